#!/usr/bin/env bash
# Version: rasterio 1.4.4 with GDAL 3.10.3; netCDF4 1.7.2 writes the files.
#
# The good guess: a raster that is opened without a geotransform has its rows in the order of the file.
#
# What happens: if GDAL finds a netCDF grid's axes too uneven for a geotransform, it gives the last row of the file
# first, whether the file begins in the north or in the south. Axes of one arc second in single precision do that for
# some sizes: 256 rows get no geotransform and are reversed, 255 and 257 rows get one, north first. The setting
# GDAL_NETCDF_BOTTOMUP=NO gives the order of the file.
#
# Why it matters: in pixel coordinates, a file that begins in the north becomes a mesh that is the mirror image of its
# terrain. One row more or less in the file turns it over.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check rasterio==1.4.4 numpy==2.2.6 netCDF4==1.7.2
cd "$work"

venv/bin/python -W ignore - <<'PYTHON'
import netCDF4
import numpy as np
import rasterio

print(f"rasterio {rasterio.__version__}, GDAL {rasterio.__gdal_version__}, netCDF4 {netCDF4.__version__}")


def first_row(n, north_first, **settings):
    """Writes an n x n CF grid whose heights are the row numbers of the file; the height of the first row read."""
    latitudes = 47.423 - np.arange(n) / 3600
    with netCDF4.Dataset("grid.nc", "w") as f:
        f.Conventions = "CF-1.8"
        axes = ("lat", latitudes if north_first else latitudes[::-1]), ("lon", -105.7 + np.arange(n) / 3600)
        for axis, values in axes:
            f.createDimension(axis, n)
            v = f.createVariable(axis, "f4", (axis,))
            v.standard_name = "latitude" if axis == "lat" else "longitude"
            v.units = "degrees_north" if axis == "lat" else "degrees_east"
            v[:] = values
        f.createVariable("z", "f4", ("lat", "lon"))[:] = np.tile(np.arange(n)[:, None], (1, n))
    with rasterio.Env(**settings), rasterio.open("grid.nc") as f:
        return "no geotransform" if f.transform.is_identity else "geotransform", int(f.read(1)[0, 0])


for n in 255, 256, 257:
    for north_first in True, False:
        kind, row = first_row(n, north_first)
        print(f"{n} rows, {'north' if north_first else 'south'} first: {kind}, row {row} of the file comes first")
        if n == 256:
            assert (kind, row) == ("no geotransform", n - 1), "the rows are no longer reversed"
        else:
            assert (kind, row) == ("geotransform", 0 if north_first else n - 1), "north is no longer first"

kind, row = first_row(256, True, GDAL_NETCDF_BOTTOMUP="NO")
print(f"256 rows, north first, GDAL_NETCDF_BOTTOMUP=NO: {kind}, row {row} of the file comes first")
assert (kind, row) == ("no geotransform", 0)
PYTHON
