#!/usr/bin/env bash
# Installs QGIS for `make test-readers`, where it is missing and there is apt-get.
set -euo pipefail
if /usr/bin/python3 -c 'import qgis.core' >/dev/null 2>&1; then exit 0; fi
if ! command -v apt-get >/dev/null; then
    echo "setup: QGIS is missing (python3-qgis and qgis-providers on Debian); its part is skipped" >&2
    exit 0
fi
as_root=()
if [ "$(id -u)" -ne 0 ]; then as_root=(sudo); fi
echo "setup: installing QGIS"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends python3-qgis qgis-providers
