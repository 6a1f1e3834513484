#!/usr/bin/env bash
# Installs what the build and the tests need and Debian lacks by default. Does nothing where all of it is there.
set -euo pipefail

missing=()
need() { # PACKAGE COMMAND...: the package is missing if the command fails
    local package=$1
    shift
    "$@" >/dev/null 2>&1 || missing+=("$package")
}

need gcc cc --version
need libc6-dev test -e /usr/include/stdlib.h
need pkg-config pkg-config --version
need libgdal-dev pkg-config --exists gdal
# One test opens meshes with readers from PyPI.
need python3 python3 --version
need python3-venv python3 -c 'import ensurepip, venv'

if ! command -v cargo >/dev/null; then
    echo "setup: Rust is missing; https://rustup.rs installs it" >&2
    exit 1
fi
if [ ${#missing[@]} -eq 0 ]; then
    echo "setup: everything is there (GDAL $(pkg-config --modversion gdal))"
    exit 0
fi
if ! command -v apt-get >/dev/null; then
    echo "setup: no apt-get here; install these, or what they are called here: ${missing[*]}" >&2
    exit 1
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
        echo "setup: neither root nor sudo; as root: apt-get install ${missing[*]}" >&2
        exit 1
    fi
    as_root=(sudo)
fi
echo "setup: installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
version=$(pkg-config --modversion gdal)
echo "setup: done (GDAL $version)"
