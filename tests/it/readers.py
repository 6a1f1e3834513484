"""Opens meshes in trimesh, meshio, plyfile, ugrid-checks and the netCDF library: readers.py CASES, a file of JSON that lists how
each is to be checked, what `simplify --json` says of it, and the same mesh as PLY in map coordinates. Exits 1 at the
first that is something else."""

import json
import sys
import xml.etree.ElementTree
from pathlib import Path

import meshio
import netCDF4
import numpy
import plyfile
import trimesh
from ugrid_checks.check import check_dataset

# The raster's samples, which the test has laid beside the meshes.
COLUMNS, ROWS = 120, 90


class Wrong(Exception):
    """A reader has found something else."""


def expect(what, expected, found):
    if expected != found:
        raise Wrong(f"{what}: expected {expected}, found {found}")


def expect_same(what, expected, found):
    expected, found = numpy.asarray(expected), numpy.asarray(found)
    expect(f"shape of {what}", expected.shape, found.shape)
    if not (expected == found).all():
        at = tuple(int(i) for i in numpy.argwhere(expected != found)[0])
        raise Wrong(f"{what}, at {at}: expected {expected[at]!r}, found {found[at]!r}")


class Expected:
    """The mesh as a case wants it: the reference in the case's frame."""

    def __init__(self, case):
        reference = trimesh.load(case["reference"], process=False)
        report = case["report"]
        self.vertices, self.triangles, self.map = report["vertices"], report["triangles"], report["map"]
        self.options, self.path = case["options"].split(), case["file"]
        self.is_single = self.map["precision"] == "float"
        self.faces = numpy.asarray(reference.faces)
        (x, y), (across, up) = self.map["offset"], self.map["xy_scale"]
        self.shift = numpy.array([x, y, 0.0])
        places = (numpy.asarray(reference.vertices) - self.shift) * [across, up, self.map["z_scale"]]
        self.places = places.astype(numpy.float32).astype(float) if self.is_single else places
        self.colours = reference.visual.vertex_colors if reference.visual.kind == "vertex" else None
        self.normals = "--normals" in self.options
        expect("vertices of the reference", self.vertices, len(self.places))
        expect("triangles of the reference", self.triangles, len(self.faces))


def on_samples(places, samples):
    """Every vertex stands on a sample, at its height."""
    heights = numpy.fromfile(samples["file"]).reshape(ROWS, COLUMNS)
    left, across, _, top, _, down = samples["transform"]
    columns, rows = (places[:, 0] - left) / across - 0.5, (places[:, 1] - top) / down - 0.5
    off = max(abs(columns - columns.round()).max(), abs(rows - rows.round()).max())
    expect("vertices on samples, about", True, bool(off < 1e-6))
    expect_same("heights of the samples", heights[rows.round().astype(int), columns.round().astype(int)], places[:, 2])


def upward_normals(normals, count, axis=2):
    expect("normals", (count, 3), normals.shape)
    lengths = numpy.linalg.norm(normals, axis=1)
    expect("length of normals, about", True, bool((abs(lengths - 1) < 1e-5).all()))
    expect("normals that point up", count, int((normals[:, axis] > 0).sum()))
    expect("normals of their own", True, len(numpy.unique(normals, axis=0)) > count / 10)


def ply(case):
    expected = Expected(case)
    mesh = trimesh.load(expected.path, process=False)
    expect("consistent winding", True, bool(mesh.is_winding_consistent))
    expect("triangles that face up", expected.triangles, int((mesh.face_normals[:, 2] > 0).sum()))
    expect("vertices in use", expected.vertices, len(numpy.unique(mesh.faces)))
    expect("vertices at places of their own", expected.vertices, len(numpy.unique(mesh.vertices[:, :2], axis=0)))
    expect_same("places in trimesh", expected.places, mesh.vertices)
    expect_same("triangles in trimesh", expected.faces, mesh.faces)
    if "samples" in case:
        on_samples(mesh.vertices, case["samples"])

    other = meshio.read(expected.path)
    expect("kinds of cells in meshio", ["triangle"], [block.type for block in other.cells])
    expect("numbers of the vertices in meshio", "float32" if expected.is_single else "float64", str(other.points.dtype))
    expect_same("places in meshio", expected.places, other.points)
    expect_same("triangles in meshio", expected.faces, other.cells[0].data)
    expect("normals in meshio", expected.normals, "nx" in other.point_data)
    if expected.normals:
        upward_normals(numpy.stack([other.point_data[name] for name in ("nx", "ny", "nz")], axis=1), expected.vertices)
        upward_normals(mesh.vertex_normals, expected.vertices)


