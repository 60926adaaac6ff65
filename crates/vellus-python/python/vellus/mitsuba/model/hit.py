"""The near field: everything about a hit, and its queries. See `vellus::near`."""

import drjit as dr

from .arrays import wrap
from .medulla import Azimuth, Inclination
from .path import DIFFUSE, REST, Path
from .sampling import draw


class Hit:
    """One hit of a fibre at an offset."""

    def __init__(self, fiber, wo, h):
        self.fiber = fiber
        x, y, z = wo
        sin_o = dr.clip(x, -1, 1)
        cos_o = dr.sqrt(dr.maximum(y * y + z * z, 1e-24))
        # Along the axis the azimuth is arbitrary.
        along = cos_o < 1e-11
        self.cos, self.sin = dr.select(along, 1, y / cos_o), dr.select(along, 0, z / cos_o)
        path = self.path = Path(fiber, sin_o, cos_o, dr.clip(h, -1, 1))
        self.centres = fiber.longitudinal.centres(sin_o, cos_o)
        self.exits, self.scattered_exits = path.exits(), path.scattered_exits()
        mean_path = None
        if fiber.scatters:
            self.inclination = Inclination(fiber.medulla, path.theta)
            self.azimuth = Azimuth(fiber.medulla, path.elongation, path.gamma_m(), self.inclination.leaving)
            mean_path = None if fiber.reflects else self.azimuth.mean_path()
        if fiber.reflects:
            self.scattered_exits, self.turns = fiber.reflection.turning.at(path)
        self.attenuation = path.attenuation(mean_path if fiber.scatters else 0)
        with dr.suspend_grad():
            most = [dr.maximum(dr.maximum(r, g), b) for r, g, b in self.attenuation]
            scale = 1 / dr.maximum(sum(most[1:], most[0]), 1e-30)
            self.probability = [dr.detach(p * scale) for p in most]

    def densities(self, sin_i, cos_i, phi):
        """The densities of the components over solid angle; `phi` is φ_i − φ_o."""
        fiber = self.fiber
        m = fiber.longitudinal.eval(self.centres, sin_i, cos_i)
        n = fiber.azimuthal.eval(self.exits, phi)
        d = [m[p] * n[p] for p in range(3)] + [0, 0, m[3] * dr.inv_two_pi, cos_i * dr.inv_pi**2]
        if fiber.scatters:
            theta = fiber.medulla.inside(sin_i, cos_i)
            back, ahead = self.inclination.eval(theta, fiber.medulla.transmittance(sin_i))
            around = dr.sincos(phi)
            for p, exit in enumerate(self.scattered_exits):
                turned, slope = self.turns[p].inside(*around) if fiber.reflects else (0, 1)
                relative = wrap(phi - exit + turned)
                c_m = dr.lerp(back, ahead, dr.abs(relative) * dr.inv_pi)
                d[3 + p] = dr.select(self.path.exists, slope * c_m * self.azimuth.eval(relative), 0)
            if fiber.reflects:
                d[DIFFUSE] = d[DIFFUSE] * self.turns[2].inside(*around)[1]
        return d

    def outgoing(self, wi):
        """sin θᵢ, cos θᵢ and φ_i − φ_o of a direction."""
        x, y, z = wi
        phi = dr.atan2(z * self.cos - y * self.sin, y * self.cos + z * self.sin)
        return x, dr.sqrt(dr.maximum(y * y + z * z, 1e-24)), phi

    def lobes(self, wi):
        """f·cos θᵢ of R, TT, TRT, TTs, TRTs and the rest, RGB."""
        d = self.densities(*self.outgoing(wi))
        lobes = [[a * d[p] for a in self.attenuation[p]] for p in range(DIFFUSE)]
        lobes[REST] = [light + a * d[DIFFUSE] for light, a in zip(lobes[REST], self.attenuation[DIFFUSE])]
        return lobes

    def total(self, densities):
        channel = lambda c: sum(
            (a[c] * d for a, d in zip(self.attenuation[1:], densities[1:])), self.attenuation[0][c] * densities[0]
        )
        return [channel(c) for c in range(3)]

    def density(self, densities):
        return sum(p * dr.detach(d) for p, d in zip(self.probability, densities))

    def eval(self, wi):
        """f·cos θᵢ, RGB."""
        return self.total(self.densities(*self.outgoing(wi)))

    def pdf(self, wi):
        """The density per solid angle with which `sample` draws `wi`. It has no gradient."""
        return self.eval_pdf(wi)[1]

    def eval_pdf(self, wi):
        d = self.densities(*self.outgoing(wi))
        return self.total(d), self.density(d)

    def sample(self, u):
        """Draws ω_i from four uniform numbers: for the lobe, two for the inclination, and one for the azimuth.

        Returns ω_i, its density per solid angle, and f·cos θᵢ over the density, RGB. The direction and the density have
        no gradient.
        """
        with dr.suspend_grad():
            sin_i, cos_i, phi = draw(self, u)
            sin_phi, cos_phi = dr.sincos(phi)
            y, z = cos_phi * self.cos - sin_phi * self.sin, sin_phi * self.cos + cos_phi * self.sin
            wi = [sin_i, cos_i * y, cos_i * z]
        d = self.densities(sin_i, cos_i, phi)
        pdf = self.density(d)
        inverse = dr.select(pdf > 0, 1 / dr.maximum(pdf, 1e-37), 0)
        return wi, pdf, [f * inverse for f in self.total(d)]
