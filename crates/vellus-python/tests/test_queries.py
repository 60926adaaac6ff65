"""Queries for arrays: values, shapes, types, errors, threads."""

import os
import pickle
import subprocess
import sys
import threading

import numpy as np
import pytest
import vellus
from conftest import unit, vectors
from hypothesis import given, settings
from hypothesis import strategies as st
from vellus import Bcsdf

X = np.array([0.0, 1.0, 0.0])
Z = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def fox():
    return Bcsdf("red-fox")


def single(case, key):
    return np.array(case[key], np.float32)


def check_samples(samples, expected):
    for i, sample in enumerate(expected):
        if sample is None:
            assert samples.lobe[i] == -1 and samples.pdf[i] == 0
            continue
        wi, pdf, weight, lobe = sample
        assert np.array_equal(samples.wi[i], np.float32(wi)) and samples.pdf[i] == np.float32(pdf)
        assert np.array_equal(samples.weight[i], np.float32(weight)) and samples.lobe[i] == lobe


def test_golden_vectors():
    fibers, queries = vectors()
    assert len(queries) == 2000
    for index, fiber in enumerate(fibers):
        own = queries[queries[:, 0] == index]
        found = Bcsdf(fiber).eval(wo=own[:, 3:6], wi=own[:, 6:9], window=own[:, 1:3])
        assert (np.abs(found - own[:, 9:12]) <= own[:, 12:]).all(), index


@pytest.mark.parametrize("at", [{"h": 0.3}, {"window": (-0.5, 0.25)}])
def test_parameters_may_differ_from_query_to_query(at):
    """Each query has the value of a fibre with its parameters. The last digits may differ, where eight are at once."""
    rng = np.random.default_rng(3)
    wo, wi = unit(rng), unit(rng, 3, 40)
    kappa, beta_n = rng.uniform(0, 0.95, (3, 1)), rng.uniform(3, 30, 40)
    sigma = np.repeat(rng.uniform(0, 1, (3, 8, 3)), 5, axis=1)
    parameters = {"kappa": kappa, "beta_n": beta_n, "sigma_ca": sigma}
    for name in ("red-fox", "red-fox-published"):
        bcsdf, u = Bcsdf(name), rng.random((3, 40, 5))
        f, pdf = bcsdf.eval_pdf(wi=wi, wo=wo, **at, parameters=parameters)
        samples = bcsdf.sample(wo, u, **at, parameters=parameters)
        energy = bcsdf.energy(wo, **at, parameters={"kappa": kappa})
        assert f.shape == (3, 40, 3) and energy.shape == (3, 1, 3)
        for i, j in ((0, 0), (1, 17), (2, 39), (0, 4), (1, 5)):
            own = {"kappa": kappa[i, 0], "beta_n": beta_n[j], "sigma_ca": tuple(sigma[i, j])}
            one = Bcsdf(vellus.Fiber(name, **own))
            expected = one.eval_pdf(wi=wi[i, j], wo=wo, **at)
            assert np.allclose(f[i, j], expected[0], rtol=2e-5) and np.isclose(pdf[i, j], expected[1], rtol=2e-5)
            drawn = one.sample(wo, u[i, j], **at)
            assert samples.lobe[i, j] == drawn.lobe and np.allclose(samples.wi[i, j], drawn.wi, atol=2e-5)
        assert np.allclose(energy[1, 0], Bcsdf(vellus.Fiber(name, kappa=kappa[1, 0])).energy(wo, **at), rtol=2e-5)


