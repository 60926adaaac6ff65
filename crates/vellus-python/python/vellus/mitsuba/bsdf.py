"""The BSDF `vellus`: queries go to the compiled model as whole arrays."""

from functools import lru_cache

import drjit as dr
import mitsuba as mi
import numpy as np

import vellus

from . import properties
from .frame import offset, split, to_fiber, to_mitsuba

PARAMETERS = ("eta", "kappa", "alpha", "beta_m", "beta_n", "sigma_ca", "sigma_ms", "sigma_ma", "g", "layers", "wet")


def numbers(*columns):
    """Arrays of Dr.Jit as one array of NumPy: (n, columns), and n."""
    n = max(dr.width(column) for column in columns)
    out = np.empty((n, len(columns)), np.float32)
    for i, column in enumerate(columns):
        out[:, i] = dr.detach(column).numpy()
    return out


@lru_cache(None)
def for_variant(name):
    """The class for the current variant, whose name is `name`. Each variant has its own base class."""
    FLAGS = mi.BSDFFlags.Glossy | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide | mi.BSDFFlags.NonSymmetric

    class Vellus(mi.BSDF):
        """The near field of a fibre. It has no gradients: see `differentiable.Differentiable`.

        It evaluates its arguments, so Dr.Jit must not record loops and calls symbolically: use
        `vellus.mitsuba.arrays()`.
        """

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.fiber = properties.read(props)
            self.model = vellus.Bcsdf(self.fiber)
            self.m_components, self.m_flags = [FLAGS], FLAGS

        def traverse(self, callback):
            for name in PARAMETERS:
                value = getattr(self.fiber, name)
                value = mi.Color3f(*value) if isinstance(value, tuple) or np.ndim(value) else mi.Float(value)
                setattr(self, name, value)
                callback.put(name, value, mi.ParamFlags.NonDifferentiable)

        def parameters_changed(self, keys):
            values = {name: getattr(self, name) for name in PARAMETERS}
            values = {k: [x[0] for x in v] if isinstance(v, mi.Color3f) else v[0] for k, v in values.items()}
            self.fiber = properties.fiber(None, {**values, "exit": self.fiber.exit})
            self.model = vellus.Bcsdf(self.fiber)

        @staticmethod
        def prepare(si):
            try:
                return numbers(*to_fiber(si.wi)), numbers(offset(si.wi))[:, 0]
            except RuntimeError as error:
                # Dr.Jit cannot evaluate what it records. It records all BSDFs of the process, also those of other
                # scenes.
                what = "vellus needs whole arrays: render inside `with vellus.mitsuba.arrays():`"
                what += ", as long as a BSDF of this kind exists"
                raise RuntimeError(what) from error

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_pdf(self, ctx, si, wo, active=True):
            toward, h = self.prepare(si)
            value, pdf = self.model.eval_pdf(wi=numbers(*to_fiber(wo)), wo=toward, h=h, check=False)
            return mi.Color3f(*value.T.copy()) & active, mi.Float(pdf) & active

        def sample(self, ctx, si, sample1, sample2, active=True):
            toward, h = self.prepare(si)
            drawn = self.model.sample(toward, numbers(*split(sample1, sample2)), h, check=False)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = to_mitsuba([mi.Float(c) for c in drawn.wi.T.copy()])
            bs.pdf = mi.Float(drawn.pdf)
            bs.eta, bs.sampled_type, bs.sampled_component = 1, +FLAGS, 0
            active = active & (bs.pdf > 0)
            bs.pdf &= active
            return bs, mi.Color3f(*drawn.weight.T.copy()) & active

        def eval_pdf_sample(self, ctx, si, wo, sample1, sample2, active=True):
            value, pdf = self.eval_pdf(ctx, si, wo, active)
            bs, weight = self.sample(ctx, si, sample1, sample2, active)
            return value, pdf, bs, weight

        def to_string(self):
            return f"Vellus[{self.fiber}]"

    return Vellus
