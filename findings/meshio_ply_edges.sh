#!/usr/bin/env bash
# Version: meshio 5.3.5.
#
# The good guess: a PLY file with an element that a reader has no use for, such as `edge`, is read without it: the header says how long
# each element's rows are, so that readers can pass over them. If a file is refused all the same, meshio.read raises an error of meshio's.
#
# What happens: `edge`, an element that the format's first description names as one of a user, is refused. And meshio.read raises no
# error for a file that it refuses: it prints, and calls sys.exit(1). `except Exception` does not catch that; the program ends in
# the middle of its work. meshio.ply.read, which does not guess the format, raises ReadError.
#
# Why it matters: breaklines and feature edges of a terrain mesh stand in `edge` (Open3D and trimesh know them). A
# service that reads meshes of its users with meshio is ended by one of them.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.2.6 plyfile==1.1.5
cd "$work"

venv/bin/python - <<'PYTHON'
import meshio
import plyfile

print(f"meshio {meshio.__version__}, plyfile 1.1.5")
HEADER = """ply
format ascii 1.0
element vertex 4
property double x
property double y
property double z
element face 2
property list uchar int vertex_indices
"""
EDGES = "element edge 1\nproperty int vertex1\nproperty int vertex2\n"
BODY = "end_header\n0 0 10\n1 0 11\n1 1 12\n0 1 11\n3 0 1 2\n3 0 2 3\n"
with open("plain.ply", "w") as f:
    f.write(HEADER + BODY)
with open("edges.ply", "w") as f:
    f.write(HEADER + EDGES + BODY + "0 2\n")


def outcome(read, name):
    try:
        mesh = read(name)
    except Exception as error:
        return f"an error: {type(error).__name__}"
    except SystemExit as end:
        return f"the end of the process, with exit code {end.code}"
    return f"{len(mesh.points)} vertices" if isinstance(mesh, meshio.Mesh) else f"{mesh['vertex'].count} vertices"


found = {
    "plyfile, with edges": outcome(plyfile.PlyData.read, "edges.ply"),
    "meshio, without edges": outcome(meshio.read, "plain.ply"),
    "meshio, with edges": outcome(meshio.read, "edges.ply"),
    "meshio.ply, with edges": outcome(meshio.ply.read, "edges.ply"),
}
for what, how in found.items():
    print(f"{what}: {how}")
assert found["plyfile, with edges"] == found["meshio, without edges"] == "4 vertices"
assert found["meshio, with edges"] == "the end of the process, with exit code 1"
assert found["meshio.ply, with edges"] == "an error: ReadError"
PYTHON
