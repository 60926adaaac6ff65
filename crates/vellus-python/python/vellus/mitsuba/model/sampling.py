"""Draws a direction from the lobes. Nothing here has gradients. See the functions `sample` of the crate's modules."""

import drjit as dr
import numpy as np

from .path import DIFFUSE, REST
from .tables import FIRST, STEP, forward_weight, six_moments

# The normal quantile is at most 5.3.
EDGE = 6e-8


def choose(weights, u):
    """The index of a weight, chosen in proportion to the weights, which sum to 1. Never one that is 0."""
    index, chosen, total = dr.uint32_array_t(type(u))(0), dr.mask_t(u)(False), 0
    for i, weight in enumerate(weights):
        total = weight + total
        # If rounding leaves a rest, the last item with a weight is chosen.
        index = dr.select((weight > 0) & ~chosen, i, index)
        chosen |= (u < total) & (weight > 0)
    return index


def select(index, values):
    """The value of each lane's index."""
    result = values[0]
    for i, value in enumerate(values[1:], 1):
        result = dr.select(index == i, value, result)
    return result


def rescale(u, share):
    """Whether `u` is below `share`, and a new uniform number."""
    below = u < share
    rest = dr.select(below, u / dr.maximum(share, 1e-30), (u - share) / dr.maximum(1 - share, 1e-30))
    return below, dr.clip(rest, 0, dr.one_minus_epsilon(type(u)))


def invert(nodes, first, last, start, stop, u, cumulative, at):
    """The position with the share `u` of an integral below it. The density is linear between nodes.

    `nodes`: their number. `first`, `last`: those next to the ends of the range, inside. `start`, `stop`: position,
    integral and density at the ends. `cumulative(i)`: the integral at a node. `at(i)`: all three.
    """
    target = dr.lerp(start[1], stop[1], u)
    beyond = dr.binary_search(0, nodes, lambda i: (i <= first) | ((i <= last) & (cumulative(i) <= target)))
    node = dr.clip(dr.int32_array_t(type(u))(beyond) - 1, 0, nodes - 1)
    node = dr.uint32_array_t(type(u))(node)
    here, following = at(node), at(dr.minimum(node + 1, nodes - 1))
    before, at_end = target < here[1], node >= last
    low = [dr.select(before, a, b) for a, b in zip(start, here)]
    high = [dr.select(before, a, dr.select(at_end, b, c)) for a, b, c in zip(here, stop, following)]
    (x0, m0, f0), (x1, m1, f1) = low, high
    t = dr.select(m1 > m0, dr.clip((target - m0) / dr.maximum(m1 - m0, 1e-37), 0, 1), u)
    # Root of the quadratic cumulative, in the form without cancellation.
    bottom = f0 + dr.sqrt(dr.maximum(f0 * f0 + t * (f1 * f1 - f0 * f0), 0))
    x = dr.select(bottom > 0, t * (f0 + f1) / dr.maximum(bottom, 1e-37), t)
    return dr.lerp(x0, x1, dr.clip(x, 0, 1))


