"""The light that the medulla scatters: C^N, C^M and ⟨L⟩ from the tables. See `vellus::medulla`."""

import math

import drjit as dr

from . import cuticle
from .arrays import between, blend, blend2, cycle, pair, sums
from .sampling import Sampler
from .tables import CONES, G_MAX, SHIFTS, SMALLEST, STEP, TAU_GROWTH, TAU_SCALE, THETA_MAX

# Below this angle asin h″ a part of C^N is mirrored.
MIRROR_REACH = dr.pi / 360


def backward_gain(p):
    """What absorption in the medulla leaves of the backward half, over what it leaves of the forward half."""
    isotropic = p.sigma_ms * p.kappa * (1 - p.g)
    a = sum(dr.minimum(sigma * p.kappa, 2) for sigma in p.sigma_ma) / 3
    longer = 0.61 + 4.49 * isotropic / (isotropic + 7.06) - 1.46 * p.g + 0.263 * a
    return dr.exp(a * longer / (1 + 0.608 * a * isotropic))


class Inclination:
    """C^M for one inclination at which light enters."""

    def __init__(self, medulla, theta):
        self.medulla = medulla
        self.mirror = dr.select(theta < 0, -1, 1)
        self.shift = dr.abs(theta)
        self.at = between(self.shift * ((medulla.thetas - 1) / THETA_MAX), medulla.thetas)
        back, ahead = medulla.halves
        all_b, all_f = back.total(self.at, 0 * theta), ahead.total(self.at, self.shift)
        if medulla.refracts:
            # D18: with refraction, a density in sin θᵢ = η sin θ′.
            all_f = all_f * medulla.backward_gain
            leaving = [half.over_cone(self.at, self.shift) for half in medulla.halves]
            self.scale = [all_f / medulla.eta, all_b / medulla.eta]
            self.leaving = [all_f * leaving[0], all_b * leaving[1]]
        else:
            ahead_integral = ahead.total(self.at, self.shift, cubic=True)
            self.scale = [1 / dr.maximum(z, 1e-30) for z in (all_b, ahead_integral)]
            self.leaving = [1.0, 1.0]

    def eval(self, theta, transmittance):
        """C^M of the backward and the forward half at the angle θ′ inside: densities in sin θᵢ."""
        theta = theta * self.mirror
        back, ahead = self.medulla.halves
        return (
            self.scale[0] * transmittance * back.eval(self.at, theta),
            self.scale[1] * transmittance * ahead.eval(self.at, theta + self.shift),
        )


class Azimuth:
    """C^N of one path: `angle` is asin h″ with its sign."""

    def __init__(self, medulla, elongation, angle, leaving):
        self.medulla = medulla
        taus, offsets = medulla.shape
        tau = dr.log(1 + TAU_SCALE * medulla.optical_radius * elongation)
        self.tau = between(tau * ((taus - 1) / TAU_GROWTH), taus)
        self.offset = between(dr.abs(angle) * ((offsets - 1) * 2 / dr.pi), offsets)
        whole, ahead = (self.corners(table, 1, 0) for table in medulla.integrals)
        total = whole * leaving[0] + ahead * (leaving[1] - leaving[0])
        self.scale = dr.select(total > 0, 1 / dr.select(total > 0, total, 1), 0)
        self.mirror = dr.select(angle < 0, -1, 1)
        x = dr.minimum(dr.abs(angle) * (1 / MIRROR_REACH), 1)
        self.turned = 0.5 * dr.square(1 - x)

    def corners(self, table, size, at, active=True):
        """The blend over τ and h″ of the entry `at` of the blocks of this size."""
        (i, s), (j, t) = self.tau, self.offset
        offsets = self.medulla.shape[1]
        get = lambda k, m: dr.gather(type(table), table, ((i + k) * offsets + j + m) * size + at, active)
        return dr.lerp(dr.lerp(get(0, 0), get(0, 1), t), dr.lerp(get(1, 0), get(1, 1), t), s)

    def plain(self, phi, active=True):
        nodes = self.medulla.azimuths
        index, t = between(dr.select(phi < 0, phi + dr.two_pi, phi) * ((nodes - 1) / dr.two_pi), nodes)
        low, high = (self.corners(self.medulla.azimuthal, nodes, index + k, active) for k in (0, 1))
        return dr.lerp(low, high, t)

    def eval(self, phi):
        """The density at an azimuth from straight back, in [−π, π]."""
        phi = phi * self.mirror
        value = self.plain(phi)
        mirrored = self.turned > 0
        value = dr.select(mirrored, dr.lerp(value, self.plain(-phi, mirrored), self.turned), value)
        return self.scale * value

    def mean_path(self):
        return self.corners(self.medulla.mean_path, 1, 0)


