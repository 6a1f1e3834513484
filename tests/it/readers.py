"""Opens a mesh in trimesh and meshio: readers.py MESH VERTICES TRIANGLES [colours]. Exits 1 where they find anything
else. With `colours`, vertex i has the colour (10 i, 0, 255) and a heat of i / 2."""

import sys

import meshio
import numpy
import trimesh


def expect(what, expected, found):
    if expected != found:
        sys.exit(f"{what}: expected {expected}, found {found}")


def main(path, vertices, triangles):
    mesh = trimesh.load(path, process=False)
    expect("vertices in trimesh", vertices, len(mesh.vertices))
    expect("triangles in trimesh", triangles, len(mesh.faces))
    expect("consistent winding", True, bool(mesh.is_winding_consistent))
    expect("triangles that face up", triangles, int((mesh.face_normals[:, 2] > 0).sum()))
    expect("vertices in use", vertices, len(numpy.unique(mesh.faces)))
    expect("vertices at places of their own", vertices, len(numpy.unique(mesh.vertices[:, :2], axis=0)))

    other = meshio.read(path)
    expect("kinds of cells in meshio", ["triangle"], [block.type for block in other.cells])
    expect("vertices in meshio", vertices, len(other.points))
    expect("triangles in meshio", triangles, len(other.cells[0].data))
    expect("numbers of the vertices in meshio", "float64", str(other.points.dtype))
    expect("same vertices in both", True, bool((other.points == mesh.vertices).all()))
    expect("same triangles in both", True, bool((other.cells[0].data == mesh.faces).all()))
    return mesh, other


def colours(mesh, other):
    count = len(mesh.vertices)
    expected = [[10 * i, 0, 255] for i in range(count)]
    expect("colours in trimesh", expected, mesh.visual.vertex_colors[:, :3].tolist())
    # meshio 5.3 takes `uchar` for a signed byte.
    found = [other.point_data[name].astype("uint8") for name in ("red", "green", "blue")]
    expect("colours in meshio", expected, numpy.stack(found, axis=1).tolist())
    heat = other.point_data["heat"]
    expect("numbers of the heat in meshio", "float32", str(heat.dtype))
    expect("heat in meshio", [0.5 * i for i in range(count)], heat.tolist())


both = main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
if sys.argv[4:] == ["colours"]:
    colours(*both)
