"""Whatever the heights: within the tolerance, certified, the same whatever the threads; and nothing is left behind."""

from __future__ import annotations

import gc
import resource

import hypothesis.extra.numpy as of_numpy
import numpy as np
import pytest
import terrabite as tb
from conftest import hills, is_long
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

SHAPES = of_numpy.array_shapes(min_dims=2, max_dims=2, min_side=2, max_side=24)
HEIGHTS = st.floats(-1000, 1000, width=32)
EXAMPLES = settings(
    max_examples=400 if is_long() else 40,
    # The same every time in `make test`, others every time in `make test-long`.
    derandomize=not is_long(),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    database=None,
)


@EXAMPLES
@given(
    heights=of_numpy.arrays("float32", SHAPES, elements=HEIGHTS),
    holes=st.floats(0, 0.4),
    tolerance=st.sampled_from([0.0, 0.5, 100.0, 5000.0]),
    quality=st.sampled_from(["none", "fast", "balanced"]),
    tile=st.sampled_from([0, 5, 512]),
)
def test_every_mesh_is_certified(heights, holes, tolerance, quality, tile):
    heights = np.where(np.random.default_rng(heights.size).random(heights.shape) < holes, np.nan, heights)
    try:
        tin = tb.simplify(heights, tolerance, quality=quality, tile=tile, threads=1)
    except tb.RasterError as error:
        assert "no ground" in str(error)
        return
    assert tin.max_error <= tolerance
    verdict = tb.verify(heights, tin, tolerance)
    assert verdict.passed, verdict.failures
    other = tb.simplify(np.asfortranarray(heights), tolerance, quality=quality, tile=tile, threads=2)
    assert np.array_equal(tin.vertices, other.vertices) and np.array_equal(tin.triangles, other.triangles)


@EXAMPLES
@given(
    stored=of_numpy.arrays(st.sampled_from(["uint8", "int16", "uint32", "int64"]), SHAPES, elements=st.integers(0, 100)),
    nodata=st.integers(0, 100),
)
def test_nodata_of_integers_is_missing(stored, nodata):
    heights = np.where(stored == nodata, np.nan, stored.astype("float64"))
    found = []
    for raster, options in ((stored, {"nodata": nodata}), (heights, {})):
        try:
            tin = tb.simplify(raster, 3, threads=1, **options)
            found.append((tin.vertices.tolist(), tin.triangles.tolist(), tin.report["missing_samples"]))
        except tb.RasterError as error:
            found.append(str(error))
    assert found[0] == found[1]


@pytest.mark.parametrize("call", ["simplify", "fails", "verify"])
def test_a_thousand_calls_leave_nothing_behind(call):
    dem = hills(40, 50).astype("float32")
    tin = tb.simplify(dem, 3)

    def once() -> None:
        if call == "verify":
            assert tb.verify(dem, tin, 3, threads=1)
        elif call == "simplify":
            tb.simplify(dem, 3, quality="none", threads=1)
        else:
            with pytest.raises(tb.RasterError):
                tb.simplify(np.full((40, 50), np.nan), 3, threads=1)

    def resident() -> int:
        gc.collect()
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * resource.getpagesize()

    for _ in range(100):
        once()
    before, objects = resident(), len(gc.get_objects())
    for _ in range(1000 if call == "simplify" or is_long() else 200):
        once()
    # A call whose arrays stayed would leave 8 kB of heights and more.
    assert resident() - before < 4 << 20 and len(gc.get_objects()) - objects < 500
