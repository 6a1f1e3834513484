#!/usr/bin/env bash
# Version: rasterio 1.4.4 with GDAL 3.10.3.
#
# The good guess: a terrain format that stores signed heights gives them back, below sea level too.
#
# What happens: GDAL writes heights below 0 into an HF2 file correctly, but reads each height at or below 0 as
# 1.1754944e-38, the smallest normal single-precision number. There is no nodata value, no mask and no warning.
#
# Why it matters: polders, the Dead Sea and all of the sea floor become a plain at 0, and a comparison with 0 (to cut
# at the coast, say) finds no sample at sea level.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check rasterio==1.4.4 numpy==2.2.6
cd "$work"

venv/bin/python - <<'PYTHON'
import struct

import numpy as np
import rasterio
from rasterio.shutil import copy
from rasterio.transform import from_origin

print(f"rasterio {rasterio.__version__}, GDAL {rasterio.__gdal_version__}")
heights = np.array([[-5, 0, 0.5, 10], [-100, 20, -0.25, 30]], "float32")
with rasterio.open("dem.tif", "w", driver="GTiff", width=4, height=2, count=1, dtype="float32", crs="EPSG:32633",
                   transform=from_origin(500000, 5000000, 30, 30)) as f:
    f.write(heights, 1)
copy("dem.tif", "dem.hf2", driver="HF2")

# What the file stores, decoded without GDAL. A header of 28 bytes ends with the length of the extended header. Then
# comes the only tile: scale, offset, and for each row from the south a size in bytes, the first value and steps.
data = open("dem.hf2", "rb").read()
at = 28 + struct.unpack_from("<I", data, 24)[0]
scale, offset = struct.unpack_from("<ff", data, at)
at, rows = at + 8, []
for _ in range(2):
    size, value = struct.unpack_from("<Bi", data, at)
    steps = struct.unpack_from("<3" + {1: "b", 2: "h", 4: "i"}[size], data, at + 5)
    at += 5 + 3 * size
    rows.append(np.cumsum([value, *steps]) * scale + offset)
stored = np.array(rows[::-1])

with rasterio.open("dem.hf2") as f:
    read, nodata, flags = f.read(1), f.nodata, [flag.name for flag in f.mask_flag_enums[0]]
print(f"written: {heights.tolist()}")
print(f"stored:  {stored.round(2).tolist()}")
print(f"read:    {read.tolist()}; nodata {nodata}, mask {flags}")
below = heights <= 0
assert np.abs(stored - heights).max() < 0.01, "the file does not store the heights"
assert np.all(read[below] == np.finfo("float32").tiny), "heights at or below 0 are read otherwise"
assert np.abs(read - heights)[~below].max() < 0.01 and nodata is None and flags == ["all_valid"]
PYTHON
