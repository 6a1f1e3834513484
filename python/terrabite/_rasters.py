"""Rasters that rasterio opens: what they say, and their stored values, window by window."""

from __future__ import annotations

import os
import threading
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _facts, _terrabite

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: What GDAL calls colours, and the library does.
COLOURS = {"y": "luminance", "cb": "chrominance", "cr": "chrominance", "gray": None, "grey": None, "undefined": None}

#: Subdatasets named in a message, at most.
NAMED = 12

#: Warnings are caught for the whole process, so one dataset is opened at a time.
_OPENING = threading.Lock()


def is_dataset(raster: object) -> bool:
    """Whether it is an open dataset of rasterio, or behaves like one."""
    return all(hasattr(raster, name) for name in ("read", "read_masks", "mask_flag_enums", "block_shapes", "colorinterp"))


class _Raster:
    """Reads windows through datasets: a pool of them for a path, one under a lock for a dataset of the user."""

    def __init__(self, path: str | None, dataset: Any, oo: dict[str, Any]) -> None:
        self._path, self._oo = path, oo
        self._free = [dataset]
        self._only = threading.Lock() if path is None else None

    def _open(self) -> Any:
        assert self._path is not None
        return _open(self._path, self._oo)[0]

    def _with_dataset(self, read: Any) -> NDArray[Any]:
        if self._only is not None:
            with self._only:
                return np.ascontiguousarray(read(self._free[0]))
        # A dataset serves one thread at a time, and whoever comes next keeps its blocks.
        try:
            dataset = self._free.pop()
        except IndexError:
            dataset = self._open()
        found = np.ascontiguousarray(read(dataset))
        self._free.append(dataset)
        return found

    def read(self, band: int, column: int, row: int, width: int, height: int) -> NDArray[Any]:
        """Stored values of a window."""
        window = ((row, row + height), (column, column + width))
        return self._with_dataset(lambda dataset: dataset.read(band, window=window))

    def release(self) -> None:
        """Closes what is held, where it can be opened again."""
        while self._only is None and self._free:
            try:
                self._free.pop().close()
            except IndexError:
                break


class _Band:
    """One band of it: adds the mask, which is one of each band."""

    def __init__(self, raster: _Raster, number: int) -> None:
        self.read, self.release = raster.read, raster.release
        self._raster, self._number = raster, number

    def read_mask(self, column: int, row: int, width: int, height: int) -> NDArray[np.uint8]:
        """GDAL's mask of a window: 0 where nothing is there."""
        window = ((row, row + height), (column, column + width))
        read = self._raster._with_dataset
        mask: NDArray[np.uint8] = read(lambda dataset: dataset.read_masks(self._number, window=window))
        return mask


def _open(path: str, oo: dict[str, Any]) -> tuple[Any, bool]:
    """A dataset, and whether it has a geotransform."""
    try:
        import rasterio
        from rasterio.errors import NotGeoreferencedWarning, RasterioError, RasterioIOError
    except ImportError as error:
        raise ImportError(
            f"{path}: paths are opened with rasterio (pip install rasterio); arrays need nothing but numpy"
        ) from error
    try:
        with _OPENING, warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            dataset = rasterio.open(path, sharing=False, **oo)
            # Asked here, as it is what tells an identity from nothing.
            _ = dataset.transform
    except (RasterioIOError, RasterioError, OSError) as error:
        raise _terrabite.RasterError(f"{path}: cannot be opened as a raster: {error}") from error
    missing = any(issubclass(warning.category, NotGeoreferencedWarning) for warning in said)
    return dataset, not missing


def _colour(interpretation: Any) -> str | None:
    name = str(interpretation.name).lower()
    return COLOURS.get(name, name)


def _colour_table(dataset: Any, band: int) -> list[tuple[int, int, int]] | None:
    try:
        table = dataset.colormap(band)
    except ValueError:
        return None
    return [tuple(table[entry][:3]) for entry in sorted(table)]


def _elsewhere(dataset: Any) -> str | None:
    """What else than a geotransform places it on the map, in words."""
    points = len(dataset.gcps[0])
    if points:
        return f"{points} ground control points"
    if dataset.rpcs is not None:
        return "rational polynomial coefficients (RPC)"
    return "geolocation arrays" if dataset.tags(ns="GEOLOCATION") else None


def _facts_of(dataset: Any, name: str, band: int, has_transform: bool) -> _facts.Facts:
    if dataset.count == 0:
        named = ", ".join(f"'{sub}'" for sub in dataset.subdatasets[:NAMED])
        hint = f"; it holds subdatasets, give the name of one in place of the file's: {named}" if named else ""
        raise _terrabite.RasterError(f"{name}: expected a raster band, found none{hint}")
    if not 1 <= band <= dataset.count:
        raise ValueError(f"{name}: expected band {band}, found bands 1 to {dataset.count}")
    at = band - 1
    crs, esri_wkt = _facts.crs_text(dataset.crs)
    flags = {flag.name for flag in dataset.mask_flag_enums[at]}
    down, across = dataset.block_shapes[at]
    return _facts.Facts(
        name=name,
        size=(dataset.width, dataset.height),
        dtypes=list(dataset.dtypes),
        band=band,
        driver=dataset.driver,
        colours=[_colour(interpretation) for interpretation in dataset.colorinterp],
        colour_table=_colour_table(dataset, band),
        block=(across, down),
        scale=dataset.scales[at],
        offset=dataset.offsets[at],
        nodata=dataset.nodatavals[at],
        mask_flags=("all_valid" in flags, "per_dataset" in flags, "alpha" in flags, "nodata" in flags),
        transform=_facts.coefficients(dataset.transform) if has_transform else None,
        elsewhere=None if has_transform else _elsewhere(dataset),
        crs=crs,
        esri_wkt=esri_wkt,
        unit=dataset.units[at] or "",
        description=dataset.descriptions[at] or "",
        pixel_is=dataset.tags().get("AREA_OR_POINT", ""),
    )


def bands_of(
    raster: str | os.PathLike[str] | Any, view: _facts.View, further: list[int], image: bool = False
) -> tuple[_terrabite.Band, list[_terrabite.Band], tuple[float, ...] | None]:
    """The band that is looked at, further ones of the same raster, whose nodata tags are their own, and its transform.

    Of an image, further bands are all where none are named, and the first of them is looked at. What marks its samples marks
    those of all its bands.
    """
    if isinstance(raster, str | os.PathLike):
        path = os.fspath(raster)
        dataset, has_transform = _open(path, view.oo)
        reader, name = _Raster(path, dataset, view.oo), path
    else:
        dataset, name = raster, str(raster.name) or "a dataset"
        has_transform = not _is_identity(raster)
        reader = _Raster(None, dataset, {})
    view.is_named = view.band is not None or bool(further) or image
    number = 1 if view.band is None else view.band
    if image and further:
        number = further[0]
    facts = _facts_of(dataset, name, number, has_transform)
    view.is_image = image and not further
    if view.is_image:
        further = list(range(1, dataset.count + 1))
    view.place(facts.crs)
    band = _terrabite.Band.of_reader(_Band(reader, number), facts, view)
    beside = view.beside(view.nodata if image else ())
    others = [
        _terrabite.Band.of_reader(_Band(reader, n), _facts_of(dataset, name, n, has_transform), beside) for n in further
    ]
    return band, others, facts.transform


def _is_identity(dataset: Any) -> bool:
    """Whether a dataset has no geotransform: rasterio gives the identity then."""
    return bool(dataset.transform.is_identity)
