"""Every argument of every function: bad values give one error with the argument, its value and its range."""

import ast
import math
import pickle
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stub_docs import STUBS

import vellus

NAN, INF = math.nan, math.inf
X = [0.0, 1.0, 0.0]
SQUARE = np.eye(4)
STRAND = np.stack([np.zeros(4), np.arange(4.0), np.zeros(4)], 1)

# Bad values of each kind of argument, with a part of the message: the value or the shape. `TypeError`: a wrong type.
NO_NUMBER = [("x", TypeError), (None, TypeError), ([None], TypeError)]
NO_ARRAY = [("x", TypeError), ([1j], TypeError), ([None], TypeError), (object(), TypeError)]
KINDS = {
    # Arrays of queries. NaN is no error there: it marks a missing query.
    "unit": [([2.0, 0, 0], "length 2"), ([INF, 0, 0], "length inf"), ([0.0, 0, 0], "length 0"), ([1.0], "(1,)")]
    + [(np.zeros((2, 4)), "(2, 4)"), (1.0, "()"), (None, TypeError), (np.ones(3, bool), TypeError)]
    + NO_ARRAY,
    "offset": [(2, "2"), (-INF, "-inf"), (1e30, "1" + 30 * "0")] + NO_ARRAY,
    "ends": [([-3, 0], "-3"), ([0, INF], "inf"), ([0.1], "(1,)"), ("near", "near")] + NO_ARRAY[1:],
    "uniform": [([1.5] * 5, "1.5"), ([-1] * 5, "-1"), ([INF] * 5, "inf"), ([0.1] * 3, "(3,)")] + NO_ARRAY,
    "shift": [(1.5, "1.5"), (-0.1, "-0.1"), (INF, "inf")] + NO_ARRAY,
    "width": [(-1, "-1"), (-INF, "-inf")] + NO_ARRAY,
    "inclination": [(91, "91"), (-INF, "-inf"), (1e30, "1" + 30 * "0")] + NO_ARRAY,
    "azimuth": [(INF, "inf")] + NO_ARRAY,
    "reflectance": [(-0.1, "-0.1"), (1.1, "1.1"), (INF, "inf")] + NO_ARRAY,
    "absorption": [(-1, "-1"), (INF, "inf")] + NO_ARRAY,
    # Arrays where NaN is an error.
    "angles": [([NAN], "NaN"), ([1000.0], "1000"), ([-INF], "-inf"), (np.zeros((2, 2)), "(2, 2)")] + NO_ARRAY,
    "vector": [([NAN, 0, 1], "NaN"), ([INF, 0, 1], "inf"), ([1, 2], "(2,)"), (1.0, "()")] + NO_ARRAY,
    "arrow": [([0, 0, 0], "zero"), ([NAN, 0, 1], "NaN"), ([1, 2], "(2,)")] + NO_ARRAY,
    "color": [(NAN, "NaN"), (-1, "-1"), ([0.1, 0.2], "(2,)"), ([INF, 0, 0], "inf")] + NO_ARRAY,
    "tint": [(NAN, "NaN"), (-1, "-1"), (2, "2"), ([0.1, 0.2], "(2,)")] + NO_ARRAY,
    "coat color": [([NAN, 0, 0], "NaN"), ([0, 2, 0], "2"), ("unicorn", "unicorn"), (3, TypeError)],
    "matrix": [(np.eye(3), "(3, 3)"), (NAN * SQUARE, "NaN"), (0 * SQUARE, "0, 0, 0, 1"), (1, "()")] + NO_ARRAY,
    "points": [([[NAN, 0, 0]], "NaN"), ([1, 2, 3], "(3,)"), ([[1, 2]], "(1, 2)"), (1e30 * STRAND, "1e30")]
    + NO_ARRAY,
    "counts": [([-4], "-4"), ([1.5], "1.5"), ([[4]], "(1, 1)"), ([5], "5"), ([NAN], "NaN")] + NO_ARRAY,
    "radii": [(-1, "-1"), (NAN, "NaN"), ([1, 2, 3, 4, 5], "(5,)"), (INF, "inf")] + NO_ARRAY,
    "triangles": [([[0, 1]], "(1, 2)"), ([[0, 1, 9]], "4 points"), ([[0, 1, -1]], "-1"), ([[0, 1, NAN]], "NaN")]
    + NO_ARRAY,
    "moved": [([[0, 0, 0]], "(1, 3)"), (np.full((4, 3), NAN), "NaN")] + NO_ARRAY,
    "uv": [([[0, 0, 0]], "(1, 3)"), ([[NAN, 0]] * 4, "NaN")] + NO_ARRAY,
    "corners": [([[0, 0, 0, 0]], "(1, 4)"), (np.full((4, 3), NAN), "NaN")] + NO_ARRAY,
    "image": [(np.ones((2, 2)), "(2, 2)"), (np.full((1, 1, 3), NAN), "NaN"), (-np.ones((1, 1, 3)), "-1")],
    "measured": [([-1.0] * 40, "-1"), ([INF] * 40, "inf"), ([1.0] * 7, "(7,)")] + NO_ARRAY,
    "deviations": [([-1.0] * 40, "-1"), ([NAN] * 40, "NaN"), ([INF] * 40, "inf"), (0, "0"), ([1.0] * 7, "(7,)")]
    + NO_ARRAY,
    "widths": [(NAN, "NaN"), (31, "31"), (-1, "-1"), ((1, INF), "inf"), ((1, 2, 3), "3 numbers")] + NO_ARRAY,
    "unchecked widths": [((1, 2, 3), "3 numbers")] + NO_ARRAY,
    # Single numbers.
    "right angle": [(NAN, "NaN"), (91, "91"), (INF, "inf")] + NO_NUMBER,
    "h": [(NAN, "NaN"), (2, "2"), (-INF, "-inf"), ("x", TypeError)],
    "share": [(NAN, "NaN"), (-0.1, "-0.1"), (2, "2"), (INF, "inf")] + NO_NUMBER[:1],
    "positive": [(NAN, "NaN"), (-1, "-1"), (0, "0"), (INF, "inf")] + NO_NUMBER[:1],
    "not negative": [(NAN, "NaN"), (-1, "-1"), (INF, "inf")] + NO_NUMBER[:1],
    "at least 1": [(NAN, "NaN"), (0.5, "0.5"), (-INF, "-inf")] + NO_NUMBER[:1],
    "level of detail": [("full", "full"), (9, "9"), (NAN, "NaN"), (-INF, "-inf"), ([1], TypeError)],
    "view": [(NAN, "NaN"), (0, "0"), (180, "180"), (-40, "-40")] + NO_NUMBER,
    "index of refraction": [(NAN, "NaN"), (0.5, "0.5"), (9, "9")] + NO_NUMBER,
    "half angle": [(NAN, "NaN"), (-1, "-1"), (181, "181")] + NO_NUMBER,
    "cone": [(NAN, "NaN"), (0, "0"), (181, "181")] + NO_NUMBER[:1],
    "stops": [(NAN, "NaN"), (101, "101"), (-INF, "-inf")] + NO_NUMBER,
    # Whole numbers.
    "count": [(0, "0"), (-1, "-1"), (10**30, "1" + 30 * "0"), (1.5, TypeError), (None, TypeError)],
    "depth": [(-1, "-1"), (10**30, "1" + 30 * "0"), (1.5, TypeError)],
    "seed": [(-1, "-1"), (10**30, "1" + 30 * "0"), (1.5, TypeError), (None, TypeError)],
    "channels": [(2, "2"), (-1, "-1"), ("x", TypeError)],
    "photons": [(1, "1"), (-1, "-1"), (10**30, "1" + 30 * "0"), ("x", TypeError)],
    "index": [(9, "9"), (-1, "-1"), (10**30, "1" + 30 * "0"), ("x", TypeError)],
    "crop": [((0, 0, 99, 8), "99"), ((-1, 0, 8, 8), "-1"), ((0, 0, 0, 8), "0"), ((1, 2), "got 2"), (5, TypeError)],
    # First and last angle, or two sizes.
    "axis": [((50, 10), "50"), ((NAN, 1), "NaN"), ((0, INF), "inf"), ((1,), "got 1"), (5, TypeError)],
    "steps": [((0, 1), "0"), ((NAN, 1), "NaN"), ((-1, 1), "-1"), ((1,), "got 1"), (5, TypeError)],
    "pair": [((2, 0), "2"), ((NAN, 0), "NaN"), ((0,), "got 1"), (5, TypeError)],
    # Everything else.
    "fiber": [("unicorn", "unicorn"), (3, TypeError), (None, TypeError)],
    "optional fiber": [("unicorn", "unicorn"), (3, TypeError)],
    "choice": [("unicorn", "unicorn"), (3, TypeError)],
    "choices": [(["unicorn"], "unicorn"), ("unicorn", TypeError), ([3], TypeError)],
    "flag": [(2, TypeError), ("x", TypeError)],
    "text": [(3, TypeError)],
    "path": [(3, TypeError), (None, TypeError)],
    "profiles": [(3, TypeError), (None, TypeError), ("cat", TypeError), ([3], TypeError), ([], "empty")],
    "optional path": [(3, TypeError), ("nowhere.obj", "nowhere.obj")],
    "callback": [],
    "table": [(3, TypeError), ({3: 3}, TypeError), ({"unicorn": 0.5}, "unicorn")],
    "ties": [(3, TypeError), ({"unicorn": "eta"}, "unicorn"), ({"eta": 3}, TypeError)],
    "textures": [(3, TypeError), ({3: 3}, TypeError), ({"unicorn": 0}, "unicorn"), ({"kappa": -1}, "-1")],
}