def edges(case):
    """Edges that follow breaklines are sides of triangles; as many as the report says, each once."""
    # meshio 5.3 ends the process at an element of another name than vertex and face, and trimesh 5.2 wants scipy.
    mesh = plyfile.PlyData.read(case["file"])
    faces = numpy.stack(list(mesh["face"]["vertex_indices"])).astype(int)
    expect("triangles", case["report"]["triangles"], len(faces))
    sides = {tuple(sorted(side)) for a, b, c in faces.tolist() for side in ((a, b), (b, c), (c, a))}
    found = numpy.stack([mesh["edge"][name] for name in ("vertex1", "vertex2")], axis=1).astype(int)
    found = {tuple(sorted(edge)) for edge in found.tolist()}
    expect("edges of lines", case["report"]["breaklines"]["chains"]["edges"], len(found))
    expect("edges of lines that are no sides", set(), found - sides)


def colours(case):
    mesh, other = trimesh.load(case["file"], process=False), meshio.read(case["file"])
    expected = [[10 * i, 0, 255] for i in range(4)]
    expect("colours in trimesh", expected, mesh.visual.vertex_colors[:, :3].tolist())
    # meshio 5.3 takes `uchar` for a signed byte.
    found = [other.point_data[name].astype("uint8") for name in ("red", "green", "blue")]
    expect("colours in meshio", expected, numpy.stack(found, axis=1).tolist())
    heat = other.point_data["heat"]
    expect("numbers of the heat in meshio", "float32", str(heat.dtype))
    expect("heat in meshio", [0.0, 0.5, 1.0, 1.5], heat.tolist())


def obj(case):
    expected = Expected(case)
    mesh = trimesh.load(expected.path, process=False, maintain_order=True)
    expect_same("places in trimesh", expected.places, mesh.vertices)
    expect_same("triangles in trimesh", expected.faces, mesh.faces)
    other = meshio.read(expected.path)
    expect("kinds of cells in meshio", ["triangle"], [block.type for block in other.cells])
    expect_same("places in meshio", expected.places, other.points)
    expect_same("triangles in meshio", expected.faces, other.cells[0].data)
    if expected.normals:
        upward_normals(mesh.vertex_normals, expected.vertices)
        upward_normals(other.point_data["obj:vn"], expected.vertices)
        expect_same("normals in both", mesh.vertex_normals.round(5), other.point_data["obj:vn"].round(5))
    if "--texture" in expected.options:
        texture(mesh, mesh.visual.material.image, expected.places)


def texture(mesh, image, places):
    """What lies over a vertex: red grows to the east by 2 a column, green to the south, blue is 200."""
    # What lies beyond the centres of the outermost samples has been cut off.
    expect("pixels of the image", (4 * (COLUMNS - 1), 4 * (ROWS - 1)), image.size)
    u, v = numpy.asarray(mesh.visual.uv).T
    west, north = places[:, 0].min(), places[:, 1].max()
    least, largest = ([round(float(n), 6) for n in of] for of in ((u.min(), v.min()), (u.max(), v.max())))
    expect("the least and the largest of u and v, about", ([0.0, 0.0], [1.0, 1.0]), (least, largest))
    pixels = numpy.asarray(image.convert("RGB")).astype(float)
    # trimesh counts v from below.
    row = ((1 - v) * image.size[1]).round().astype(int).clip(max=image.size[1] - 1)
    column = (u * image.size[0]).round().astype(int).clip(max=image.size[0] - 1)
    colour = pixels[row, column]
    columns, rows = ((places[:, 0] - west) / 0.25).round(), ((north - places[:, 1]) / 0.25).round()
    # JPEG is near, not equal.
    far = abs(colour - numpy.stack([2 * columns, 2 * rows, numpy.full(len(u), 200.0)], axis=1)).max()
    expect("colours under the vertices, at most 8 off", True, bool(far <= 8))


def stl(case):
    expected = Expected(case)
    mesh = trimesh.load(expected.path, process=False)
    corners = expected.places[expected.faces]
    expect_same("corners in trimesh", corners, mesh.triangles)
    expect("triangles that face up", expected.triangles, int((mesh.face_normals[:, 2] > 0).sum()))
    joined = trimesh.load(expected.path)
    expect("vertices in trimesh when joined", expected.vertices, len(joined.vertices))
    other = meshio.read(expected.path)
    expect("kinds of cells in meshio", ["triangle"], [block.type for block in other.cells])
    expect("vertices in meshio, which joins them", expected.vertices, len(other.points))
    expect_same("corners in meshio", corners, other.points[other.cells[0].data])


