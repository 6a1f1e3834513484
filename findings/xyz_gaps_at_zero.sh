#!/usr/bin/env bash
# Version: rasterio 1.4.4 with GDAL 3.10.3.
#
# The good guess: a place that an XYZ table has no line for is missing in the raster, whatever heights the table has.
#
# What happens: GDAL chooses the type and the nodata value of an XYZ table from its heights. Whole numbers from 0 to
# 255 make a Byte raster, and its nodata value is 0 if no height is 0. If one is, there is no nodata value, and each
# gap is a valid height of 0. With one more height of 256, -1 or 0.5, the gaps are missing again.
#
# Why it matters: a table of a flat coast in whole metres is just that. Its gaps (other tiles, water, cut borders)
# become pits at sea level with walls around them, and a single sample decides between pits and holes.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check rasterio==1.4.4 numpy==2.2.6
cd "$work"

venv/bin/python -W ignore - <<'PYTHON'
import rasterio

print(f"rasterio {rasterio.__version__}, GDAL {rasterio.__gdal_version__}")


def gap(corner, opposite):
    """Writes a table of 4 x 3 heights of 7, but for two corners, without a line for (1, 1); what (1, 1) is read as."""
    heights = {(0, 0): corner, (3, 2): opposite}
    with open(f"{corner}_{opposite}.xyz", "w") as f:
        for y in 2, 1, 0:
            for x in 0, 1, 2, 3:
                if (x, y) != (1, 1):
                    f.write(f"{x} {y} {heights.get((x, y), 7)}\n")
    with rasterio.open(f"{corner}_{opposite}.xyz") as f:
        assert f.shape == (3, 4)
        return f.dtypes[0], f.nodata, f.read(1)[1, 1].item(), f.read_masks(1)[1, 1] != 0


pits, holes = [(0, 200), (0, 255)], [(1, 255), (0, 256), (0, -1), (0, 0.5)]
for corner, opposite in pits + holes:
    valid = (corner, opposite) in pits
    dtype, nodata, value, is_valid = gap(corner, opposite)
    says = "valid" if is_valid else "missing"
    print(f"heights 7, {corner} and {opposite}: {dtype}, nodata {nodata}; the gap is {value}, {says}")
    assert is_valid == valid, "the gap is read otherwise"
    assert not valid or (dtype, nodata, value) == ("uint8", None, 0)
PYTHON
