#!/usr/bin/env python3
"""Opens meshes of every format in programs that others wrote, and prints what each finds, as a table for
docs/formats.md. Called by `make test-readers`, after the build.

A mesh in UTM, a quarter of a metre a cell, is written in each format: in map coordinates, where singles are half a
metre apart, and with `--local`. Each reader opens each file in a process of its own, so one that ends abnormally ends
nothing else. What it finds is held against the same mesh as text (`--ascii`), and against EXPECTED below: exit code 1
where something else is found.

The readers from PyPI are installed once into target/readers, for which a Python from 3.11 to 3.14 is looked for
(READERS_PYTHON names the Python of another environment that has them). QGIS is Debian's, and works with
/usr/bin/python3 alone.
"""

import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

from environment import python_with

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / os.environ.get("CARGO_TARGET_DIR", "target")
TERRABITE = Path(os.environ.get("TERRABITE") or TARGET / "release" / "terrabite").absolute()
SYSTEM_PYTHON = "/usr/bin/python3"
# The Pythons for which all of scripts/readers-requirements.txt has wheels.
PYTHONS = ((3, 11), (3, 14))
SECONDS = 300

CASES = ["map", "local"]
NAMES = {
    "ply": "PLY", "ascii.ply": "PLY as text", "obj": "OBJ", "stl": "STL", "glb": "GLB", "vtp": "VTP", "nc": "UGRID",
    "2dm": "2DM", "gpkg": "GeoPackage", "fgb": "FlatGeobuf",
}
# The options of a format. Attributes are carried along, and say nothing about where vertices are.
ATTRIBUTES = ["--attributes", "2,3,4", "--attribute-weight", "0"]
NORMALS = ["--normals", "gradient"]
OPTIONS = {"ply": NORMALS, "ascii.ply": NORMALS + ["--ascii"], "obj": NORMALS, "glb": NORMALS, "vtp": NORMALS}
# Formats that are always local, and FlatGeobuf, which never is.
ONE_FRAME = ["stl", "glb", "fgb"]


# ---------------------------------------------------------------- readers, each in a process of its own
#
# A reader gets a path and its format, and gives a dictionary: `version`; `places`, and `triangles` of their numbers, or
# `corners` of each triangle; where it has them `colours` from 0 to 255 (or `colours_of_corners`), `normals`, `crs`,
# `extent`, and `also`, a list of words.


def pyvista(path, form):
    import pyvista
    import vtk

    mesh = pyvista.read(path)
    if form == "glb":
        mesh = mesh.combine().extract_surface(algorithm="dataset_surface")
    found = {
        "version": f"PyVista {pyvista.__version__} (VTK {vtk.vtkVersion().GetVTKVersion()})",
        "places": mesh.points.astype(float).tolist(),
        "triangles": mesh.faces.reshape(-1, 4)[:, 1:].tolist(),
        "also": [],
    }
    data = mesh.point_data
    for name in ("RGB", "COLOR_0"):
        if name in data:
            # Singles from 0 to 1 in GLB.
            found["colours"] = (data[name][:, :3] * (255 if form == "glb" else 1)).round().tolist()
    if all(name in data for name in ("red", "green", "blue")):
        found["colours"] = list(zip(*(data[name].tolist() for name in ("red", "green", "blue"))))
    if data.active_normals_name:
        found["normals"] = data.active_normals.tolist()
    if "terrabite" in mesh.field_data:
        lines = [str(line) for line in mesh.field_data["terrabite"]]
        found["also"] += ["field data"] if lines[0].startswith("made by terrabite") else []
    return found


def open3d(path, form):
    import numpy
    import open3d

    mesh = open3d.io.read_triangle_mesh(path)
    found = {
        "version": f"Open3D {open3d.__version__}",
        "places": numpy.asarray(mesh.vertices).tolist(),
        "triangles": numpy.asarray(mesh.triangles).tolist(),
    }
    if mesh.has_vertex_colors():
        found["colours"] = (numpy.asarray(mesh.vertex_colors) * 255).round().tolist()
    # Those of an STL are of its making.
    if mesh.has_vertex_normals() and form != "stl":
        found["normals"] = numpy.asarray(mesh.vertex_normals).tolist()
    return found