def test_colours_may_differ_from_query_to_query(fox):
    colors = np.random.default_rng(4).uniform(0.1, 0.8, (6, 3))
    wi = np.full(3, 3**-0.5)
    f = fox.eval(wi=wi, wo=X, h=0.1, parameters={"reflectance": colors})
    for color, value in zip(colors, f):
        fiber = vellus.Fiber("red-fox", reflectance=tuple(color))
        assert np.allclose(value, Bcsdf(fiber).eval(wi=wi, wo=X, h=0.1), rtol=1e-4)
    grey = fox.energy(X, 0.1, parameters={"sigma_ca": 0.3})
    assert np.allclose(grey, fox.energy(X, 0.1, parameters={"sigma_ca": [0.3] * 3}), rtol=1e-6)
    # Parameters that are not a number give none, and do not disturb their neighbours.
    kappa = np.full(20, 0.5)
    kappa[7] = np.nan
    energy = fox.energy(X, 0.1, parameters={"kappa": kappa})
    assert np.isnan(energy[7]).all() and np.array_equal(energy[6], energy[8]) and np.isfinite(energy[6]).all()


@pytest.mark.parametrize(
    "parameters, part",
    [
        ({"kappa": [0.5, 1.5]}, r"kappa\[1\]: kappa = 1.5 is out of range"),
        ({"kapa": 0.5}, 'parameter "kapa" is unknown'),
        ({"exit": 1}, 'parameter "exit" is unknown'),
        ({"sigma_ca": [0.1, 0.2]}, "sigma_ca has the shape"),
        ({"sigma_ca": 0.1, "melanin": [1, 1]}, "only one parameter may give the colour"),
        ({"kappa": np.full(3, 0.5), "eta": np.full(4, 1.5)}, "do not fit together"),
    ],
)
def test_bad_parameters_are_named(fox, parameters, part):
    with pytest.raises(ValueError, match=part):
        fox.energy(X, 0.1, parameters=parameters)


def test_results_are_the_bits_of_rust(reference):
    for name, case in reference.items():
        bcsdf = Bcsdf(name)
        wi, wo, h, u, windows = (single(case, key) for key in ("wi", "wo", "h", "u", "windows"))
        near = case["near"]
        f, pdf = bcsdf.eval_pdf(wi=wi, wo=wo, h=h, lobes=True)
        assert f.dtype == np.float32 and np.array_equal(f, single(near, "eval"))
        assert np.array_equal(pdf, single(near, "pdf")) and np.array_equal(pdf, bcsdf.pdf(wi=wi, wo=wo, h=h))
        assert np.array_equal(bcsdf.energy(wo, h, lobes=True), single(near, "energy"))
        check_samples(bcsdf.sample(wo, u, h), near["sample"])
        check_samples(bcsdf.sample(wo, u[:, :4], h), near["sample"])
        assert np.array_equal(vellus.pixel_window(h, np.float32(0.3)), windows)
        f, pdf = bcsdf.eval_pdf(wi=wi, wo=wo, window=windows, lobes=True)
        each = case["window"]
        assert np.array_equal(f, np.float32([q["eval"] for q in each]))
        assert np.array_equal(pdf, np.float32([q["pdf"] for q in each]))
        energy = bcsdf.energy(wo, window=windows, lobes=True)
        assert np.array_equal(energy, np.float32([q["energy"] for q in each]))
        check_samples(bcsdf.sample(wo, u, window=windows), [q["sample"] for q in each])
        f, pdf = bcsdf.eval_pdf(wi=wi, wo=wo[0], window="far", lobes=True)
        assert np.array_equal(f, single(case["far"], "eval")) and np.array_equal(pdf, single(case["far"], "pdf"))


def test_buffers_of_shaders_are_those_of_rust(reference):
    for name, case in reference.items():
        fiber = vellus.Fiber(name)
        arrays = {"tables": vellus.shader_tables(), "record": fiber.shader_record()}
        arrays |= {"color": fiber.shader_color(), "far": fiber.shader_far_table()}
        for part, array in arrays.items():
            assert array.dtype == np.float32 and array.shape[1:] == (4,) and array.flags.c_contiguous
            bits = array.ravel().view(np.uint32).astype(np.uint64)
            places = np.arange(1, bits.size + 1, dtype=np.uint64)
            assert [len(array), int(np.sum(bits * places))] == case["shaders"][part], (name, part)


