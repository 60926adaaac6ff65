"""Mitsuba's frame and random numbers in the form that Vellus uses.

Curves of Mitsuba have the frame (s, t, n), where t runs along the curve and n is the surface normal. Vellus has x along
the fibre from root to tip, so its (x, y, z) is (t, n, s).
"""

import drjit as dr
import mitsuba as mi

# Mitsuba's samplers give multiples of 2⁻²³.
BITS = 23


def to_fiber(w):
    """A direction in the fibre's frame: x, y, z."""
    return w.y, w.z, w.x


def to_mitsuba(w):
    """The inverse of `to_fiber`."""
    x, y, z = w
    return mi.Vector3f(z, x, y)


def offset(w):
    """h in [−1, 1] of a ray toward `w`: the sine of the angle from the normal, about the tangent."""
    across = dr.sqrt(w.x * w.x + w.z * w.z)
    return dr.clip(w.x / dr.maximum(across, 1e-20), -1, 1)


def split(sample1, sample2):
    """Four uniform numbers in (0, 1) from the three that Mitsuba gives: of 18, 17, 17 and 17 bits.

    The first three have the leading bits of Mitsuba's numbers, so that stratified samples stay stratified. The last has
    the remaining 5 + 6 + 6 bits.
    """
    parts, rest, bits = [], mi.UInt32(0), 0
    for u, kept in ((sample1, 18), (sample2.x, 17), (sample2.y, 17)):
        whole = dr.minimum(mi.UInt32(u * (1 << BITS)), (1 << BITS) - 1)
        low = BITS - kept
        parts.append((mi.Float(whole >> low) + 0.5) * 2.0**-kept)
        rest = (rest << low) | (whole & ((1 << low) - 1))
        bits += low
    parts.append((mi.Float(rest) + 0.5) * 2.0**-bits)
    return parts
