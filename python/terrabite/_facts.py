"""What is told of a raster, and how it is to be looked at: what the module in Rust takes, attribute by attribute."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

#: GDAL's, in its order.
Coefficients: TypeAlias = tuple[float, float, float, float, float, float]


@dataclass
class Facts:
    """What is known of a raster's band, in GDAL's terms. An array has one band, and little of this."""

    name: str
    size: tuple[int, int]
    dtypes: list[str]
    band: int = 1
    driver: str = ""
    colours: list[str | None] = field(default_factory=lambda: [None])
    colour_table: list[tuple[int, int, int]] | None = None
    block: tuple[int, int] = (256, 256)
    scale: float = 1.0
    offset: float = 0.0
    nodata: float | int | None = None
    mask_flags: tuple[bool, bool, bool, bool] = (True, False, False, False)
    transform: Coefficients | None = None
    elsewhere: str | None = None
    crs: str = ""
    esri_wkt: str | None = None
    unit: str = ""
    description: str = ""
    pixel_is: str = ""


@dataclass
class View:
    """How a raster is to be looked at."""

    band: int | None = None
    nodata: list[str] = field(default_factory=list)
    valid_range: tuple[float, float] | None = None
    window: tuple[int, int, int, int] | None = None
    bbox: Sequence[float] | None = None
    bbox_crs: Any = None
    between: list[tuple[float, float]] | None = None
    oo: dict[str, Any] = field(default_factory=dict)
    encoding: str | None = None
    cutline: list[list[list[tuple[float, float]]]] = field(default_factory=list)
    is_named: bool = True
    is_image: bool = False

    def place(self, crs: str) -> None:
        """Finds the part that a box is, in a raster of this CRS."""
        if self.bbox is not None:
            self.between = box_places(self.bbox, self.bbox_crs, crs)

    def beside(self, nodata: Sequence[str] = ()) -> View:
        """How further bands of the same raster are looked at: the same part of them."""
        return View(window=self.window, between=self.between, nodata=list(nodata))


def words(nodata: object) -> list[str]:
    """The words for marks of missing samples, as the command takes them."""
    if nodata is None:
        return []
    if isinstance(nodata, str):
        return [nodata]
    if isinstance(nodata, Iterable):
        return [word for value in nodata for word in words(value)]
    # Numbers of numpy print as others do.
    number = nodata.item() if hasattr(nodata, "item") else nodata
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise TypeError(f"nodata: expected numbers or words, found {type(number).__name__}")
    return [repr(number)]


Rings = list[list[tuple[float, float]]]


def polygons(shapes: Any, name: str = "cutline") -> list[Rings]:
    """The rings of polygons: of geometries of GeoJSON, of what has them as ``__geo_interface__``, or of a sequence of those."""
    if shapes is None:
        return []
    found = _rings(shapes, name)
    if not found:
        raise ValueError(f"{name}: expected polygons, found none")
    return found


def _rings(shapes: Any, name: str) -> list[Rings]:
    if shapes is None:
        # A feature without a geometry.
        return []
    shape = getattr(shapes, "__geo_interface__", shapes)
    if not isinstance(shape, Mapping):
        if isinstance(shape, str) or not isinstance(shape, Iterable):
            raise TypeError(f"{name}: expected polygons as GeoJSON has them, or with __geo_interface__")
        return [polygon for part in shape for polygon in _rings(part, name)]
    kind = shape.get("type")
    if kind == "Polygon":
        return [[[(float(place[0]), float(place[1])) for place in ring] for ring in shape["coordinates"]]]
    if kind == "MultiPolygon":
        return [one for part in shape["coordinates"] for one in _rings({"type": "Polygon", "coordinates": part}, name)]
    if kind == "Feature":
        return _rings(shape["geometry"], name)
    if kind in ("FeatureCollection", "GeometryCollection"):
        return _rings(shape["features" if kind == "FeatureCollection" else "geometries"], name)
    raise ValueError(f"{name}: expected polygons, found {kind}")


def places(points: Any) -> list[tuple[float, float]] | None:
    """Places on the map, of an array of shape (n, 2) or (n, 3), whose heights do not matter."""
    if points is None:
        return None
    found = np.asarray(points, dtype="float64")
    if found.ndim != 2 or found.shape[1] not in (2, 3):
        raise ValueError(f"points: expected an array of shape (n, 2) or (n, 3), found {found.shape}")
    return [(float(x), float(y)) for x, y in found[:, :2]]


def lines(breaklines: Any) -> list[list[list[float]]] | None:
    """Lines on the map, each an array of shape (n, 2) or (n, 3), or an object of shapely."""
    if breaklines is None:
        return None
    found = []
    for line in breaklines:
        vertices = np.asarray(getattr(line, "coords", line), dtype="float64")
        if vertices.ndim != 2 or vertices.shape[1] not in (2, 3):
            raise ValueError(f"breaklines: expected lines of shape (n, 2) or (n, 3), found {vertices.shape}")
        found.append(vertices.tolist())
    return found


def numbers(name: str, values: Sequence[float] | None, count: int) -> tuple[float, ...] | None:
    """So many numbers, or nothing."""
    if values is None:
        return None
    found = tuple(values)
    if len(found) != count:
        raise ValueError(f"{name}: expected {count} numbers, found {len(found)}")
    return found


#: Places along a side of a box that are looked for in another CRS, where its sides may be bent, as in the command.
SIDE = 65


def box_places(bbox: Sequence[float] | None, bbox_crs: Any, crs: str) -> list[tuple[float, float]] | None:
    """Places in the CRS of a raster that a box is between: its corners, or 65 × 65 places of a box in another CRS."""
    box = numbers("bbox", bbox, 4)
    if box is None:
        return None
    steps = 2 if bbox_crs is None else SIDE
    xs, ys = (axis.ravel().tolist() for axis in np.meshgrid(np.linspace(box[0], box[2], steps), np.linspace(box[1], box[3], steps)))
    if bbox_crs is not None:
        xs, ys = _transformed(xs, ys, bbox_crs, crs)
    return list(zip(xs, ys, strict=True))


def _transformed(xs: list[float], ys: list[float], bbox_crs: Any, crs: str) -> tuple[list[float], list[float]]:
    if not crs:
        raise ValueError("bbox_crs: expected a raster with a CRS, found none; give bbox in its coordinates, without bbox_crs")
    try:
        from rasterio.crs import CRS
        from rasterio.errors import RasterioError
        from rasterio.warp import transform
    except ImportError as error:
        raise ImportError("bbox_crs: rasterio transforms it (pip install rasterio); bbox in the raster's CRS needs nothing") from error
    try:
        found = transform(CRS.from_user_input(crs_text(bbox_crs)[0]), CRS.from_user_input(crs), xs, ys)
    except (RasterioError, ValueError) as error:
        raise ValueError(f"bbox_crs: expected a CRS from which there is a way to the raster's, found {bbox_crs}: {error}") from error
    if not np.isfinite(found).all():
        raise ValueError(f"bbox_crs: the box has places that the raster's CRS has not ({bbox_crs})")
    return found[0], found[1]


def coefficients(transform: Any) -> Coefficients | None:
    """The six coefficients in GDAL's order, of those or of an ``affine.Affine``."""
    if transform is None:
        return None
    found = transform.to_gdal() if hasattr(transform, "to_gdal") else transform
    c = numbers("transform", tuple(float(value) for value in found), 6)
    assert c is not None
    return (c[0], c[1], c[2], c[3], c[4], c[5])


