"""The same ball of fur in Mitsuba and in `vellus render`, and a gradient through a path tracer."""

import numpy as np
import pytest
from mitsuba_support import command, dr, fur, load, mi, render, vellus_picture, write_curves

STRANDS, SIZE, PRESET = 600, 64, "red-fox"


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ball")
    points, radii = fur(STRANDS)
    write_curves(folder / "fur.txt", points, radii)
    result = {}
    for kind in ("vellus", "vellus_drjit"):
        scene = load(folder / "fur.txt", {"type": kind, "preset": PRESET}, size=SIZE)
        result[kind] = render(scene, kind, spp=128)
    if command():
        result["render"] = vellus_picture(folder, points, radii, PRESET, SIZE, 256)
    return result


def same(a, b):
    """The means of all pixels agree within 1 %; the noise of 128 samples is 0.1 %."""
    assert np.abs(a.mean((0, 1)) / b.mean((0, 1)) - 1).max() < 0.01
    # And those of the fur alone, where the picture is not sky.
    fur = slice(16, 48)
    assert np.abs(a[fur, fur].mean((0, 1)) / b[fur, fur].mean((0, 1)) - 1).max() < 0.01


def test_both_ways_agree(pictures):
    same(pictures["vellus"], pictures["vellus_drjit"])


def test_mitsuba_agrees_with_vellus_render(pictures):
    if "render" not in pictures:
        pytest.skip("no command vellus: build it (cargo build --release -p vellus-cli) or set VELLUS_COMMAND")
    for kind in ("vellus", "vellus_drjit"):
        same(pictures[kind], pictures["render"])


def test_gradients_of_a_picture_equal_differences(tmp_path):
    """∂(mean of a picture)/∂parameter by `prb` against a central difference with the same seeds.

    The same random numbers choose other directions for other parameters, so the differences are noisy: their
    standard error is 1 to 2 %, and that of `prb` too.
    """
    write_curves(tmp_path / "fur.txt", *fur(200, radius=0.04))
    scene = load(tmp_path / "fur.txt", {"type": "vellus_drjit", "preset": PRESET}, size=32, depth=4)
    integrator = mi.load_dict({"type": "prb", "max_depth": 4, "rr_depth": 1000})
    params = mi.traverse(scene)
    steps = {"sigma_ca": 0.05}
    keys = {name: next(k for k in params.keys() if k.endswith(name)) for name in steps}
    start = {name: type(params[key])(params[key]) for name, key in keys.items()}
    for name, key in keys.items():
        dr.enable_grad(params[key])
    params.update()
    image = mi.render(scene, params, integrator=integrator, spp=512, seed=1, seed_grad=2)
    dr.backward(dr.mean(image, axis=None))
    gradients = {name: np.sum(dr.grad(params[key]).numpy()) for name, key in keys.items()}
    with dr.suspend_grad():
        for name, key in keys.items():
            means = []
            for sign in (1, -1):
                params[key] = start[name] + sign * steps[name]
                params.update()
                means.append(np.array(mi.render(scene, integrator=integrator, spp=1024, seed=3)).mean())
            params[key] = start[name]
            params.update()
            assert gradients[name] == pytest.approx((means[0] - means[1]) / (2 * steps[name]), rel=0.1), name
