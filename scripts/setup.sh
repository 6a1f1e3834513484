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
# meshoptimizer is C++.
need g++ c++ --version
need libc6-dev test -e /usr/include/stdlib.h
need pkg-config pkg-config --version
need libgdal-dev pkg-config --exists gdal
# Tests open meshes with readers from PyPI, and call the package of python/, in environments of their own.
any_python=$(dirname "$0")/any_python.sh
need python3 "$any_python"
need python3-venv "$any_python"
# Tests open meshes of every format with programs that others wrote: these, and one from npm.
need nodejs node --version
need npm npm --version
need admesh admesh --version
need libxml2-utils xmllint --version
need netcdf-bin command -v ncdump
need gdal-bin ogrinfo --version

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
if ! "$any_python" >/dev/null; then
    echo "setup: the tests of tests/it/readers.rs and python/ need one, or TERRABITE_SKIP_READERS=1" >&2
fi
version=$(pkg-config --modversion gdal)
echo "setup: done (GDAL $version)"