def solid(case):
    """Of two parts, one with a hole."""
    expected = Expected(case)
    mesh = trimesh.load(expected.path)
    expect("closed", True, bool(mesh.is_watertight))
    expect("wound the same way", True, bool(mesh.is_winding_consistent))
    expect("encloses a volume", True, bool(mesh.is_volume))
    # A ball has 2, a ring has 0.
    expect("Euler's number", 2, int(mesh.euler_number))
    expect("vertices, all twice", 2 * expected.vertices, len(mesh.vertices))
    expect("triangles that face up", expected.triangles, int((mesh.face_normals[:, 2] > 1e-6).sum()))
    expect("triangles that face down", expected.triangles, int((mesh.face_normals[:, 2] < -1e-6).sum()))
    surface = expected.places[expected.faces]
    sides = surface[:, 1:, :2] - surface[:, :1, :2]
    areas = (sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]) / 2
    floor = mesh.bounds[0, 2]
    volume = float((areas * (surface[:, :, 2].mean(axis=1) - floor)).sum())
    expect("volume, within a millionth", True, abs(mesh.volume / volume - 1) < 1e-6)
    lowest = float(expected.places[:, 2].min())
    option = expected.options
    depth = lowest - float(option[option.index("--base-depth") + 1]) if "--base-depth" in option else -100.0
    expect("floor", depth, float(floor))


def glb(case):
    expected = Expected(case)
    scene = trimesh.load(expected.path, process=False)
    [(name, mesh)] = scene.geometry.items()
    [node] = scene.graph.nodes_geometry
    matrix, _ = scene.graph[node]
    # glTF's y is up, and its z is south.
    turned = expected.places[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
    expect_same("places in trimesh", turned, mesh.vertices)
    expect_same("triangles in trimesh", expected.faces, mesh.faces)
    across, up = expected.map["xy_scale"]
    shift = numpy.array([expected.shift[0] * across, 0.0, -expected.shift[1] * up])
    expect_same("matrix of the node", trimesh.transformations.translation_matrix(shift), matrix)
    world = turned + shift
    expect_same("bounds in the world", [world.min(axis=0), world.max(axis=0)], scene.bounds)
    if expected.normals:
        upward_normals(mesh.vertex_normals, expected.vertices, axis=1)
    if "--texture" in expected.options:
        texture(mesh, mesh.visual.material.baseColorTexture, expected.places)
    if expected.colours is not None:
        # With a material beside them, trimesh has colours there.
        expect_same("colours", expected.colours, mesh.visual.vertex_attributes["color"])
        expect("different colours", True, len(numpy.unique(expected.colours, axis=0)) > 50)


def compressed(case):
    """trimesh 5.2 does not know the compression; readers.mjs does."""
    Expected(case)


def landxml(case):
    """The numbers that xmllint has counted."""
    expected = Expected(case)
    names = "{http://www.landxml.org/schema/LandXML-1.2}"
    root = xml.etree.ElementTree.parse(expected.path).getroot()
    points = list(root.iter(names + "P"))
    expect("numbers of the points", [str(i + 1) for i in range(expected.vertices)], [p.get("id") for p in points])
    # Readers split at exactly one blank. Northing comes first.
    places = [[float(word) for word in p.text.split(" ")] for p in points]
    expect_same("places", expected.places[:, [1, 0, 2]], places)
    faces = [[int(word) - 1 for word in f.text.split(" ")] for f in root.iter(names + "F")]
    expect_same("triangles", expected.faces, faces)


def ugrid(case):
    expected = Expected(case)
    logs = check_dataset(expected.path, print_summary=False).logger.report_statement_logrecords()
    expect("statements of ugrid-checks", [], [str(record.msg) for record in logs])
    with netCDF4.Dataset(expected.path) as file:
        file.set_auto_mask(False)
        columns = [file[f"mesh2d_node_{axis}"][:] for axis in "xyz"]
        expect("numbers", {"float32" if expected.is_single else "float64"}, {str(column.dtype) for column in columns})
        expect_same("places", expected.places, numpy.stack(columns, axis=1))
        expect_same("triangles", expected.faces, file["mesh2d_face_nodes"][:])


def ogr(case):
    """Read by ogrinfo."""
    Expected(case)


CHECKS = {
    check.__name__: check
    for check in (ply, edges, colours, obj, stl, solid, glb, compressed, landxml, ugrid, ogr)
}

for case in json.loads(Path(sys.argv[1]).read_text()):
    try:
        CHECKS[case["check"]](case)
    except Wrong as wrong:
        sys.exit(f"{case['file']} {case.get('options', '')}: {wrong}")
