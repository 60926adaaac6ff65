"""The frame of curves, and the split of random numbers."""

import numpy as np
from mitsuba_support import dr, mi
from vellus.mitsuba.frame import BITS, offset, split, to_fiber, to_mitsuba


def test_x_runs_from_root_to_tip_and_h_has_the_sign_of_the_crate(tmp_path):
    path = tmp_path / "curve.txt"
    path.write_text("".join(f"{x} 0 0 0.1\n" for x in (-3, -1, 1, 3)))
    scene = mi.load_dict({"type": "scene", "curve": {"type": "bsplinecurve", "filename": str(path)}})
    origin = mi.Point3f(mi.Float([0.0, 0.1, 0.2]), mi.Float([0.05, -0.03, 0.0]), 5.0)
    si = scene.ray_intersect(mi.Ray3f(origin, mi.Vector3f(0, 0, -1)))
    assert dr.all(si.is_valid())
    along = si.to_world(to_mitsuba((mi.Float(1), mi.Float(0), mi.Float(0))))
    assert np.allclose(np.array(along), [[1, 1, 1], [0, 0, 0], [0, 0, 0]], atol=1e-5)
    # h = x · (n × ω): the normal at y/r is (0, y/r, …) and ω is z, so h = y/r.
    assert np.allclose(offset(si.wi).numpy(), [0.5, -0.3, 0.0], atol=2e-3)


def test_directions_go_there_and_back():
    w = mi.Vector3f(0.36, 0.48, 0.8)
    assert dr.all(to_mitsuba(to_fiber(w)) == w)


def test_split_numbers_are_uniform_and_independent():
    """χ² over 32 × 32 cells of each pair of numbers, and over 4,096 cells of each number.

    There are 10 tests. Each compares with the mean plus 4.5 standard deviations, which a χ² of 1,000 or more degrees of
    freedom exceeds with a probability below 1.1e-5: one false alarm in 9,000 seeds. The seed is fixed.
    """
    g = np.random.default_rng(7)
    n = 1_000_000
    u = [mi.Float(g.integers(0, 1 << BITS, n) * 2.0**-BITS) for _ in range(3)]
    parts = [p.numpy().astype(float) for p in split(u[0], mi.Point2f(u[1], u[2]))]
    assert len(parts) == 4 and all(0 < p.min() and p.max() < 1 for p in parts)
    histograms = [np.histogram(p, 4096, (0, 1))[0] for p in parts]
    pairs = [(a, b) for a in range(4) for b in range(a)]
    histograms += [np.histogram2d(parts[a], parts[b], 32, [[0, 1], [0, 1]])[0].ravel() for a, b in pairs]
    for histogram in histograms:
        expected, free = n / len(histogram), len(histogram) - 1
        chi2 = ((histogram - expected) ** 2 / expected).sum()
        assert chi2 < free + 4.5 * np.sqrt(2 * free)


def test_split_uses_every_bit_once():
    """Each of the 69 bits changes one of the numbers, and no two change the same bit of it."""
    seen = set()
    for axis in range(3):
        for bit in range(BITS):
            u = [0.0, 0.0, 0.0]
            u[axis] = 2.0 ** (bit - BITS)
            parts = [p.numpy()[0] for p in split(mi.Float(u[0]), mi.Point2f(u[1], u[2]))]
            zero = [p.numpy()[0] for p in split(mi.Float(0), mi.Point2f(0, 0))]
            changed = [(i, round(float(np.log2(p - z)), 3)) for i, (p, z) in enumerate(zip(parts, zero)) if p != z]
            assert len(changed) == 1
            seen.add(changed[0])
    assert len(seen) == 3 * BITS
