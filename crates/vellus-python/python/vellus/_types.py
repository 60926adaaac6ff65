"""Results with several arrays."""

from typing import Any, NamedTuple

from numpy.typing import NDArray


class Samples(NamedTuple):
    """Sampled directions."""

    wi: NDArray[Any]
    """Directions, unit length, in the fibre's frame: shape (..., 3)."""
    pdf: NDArray[Any]
    """Density per solid angle, of all lobes together: shape (...). 0 where nothing was drawn."""
    weight: NDArray[Any]
    """f·cos θᵢ over the density, RGB: shape (..., 3)."""
    lobe: NDArray[Any]
    """Index into `LOBES` of the lobe that the direction was drawn from: int8, shape (...). -1 where none was drawn."""


class SimulatedEnergies(NamedTuple):
    """Shares of the light that hits a simulated fibre, RGB, float64."""

    mean: NDArray[Any]
    """Mean of each of `vellus.FATES`: shape (6, 3)."""
    error: NDArray[Any]
    """Standard error of each mean: shape (6, 3)."""
    total: NDArray[Any]
    """All light that leaves: shape (3,)."""
    total_error: NDArray[Any]
    """Its standard error: shape (3,)."""


class Estimate(NamedTuple):
    """The value of one fitted parameter."""

    value: float
    """Its value, angles in degrees."""
    error: float | None
    """Its standard error. None if it was not fitted, or the data do not constrain it."""
    unit: str
    """`degrees`, or nothing."""
    state: str
    """`fitted`, `at bound`, `fixed` or `tied`."""
    determined: bool
    """Whether the data determine the value."""
