"""The same ball of fur in Mitsuba and in `vellus render`, and a gradient through a path tracer."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mitsuba_support import BOTH, command, dr, fur, load, mi, render, vellus_picture, write_curves

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


@pytest.mark.parametrize("other", ["diffuse", "roughplastic", "hair"])
def test_both_ways_agree_beside_other_bsdfs(tmp_path, other):
    """A ground, and a second fibre."""
    write_curves(tmp_path / "fur.txt", *fur(200, radius=0.04))
    at = mi.ScalarTransform4f()
    means = []
    for kind in BOTH:
        mouse = {"type": "bsplinecurve", "filename": str(tmp_path / "fur.txt"), "to_world": at.translate([2.5, 0, 0])}
        ground = {"type": "rectangle", "to_world": at.translate([0, 0, -1.6]).scale(4), "bsdf": {"type": other}}
        more = {"mouse": {**mouse, "bsdf": {"type": kind, "preset": "mouse"}}, "ground": ground}
        scene = load(tmp_path / "fur.txt", {"type": kind, "preset": PRESET}, size=48, depth=6, more=more)
        means.append(render(scene, kind, spp=64).mean((0, 1)))
    # The differences found were at most 0.1 %.
    assert np.abs(means[0] / means[1] - 1).max() < 0.01


def test_no_ray_reads_past_the_segments(tmp_path):
    """Rays at the tip of the last strand, with Dr.Jit's check of bounds, in a process of its own."""
    code = """
from mitsuba_support import dr, fur, load, mi, np, write_curves
points, radii = fur(600)
write_curves("fur.txt", points, np.full(len(radii), 0.02))
dr.set_flag(dr.JitFlag.Debug, True)
scene = load("fur.txt", {"type": "diffuse"}, light=False)
# B-splines end between their control points.
tip = (points[-1][-3] + 4 * points[-1][-2] + points[-1][-1]) / 6
along = points[-1][-1] - points[-1][-3]
side = np.cross(along, [0.3, 0.5, 0.8])
start = mi.Point3f((tip + 0.05 * side / np.linalg.norm(side)).tolist())
n = 1_000_000
rng = mi.PCG32(n)
target = mi.Point3f(tip.tolist()) - mi.Vector3f(along.tolist()) * (rng.next_float32() * 1e-3)
hit = scene.ray_intersect(mi.Ray3f(start, dr.normalize(target - start)))
assert dr.count(hit.is_valid() & (hit.t > 0.02))[0] > n // 2
dr.eval(hit)
dr.sync_thread()
"""
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parent)}
    run = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert "out-of-bounds read" not in run.stdout + run.stderr, run.stderr


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
