"""The calls: rasters in, meshes and verdicts out."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack

import numpy as np

from . import _arrays, _facts, _rasters, _terrabite
from ._tin import TIN, Flag, Verdict

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    #: What has heights: an array (masked or not), a DataArray of xarray, a dataset of rasterio, or a path.
    Raster = NDArray[Any] | str | os.PathLike[str] | Any
    #: Called with a stage's name, the steps of it that are done, and how many there are.
    Progress = Callable[[str, int, int], object]
    #: A stored value that marks missing samples, or several; words are those of the command.
    Nodata = float | str | Iterable[float | str]
    Attributes = Sequence[int] | Mapping[str, NDArray[np.generic]]


class Polishing(TypedDict, total=False):
    """What polishing does, number by number: each is as the quality says unless given. Wrong ones raise ``ValueError``."""

    #: Edges that it makes: tested at samples alone, or where they cross the grid, too; by default as ``feasibility`` says.
    polish_edges: Literal["weak", "strong"]
    #: Sweeps of removal in the beginning.
    polish_sweeps: int | Literal["all"]
    #: Rounds of moves after those.
    polish_moves: int
    #: Sweeps of removal in the end.
    polish_last_sweeps: int | Literal["all"]
    #: Passes of remove-and-repair, at most.
    polish_passes: int
    #: By how much the energy may rise when a vertex goes: one to eight, for the first passes; the last is the rest's.
    polish_caps: Sequence[float]
    #: Whether every pass tries all vertices, or only those at which something has changed.
    polish_retry: bool
    #: Passes beyond the caps end when fewer than one vertex in so many is removed; 0 means never.
    polish_yield: int
    #: Rounds of repair after a vertex has gone, at most.
    polish_rounds: int
    #: To what share a round must bring down the energy of violating triangles for another to follow.
    polish_shrink: float
    #: What energy violating triangles may have for the last round to follow, and five times as much for each before; ``inf`` for any.
    polish_reach: float
    #: Steps of a vertex that moves in a round of repair.
    polish_steps: int
    #: Whether the first of these is half as long from one round to the next.
    polish_finer: bool
    #: Whether a round also moves vertices around which it has left no violation.
    polish_thorough: bool
    #: Steps of a vertex that moves between passes.
    polish_steps_between: int
    #: Places looked at around a vertex that stands on a sample.
    polish_places: Literal[4, 8]
    #: In how many rows, about, these are compared first where triangles are large.
    polish_rows: int | Literal["all"]
    #: Whether edges turn between passes, too.
    polish_turns: bool
    #: Removal fills holes with up to so many corners by dynamic programming.
    polish_longest_ring: int
    #: Remove-and-repair leaves vertices with more neighbours alone.
    polish_longest_repaired: int


def simplify(
    raster: Raster,
    /,
    max_error: float | None = None,
    *,
    max_rms: float | None = None,
    max_points: int | None = None,
    max_triangles: int | None = None,
    quality: Literal["none", "fast", "balanced", "best"] | None = None,
    heights: Literal["sampled", "fitted"] = "sampled",
    min_angle: float | None = None,
    max_stray: float | None = None,
    feasibility: Literal["weak", "strong"] = "weak",
    tile: int = 512,
    trim: int = 0,
    fill_holes: int = 0,
    nodata: Nodata | None = None,
    valid_range: Sequence[float] | None = None,
    transform: Any = None,
    crs: Any = None,
    band: int | None = None,
    window: Sequence[int] | None = None,
    bbox: Sequence[float] | None = None,
    bbox_crs: Any = None,
    oo: Mapping[str, Any] | None = None,
    encoding: Literal["terrain-rgb", "terrarium"] | None = None,
    cutline: Any = None,
    cutline_exact: bool = False,
    attributes: Attributes | None = None,
    attribute_weight: float | None = None,
    image: bool = False,
    importance: Raster | None = None,
    points: Any = None,
    breaklines: Any = None,
    lake_polygons: Any = None,
    lake_z: Literal["min", "median"] | Sequence[float] = "min",
    footprints: Any = None,
    breakline_shift: float = 0.5,
    breakline_z: Literal["raster", "line"] = "raster",
    breakline_type: Literal["hard", "soft"] | Sequence[str] = "hard",
    engine: Literal["greedy-cuts", "greedy-insertion", "hitting-set"] | None = None,
    cuts: Literal["plain", "improved"] | None = None,
    swap: Literal["delaunay", "data-dependent"] | None = None,
    quality_threshold: float | None = None,
    shape: Literal["area-over-diameter", "smallest-angle"] | None = None,
    fit: Literal["max-sum", "l2", "l-infinity"] | None = None,
    selection: Literal["sequential", "fractional", "constant"] | None = None,
    fraction: float | None = None,
    measure: Literal["local-error", "curvature", "global-error", "product"] | None = None,
    smoothing: float | None = None,
    squares: Literal["nested", "sliding"] | None = None,
    corners: Literal["samples", "free"] | None = None,
    stitching: Literal["shared", "merged"] | None = None,
    access: Literal["auto", "windows", "decode"] = "auto",
    memory: int | None = None,
    threads: int | None = None,
    temp_dir: str | os.PathLike[str] | None = None,
    normals: Literal["gradient", "area"] | None = None,
    work_dir: str | os.PathLike[str] | None = None,
    keep_work_dir: bool = False,
    cancel: Flag | None = None,
    progress: Progress | None = None,
    **polishing: Unpack[Polishing],
) -> TIN:
    """Turn a raster of heights into a mesh that is within ``max_error`` of every sample.

    ``raster`` is an array of shape (rows, columns), a masked array, an ``xarray.DataArray``, an open dataset of rasterio, or a
    path, which rasterio opens and reads window by window.

    - An array is borrowed where it is C-contiguous, in the machine's byte order and of an integer type or float32 or float64.
      Anything else costs one copy (as float32 for float16). Nobody should write to it meanwhile.
    - What is masked or NaN is missing, and no ground. ``nodata`` names further stored values: numbers, or the words of the
      command (``"nan"``, ``"tag"`` for the raster's own, ``"none"``).
    - Of a DataArray, ``_FillValue``, ``scale_factor`` and ``add_offset`` in ``attrs`` apply; in ``encoding`` they were applied
      when it was read, and do not apply again. Place and CRS come from its coordinates and its grid mapping.
    - Of a path or dataset, the rules of the command hold: nodata tag, mask, alpha band, scale and offset.

    Options are those of ``terrabite simplify``, with underscores and the same defaults; one of ``max_error``,
    ``max_triangles``, ``max_points`` and ``max_rms`` is needed. Lengths are in the units of the heights.

    Args:
        raster: Heights.
        max_error: The largest vertical distance allowed between mesh and samples; 0 is exact.
        max_rms: The root mean square of the distances to reach.
        max_points: A budget of vertices.
        max_triangles: A budget of triangles.
        quality: How much work goes into fewer triangles: balanced by default.
        heights: Whether vertices that polishing moves have the heights of samples, or heights fitted to those around them.
        min_angle: The smallest angle, in degrees, of triangles that polishing makes, unless they replace sharper ones.
        max_stray: How far the surface may stray between samples, in tolerances; ``inf`` for no limit.
        feasibility: Where triangles are tested: at samples, or also where their edges cross the grid.
        tile: The side of tiles, in cells.
        trim: Ground within this number of cells of a missing sample may be removed.
        fill_holes: Voids of up to this number of samples are covered.
        nodata: Stored values that mark missing samples, in place of a raster's tag.
        valid_range: The least and the largest height that is valid, after scale and offset.
        transform: Where an array lies: an ``affine.Affine``, or GDAL's six coefficients.
        crs: The CRS of an array: anything rasterio takes where it is installed, else a text, such as ``"EPSG:32633"``.
        band: The band of a path or dataset, from 1.
        window: Column, row, width and height of the part that is meant, in samples.
        bbox: The least x and y of the part that is meant, and the largest, in the raster's CRS.
        bbox_crs: The CRS of ``bbox``, where it is another: anything rasterio takes, which is needed for it; x is longitude there.
        oo: Open options of a path's format, by name.
        encoding: How heights are stored as red, green and blue.
        cutline: Polygons in the raster's CRS outside of which samples count as missing: geometries of GeoJSON, objects with
            ``__geo_interface__`` such as those of shapely and geopandas, or a sequence of them.
        cutline_exact: Whether the mesh ends at the outlines of these polygons themselves, not at sides and diagonals of cells.
        attributes: Bands (numbers, from 1) or, with an array, further arrays by name, that become values of the vertices, each
            counted in the error.
        attribute_weight: What attributes count in the error, from 0 to 1; 0.5 by default.
        image: Whether a path or dataset is an image without heights: flat; all bands are attributes unless ``attributes`` says which.
        importance: Weights on the samples of the raster: distance times weight is within ``max_error``.
        points: Places in the raster's CRS, of shape (n, 2) or (n, 3): the samples nearest to them become vertices.
        breaklines: Lines in the raster's CRS, each of shape (n, 2) or (n, 3): edges of the mesh follow them.
        lake_polygons: Polygons, as for ``cutline``: lakes, which are level.
        lake_z: The height of each lake: the least or the median of the samples on its rim, or a number for each polygon.
        footprints: Polygons, as for ``cutline``: edges of the mesh follow their outlines.
        breakline_shift: How far edges may be from lines and outlines, in cells.
        breakline_z: Which heights edges of breaklines have: ``"line"`` takes those of lines of shape (n, 3).
        breakline_type: How edges of breaklines are marked: ``"hard"`` where the slope breaks, ``"soft"`` where it need not, or one
            of these for each line. :func:`verify` does not ask.
        engine: How tiles are triangulated.
        cuts: The order of greedy cuts.
        swap: By what edges of greedy insertion are swapped.
        quality_threshold: Data-dependent: shape decides where one is at most so large a share of the other.
        shape: Data-dependent: what a good shape is.
        fit: Data-dependent: the error that a swap is to lower.
        selection: How many candidates a pass inserts.
        fraction: Fractional: candidates with at least this share of the largest error.
        measure: What makes a sample important that is beyond the tolerance.
        smoothing: Curvature and product: the standard deviation of the Gaussian, in cells.
        squares: Hitting set: which squares of samples are tried.
        corners: Hitting set: what heights vertices have where squares meet.
        stitching: Hitting set: how squares become a mesh.
        access: How samples are read: as suits, in windows, or decoded into a temporary file first.
        memory: The most memory to use, in bytes, apart from the raster and the mesh; a quarter of the machine's and at most 2 GiB
            by default.
        threads: Threads to work with; as many as the machine has cores by default. The mesh does not depend on it.
        temp_dir: The folder of temporary files.
        normals: ``nx``, ``ny`` and ``nz`` among the attributes: normals of the raster at the vertices, or of the triangles around them.
        work_dir: A folder that keeps finished tiles until the mesh is there: after an interruption the same call goes on.
        keep_work_dir: It stays when the mesh is there.
        cancel: An object with ``is_set()``, such as a ``threading.Event``: setting it, from any thread, stops the call.
        progress: Called with a stage's name, steps done and steps in all, at most every 50 ms, by the calling thread.
        **polishing: What polishing does, number by number, for experts: :class:`Polishing`.

    Returns:
        The mesh. The same raster and options give the same one, whatever the threads and the memory.

    Raises:
        TypeError: the array cannot be used; the message says what to call. Or an option has the wrong type.
        ValueError: an option has no usable value, or options do not go together.
        RasterError: the raster cannot be read, or its samples cannot be meshed.
        ResourceError: ``memory`` or the disk is too small.
        Cancelled: ``cancel`` was set. Ctrl-C raises KeyboardInterrupt within a second.

    >>> import numpy as np
    >>> import terrabite as tb
    >>> rows, columns = np.mgrid[-100:100, -150:150]
    >>> hill = 300 - (rows**2 + columns**2) / 100
    >>> tin = tb.simplify(hill, max_error=0.5)
    >>> tin.max_error <= 0.5, len(tin.triangles) < hill.size // 20
    (True, True)
    """
    if unknown := sorted(polishing.keys() - Polishing.__annotations__.keys()):
        raise TypeError(f"simplify() got an unexpected keyword argument {unknown[0]!r}")
    outlines = _outlines(cutline, cutline_exact)
    view = _view(raster, nodata, valid_range, band, window, (bbox, bbox_crs), oo, encoding, None if cutline_exact else cutline)
    heights_band, further, place = _bands(raster, view, transform, crs, attributes, image)
    options = {
        "max_error": max_error,
        "max_rms": max_rms,
        "max_points": max_points,
        "max_triangles": max_triangles,
        "quality": quality,
        "heights": heights,
        "feasibility": feasibility,
        "min_angle": min_angle,
        "max_stray": max_stray,
        "tile": tile,
        "trim": trim,
        "fill_holes": fill_holes,
        "importance": _weights(importance, view),
        "attributes": further,
        "attribute_weight": attribute_weight,
        "image": image,
        "points": _facts.places(points),
        "breaklines": _facts.lines(breaklines),
        "lake_polygons": None if lake_polygons is None else _facts.polygons(lake_polygons, "lake_polygons"),
        "lake_z": lake_z if isinstance(lake_z, str) else [float(z) for z in lake_z],
        "footprints": None if footprints is None else _facts.polygons(footprints, "footprints"),
        "cutline_exact": outlines,
        "breakline_shift": breakline_shift,
        "breakline_z": breakline_z,
        "breakline_type": breakline_type if isinstance(breakline_type, str) else list(breakline_type),
        "engine": engine,
        "cuts": cuts,
        "swap": swap,
        "quality_threshold": quality_threshold,
        "shape": shape,
        "fit": fit,
        "selection": selection,
        "fraction": fraction,
        "measure": measure,
        "smoothing": smoothing,
        "squares": squares,
        "corners": corners,
        "stitching": stitching,
        "access": access,
        "memory": memory,
        "threads": threads,
        "temp_dir": temp_dir,
        "normals": normals,
        "work_dir": work_dir,
        "keep_work_dir": keep_work_dir,
        "polishing": {name: polishing.get(name) for name in Polishing.__annotations__},
    }
    return TIN(_terrabite.simplify(heights_band, options, cancel, progress), place)


def verify(
    raster: Raster,
    mesh: TIN | str | os.PathLike[str],
    /,
    max_error: float,
    *,
    max_stray: float | None = None,
    trim: int = 0,
    fill_holes: int = 0,
    nodata: Nodata | None = None,
    valid_range: Sequence[float] | None = None,
    transform: Any = None,
    crs: Any = None,
    band: int | None = None,
    window: Sequence[int] | None = None,
    bbox: Sequence[float] | None = None,
    bbox_crs: Any = None,
    oo: Mapping[str, Any] | None = None,
    encoding: Literal["terrain-rgb", "terrarium"] | None = None,
    cutline: Any = None,
    cutline_exact: bool = False,
    attributes: Attributes | None = None,
    attribute_weight: float | None = None,
    image: bool = False,
    importance: Raster | None = None,
    breaklines: Any = None,
    lake_polygons: Any = None,
    lake_z: Literal["min", "median"] | Sequence[float] = "min",
    footprints: Any = None,
    breakline_shift: float = 0.5,
    breakline_z: Literal["raster", "line"] = "raster",
    threads: int | None = None,
    temp_dir: str | os.PathLike[str] | None = None,
    cancel: Flag | None = None,
    progress: Progress | None = None,
) -> Verdict:
    """Judge a mesh against its raster, by code that shares nothing with what made it.

    Heights, coverage, cracks and folds are judged, as by ``terrabite verify``. Options that say which samples there are, and
    ``trim``, ``fill_holes``, ``attributes``, ``importance``, ``breaklines``, ``lake_polygons`` and ``footprints``, must be those that the mesh was made with: see :func:`simplify`.

    Args:
        raster: What the mesh was made from.
        mesh: A mesh, or a file with one in any of the formats that :meth:`TIN.write` writes.
        max_error: The vertical distance allowed at every sample, in the units of the heights.
        max_stray: How far the surface may stray between samples, in tolerances; not judged by default.
        trim: The mesh may end short of the ground within this number of cells of a missing sample.
        fill_holes: The mesh must cover voids of up to this number of samples.
        nodata: As for :func:`simplify`, and so are those that follow.
        valid_range: The heights that are valid.
        transform: Where an array lies.
        crs: The CRS of an array.
        band: The band.
        window: The part in samples.
        bbox: The part on the map.
        bbox_crs: The CRS of ``bbox``.
        oo: Open options.
        encoding: How heights are stored.
        cutline: Polygons.
        cutline_exact: Whether the mesh must end at their outlines.
        attributes: Bands or arrays that are attributes.
        attribute_weight: What they count.
        image: Whether the raster is an image without heights.
        importance: Weights.
        breaklines: Lines that edges of the mesh must follow.
        lake_polygons: Polygons that must be level.
        lake_z: Their heights.
        footprints: Polygons whose outlines they must follow.
        breakline_shift: How far edges may be from them, in cells.
        breakline_z: Which heights those edges have.
        threads: Threads to work with; the verdict does not depend on them.
        temp_dir: The folder of temporary files, about 200 bytes a triangle.
        cancel: Stops the call when it is set.
        progress: As for :func:`simplify`.

    Returns:
        A verdict. A mesh that is merely wrong is one; errors are for what cannot be read.

    Raises:
        MeshError: the file holds no mesh that can be read.
        RasterError, TypeError, ValueError, Cancelled: as for :func:`simplify`.

    >>> import numpy as np, terrabite as tb
    >>> heights = np.random.default_rng(1).random((60, 80))
    >>> tin = tb.simplify(heights, max_error=0.25)
    >>> tb.verify(heights, tin, max_error=0.25).passed, tb.verify(heights, tin, max_error=0.1).passed
    (True, False)
    """
    outlines = _outlines(cutline, cutline_exact)
    view = _view(raster, nodata, valid_range, band, window, (bbox, bbox_crs), oo, encoding, None if cutline_exact else cutline)
    heights_band, further, _ = _bands(raster, view, transform, crs, attributes, image)
    options = {
        "max_error": max_error,
        "max_stray": max_stray,
        "fill_holes": fill_holes,
        "trim": trim,
        "importance": _weights(importance, view),
        "attributes": further,
        "attribute_weight": attribute_weight,
        "image": image,
        "breaklines": _facts.lines(breaklines),
        "lake_polygons": None if lake_polygons is None else _facts.polygons(lake_polygons, "lake_polygons"),
        "lake_z": lake_z if isinstance(lake_z, str) else [float(z) for z in lake_z],
        "footprints": None if footprints is None else _facts.polygons(footprints, "footprints"),
        "cutline_exact": outlines,
        "breakline_shift": breakline_shift,
        "breakline_z": breakline_z,
        "threads": threads,
        "temp_dir": temp_dir,
    }
    judged = mesh._mesh if isinstance(mesh, TIN) else os.fspath(mesh)
    return Verdict(json.loads(_terrabite.verify(heights_band, judged, options, cancel, progress)))


def _outlines(cutline: Any, is_exact: bool) -> list[_facts.Rings] | None:
    if not is_exact:
        return None
    if cutline is None:
        raise ValueError("cutline_exact requires cutline: it is the outlines of its polygons that the mesh ends at")
    return _facts.polygons(cutline)


def _view(
    raster: Raster,
    nodata: Nodata | None,
    valid_range: Sequence[float] | None,
    band: int | None,
    window: Sequence[int] | None,
    box: tuple[Sequence[float] | None, Any],
    oo: Mapping[str, Any] | None,
    encoding: str | None,
    cutline: Any,
) -> _facts.View:
    is_path = isinstance(raster, str | os.PathLike)
    if band is not None and not (is_path or _rasters.is_dataset(raster)):
        raise TypeError("band is for paths and datasets: index the array")
    if encoding is not None and band is not None:
        raise ValueError("encoding cannot be combined with band: colours stand for heights in three bands together")
    if encoding is not None and not (is_path or _rasters.is_dataset(raster)):
        raise TypeError("encoding is for paths and datasets: make heights of the array of colours")
    if box[1] is not None and box[0] is None:
        raise ValueError("bbox_crs requires bbox: it is the CRS of its numbers")
    if oo and not is_path:
        raise TypeError("oo is for paths: options of a format apply when it is opened")
    limits = _facts.numbers("valid_range", valid_range, 2)
    part = _facts.numbers("window", window, 4)
    return _facts.View(
        band=band,
        nodata=_facts.words(nodata),
        valid_range=None if limits is None else (limits[0], limits[1]),
        window=None if part is None else (int(part[0]), int(part[1]), int(part[2]), int(part[3])),
        bbox=box[0],
        bbox_crs=box[1],
        oo=dict(oo or {}),
        encoding=encoding,
        cutline=_facts.polygons(cutline),
    )


def _bands(
    raster: Raster, view: _facts.View, transform: Any, crs: Any, attributes: Attributes | None, image: bool = False
) -> tuple[_terrabite.Band, list[_terrabite.Band] | None, tuple[float, ...] | None]:
    """The band of the heights, those of the attributes, and where the raster lies."""
    named = attributes if isinstance(attributes, Mapping) else None
    numbered = [] if attributes is None or named is not None else [int(number) for number in attributes]
    if isinstance(raster, str | os.PathLike) or _rasters.is_dataset(raster):
        if transform is not None or crs is not None:
            raise TypeError("transform and crs are for arrays: a raster brings its own")
        if named is not None:
            raise TypeError("attributes: expected numbers of bands, found arrays by name")
        if image and (view.band is not None or view.encoding is not None or view.valid_range is not None):
            raise ValueError("image cannot be combined with band, encoding or valid_range: an image has no heights")
        band, further, place = _rasters.bands_of(raster, view, numbered, image)
        return band, further if image or attributes is not None else None, place
    if image:
        raise TypeError("image is for paths and datasets: give an array of zeros, and the bands as attributes, by name")
    if numbered:
        raise TypeError("attributes: expected arrays by name, as an array has no other bands")
    if _arrays.is_data_array(raster):
        values, facts = _arrays.of_data_array(raster)
    else:
        values, facts = raster, _facts.Facts(name="array", size=(0, 0), dtypes=[])
    if transform is not None:
        facts.transform = _facts.coefficients(transform)
    if crs is not None:
        facts.crs, facts.esri_wkt = _facts.crs_text(crs)
    view.place(facts.crs)
    band = _arrays.band_of(values, facts, view)
    beside = view.beside()
    arrays = None
    if named is not None:
        if not named:
            raise ValueError("attributes: expected one array or more, found none")
        shape = np.shape(values)
        for name, array in named.items():
            if np.shape(array) != shape:
                raise ValueError(f"attributes: expected arrays of the shape {shape}, found {np.shape(array)} for {name}")
        arrays = [
            _arrays.band_of(array, _facts.Facts(name=name, size=(0, 0), dtypes=[], description=name), beside)
            for name, array in named.items()
        ]
    return band, arrays, facts.transform


def _weights(importance: Raster | None, view: _facts.View) -> _terrabite.Band | None:
    """Weights, of the same part as the heights."""
    if importance is None:
        return None
    return _bands(importance, view.beside(), None, None, None)[0]
