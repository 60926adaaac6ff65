"""The BSDFs in Mitsuba: sampling, energy, properties."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mitsuba_support import BOTH, FIBER, dr, fur, load, mi, render, write_curves

WHITE = dict(kappa=0.8, sigma_ms=2.0, g=0.6, beta_m=12.0, beta_n=12.0)
# A medulla so dense that light which leaves later is not uniform in azimuth.
DENSE = dict(kappa=0.9, sigma_ms=30.0, g=0.1, beta_m=12.0, beta_n=12.0)
# Fibres and directions toward the camera, in Mitsuba's frame.
CHI2 = [
    ({"preset": "red-fox"}, [0.3, 0.2, 0.9]),
    ({"preset": "red-fox-published"}, [-0.5, -0.6, 0.4]),
    ({"preset": "cat"}, [0.05, 0.9, 0.4]),
    ({"preset": "mouse"}, [0.0, 0.0, 1.0]),
    (DENSE, [0.8, 0.3, 0.5]),
]


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize("fiber, wi", CHI2)
def test_samples_follow_the_density(kind, fiber, wi):
    """Mitsuba's χ² test. All ten together have a false-alarm rate of 1 %; its random numbers are fixed."""
    from mitsuba.chi2 import BSDFAdapter, ChiSquareTest, SphericalDomain

    wi = [float(x / np.linalg.norm(wi)) for x in wi]
    tag = lambda value: "string" if isinstance(value, str) else "float"
    properties = "".join(f'<{tag(value)} name="{name}" value="{value}"/>' for name, value in fiber.items())
    sample, pdf = BSDFAdapter(kind, properties, wi=wi)
    test = ChiSquareTest(SphericalDomain(), sample, pdf, sample_dim=3, sample_count=200_000, res=101, ires=16)
    assert test.run(significance_level=0.01, test_count=len(BOTH) * len(CHI2)), test.messages


@pytest.mark.parametrize("kind", BOTH)
def test_a_white_furnace_is_white(tmp_path, kind):
    """Fur that absorbs nothing under a sky of 1: every pixel is 1.

    Paths end after 200 events. The mean of a picture of 32² pixels with 64 samples has an error below 1e-3, because all
    weights are 1; single lanes differ by the tables' normalisation, at most 0.3 %.
    """
    write_curves(tmp_path / "fur.txt", *fur(150, radius=0.05))
    scene = load(tmp_path / "fur.txt", {"type": kind, **WHITE}, sky=(1, 1, 1), depth=200, size=32, light=False)
    picture = render(scene, kind, spp=64)
    assert np.abs(picture.mean((0, 1)) - 1).max() < 5e-3
    assert np.isfinite(picture).all()


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize(
    "properties, words",
    [
        ({"kappa": 1.5}, ["kappa", "1.5", "[0, 0.99]"]),
        ({"beta_m": float("nan")}, ["beta_m", "NaN", "[0.1, 90]"]),
        ({"sigma_ca": [0.1, -0.2, 0.3]}, ["sigma_ca.g", "-0.2", "[0, 1000]"]),
        ({"sigma_ca": [0.1, 0.2]}, ["sigma_ca"]),
        ({"roughness": 0.3}, ["roughness"]),
        ({"preset": "unicorn"}, ["unicorn", "red-fox"]),
        ({"preset": 3.0}, ["preset"]),
        ({"exit": "closed"}, ["closed", "open, reflecting"]),
        ({"eta": "glass"}, ["eta", "glass"]),
        ({"sigma_ca": {"type": "checkerboard"}}, ["sigma_ca", "textures"]),
        ({"sigma_ca": {"type": "spectrum", "value": [(400, 0.1), (700, 0.3)]}}, ["sigma_ca", "other spectra"]),
        ({"sigma_ca": {"type": "spectrum", "value": -0.2}}, ["sigma_ca", "-0.2", "[0, 1000]"]),
    ],
)
def test_bad_properties_are_named(kind, properties, words):
    with pytest.raises(Exception) as error:
        mi.load_dict({"type": kind, **properties})
    for word in words:
        assert word.lower() in str(error.value).lower()


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize(
    "color",
    [
        0.2,
        {"type": "spectrum", "value": 0.2},
        {"type": "uniform", "value": 0.2},
        {"type": "rgb", "value": 0.2},
        {"type": "srgb", "color": [0.2, 0.2, 0.2]},
    ],
)
def test_constants_are_colours(kind, color):
    params = mi.traverse(mi.load_dict({"type": kind, **FIBER, "sigma_ca": color}))
    assert np.allclose(np.ravel(params["sigma_ca"]), 0.2)
    with pytest.raises(Exception, match="reflectance|sigma_ca"):
        mi.load_dict({"type": kind, "sigma_ca": color, "reflectance": color})


def test_symbolic_rendering_of_the_compiled_model_is_refused(tmp_path):
    """In a process of its own: after an error inside a symbolic loop, Dr.Jit stays in it."""
    code = """
from mitsuba_support import fur, load, mi, write_curves
write_curves("fur.txt", *fur(5))
mi.render(load("fur.txt", {"type": "vellus"}, size=8), spp=1)
"""
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parent)}
    run = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert run.returncode != 0 and "render inside `with vellus.mitsuba.arrays():`" in run.stderr


@pytest.mark.parametrize("kind", BOTH)
def test_parameters_change_the_fibre_and_are_checked(kind):
    bsdf = mi.load_dict({"type": kind, **FIBER})
    other = mi.load_dict({"type": kind, **FIBER, "kappa": 0.4, "sigma_ca": [0.5, 0.6, 0.7]})
    params = mi.traverse(bsdf)
    params["kappa"] = 0.4
    params["sigma_ca"] = mi.Color3f(0.5, 0.6, 0.7)
    params.update()
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = dr.normalize(mi.Vector3f(0.3, 0.2, 0.9))
    wo = dr.normalize(mi.Vector3f(-0.2, 0.1, 0.9))
    values = [b.eval(mi.BSDFContext(), si, wo) for b in (bsdf, other)]
    assert dr.allclose(*values, rtol=1e-5)
    params["kappa"] = -1.0
    with pytest.raises(Exception, match="kappa"):
        params.update()


@pytest.mark.parametrize("kind", BOTH)
def test_inactive_lanes_are_black(kind):
    bsdf = mi.load_dict({"type": kind, "preset": "red-fox"})
    si = dr.zeros(mi.SurfaceInteraction3f, 2)
    si.wi = mi.Vector3f(0, 0, 1)
    active = mi.Bool([True, False])
    value, pdf = bsdf.eval_pdf(mi.BSDFContext(), si, mi.Vector3f(0, 0.1, 0.99), active)
    bs, weight = bsdf.sample(mi.BSDFContext(), si, mi.Float([0.3, 0.4]), mi.Point2f(0.4, 0.7), active)
    for x in (value.x, pdf, bs.pdf, weight.y):
        assert x.numpy()[0] > 0 and x.numpy()[1] == 0


def test_scalar_variants_are_refused_and_leave_a_name_to_the_native_plugin():
    mi.set_variant("scalar_rgb")
    try:
        with pytest.raises(Exception, match="vellus_drjit needs a vector variant with RGB.* scalar_rgb"):
            mi.load_dict({"type": "vellus_drjit"})
        # Mitsuba looks for the native plugin, which is not installed here.
        with pytest.raises(Exception, match="vellus") as error:
            mi.load_dict({"type": "vellus"})
        assert "needs a vector variant" not in str(error.value)
    finally:
        mi.set_variant("llvm_ad_rgb")
