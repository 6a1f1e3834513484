#!/usr/bin/env bash
# Versions: rasterio 1.3.9 with GDAL 3.6.4 (both parts below); rasterio 1.4.4 with GDAL 3.10.3 (the second part only).
#
# The good guess: the type of the buffer only says how values are handed over. Reading a raster as double gives what
# reading it in its own type and then widening gives.
#
# What happens, with a VRT:
# 1. An Int16 band that scales feet to metres gives whole metres when it is read as int16, and fractions when it is
#    read as float64. GDAL 3.9.2 and newer round in both cases.
# 2. The holes of a Float32 mosaic with the nodata tag -9999.9 equal the tag when they are read as float64, but not
#    when they are read as float32 and widened. GDAL 3.10.3 still does so.
#
# Why it matters: two tools that build a mesh from one VRT get heights that differ by half a metre, and a tool that
# checks a mesh against doubles blames the mesh. A comparison with the nodata tag misses the holes in one of both
# ways.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

cat > compare.py <<'PYTHON'
import numpy as np
import rasterio
from rasterio.transform import from_origin

print(f"rasterio {rasterio.__version__}, GDAL {rasterio.__gdal_version__}")
rounds_both = tuple(map(int, rasterio.__gdal_version__.split(".")[:2])) >= (3, 9)
with rasterio.open("feet.tif", "w", driver="GTiff", width=4, height=1, count=1, dtype="int16", crs="EPSG:32633",
                   transform=from_origin(500000, 5000000, 30, 30)) as f:
    f.write(np.array([[100, 101, 102, 103]], "int16"), 1)


def read(dtype, width, band):
    """Band 1 of a VRT, read in its own type and then widened, and read as float64; its nodata tag."""
    with open("a.vrt", "w") as f:
        f.write(f'<VRTDataset rasterXSize="{width}" rasterYSize="1"><VRTRasterBand dataType="{dtype}" band="1">{band}'
                "</VRTRasterBand></VRTDataset>")
    with rasterio.open("a.vrt") as f:
        return f.read(1)[0].astype("float64"), f.read(1, out_dtype="float64")[0], f.nodata


source = '<SourceFilename relativeToVRT="1">feet.tif</SourceFilename><SourceBand>1</SourceBand>'
own, double, _ = read("Int16", 4, f"<ComplexSource>{source}<ScaleRatio>0.3048</ScaleRatio></ComplexSource>")
print(f"scaled Int16:  as int16 {own.tolist()}, as float64 {double.tolist()}")
assert own.tolist() == [30, 31, 31, 31]
assert np.array_equal(double, own) if rounds_both else np.allclose(double, [30.48, 30.7848, 31.0896, 31.3944])

place = '<SrcRect xOff="0" yOff="0" xSize="4" ySize="1"/><DstRect xOff="2" yOff="0" xSize="4" ySize="1"/>'
own, double, tag = read("Float32", 6, f"<NoDataValue>-9999.9</NoDataValue><SimpleSource>{source}{place}</SimpleSource>")
print(f"nodata {tag}: as float32 {own[0]!r}, as float64 {double[0]!r}; holes equal to the tag: "
      f"{np.count_nonzero(own == tag)} and {np.count_nonzero(double == tag)} of 2")
assert np.count_nonzero(own == tag) == 0 and np.count_nonzero(double == tag) == 2
PYTHON

for version in 1.3.9 1.4.4; do
    python3 -m venv "venv-$version"
    "venv-$version/bin/pip" install --quiet --disable-pip-version-check "rasterio==$version" numpy==1.26.4
    # VRT and GeoTIFF without a geotransform are valid; Python's warning of that is not the point here.
    "venv-$version/bin/python" -W ignore compare.py
done