# The message has another word than the name.
OTHER_NAMES = {
    # Names of files, presets, parameters and models are the values.
    "fiber", "path", "text", "fix", "tie", "free", "separate", "share", "textures", "layer", "default", "parameters",
    "body",
    # The strand or the vertex of a mesh.
    "points", "model", "models", "name", "exit", "values", "theta", "phi", "counts",
}  # fmt: skip

GRID = np.meshgrid(np.arange(10.0, 15), np.arange(0.0, 160, 20), indexing="ij")
MEASURED = {"theta": GRID[0].ravel(), "phi": GRID[1].ravel(), "values": np.ones(40), "theta_o": 5.0}
QUERY = {"h": "offset", "check": "flag", "parameters": "table"}
EVAL = {"wi": "unit", "wo": "unit", "lobes": "flag", **QUERY}


def scene():
    made = vellus.Scene()
    made.add_look("cat")
    made.add_surface()
    made.add_strands(STRAND, [4], 0.1)
    made.add_light("dome")
    made.look_at([0, 2, 9], [0, 2, 0])
    return made


def window(kinds):
    """The same call with a window."""
    return {name: kind for name, kind in kinds.items() if name != "h"} | {"window": "ends"}


def queries(model):
    good = {"wi": X, "wo": X, "h": 0.1}
    near = {
        "eval": EVAL,
        "pdf": {k: v for k, v in EVAL.items() if k != "lobes"},
        "eval_pdf": EVAL,
        "sample": {"wo": "unit", "u": "uniform", **QUERY},
        "energy": {"wo": "unit", "lobes": "flag", **QUERY},
    }
    for name, kinds in near.items():
        base = {k: v for k, v in {**good, "u": [0.1] * 5}.items() if k in kinds}
        yield name, getattr(model, name), base, kinds
        far = {k: v for k, v in base.items() if k != "h"} | {"window": "far"}
        yield name, getattr(model, name), far, window(kinds)


