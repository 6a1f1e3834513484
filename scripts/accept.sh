#!/usr/bin/env bash
# The long acceptance run: simplify, then verify, for real terrains at every tolerance, feasibility and tile size; then
# resumable runs that are killed at random moments, $KILLS (300) times. Called by `make accept`, after the build. Real
# terrains are looked for in ../shared/data, or in $TERRABITE_DATA.
set -euo pipefail
cd "$(dirname "$0")/.."

terrabite=${CARGO_TARGET_DIR:-target}/release/terrabite
cells=${CARGO_TARGET_DIR:-target}/release/examples/cells
data=${TERRABITE_DATA:-../shared/data}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
passed=0 failed=0

pass() { passed=$((passed + 1)); printf 'ok    %s\n' "$*"; }
fail() { failed=$((failed + 1)); printf 'FAIL  %s\n' "$*"; }
field() { python3 -c 'import json,sys; print(json.load(open(sys.argv[1]))[sys.argv[2]])' "$1" "$2"; }

# certify NAME RASTER TOLERANCE [OPTION...]: simplifies and verifies. Both get the options of `both`.
both=()
certify() {
    local name=$1 raster=$2 tolerance=$3
    shift 3
    local title="$name at $tolerance ${both[*]} $*"
    if ! "$terrabite" simplify "$raster" "$work/tin.ply" --max-error "$tolerance" --overwrite --json "${both[@]}" "$@" \
        >"$work/report.json"; then
        fail "$title: simplify"
    elif ! "$terrabite" verify "$raster" "$work/tin.ply" --max-error "$tolerance" "${both[@]}" \
        >"$work/verdict.txt"; then
        fail "$title: $(cat "$work/verdict.txt")"
    else
        pass "$title: $(field "$work/report.json" triangles) triangles"
    fi
}

# at_most TITLE LIMIT: the last simplification has no more triangles.
at_most() {
    local count
    count=$(field "$work/report.json" triangles)
    if [ "$count" -le "$2" ]; then pass "$1: $count of at most $2 triangles"; else fail "$1: $count, not $2"; fi
}

# everyhow NAME TOLERANCE...: weak and strong, at tile sizes 128, 512 and the default, polished and not, by both engines.
everyhow() {
    local name=$1 raster=$data/$1.tif tolerance feasibility
    shift
    for tolerance in "$@"; do
        for feasibility in weak strong; do
            certify "$name" "$raster" "$tolerance" --feasibility "$feasibility" --tile 128 --quality none --cuts plain
            certify "$name" "$raster" "$tolerance" --feasibility "$feasibility" --tile 512 --quality none --cuts improved
            certify "$name" "$raster" "$tolerance" --feasibility "$feasibility" --quality none --engine greedy-insertion
            certify "$name" "$raster" "$tolerance" --feasibility "$feasibility" --quality fast
            certify "$name" "$raster" "$tolerance" --feasibility "$feasibility" --tile 128
        done
    done
}

# by_both NAME QUALITY TOLERANCE...: polished, by both engines, at tile sizes 128, 512 and the default.
by_both() {
    local name=$1 quality=$2 tolerance engine
    shift 2
    for tolerance in "$@"; do
        for engine in greedy-insertion greedy-cuts; do
            local how=(--engine "$engine" --quality "$quality")
            certify "$name" "$data/$name.tif" "$tolerance" "${how[@]}" --tile 128
            certify "$name" "$data/$name.tif" "$tolerance" "${how[@]}" --tile 512
            certify "$name" "$data/$name.tif" "$tolerance" "${how[@]}"
        done
    done
}

if [ -d "$data" ]; then
    by_both crater_lake_garland balanced 5 20
    by_both sainte_helens balanced 5 20
    by_both srtm3_N46E008 balanced 5 20
    by_both srtm3_S33W071 balanced 10 50
    by_both srtm3_N57E011 balanced 2 10
    by_both srtm3_mosaic_n_england balanced 5 20
    by_both srtm_pearl_river_nodata balanced 5 20
    by_both pataha_10m balanced 2 10
    by_both bathymetry_30m balanced 0.2 1
    by_both ahn_dsm_050cm balanced 0.5 2
    by_both lidar_wetland_1m balanced 0.1 0.5
    by_both aster_exploradores balanced 5 20
    by_both mars_mola_4ppd balanced 50 200
    by_both moon_tycho_4096 balanced 20 100
    by_both moon_highlands_8192 fast 20 100

    # Small holes bridged, coasts trimmed, and both.
    for options in "--fill-holes 1000" "--trim 2" "--fill-holes 100 --trim 4"; do
        read -ra both <<<"$options"
        by_both sainte_helens balanced 5
        by_both srtm3_N46E008 balanced 20
        by_both srtm_pearl_river_nodata balanced 20
        by_both pataha_10m balanced 10
        by_both bathymetry_30m balanced 1
        by_both ahn_dsm_050cm balanced 2
        by_both aster_exploradores balanced 20
        both=(--nodata 0 "${both[@]}")
        by_both srtm3_N57E011 balanced 10
    done
    both=()

    everyhow crater_lake_garland 1 5 20
    everyhow srtm3_S33W071 10
    everyhow srtm3_mosaic_n_england 5
    everyhow moon_tycho_4096 20 200
    everyhow lidar_wetland_1m 0.1
    everyhow mars_mola_4ppd 50

    crater=$data/crater_lake_garland.tif
    certify crater_lake_garland "$crater" 5 --tile 512 --quality none --cuts plain
    at_most "plain weak cuts of Crater Lake at 5" 26500
    certify crater_lake_garland "$crater" 20 --tile 512 --quality none --cuts plain
    at_most "plain weak cuts of Crater Lake at 20" 5000

    # The counts of Garland's own program, and 1 %.
    insertion=(--tile 0 --quality none --engine greedy-insertion)
    while read -r tolerance limit; do
        certify crater_lake_garland "$crater" "$tolerance" "${insertion[@]}"
        at_most "insertion on Crater Lake at $tolerance" "$limit"
    done <<<"1 83656