class Sampler:
    """Cumulative tables of the scattered lobes of one fibre."""

    def __init__(self, medulla):
        F = type(medulla.azimuthal)
        self.medulla = medulla
        nodes = medulla.azimuths
        table = dr.detach(medulla.azimuthal).numpy().reshape(-1, nodes).astype(float)
        phi = np.linspace(0, 2 * np.pi, nodes)
        w = forward_weight(phi)
        low, high = table[:, :-1], table[:, 1:]
        step = phi[1]
        whole = 0.5 * (low + high) * step
        ahead = ((2 * w[:-1] + w[1:]) * low + (w[:-1] + 2 * w[1:]) * high) * (step / 6)
        # One after the other: the backward half, the forward half, both.
        parts = [np.pad(np.cumsum(part, 1), ((0, 0), (1, 0))) for part in (whole - ahead, ahead, whole)]
        self.azimuthal = F(np.concatenate(parts).ravel())
        self.part = dr.width(medulla.azimuthal)
        # Both halves of C^M, one after the other.
        self.moments, self.values, starts = [], [], [0]
        for half in medulla.halves:
            values = dr.detach(half.values).numpy().reshape(-1, half.nodes).astype(float)
            self.values.append(values.ravel())
            self.moments.append(six_moments(values, FIRST).ravel())
            starts.append(starts[-1] + values.size)
        self.forward_start = starts[1]
        self.values, self.moments = F(np.concatenate(self.values)), F(np.concatenate(self.moments))
        dr.eval(self.azimuthal, self.values, self.moments)

    def azimuth(self, azimuth, part, u):
        """An azimuth in [−2π, 2π] from straight back. `part`: 0 and 1 are the weights of the halves, 2 is neither."""
        nodes = self.medulla.azimuths
        step = 2 * np.pi / (nodes - 1)
        turned, u = rescale(u, azimuth.turned)
        cumulative = lambda i: azimuth.corners(self.azimuthal, nodes, part * self.part + i)

        def at(i):
            phi = type(u)(i) * step
            forward = 1 - dr.abs(phi * dr.inv_pi - 1)
            weight = select(part, [1 - forward, forward, 1])
            return phi, cumulative(i), weight * azimuth.corners(self.medulla.azimuthal, nodes, i)

        U = dr.uint32_array_t(type(u))
        first, last = U(0), U(nodes - 1)
        phi = invert(nodes, first, last, at(first), at(last), u, cumulative, at)
        return dr.select(turned, -phi, phi) * azimuth.mirror

    def inclination(self, inclination, forward, u):
        """sin θᵢ and cos θᵢ of light that leaves in the given half."""
        medulla = self.medulla
        U = dr.uint32_array_t(type(u))
        back, ahead = (half.nodes for half in medulla.halves)
        nodes = dr.select(forward, U(ahead), U(back))
        base = dr.select(forward, self.forward_start, U(0))
        shift = dr.select(forward, inclination.shift, 0)
        quartic = medulla.loss * dr.square(dr.square(medulla.eta))
        part = quartic * (1 / 16)
        factors = []
        for k, f in ((1, 1 - 2 * part), (3, 3 * part), (5, -part)):
            sin, cos = dr.sincos(k * shift)
            factors += [f * cos, f * sin]
        row, t = inclination.at

        def blended(get):
            return dr.lerp(get(base + row * nodes), get(base + (row + 1) * nodes), t)

        def cumulative(i):
            column = lambda k: blended(lambda start: dr.gather(type(u), self.moments, (start + i) * 6 + k))
            return sum(f * column(k) for k, f in enumerate(factors))

        def weight(delta):
            sin, cos = dr.sincos(delta - shift)
            return dr.maximum(cos * (1 - quartic * dr.square(dr.square(sin))), 0)

        value = lambda i: blended(lambda start: dr.gather(type(u), self.values, start + i))
        angle = lambda i: FIRST + STEP * type(u)(i)
        at = lambda i: (angle(i), cumulative(i), value(i) * weight(angle(i)))
        highest = angle(nodes - 1)
        ends = [dr.clip(shift + sign * medulla.half, FIRST, highest) for sign in (-1, 1)]
        # Rounding must not put a node of the range outside it.
        x = [(end - FIRST) * (1 / STEP) for end in ends]
        first = dr.minimum(U(dr.ceil(x[0])), nodes - 1)
        last = dr.minimum(U(dr.floor(x[1])), nodes - 1)

        def end(delta, node):
            x = (delta - FIRST) * (1 / STEP)
            index = dr.minimum(U(x), nodes - 2)
            fraction = dr.clip(x - type(u)(index), 0, 1)
            outer = dr.lerp(value(index), value(index + 1), fraction) * weight(delta)
            position, integral, inner = at(node)
            return delta, integral + 0.5 * (inner + outer) * (delta - position), outer

        largest = max(back, ahead)
        clamped = lambda f: lambda i: f(dr.minimum(U(i), nodes - 1))
        delta = invert(
            largest, first, last, end(ends[0], first), end(ends[1], last), u, clamped(cumulative), clamped(at)
        )
        theta = (delta - shift) * inclination.mirror
        sin_i = dr.clip(medulla.eta * dr.sin(theta), -1, 1)
        return sin_i, dr.sqrt((1 - sin_i) * (1 + sin_i))

    def draw(self, hit, exit, u):
        """sin θᵢ, cos θᵢ and φ of a scattered lobe with this exit azimuth."""
        azimuth, inclination = hit.azimuth, hit.inclination
        U = dr.uint32_array_t(type(u[0]))
        if self.medulla.refracts:
            # First a half, then the azimuth under its weight.
            whole, ahead = (azimuth.corners(table, 1, 0) for table in self.medulla.integrals)
            behind = (whole - ahead) * inclination.leaving[0]
            ahead = ahead * inclination.leaving[1]
            forward, _ = rescale(u[0], ahead / dr.maximum(behind + ahead, 1e-30))
            phi = self.azimuth(azimuth, dr.select(forward, U(1), U(0)), u[2])
        else:
            phi = self.azimuth(azimuth, U(2), u[2])
            wrapped = phi - dr.two_pi * dr.round(phi * dr.inv_two_pi)
            forward, _ = rescale(u[0], dr.abs(wrapped) * dr.inv_pi)
        return *self.inclination(inclination, forward, u[1]), phi + exit


