"""Hair and fur: fibre scattering for arrays of queries, fits, and a renderer."""

from ._types import Samples
from ._vellus import Bcsdf, Fiber, __version__, parameters, species, tables

LOBES = ("R", "TT", "TRT", "TTs", "TRTs", "rest")
"""The six lobes, in the order of every axis of lobes."""

__all__ = ["LOBES", "Bcsdf", "Fiber", "Samples", "__version__", "parameters", "species", "tables"]
