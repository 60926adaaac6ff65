"""The near field of Vellus in Dr.Jit: the same values as the crate, with gradients of all parameters.

It needs `drjit` only. Formulas and their sources are those of the crate `vellus`; each module names its module there.
"""

from .fiber import Fiber

__all__ = ["Fiber"]