def draw(hit, u):
    """sin θᵢ, cos θᵢ and φ_i − φ_o from four uniform numbers: one for the lobe, two for θᵢ, one for the azimuth."""
    fiber, (u0, u1, u2, u3) = hit.fiber, u
    lobe = choose(hit.probability, u0)
    # R, TT, TRT and the rest: a direction of the spherical Gaussian. The density of `drop` is that of its height.
    shape = dr.select(lobe == REST, 3, dr.minimum(lobe, 2))
    lines = fiber.longitudinal
    s, c = (select(shape, [centre[k] for centre in hit.centres]) for k in (0, 1))
    v, floor = select(shape, lines.v), select(shape, lines.floor)
    drop = dr.clip(-v * dr.log(dr.maximum(u1 + (1 - u1) * floor, 1e-37)), 0, 2)
    cos, sin = 1 - drop, dr.sqrt(drop * (2 - drop))
    sin_turn, cos_turn = dr.sincos(dr.two_pi * u2)
    sin_i, across = cos * s + sin * cos_turn * c, cos * c - sin * cos_turn * s
    cos_i = dr.sqrt(dr.square(across) + dr.square(sin * sin_turn))
    quantile = dr.sqrt_two * dr.erfinv(2 * dr.clip(u3, EDGE, 1 - EDGE) - 1)
    phi = select(shape, [e + sigma * quantile for e, sigma in zip(hit.exits, fiber.azimuthal.sigma)] + [dr.two_pi * u3])
    if fiber.scatters:
        diffuse = lobe == DIFFUSE
        sin_d = dr.sqrt(u1) * cos_turn
        sin_i, phi = dr.select(diffuse, sin_d, sin_i), dr.select(diffuse, dr.two_pi * u3, phi)
        cos_i = dr.select(diffuse, dr.sqrt(dr.maximum((1 - sin_d) * (1 + sin_d), 0)), cos_i)
        scattered = (lobe == 3) | (lobe == 4)
        exit = dr.select(lobe == 3, *hit.scattered_exits)
        parts = fiber.medulla.sampler.draw(hit, exit, (u1, u2, u3))
        sin_i, cos_i, phi = (dr.select(scattered, a, b) for a, b in zip(parts, (sin_i, cos_i, phi)))
    if fiber.reflects:
        for component, turn in zip((3, 4, DIFFUSE), hit.turns):
            phi = dr.select(lobe == component, turn.leaving(phi), phi)
    return sin_i, cos_i, phi
