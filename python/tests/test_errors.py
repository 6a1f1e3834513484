"""Options and what they may be; exceptions, and what they say."""

from __future__ import annotations

import inspect
import subprocess

import numpy as np
import pytest
import terrabite as tb


@pytest.mark.parametrize(
    "options",
    [
        {"max_error": -1},
        {"max_error": float("nan")},
        {"max_error": float("inf")},
        {"max_error": 1, "quality": "good"},
        {"max_error": 1, "engine": "delaunay"},
        {"max_error": 1, "heights": "mean"},
        {"max_error": 1, "max_stray": 0.5},
        {"max_error": 1, "min_angle": 61},
        {"max_error": 1, "trim": 2000},
        {"max_error": 1, "threads": 0},
        {"max_error": 1, "threads": -1},
        {"max_error": 1, "tile": -1},
        {"max_error": 1, "window": (-1, 0, 10, 10)},
        {"max_triangles": -1},
        {"max_error": 1, "attributes": {"a": np.ones((90, 120))}, "attribute_weight": 2},
        {"max_error": 1, "valid_range": (2, 1)},
        {"max_error": 1, "valid_range": (2, 3, 4)},
        {"max_error": 1, "window": (0, 0, 1000, 10)},
        {"max_error": 1, "window": (0, 0, 10, 10), "bbox": (0, 0, 1, 1)},
        {"max_error": 1, "bbox": (1e6, 1e6, 2e6, 2e6)},
        {"max_error": 1, "bbox_crs": "EPSG:4326"},
        {"max_error": 1, "bbox": (0, 0, 1, 1), "bbox_crs": "EPSG:4326"},
        {"max_error": 1, "polish_places": 5},
        {"max_error": 1, "polish_caps": []},
        {"max_error": 1, "polish_rows": "some"},
        {"max_error": 1, "polish_edges": "good"},
        {"max_error": 1, "polish_passes": -1},
        {"max_error": 1, "quality": "none", "polish_passes": 1},
        {"max_error": 1, "nodata": "high"},
        {"max_error": 1, "transform": (0, 1, 0)},
        {"max_error": 1, "transform": (0, 1, 0), "crs": "EPSG:32633"},
        {"max_error": 1, "engine": "greedy-cuts", "swap": "data-dependent"},
        {"max_error": 1, "shape": "smallest-angle"},
        {"max_error": 1, "attribute_weight": 0.5},
        {"max_error": 1, "quality": "none", "heights": "fitted"},
    ],
)
def test_values_that_cannot_be_used(dem, options):
    with pytest.raises(ValueError):
        tb.simplify(dem, **options)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"max_error": "5"},
        {"max_error": 1, "tile": 2.5},
        {"max_error": 1, "quality": 3},
        {"max_error": 1, "nodata": True},
        {"max_error": 1, "band": 2},
        {"max_error": 1, "image": True},
        {"max_error": 1, "polish_passes": "3"},
        {"max_error": 1, "polish_pass": 3},
        {"max_error": 1, "oo": {"a": 1}},
        {"max_error": 1, "attributes": [1]},
        {"max_error": 1, "no_such_option": 1},
        {"max_error": 1, "crs": 2.5},
    ],
)
def test_types_that_cannot_be_used(dem, options):
    with pytest.raises(TypeError):
        tb.simplify(dem, **options)


def test_messages_begin_with_the_option(dem):
    for options in ({"max_error": "5"}, {"max_error": 5, "quality": "good"}, {"max_error": 5, "memory": -1}, {"max_error": 5, "window": (1, 2)}):
        with pytest.raises((TypeError, ValueError)) as refused:
            tb.simplify(dem, **options)
        assert str(refused.value).startswith(f"{[*options][-1]}: ")


def test_attributes_and_polygons_that_are_none(dem):
    with pytest.raises(ValueError, match="attributes: expected arrays of the shape"):
        tb.simplify(dem, 1, attributes={"red": dem[:5]})
    with pytest.raises(ValueError, match="attributes: expected one array or more"):
        tb.simplify(dem, 1, attributes={})
    nothing = ([], {"type": "FeatureCollection", "features": []}, {"type": "Feature", "geometry": None})
    for cutline in nothing:
        with pytest.raises(ValueError, match="cutline: expected polygons, found none"):
            tb.simplify(dem, 1, cutline=cutline)


def test_data_that_cannot_be_meshed(dem):
    with pytest.raises(tb.RasterError, match="no ground"):
        tb.simplify(np.full((9, 9), np.nan), 1)
    with pytest.raises(tb.RasterError, match="at least 2 × 2"):
        tb.simplify(np.zeros((1, 9)), 1)
    with pytest.raises(tb.RasterError):
        tb.simplify(np.where(dem > 200, np.inf, dem), 1)
    with pytest.raises(tb.RasterError):
        tb.simplify(np.full((9, 9), 2**60), 1)
    with pytest.raises(tb.RasterError, match="map"):
        tb.simplify(dem, 1, transform=(0, 1, 1, 0, 1, 1))
    with pytest.raises(tb.RasterError, match="128 × 128|size"):
        tb.simplify(dem, 1, importance=np.ones((128, 128)))
    with pytest.raises(tb.ResourceError):
        tb.simplify(dem, 1, memory=1000)
    assert issubclass(tb.RasterError, tb.Error) and issubclass(tb.Error, Exception)
    assert all(error.__module__ == "terrabite" for error in (tb.Error, tb.RasterError, tb.Cancelled))