def test_sums_lobes_and_types(fox, rng):
    wi, wo, h = unit(rng, 100), unit(rng, 100), rng.uniform(-1, 1, 100)
    f = fox.eval(wi=wi, wo=wo, h=h)
    assert f.dtype == np.float64 and f.shape == (100, 3)
    lobes = fox.eval(wi=wi, wo=wo, h=h, lobes=True)
    assert lobes.shape == (100, 6, 3)
    # The sum over six lobes rounds in single precision.
    np.testing.assert_allclose(lobes.sum(axis=1), f, rtol=1e-6)
    narrow = {name: a.astype(np.float32) for name, a in {"wi": wi, "wo": wo, "h": h}.items()}
    half = narrow["wi"].astype(np.float16).astype(np.float32)
    assert fox.eval(**narrow).dtype == np.float32
    assert np.array_equal(fox.eval(**narrow), f)
    assert fox.eval(wi=narrow["wi"], wo=narrow["wo"], h=0.3).dtype == np.float32
    assert fox.eval(wi=narrow["wi"], wo=wo, h=0.3).dtype == np.float64
    assert fox.eval(wi=[0, 1, 0], wo=(0, 0, 1), h=0).dtype == np.float64
    assert fox.eval(wi=half, wo=narrow["wo"], h=h[0], check=False).dtype == np.float32


@pytest.mark.parametrize("model", [Bcsdf("cat"), vellus.models.Model("yan2015", "cat")], ids=["Bcsdf", "Model"])
@pytest.mark.parametrize("name", ["eval", "pdf", "eval_pdf"])
def test_directions_are_given_by_name(model, name):
    """The model is not reciprocal: two directions in the wrong order would be a wrong result without an error."""
    assert not np.array_equal(model.eval(wi=X, wo=Z, h=0.3), model.eval(wi=Z, wo=X, h=0.3))
    query = getattr(model, name)
    for positional, rest in (((X, Z, 0.3), {}), ((X, Z), {"h": 0.3}), ((X,), {"wo": Z, "h": 0.3})):
        with pytest.raises(TypeError, match="positional argument"):
            query(*positional, **rest)
    with pytest.raises(TypeError, match="missing 1 required keyword argument: 'wo'"):
        query(wi=X, h=0.3)


@pytest.mark.parametrize("where", [{"h": 0.3}, {"window": (-0.5, 0.25)}, {"window": "far"}])
def test_broadcasting_equals_single_queries(fox, rng, where):
    wi, wo = unit(rng, 4, 1, 5), unit(rng, 3, 1)
    f, pdf = fox.eval_pdf(wi=wi, wo=wo, **where)
    assert f.shape == (4, 3, 5, 3) and pdf.shape == (4, 3, 5)
    for i, j, k in np.ndindex(4, 3, 5):
        # A shared window is evaluated in groups of eight, which rounds otherwise.
        np.testing.assert_allclose(f[i, j, k], fox.eval(wi=wi[i, 0, k], wo=wo[j, 0], **where), rtol=2e-4, atol=1e-6)


def test_one_wo_for_many_queries_changes_no_bit(fox, rng):
    wi, wo = unit(rng, 1000).astype(np.float32), unit(rng).astype(np.float32)
    many = np.broadcast_to(wo, (1000, 3)).copy()
    assert np.array_equal(fox.eval(wi=wi, wo=wo, h=0.3), fox.eval(wi=wi, wo=many, h=np.full(1000, 0.3, np.float32)))


