"""The path of light in the fibre, and the energy of each lobe: see `vellus::cylinder::path`."""

import drjit as dr

from .arrays import root
from .cuticle import fresnel

# Components: R, TT, TRT, TTs, TRTs, the rest, and scattered light that the cuticle reflected before it left.
COMPONENTS, REST, DIFFUSE = 7, 5, 6


def complement(x):
    """1 − eˣ for x ≤ 0, without cancellation near 0."""
    series = -x * (1 + x * (0.5 + x * (1 / 6)))
    return dr.select(-x < 0.02, series, 1 - dr.exp(x))


class Path:
    def __init__(self, p, sin_o, cos_o, h):
        self.p, self.cos_o = p, cos_o
        sin_t = sin_o / p.eta
        self.sin2_t = sin_t * sin_t
        cos_gamma_o = root((1 - h) * (1 + h))
        cos_t = dr.sqrt(dr.maximum((1 - sin_t) * (1 + sin_t), 1e-12))
        self.elongation = 1 / cos_t
        excess = (p.eta - 1) * (p.eta + 1) + cos_o * cos_o
        self.h_inside = h * cos_o / dr.sqrt(dr.maximum(excess, 1e-20))
        self.reflected, self.transmitted = fresnel(p.eta, p.layers, cos_o * cos_gamma_o)
        self.gamma_o = dr.atan2(h, cos_gamma_o)
        cos_gamma_t = root((1 - self.h_inside) * (1 + self.h_inside))
        self.gamma_t = dr.atan2(self.h_inside, cos_gamma_t)
        offset = dr.abs(self.h_inside)
        self.s_m = root((p.kappa - offset) * (p.kappa + offset))
        self.exists = offset < p.kappa
        self.s_c = dr.maximum(cos_gamma_t - self.s_m, 0)
        self.theta = dr.atan2(sin_t, cos_t) if p.reflects else dr.atan2(sin_o, cos_o)

    def gamma_m(self):
        """asin h″."""
        return dr.atan2(self.h_inside, dr.select(self.exists, self.s_m, 1e-20))

    def exits(self):
        """Φ of R, TT, TRT."""
        return [2 * k * self.gamma_t - 2 * self.gamma_o + k * dr.pi for k in range(3)]

    def scattered_exits(self):
        """Φˢ of TTs, TRTs."""
        first = self.gamma_t - self.gamma_o
        return [first, first + dr.pi + 2 * self.gamma_t]

    def attenuation(self, mean_path):
        """The energy of the components, RGB. `mean_path` is ⟨L⟩; reflecting exits do not need it."""
        p, f, t, long = self.p, self.reflected, self.transmitted, self.elongation
        unscattered = -2 * long * self.s_m * p.sigma_ms
        q = complement(unscattered)
        first = late = None
        if p.reflection:
            chord = self.s_m / dr.maximum(p.kappa, 1e-20)
            share, ln_kept, at_first = p.reflection.at(self.sin2_t, chord)
            escape = [s * dr.exp(k - self.s_c * long * ca) for s, k, ca in zip(share, ln_kept, p.sigma_ca)]
            first, late = p.reflection.divide(escape, at_first)
        else:
            cortex, medulla = (self.s_c + 1 - p.kappa) * long, p.kappa * mean_path * long
            escape = [dr.exp(-cortex * ca - medulla * ma) for ca, ma in zip(p.sigma_ca, p.sigma_ma)]
        energies = [[] for _ in range(COMPONENTS)]
        for c in range(3):
            through = dr.exp(unscattered - 2 * long * (self.s_c * p.sigma_ca[c] + self.s_m * p.sigma_ma[c]))
            again = f * through
            tt = t * t * through
            series = again * again * (t / dr.maximum(t + f * (1 - through), 1e-20))
            if p.reflection:
                tts, a_late = t * q * first[c], t * q * late[c]
                rest = t * through * series
                diffuse = a_late + a_late * again + escape[c] * q * series
            else:
                tts = t * escape[c] * q
                rest = (t * through + escape[c] * q) * series
                diffuse = type(tts)(0)
            values = [f, tt, tt * again, tts, tts * again, rest, diffuse]
            for energy, value in zip(energies, values):
                energy.append(value)
        return energies
