#!/usr/bin/env bash
# Makes a terrain, bites it into triangles, checks the file and draws it. Called by `make demo`, after the build.
set -euo pipefail
cd "$(dirname "$0")/.."

target=${CARGO_TARGET_DIR:-target}
terrabite=$target/release/terrabite
demo=$target/demo
mkdir -p "$demo"
run() {
    echo
    echo "> terrabite $*"
    "$terrabite" "$@"
}

run synth "$demo/dem.tif" --size 2048x2048 --seed 7 --overwrite
run simplify "$demo/dem.tif" "$demo/tin.ply" --max-error 5 --overwrite
run verify "$demo/dem.tif" "$demo/tin.ply" --max-error 5
run preview "$demo/dem.tif" "$demo/tin.ply" "$demo/tin.png" --overwrite
echo
echo "The picture is $demo/tin.png"