def pymeshlab(path, form):
    import importlib.metadata

    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(path)
    mesh = meshes.current_mesh()
    matrix = mesh.transform_matrix()
    places = mesh.vertex_matrix()
    found = {
        "version": f"pymeshlab {importlib.metadata.version('pymeshlab')}",
        "places": (places @ matrix[:3, :3].T + matrix[:3, 3]).tolist(),
        "triangles": mesh.face_matrix().tolist(),
    }
    if mesh.has_vertex_color():
        found["colours"] = (mesh.vertex_color_matrix()[:, :3] * 255).round().tolist()
    # It makes normals where there are none, which are not of length one.
    normals = mesh.vertex_normal_matrix()
    if abs((normals**2).sum(axis=1) - 1).max() < 1e-4:
        found["normals"] = normals.tolist()
    return found


def xugrid(path, _):
    import numpy
    import xugrid

    data = xugrid.open_dataset(path)
    grid = data.ugrid.grid
    columns = [grid.node_x, grid.node_y, data["mesh2d_node_z"].values]
    colours = [data[name].values for name in ("red", "green", "blue")]
    return {
        "version": f"xugrid {xugrid.__version__}",
        "places": numpy.stack(columns, axis=1).tolist(),
        "triangles": grid.face_node_connectivity.tolist(),
        "colours": numpy.stack(colours, axis=1).tolist(),
        "crs": crs_in_words(grid.crs),
    }


def uxarray(path, _):
    import warnings

    import numpy
    import uxarray

    # It says that areas on spheres have no meaning here.
    warnings.simplefilter("ignore")
    grid, data = uxarray.open_grid(path), uxarray.open_dataset(path, path)
    # It calls x and y so, whatever they are.
    columns = [grid.node_lon.values, grid.node_lat.values, data["mesh2d_node_z"].values]
    colours = [data[name].values for name in ("red", "green", "blue")]
    return {
        "version": f"uxarray {uxarray.__version__}",
        "places": numpy.stack(columns, axis=1).tolist(),
        "triangles": grid.face_node_connectivity.values.tolist(),
        "colours": numpy.stack(colours, axis=1).tolist(),
    }


def crs_in_words(crs):
    """Of pyproj's."""
    if crs is None:
        return None
    return f"EPSG:{crs.to_epsg()}" if crs.to_epsg() else crs.name


def geopandas(path, _):
    import geopandas
    import pyogrio

    data = geopandas.read_file(path)
    corners = [list(geometry.exterior.coords)[:3] for geometry in data.geometry]
    if not all(len(g.exterior.coords) == 4 and g.has_z and not g.interiors for g in data.geometry):
        raise ValueError("not every polygon is a triangle with heights")
    names = [f"{colour}_{corner}" for corner in (1, 2, 3) for colour in ("red", "green", "blue")]
    gdal = ".".join(str(number) for number in pyogrio.__gdal_version__)
    return {
        "version": f"geopandas {geopandas.__version__} (pyogrio {pyogrio.__version__}, GDAL {gdal})",
        "corners": corners,
        "colours_of_corners": data[names].to_numpy(dtype=float).reshape(-1, 3, 3).tolist(),
        "crs": crs_in_words(data.crs),
    }


