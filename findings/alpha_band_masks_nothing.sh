#!/usr/bin/env bash
# Version: rasterio 1.4.4 with GDAL 3.10.3.
#
# The good guess: a band whose colour interpretation is alpha masks the other bands, so a masked read of band 1 hides
# every sample whose alpha is 0.
#
# What happens: the mask of band 1 heeds an alpha band only if it is the last of exactly 2 or 4 bands of 8 or 16 bits
# without a sign, and no nodata tag stands next to it. Otherwise the alpha band is ignored, and no warning is given. A
# float DEM with an alpha band is "all valid".
#
# Why it matters: an alpha band is what a warp adds to say where there is no ground, and DEMs are mostly Int16 or
# Float32. The corners that the warp could not fill are heights of 0: they become cliffs around the terrain.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check rasterio==1.4.4 numpy==2.2.6
cd "$work"

venv/bin/python - <<'PYTHON'
import numpy as np
import rasterio
from rasterio.enums import ColorInterp
from rasterio.shutil import copy
from rasterio.transform import from_origin
from rasterio.vrt import WarpedVRT

print(f"rasterio {rasterio.__version__}, GDAL {rasterio.__gdal_version__}")
GRID = dict(driver="GTiff", crs="EPSG:32633", transform=from_origin(700000, 5000000, 1000, 1000))


def valid(dtype, bands, nodata=None):
    """Valid samples of band 1, of 12; alpha (the last band) is 0 for 3 of them."""
    with rasterio.open("a.tif", "w", width=4, height=3, count=bands, dtype=dtype, nodata=nodata, **GRID) as f:
        f.colorinterp = [ColorInterp.gray] + [ColorInterp.undefined] * (bands - 2) + [ColorInterp.alpha]
        for band in range(1, bands + 1):
            f.write(np.full((3, 4), 100, dtype), band)
        alpha = np.full((3, 4), 255, dtype)
        alpha[:, 0] = 0
        f.write(alpha, bands)
    with rasterio.open("a.tif") as f:
        assert f.colorinterp[-1] == ColorInterp.alpha
        return f.read(1, masked=True).count(), "+".join(flag.name for flag in f.mask_flag_enums[0])


heeded = [("uint8", 2), ("uint16", 2), ("uint16", 4)]
ignored = [("int16", 2), ("int32", 2), ("float32", 2), ("float32", 4), ("uint16", 3), ("uint16", 5), ("uint16", 2, 7)]
for cases, expected in (heeded, 9), (ignored, 12):
    for case in cases:
        count, flags = valid(*case)
        tag = f", nodata {case[2]}" if case[2:] else ""
        print(f"{case[0]}, {case[1]} bands{tag}: {count} of 12 samples valid, mask flags {flags}")
        assert count == expected, f"{case}: expected {expected} valid samples"

with rasterio.open("dem.tif", "w", width=100, height=100, count=1, dtype="float32", **GRID) as f:
    f.write(np.full((100, 100), 1000, "float32"), 1)
with rasterio.open("dem.tif") as f, WarpedVRT(f, crs="EPSG:4326", add_alpha=True) as warped:
    copy(warped, "warped.tif", driver="GTiff")
with rasterio.open("warped.tif") as f:
    heights, alpha = f.read(1, masked=True), f.read(2)
outside, zeros = np.count_nonzero(alpha == 0), np.count_nonzero(heights.compressed() == 0)
print(f"warped float DEM: {outside} samples have alpha 0; {zeros} valid heights are 0")
assert zeros == outside > 0
PYTHON
