"""The cuticle: reflectance, and how it refracts light. See `vellus::cylinder::cuticle`."""

import drjit as dr
import numpy as np


def refracted_cos2(eta, cos2):
    """cos² of the refracted direction from cos² of incidence."""
    return dr.maximum(1 - (1 - cos2) / dr.square(eta), 1e-20)


def parts(eta, layers, cos, cos_t):
    """Two numbers with the ratio F : (1 − F)."""
    a, b, c, d = cos, eta * cos_t, eta * cos, cos_t
    s, p = a * a + b * b, c * c + d * d
    reflected = dr.square(a - b) * p + dr.square(c - d) * s
    through = a * b * p + c * d * s
    return 0.5 * layers * reflected, dr.maximum(through, 1e-30)


def fresnel(eta, layers, cos):
    """The reflected and the transmitted share. Neither is 1 minus the other, which would lose digits."""
    back, through = parts(eta, layers, cos, dr.sqrt(refracted_cos2(eta, cos * cos)))
    scale = 1 / (back + through)
    return back * scale, through * scale


def outward(F, eta, kappa, layers):
    """Means over light that leaves the medulla and then the fibre: see `vellus::medulla::cone`.

    Returns b of T(s) = 1 − b s⁴, the transmittance for scattered light at s = sin θᵢ; the slope of the angle by which
    the cuticle turns light, over its offset h″; and the largest h″ at which light leaves.
    """
    x, w = np.polynomial.legendre.leggauss(4)
    s2, share = F(np.tile((0.5 + 0.5 * x) ** 2, 2)), F(np.tile(0.5 * w, 2))
    t = F(np.repeat(0.5 + 0.5 * np.polynomial.legendre.leggauss(2)[0], 4))
    cos2 = 1 - s2
    largest = dr.sqrt(cos2 / (eta * eta - s2))
    most = dr.minimum(kappa / largest, 1)
    h = most * t * (2 - t)
    cos2 = cos2 * (1 - h * h)
    back, through = parts(eta, layers, dr.sqrt(cos2), dr.sqrt(refracted_cos2(eta, cos2)))
    passed = through / (back + through) * largest * most * (1 - t) * share
    zeroth, fourth = dr.sum(passed), dr.sum(passed * s2 * s2)
    constant, line = zeroth / 9 - fourth * 0.2, zeroth * 0.2 - fourth
    loss = dr.clip(line / dr.maximum(constant, 1e-20), 0, 1)
    cos_inside = dr.sqrt(1 - s2 / (eta * eta))
    offset = h * largest / kappa
    weight = passed * cos_inside * offset
    slope = dr.sum(weight * (dr.asin(h) - dr.asin(h * largest))) / dr.maximum(dr.sum(weight * offset), 1e-37)
    furthest, share = most * largest / kappa, share * cos_inside
    reach = dr.sum(share * furthest * furthest) / dr.sum(share * furthest)
    return loss, dr.maximum(slope, 0), reach