def qgis(path, form):
    os.environ["QT_QPA_PLATFORM"] = "offscreen"
    from qgis import core

    core.QgsApplication([], False).initQgis()
    found = {"version": f"QGIS {core.Qgis.QGIS_VERSION.split('-')[0]}"}
    if form in ("gpkg", "fgb"):
        layer = core.QgsVectorLayer(path, "tin", "ogr")
        if not layer.isValid():
            raise ValueError(layer.error().summary() or "no layer")
        corners, colours = [], []
        for feature in layer.getFeatures():
            places = [[p.x(), p.y(), p.z()] for p in feature.geometry().constGet().vertices()]
            if len(places) != 4:
                raise ValueError(f"a polygon of {len(places)} places")
            corners.append(places[:3])
            names = [[f"{colour}_{corner}" for colour in ("red", "green", "blue")] for corner in (1, 2, 3)]
            colours.append([[float(feature[name]) for name in of_corner] for of_corner in names])
        found |= {"corners": corners, "colours_of_corners": colours}
    else:
        layer = core.QgsMeshLayer(path, "tin", "mdal")
        if not layer.isValid():
            raise ValueError(layer.error().summary() or "no layer")
        provider, mesh = layer.dataProvider(), core.QgsMesh()
        provider.populateMesh(mesh)
        points = [mesh.vertex(i) for i in range(provider.vertexCount())]
        found["places"] = [[p.x(), p.y(), p.z()] for p in points]
        found["triangles"] = [list(mesh.face(i)) for i in range(provider.faceCount())]
        groups = {provider.datasetGroupMetadata(i).name(): i for i in range(provider.datasetGroupCount())}
        if {"red", "green", "blue"} <= groups.keys():
            channels = []
            for name in ("red", "green", "blue"):
                block = provider.datasetValues(core.QgsMeshDatasetIndex(groups[name], 0), 0, len(points))
                channels.append([block.value(i).scalar() for i in range(len(points))])
            found["colours"] = list(zip(*channels))
        if "Bed Elevation" in groups:
            block = provider.datasetValues(core.QgsMeshDatasetIndex(groups["Bed Elevation"], 0), 0, len(points))
            same = all(block.value(i).scalar() == point.z() for i, point in enumerate(points))
            found["also"] = ["Bed Elevation"] if same else []
    box = layer.extent()
    found["extent"] = [box.xMinimum(), box.yMinimum(), box.xMaximum(), box.yMaximum()]
    found["crs"] = layer.crs().authid() or layer.crs().description() or None
    return found


READERS = {
    pyvista: ["vtp", "ply", "ascii.ply", "obj", "stl", "glb"],
    open3d: ["ply", "ascii.ply", "obj", "stl", "glb"],
    pymeshlab: ["ply", "ascii.ply", "obj", "stl", "glb"],
    xugrid: ["nc"],
    uxarray: ["nc"],
    geopandas: ["gpkg", "fgb"],
    qgis: ["nc", "2dm", "ply", "ascii.ply", "gpkg", "fgb"],
}

# ---------------------------------------------------------------- what is to be found

EXACT, SINGLES, DOUBLES, NONE, UTM = "exact", "singles", "doubles", "–", "EPSG:32633"
SHADED = ["colours", "normals"]
MESH = ["Bed Elevation", "colours", UTM]
# Reader and format: what is found of places in map coordinates and with --local, and what else.
EXPECTED = {
    ("pyvista", "vtp"): (EXACT, EXACT, ["field data", *SHADED]),
    ("pyvista", "ply"): (SINGLES, SINGLES, SHADED),
    ("pyvista", "ascii.ply"): (SINGLES, SINGLES, SHADED),
    ("pyvista", "obj"): (EXACT, EXACT, ["normals"]),
    ("pyvista", "stl"): (EXACT, NONE, []),
    ("pyvista", "glb"): (SINGLES, NONE, SHADED),
    ("open3d", "ply"): (EXACT, EXACT, SHADED),
    ("open3d", "ascii.ply"): (EXACT, EXACT, SHADED),
    ("open3d", "obj"): (SINGLES, SINGLES, ["normals"]),
    ("open3d", "stl"): (EXACT, NONE, []),
    ("open3d", "glb"): (SINGLES, NONE, SHADED),
    ("pymeshlab", "ply"): (EXACT, EXACT, SHADED),
    ("pymeshlab", "ascii.ply"): (EXACT, EXACT, SHADED),
    ("pymeshlab", "obj"): (EXACT, EXACT, ["normals"]),
    ("pymeshlab", "stl"): (EXACT, NONE, []),
    ("pymeshlab", "glb"): (EXACT, NONE, SHADED),
    ("xugrid", "nc"): (EXACT, EXACT, ["colours", UTM]),
    ("uxarray", "nc"): (EXACT, EXACT, ["colours"]),
    ("geopandas", "gpkg"): (EXACT, EXACT, ["colours", UTM]),
    ("geopandas", "fgb"): (EXACT, NONE, ["colours", UTM]),
    ("qgis", "nc"): (EXACT, EXACT, MESH),
    ("qgis", "2dm"): (EXACT, EXACT, ["Bed Elevation"]),
    ("qgis", "ply"): (EXACT, EXACT, MESH),
    # Its own parser of decimals rounds the last bit of some.
    ("qgis", "ascii.ply"): (EXACT, DOUBLES, MESH),
    ("qgis", "gpkg"): (EXACT, EXACT, ["colours", UTM]),
    ("qgis", "fgb"): (EXACT, NONE, ["colours", UTM]),
}
# What local coordinates may be said to be in.
CARTESIAN = "Undefined Cartesian SRS"


