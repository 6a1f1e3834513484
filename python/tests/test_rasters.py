"""Rasters through rasterio, and arrays of xarray: what is missing, where they lie, and the same bytes as the command."""

from __future__ import annotations

import json
import tracemalloc
import types
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
import terrabite as tb
import xarray as xr
from conftest import hills, run
from rasterio.enums import ColorInterp
from rasterio.transform import Affine

UTM = {"crs": "EPSG:32633", "transform": Affine(10, 0, 500_000, 0, -10, 5_200_000)}


def make(path: Path, *bands: Any, **profile: Any) -> Path:
    """A GeoTIFF with these bands. Masks, tags and so on: what `also` does with the open dataset."""
    also = profile.pop("also", lambda dataset: None)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rows, columns = bands[0].shape
        with rasterio.open(
            path, "w", driver="GTiff", width=columns, height=rows, count=len(bands), dtype=bands[0].dtype, **profile
        ) as dataset:
            for number, band in enumerate(bands, 1):
                dataset.write(band, number)
            also(dataset)
    return path


LAKE = np.hypot(*np.mgrid[-45:45, -60:60]) < 12
WET = np.where(LAKE, -9999, hills())


def scaled(dataset: Any) -> None:
    dataset.scales, dataset.offsets, dataset.units = (0.1,), (50.0,), ("m",)


def alpha(dataset: Any) -> None:
    dataset.colorinterp = (ColorInterp.gray, ColorInterp.alpha)


def masked(dataset: Any) -> None:
    dataset.write_mask(~LAKE)


CUSTOM = "+proj=tmerc +lon_0=12.5 +k=0.9996 +x_0=500000 +ellps=GRS80 +units=m"

