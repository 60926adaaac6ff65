"""Hair and fur: fibre scattering for arrays of queries, fits, and a renderer.

All angles are in degrees, all lengths in fibre radii, and absorption and scattering per fibre radius.
"""

from . import models
from ._types import Samples
from ._vellus import (
    Bcsdf,
    CoatColors,
    Fiber,
    __version__,
    cell_window,
    direction,
    parameters,
    pixel_window,
    species,
    tables,
)

LOBES = ("R", "TT", "TRT", "TTs", "TRTs", "rest")
"""The six lobes, in the order of every axis of lobes."""

__all__ = [
    "LOBES",
    "Bcsdf",
    "CoatColors",
    "Fiber",
    "Samples",
    "__version__",
    "cell_window",
    "direction",
    "models",
    "parameters",
    "pixel_window",
    "species",
    "tables",
]
