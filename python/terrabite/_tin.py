"""The mesh that a call gives."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np

from . import _terrabite

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Format = Literal["ply", "obj", "glb", "stl", "landxml", "ugrid", "vtp", "2dm"]


class Flag(Protocol):
    """What stops a call: ``threading.Event`` is one."""

    def is_set(self) -> bool:
        """Whether the call is to stop."""
        ...


def _is_there(name: str, call: str) -> ImportError:
    return ImportError(f"{call} needs {name}: pip install {name}")


class TIN:
    """A triangulated irregular network: a mesh over a raster of heights, within a stated vertical distance of every sample.

    The arrays are read-only and are not copied; ``tin.vertices.copy()`` gives one that may be changed. :func:`simplify` makes
    instances of it.

    >>> import numpy as np, terrabite as tb
    >>> tin = tb.simplify(np.zeros((5, 7)), max_error=1)
    >>> tin.vertices.shape, tin.triangles.shape
    ((4, 3), (2, 3))
    """

    __slots__ = ("_mesh", "_report", "_transform")

    def __init__(self, mesh: _terrabite.Mesh, transform: tuple[float, ...] | None) -> None:
        """Of a mesh that the module in Rust has made. Call :func:`simplify` instead."""
        self._mesh, self._transform = mesh, transform
        self._report: dict[str, Any] = json.loads(mesh.report)

    @property
    def vertices(self) -> NDArray[np.float64]:
        """x and y on the map and the height of each vertex: float64 of shape (n, 3), in the units of the raster's CRS and of its
        heights. Without a CRS or transform x is column + ½, and y is −(row + ½).
        """
        return self._mesh.vertices

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """The three vertices of each triangle, counter-clockwise seen from above: uint32 of shape (m, 3)."""
        return self._mesh.triangles

    @property
    def breakline_edges(self) -> NDArray[np.uint32]:
        """The two vertices of each edge that follows a line of ``breaklines``: uint32 of shape (k, 2), line by line."""
        return self._mesh.edges

    @property
    def breakline_types(self) -> NDArray[np.str_]:
        """The type of each of ``breakline_edges``, ``"hard"`` or ``"soft"``: shape (k,). Edges of outlines are hard."""
        return np.where(self._mesh.soft_edges, "soft", "hard")

    @property
    def attributes(self) -> dict[str, NDArray[np.float64]]:
        """Further values of the vertices by their names: float64 of shape (n,), one for each attribute that was asked for; with
        ``normals`` ``nx``, ``ny`` and ``nz``, too, which files have as normals where the format does.
        """
        return dict(self._mesh.attributes)

    @property
    def max_error(self) -> float:
        """The largest vertical distance between the mesh and a sample, in the units of the heights."""
        error: float = self._report["error"]["max"]
        return error

    @property
    def tolerance(self) -> float | None:
        """The tolerance that the mesh keeps to: ``max_error``, or what was found for a budget."""
        tolerance: float | None = self._report["tolerance"]
        return tolerance

    @property
    def report(self) -> dict[str, Any]:
        """What the command prints with ``--json``: errors and where they are, counts of samples, times, warnings."""
        return self._report

    @property
    def crs(self) -> str | None:
        """The CRS as authority and code, such as ``"EPSG:32633"``, or as WKT where it has no code; None where there is none."""
        return self._mesh.crs

    @property
    def transform(self) -> tuple[float, ...] | None:
        """The raster's six coefficients in GDAL's order, those of the whole raster if a part of it was meshed; None where it has
        none. ``affine.Affine.from_gdal(*tin.transform)`` is what rasterio calls a transform.
        """
        return self._transform

    def __repr__(self) -> str:
        return (
            f"<terrabite.TIN: {len(self.vertices)} vertices, {len(self.triangles)} triangles, "
            f"max_error {self.max_error:g}, crs {self.crs}>"
        )

    def write(
        self,
        path: str | os.PathLike[str],
        *,
        format: Format | None = None,
        precision: Literal["double", "float"] | None = None,
        local: bool = False,
        z_scale: float = 1,
        ascii: bool = False,
        base_height: float | None = None,
        base_depth: float | None = None,
        mesh_compression: Literal["meshopt"] | None = None,
        overwrite: bool = False,
        temp_dir: str | os.PathLike[str] | None = None,
        cancel: Flag | None = None,
    ) -> dict[str, Any]:
        """Write the mesh to a file.

        The format is that of the extension (.ply, .obj, .glb, .stl, .xml for LandXML, .nc for UGRID, .vtp, .2dm) unless
        ``format`` names it. Where a format or ``precision="float"`` has single precision only, heights are rounded; what they
        lose by that is added to the bound that the file states: ``["max_error"]`` of the dictionary that is returned, with
        ``["loss"]`` for what was lost. The mesh gets its name when it is complete; before, there is none.

        ``local`` takes an origin near the middle of the mesh from x and y, ``z_scale`` multiplies heights; the file says both.
        ``ascii`` writes text where binary is usual (PLY). ``base_height`` or ``base_depth`` make a solid with a floor
        (STL). ``mesh_compression`` is for GLB.

        Raises:
            ValueError: the extension names no format, or the format does not take an option.
            OutputError: the file exists and ``overwrite`` is False, or cannot be written.
            Cancelled: ``cancel`` was set.

        >>> import numpy as np, pathlib, tempfile, terrabite as tb
        >>> tin = tb.simplify(np.hypot(*np.mgrid[-20:20, -30:30]), max_error=0.5)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     written = tin.write(pathlib.Path(folder) / "cone.glb")
        >>> written["format"], written["precision"], written["loss"] < 1e-5
        ('glb', 'float', True)
        """
        options = {
            "format": format,
            "precision": precision,
            "local": local,
            "z_scale": z_scale,
            "ascii": ascii,
            "base_height": base_height,
            "base_depth": base_depth,
            "mesh_compression": mesh_compression,
            "overwrite": overwrite,
            "temp_dir": temp_dir,
        }
        written: dict[str, Any] = json.loads(self._mesh.write(path, options, cancel))
        return written

    def to_trimesh(self) -> Any:
        """The mesh as a ``trimesh.Trimesh``, vertices and faces in the same order. Attributes become ``vertex_attributes``.

        >>> import numpy as np, terrabite as tb
        >>> float(tb.simplify(np.zeros((5, 7)), max_error=1).to_trimesh().area)
        24.0
        """
        try:
            import trimesh
        except ImportError as error:
            raise _is_there("trimesh", "to_trimesh") from error
        return trimesh.Trimesh(
            self.vertices, self.triangles.astype("int64"), process=False, vertex_attributes={**self.attributes}
        )

    def to_pyvista(self) -> Any:
        """The mesh as a ``pyvista.PolyData``. Attributes become ``point_data``."""
        try:
            import pyvista
        except ImportError as error:
            raise _is_there("pyvista", "to_pyvista") from error
        mesh = pyvista.PolyData.from_regular_faces(self.vertices, self.triangles.astype("int64"))
        for name, values in self.attributes.items():
            mesh.point_data[name] = values
        return mesh

    def to_meshio(self) -> Any:
        """The mesh as a ``meshio.Mesh`` with cells of the type ``"triangle"``. Attributes become ``point_data``.

        >>> import numpy as np, terrabite as tb
        >>> tb.simplify(np.zeros((5, 7)), max_error=1).to_meshio().cells[0].data.shape
        (2, 3)
        """
        try:
            import meshio
        except ImportError as error:
            raise _is_there("meshio", "to_meshio") from error
        return meshio.Mesh(self.vertices, [("triangle", self.triangles)], point_data=self.attributes)


class Verdict:
    """What :func:`verify` has found out. It is true where the mesh passes."""

    __slots__ = ("_report",)

    def __init__(self, report: dict[str, Any]) -> None:
        """Of the report of a run."""
        self._report = report

    @property
    def passed(self) -> bool:
        """Whether the mesh is within the tolerance of every sample, covers the ground, and has no cracks, folds or overlaps."""
        return bool(self._report["passed"])

    @property
    def failures(self) -> list[str]:
        """What is wrong, a sentence for each kind of fault."""
        return list(self._report["failures"])

    @property
    def report(self) -> dict[str, Any]:
        """What the command ``verify`` prints with ``--json``."""
        return self._report

    def __bool__(self) -> bool:
        return self.passed

    def __repr__(self) -> str:
        return "<terrabite.Verdict: passed>" if self.passed else f"<terrabite.Verdict: {'; '.join(self.failures)}>"
