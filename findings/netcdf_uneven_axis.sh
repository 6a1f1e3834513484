#!/usr/bin/env bash
# Version: rasterio 1.4.4 with GDAL 3.10.3; netCDF4 1.7.2 writes the files.
#
# The good guess: a netCDF grid whose axis is not evenly spaced gets no geotransform (but geolocation arrays, or an
# error), because no geotransform says where its samples are.
#
# What happens:
# 1. Of the longitudes, only the first, the middle and the last step are compared. A grid that lacks two columns gets
#    an even geotransform, and nothing is said. Columns are off by more than a cell. A gap at the middle step is found.
# 2. Latitudes that are spaced as on a Mercator map get an even geotransform as well: rows are off by 5 degrees. The
#    only sign is a logged warning that speaks of a threshold of 0.1 degrees.
#
# Why it matters: sea floor models and ocean models come on such grids. The mesh has right heights in wrong places,
# hundreds of kilometres away, and no error of the mesh shows it.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check rasterio==1.4.4 numpy==2.2.6 netCDF4==1.7.2
cd "$work"

venv/bin/python -W ignore - <<'PYTHON'
import logging

import netCDF4
import numpy as np
import rasterio

print(f"rasterio {rasterio.__version__}, GDAL {rasterio.__gdal_version__}, netCDF4 {netCDF4.__version__}")
messages = []
handler = logging.Handler()
handler.emit = lambda record: messages.append(record.getMessage())
logging.getLogger("rasterio").addHandler(handler)


def opened(latitudes, longitudes, z):
    """Writes a CF grid of heights z; its geotransform, its values, and what GDAL warned of."""
    with netCDF4.Dataset("grid.nc", "w") as f:
        f.Conventions = "CF-1.8"
        for axis, values, name in (("lat", latitudes, "latitude"), ("lon", longitudes, "longitude")):
            f.createDimension(axis, len(values))
            v = f.createVariable(axis, "f8", (axis,))
            v.standard_name, v.units = name, "degrees_north" if axis == "lat" else "degrees_east"
            v[:] = values
        f.createVariable("z", "f8", ("lat", "lon"))[:] = z
    messages.clear()
    with rasterio.open("grid.nc") as f:
        return f.transform, f.read(1), list(messages)


latitudes, even = np.arange(50, 44.9, -0.5), 10 + 0.5 * np.arange(31)
for gap_after, expected in (9, "geotransform"), (15, "none"):
    longitudes = even + np.where(np.arange(31) > gap_after, 1.0, 0.0)
    transform, z, warned = opened(latitudes, longitudes, np.tile(longitudes, (len(latitudes), 1)))
    off = np.abs(transform.c + transform.a * (np.arange(31) + 0.5) - z[0]).max()
    none = transform.is_identity
    says = "no geotransform" if none else f"columns up to {off:.2f} degrees ({off / 0.5:.2f} cells) off"
    print(f"gap after column {gap_after}: {says}; warnings: {warned}")
    assert none if expected == "none" else not none and off > 0.5 and not warned

latitudes = np.degrees(np.arctan(np.sinh(np.radians(np.arange(453) / 6))))[::-1]
transform, z, warned = opened(latitudes, np.arange(60) / 6, np.tile(latitudes[:, None], (1, 60)))
off = np.abs(transform.f + transform.e * (np.arange(453) + 0.5) - z[:, 0]).max()
print(f"Mercator latitudes: rows up to {off:.2f} degrees off; warnings: {warned}")
assert not transform.is_identity and off > 5
PYTHON