def crs_text(crs: Any) -> tuple[str, str | None]:
    """A CRS as WKT where a library is at hand that knows it, else in the words it was given in; and in Esri's dialect."""
    if crs is None or crs == "":
        return "", None
    if isinstance(crs, str | int):
        try:
            from rasterio.crs import CRS
        except ImportError:
            return (f"EPSG:{crs}" if isinstance(crs, int) else crs), None
        crs = CRS.from_user_input(crs)
    if not hasattr(crs, "to_wkt"):
        raise TypeError(f"crs: expected a text, a code of EPSG, or an object with to_wkt(), found {type(crs).__name__}")
    for version, esri in (("WKT1_GDAL", "WKT1_ESRI"), ("WKT1", "WKT1_ESRI")):
        try:
            return str(crs.to_wkt(version=version)), _esri(crs, esri)
        except (TypeError, ValueError, LookupError):
            continue
        except Exception as error:  # each library has errors of its own for a CRS that has no such text
            if type(error).__module__.partition(".")[0] not in ("rasterio", "pyproj"):
                raise
    return str(crs.to_wkt()), None


def _esri(crs: Any, version: str) -> str | None:
    try:
        return str(crs.to_wkt(version=version)) or None
    except Exception:  # not every CRS can be said in that dialect
        return None