def test_memory_layouts(fox, rng):
    wi, wo, h = unit(rng, 60), unit(rng, 60), rng.uniform(-1, 1, 60)
    expected = fox.eval(wi=wi, wo=wo, h=h)
    frozen = wi.copy()
    frozen.setflags(write=False)
    record = np.zeros(60, dtype=[("a", "i1"), ("wi", "f8", 3)])
    record["wi"] = wi
    for other in (
        np.asfortranarray(wi),
        np.repeat(wi, 2, axis=0)[::2],
        wi[::-1][::-1],
        frozen,
        record["wi"],
        wi.astype(">f8"),
        wi.tolist(),
    ):
        assert np.array_equal(fox.eval(wi=other, wo=wo, h=h), expected)
    cube = fox.eval(wi=wi.reshape(3, 4, 5, 3), wo=wo.reshape(3, 4, 5, 3), h=h.reshape(3, 4, 5))
    assert np.array_equal(cube.reshape(60, 3), expected)
    swapped = fox.eval(
        wi=wi.reshape(6, 10, 3).swapaxes(0, 1), wo=wo.reshape(6, 10, 3).swapaxes(0, 1), h=h.reshape(6, 10).T
    )
    assert np.array_equal(swapped.swapaxes(0, 1).reshape(60, 3), expected)


def test_empty_arrays(fox):
    assert fox.eval(wi=np.zeros((0, 3)), wo=X, h=0.1).shape == (0, 3)
    assert fox.eval(wi=np.zeros((4, 0, 3), np.float32), wo=np.zeros((1, 3), np.float32), h=0.1, lobes=True).shape == (
        4,
        0,
        6,
        3,
    )
    assert fox.sample(X, np.zeros((0, 5)), window="far").lobe.shape == (0,)
    assert fox.energy(np.zeros((2, 0, 3)), window="far").shape == (2, 0, 3)
    assert vellus.cell_window([], 0.2, 0.5).shape == (0, 2)


def test_nan_marks_a_query_as_absent(fox, rng):
    wi, wo, h = unit(rng, 40), unit(rng, 40), rng.uniform(-1, 1, 40)
    expected = fox.eval(wi=wi, wo=wo, h=h)
    wi[3, 1], wo[17, 0], h[21] = np.nan, np.nan, np.nan
    f, pdf = fox.eval_pdf(wi=wi, wo=wo, h=h)
    bad = [3, 17, 21]
    assert np.isnan(f[bad]).all() and np.isnan(pdf[bad]).all()
    good = np.setdiff1d(np.arange(40), bad)
    assert np.array_equal(f[good], expected[good])
    samples = fox.sample(wo, rng.random((40, 5)), window=np.stack([h, h + 0.0], axis=-1))
    assert list(np.flatnonzero(samples.lobe == -1)) == [17, 21] and np.isnan(samples.wi[17]).all()
    assert np.isnan(vellus.pixel_window(np.nan, 0.1)).all()


