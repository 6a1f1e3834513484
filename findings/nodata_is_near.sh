#!/usr/bin/env bash
# Version: rasterio 1.4.4 with GDAL 3.10.3.
#
# The good guess: a sample is missing if it equals the nodata tag.
#
# What happens: GDAL's mask compares floating-point samples with the tag by nearness, relative to their size. About
# 0.0048 to either side of -9999, and 0.0156 to either side of -32768, is masked. The range of a Float64 raster is as
# wide as that of a Float32 raster, although its numbers are far finer.
#
# Why it matters: trenches are that deep, and single valid samples of their floor turn into holes of the mesh. Two
# readers of one file, one by equality and one by GDAL's mask, disagree on where the terrain ends.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check rasterio==1.4.4 numpy==2.2.6
cd "$work"

venv/bin/python - <<'PYTHON'
import numpy as np
import rasterio
from rasterio.transform import from_origin

print(f"rasterio {rasterio.__version__}, GDAL {rasterio.__gdal_version__}")


def masked(dtype, nodata, heights):
    """Which of these heights GDAL masks, and which of them equal the tag, after a round trip through a GeoTIFF."""
    name = f"{dtype}{nodata}.tif"
    with rasterio.open(name, "w", driver="GTiff", width=len(heights), height=1, count=1, dtype=dtype, nodata=nodata,
                       crs="EPSG:32633", transform=from_origin(500000, 5000000, 30, 30)) as f:
        f.write(np.array([heights], dtype), 1)
    with rasterio.open(name) as f:
        assert f.dtypes[0] == dtype and f.nodata == nodata
        return (f.read_masks(1)[0] == 0).tolist(), (f.read(1)[0] == f.nodata).tolist()


cases = [
    (-9999, [-9999.0, -9999.002, -9998.998, -9999.004, -9999.006, -9998.99], [1, 1, 1, 1, 0, 0]),
    (-32768, [-32768.0, -32767.99, -32767.986, -32767.98], [1, 1, 1, 0]),
]
for dtype in "float32", "float64":
    for nodata, heights, expected in cases:
        near, equal = masked(dtype, nodata, heights)
        seen = ", ".join(f"{height} {'masked' if m else 'valid'}" for height, m in zip(heights, near))
        print(f"{dtype}, nodata {nodata}: {seen}")
        assert near == [bool(m) for m in expected], "the mask is another one"
        assert equal == [True] + [False] * (len(heights) - 1), "only the first height equals the tag"
PYTHON
