"""The tables of the medulla as plain NumPy arrays, dense in their parameters.

The crate stores each table as a mixture: a sum over components of one factor per parameter. Each factor is linear
between its nodes, so the mixture is multilinear between the nodes of the dense table. A query of the dense table gives
the same values as a query of the mixture.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

import vellus

_RAW = vellus.tables()
# Constants of the crate's grid: see `vellus::grid`.
_GRID = _RAW["constants"]
TAU_GROWTH, TAU_SCALE, G_MAX, THETA_MAX = (_GRID[name] for name in ("tau_growth", "tau_scale", "g_max", "theta_max"))
CONES, SHIFTS = _GRID["cones"], _GRID["shifts"]
SMALLEST = math.asin(1 / _GRID["most_eta"])
# Nodes of the outgoing angle are half a degree apart in all tables.
STEP = math.pi / 360
# The azimuth from straight back begins at 0, the other angles here.
FIRST = -math.pi / 2


class Half(NamedTuple):
    """One half of C^M. τ, g and θ are the first three axes of each table."""

    values: np.ndarray  # C^M at the nodes of δ
    totals: np.ndarray  # its integral with the weight cos(δ − s), at shifts s from −0.5° to 90.5°
    weights: np.ndarray  # the weights of the components
    whole: np.ndarray  # (cone, shift, component): integrals over the cones
    lost: np.ndarray  # the same with the weight (η sin θ′)⁴


class Tables(NamedTuple):
    """All tables. g is the first axis of those over azimuth, so that those for one g are contiguous."""

    azimuthal: np.ndarray  # (g, τ, h, φ): C^N
    integrals: np.ndarray  # (2, g, τ, h): its integral, and that with the weight |φ|/π of the forward half
    mean_path: np.ndarray  # (g, τ, h)
    halves: tuple  # the backward and the forward Half
    exits: np.ndarray  # (τ, g, row, entry): first exits
    exit_step: float  # the distance between its nodes of τ in ln(1 + kτ)
    turns: np.ndarray  # (τ, g, reach, coefficient): the offset at which light leaves
    reaches: np.ndarray  # nodes of its limits


def forward_weight(phi):
    """|φ|/π for an azimuth in [0, 2π] from straight back: the weight of the forward half of C^M."""
    return 1 - np.abs(phi / np.pi - 1)


def moments(values, first, k):
    """∫ B cos kδ dδ and ∫ B sin kδ dδ from the first node to each node; B is linear between nodes on the last axis."""
    x = first + STEP * np.arange(values.shape[-1])
    slope = np.diff(values) / STEP
    sin, cos = np.sin(k * x), np.cos(k * x)
    steps = (
        np.diff(values * sin) / k + slope * np.diff(cos) / k**2,
        -np.diff(values * cos) / k + slope * np.diff(sin) / k**2,
    )
    zero = np.zeros(values.shape[:-1] + (1,))
    return [np.concatenate([zero, np.cumsum(step, -1)], -1) for step in steps]


def six_moments(values, first):
    """The moments for k = 1, 3 and 5 on a new last axis."""
    return np.stack([m for k in (1, 3, 5) for m in moments(values, first, k)], -1)


def view(shift, eta, loss):
    """The factors of the six moments in ∫ B T cos θ′ dδ, with θ′ = δ − `shift` and T = 1 − `loss` (η sin θ′)⁴."""
    part = loss * eta**4 / 16
    factors = (1 - 2 * part, 3 * part, -part)
    return np.stack([f * turn(k * shift) for f, k in zip(factors, (1, 3, 5)) for turn in (np.cos, np.sin)], -1)


def over_cones(values, first, shifts):
    """The integrals of each component over each cone, for shifts from its axis to its edge: (2, cone, shift, r)."""
    rank, nodes = values.shape
    angle = SMALLEST + (np.pi / 2 - SMALLEST) * np.arange(CONES) / (CONES - 1)
    angle, part = np.meshgrid(angle, np.arange(shifts) / max(shifts - 1, 1), indexing="ij")
    shift, eta = angle * part, 1 / np.sin(angle)
    columns = np.moveaxis(six_moments(values, first), 0, -1)  # node, moment, component

    def total(loss):
        factors = view(shift, eta, loss)
        weight = lambda delta: np.maximum(np.cos(delta - shift) * (1 - loss * (eta * np.sin(delta - shift)) ** 4), 0)[
            ..., None
        ]
        sums = 0
        for sign in (-1, 1):
            delta = np.clip(shift + sign * angle, first, first + STEP * (nodes - 1))
            x = np.clip((delta - first) / STEP, 0, nodes - 1)
            # The nearest node inside the cone. The rest of the interval is a trapezium, as in the crate.
            node = (np.ceil(x - 1e-9) if sign < 0 else np.floor(x + 1e-9)).astype(int)
            low = np.minimum(x.astype(int), nodes - 2)
            t = (x - low)[..., None]
            outer = values.T[low] * (1 - t) + values.T[low + 1] * t
            inside = first + STEP * node
            edge = 0.5 * (delta - inside)[..., None] * (weight(inside) * values.T[node] + weight(delta) * outer)
            sums = sums + sign * (np.einsum("csk,cskr->csr", factors, columns[node]) + edge)
        return sums

    whole = total(0.0)
    return whole, np.maximum(whole - total(1.0), 0)


def half(factors, shifts):
    tau, g, theta, values = factors
    values = values.T
    weights = np.einsum("ar,br,cr->abcr", tau, g, theta)
    # Both ends of the half circle around a shift are nodes.
    cos, sin = moments(values, FIRST, 1)
    k = np.arange(-1, 182)
    s = k * STEP
    low, high = np.clip([k, k + 360], 0, values.shape[1] - 1)
    totals = np.cos(s) * (cos[:, high] - cos[:, low]) + np.sin(s) * (sin[:, high] - sin[:, low])
    return Half(weights @ values, weights @ np.maximum(totals, 0), weights, *over_cones(values, FIRST, shifts))


def factors(table):
    """The factors over the parameters and the outgoing angle: four arrays (node, component)."""
    return [np.asarray(values, float) for name, values in table.items() if not name.endswith("_nodes")]


@lru_cache(1)
def shipped():
    """The tables that the package contains."""
    tau, g, h, values = factors(_RAW["azimuthal"])
    step = 2 * np.pi / (len(values) - 1)
    values = values / (step * np.maximum(0.5 * (values[:-1] + values[1:]).sum(0), 1e-300))
    w = forward_weight(step * np.arange(len(values)))[:, None]
    low, high, w0, w1 = values[:-1], values[1:], w[:-1], w[1:]
    ahead = ((2 * w0 + w1) * low + (w0 + 2 * w1) * high).sum(0) * step / 6
    weights = np.einsum("ar,br,cr->bacr", tau, g, h)
    integrals = np.stack([weights.sum(-1), weights @ ahead])
    halves = [half(factors(_RAW[name]), n) for name, n in (("backward", 1), ("forward", SHIFTS))]
    exit = _RAW["exit"]
    exits = np.concatenate([exit[name] for name in ("state", "path")], 2).astype(float)
    exit_step = math.log1p(TAU_SCALE * exit["tau_nodes"][1])
    mean_path = np.asarray(_RAW["mean_path"]["value"], float).transpose(1, 0, 2)
    azimuthal, turns = weights @ values.T, exit["turn"].astype(float)
    return Tables(azimuthal, integrals, mean_path, tuple(halves), exits, exit_step, turns, exit["reach_nodes"])
