#!/usr/bin/env bash
# Version: uxarray 2026.10.0 reads what netCDF4 1.7.5.1.post1 writes.
#
# The good guess: a UGRID mesh whose node coordinates bear neither units nor a standard_name is plane, or is refused: the
# conventions ask for both, and values beyond 360 are no degrees.
#
# What happens: uxarray takes the first coordinate for longitudes in degrees and wraps it into -180 to 180. The easting
# 500000.12 becomes -39.88; the northing stays. No warning, no error. With units "m" and standard_name
# "projection_x_coordinate" the numbers come out as they are (still as node_lon and node_lat).
#
# Why it matters: a hydraulic mesh in UTM loses its shape: places 360 m apart fall together.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: uxarray==2026.10.0 netCDF4==1.7.5.1.post1
cd "$work"

venv/bin/python -W ignore - <<'PYTHON'
import netCDF4
import numpy
import uxarray

print(f"uxarray {uxarray.__version__}, netCDF4 {netCDF4.__version__}")
EASTING, NORTHING = 500000.12, 5200000.77


def nodes(name, attributes):
    """Writes two triangles, and returns what uxarray has of the first node."""
    with netCDF4.Dataset(name, "w", format="NETCDF3_64BIT_OFFSET") as f:
        f.Conventions = "CF-1.8 UGRID-1.0"
        for dimension, size in ("node", 4), ("face", 2), ("three", 3):
            f.createDimension(dimension, size)
        mesh = f.createVariable("mesh2d", "i4")
        mesh.setncatts({"cf_role": "mesh_topology", "topology_dimension": 2, "node_coordinates": "node_x node_y",
                        "face_node_connectivity": "faces", "face_dimension": "face"})
        x, y = f.createVariable("node_x", "f8", ("node",)), f.createVariable("node_y", "f8", ("node",))
        x[:], y[:] = [EASTING, EASTING + 10, EASTING + 10, EASTING], [NORTHING, NORTHING, NORTHING + 10, NORTHING + 10]
        if attributes:
            x.setncatts({"units": "m", "standard_name": "projection_x_coordinate"})
            y.setncatts({"units": "m", "standard_name": "projection_y_coordinate"})
        faces = f.createVariable("faces", "i4", ("face", "three"))
        faces.setncatts({"cf_role": "face_node_connectivity", "start_index": 0})
        faces[:] = [[0, 1, 2], [0, 2, 3]]
    grid = uxarray.open_grid(name)
    return [float(numpy.asarray(v)[0]) for v in (grid.node_lon, grid.node_lat)]


bare, said = nodes("bare.nc", False), nodes("said.nc", True)
print(f"written: {EASTING}, {NORTHING}")
print(f"without units and standard_name: {bare[0]:.2f}, {bare[1]:.2f}")
print(f"with them: {said[0]:.2f}, {said[1]:.2f}")
assert abs(bare[0] - (-39.88)) < 0.01 and bare[1] == NORTHING
assert said == [EASTING, NORTHING]
PYTHON