# ---------------------------------------------------------------- meshes


def made(folder):
    """A raster with colours, and meshes of it: their paths by format and case, with what `simplify --json` says."""
    run(TERRABITE, "synth", folder / "heights.tif", "--size", "160x120", "--cell", "0.25", "--seed", "4", "--quiet")
    lut = {2: "0:0,100:250,300:0,900:250", 3: "0:250,50:0,400:250,900:0", 4: "0:100,1000:200"}
    source = '<SourceFilename relativeToVRT="1">heights.tif</SourceFilename>'
    bands = [f'<VRTRasterBand dataType="Float32" band="1"><SimpleSource>{source}</SimpleSource></VRTRasterBand>']
    bands += [
        f'<VRTRasterBand dataType="Byte" band="{band}"><ComplexSource>{source}<LUT>{table}</LUT></ComplexSource>'
        "</VRTRasterBand>"
        for band, table in lut.items()
    ]
    place = f"<SRS>{UTM}</SRS><GeoTransform>500000.12,0.25,0,5200000.77,0,-0.25</GeoTransform>"
    raster = folder / "colours.vrt"
    raster.write_text(f'<VRTDataset rasterXSize="160" rasterYSize="120">{place}{"".join(bands)}</VRTDataset>')
    meshes = {}
    for form in NAMES:
        for case in CASES[:1] if form in ONE_FRAME else CASES:
            path = folder / f"{case}.{form}"
            options = [*ATTRIBUTES, *OPTIONS.get(form, []), *(["--local"] if case == "local" else [])]
            report = run(TERRABITE, "simplify", raster, path, "--max-error", "0.5", "--json", *options)
            meshes[form, case] = path, json.loads(report)
    return meshes


def run(*command):
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"readers: {' '.join(str(part) for part in command)}: exit code {done.returncode}")
    return done.stdout


class Reference:
    """The mesh in map coordinates, read from text."""

    def __init__(self, path):
        lines = iter(path.read_text().splitlines())
        counts, names, kinds = {}, [], []
        for line in lines:
            match line.split():
                case ["element", what, count]:
                    counts[what] = int(count)
                case ["property", kind, name] if "face" not in counts:
                    names.append(name)
                    kinds.append(kind)
                case ["end_header"]:
                    break
        rows = [[float(word) for word in next(lines).split()] for _ in range(counts["vertex"])]
        column = {name: i for i, name in enumerate(names)}
        pick = lambda *names: [[row[column[name]] for name in names] for row in rows]
        self.places, self.normals = pick("x", "y", "z"), pick("nx", "ny", "nz")
        self.colours = pick("red", "green", "blue")
        self.triangles = [[int(word) for word in next(lines).split()][1:] for _ in range(counts["face"])]

    def in_frame(self, report, form):
        """The places as a file has them; GLB is taken where its node puts it."""
        x, y = report["map"]["offset"]
        if form == "glb":
            return [[single(p[0] - x) + x, single(p[2]), -single(p[1] - y) - y] for p in self.places]
        places = [[p[0] - x, p[1] - y, p[2]] for p in self.places]
        return [[single(c) for c in p] for p in places] if report["map"]["precision"] == "float" else places


