"""Turns rasters of heights of any size into triangulated irregular networks (TINs) with a certified vertical error.

>>> import numpy as np, terrabite as tb
>>> heights = np.hypot(*np.mgrid[-50:50, -80:80])
>>> tin = tb.simplify(heights, max_error=0.5)
>>> tb.verify(heights, tin, max_error=0.5).passed
True
"""

from ._api import Polishing, simplify, verify
from ._terrabite import Cancelled, Error, MeshError, OutputError, RasterError, ResourceError, __version__
from ._tin import TIN, Flag, Verdict

__all__ = [
    "TIN",
    "Cancelled",
    "Error",
    "Flag",
    "MeshError",
    "OutputError",
    "Polishing",
    "RasterError",
    "ResourceError",
    "Verdict",
    "__version__",
    "simplify",
    "verify",
]

try:
    from . import _accessor as _accessor
except ImportError:  # without xarray, arrays have no accessor
    pass
