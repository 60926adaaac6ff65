"""Pictures of lobes, profiles, energies, models and windows. Notebooks show them; `save` writes PNG or SVG."""

from ._vellus import Plot
from ._vellus import plot_energy as energy
from ._vellus import plot_lobes as lobes
from ._vellus import plot_models as models
from ._vellus import plot_profile as profile
from ._vellus import plot_windows as windows

__all__ = ["Plot", "energy", "lobes", "models", "profile", "windows"]
