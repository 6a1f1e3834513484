#!/usr/bin/env bash
# Version: rasterio 1.4.3 (its wheel has GDAL 3.9.3), pyproj 3.7.2 (PROJ 9.5.1).
#
# The good guess: rasterio.warp.reproject and rasterio.vrt.WarpedVRT are gdalwarp for Python. gdalwarp moves the heights of a DEM when the
# two CRSs have different vertical datums, so they do, too.
#
# What happens: they move samples sideways only. With a geoid of 50 m at hand, which pyproj uses, heights above the geoid come out as they
# went in. The result says that it is in EPSG:4979, so ellipsoidal, and is 50 m too low. There is no error and no warning. (gdalwarp of
# GDAL 3.6.2 gives 550 for the same file.)
#
# Why it matters: terrain tiles, and whatever else is drawn on a globe, want ellipsoidal heights. A DEM that was prepared like this is
# off by the height of the geoid, up to 107 m, and looks right.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check rasterio==1.4.3 pyproj==3.7.2 numpy==2.2.6
cd "$work"

venv/bin/python - <<'PYTHON'
import os
import struct

import numpy as np
import pyproj
import rasterio
from rasterio.transform import from_origin
from rasterio.vrt import WarpedVRT
from rasterio.warp import Resampling, reproject

print(f"rasterio {rasterio.__version__} (GDAL {rasterio.__gdal_version__}), pyproj {pyproj.__version__} (PROJ {pyproj.proj_version_str})")
# A geoid that is 50 m above the ellipsoid everywhere: 3 × 3 values from 0° N 0° E on, 10° apart.
with open("geoid.gtx", "wb") as file:
    file.write(struct.pack(">ddddii", 40.0, 0.0, 10.0, 10.0, 3, 3) + struct.pack(">9f", *[50.0] * 9))
above_the_geoid = f"+proj=longlat +datum=WGS84 +geoidgrids={os.path.abspath('geoid.gtx')} +vunits=m +no_defs"
ellipsoidal = "EPSG:4979"

expected = pyproj.Transformer.from_crs(above_the_geoid, ellipsoidal, always_xy=True).transform(8, 46, 500)[2]
print(f"pyproj: 500 m above the geoid are {expected} m above the ellipsoid")

heights, place = np.full((20, 20), 500, "float32"), from_origin(7, 47, 0.1, 0.1)
warped = np.zeros_like(heights)
reproject(
    heights, warped, src_transform=place, src_crs=above_the_geoid, dst_transform=place, dst_crs=ellipsoidal,
    resampling=Resampling.nearest,
)
print(f"rasterio.warp.reproject: {warped[10, 10]}")
with rasterio.open("dem.tif", "w", driver="GTiff", width=20, height=20, count=1, dtype="float32", crs=above_the_geoid, transform=place) as dem:
    dem.write(heights, 1)
with rasterio.open("dem.tif") as dem, WarpedVRT(dem, crs=ellipsoidal) as vrt:
    seen = vrt.read(1)[10, 10]
    print(f"WarpedVRT: {seen} in {vrt.crs}")
assert expected == 550
assert warped[10, 10] == 500 and seen == 500, "heights are moved now"
PYTHON
