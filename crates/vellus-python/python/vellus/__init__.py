"""Hair and fur: fibre scattering for arrays of queries, fits, and a renderer.

All angles are in degrees, all lengths in fibre radii, and absorption and scattering per fibre radius.
"""

from . import _processor, models, plots  # noqa: F401  _processor is the first
from ._types import Estimate, FitPart, Samples, SimulatedEnergies
from ._vellus import (
    FATES,
    Bcsdf,
    CoatColors,
    Fiber,
    Fit,
    Picture,
    Profile,
    Scene,
    State,
    __version__,
    cell_window,
    direction,
    fit,
    parameters,
    pixel_window,
    profile,
    shader_tables,
    simulate,
    simulate_energies,
    species,
    tables,
)

LOBES = ("R", "TT", "TRT", "TTs", "TRTs", "rest")
"""The six lobes, in the order of every axis of lobes."""

__all__ = [
    "FATES",
    "LOBES",
    "Bcsdf",
    "CoatColors",
    "Estimate",
    "Fiber",
    "Fit",
    "FitPart",
    "Picture",
    "Profile",
    "Samples",
    "Scene",
    "SimulatedEnergies",
    "State",
    "__version__",
    "cell_window",
    "direction",
    "fit",
    "models",
    "parameters",
    "pixel_window",
    "plots",
    "profile",
    "shader_tables",
    "simulate",
    "simulate_energies",
    "species",
    "tables",
]
