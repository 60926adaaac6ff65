"""The share of scattered light that leaves a fibre with reflecting exits: see `vellus::exit`."""

import math

import drjit as dr
import numpy as np

from . import states, turn
from .arrays import between, blend, blend2, cycle, entry, repeat, sums
from .states import ABSORPTIONS, ENTRIES, STATES
from .tables import G_MAX, TAU_SCALE

TINY = 1e-30
# Between these ratios of the second effective path to the first, the interpolation changes.
STEEP = 0.69, 0.25


def complement(x):
    """1 − e⁻ˣ."""
    series = x * (1 - x * (0.5 - x / 6))
    return dr.maximum(dr.select(x < 0.01, series, 1 - dr.exp(-x)), TINY)


def coefficients(F, nodes):
    """The coefficients of the polynomials with these values at the nodes of the entry: one block for each channel."""
    matrix = F(states.COEFFICIENTS.ravel())
    channels = dr.width(nodes) // ENTRIES
    blocks = dr.arange(dr.uint32_array_t(F), channels * ENTRIES * ENTRIES)
    values = dr.gather(F, nodes, blocks // (ENTRIES * ENTRIES) * ENTRIES + blocks % ENTRIES)
    return sums(values * cycle(matrix, channels), ENTRIES)


class Reflection:
    """Arrays have one block for each channel, with one number for each state or entry."""

    def __init__(self, grid, p):
        F = self.F = grid.F
        g = states.geometry()
        each = lambda a: F(np.tile(a, 3))
        tau = p.sigma_ms * p.kappa
        weight, chord, elongation = each(g.weight), each(g.chord), each(g.elongation)
        through = cycle(self.transmittance(p), 3)
        cos_gamma = dr.sqrt(1 - p.kappa * p.kappa * each(g.square))
        cortex = dr.maximum(cos_gamma - p.kappa * each(g.half_chord), 0) * elongation
        scattered = complement(tau * (1 - p.g) ** 0.7 * chord)
        excess = complement(tau * chord) / scattered
        taus, gs = grid.plain.exits.shape[:2]
        at_tau = between(dr.log(1 + TAU_SCALE * tau) * (1 / grid.plain.exit_step), taus)
        at_g = between(dr.log(1 - p.g) * ((gs - 1) / math.log(1 - G_MAX)), gs)
        rows = blend2(grid.exits, (STATES + ABSORPTIONS) * ENTRIES, at_tau, at_g, gs)
        self.first_rows = rows
        # A reflection takes light around the fibre by 2 (asin h″ − asin κh″), where cos asin h″ is half a chord.
        cos = each(g.half_chord) * cos_gamma + p.kappa * each(g.square)
        mean = lambda x: dr.sum(weight * x) / 3
        remains = turn.stays(tau * (1 - p.g), mean(2 * cos * cos - 1), 1 - mean(through))
        reaches = grid.plain.reaches
        at_reach = between((p.medulla.reach - reaches[0]) * (1 / (reaches[1] - reaches[0])), len(reaches))
        parts = blend(blend2(grid.turns, 3 * len(reaches), at_tau, at_g, gs), 3, at_reach)
        self.turning = turn.Turning(p, [entry(parts, k) for k in range(3)], remains)
        absorption = dr.concat([p.kappa * sigma for sigma in p.sigma_ma])
        cortical = repeat(dr.concat(list(p.sigma_ca)), STATES)

        # What absorption in the medulla leaves.
        ln_kept = coefficients(F, self.ln_kept(rows, absorption))
        chord_keeps = dr.exp(-chord * repeat(absorption, STATES))
        leaving = dr.exp(0.5 * dr.minimum(self.over_states(ln_kept), 0))
        kept = dr.clip(excess * (leaving * leaving - chord_keeps) + chord_keeps, 0, 1)
        inverse = 1 / dr.maximum(self.first_exits(leaving), TINY)

        # V = leaves + stays x.
        c = dr.exp(-cortex * cortical)
        returns = (1 - through) * c * c
        lost = through + (1 - through) * (1 - c * c)
        absorbed = (1 - scattered) * (1 - chord_keeps)
        scale = 1 / dr.maximum(lost + returns * (scattered + absorbed), 1e-20)
        at_once = through * c
        leaves = at_once * scale
        stays = returns * scattered * kept * scale
        again = weight * scattered * leaving
        numerator = sums(again * leaves, STATES)
        denominator = sums(again * scale * (lost + returns * (absorbed + scattered * (1 - kept))), STATES)
        x = repeat(numerator / dr.maximum(denominator, TINY), STATES)
        value = (leaves + stays * x) * leaving
        everything, at_first = (dr.clip(self.first_exits(v) * inverse, 0, 1) for v in (value, at_once * leaving))
        shares = dr.minimum(at_first / dr.maximum(everything, TINY), 1)
        split = lambda polynomial: [[entry(polynomial, ENTRIES * i + m) for m in range(ENTRIES)] for i in range(3)]
        polynomials = coefficients(F, everything), ln_kept, coefficients(F, shares)
        self.escape_of, self.ln_kept_of, self.first_of = map(split, polynomials)

    def over_states(self, polynomial):
        """The mean of a polynomial of the entry over each state.

        One gather, because Dr.Jit 1.5 loses gradients of several gathers from one array in a row of gathers.
        """
        k = dr.arange(dr.uint32_array_t(self.F), 3 * STATES * ENTRIES)
        coefficient = dr.gather(self.F, polynomial, k // (STATES * ENTRIES) * ENTRIES + k % ENTRIES)
        monomials = self.F(states.geometry().monomials.T.ravel())
        return sums(coefficient * cycle(monomials, 3), ENTRIES)

    def transmittance(self, p):
        """The transmittance of the cuticle for light in each state."""
        table = self.F(states.transmittance().reshape(-1, STATES, 2).transpose(0, 2, 1).ravel())
        least = states.LEAST_SQUARE
        at_kappa = between(p.kappa * p.kappa * (states.KAPPAS - 1), states.KAPPAS)
        index = (1 / (p.eta * p.eta) - least) / (1 - least)
        at_eta = between(index * (states.INDICES - 1), states.INDICES)
        both = blend2(table, 2 * STATES, at_kappa, at_eta, states.INDICES)
        entries = dr.arange(dr.uint32_array_t(self.F), STATES)
        through, back = (dr.gather(self.F, both, entries + k * STATES) for k in (0, 1))
        layered = dr.maximum(back * p.layers + through, 1e-20)
        even = (through + back) * (1 - states.UNEVEN) / layered
        return dr.minimum(through * (even + states.UNEVEN), 1)

    def ln_kept(self, rows, absorption):
        """The logarithm of what absorption in the medulla leaves of the light of each entry, channel by channel."""
        index, t = between(dr.log(1 + 4 * absorption) * (1 / math.log(3)), ABSORPTIONS)
        entries = dr.arange(dr.uint32_array_t(self.F), 3 * ENTRIES) % ENTRIES
        base = (repeat_index(index, ENTRIES) + STATES) * ENTRIES + entries
        low, high = (dr.gather(self.F, rows, base + k * ENTRIES) for k in (0, 1))
        t = repeat(t, ENTRIES)
        path = dr.lerp(low, high, t)
        # In a dense medulla the effective path falls fast from its mean, as 1/sqrt(a), and its inverse is linear.
        share = dr.clip((STEEP[0] - high / low) / (STEEP[0] - STEEP[1]), 0, 1)
        share = dr.select(repeat_index(index, ENTRIES) == 0, share, 0)
        path = 1 / dr.lerp(1 / path, dr.lerp(1 / low, 1 / high, t), share)
        # The product does not exceed that of the next node.
        node = (dr.exp((self.F(index) + 1) * math.log(3)) - 1) / 4
        return -dr.minimum(path * repeat(absorption, ENTRIES), high * repeat(node, ENTRIES))

    def first_exits(self, values):
        """The mean of a number for each state over first exits, at the nodes of the entry."""
        k = dr.arange(dr.uint32_array_t(self.F), 3 * ENTRIES * STATES)
        channel, node, state = k // (ENTRIES * STATES), k // STATES % ENTRIES, k % STATES
        table = dr.gather(self.F, self.first_rows, state * ENTRIES + node)
        return sums(table * dr.gather(self.F, values, channel * STATES + state), STATES)

    def at(self, sin2_t, chord):
        """The share of scattered light that leaves, the logarithm of a further factor, and the share of first exits.

        Each is RGB.
        """
        y = sin2_t * (1 / states.MAX_SIN2)

        def value(e):
            constant = (e[5] * y + e[2]) * y + e[0]
            linear = (e[7] * y + e[4]) * y + e[1]
            return ((e[6] * y + e[3]) * chord + linear) * chord + constant

        # Polynomials overshoot.
        return (
            [dr.clip(value(e), 0, 1) for e in self.escape_of],
            [dr.minimum(value(e), 0) for e in self.ln_kept_of],
            [dr.clip(value(e), 0, 1) for e in self.first_of],
        )

    @staticmethod
    def divide(escape, shares):
        """Divides escaping light into the part that leaves when it first meets the cuticle, and the rest.

        `shares`: the share of first exits of each channel. See `vellus::exit` for the limit.
        """
        most = dr.maximum(dr.maximum(escape[0], escape[1]), escape[2])
        squares = [e * e for e in escape]
        # Gradients contain the square of the inverse of this bound, which must not overflow in single precision.
        common = sum(s * w for s, w in zip(shares, squares)) / dr.maximum(sum(squares), 1e-18)
        limit = most * common
        first = [dr.minimum(dr.maximum(e * s, e - (most - limit)), limit) for e, s in zip(escape, shares)]
        return first, [dr.maximum(e - f, 0) for e, f in zip(escape, first)]


def repeat_index(index, times):
    return dr.gather(type(index), index, dr.arange(type(index), dr.width(index) * times) // times)
