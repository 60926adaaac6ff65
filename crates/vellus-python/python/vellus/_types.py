"""Results with several arrays."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._vellus import Fiber


class Samples(NamedTuple):
    """Sampled directions."""

    wi: NDArray[np.float32 | np.float64]
    """Directions, unit length, in the fibre's frame: shape (..., 3)."""
    pdf: NDArray[np.float32 | np.float64]
    """Density per solid angle, of all lobes together: shape (...). 0 where nothing was drawn."""
    weight: NDArray[np.float32 | np.float64]
    """f·cos θᵢ over the density, RGB: shape (..., 3)."""
    lobe: NDArray[np.int8]
    """Index into `LOBES` of the lobe that the direction was drawn from: int8, shape (...). -1 where none was drawn."""


class SimulatedEnergies(NamedTuple):
    """Shares of the light that hits a simulated fibre, RGB, float64."""

    mean: NDArray[np.float64]
    """Mean of each of `vellus.FATES`: shape (6, 3)."""
    error: NDArray[np.float64]
    """Standard error of each mean: shape (6, 3)."""
    total: NDArray[np.float64]
    """All light that leaves: shape (3,)."""
    total_error: NDArray[np.float64]
    """Its standard error: shape (3,)."""


class Estimate(NamedTuple):
    """The value of one fitted parameter."""

    value: float
    """Its value, angles in degrees."""
    error: float | None
    """Its standard error. None if it was not fitted, or the data do not constrain it."""
    interval: tuple[float, float] | None
    """Its 95 % interval: the values for which the best fit of all others is not worse than chance explains, within the
    range of the parameter. None if it was not fitted."""
    unit: str
    """`degrees`, or nothing."""
    state: str
    """`fitted`, `at bound`, `fixed` or `tied`."""
    determined: bool
    """Whether the data determine the value."""


class FitPart(NamedTuple):
    """The result of a fit for one of its profiles."""

    fiber: Fiber
    """The fitted fibre. It only differs between profiles in what `separate` names."""
    theta_o: float
    """Inclination of the fixed direction, degrees."""
    scale: float
    """The factor on the values of the model."""
    background: float
    """What is added to them."""
    fitted: NDArray[np.float64]
    """The value of the model for each point of the profile: shape (N, channels)."""
    nrmse: float
    """RMS error divided by the range of the measured values."""
    log_nrmse: float
    """The same for the logarithms, which the fit minimises."""
