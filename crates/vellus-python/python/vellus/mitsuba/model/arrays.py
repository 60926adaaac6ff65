"""Small helpers for Dr.Jit arrays. `F` is always the type of floating-point arrays, such as `mitsuba.Float`."""

import drjit as dr

from . import tables


class Grid:
    """Tables as Dr.Jit arrays of type `F`, made once for each type."""

    made = {}

    def __init__(self, F):
        self.F, self.U = F, dr.uint32_array_t(F)
        self.plain = tables.shipped()
        flat = lambda a: F(a.ravel())
        self.azimuthal, self.mean_path = map(flat, (self.plain.azimuthal, self.plain.mean_path))
        self.exits, self.turns = map(flat, (self.plain.exits, self.plain.turns))
        self.integrals = [flat(a) for a in self.plain.integrals]
        self.halves = [type(h)(*map(flat, h)) for h in self.plain.halves]
        dr.eval(self.azimuthal, self.mean_path, self.exits, self.turns, self.integrals, self.halves)

    @classmethod
    def of(cls, F):
        if F not in cls.made:
            cls.made[F] = cls(F)
        return cls.made[F]


def between(x, nodes):
    """The lower node and the fraction of a position on nodes 0 to `nodes` − 1, clamped to that range."""
    x = dr.clip(x, 0, nodes - 1)
    index = dr.minimum(dr.uint32_array_t(type(x))(dr.detach(x)), nodes - 2)
    return index, x - type(x)(index)


def pair(table, index, t, active=True):
    """Linear interpolation between an index and the next."""
    low, high = (dr.gather(type(table), table, index + k, active) for k in (0, 1))
    return dr.fma(high - low, t, low)


def block(table, index, size):
    """The block with this index of a table of blocks of equal size."""
    entries = dr.arange(dr.uint32_array_t(type(table)), size)
    return dr.gather(type(table), table, index * size + entries)


def blend(table, size, at):
    """Interpolation of whole blocks on one axis: `at` is from `between`."""
    index, t = at
    return dr.lerp(block(table, index, size), block(table, index + 1, size), t)


def blend2(table, size, first, second, nodes):
    """Interpolation of whole blocks on two axes, the second of which has `nodes` nodes."""
    (i, s), (j, t) = first, second
    row = lambda k: dr.lerp(block(table, (i + k) * nodes + j, size), block(table, (i + k) * nodes + j + 1, size), t)
    return dr.lerp(row(0), row(1), s)


def repeat(values, times):
    """Each entry `times` times in a row."""
    entries = dr.arange(dr.uint32_array_t(type(values)), dr.width(values) * times)
    return dr.gather(type(values), values, entries // times)


def cycle(values, times):
    """The whole array `times` times in a row."""
    entries = dr.arange(dr.uint32_array_t(type(values)), dr.width(values) * times)
    return dr.gather(type(values), values, entries % dr.width(values))


def sums(values, size):
    """The sum of each block of this size."""
    return dr.block_reduce(dr.ReduceOp.Add, values, size)


def entry(values, i):
    """One entry as an array of width 1."""
    return dr.gather(type(values), values, dr.uint32_array_t(type(values))(i))


def root(x):
    """√x, and 0 with the derivative 0 where x ≤ 0."""
    return dr.select(x > 0, dr.sqrt(dr.select(x > 0, x, 1)), 0)


def wrap(x):
    """An angle in [−π, π]."""
    return x - dr.two_pi * dr.round(x * (1 / dr.two_pi))