def test_edges_have_the_heights_of_lines():
    dem = np.add.outer(np.arange(40.0), np.arange(50.0)) % 7
    dam = [np.array([[3.2, -5.1, 20.0], [40.7, -33.3, 22.0]])]
    tin = tb.simplify(dem, 1, breaklines=dam, breakline_z="line")
    assert tin.vertices[:, 2].max() >= 20 and tin.report["beside_lines"] > 50
    assert tb.verify(dem, tin, 1, breaklines=dam, breakline_z="line").passed
    assert not tb.verify(dem, tin, 1, breaklines=dam).passed
    with pytest.raises(tb.Error, match="heights"):
        tb.simplify(dem, 1, breaklines=[dam[0][:, :2]], breakline_z="line")
    with pytest.raises(ValueError, match="breakline"):
        tb.verify(dem, tin, 1, breakline_z="line")


def test_lakes_are_level():
    dem = np.add.outer(np.arange(40.0), np.arange(50.0)) % 7
    lakes = [{"type": "Polygon", "coordinates": [[(8.2, -8.4), (30.1, -9.0), (24.4, -28.8), (8.2, -8.4)]]}]
    tin = tb.simplify(dem, 1, lake_polygons=lakes, lake_z=[-3.0])
    assert tin.vertices[:, 2].min() == -3 and tin.report["samples_in_lakes"] > 100
    assert tb.verify(dem, tin, 1, lake_polygons=lakes, lake_z=[-3.0]).passed
    assert not tb.verify(dem, tin, 1, lake_polygons=lakes, lake_z="median").passed
    with pytest.raises(ValueError, match="lake_z: expected 1 heights, found 2"):
        tb.simplify(dem, 1, lake_polygons=lakes, lake_z=[1, 2])


def test_edges_follow_outlines():
    dem = np.add.outer(np.arange(40.0), np.arange(50.0)) % 7
    roof = {"type": "Polygon", "coordinates": [[(8.2, -8.4), (30.1, -9.0), (24.4, -28.8), (8.2, -8.4)]]}
    tin = tb.simplify(dem, 1, footprints=roof)
    assert tin.report["footprints"]["chains"]["edges"] >= 3
    assert tb.verify(dem, tin, 1, footprints=roof).passed
    assert not tb.verify(dem, tb.simplify(dem, 1), 1, footprints=roof).passed
    with pytest.raises(ValueError, match="footprints: expected polygons"):
        tb.simplify(dem, 1, footprints=[])


def test_the_mesh_ends_at_outlines():
    dem = np.add.outer(np.arange(40.0), np.arange(50.0)) % 7
    # Not closed.
    area = {"type": "Polygon", "coordinates": [[(8.25, -8.5), (30.25, -8.5), (24.5, -28.75)]]}
    tin = tb.simplify(dem, 1, cutline=area, cutline_exact=True)
    a, b, c = (tin.vertices[tin.triangles[:, i], :2] for i in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    double = (ux * vy - uy * vx).sum()
    assert abs(double - 22 * 20.25) < 8 and tin.report["exact_cutline"]["chains"]["edges"] >= 3
    assert tb.verify(dem, tin, 1, cutline=area, cutline_exact=True).passed
    assert not tb.verify(dem, tin, 1, cutline=area).passed
    assert not tb.verify(dem, tb.simplify(dem, 1, cutline=area), 1, cutline=area, cutline_exact=True).passed
    with pytest.raises(ValueError, match="cutline_exact requires cutline"):
        tb.simplify(dem, 1, cutline_exact=True)
    with pytest.raises(tb.Error, match="expected a cutline around some of the raster"):
        tb.simplify(dem, 1, cutline={"type": "Polygon", "coordinates": [[(-9, 9), (-5, 9), (-5, 5), (-9, 9)]]}, cutline_exact=True)


def test_options_have_the_names_and_defaults_of_the_command(command):
    """Those that are not there are for files: where they go, what is printed, and layers that GDAL's vector library reads."""
    of_files = {
        "input", "output", "overwrite", "quiet", "json", "dry-run", "help", "format", "ascii", "precision",
        "local", "z-scale", "texture", "texture-size", "base-height", "base-depth", "mesh-compression",
        "ogr-geometry", "cutline-layer", "points-layer", "breaklines-layer", "lake-polygons-layer", "footprints-layer", "importance-band", "importance-oo", "report",
    }
    shown = subprocess.run([command, "simplify", "--help"], capture_output=True, text=True, check=True).stdout
    names = {line.split("--")[1].split()[0].strip(",") for line in shown.splitlines() if line.strip().startswith(("--", "-q, --", "-h, --"))}
    asked = inspect.signature(tb.simplify).parameters
    ours = {name.replace("_", "-") for name in (*asked, *tb.Polishing.__annotations__)}
    missing = names - of_files - ours
    assert not missing and {"max-error", "quality", "nodata"} <= names
    assert asked["tile"].default == 512 and asked["heights"].default == "sampled" and asked["trim"].default == 0
