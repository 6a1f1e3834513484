#!/usr/bin/env bash
# Version: rasterio 1.4.4 with GDAL 3.10.3; netCDF4 1.7.2 writes the files.
#
# The good guess: a grid whose dimensions are y and x, and whose `coordinates` attribute names 1-D latitudes and
# longitudes, is warped onto the same map as a grid that stores the same coordinates in two dimensions.
#
# What happens: GDAL makes geolocation arrays of both. It reverses the rows of the heights and of 2-D latitudes
# together, but leaves 1-D latitudes in the order of the file. The warp of the latter is upside down, with a
# geotransform, a CRS and no warning.
#
# Why it matters: a warp is the usual first step before such a grid becomes a mesh. North and south of the terrain
# change places, and nothing in the output tells.
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
from rasterio.vrt import WarpedVRT

print(f"rasterio {rasterio.__version__}, GDAL {rasterio.__gdal_version__}, netCDF4 {netCDF4.__version__}")
ROWS, COLUMNS = 61, 81


def warped(two_dimensional, north_first):
    """Writes a grid of which each height is 100 times its latitude; latitude and height of warped samples."""
    latitudes, longitudes = np.linspace(50, 47, ROWS), np.linspace(8, 12, COLUMNS)
    latitudes = latitudes if north_first else latitudes[::-1]
    grid = np.meshgrid(latitudes, longitudes, indexing="ij")
    with netCDF4.Dataset("grid.nc", "w") as f:
        f.Conventions = "CF-1.8"
        f.createDimension("y", ROWS)
        f.createDimension("x", COLUMNS)
        for axis, dimension, line, plane in (("lat", "y", latitudes, grid[0]), ("lon", "x", longitudes, grid[1])):
            v = f.createVariable(axis, "f8", ("y", "x") if two_dimensional else (dimension,))
            v.standard_name = "latitude" if axis == "lat" else "longitude"
            v.units = "degrees_north" if axis == "lat" else "degrees_east"
            v[:] = plane if two_dimensional else line
        z = f.createVariable("z", "f4", ("y", "x"), fill_value=-9999.0)
        z.coordinates, z[:] = "lat lon", grid[0] * 100
    with rasterio.open("grid.nc") as f:
        assert f.transform.is_identity and f.tags(ns="GEOLOCATION")
        with WarpedVRT(f, src_crs="EPSG:4326", crs="EPSG:4326") as out:
            rows = np.array([5, out.height // 2, out.height - 6])
            return out.transform.f + out.transform.e * (rows + 0.5), out.read(1)[rows, out.width // 2]


for two_dimensional in True, False:
    for north_first in True, False:
        latitudes, heights = warped(two_dimensional, north_first)
        name = f"{2 if two_dimensional else 1}-D latitudes, {'north' if north_first else 'south'} first"
        print(f"{name}: at latitudes {latitudes.round(2).tolist()} heights {heights.round(0).tolist()}")
        expected = latitudes * 100 if two_dimensional else 9700 - latitudes * 100
        assert np.abs(heights - expected).max() < 10, f"{name}: the warp is another one"
PYTHON
