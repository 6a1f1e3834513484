"""Calls as users write them, for mypy alone: types are those that the documentation says."""

import pathlib
import threading

import numpy as np
import terrabite as tb
from numpy.typing import NDArray


def simplified(heights: NDArray[np.float32]) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    tin: tb.TIN = tb.simplify(heights, max_error=5, nodata=[-9999, "nan"], quality="fast", cancel=threading.Event())
    error: float = tin.max_error
    crs: str | None = tin.crs
    assert error <= 5 and crs is None
    tin.write(pathlib.Path("out.glb"), overwrite=True)["loss"]
    return tin.vertices, tin.triangles


def judged(path: pathlib.Path) -> bool:
    verdict = tb.verify(path, "tin.ply", max_error=5, progress=lambda stage, done, total: print(stage, done / total))
    failures: list[str] = verdict.failures
    return verdict.passed and not failures


def refused(heights: NDArray[np.float32]) -> None:
    tb.simplify(heights, max_error=5, quality="good")  # type: ignore[arg-type]
    tb.simplify(heights, max_error="5")  # type: ignore[arg-type]
    tb.simplify(heights, no_such_option=1)  # type: ignore[call-arg]
