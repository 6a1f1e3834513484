#!/usr/bin/env bash
# Version: rasterio 1.4.4 with GDAL 3.10.3.
#
# The good guess: a GeoTIFF with COMPRESS=LERC and MAX_Z_ERROR=0.1 has heights that are off by 0.1 at the most, and the same missing samples
# as before: GDAL knows the nodata tag, and LERC has a mask for what is missing.
#
# What happens: to the encoder a missing sample is a height like others, and may be off by 0.1 as well. It stays exact where it is the least
# value of its block, as -9999 is on land, and in blocks that are missing as a whole. Where the tag is above the heights, as 9999, 32767 and,
# over the sea floor, 0 are, some missing samples no longer equal it: they are valid. LERC's mask is used for NaN alone. There is no warning,
# and the documentation of MAX_Z_ERROR does not speak of missing samples. The driver COG does the same.
#
# Why it matters: along the rim of each void stand spikes of 9998.9 m; around islands that are 0 in a model of the sea floor lies a dotted
# shelf of valid depths of some centimetres. Naming the tag again does not make such samples missing.
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
row, column = np.mgrid[:256, :256]
LAND = 100 + 20 * np.sin(column / 15) + 15 * np.cos(row / 11)
VOID = np.hypot(column - 128, row - 128) < 50


def false_heights(heights, dtype, nodata, error, driver="GTiff"):
    """What is valid, although it was missing when it was written."""
    written = np.where(VOID, nodata, heights).astype(dtype)
    with rasterio.open("dem.tif", "w", driver=driver, width=256, height=256, count=1, dtype=dtype, nodata=nodata, crs="EPSG:32633",
                       transform=from_origin(500000, 5000000, 10, 10), compress="LERC", max_z_error=error) as f:
        f.write(written, 1)
    with rasterio.open("dem.tif") as f:
        assert f.compression.value.startswith("LERC") and (f.nodata == nodata or np.isnan(nodata))
        read, valid = f.read(1), f.read_masks(1) != 0
    assert np.all(valid[~VOID]) and np.abs(read - written.astype(float))[~VOID].max() <= error * 1.001
    return read[VOID & valid]


cases = [
    (LAND, "float32", -9999, 0.1, "GTiff", False),
    (LAND, "float32", float("nan"), 0.1, "GTiff", False),
    (LAND, "float32", 9999, 0.0, "GTiff", False),
    (LAND, "float32", 9999, 0.1, "GTiff", True),
    (LAND, "float32", 9999, 0.1, "COG", True),
    (LAND, "float32", 32767, 0.1, "GTiff", True),
    (LAND, "int16", 32767, 2, "GTiff", True),
    (-LAND, "float32", 0, 0.1, "GTiff", True),
]
for heights, dtype, nodata, error, driver, moved in cases:
    false = false_heights(heights, dtype, nodata, error, driver)
    extent = f", at {false.min():.3f} to {false.max():.3f}" if false.size else ""
    print(f"{driver}, {dtype}, heights {heights.min():.0f} to {heights.max():.0f}, nodata {nodata}, error {error}: "
          f"{false.size} of {VOID.sum()} missing samples are valid{extent}")
    assert (false.size > 100) == moved and (moved or false.size == 0), "another number of samples is valid"
PYTHON
