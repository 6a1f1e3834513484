#!/usr/bin/env bash
# Version: pyproj 3.7.2 (PROJ 9.5.1).
#
# The good guess: Transformer.from_crs(…, only_best=True) raises an error where the grid that the best transformation needs is not there:
# the documentation names it as the way to refuse anything less.
#
# What happens: where the grid of a geoid is missing, as it is in every wheel, heights above EGM96, EGM2008, NAVD 88 and NAP come out as
# they went in, with only_best=True as well, and with errcheck=True, too. PROJ falls back on a transformation that takes the geoid for
# the ellipsoid ("ballpark"), and only_best does not count it as worse than the best. allow_ballpark=False raises.
#
# Why it matters: who brings a DEM to ellipsoidal heights and has thought of missing grids is about 50 m wrong in the Alps, without a word.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check pyproj==3.7.2
cd "$work"

PROJ_NETWORK=OFF venv/bin/python -W ignore - <<'PYTHON'
import pyproj
from pyproj.exceptions import ProjError

print(f"pyproj {pyproj.__version__} (PROJ {pyproj.proj_version_str})")
for crs, place in [("EPSG:4326+5773", (8, 46)), ("EPSG:9518", (8, 46)), ("EPSG:4269+5703", (-100, 40)), ("EPSG:7415", (155_000, 463_000))]:
    best = pyproj.Transformer.from_crs(crs, "EPSG:4979", always_xy=True, only_best=True)
    height = best.transform(*place, 500, errcheck=True)[2]
    print(f"{crs}, only_best: 500 becomes {height}")
    assert height == 500, "the missing grid is told now"
    try:
        pyproj.Transformer.from_crs(crs, "EPSG:4979", always_xy=True, allow_ballpark=False)
        raise SystemExit("allow_ballpark=False does not raise any more")
    except ProjError as error:
        print(f"{crs}, allow_ballpark=False: {str(error)[:70]}")
PYTHON
