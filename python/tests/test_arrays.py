"""Arrays: borrowed where they can be, copied where they must, refused with a way out; results that numpy owns."""

from __future__ import annotations

import threading
import time
import tracemalloc

import numpy as np
import pytest
import terrabite as tb
from conftest import hills

DTYPES = ["uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64"]


def same(one: tb.TIN, other: tb.TIN) -> bool:
    return np.array_equal(one.vertices, other.vertices) and np.array_equal(one.triangles, other.triangles)


def test_a_mesh_is_within_the_tolerance_and_covers_all(dem):
    tin = tb.simplify(dem, max_error=2)
    assert tin.vertices.dtype == np.float64 and tin.vertices.shape[1:] == (3,)
    assert tin.triangles.dtype == np.uint32 and tin.triangles.shape[1:] == (3,)
    assert tin.triangles.max() == len(tin.vertices) - 1
    assert 0 < tin.max_error <= 2 == tin.tolerance
    assert tin.crs is None and tin.transform is None
    assert tb.verify(dem, tin, max_error=2)
    # Vertices have the heights of their samples, at x = column + ½, y = −(row + ½), and triangles turn left.
    columns, rows = (tin.vertices[:, 0] - 0.5).astype(int), (-tin.vertices[:, 1] - 0.5).astype(int)
    assert np.array_equal(dem[rows, columns], tin.vertices[:, 2])
    a, b, c = (tin.vertices[tin.triangles[:, i], :2] for i in range(3))
    doubled = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert doubled.min() > 0 and doubled.sum() / 2 == (dem.shape[0] - 1) * (dem.shape[1] - 1)


@pytest.mark.parametrize("quality", ["balanced", "none"])
def test_a_budget_is_kept_and_its_tolerance_said(dem, quality):
    tin = tb.simplify(dem, max_triangles=500, quality=quality)
    assert 450 <= len(tin.triangles) <= 500
    assert (tin.tolerance is None) == (quality == "none")
    if tin.tolerance is not None:
        assert tb.verify(dem, tin, max_error=tin.tolerance).passed
        assert same(tin, tb.simplify(dem, max_error=tin.tolerance))


@pytest.mark.parametrize("dtype", DTYPES)
def test_every_type_is_read_as_it_is(dem, dtype):
    small = np.round(dem / 4).astype(dtype)
    assert same(tb.simplify(small, 1), tb.simplify(small.astype("float64"), 1))


def test_a_borrowed_array_is_not_copied():
    dem = hills(1500, 2000).astype("float32")
    tb.simplify(dem[:64, :64].copy(), 5)
    tracemalloc.start()
    tb.simplify(dem, 50, quality="none", threads=1)
    _, peak = tracemalloc.get_traced_memory()
    tb.simplify(np.asfortranarray(dem), 50, quality="none", threads=1)
    _, copied = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # numpy tells what it allocates.
    assert peak < dem.nbytes / 10 and copied > dem.nbytes


def test_everything_else_is_copied_and_means_the_same(dem):
    expected = tb.simplify(dem, 2)
    wide = np.zeros((2 * dem.shape[0], 3 * dem.shape[1]))
    wide[::2, ::3] = dem
    frozen = dem.copy()
    frozen.flags.writeable = False
    shifted = np.frombuffer(b"x" + dem.tobytes(), dtype=np.uint8)[1:].view("float64").reshape(dem.shape)
    assert not shifted.flags.aligned
    for other in (dem.astype(">f8"), wide[::2, ::3], np.asfortranarray(dem), frozen, dem[::-1][::-1], shifted):
        assert same(tb.simplify(other, 2), expected)
    assert same(tb.simplify(dem.astype("float16"), 2), tb.simplify(dem.astype("float16").astype("float32"), 2))


def test_a_transposed_array_is_not_taken_by_columns(dem):
    # In memory the two are the same; a slice in memory order would be another terrain.
    tin = tb.simplify(dem.T, 2)
    assert tin.vertices[:, 0].max() == dem.shape[0] - 0.5
    assert tb.verify(dem.T, tin, max_error=2) and same(tin, tb.simplify(dem.T.copy(), 2))


def test_what_cannot_be_heights_is_refused_with_a_way_out(dem):
    for wrong, way in [
        (dem > 200, 'astype("uint8")'),
        (dem.astype(complex), 'astype("float64")'),
        (dem.astype("longdouble"), 'astype("float64")'),
        (dem.astype(str), 'astype("float64")'),
        (dem[0], "two dimensions"),
        (np.stack([dem, dem]), "two dimensions"),
        (7, "two dimensions"),
    ]:
        with pytest.raises(TypeError) as refused:
            tb.simplify(wrong, 2)
        assert way in str(refused.value)


