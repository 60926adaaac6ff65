"""Vellus in Mitsuba 3: `import vellus.mitsuba` registers the BSDFs `vellus` and `vellus_drjit`.

Both are the near field of a fibre, for the variants `llvm_ad_rgb` and `cuda_ad_rgb`, and for curves
(`bsplinecurve`). Their properties are the parameters of `vellus.Fiber`, `preset` and `exit`. In scalar variants, the
name `vellus` is left to the native plugin.

- `vellus` calls the compiled model with whole arrays. It has no gradients, and Dr.Jit must not record calls and loops
  symbolically: render inside `with vellus.mitsuba.arrays():`.
- `vellus_drjit` is the same model in Dr.Jit. It has gradients of all parameters.
"""

from contextlib import contextmanager

try:
    import drjit as dr
    import mitsuba as mi
except ImportError as error:
    raise ImportError("vellus.mitsuba needs the package mitsuba: pip install mitsuba==3.9.1") from error


def _register(*_):
    """Registers the BSDFs in the current variant. Mitsuba calls this when the variant changes."""
    if mi.variant() is None:
        return

    def compiled(props):
        from . import bsdf, properties

        properties.needs_arrays("vellus")
        return bsdf.for_variant(mi.variant())(props)

    def differentiable(props):
        from . import differentiable, properties

        properties.needs_arrays("vellus_drjit")
        return differentiable.for_variant(mi.variant())(props)

    # A BSDF from Python would hide the native plugin, which has this name in scalar variants.
    if not mi.variant().startswith("scalar"):
        mi.register_bsdf("vellus", compiled)
    mi.register_bsdf("vellus_drjit", differentiable)


_register()
mi.detail.add_variant_callback(_register)


@contextmanager
def arrays():
    """Turns Dr.Jit's symbolic loops and calls off, as the BSDF `vellus` needs it."""
    flags = [dr.JitFlag.SymbolicLoops, dr.JitFlag.SymbolicCalls, dr.JitFlag.SymbolicConditionals]
    before = [dr.flag(flag) for flag in flags]
    for flag in flags:
        dr.set_flag(flag, False)
    try:
        yield
    finally:
        for flag, value in zip(flags, before):
            dr.set_flag(flag, value)