class Half:
    """One half of C^M for one τ and g."""

    def __init__(self, grid, which, tau, g, medulla):
        F, table, plain = grid.F, grid.halves[which], grid.plain.halves[which]
        taus, gs, thetas, self.nodes = plain.values.shape
        self.medulla, self.totals_nodes = medulla, plain.totals.shape[-1]
        at_tau, at_g = between(tau * (taus - 1), taus), between(g * (gs - 1), gs)
        fixed = lambda t, size: blend2(t, thetas * size, at_tau, at_g, gs)
        self.values, self.totals = fixed(table.values, self.nodes), fixed(table.totals, self.totals_nodes)
        if medulla.refracts:
            rank = plain.weights.shape[-1]
            self.shifts = plain.whole.shape[1]
            weights = fixed(table.weights, rank)
            cone = between((medulla.half - SMALLEST) * ((CONES - 1) / (dr.pi / 2 - SMALLEST)), CONES)
            size = self.shifts * rank
            z = dr.maximum(blend(table.whole, size, cone) - medulla.loss * blend(table.lost, size, cone), 0)
            # The product of (θ, component) and (shift, component).
            k = dr.arange(grid.U, thetas * size)
            products = dr.gather(F, weights, k // size * rank + k % rank) * cycle(z, thetas)
            self.leaving = sums(products, rank)

    def rows(self, at, table, size, x):
        """The blend over θ of the table's entries at the position x."""
        (i, s), (j, t) = at, between(x, size)
        row = lambda k: pair(table, (i + k) * size + j, t)
        return dr.lerp(row(0), row(1), s)

    def eval(self, at, delta):
        return self.rows(at, self.values, self.nodes, (delta + dr.pi / 2) * (1 / STEP))

    def total(self, at, shift, cubic=False):
        """The integral of C^M over all inclinations."""
        size, x = self.totals_nodes, shift * (1 / STEP)
        if not cubic:
            return self.rows(at, self.totals, size, x + 1)
        # Lagrange's polynomials on the nodes −1, 0, 1, 2.
        (i, s), (j, t) = at, between(x, size - 2)
        a, b, c = t + 1, t - 1, t - 2
        weights = [-t * b * c / 6, a * b * c / 2, -a * t * c / 2, a * t * b / 6]
        get = lambda k, m: dr.gather(type(t), self.totals, (i + k) * size + j + m)
        row = lambda k: sum(w * get(k, m) for m, w in enumerate(weights))
        return dr.lerp(row(0), row(1), s)

    def over_cone(self, at, shift):
        """The integral over the cone of light that leaves."""
        if self.shifts == 1:
            return pair(self.leaving, *at)
        return self.rows(at, self.leaving, self.shifts, shift / self.medulla.half * (self.shifts - 1))


class Medulla:
    """The tables for one fibre."""

    def __init__(self, grid, p):
        plain = grid.plain
        gs, taus, offsets, self.azimuths = plain.azimuthal.shape
        self.shape, self.thetas = (taus, offsets), plain.halves[0].values.shape[2]
        self.optical_radius = p.sigma_ms * p.kappa
        tau = dr.log(1 + TAU_SCALE * self.optical_radius) * (1 / TAU_GROWTH)
        g = dr.log(1 - p.g) * (1 / math.log(1 - G_MAX))
        at_g = between(g * (gs - 1), gs)
        self.azimuthal = blend(grid.azimuthal, taus * offsets * self.azimuths, at_g)
        self.integrals = [blend(table, taus * offsets, at_g) for table in grid.integrals]
        path_gs = plain.mean_path.shape[0]
        self.mean_path = blend(grid.mean_path, taus * offsets, between(g * (path_gs - 1), path_gs))
        self.refracts = p.reflects
        self.eta = p.eta if p.reflects else type(p.eta)(1)
        self.loss = type(p.eta)(0)
        if p.reflects:
            self.loss, self.slope, self.reach = cuticle.outward(grid.F, p.eta, p.kappa, p.layers)
            self.backward_gain = backward_gain(p)
        inverse = 1 / self.eta
        self.excess = dr.maximum((1 - inverse) * (1 + inverse), 0)
        self.half = dr.atan2(inverse, dr.sqrt(dr.maximum(self.excess, 1e-12)))
        self.halves = [Half(grid, which, tau, g, self) for which in (0, 1)]
        self.sampler = Sampler(self)

    def inside(self, sin_i, cos_i):
        """θ′ inside the fibre."""
        return dr.atan2(sin_i / self.eta, dr.sqrt(dr.maximum(cos_i * cos_i + sin_i * sin_i * self.excess, 1e-20)))

    def transmittance(self, sin_i):
        """T(sin θᵢ)."""
        if not self.refracts:
            return 1
        return dr.maximum(1 - self.loss * dr.square(dr.square(sin_i)), 0)
