#!/usr/bin/env bash
# Installs what `make test-readers` needs and Debian lacks by default: QGIS, and libraries that Open3D loads. Where there
# is no apt-get, it says what is missing.
set -euo pipefail

missing=()
/usr/bin/python3 -c 'import qgis.core' >/dev/null 2>&1 || missing+=(python3-qgis qgis-providers)
library() { # PACKAGE LIBRARY: the package is missing if the library cannot be loaded
    /usr/bin/python3 -c "import ctypes; ctypes.CDLL('$2')" >/dev/null 2>&1 || missing+=("$1")
}
library libusb-1.0-0 libusb-1.0.so.0
library libgl1 libGL.so.1
library libgomp1 libgomp.so.1

if [ ${#missing[@]} -eq 0 ]; then exit 0; fi
if ! command -v apt-get >/dev/null; then
    echo "setup: no apt-get here; without these (as Debian calls them) readers are skipped or fail: ${missing[*]}" >&2
    exit 0
fi
as_root=()
if [ "$(id -u)" -ne 0 ]; then as_root=(sudo); fi
echo "setup: installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
