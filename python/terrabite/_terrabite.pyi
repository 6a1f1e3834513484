"""The module in Rust: see python/src."""

import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._facts import Facts, View
from ._tin import Flag

__version__: str

class Error(Exception):
    """What went wrong with data, files or the machine."""

class RasterError(Error):
    """The heights cannot be read, or cannot be meshed."""

class MeshError(Error):
    """A mesh cannot be read, or is damaged."""

class OutputError(Error):
    """The output cannot be written."""

class ResourceError(Error):
    """The memory or the disks are too small."""

class Cancelled(Error):
    """The cancel flag was set."""

class Band:
    """One band of a raster: what is known of it, and the way to its stored values."""

    @staticmethod
    def of_array(array: NDArray[Any], mask: NDArray[np.bool_] | None, facts: Facts, view: View) -> Band: ...
    @staticmethod
    def of_reader(reader: object, facts: Facts, view: View) -> Band: ...
    @property
    def shape(self) -> tuple[int, int]: ...

class Mesh:
    """A mesh in arrays that numpy owns, with what a file with it says of itself."""

    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def edges(self) -> NDArray[np.uint32]: ...
    @property
    def soft_edges(self) -> NDArray[np.bool_]: ...
    @property
    def attributes(self) -> list[tuple[str, NDArray[np.float64]]]: ...
    @property
    def report(self) -> str: ...
    @property
    def crs(self) -> str | None: ...
    def write(self, path: str | os.PathLike[str], options: Mapping[str, object], cancel: Flag | None) -> str: ...

def simplify(
    band: Band,
    options: Mapping[str, object],
    cancel: Flag | None,
    progress: Callable[[str, int, int], object] | None,
) -> Mesh: ...
def verify(
    band: Band,
    mesh: Mesh | str,
    options: Mapping[str, object],
    cancel: Flag | None,
    progress: Callable[[str, int, int], object] | None,
) -> str: ...
