"""A fibre: parameters as Dr.Jit arrays, and everything that depends on them alone."""

import drjit as dr

from .arrays import Grid
from .exit import Reflection
from .hit import Hit
from .medulla import Medulla
from .unscattered import Azimuthal, Longitudinal

ANGLES = ("alpha", "beta_m", "beta_n")
NUMBERS = ("eta", "kappa", *ANGLES, "sigma_ms", "g", "layers")
COLORS = ("sigma_ca", "sigma_ma")


class Fiber:
    """The near field of a fibre with differentiable parameters.

    `F`: the type of arrays, such as `mitsuba.Float` or `drjit.llvm.ad.Float64`. `parameters`: each of `NUMBERS` with
    one number, and each of `COLORS` with three. Angles are in degrees, σ per fibre radius. Ranges: `vellus.Fiber`,
    which checks them; nothing is checked here. `reflects` is false for open exits.

    The arrays may track gradients. Making a fibre takes some milliseconds; a renderer makes it once for each change.
    """

    def __init__(self, F, parameters, reflects=True):
        self.F = F
        for name in NUMBERS:
            value = F(parameters[name])
            setattr(self, name, dr.deg2rad(value) if name in ANGLES else value)
        for name in COLORS:
            setattr(self, name, [F(parameters[name][c]) for c in range(3)])
        self.scatters = dr.detach(self.sigma_ms * self.kappa)[0] > 0
        self.reflects = reflects and self.scatters
        self.longitudinal, self.azimuthal = Longitudinal(self.alpha, self.beta_m), Azimuthal(self.beta_n)
        grid = Grid.of(F) if self.scatters else None
        self.medulla = Medulla(grid, self) if self.scatters else None
        self.reflection = Reflection(grid, self) if self.reflects else None

    def at(self, wo, h):
        """Prepares what depends on ω_o, the direction toward the camera, and on the offset h in [−1, 1].

        `wo`: the x, y and z of unit vectors in the frame of the fibre, x from root to tip.
        """
        return Hit(self, wo, h)
