"""The BSDF `vellus_drjit`: the near field in Dr.Jit, with gradients of all parameters."""

from functools import lru_cache

import drjit as dr
import mitsuba as mi

from . import properties
from .frame import offset, split, to_fiber, to_mitsuba
from .model import Fiber
from .model.fiber import COLORS, NUMBERS


@lru_cache(None)
def for_variant(name):
    """The class for the current variant, whose name is `name`. Each variant has its own base class."""
    FLAGS = mi.BSDFFlags.Glossy | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide | mi.BSDFFlags.NonSymmetric

    class Differentiable(mi.BSDF):
        """The near field of a fibre, differentiable in `NUMBERS` and `COLORS` (angles in degrees, σ per radius)."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            fiber = properties.read(props).in_air()
            self.exit = fiber.exit
            for name in NUMBERS:
                setattr(self, name, mi.Float(getattr(fiber, name)))
            for name in COLORS:
                value = getattr(fiber, name)
                setattr(self, name, mi.Color3f(*value) if hasattr(value, "__len__") else mi.Color3f(value))
            self.m_components, self.m_flags = [FLAGS], FLAGS
            self.model = Fiber(mi.Float, self.values(), self.exit == "reflecting")

        def values(self):
            return {name: getattr(self, name) for name in (*NUMBERS, *COLORS)}

        def traverse(self, callback):
            for name, value in self.values().items():
                callback.put(name, value, mi.ParamFlags.Differentiable)

        def parameters_changed(self, keys):
            plain = lambda v: [dr.detach(x)[0] for x in v] if isinstance(v, mi.Color3f) else dr.detach(v)[0]
            # Checks the ranges.
            properties.fiber(None, {**{k: plain(v) for k, v in self.values().items()}, "exit": self.exit})
            self.model = Fiber(mi.Float, self.values(), self.exit == "reflecting")

        def hit(self, si):
            return self.model.at(to_fiber(si.wi), offset(si.wi))

        def eval(self, ctx, si, wo, active=True):
            return mi.Color3f(*self.hit(si).eval(to_fiber(wo))) & active

        def pdf(self, ctx, si, wo, active=True):
            return self.hit(si).pdf(to_fiber(wo)) & active

        def eval_pdf(self, ctx, si, wo, active=True):
            value, pdf = self.hit(si).eval_pdf(to_fiber(wo))
            return mi.Color3f(*value) & active, pdf & active

        def draw(self, hit, sample1, sample2, active):
            wi, pdf, weight = hit.sample(split(sample1, sample2))
            active = active & (pdf > 0)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo, bs.pdf = to_mitsuba(wi), pdf & active
            bs.eta, bs.sampled_type, bs.sampled_component = 1, +FLAGS, 0
            return bs, mi.Color3f(*weight) & active

        def sample(self, ctx, si, sample1, sample2, active=True):
            return self.draw(self.hit(si), sample1, sample2, active)

        def eval_pdf_sample(self, ctx, si, wo, sample1, sample2, active=True):
            hit = self.hit(si)
            value, pdf = hit.eval_pdf(to_fiber(wo))
            return mi.Color3f(*value) & active, pdf & active, *self.draw(hit, sample1, sample2, active)

        def to_string(self):
            values = ", ".join(f"{name}={value}" for name, value in self.values().items())
            return f"VellusDrJit[{values}, exit={self.exit}]"

    return Differentiable