5 19641
10 9275
20 4018"
    # Those of pydelatin: 1 % more untiled, 3 % at the default tile.
    certify moon_tycho_4096 "$data/moon_tycho_4096.tif" 20 "${insertion[@]}" --memory 12GiB
    at_most "insertion on Tycho at 20, one tile" 424406
    certify moon_tycho_4096 "$data/moon_tycho_4096.tif" 20 --quality none --engine greedy-insertion
    at_most "insertion on Tycho at 20" 432810
    for swap in data-dependent delaunay; do
        for selection in sequential fractional constant; do
            certify crater_lake_garland "$crater" 5 --quality none --swap "$swap" --selection "$selection"
        done
    done
    for measure in local-error curvature global-error product; do
        certify crater_lake_garland "$crater" 10 --quality none --measure "$measure"
    done

    # The densest mesh of a raster with gaps passes without any tolerance, and misses each of some faces.
    for name in pataha_10m srtm_pearl_river_nodata srtm3_N46E008 ahn_dsm_050cm bathymetry_30m aster_exploradores; do
        "$cells" "$data/$name.tif" "$work/cells.ply"
        if "$terrabite" verify "$data/$name.tif" "$work/cells.ply" --max-error 0 >"$work/verdict.txt"; then
            pass "cells of $name: $(sed -n 2p "$work/verdict.txt")"
        else
            fail "cells of $name: $(cat "$work/verdict.txt")"
        fi
        for face in 0 1000 123456; do
            "$cells" "$data/$name.tif" "$work/cells.ply" "$face"
            if "$terrabite" verify -q "$data/$name.tif" "$work/cells.ply" --max-error 0; then
                fail "cells of $name but face $face: passed"
            else
                pass "cells of $name but face $face: refused"
            fi
        done
    done

    if command -v gdal_translate >/dev/null; then
        copy() { gdal_translate -q "$@"; }
        copy -ot Float64 "$crater" "$work/float64.tif"
        copy -co ENDIANNESS=BIG "$crater" "$work/big-endian.tif"
        copy -co BLOCKYSIZE=7 "$crater" "$work/stripped.tif"
        copy -co TILED=YES -co BLOCKXSIZE=64 -co BLOCKYSIZE=64 "$crater" "$work/tiled.tif"
        for name in float64 big-endian stripped tiled; do
            for feasibility in weak strong; do
                certify "$name" "$work/$name.tif" 5 --feasibility "$feasibility"
                certify "$name" "$work/$name.tif" 5 --feasibility "$feasibility" --tile 128
            done
            how=$(python3 -c 'import json,sys; print(json.load(open(sys.argv[1]))["access"]["how"])' "$work/report.json")
            case $name:$how in
                stripped:in_place | tiled:in_place | float64:in_place | big-endian:windows | big-endian:decoded) pass "$name is $how" ;;
                *) fail "$name is $how" ;;
            esac
        done
    else
        echo "skipped: other types and layouts, there is no gdal_translate (apt-get install gdal-bin)"
    fi
else
    echo "skipped: the real terrains, there is no folder $data (set TERRABITE_DATA)"
fi

# Made by ourselves, so it runs everywhere.
"$terrabite" synth "$work/synth.tif" --size 3000x2000 --seed 7 --quiet
for feasibility in weak strong; do
    certify synth "$work/synth.tif" 1 --feasibility "$feasibility"
    certify synth "$work/synth.tif" 20 --feasibility "$feasibility" --tile 128
    certify synth "$work/synth.tif" 0 --feasibility "$feasibility" --tile 256
done

killed=$data/srtm3_S33W071.tif tolerance=60
[ -f "$killed" ] || killed=$work/synth.tif tolerance=20
if scripts/kills.py "$killed" --kills "${KILLS:-300}" -- --max-error "$tolerance" --tile 128; then
    passed=$((passed + 1))
else
    failed=$((failed + 1))
fi

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
