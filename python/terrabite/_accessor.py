"""``DataArray.terrabite``: the calls as methods of arrays of xarray."""

from __future__ import annotations

import functools
import os
from typing import TYPE_CHECKING, Any

import xarray

from . import _api

if TYPE_CHECKING:
    from ._tin import TIN, Verdict


@xarray.register_dataarray_accessor("terrabite")  # type: ignore[no-untyped-call, untyped-decorator, unused-ignore]
class TerrabiteAccessor:
    """What terrabite does with a ``DataArray``.

    >>> import numpy as np, xarray as xr, terrabite
    >>> dem = xr.DataArray(np.zeros((5, 7)), dims=("y", "x"), coords={"y": np.arange(5.0), "x": np.arange(7.0)})
    >>> float(dem.terrabite.simplify(max_error=1).vertices[:, 0].max())
    6.0
    """

    def __init__(self, dem: xarray.DataArray) -> None:
        """Of an array; xarray makes it."""
        self._dem = dem

    @functools.wraps(_api.simplify, assigned=("__doc__",))
    def simplify(self, max_error: float | None = None, **options: Any) -> TIN:
        return _api.simplify(self._dem, max_error, **options)

    @functools.wraps(_api.verify, assigned=("__doc__",))
    def verify(self, mesh: TIN | str | os.PathLike[str], /, max_error: float, **options: Any) -> Verdict:
        return _api.verify(self._dem, mesh, max_error, **options)
