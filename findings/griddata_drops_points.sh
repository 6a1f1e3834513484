#!/usr/bin/env bash
# Version: scipy 1.17.1.
#
# The good guess: griddata(points, heights, places), "linear" or "cubic", leads its surface through all of the points. UTM coordinates are no
# strain on doubles: at a northing of 5.2 million these tell a nanometre apart.
#
# What happens: points that are close together for their distance from the origin are left out, without a word. Qhull finds the Delaunay
# triangles on the paraboloid x² + y², whose values are 2.7e13 there, so rounding hides what rises above it by little. In UTM, of
# ground points half a metre apart half is left out, and six of seven of those a quarter of a metre apart. With an offset subtracted, or with
# rescale=True, each point counts. scipy.spatial.Delaunay documents that Qhull may omit points, and lists them as `coplanar`; griddata,
# LinearNDInterpolator and CloughTocher2DInterpolator pass over that list and do not speak of it. rescale is said to be for axes of different
# units.
#
# Why it matters: it is the usual way from lidar or drone points to a DEM in Python. Walls, kerbs and ditches, which are what such points are
# for, become lower or go, the result has no gaps, and a test with small coordinates passes. (gdal_grid -a linear of GDAL 3.6.2 does the
# same.)
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check scipy==1.17.1 numpy==2.2.6
cd "$work"

venv/bin/python -W error - <<'PYTHON'
import numpy as np
import scipy
from scipy.interpolate import griddata
from scipy.spatial import Delaunay

print(f"scipy {scipy.__version__}, numpy {np.__version__}")
SIDE = 100


def ground(spacing):
    """Points near the nodes of a square grid; a slope, and a wall that is 2 m high and as wide as two rows."""
    column, row = np.meshgrid(np.arange(SIDE), np.arange(SIDE))
    shaken = np.random.default_rng(1).uniform(-0.45, 0.45, (SIDE * SIDE, 2))
    x, y = ((np.column_stack([column.ravel(), row.ravel()]) + shaken) * spacing).T
    return np.column_stack([x, y]), 100 + 0.05 * x + 2 * (np.abs(y - SIDE * spacing / 2) < spacing)


def error(points, heights, **options):
    """How far the surface is from the points that it is made of."""
    return np.abs(griddata(points, heights, points, **options) - heights).max()


for spacing, at_most in (0.5, 0.6), (0.25, 0.2):
    local, heights = ground(spacing)
    utm = local + [500000, 5200000]
    used = [len(np.unique(Delaunay(points).simplices)) for points in (local, utm)]
    errors = {
        "small coordinates": error(local, heights),
        "UTM": error(utm, heights),
        "UTM, cubic": error(utm, heights, method="cubic"),
        "UTM, rescale=True": error(utm, heights, rescale=True),
    }
    print(f"{SIDE * SIDE} points, {spacing} m apart: {used[0]} used with small coordinates, {used[1]} in UTM")
    for name, value in errors.items():
        print(f"    {name}: up to {value:.3f} m off at the points")
    assert used[0] == SIDE * SIDE and used[1] < at_most * SIDE * SIDE, "another number of points is used"
    assert errors["UTM"] > 1.5 and errors["UTM, cubic"] > 1.5, "the wall stands"
    assert errors["small coordinates"] < 1e-6 and errors["UTM, rescale=True"] < 1e-6
PYTHON
