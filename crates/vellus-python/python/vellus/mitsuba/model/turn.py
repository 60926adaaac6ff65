"""D19 and D20: the azimuth of scattered light that leaves a fibre with reflecting exits. See `vellus::exit::turn`.

Light that has the azimuth ψ inside leaves at φ: e^(iφ) = (e^(iψ) − a)/(1 − ā e^(iψ)), |a| < 1.
"""

import drjit as dr

# The largest part of a.
MOST = 0.45


def stays(tau, keeps, reflected):
    """The share of light that stays on the side where it entered, for light that leaves later."""
    one_pass = dr.maximum(tau - 1.15, 0) / (tau + 0.79)
    again = one_pass * keeps
    return 0.68 * one_pass * again * (1 - reflected) / (1 - again * reflected)


class Turn:
    """The transformation with a = (`re` + i `im`) e^(i `angle`)."""

    def __init__(self, re, im, angle):
        sin, cos = dr.sincos(angle)
        self.re, self.im = re * cos - im * sin, re * sin + im * cos

    def inside(self, sin, cos):
        """ψ − φ and dψ/dφ, from the sine and the cosine of φ."""
        x, y = 1 + self.re * cos + self.im * sin, self.im * cos - self.re * sin
        return 2 * dr.atan2(y, x), (1 - dr.square(self.re) - dr.square(self.im)) / (dr.square(x) + dr.square(y))

    def leaving(self, psi):
        """φ of ψ."""
        sin, cos = dr.sincos(psi)
        return psi + 2 * dr.atan2(self.re * sin - self.im * cos, 1 - self.re * cos - self.im * sin)


class Turning:
    """How the cuticle of one fibre turns scattered light."""

    def __init__(self, p, parts, stays):
        self.kappa, self.slope, self.stays = p.kappa, p.medulla.slope, stays
        self.parts = [part * self.slope for part in parts]
        # The share of light that hardly changed its direction: it is turned as TT is.
        self.straight = dr.square(dr.square(p.g)) * dr.exp(-p.sigma_ms * p.kappa * (1 - p.g))

    def at(self, path):
        """Φˢ of TTs and TRTs with the shift α, and the transformations of TTs, TRTs and light that leaves later."""
        constant, cosine, sine = self.parts
        h = dr.clip(path.h_inside / self.kappa, -1, 1)
        more = self.straight * path.cos_o * (path.gamma_o - path.gamma_t - h * self.slope)
        limit = lambda x: dr.clip(0.5 * x, -MOST, MOST)
        re, im = limit((1 - h * h) * sine), -limit(h * cosine + more)
        exits = path.scattered_exits()
        entry = exits[0] - path.gamma_m()
        exits = [exit - h * constant for exit in exits]
        return exits, [Turn(re, im, exit) for exit in exits] + [Turn(-self.stays, 0, entry)]