def single(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


# ---------------------------------------------------------------- judging


def judged(found, reference, report, form):
    """What was found, in words: of places, and of all else."""
    places = reference.in_frame(report, form)
    expected = [[places[i] for i in triangle] for triangle in reference.triangles]
    by_number = "triangles" in found
    corners = [[found["places"][i] for i in t] for t in found["triangles"]] if by_number else found["corners"]
    if len(corners) != len(expected):
        return f"{len(corners)} of {len(expected)} triangles", []
    if by_number and len(found["places"]) != len(places) and form != "stl":
        return f"{len(found['places'])} of {len(places)} vertices", []
    order = matched(corners, expected)
    if order is None:
        return "other triangles", []
    pairs = [(corners[i][(first + k) % 3], expected[j][k]) for j, (i, first) in enumerate(order) for k in range(3)]
    where = in_words(pairs)
    also = list(found.get("also", []))
    vertices = [i for triangle in reference.triangles for i in triangle]
    for what in ("colours", "normals"):
        values = None
        if by_number and found.get(what):
            values = [found[what][found["triangles"][i][(first + k) % 3]] for i, first in order for k in range(3)]
        if found.get(f"{what}_of_corners"):
            values = [found[f"{what}_of_corners"][i][(first + k) % 3] for i, first in order for k in range(3)]
        if values is None:
            continue
        wanted = [getattr(reference, what)[i] for i in vertices]
        if form == "glb" and what == "normals":
            wanted = [[n[0], n[2], -n[1]] for n in wanted]
        off = max(abs(a - b) for value, want in zip(values, wanted) for a, b in zip(value, want))
        also.append(what if off <= (0 if what == "colours" else 1e-6) else f"other {what}")
    if found.get("crs"):
        also.append(found["crs"])
    if "extent" in found:
        columns = list(zip(*places))
        extent = [min(columns[0]), min(columns[1]), max(columns[0]), max(columns[1])]
        # GeoPackage has 15 digits of it.
        is_near = all(abs(a - b) < 1e-8 for a, b in zip(found["extent"], extent))
        also += [] if is_near else [f"extent {found['extent']}, not {extent}"]
    return where, also


def matched(corners, expected):
    """For each expected triangle the one found, and the number of its first corner; None if there is another."""
    near = lambda a, b: all(abs(p - q) <= 1.0 for p, q in zip(a, b))
    firsts = []
    for one, other in zip(corners, expected):
        first = [k for k in range(3) if all(near(one[(k + j) % 3], other[j]) for j in range(3))]
        if not first:
            break
        best = min(first, key=lambda k: max(math.dist(one[(k + j) % 3], other[j]) for j in range(3)))
        firsts.append(best)
    if len(firsts) == len(expected):
        return list(enumerate(firsts))
    # Another order: only where places are exact.
    turned = {}
    for i, triangle in enumerate(corners):
        for k in range(3):
            turned[tuple(tuple(triangle[(k + j) % 3]) for j in range(3))] = i, k
    order = [turned.get(tuple(tuple(corner) for corner in triangle)) for triangle in expected]
    return None if None in order or len({i for i, _ in order}) != len(order) else order


def in_words(pairs):
    off = max(abs(a - b) for found, want in pairs for a, b in zip(found, want))
    if off == 0:
        return EXACT
    is_single = all(a == single(b) for found, want in pairs for a, b in zip(found, want))
    are_singles = all(a == single(a) for found, _ in pairs for a in found)
    kind = SINGLES if is_single or are_singles else "doubles"
    return f"{kind}: off by up to {off:.2g} m"


# ---------------------------------------------------------------- the run


def opened(python, reader, form, path):
    """What a reader says, or why it says nothing."""
    command = [python, __file__, reader.__name__, form, path]
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        return None, f"no answer in {SECONDS} s"
    if done.returncode < 0:
        return None, "ended abnormally"
    if done.returncode > 0:
        return None, f"refused: {(done.stderr.strip().splitlines() or ['no reason'])[-1]}"
    return json.loads(done.stdout.splitlines()[-1]), None


def python_of_readers():
    """The Python of an environment with the readers."""
    named = os.environ.get("READERS_PYTHON")
    if named:
        return named
    if not PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1]:
        first, last, here = (".".join(map(str, version)) for version in (*PYTHONS, sys.version_info[:2]))
        sys.exit(
            f"readers: this is Python {here}, no other is found, and what scripts/readers-requirements.txt lists is "
            f"built for Python {first} to {last} alone: install one of those (python{last}, say), with venv"
        )
    return python_with(ROOT / "scripts" / "readers-requirements.txt", TARGET / "readers")


