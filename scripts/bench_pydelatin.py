"""pydelatin in a process of its own, run by bench.py in the virtual environment.

Reads bare single-precision heights, triangulates, and prints the seconds of each step. With --ply it also writes the
mesh in the raster's map coordinates, the way terrabite places vertices, so that the same check serves both.
"""

import argparse
import json
import resource
import time

START = time.perf_counter()
import numpy as np  # noqa: E402  (its import is part of the loading time)
from pydelatin import Delatin  # noqa: E402

parser = argparse.ArgumentParser()
parser.add_argument("heights", help="width × height floats, row by row")
parser.add_argument("width", type=int)
parser.add_argument("height", type=int)
parser.add_argument("max_error", type=float)
parser.add_argument("--ply", help="write the mesh here")
parser.add_argument("--geotransform", type=float, nargs=6)
arguments = parser.parse_args()


def write_ply(path, vertices, triangles, coefficients):
    """Vertices at pixel centres, x = (c0 + P·c1) + L·c2 in doubles; triangles counter-clockwise on the map."""
    c0, c1, c2, c3, c4, c5 = coefficients
    # pydelatin counts y upwards from the last row.
    pixel = vertices[:, 0].astype(np.float64) + 0.5
    line = (arguments.height - 1 - vertices[:, 1].astype(np.float64)) + 0.5
    places = np.empty((len(vertices), 3), "<f8")
    places[:, 0] = (c0 + pixel * c1) + line * c2
    places[:, 1] = (c3 + pixel * c4) + line * c5
    places[:, 2] = vertices[:, 2]
    faces = np.empty(len(triangles), [("count", "u1"), ("corners", "<u4", 3)])
    faces["count"] = 3
    # Counter-clockwise with y upwards: on the map too, unless rows run along the map's y axis.
    faces["corners"] = triangles[:, ::-1] if c1 * c5 - c2 * c4 > 0 else triangles
    with open(path, "wb") as file:
        file.write(
            f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
            "property double x\nproperty double y\nproperty double z\n"
            f"element face {len(triangles)}\nproperty list uchar uint vertex_indices\nend_header\n".encode()
        )
        file.write(places.tobytes())
        file.write(faces.tobytes())


heights = np.fromfile(arguments.heights, "<f4").reshape(arguments.height, arguments.width)
loaded, cpu_loaded = time.perf_counter(), time.process_time()
mesh = Delatin(heights, max_error=arguments.max_error)
triangulated, cpu_triangulated = time.perf_counter(), time.process_time()
vertices, triangles = mesh.vertices, mesh.triangles
if arguments.ply:
    write_ply(arguments.ply, vertices, triangles, arguments.geotransform)
report = {
    "triangles": len(triangles),
    "vertices": len(vertices),
    "load_seconds": loaded - START,
    "triangulate_seconds": triangulated - loaded,
    "triangulate_cpu_seconds": cpu_triangulated - cpu_loaded,
    "peak_kib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
}
print(json.dumps(report))