def test_subnormal_numbers(fox):
    tiny = np.float32(1e-40)
    for f in (
        fox.eval(wi=[tiny, 1, 0], wo=X, h=tiny),
        fox.eval(wi=[1e-320, 1, 0], wo=X, h=1e-320),
        fox.energy(X, tiny),
    ):
        assert np.isfinite(f).all()
    assert np.isfinite(fox.sample(X, np.full((4, 5), tiny), tiny).weight).all()


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda b: b.eval(wi=[0, 0, 2], wo=X, h=0.1), ValueError, "wi has the length 2: it must be a unit vector"),
        (lambda b: b.eval(wi=[X, X, 3 * X], wo=X, h=0.1), ValueError, "wi[2] has the length 3"),
        (lambda b: b.eval(wi=X, wo=[[X], [0 * X]], h=0.1), ValueError, "wo[1, 0] has the length 0"),
        (
            lambda b: b.eval(wi=[0, 1], wo=X, h=0.1),
            ValueError,
            "wi has the shape (2,): its last axis must have 3 numbers",
        ),
        (lambda b: b.eval(wi=1.0, wo=X, h=0.1), ValueError, "wi has the shape (): its last axis"),
        (lambda b: b.eval(wi=[X] * 4, wo=[X] * 5, h=0), ValueError, "do not fit together: wo (5,), h (), wi (4,)"),
        (
            lambda b: b.eval(wi=[0, 0, 1j], wo=X, h=0.1),
            TypeError,
            "wi has the dtype complex128: it must be float32 or float64",
        ),
        (lambda b: b.eval(wi=["a", "b", "c"], wo=X, h=0.1), TypeError, "wi has the dtype <U1"),
        (lambda b: b.eval(wi=None, wo=X, h=0.1), TypeError, "wi has the dtype object"),
        (lambda b: b.eval(wi=[[0, 1], [0]], wo=X, h=0.1), TypeError, "wi is not an array of real numbers"),
        (lambda b: b.eval(wi=X > 0, wo=X, h=0.1), TypeError, "wi has the dtype bool"),
        (lambda b: b.eval(wi=X, wo=X, h=[0, 1.5]), ValueError, "h[1] = 1.5 is out of range: it must be in [-1, 1]"),
        (lambda b: b.eval(wi=X, wo=X, window=[0, 0.5, 1]), ValueError, "its last axis must have 2 numbers"),
        (lambda b: b.eval(wi=X, wo=X, window=[-3, 0]), ValueError, "window = -3 is out of range"),
        (lambda b: b.eval(wi=X, wo=X, window="near"), ValueError, "window = 'near' is unknown"),
        (lambda b: b.eval(wi=X, wo=X), TypeError, "h or window is missing"),
        (lambda b: b.eval(wi=X, wo=X, h=0.1, window="far"), TypeError, "h and window are both given"),
        (lambda b: b.sample(X, [0, 0, 0, 0, 1.5], 0.1), ValueError, "u = 1.5 is out of range: it must be in [0, 1)"),
        (lambda b: b.sample(X, [0.1] * 4, window="far"), ValueError, "its last axis must have 5 numbers"),
        (lambda b: b.sample(X, [0.1] * 6, 0.1), ValueError, "its last axis must have 5 numbers"),
        (lambda b: vellus.pixel_window(0.1, -1), ValueError, "width = -1 is out of range: it must be at least 0"),
        (lambda b: vellus.cell_window(0.1, 0.2, 1.5), ValueError, "u = 1.5 is out of range"),
        (lambda b: vellus.models.Model("phong", "cat"), ValueError, "unknown model 'phong'"),
    ],
)
def test_bad_arguments_are_named(fox, call, error, text):
    with pytest.raises(error) as caught:
        call(fox)
    assert text in str(caught.value)


def test_the_first_bad_number_is_named_whatever_thread_finds_it(fox):
    wi = np.tile(X, (100_000, 1))
    wi[[70_001, 99_999]] *= 2
    for _ in range(5):
        with pytest.raises(ValueError, match=r"wi\[70001\] has the length 2"):
            fox.eval(wi=wi, wo=X, h=0.1)
    assert fox.eval(wi=wi, wo=X, h=0.1, check=False).shape == (100_000, 3)


@settings(max_examples=30, deadline=None)
@given(
    preset=st.sampled_from(vellus.species()),
    theta=st.floats(-85, 85),
    ends=st.tuples(st.floats(-1, 1), st.floats(-1, 1)),
)
def test_values_integrate_to_the_energy_and_the_density_to_one(preset, theta, ends):
    bcsdf = Bcsdf(preset)
    wo = vellus.direction(theta, 0.0)
    rng = np.random.default_rng(1)
    for where in ({"h": ends[0]}, {"window": ends}, {"window": "far"}):
        energy = bcsdf.energy(wo, **where)
        assert (energy >= 0).all() and (energy <= 1 + 1e-4).all()
        samples = bcsdf.sample(wo, rng.random((4000, 5)), **where)
        drawn = samples.lobe >= 0
        assert np.isfinite(samples.weight).all() and drawn.mean() > 0.99
        # Weights are nearly constant, at most 1.5 in a window: the mean of 4000 is within 5 % of the energy.
        np.testing.assert_allclose(samples.weight.mean(axis=0), energy, rtol=0.05, atol=0.005)
        f, pdf = bcsdf.eval_pdf(wi=samples.wi[drawn], wo=wo, **where)
        # The direction is rounded between sampling and evaluation, and the narrowest lobes are 1 degree wide.
        np.testing.assert_allclose(pdf, samples.pdf[drawn], rtol=0.02, atol=1e-4)
        np.testing.assert_allclose(f, samples.weight[drawn] * samples.pdf[drawn][:, None], rtol=0.02, atol=1e-4)
    assert (bcsdf.eval(wi=-wo, wo=wo, h=ends[0]) >= 0).all()