def calls():
    """(name in the stubs, function, good arguments, kind of each argument)."""
    at = {"fiber": "cat", "theta_o": 1.0}
    cells = {**at, "theta": [1.0, 2.0], "phi": [3.0, 4.0]}
    for owner, model in (("Bcsdf", vellus.Bcsdf("cat")), ("Model", vellus.models.Model("marschner2003", "cat"))):
        yield from ((f"{owner}.{name}", *rest) for name, *rest in queries(model))
    yield "Bcsdf", vellus.Bcsdf, {"fiber": "cat"}, {"fiber": "fiber", "fine_windows": "flag"}
    yield "Model", vellus.models.Model, {"name": "vellus", "fiber": "cat"}, {"name": "choice", "fiber": "fiber"}
    yield "CoatColors", vellus.CoatColors, {"fiber": "cat"}, {"fiber": "fiber"}
    coat = vellus.CoatColors("cat")
    yield "CoatColors.absorption", coat.absorption, {"color": 0.2}, {"color": "reflectance"}
    yield "CoatColors.color", coat.color, {"absorption": 0.2}, {"absorption": "absorption"}
    yield "pixel_window", vellus.pixel_window, {"h": 0.1, "width": 0.2}, {"h": "offset", "width": "width"}
    kinds = {"h": "offset", "width": "width", "u": "shift"}
    yield "cell_window", vellus.cell_window, {"h": 0.1, "width": 0.2, "u": 0.3}, kinds
    yield "direction", vellus.direction, {"theta": 1, "phi": 2}, {"theta": "inclination", "phi": "azimuth"}
    angles = {"fiber": "fiber", "theta_o": "right angle", "theta": "angles", "phi": "angles"}
    yield "profile", vellus.profile, cells, {**angles, "model": "choice"}
    run = {"photons": "photons", "seed": "seed", "progress": "callback"}
    yield "simulate", vellus.simulate, {**cells, "photons": 10}, {**angles, **run, "size": "steps"}
    kinds = {"fiber": "fiber", "theta_o": "right angle", "h": "h", **run}
    yield "simulate_energies", vellus.simulate_energies, {**at, "photons": 10}, kinds
    yield from measurements()
    yield from pictures()
    yield from scenes()


