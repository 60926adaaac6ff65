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
    """Index into `LOBES` of the lobe that the direction was drawn from: int8, shape (...). -1 where nothing was drawn."""