def test_the_density_integrates_to_one(fox):
    # A grid over the sphere: x and phi are uniform, and lobes of 9 degrees are much wider than its cells.
    x = (np.arange(600) + 0.5) / 300 - 1
    phi = np.arange(0, 360, 1.0)
    wi = vellus.direction(np.degrees(np.arcsin(x))[:, None], phi)
    for where in ({"h": 0.3}, {"window": (-0.5, 0.5)}, {"window": "far"}):
        f, pdf = fox.eval_pdf(wi=wi, wo=X, **where)
        assert pdf.mean() * 4 * np.pi == pytest.approx(1, abs=2e-3)
        np.testing.assert_allclose(f.mean(axis=(0, 1)) * 4 * np.pi, fox.energy(X, **where), rtol=2e-3)


def test_the_far_field_of_a_symmetric_fibre_is_reciprocal():
    # With h averaged, flat scales and no medulla, only the attenuation breaks reciprocity, and without absorption
    # the whole far field f is the same for both orders of the directions at equal inclinations.
    bcsdf = Bcsdf(vellus.Fiber(alpha=0))
    a, b = vellus.direction(30.0, 0.0), vellus.direction(30.0, 140.0)
    np.testing.assert_allclose(bcsdf.eval(wi=a, wo=b, window="far"), bcsdf.eval(wi=b, wo=a, window="far"), rtol=1e-4)


def test_cells_average_to_the_far_field(fox):
    u = (np.arange(16) + 0.5) / 16
    h = (np.arange(256) + 0.5) / 128 - 1
    windows = vellus.cell_window(h, 0.3, u[:, None])
    assert windows.shape == (16, 256, 2) and (windows[..., 0] <= h + 1e-6).all() and (windows[..., 1] >= h - 1e-6).all()
    wi = vellus.direction(10.0, 150.0)
    mean = fox.eval(wi=wi, wo=X, window=windows).mean(axis=(0, 1))
    # 256 offsets resolve a cell to 3 %, and 16 shifts average that.
    np.testing.assert_allclose(mean, fox.eval(wi=wi, wo=X, window="far"), rtol=0.02)


@pytest.mark.parametrize("name", vellus.models.NAMES)
def test_earlier_models(name, rng):
    model = vellus.models.Model(name, "red-fox")
    assert model.name == name and model.field in ("near", "far", "any") and pickle.loads(pickle.dumps(model)) == model
    wo = unit(rng)
    samples = model.sample(wo, rng.random((2000, 5)), h=0.2)
    drawn = samples.lobe >= 0
    f, pdf = model.eval_pdf(wi=samples.wi[drawn], wo=wo, h=0.2)
    np.testing.assert_allclose(pdf, samples.pdf[drawn], rtol=0.02, atol=1e-4)
    energy = model.energy(wo, h=0.2, lobes=True)
    assert energy.shape == (6, 3) and (energy >= 0).all()
    assert np.array_equal(f, model.eval(wi=samples.wi[drawn], wo=wo, h=0.2))
    assert model.pdf(wi=X, wo=wo, window="far").shape == ()
    profile = vellus.profile("red-fox", 20.0, [-10.0, 0.0], [0.0, 90.0, 180.0], model=name)
    assert profile.shape == (2, 3, 3) and (profile > 0).all()


def test_the_model_vellus_is_the_bcsdf(fox, rng):
    model = vellus.models.Model("vellus", "red-fox")
    wi, wo, h = unit(rng, 50), unit(rng, 50), rng.uniform(-1, 1, 50)
    # One computes hits one by one, the other eight at a time.
    np.testing.assert_allclose(model.eval(wi=wi, wo=wo, h=h), fox.eval(wi=wi, wo=wo, h=h), rtol=1e-3, atol=1e-6)


