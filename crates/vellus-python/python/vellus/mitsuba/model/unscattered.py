"""The lobes of light that the medulla does not scatter: R, TT, TRT and the rest.

See `vellus::cylinder::longitudinal` and `vellus::cylinder::azimuthal`.
"""

import drjit as dr

from .arrays import wrap

# Fits of the crate: I₀(√z) up to x = 5, and √x e⁻ˣ I₀(x) in 1/x beyond.
NEAR = [3.40594e-12, 4.3296086e-10, 6.852862e-8, 6.7745964e-6, 4.3406636e-4, 0.015624912, 0.25, 1.0]
FAR = [-1.9657496, 1.5853693, -0.2659415, 0.05705673, 0.02696209, 0.04988296, 0.39894223]


def polynomial(x, coefficients):
    value = coefficients[0]
    for c in coefficients[1:]:
        value = value * x + c
    return value


def bessel_i0e(x):
    """e⁻ˣ I₀(x) for x ≥ 0, with a relative error of at most 1.2e-6."""
    t = 1 / dr.maximum(x, 5)
    near = dr.minimum(x, 5)
    return dr.select(x < 5, polynomial(near * near, NEAR) * dr.exp(-near), polynomial(t, FAR) * dr.sqrt(t))


class Longitudinal:
    """Shifts and widths of R, TT, TRT and the rest."""

    def __init__(self, alpha, beta_m):
        shift = [k * alpha for k in (1, -0.5, -1.5, -1.5)]
        self.sin, self.cos = [dr.sin(a) for a in shift], [dr.cos(a) for a in shift]
        self.v = [dr.square(k * beta_m) for k in (1, 0.5, 1.5, 2)]
        self.inverse = [1 / v for v in self.v]
        self.floor = [dr.exp(-2 / v) for v in self.v]
        self.norm = [1 / (v * (1 - floor)) for v, floor in zip(self.v, self.floor)]

    def centres(self, sin_o, cos_o):
        """sin θ_c and |cos θ_c| of the four lobes."""
        return [(-(sin_o * c + cos_o * s), dr.abs(cos_o * c - sin_o * s)) for s, c in zip(self.sin, self.cos)]

    def eval(self, centres, sin_i, cos_i):
        """Densities in sin θᵢ."""
        return [
            dr.exp(-0.5 * (dr.square(sin_i - s) + dr.square(cos_i - c)) * inverse)
            * bessel_i0e(cos_i * c * inverse)
            * norm
            for (s, c), inverse, norm in zip(centres, self.inverse, self.norm)
        ]


class Azimuthal:
    """Wrapped Gaussians around the exit azimuths of R, TT and TRT."""

    def __init__(self, beta_n):
        self.sigma = [beta_n * k**0.5 for k in (1, 2, 3)]
        # With fewer images the omitted ones are below a rounding: see `vellus::cylinder::azimuthal`.
        widest = dr.detach(self.sigma[2])[0]
        self.images = 0 if widest < 0.55 else 1 if widest < 1.39 else 2

    def eval(self, exits, phi):
        """Densities per radian."""
        values = []
        for sigma, exit in zip(self.sigma, exits):
            d = wrap(phi - exit)
            exponent = -0.5 / dr.square(sigma)
            turns = range(-self.images, self.images + 1)
            images = [dr.exp(dr.square(d + dr.two_pi * turn) * exponent) for turn in turns]
            values.append(sum(images[1:], images[0]) / (sigma * dr.two_pi**0.5))
        return values