def measurements():
    kinds = {"theta": "angles", "phi": "angles", "values": "measured", "theta_o": "right angle"}
    # Its angles may have any shape.
    kinds = {**kinds, "theta": "azimuth", "phi": "azimuth", "quantity": "choice", "channels": "channels"}
    kinds |= {"sigma": "deviations", "blur": "widths", "channel": "callback"}
    yield "Profile", vellus.Profile, MEASURED, kinds
    kinds = {"path": "path", "theta_o": "callback", "angles": "choice", "quantity": "choice"}
    kinds |= {"theta": "callback", "phi": "callback", "blur": "unchecked widths"}
    yield "Profile.read", vellus.Profile.read, {"path": "nowhere.csv"}, kinds
    kinds = {name: kind for name, kind in kinds.items() if name not in ("theta", "phi")}
    yield "Profile.read_channels", vellus.Profile.read_channels, {"path": "nowhere.csv"}, kinds
    kinds = {"fiber": "fiber", "theta_o": "right angle", "theta": "axis", "phi": "axis", "step": "steps"}
    kinds |= {"noise": "share", "gaps": "share", "scale": "positive", "channels": "channels", "seed": "seed"}
    kinds |= {"background": "not negative", "blur": "widths"}
    kinds |= {"photons": "photons", "model": "choice", "progress": "callback"}
    good = {"fiber": "cat", "step": (10.0, 10.0)}
    yield "Profile.measure", vellus.Profile.measure, good, kinds
    profile = vellus.Profile.measure(**good)
    yield "Profile.write", profile.write, {"path": "nowhere/a.csv"}, {"path": "path"}
    kinds = {"profile": "profiles", "model": "choice", "starts": "count", "seed": "seed", "huber": "at least 1"}
    kinds |= {"exit": "choice", "fix": "table", "tie": "ties", "free": "choices", "progress": "callback"}
    kinds |= {"separate": "choices", "share": "choices"}
    yield "fit", vellus.fit, {"profile": profile, "starts": 1}, kinds
    fit = vellus.fit(profile, starts=1)
    yield "Fit.plot", fit.plot, {}, {"kind": "choice", "profile": "index"}
    yield "Fiber.from_json", vellus.Fiber.from_json, {"text": "{}"}, {"text": "text"}
    yield "Fiber.read", vellus.Fiber.read, {"path": "nowhere.toml"}, {"path": "path"}


def pictures():
    plots = {"fiber": "fiber", "theta_o": "right angle", "model": "choice"}
    plot = vellus.plots
    yield "plot_lobes", plot.lobes, {"fiber": "cat"}, {**plots, "h": "h"}
    yield "plot_profile", plot.profile, {"fiber": "cat"}, {**plots, "theta": "axis", "phi": "axis"}
    yield "plot_energy", plot.energy, {"fiber": "cat"}, plots
    kinds = {"fiber": "fiber", "theta_o": "right angle"}
    yield "plot_models", plot.models, {"fiber": "cat"}, {**kinds, "models": "choices"}
    yield "plot_windows", plot.windows, {"fiber": "cat", "window": (0, 1)}, {**kinds, "window": "pair"}
    yield "Plot.save", plot.lobes("cat").save, {"path": "a.jpg"}, {"path": "path"}
    picture = scene().render(4, 4, 1)
    kinds = {"path": "path", "exposure": "stops", "tone": "choice", "half": "flag"}
    yield "Picture.write", picture.write, {"path": "a.png"}, kinds
    yield "Picture.srgb", picture.srgb, {}, {"exposure": "stops", "tone": "choice"}
    yield "Picture.ids", picture.ids, {"layer": "crypto-object"}, {"layer": "choice"}
    yield "Picture.get", picture.get, {"name": "beauty"}, {"name": "text", "default": "callback"}


