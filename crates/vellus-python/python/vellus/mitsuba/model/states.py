"""The states of scattered light that meets the cuticle from inside: see `vellus::exit::states` and `exit::cone`."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

INCLINATIONS, OFFSETS = 6, 4
STATES, ENTRIES, ABSORPTIONS = INCLINATIONS * OFFSETS, 8, 6
MAX_SIN2 = 0.9
# c and y of the nodes of the entry.
NODES = np.array([[0, 0], [0.5, 0], [1, 0], [0, 0.5], [1, 0.5], [0, 1], [0.5, 1], [1, 1]])
# Nodes of κ² in [0, 1] and of 1/η² in [1/9, 1], for the transmittance of the cuticle.
KAPPAS, INDICES, LEAST_SQUARE = 17, 37, 1 / 9
# The share of light that is taken as reflected wholly or not at all.
UNEVEN = 0.03


def monomials(c, y):
    return np.stack([1 + 0 * c, c, y, c * c, c * y, y * y, c * c * y, c * y * y], -1)


# Coefficients of the polynomial that is 1 at one node and 0 at the others: (monomial, node).
COEFFICIENTS = np.round(np.linalg.inv(monomials(NODES[:, 0], NODES[:, 1])), 9)


class Geometry(NamedTuple):
    """Means over each state, weighted by cos²θ′."""

    weight: np.ndarray
    elongation: np.ndarray
    half_chord: np.ndarray
    chord: np.ndarray
    square: np.ndarray
    monomials: np.ndarray  # (monomial, state)


def cells():
    """The ends of |θ′| and of |h″| of each state: four arrays."""
    i, j = np.divmod(np.arange(STATES), OFFSETS)
    step = np.pi / 2 / INCLINATIONS
    return i * step, (i + 1) * step, j / OFFSETS, (j + 1) / OFFSETS


def squared(x):
    """∫ cos²."""
    return 0.5 * x + 0.25 * np.sin(2 * x)


@lru_cache(1)
def geometry():
    a, b, low, high = cells()
    weight = squared(b) - squared(a)
    segment = lambda h: 0.5 * (np.arcsin(h) + h * np.sqrt(1 - h * h))
    half_chord = (segment(high) - segment(low)) * OFFSETS
    elongation = (np.sin(b) - np.sin(a)) / weight
    x = (np.arange(16) + 0.5) / 16
    theta = (a[:, None] + (b - a)[:, None] * x)[:, :, None]
    h = (low[:, None] + x / OFFSETS)[:, None, :]
    values = monomials(np.sqrt(1 - h * h) + 0 * theta, np.sin(theta) ** 2 / MAX_SIN2 + 0 * h)
    cos2 = np.cos(theta)[..., None] ** 2
    mean = (values * cos2).sum((1, 2)) / (16 * cos2.sum((1, 2)))
    share = weight / (0.25 * np.pi * OFFSETS)
    return Geometry(share, elongation, half_chord, 2 * elongation * half_chord, (0.5 * (low + high)) ** 2, mean.T)


def one_slab(eta, cos):
    """The reflected and the transmitted share of one cuticle slab."""
    inside = np.sqrt(np.maximum(1 - (1 - cos * cos) / eta**2, 0))
    a, b, c, d = cos, eta * inside, eta * cos, inside
    s, p = a * a + b * b, c * c + d * d
    back, through = 0.5 * ((a - b) ** 2 * p + (c - d) ** 2 * s), np.maximum(a * b * p + c * d * s, 1e-30)
    return back / (back + through), through / (back + through)


@lru_cache(1)
def transmittance():
    """(κ², 1/η², state, 2): the shares of a state that one slab transmits and that it reflects partly."""
    x, w = np.polynomial.legendre.leggauss(4)
    kappa = np.sqrt(np.arange(KAPPAS) / (KAPPAS - 1))[:, None, None]
    eta = 1 / np.sqrt(LEAST_SQUARE + (1 - LEAST_SQUARE) * np.arange(INDICES) / (INDICES - 1))[None, :, None]
    a, b, low, high = (end[None, None] + 0 * (kappa + eta) for end in cells())
    critical = np.sqrt(np.maximum(1 - 1 / (eta * eta), 0))
    # The offset at which light of the inclination θ′ reaches the critical angle. The integrand has a kink there.
    kink = lambda theta: np.clip(
        np.sqrt(np.maximum(1 - (critical / np.cos(theta)) ** 2, 0)) / np.maximum(kappa, 1e-9), low, high
    )
    ends = [low, np.where(kappa > 0, kink(b), low), np.where(kappa > 0, kink(a), low), high]
    sums = np.zeros(a.shape + (2,))
    for start, stop in zip(ends, ends[1:]):
        for xh, wh in zip(x, w):
            h = 0.5 * (start + stop) + 0.5 * (stop - start) * xh
            cos_gamma = np.sqrt(1 - (kappa * h) ** 2)
            last = np.minimum(np.arccos(np.minimum(critical / np.maximum(cos_gamma, 1e-12), 1)), b)
            for xt, wt in zip(x, w):
                # The reflectance rises with a square root at the critical angle.
                s = 0.5 + 0.5 * xt
                theta = last - (last - a) * s * s
                cos = np.cos(theta) * cos_gamma
                shares = one_slab(eta, np.sqrt(np.maximum(1 - eta**2 * (1 - cos * cos), 0)))
                light = 0.5 * wh * (stop - start) / (high - low) * wt * s * (last - a) * np.cos(theta) ** 2
                sums += np.where(last > a, light, 0)[..., None] * np.stack(shares[::-1], -1)
    return sums / (squared(b) - squared(a))[..., None]
