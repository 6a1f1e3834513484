#!/usr/bin/env bash
# Version: zarr 2.18.7 writes the array; rasterio 1.4.4 with GDAL 3.10.3 reads it.
#
# The good guess: the fill value of a Zarr array says what a chunk holds that was never written. An array whose chunks
# are all written, and that says nothing about missing heights, has none.
#
# What happens: zarr-python gives each new array the fill value 0, unless told otherwise, and GDAL takes the fill
# value of an array (format version 2) for its nodata value. Each sample of exactly 0 is masked. With fill_value=None,
# none is.
#
# Why it matters: 0 is sea level. The sea of a land DEM and each sample of the coast at 0 become holes of the mesh.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check rasterio==1.4.4 numpy==2.2.6 zarr==2.18.7
cd "$work"

venv/bin/python -W ignore - <<'PYTHON'
import json

import numpy as np
import rasterio
import zarr

print(f"zarr {zarr.__version__}, rasterio {rasterio.__version__}, GDAL {rasterio.__gdal_version__}")
heights = np.tile(np.array([-2, -1, 0, 0, 1, 2]), (4, 1))


def read(name, dtype, **options):
    """Writes all chunks of an array; its fill value in the file, and GDAL's nodata value and count of valid samples."""
    array = zarr.open(name, mode="w", shape=heights.shape, chunks=(2, 3), dtype=dtype, **options)
    array[:] = heights
    assert array.nchunks_initialized == array.nchunks
    with open(f"{name}/.zarray") as f:
        fill = json.load(f)["fill_value"]
    with rasterio.open(f"ZARR:{name}") as f:
        assert np.array_equal(f.read(1), heights)
        return fill, f.nodata, f.read(1, masked=True).count()


for dtype in "float32", "int16":
    fill, nodata, valid = read(f"{dtype}.zarr", dtype)
    print(f"{dtype}, defaults: fill value {fill}, GDAL's nodata {nodata}, {valid} of {heights.size} samples valid")
    assert fill == 0 and nodata == 0 and valid == np.count_nonzero(heights)
    fill, nodata, valid = read(f"{dtype}-none.zarr", dtype, fill_value=None)
    print(f"{dtype}, fill_value=None: {fill}, GDAL's nodata {nodata}, {valid} of {heights.size} samples valid")
    assert fill is None and nodata is None and valid == heights.size
PYTHON