def scenes():
    made = scene()
    kinds = {"path": "path", "small": "flag", "fiber": "optional fiber", "width": "not negative", "strands": "positive"}
    kinds |= {"camera": "text", "frame": "callback", "stage": "flag", "aspect": "positive", "light": "choice"}
    kinds |= {"background": "choice", "view": "choice", "body": "optional path"}
    kinds |= {"strict": "flag", "reflectance_of": "choice", "tip_color": "coat color", "tips": "share"}
    kinds |= {"ramp": "choice", "belly": "coat color", "mix": "choices", "coat": "choice", "wet": "share"}
    kinds |= {"shutter": "pair"}
    yield "Scene.open", vellus.Scene.open, {"path": "cat", "small": True}, kinds
    kinds = {"fiber": "fiber", "name": "text", "textures": "textures"}
    yield "Scene.add_look", made.add_look, {"fiber": "cat"}, kinds
    kinds = {"image": "image", "wrap": "choice", "linear": "flag", "name": "text"}
    yield "Scene.add_texture", made.add_texture, {"image": np.ones((1, 1, 3))}, kinds
    both = {"points": "points", "moved": "moved", "name": "text", "prototype": "index"}
    kinds = {**both, "counts": "counts", "radii": "radii", "look": "index", "basis": "choice", "uv": "uv"}
    good = {"points": STRAND, "counts": [4], "radii": 0.1}
    yield "Scene.add_strands", made.add_strands, good, {**kinds, "normals": "corners", "parameters": "table"}
    kinds = {"color": "tint", "texture": "index", "emission": "color", "roughness": "share", "metallic": "share"}
    yield "Scene.add_surface", made.add_surface, {}, {**kinds, "ior": "index of refraction", "name": "text"}
    kinds = {**both, "triangles": "triangles", "surface": "index", "normals": "corners", "uv": "uv"}
    good = {"points": STRAND, "triangles": [[0, 1, 2]], "surface": 0}
    yield "Scene.add_mesh", made.add_mesh, good, kinds
    yield "Scene.add_prototype", made.add_prototype, {}, {"name": "text"}
    kinds = {"prototype": "index", "matrix": "matrix"}
    yield "Scene.add_instance", made.add_instance, {"prototype": made.add_prototype(), "matrix": SQUARE}, kinds
    kinds = {"kind": "choice", "color": "color", "matrix": "matrix", "direction": "arrow", "angle": "half angle"}
    kinds |= {"group": "text", "visible": "flag", "texture": "index"}
    good = {"kind": "distant", "direction": X}
    yield "Scene.add_light", made.add_light, good, kinds
    kinds = {"position": "vector", "radius": "positive", "axis": "arrow", "cone": "cone", "softness": "share"}
    good = {"kind": "cylinder", "position": X, "radius": 1, "axis": X, "cone": 30}
    yield "Scene.add_light", made.add_light, good, kinds
    kinds = {"matrix": "matrix", "moved": "matrix", "fov": "view", "aperture": "not negative"}
    yield "Scene.set_camera", made.set_camera, {"matrix": SQUARE}, {**kinds, "focus_distance": "positive"}
    kinds = {"eye": "vector", "target": "vector", "up": "vector", "fov": "view"}
    yield "Scene.look_at", made.look_at, {"eye": [0, 0, 9], "target": [0, 0, 0]}, kinds
    small = {"width": 8, "height": 8, "samples": 1}
    kinds = {"width": "count", "height": "count", "samples": "count", "layers": "choices", "mode": "choice"}
    kinds |= {"filter": "choice", "seed": "seed", "crop": "crop", "noise": "positive", "time": "positive"}
    kinds |= {"max_depth": "depth", "clamp_indirect": "positive", "radiance_cache": "photons", "denoise": "flag"}
    kinds |= {"lod": "level of detail"}
    kinds |= {"callback": "callback", "interval": "positive", "progress": "flag"}
    yield "Scene.render", scene().render, small, kinds


CALLS = list(calls())