def other_python():
    """A Python for which there are readers, where this one is older or newer."""
    names = [f"python3.{minor}" for minor in range(PYTHONS[1][1], PYTHONS[0][1] - 1, -1)] + [SYSTEM_PYTHON]
    suits = f"import ensurepip, sys, venv; sys.exit(not {PYTHONS[0]} <= sys.version_info[:2] <= {PYTHONS[1]})"
    found = (path for path in map(shutil.which, names) if path)
    return next((p for p in found if subprocess.run([p, "-c", suits], stderr=subprocess.DEVNULL).returncode == 0), None)


def there_is_qgis():
    return subprocess.run([SYSTEM_PYTHON, "-c", "import qgis.core"], stderr=subprocess.DEVNULL).returncode == 0


def main():
    if not TERRABITE.is_file():
        sys.exit(f"readers: {TERRABITE} is not there; `make test-readers` builds it, TERRABITE names another")
    if not PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1] and other_python():
        os.execv(other_python(), [other_python(), __file__])
    python, wrong = python_of_readers(), []
    with tempfile.TemporaryDirectory(prefix="terrabite-readers-") as folder:
        meshes = made(Path(folder))
        reference = Reference(meshes["ascii.ply", "map"][0])
        print(f"{run(TERRABITE, '-V').strip()}: {len(reference.triangles)} triangles\n")
        print("| reader | format | map coordinates | `--local` | also read |\n|---|---|---|---|---|")
        for reader, forms in READERS.items():
            if reader is qgis and not there_is_qgis():
                print("readers: no QGIS for /usr/bin/python3; its part is skipped", file=sys.stderr)
                continue
            for form in forms:
                row = one(SYSTEM_PYTHON if reader is qgis else python, reader, form, meshes, reference)
                expected = EXPECTED.get((reader.__name__, form))
                version, cells, also = row
                print(f"| {version} | {NAMES[form]} | {' | '.join(cells)} | {', '.join(also)} |", flush=True)
                kinds = [cell.split(":")[0] for cell in cells]
                if expected != (*kinds, also):
                    wrong.append(f"{version}, {NAMES[form]}: expected {expected}, found {(*kinds, also)}")
    for line in wrong:
        print(f"readers: {line}", file=sys.stderr)
    sys.exit(1 if wrong else 0)


def one(python, reader, form, meshes, reference):
    """A row: the reader with its version, what it finds in both cases, and what else in both together."""
    version, cells, also = reader.__name__, [], []
    for case in CASES:
        if (form, case) not in meshes:
            cells.append(NONE)
            continue
        path, report = meshes[form, case]
        found, reason = opened(python, reader, form, str(path))
        if found is None:
            cells.append(reason)
            continue
        version = found["version"]
        where, more = judged(found, reference, report, form)
        cells.append(where)
        if case == "local" and found.get("crs"):
            more.remove(found["crs"])
            more += [f"{found['crs']} with --local"] if found["crs"] != CARTESIAN else []
        also += [word for word in more if word not in also]
    return version, cells, also


if __name__ == "__main__":
    if len(sys.argv) == 4:
        reader = next(reader for reader in READERS if reader.__name__ == sys.argv[1])
        print(json.dumps(reader(sys.argv[3], sys.argv[2])))
    else:
        main()
