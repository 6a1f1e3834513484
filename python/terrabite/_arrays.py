"""Arrays: of numpy, masked ones, and those of xarray, whose owner is taken at his word."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _facts, _terrabite

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Types of samples that are read as they are.
DTYPES = ("uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64")

#: How far a row or column may be from where even ones are, in cells.
ROUNDING_CELLS = 0.01

#: The same beyond which coordinates are uneven.
UNEVEN_CELLS = 0.1


def ready(array: Any) -> NDArray[Any]:
    """The array itself where it can be borrowed, else a copy of it in C order and the machine's byte order."""
    values: NDArray[Any] = np.asarray(array)
    if values.ndim != 2:
        raise TypeError(f"expected an array of two dimensions (rows, columns), found {values.ndim}: index or squeeze it")
    if values.dtype == np.float16:
        values = values.astype(np.float32)
    if values.dtype.name not in DTYPES:
        way = 'astype("uint8")' if values.dtype == np.bool_ else 'astype("float64")'
        raise TypeError(f"expected heights of one of the types {', '.join(DTYPES)}, found {values.dtype}: call {way}")
    # Copies only what has to be copied; rust-numpy would take an array in Fortran order by columns.
    return np.require(values, dtype=values.dtype.newbyteorder("="), requirements=["C", "A"])


def band_of(array: Any, facts: _facts.Facts, view: _facts.View) -> _terrabite.Band:
    """A band over an array, which may be masked. What is not in C order, or not of a type that is read, is copied."""
    mask = None
    if isinstance(array, np.ma.MaskedArray):
        if array.mask is not np.ma.nomask:
            mask = np.require(np.ma.getmaskarray(array), dtype=np.bool_, requirements=["C", "A"])
        array = array.data
    values = ready(array)
    facts.dtypes = [values.dtype.name]
    facts.size = (values.shape[1], values.shape[0])
    facts.mask_flags = (mask is None, False, False, False)
    return _terrabite.Band.of_array(values, mask, facts, view)


def is_data_array(raster: object) -> bool:
    """Whether it is an array of xarray; xarray is not imported for the question."""
    xarray = sys.modules.get("xarray")
    return xarray is not None and isinstance(raster, xarray.DataArray)


def of_data_array(dem: Any) -> tuple[Any, _facts.Facts]:
    """The values of an ``xarray.DataArray`` in rows and columns, and what it says of them."""
    if dem.ndim > 2:
        dem = dem.squeeze(drop=True)
    if dem.ndim != 2:
        raise TypeError(f"expected two dimensions, found {dem.dims}: choose with isel or sel")
    down, across = _dimensions(dem)
    dem = dem.transpose(down, across)
    mapping = _grid_mapping(dem)
    crs, esri_wkt = _facts.crs_text(mapping.get("crs_wkt") or mapping.get("spatial_ref") or None)
    attributes = dem.attrs
    facts = _facts.Facts(
        name=str(dem.name or "array"),
        size=(dem.shape[1], dem.shape[0]),
        dtypes=[dem.dtype.name],
        # What is in `encoding` was applied when the file was read; what is in `attrs` was not.
        scale=float(attributes.get("scale_factor", 1.0)),
        offset=float(attributes.get("add_offset", 0.0)),
        nodata=_first(attributes, ("_FillValue", "missing_value", "nodata")),
        transform=_transform(dem, down, across, mapping.get("GeoTransform")),
        crs=crs,
        esri_wkt=esri_wkt,
        unit=str(attributes.get("units", "")),
        description=str(attributes.get("long_name", "")),
    )
    return dem.values, facts


def _first(attributes: Mapping[str, Any], names: Sequence[str]) -> Any:
    found = next((attributes[name] for name in names if attributes.get(name) is not None), None)
    return found.item() if isinstance(found, np.generic | np.ndarray) else found


def _dimensions(dem: Any) -> tuple[str, str]:
    """The dimensions of rows and of columns."""
    for down, across in (("y", "x"), ("lat", "lon"), ("latitude", "longitude"), ("northing", "easting")):
        if {down, across} == set(dem.dims):
            return down, across
    first, second = dem.dims
    return first, second


def _grid_mapping(dem: Any) -> Mapping[str, Any]:
    name = dem.encoding.get("grid_mapping") or dem.attrs.get("grid_mapping") or "spatial_ref"
    return dem.coords[name].attrs if name in dem.coords else {}


def _axis(dem: Any, name: str) -> tuple[float, float] | None:
    """Where the first row or column is, and how far the next one is from it."""
    if name not in dem.coords:
        return None
    values = np.asarray(dem.coords[name].values)
    if values.ndim != 1 or len(values) < 2 or values.dtype.kind not in "iuf":
        return None
    places = values.astype(np.float64)
    step = (places[-1] - places[0]) / (len(places) - 1)
    off = np.abs(places - (places[0] + step * np.arange(len(places))))
    if step == 0 or not np.all(off <= UNEVEN_CELLS * abs(step)):
        at = int(np.argmax(off))
        raise _terrabite.RasterError(
            f"expected rows and columns within a tenth of a cell of even ones, found '{name}' uneven at index {at}"
        )
    return float(places[0]), float(step)


def _transform(dem: Any, down: str, across: str, said: str | None) -> _facts.Coefficients | None:
    """The geotransform that the array says, where rows and columns are still there; else that of its coordinates."""
    (y, x) = (_axis(dem, down), _axis(dem, across))
    words = said.split() if isinstance(said, str) else []
    exact = _facts.coefficients([float(word) for word in words]) if len(words) == 6 else None
    if x is None or y is None:
        return exact
    found = (x[0] - x[1] / 2, x[1], 0.0, y[0] - y[1] / 2, 0.0, y[1])
    if exact is None:
        return found
    (rows, columns), (dx, dy) = dem.shape, (abs(x[1]), abs(y[1]))
    far = [
        abs(exact[0] + exact[1] / 2 - x[0]) / dx,
        abs(exact[0] + exact[1] * (columns - 0.5) - (x[0] + x[1] * (columns - 1))) / dx,
        abs(exact[3] + exact[5] / 2 - y[0]) / dy,
        abs(exact[3] + exact[5] * (rows - 0.5) - (y[0] + y[1] * (rows - 1))) / dy,
    ]
    is_straight = exact[2] == exact[4] == 0
    return exact if is_straight and max(far) <= ROUNDING_CELLS else found
