"""Fibres: parameters, colours, files, errors."""

import copy
import json
import math
import pickle

import pytest
import vellus
from hypothesis import given
from hypothesis import strategies as st
from vellus import Fiber

NAMES = [*vellus.species(), *(f"{name}-published" for name in vellus.species())]


def test_version_is_that_of_the_crates():
    assert vellus.__version__.count(".") == 2


@pytest.mark.parametrize("name", NAMES)
def test_presets_survive_json_pickle_dict_and_repr(name):
    fiber = Fiber(name)
    assert Fiber.from_json(fiber.to_json()) == fiber
    assert pickle.loads(pickle.dumps(fiber)) == fiber == copy.deepcopy(fiber)
    assert Fiber(**fiber.to_dict()) == fiber
    assert eval(repr(fiber)) == fiber
    assert hash(Fiber(name)) == hash(fiber)
    assert json.loads(fiber.to_json())["kappa"] == fiber.kappa


def test_parameters_are_those_of_files():
    fox = Fiber("red-fox")
    assert (fox.alpha, fox.beta_m, fox.beta_n, fox.layers) == (2.64, 9.45, 17.63, 0.68)
    assert fox.exit == "reflecting" and Fiber("red-fox-published").exit == "open"
    changed = fox.replace(alpha=3, sigma_ca=(0.1, 0.2, 0.4), exit="open")
    assert (changed.alpha, changed.sigma_ca, changed.exit) == (3.0, (0.1, 0.2, 0.4), "open")
    assert changed != fox and changed.kappa == fox.kappa
    assert Fiber("red-fox", sigma_ca=0.5).sigma_ca == (0.5, 0.5, 0.5)


@given(
    kappa=st.floats(0, 0.99),
    alpha=st.floats(-45, 45),
    beta_m=st.floats(0.1, 90),
    sigma=st.tuples(*[st.floats(0, 1000, width=32)] * 3),
)
def test_any_parameters_in_range_are_kept(kappa, alpha, beta_m, sigma):
    fiber = Fiber(kappa=kappa, alpha=alpha, beta_m=beta_m, sigma_ca=sigma)
    assert pickle.loads(pickle.dumps(fiber)) == fiber
    assert fiber.kappa == pytest.approx(kappa, rel=1e-6, abs=1e-45) and fiber.alpha == pytest.approx(
        alpha, rel=1e-5, abs=1e-6
    )
    assert fiber.sigma_ca == pytest.approx(sigma, rel=1e-7, abs=1e-45)


def test_colours():
    assert Fiber("red-fox", reflectance=(0.5, 0.3, 0.2)).coat_color() == pytest.approx((0.5, 0.3, 0.2), abs=0.01)
    brown = Fiber(melanin=(1.3, 0.2))
    assert brown == Fiber(eumelanin=1.3, pheomelanin=0.2)
    assert brown.sigma_ca[0] == pytest.approx(1.3 * 0.419 + 0.2 * 0.187, rel=1e-6)
    assert Fiber(hair_reflectance=0.5).sigma_ma == (0, 0, 0)
    assert brown.without_absorption().sigma_ca == (0, 0, 0)
    with pytest.warns(UserWarning, match="no pigment gives this fibre"):
        Fiber(reflectance=0.001)
    colors = vellus.CoatColors("cat")
    assert colors.color(colors.absorption([0.5, 0.2])) == pytest.approx([0.5, 0.2], abs=1e-4)
    assert pickle.loads(pickle.dumps(colors)).range == colors.range


@pytest.mark.parametrize(
    ("arguments", "error", "text"),
    [
        ({"kappa": 2}, ValueError, "kappa = 2 is out of range: it must be in [0, 0.99]"),
        ({"kappa": math.nan}, ValueError, "kappa = NaN is out of range"),
        ({"eta": 1e300}, ValueError, "eta = inf is out of range"),
        ({"beta_m": 0}, ValueError, "it must be in [0.1, 90] degrees"),
        ({"sigma_ca": (0, -1, 0)}, ValueError, "sigma_ca.g = -1 is out of range: it must be in [0, 1000] per fibre"),
        ({"sigma_ca": (1, 2)}, ValueError, "sigma_ca takes one number or three, not 2"),
        ({"kappa": "0.5"}, TypeError, "kappa must be a number or a sequence of numbers"),
        ({"kappa": [None]}, TypeError, "kappa must be a number"),
        ({"colour": 1}, TypeError, "unknown parameter 'colour': known are kappa"),
        ({"exit": "closed"}, ValueError, "unknown exit 'closed'"),
        ({"exit": 3}, TypeError, "exit must be a string"),
        ({"melanin": 1, "reflectance": 0.5}, ValueError, "colour is given more than once"),
    ],
)
def test_bad_parameters_are_named(arguments, error, text):
    for make in (Fiber, Fiber("cat").replace):
        with pytest.raises(error) as caught:
            make(**arguments)
        assert text in str(caught.value)


def test_unknown_presets_and_bad_json():
    with pytest.raises(ValueError, match="unknown preset 'unicorn': known are bobcat"):
        Fiber("unicorn")
    with pytest.raises(ValueError, match="kappa = 7 is out of range"):
        Fiber.from_json('{"kappa": 7}')
    with pytest.raises(ValueError, match="line 1"):
        Fiber.from_json("{")
    with pytest.raises(AttributeError):
        Fiber("cat").kappa = 0.5
    with pytest.raises(TypeError, match="fiber must be a Fiber or the name of a preset"):
        vellus.Bcsdf(3)


def test_files(tmp_path):
    path = tmp_path / "fox.toml"
    path.write_text(Fiber("red-fox").to_toml())
    assert Fiber.read(path) == Fiber("red-fox")
    assert Fiber.read(str(path), "kappa=0.5", "sigma_ca=0.1,0.2,0.4").sigma_ca == (0.1, 0.2, 0.4)


def test_html_has_parameters_and_a_swatch():
    html = Fiber("red-fox")._repr_html_()
    assert "kappa" in html and "0.924" in html and "rgb(" in html
