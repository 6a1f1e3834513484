"""Opens a mesh in trimesh and meshio: readers.py MESH VERTICES TRIANGLES. Exits 1 where they find anything else."""

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


main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