#: What is stored, and the options of the command.
#: Three bands of colours.
PICTURE = [(hills() / 2).astype("uint8"), hills()[::-1].astype("uint8") // 2, LAKE.astype("uint8")]

CASES: dict[str, tuple[dict[str, Any], list[str], dict[str, Any]]] = {
    "float32": ({"bands": [hills().astype("float32")], **UTM}, [], {}),
    "bytes": ({"bands": [(hills() / 2).astype("uint8")], **UTM}, [], {}),
    "int16 with a tag, compressed": (
        {"bands": [WET.astype("int16")], "nodata": -9999, "compress": "deflate", "tiled": True, "blockxsize": 32, "blockysize": 32, **UTM},
        [],
        {},
    ),
    "several marks": (
        {"bands": [np.where(hills() > 240, -32768, WET).astype("int32")], "nodata": -32768, **UTM},
        ["--nodata", "tag", "--nodata", "-9999", "--valid-range", "100,1000"],
        {"nodata": ["tag", -9999], "valid_range": (100, 1000)},
    ),
    "a mask": ({"bands": [hills().astype("float64")], "also": masked, **UTM}, [], {}),
    "a mask and a tag": (
        {"bands": [np.where(hills() > 240, -1, hills()).astype("float32")], "nodata": -1, "also": masked, **UTM},
        [],
        {},
    ),
    "alpha": (
        {"bands": [hills().astype("uint16"), np.where(LAKE, 0, 7).astype("uint16")], "also": alpha, **UTM},
        [],
        {},
    ),
    "alpha and a tag, of floats": (
        {
            "bands": [np.where(hills() > 240, -1, hills()).astype("float32"), np.where(LAKE, np.nan, 1).astype("float32")],
            "nodata": -1, "also": alpha, **UTM,
        },
        [],
        {},
    ),
    "scale and offset": ({"bands": [(10 * hills()).astype("int16")], "also": scaled, **UTM}, [], {}),
    "no CRS and no place": ({"bands": [hills().astype("uint32")]}, [], {}),
    "geographic, 64-bit": (
        {"bands": [WET.astype("int64")], "nodata": -9999, "crs": "EPSG:4326", "transform": Affine(0.01, 0, 12, 0, -0.01, 48)},
        [],
        {},
    ),
    "a CRS without a code, turned": (
        {"bands": [hills().astype("float32")], "crs": CUSTOM, "transform": Affine(9, 2, 500_000, 2, -9, 5_200_000)},
        [],
        {},
    ),
    "a window": ({"bands": [WET.astype("float32")], "nodata": -9999, **UTM}, ["--window", "7,5,80,60"], {"window": (7, 5, 80, 60)}),
    "a box": (
        {"bands": [WET.astype("float32")], "nodata": -9999, **UTM},
        ["--bbox", "500100,5199300,500900,5199900"],
        {"bbox": (500_100, 5_199_300, 500_900, 5_199_900)},
    ),
    "a box in another CRS": (
        {"bands": [WET.astype("float32")], **UTM},
        ["--bbox", "15.002,46.946,15.011,46.951", "--bbox-crs", "EPSG:4326"],
        {"bbox": (15.002, 46.946, 15.011, 46.951), "bbox_crs": "EPSG:4326"},
    ),
    "an image": ({"bands": PICTURE, "photometric": "rgb", **UTM}, ["--image"], {"image": True}),
    "bands of an image": (
        {"bands": PICTURE, "photometric": "rgb", "nodata": 7, **UTM},
        ["--image", "--attributes", "3,1", "--nodata", "9"],
        {"image": True, "attributes": [3, 1], "nodata": 9},
    ),
    "band 2 with attributes": (
        {"bands": [(hills() / 2).astype("uint8"), hills()[::-1].astype("uint8") // 2, LAKE.astype("uint8")], **UTM},
        ["--band", "2", "--attributes", "1,3"],
        {"band": 2, "attributes": [1, 3]},
    ),
}


#: Heights of quarters of a metre as colours.
COLOURS = [(((32768 + np.round(4 * hills()) / 4) * 256).astype("int64") >> shift & 255).astype("uint8") for shift in (16, 8, 0)]
CASES["heights as colours"] = (
    {"bands": COLOURS, "photometric": "rgb", **UTM},
    ["--encoding", "terrarium"],
    {"encoding": "terrarium"},
)

SQUARE = [[500_095, 5_199_105], [501_005, 5_199_205], [500_905, 5_199_905], [500_195, 5_199_805], [500_095, 5_199_105]]
WELL = [[500_405, 5_199_405], [500_505, 5_199_405], [500_505, 5_199_505], [500_405, 5_199_405]]
PLACES = [[500_323, 5_199_321], [500_777, 5_199_654], [500_777.1, 5_199_654], [400_000, 5_199_000]]


def geojson(path: Path, *geometries: dict[str, Any]) -> Path:
    features = [{"type": "Feature", "properties": {}, "geometry": geometry} for geometry in geometries]
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}}
    path.write_text(json.dumps({"type": "FeatureCollection", "crs": crs, "features": features}))
    return path


def test_polygons_and_points_as_the_command_takes_layers(tmp_path, command):
    path = make(tmp_path / "dem.tif", hills().astype("float32"), **UTM)
    area = {"type": "Polygon", "coordinates": [SQUARE, WELL]}
    cutline = geojson(tmp_path / "area.geojson", area)
    points = geojson(tmp_path / "points.geojson", *({"type": "Point", "coordinates": place} for place in PLACES))
    words = ("--max-error", 2, "--cutline", cutline, "--points", points)
    printed = run(command, "simplify", path, tmp_path / "theirs.ply", *words, "--json")
    tin = tb.simplify(path, 2, cutline=area, points=PLACES)
    tin.write(tmp_path / "ours.ply")
    body = [(tmp_path / name).read_bytes().partition(b"end_header")[2] for name in ("ours.ply", "theirs.ply")]
    assert body[0] == body[1]
    counts = {"read": 4, "used": 2, "merged": 1, "outside": 1}
    assert tin.report["points"] | counts == tin.report["points"] | {"file": "", "layer": ""}
    assert json.loads(printed)["points"] | counts == json.loads(printed)["points"]
    assert tb.verify(path, tin, 2, cutline=area) and not tb.verify(path, tin, 2)
    # Whatever brings the polygons.
    for other in (
        [area],
        {"type": "MultiPolygon", "coordinates": [[SQUARE, WELL]]},
        {"type": "GeometryCollection", "geometries": [area]},
        json.loads(cutline.read_text()),
        types.SimpleNamespace(__geo_interface__=area),
    ):
        assert same(tb.simplify(path, 2, cutline=other, points=np.asarray(PLACES)), tin)
    with pytest.raises(ValueError, match="found Point"):
        tb.simplify(path, 2, cutline={"type": "Point", "coordinates": [0, 0]})
    with pytest.raises(TypeError, match="cutline"):
        tb.simplify(path, 2, cutline=7)
    with pytest.raises(tb.RasterError, match="finite"):
        tb.simplify(path, 2, cutline={"type": "Polygon", "coordinates": [[[0, 0], [np.inf, 0], [1, 1]]]})
    with pytest.raises(ValueError, match="points"):
        tb.simplify(path, 2, points=[1, 2])
    with pytest.raises(ValueError, match="encoding"):
        tb.simplify(path, 2, encoding="terrarium", band=1)
    with pytest.raises(tb.RasterError, match="three bands of bytes"):
        tb.simplify(path, 2, encoding="terrarium")


def without_origin(ply: bytes) -> bytes:
    """A PLY without the lines that say which program made it of what."""
    end = ply.index(b"end_header")
    lines = ply[:end].split(b"\n")
    kept = [line for line in lines if not line.startswith((b"comment terrabite", b"comment source", b"comment made by"))]
    assert len(lines) - len(kept) == 2, lines
    return b"\n".join(kept) + ply[end:]


@pytest.mark.parametrize(
    ("words", "options"),
    [
        ("--polish-passes 2 --polish-caps 0.5,2 --polish-rows all", {"polish_passes": 2, "polish_caps": [0.5, 2], "polish_rows": "all"}),
        ("--polish-edges strong --polish-turns false", {"polish_edges": "strong", "polish_turns": False}),
        ("--polish-sweeps 1 --polish-reach any", {"polish_sweeps": 1, "polish_reach": float("inf")}),
        (
            "--polish-moves 1 --polish-last-sweeps 1 --polish-retry true --polish-yield 3 --polish-rounds 2 --polish-shrink 0.5"
            " --polish-steps 2 --polish-finer false --polish-thorough true --polish-steps-between 2 --polish-places 4"
            " --polish-longest-ring 9 --polish-longest-repaired 8",
            {
                "polish_moves": 1, "polish_last_sweeps": 1, "polish_retry": True, "polish_yield": 3, "polish_rounds": 2,
                "polish_shrink": 0.5, "polish_steps": 2, "polish_finer": False, "polish_thorough": True,
                "polish_steps_between": 2, "polish_places": 4, "polish_longest_ring": 9, "polish_longest_repaired": 8,
            },
        ),
    ],
)
def test_polishing_is_that_of_the_command(tmp_path, command, words, options):
    path = make(tmp_path / "dem.tif", hills().astype("float32"), **UTM)
    run(command, "simplify", path, tmp_path / "theirs.ply", "--max-error", 2, *words.split())
    tin = tb.simplify(path, 2, **options)
    tin.write(tmp_path / "ours.ply")
    assert without_origin((tmp_path / "ours.ply").read_bytes()) == without_origin((tmp_path / "theirs.ply").read_bytes())
    assert not same(tin, tb.simplify(path, 2))


@pytest.mark.parametrize("case", CASES)
def test_the_same_bytes_as_the_command(tmp_path, command, case):
    profile, words, options = CASES[case]
    profile = dict(profile)
    path = make(tmp_path / "dem.tif", *profile.pop("bands"), **profile)
    ours, theirs = tmp_path / "ours.ply", tmp_path / "theirs.ply"
    run(command, "simplify", path, theirs, "--max-error", 2, "--tile", 64, *words)
    tin = tb.simplify(path, max_error=2, tile=64, **options)
    tin.write(ours)
    assert without_origin(ours.read_bytes()) == without_origin(theirs.read_bytes())
    assert tb.verify(path, tin, 2, **options) and tb.verify(str(path), ours, 2, **options)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        dataset = rasterio.open(path)
    with dataset:
        of_dataset = tb.simplify(dataset, 2, tile=64, **options)
    assert np.array_equal(of_dataset.vertices, tin.vertices) and of_dataset.crs == tin.crs


@pytest.mark.parametrize(
    ("how", "layout"), [("windows", {"tiled": True, "blockxsize": 256, "blockysize": 256}), ("decoded", {"blockysize": 4})]
)
def test_a_path_is_read_window_by_window(tmp_path, how, layout):
    # Threads read up to 4 MiB at a time: well below 0.6 of it all, both of them.
    heights = hills(3200, 1500).astype("float32")
    path = make(tmp_path / "dem.tif", heights, **layout, **UTM)
    tracemalloc.start()
    tin = tb.simplify(path, 50, quality="none", threads=2)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # numpy tells what it allocates.
    assert tin.report["access"]["how"] == how and peak < 0.6 * heights.nbytes
    assert same(tin, tb.simplify(heights, 50, quality="none", transform=UTM["transform"]))


def test_rasters_that_cannot_be_used(tmp_path):
    with pytest.raises(tb.RasterError, match=r"none\.tif"):
        tb.simplify(tmp_path / "none.tif", 1)
    picture = [np.zeros((9, 9), "uint8") for _ in range(3)]
    path = make(tmp_path / "picture.tif", *picture, photometric="rgb", **UTM)
    with pytest.raises(tb.RasterError, match="expected heights, found red"):
        tb.simplify(path, 1)
    assert len(tb.simplify(path, 1, band=1).triangles) == 2
    with pytest.raises(ValueError, match="bands 1 to 3"):
        tb.simplify(path, 1, band=4)
    path = make(tmp_path / "complex.tif", np.zeros((9, 9), "complex64"), **UTM)
    with pytest.raises(tb.RasterError, match="complex64"):
        tb.simplify(path, 1)
    with pytest.raises(TypeError, match="for arrays"):
        tb.simplify(path, 1, crs="EPSG:32633")


def test_a_read_that_fails_is_told(tmp_path):
    path = make(tmp_path / "dem.tif", hills(300, 300).astype("float32"), compress="deflate", **UTM)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(tb.RasterError, match=r"dem\.tif"):
        tb.simplify(path, 1)


def test_warnings_of_the_rules_are_in_the_report(tmp_path):
    path = make(tmp_path / "dem.tif", np.where(LAKE, 0, hills()).astype("float32"), nodata=0, **UTM)
    codes = [warning["code"] for warning in tb.simplify(path, 2).report["warnings"]]
    assert codes == ["zero_nodata"]
    path = make(tmp_path / "far.tif", hills().astype("float32"), nodata=1e30, **UTM)
    assert tb.simplify(path, 2).report["warnings"] == []


def data_array(values: Any = None, **attributes: Any) -> xr.DataArray:
    values = hills() if values is None else values
    rows, columns = values.shape
    places = {"y": 5_199_995 - 10.0 * np.arange(rows), "x": 500_005 + 10.0 * np.arange(columns)}
    dem = xr.DataArray(values, dims=("y", "x"), coords=places, attrs=attributes)
    crs = rasterio.crs.CRS.from_epsg(32633).to_wkt()
    return dem.assign_coords(spatial_ref=xr.DataArray(0, attrs={"crs_wkt": crs, "GeoTransform": "500000 10 0 5200000 0 -10"}))


def same(one: tb.TIN, other: tb.TIN) -> bool:
    return np.array_equal(one.vertices, other.vertices) and np.array_equal(one.triangles, other.triangles)


def test_an_array_of_xarray_says_where_it_lies():
    expected = tb.simplify(hills(), 2, transform=UTM["transform"], crs="EPSG:32633")
    dem = data_array()
    tin = dem.terrabite.simplify(max_error=2)
    assert same(tin, expected) and tin.crs == "EPSG:32633" and tin.transform == (500_000, 10, 0, 5_200_000, 0, -10)
    assert dem.terrabite.verify(tin, max_error=2).passed
    # Whatever the order of dimensions, and with one of length 1.
    assert same(tb.simplify(dem.transpose("x", "y"), 2), expected)
    assert same(tb.simplify(dem.expand_dims("band"), 2), expected)
    # A part lies where it is, whatever its grid mapping says.
    part = tb.simplify(dem[20:60, 10:], 2)
    assert part.vertices[:, :2].min(axis=0).tolist() == [500_105, 5_199_405]
    assert same(tb.simplify(dem.drop_vars("spatial_ref"), 2), expected)
    upwards = tb.simplify(dem[::-1], 2)
    assert upwards.transform[5] == 10 and tb.verify(dem[::-1], upwards, 2)
    with pytest.raises(tb.RasterError, match="uneven"):
        tb.simplify(dem[[0, 1, 2, 5, 6]], 2)


def test_what_is_in_attrs_applies_and_what_is_in_encoding_does_not():
    expected = tb.simplify(np.where(LAKE, np.nan, 0.5 * hills() + 10), 2, transform=UTM["transform"])
    stored = data_array(np.where(LAKE, -1, hills()), _FillValue=-1, scale_factor=0.5, add_offset=10.0)
    assert np.array_equal(tb.simplify(stored, 2).vertices, expected.vertices)
    applied = data_array(np.where(LAKE, np.nan, 0.5 * hills() + 10))
    applied.encoding = {"_FillValue": -1, "scale_factor": 0.5, "add_offset": 10.0}
    assert np.array_equal(tb.simplify(applied, 2).vertices, expected.vertices)


def test_what_rioxarray_opens(tmp_path):
    rioxarray = pytest.importorskip("rioxarray")
    path = make(tmp_path / "dem.tif", WET.astype("float32"), nodata=-9999, **UTM)
    expected = tb.simplify(path, 2)
    for is_masked in (False, True):
        with rioxarray.open_rasterio(path, masked=is_masked) as dem:
            tin = dem.terrabite.simplify(max_error=2)
        assert same(tin, expected) and tin.crs == "EPSG:32633", is_masked