def test_objects_survive_pickle_and_compare(fox):
    fine = Bcsdf("red-fox", fine_windows=True)
    for bcsdf in (fox, fine):
        again = pickle.loads(pickle.dumps(bcsdf))
        assert again == bcsdf and hash(again) == hash(bcsdf)
        assert np.array_equal(again.eval(wi=X, wo=X, window="far"), bcsdf.eval(wi=X, wo=X, window="far"))
    assert fox != fine and fox != "red-fox" and fox.fiber == vellus.Fiber("red-fox")
    assert repr(fox).startswith("Bcsdf(Fiber(")


PROGRAM = """
import hashlib, numpy as np, vellus
rng = np.random.default_rng(3)
v = rng.normal(size=(2, 20_000, 3))
wi, wo = (v / np.linalg.norm(v, axis=-1, keepdims=True)).astype(np.float32)
h = rng.uniform(-1, 1, 20_000).astype(np.float32)
b = vellus.Bcsdf("cat")
results = [b.eval(wi=wi, wo=wo, h=h), b.eval(wi=wi[:999], wo=wo[:999], window="far")]
results += b.sample(wo, rng.random((20_000, 5)), h)
print(hashlib.sha256(b"".join(r.tobytes() for r in results)).hexdigest())
"""


def test_the_number_of_threads_changes_no_bit():
    def run(threads):
        env = {**os.environ, "RAYON_NUM_THREADS": threads}
        return subprocess.run([sys.executable, "-c", PROGRAM], env=env, capture_output=True, check=True).stdout

    assert run("1") == run("3") == run("8")


def test_one_model_from_many_threads(fox, rng):
    wi, wo, h = unit(rng, 5000), unit(rng, 5000), rng.uniform(-1, 1, 5000)
    expected = fox.eval(wi=wi, wo=wo, h=h)
    same = []
    threads = [
        threading.Thread(target=lambda: same.append(np.array_equal(fox.eval(wi=wi, wo=wo, h=h), expected)))
        for _ in range(8)
    ]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert same == [True] * 8


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_has_threads(fox, rng):
    wi = unit(rng, 5000)
    expected = fox.eval(wi=wi, wo=X, h=0.1)
    child = os.fork()
    if child == 0:
        os._exit(0 if np.array_equal(fox.eval(wi=wi, wo=X, h=0.1), expected) else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_tables_have_the_documented_shapes():
    tables = vellus.tables()
    axes = {"azimuthal": ("tau", "g", "h", "phi"), "backward": ("tau", "g", "theta_o", "theta_i")}
    axes["forward"] = ("tau", "g", "theta_o", "delta")
    for name, factors in axes.items():
        ranks = {tables[name][axis].shape[1] for axis in factors}
        assert len(ranks) == 1
        for axis in factors:
            nodes = tables[name][f"{axis}_nodes"]
            assert tables[name][axis].dtype == np.float32 and nodes.shape == tables[name][axis].shape[:1]
            assert (np.diff(nodes) > 0).all()
    path = tables["mean_path"]
    assert path["value"].shape == tuple(len(path[f"{axis}_nodes"]) for axis in ("tau", "g", "h"))
    # C^N at h = 0 is symmetric in the azimuth, to a few hundredths of its largest value.
    a = tables["azimuthal"]
    density = (a["tau"][12] * a["g"][8] * a["h"][0]) @ a["phi"].T
    assert (density >= 0).all()
    np.testing.assert_allclose(density, density[::-1], rtol=0, atol=0.05 * density.max())
    exits = tables["exit"]
    assert exits["state"].sum(axis=2) == pytest.approx(1, abs=1e-5)
    assert exits["turn"].shape == (*(len(exits[f"{axis}_nodes"]) for axis in ("tau", "g", "reach")), 3)
    # The nodes of τ continue beyond those of the other tables.
    assert exits["tau_nodes"][12] == pytest.approx(a["tau_nodes"][-1]) and len(exits["tau_nodes"]) > 13