@pytest.mark.parametrize("name, function, good, kinds", CALLS, ids=[f"{i}-{c[0]}" for i, c in enumerate(CALLS)])
def test_bad_arguments_are_named_with_their_values(name, function, good, kinds, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    problems = []
    for argument, kind in kinds.items():
        for value, expected in KINDS[kind]:
            try:
                function(**{**good, argument: value})
                problems.append(f"{argument} = {value!r} is accepted")
                continue
            except (ValueError, TypeError, LookupError, OSError) as caught:
                error = caught
            # PyO3 adds the names of arguments of a wrong type as notes, which Python has from version 3.11 on.
            text = "\n".join([str(error), *getattr(error, "__notes__", [])])
            is_type = isinstance(error, TypeError)
            is_right = is_type if expected is TypeError else not is_type and (expected or "") in text
            is_named = argument in OTHER_NAMES or argument in text or sys.version_info < (3, 11)
            if not (is_right and is_named):
                problems.append(f"{argument} = {value!r}: {error!r}")
    assert not problems, "\n".join([name, *problems])


def test_the_table_has_every_argument():
    given = {(name, argument) for name, _, _, kinds in CALLS for argument in kinds}
    # Those of `Fiber` are tested beside it.
    skipped = {"Fiber", "Fiber.replace", "Scene"}
    missing = []
    for node in ast.parse(STUBS.read_text()).body:
        if isinstance(node, ast.FunctionDef):
            functions = [(node.name, node)]
        elif isinstance(node, ast.ClassDef):
            methods = [n for n in node.body if isinstance(n, ast.FunctionDef) and not n.decorator_list]
            methods += [n for n in node.body if isinstance(n, ast.FunctionDef) and any(
                getattr(d, "id", "") == "staticmethod" for d in n.decorator_list)]  # fmt: skip
            named = [(f"{node.name}.{n.name}".removesuffix(".__new__"), n) for n in methods]
            functions = [(name, n) for name, n in named if "._" not in name]
        else:
            continue
        for name, function in functions:
            arguments = function.args.posonlyargs + function.args.args + function.args.kwonlyargs
            names = {argument.arg for argument in arguments} - {"self", "cls"}
            if name not in skipped:
                missing += [f"{name}: {argument}" for argument in sorted(names) if (name, argument) not in given]
    assert not missing


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([(n, f, g, k) for n, f, g, k in CALLS if n.startswith(("Bcsdf.", "pixel", "cell", "direction"))]),
    st.data(),
)
def test_any_array_gives_a_result_or_a_named_error(call, data):
    """Shapes, types and numbers at random: no crash, no exception of another kind."""
    name, function, good, kinds = call
    arguments = [argument for argument, kind in kinds.items() if kind not in ("flag", "callback")]
    argument = data.draw(st.sampled_from(arguments))
    shape = data.draw(st.lists(st.integers(0, 4), max_size=3))
    dtype = data.draw(st.sampled_from(["f2", "f4", "f8", ">f8", "i1", "u8", "?", "c8", "U1", "O", "M8[s]"]))
    seed = data.draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    numbers = rng.choice([0.0, 1.0, -1.0, 0.5, NAN, INF, -INF, 1e300, 2.0], size=shape)
    with np.errstate(all="ignore"):
        array = np.abs(numbers).astype(dtype) if dtype == "u8" else numbers.astype(dtype)
    try:
        function(**{**good, argument: array})
    except (ValueError, TypeError) as error:
        assert argument in str(error), f"{name}({argument}={array!r}): {error}"


def test_every_class_is_pickled_or_refused():
    profile = vellus.Profile.measure("cat", step=(10, 10))
    bcsdf = vellus.Bcsdf("cat")
    noisy = vellus.Profile(**MEASURED, sigma=0.1, blur=(5, 2.5))
    kept = [bcsdf.fiber, bcsdf, vellus.models.Model("marschner2003", "cat"), profile, noisy]
    for value in kept:
        assert pickle.loads(pickle.dumps(value)) == value
    coat = pickle.loads(pickle.dumps(vellus.CoatColors("cat")))
    assert coat.color(0.2) == vellus.CoatColors("cat").color(0.2)
    for value in (bcsdf.sample(X, [0.1] * 5, 0.1), vellus.simulate_energies("cat", 1, photons=10)):
        again = pickle.loads(pickle.dumps(value))
        assert type(again) is type(value) and all(np.array_equal(a, b) for a, b in zip(again, value))
    fit = vellus.fit(profile, starts=1)
    assert pickle.loads(pickle.dumps(fit.estimates)) == fit.estimates
    for value in (scene(), scene().render(4, 4, 1), fit, fit.plot()):
        with pytest.raises(TypeError, match=f"cannot pickle .*{type(value).__name__}"):
            pickle.dumps(value)