def test_masked_and_nan_are_missing_and_so_is_nodata(dem):
    lake = (np.hypot(*np.mgrid[-45:45, -60:60])) < 12
    by_mask = tb.simplify(np.ma.MaskedArray(dem, lake), 2)
    by_nan = tb.simplify(np.where(lake, np.nan, dem), 2)
    by_mark = tb.simplify(np.where(lake, -9999, dem), 2, nodata=-9999)
    by_words = tb.simplify(np.where(lake, -1, dem), 2, nodata=["-9999", -1])
    by_range = tb.simplify(np.where(lake, -1e20, dem), 2, valid_range=(0, 1000))
    assert by_mask.report["missing_samples"] == lake.sum()
    assert all(same(by_mask, other) for other in (by_nan, by_mark, by_words, by_range))
    assert tb.verify(np.ma.MaskedArray(dem, lake), by_mask, max_error=2)
    assert not tb.verify(dem, by_mask, max_error=2)
    # The mask may be strided, and the data, too.
    assert same(tb.simplify(np.ma.MaskedArray(dem, lake)[:, ::2], 2), tb.simplify(np.where(lake, np.nan, dem)[:, ::2], 2))
    assert same(tb.simplify(np.ma.MaskedArray(dem), 2), tb.simplify(dem, 2))


def test_results_belong_to_numpy_and_are_read_only(dem):
    tin = tb.simplify(dem, 2)
    vertices, triangles = tin.vertices, tin.triangles
    assert tin.vertices is vertices and not vertices.flags.writeable and not triangles.flags.writeable
    assert vertices.flags.c_contiguous and triangles.flags.c_contiguous
    expected = vertices.copy()
    del tin
    tb.simplify(dem, 1)
    assert np.array_equal(vertices, expected)
    with pytest.raises(ValueError, match="read-only"):
        vertices[0] = 0


def test_place_and_crs_of_an_array(dem):
    tin = tb.simplify(dem, 2, transform=(500_000, 10, 0, 5_200_000, 0, -10), crs="EPSG:32633")
    assert tin.crs == "EPSG:32633" and tin.transform == (500_000, 10, 0, 5_200_000, 0, -10)
    assert tin.vertices[:, 0].min() == 500_005 and tin.vertices[:, 1].max() == 5_199_995
    part = tb.simplify(dem, 2, transform=tin.transform, window=(10, 20, 30, 40))
    assert part.vertices[:, :2].min(axis=0).tolist() == [500_105, 5_200_000 - 595]
    box = tb.simplify(dem, 2, transform=tin.transform, bbox=(500_100, 5_199_400, 500_400, 5_199_800))
    assert same(box, part)


def test_attributes_and_importance(dem):
    slope = np.hypot(*np.gradient(dem)).astype("float32")
    tin = tb.simplify(dem, 4, attributes={"slope": slope})
    columns, rows = (tin.vertices[:, 0] - 0.5).astype(int), (-tin.vertices[:, 1] - 0.5).astype(int)
    assert list(tin.attributes) == ["slope"] and np.array_equal(tin.attributes["slope"], slope[rows, columns])
    assert tb.verify(dem, tin, max_error=4, attributes={"slope": slope})
    weights = np.where(np.arange(dem.shape[1]) < 60, 8.0, 1.0) * np.ones_like(dem)
    weighted = tb.simplify(dem, 4, importance=weights)
    assert weighted.report["importance"]["max_weighted_error"] <= 4
    assert tb.verify(dem, weighted, max_error=4, importance=weights)
    assert not tb.verify(dem, tb.simplify(dem, 4), max_error=4, importance=weights)


def test_threads_of_python_work_at_the_same_time():
    dem, found = hills(200, 300), []
    expected = tb.simplify(dem, 1)
    workers = [threading.Thread(target=lambda: found.append(tb.simplify(dem, 1, threads=2))) for _ in range(4)]
    ticks = 0
    for worker in workers:
        worker.start()
    while any(worker.is_alive() for worker in workers):
        # The interpreter is free meanwhile.
        time.sleep(0.001)
        ticks += 1
    assert len(found) == 4 and all(same(tin, expected) for tin in found) and ticks > 20
