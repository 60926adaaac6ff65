"""The near field in Dr.Jit against the crate: values and gradients."""

import numpy as np
import pytest
from drjit.llvm.ad import Float64
from conftest import vectors
from mitsuba_support import COLORS, FIBER, NUMBERS, columns, directions, dr, mi, values

import vellus
from vellus.mitsuba.model import Fiber


def fibers(g, count):
    """The presets, those of the paper, two with a dense medulla, and random fibres."""
    presets = [vellus.Fiber(name + suffix) for name in vellus.species() for suffix in ("", "-published")]
    dense = [vellus.Fiber(**FIBER | {"kappa": 0.9, "sigma_ms": 30 / 0.9, "g": x}, exit="reflecting") for x in (0, 0.9)]
    color = lambda most: [float(x) for x in g.uniform(0, most, 3)]
    random = [
        vellus.Fiber(
            eta=g.uniform(1.2, 1.8),
            kappa=g.uniform(0.1, 0.95),
            alpha=g.uniform(-5, 5),
            beta_m=g.uniform(3, 20),
            beta_n=g.uniform(3, 20),
            sigma_ca=color(1),
            sigma_ms=g.uniform(0.05, 5),
            sigma_ma=color(0.5),
            g=g.uniform(0, 0.9),
            layers=g.uniform(0.3, 2),
            exit=["open", "reflecting"][i % 2],
        )
        for i in range(count - len(presets + dense))
    ]
    return presets + dense + random


@pytest.mark.parametrize("single", [True, False])
def test_values_equal_the_crate(single):
    """100,000 queries of 50 fibres; half of the directions are samples of the crate, half are uniform.

    The crate computes in single precision, with angles that have an error of up to 1e-6. In the tail of a lobe of
    width β, x widths from its centre, this is a relative error of x·1e-6/β: at β = 1.5° (the narrowest here, TT along
    the fibre) and x = 4 it is 1.5e-4. There the value is below 1e-3 of the peak. So the difference is relative to the
    value plus 0.01 per steradian. The mean of all values is about 0.05 per steradian.

    Where a path grazes the medulla, its length in it, √(κ² − h²), has a vertical tangent. An error of 1e-7 in h becomes
    one of 1e-7/√(2x) if h is x times κ below κ: 7e-6 at x = 1e-4. Lobes change by several times as much there, so one
    query in thousands has a bound of 1e-3.
    """
    g = np.random.default_rng(11)
    F, n = (mi.Float if single else Float64), 2000
    for fiber in fibers(g, 50):
        model = vellus.Bcsdf(fiber)
        wo, wi, h = directions(g, n), directions(g, n), g.uniform(-1, 1, n).astype(np.float32)
        half = n // 2
        wi[:half] = model.sample(wo[:half], g.random((half, 4)).astype(np.float32), h[:half]).wi
        expected, pdf = model.eval_pdf(wi=wi, wo=wo, h=h)
        hit = Fiber(F, values(fiber), fiber.exit == "reflecting").at(columns(F, wo), F(h))
        value, density = hit.eval_pdf(columns(F, wi))
        value = np.stack([v.numpy() for v in value], -1)
        # Bravais: the index of refraction across the fibre.
        inside = h * np.sqrt(1 - wo[:, 0] ** 2) / np.sqrt(fiber.eta**2 - wo[:, 0] ** 2)
        grazes = np.abs(np.abs(inside) / fiber.kappa - 1) < 1e-3
        for ours, theirs in ((value, expected), (density.numpy(), pdf)):
            error = (np.abs(ours - theirs) / (theirs + 0.01)).reshape(n, -1).max(1)
            assert error[~grazes].max() < 1e-4, fiber
            assert error[grazes].max(initial=0) < 1e-3, fiber


