"""What is told of a raster, and how it is to be looked at: what the module in Rust takes, attribute by attribute."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

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
    bbox: tuple[float, float, float, float] | None = None
    oo: dict[str, Any] = field(default_factory=dict)
    is_named: bool = True


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


def numbers(name: str, values: Sequence[float] | None, count: int) -> tuple[float, ...] | None:
    """So many numbers, or nothing."""
    if values is None:
        return None
    found = tuple(values)
    if len(found) != count:
        raise ValueError(f"{name}: expected {count} numbers, found {len(found)}")
    return found


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
