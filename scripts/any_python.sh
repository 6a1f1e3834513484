#!/usr/bin/env bash
# Prints the first Python 3.11 or newer that makes environments: that of the path may be pyenv's or too old, and packages of
# the system help only the system's.
set -euo pipefail
for python in python3 /usr/bin/python3; do
    if "$python" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
        echo "$python"
        exit 0
    fi
done
echo "neither python3 nor /usr/bin/python3 is a Python 3.11 or newer with venv" >&2
exit 1