def test_golden_vectors():
    """The near field of every eighth fibre, because each takes seconds to compile. None of them is wet."""
    fibers, queries = vectors()
    worst = 0
    for index, fiber in list(enumerate(fibers))[::8]:
        own = queries[(queries[:, 0] == index) & (queries[:, 1] == queries[:, 2])]
        model = Fiber(mi.Float, values(fiber), fiber.exit == "reflecting")
        hit = model.at(columns(mi.Float, own[:, 3:6]), mi.Float(own[:, 1]))
        value = np.stack([v.numpy() for v in hit.eval(columns(mi.Float, own[:, 6:9]))], -1)
        worst = max(worst, (np.abs(value - own[:, 9:12]) / own[:, 12:]).max())
    print(f"largest error: {worst:.2f} tolerances")
    assert worst <= 1


def test_hair_without_medulla_equals_the_crate():
    g = np.random.default_rng(3)
    fiber = vellus.Fiber(sigma_ca=[0.1, 0.2, 0.4])
    wo, wi, h = directions(g, 2000), directions(g, 2000), g.uniform(-1, 1, 2000).astype(np.float32)
    expected = vellus.Bcsdf(fiber).eval(wi=wi, wo=wo, h=h)
    value = Fiber(Float64, values(fiber)).at(columns(Float64, wo), Float64(h)).eval(columns(Float64, wi))
    assert (np.abs(np.stack([v.numpy() for v in value], -1) - expected) < 1e-4 * (expected + 0.01)).all()


@pytest.mark.parametrize("reflects", [True, False])
@pytest.mark.parametrize(
    "change", [{"sigma_ms": 8.0, "g": 0.1}, {"beta_m": 15.0, "beta_n": 12.0, "kappa": 0.5, "g": 0.8}]
)
def test_gradients_equal_central_differences(reflects, change):
    """The gradient of a weighted mean over 5,000 queries, for each parameter and channel, within 1 %.

    The tables are linear between nodes, and √(κ² − h²) has a vertical tangent where a path grazes the medulla. A
    difference over 2e-5 crosses such places for a few queries, which is an error of 0.4 % for κ and 1e-5 for others.
    """
    g = np.random.default_rng(5)
    n = 5000
    start = FIBER | change
    wo, h = columns(Float64, directions(g, n)), Float64(g.uniform(-1, 1, n))
    u, weights = ([Float64(g.random(n)) for _ in range(k)] for k in (4, 3))
    wi = Fiber(Float64, start, reflects).at(wo, h).sample(u)[0]
    dr.eval(wi)

    def mean(parameters):
        light = Fiber(Float64, parameters, reflects).at(wo, h).eval(wi)
        return dr.mean(sum(v * w for v, w in zip(light, weights)))

    tracked = {k: [Float64(x) for x in np.ravel(v)] for k, v in start.items()}
    dr.enable_grad(tracked)
    dr.backward(mean({k: v if k in COLORS else v[0] for k, v in tracked.items()}))
    for name in (*NUMBERS, *COLORS):
        for channel, parameter in enumerate(tracked[name]):
            step, ends = 1e-5, []
            for sign in (1, -1):
                moved = [float(x) for x in np.ravel(start[name])]
                moved[channel] += sign * step
                ends.append(mean(start | {name: moved if name in COLORS else moved[0]})[0])
            expected = (ends[0] - ends[1]) / (2 * step)
            assert dr.grad(parameter)[0] == pytest.approx(expected, rel=0.01), (name, channel)


def test_gradients_of_black_hair_are_finite():
    """So little light leaves that its square is 0 in single precision."""
    g = np.random.default_rng(2)
    parameters = {k: [mi.Float(x) for x in np.ravel(v)] for k, v in (FIBER | {"sigma_ca": [100.0] * 3}).items()}
    dr.enable_grad(parameters)
    fiber = Fiber(mi.Float, {k: v if k in COLORS else v[0] for k, v in parameters.items()})
    wo, wi = columns(mi.Float, directions(g, 1000)), columns(mi.Float, directions(g, 1000))
    dr.backward(dr.mean(sum(fiber.at(wo, mi.Float(g.uniform(-1, 1, 1000))).eval(wi))))
    assert all(np.isfinite(dr.grad(x)[0]) for v in parameters.values() for x in v)
