"""Scenes and pictures."""

import os
import pathlib
import resource
import shutil
import signal
import subprocess
import threading
import time

import numpy as np
import pytest

import vellus

ROOT = pathlib.Path(__file__).resolve().parents[3]


def patch(strands=200, seed=1):
    """Bent strands on a square, as arrays."""
    random = np.random.default_rng(seed)
    roots = np.zeros((strands, 3), np.float32)
    roots[:, [0, 2]] = random.uniform(-1, 1, (strands, 2))
    t = np.linspace(0, 1, 4, dtype=np.float32)[:, None]
    points = roots[:, None] + np.concatenate([0.3 * t**2, 0.8 * t, 0 * t], 1)
    return points.reshape(-1, 3), np.full(strands, 4)


def furry(strands=200):
    scene = vellus.Scene()
    look = scene.add_look("red-fox", name="fox")
    scene.add_strands(*patch(strands), 0.02, basis="bezier", look=look, name="fur")
    scene.add_light("dome", 0.5, group="sky")
    scene.add_light("distant", [1, 0.9, 0.8], direction=[0.3, 1, 0.2], angle=1)
    scene.look_at([0, 2, 4], [0, 0.3, 0], fov=35)
    return scene


@pytest.fixture(scope="module")
def scene():
    return furry()


def test_layers_have_their_shapes(scene):
    picture = scene.render(32, 24, 4, layers=["all"])
    assert picture.samples == 4 and (picture.width, picture.height) == (32, 24)
    shapes = {name: array.shape[2:] for name, array in picture.items()}
    assert all(array.shape[:2] == (24, 32) for array in picture.values())
    assert shapes["beauty"] == shapes["normal"] == (3,) and shapes["depth"] == shapes["id"] == ()
    assert shapes["lobes"] == (6, 3) and shapes["lights"] == (2, 3) and shapes["uv"] == (2,)
    assert picture.light_groups == ["sky", "distant"] == scene.light_groups
    assert picture["beauty"].dtype == np.float32 and picture["id"].dtype == np.uint32
    # The light of all groups is the picture. Each sum is exact, and each mean is rounded once.
    np.testing.assert_allclose(picture["lights"].sum(2), picture["beauty"], rtol=1e-6, atol=1e-9)
    assert 0 < picture["alpha"].mean() < 1 and picture["id"].max() <= 200
    assert set(picture) == set(picture.keys()) and len(picture) == len(picture.keys()) and "beauty" in picture
    assert picture.get("denoised") is None
    with pytest.raises(KeyError, match="no layer .*denoised.*: it has beauty"):
        picture["denoised"]


def test_denoised_parts_add_up(scene):
    layers = ["beauty", "fibers", "lobes", "lights", "albedo", "normal"]
    try:
        picture = scene.render(32, 24, 4, layers=layers, denoise=True)
    except ValueError as error:
        assert "pip install pyoidn" in str(error)
        pytest.skip(str(error))
    assert list(picture)[-3:] == ["denoised", "denoised_lobes", "denoised_lights"]
    whole, lobes, lights = (picture[name] for name in list(picture)[-3:])
    assert lobes.shape == (24, 32, 6, 3) and lights.shape == (24, 32, 2, 3)
    np.testing.assert_allclose(lights.sum(2), whole, rtol=1e-4, atol=1e-6)
    assert (lobes.sum(2) <= whole * (1 + 1e-4) + 1e-6).all()


def test_the_same_picture_from_threads_ranges_and_again(scene):
    first = scene.render(24, 16, 3)["beauty"]
    assert np.array_equal(first, scene.render(24, 16, 3)["beauty"])
    assert not np.array_equal(first, scene.render(24, 16, 3, seed=1)["beauty"])
    # A crop is a part of the picture.
    crop = scene.render(24, 16, 3, crop=(4, 2, 8, 10))["beauty"]
    assert np.array_equal(crop, first[2:12, 4:12])
    results = [None] * 4

    def work(i):
        results[i] = scene.render(24, 16, 3)["beauty"]

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    [t.start() for t in threads]
    [t.join() for t in threads]
    assert all(np.array_equal(first, result) for result in results)


def test_a_scene_that_changes_while_it_is_rendered():
    scene = furry(50)
    thread = threading.Thread(target=lambda: [scene.render(32, 32, 4) for _ in range(5)])
    thread.start()
    while thread.is_alive():
        scene.look_at([0, 2, 4], [0, 0.3, 0], fov=35)
    thread.join()


@pytest.mark.parametrize("name", ["vellus"])
def test_the_command_gives_the_same_bits(name, tmp_path):
    built = [path for kind in ("release", "debug") if (path := ROOT / "target" / kind / name).exists()]
    if not built:
        pytest.skip("the command vellus is not built")
    # The other one may be of an older version, with other pictures.
    command = max(built, key=lambda path: path.stat().st_mtime)
    version = subprocess.run([command, "--version"], capture_output=True, text=True, check=True).stdout
    options = ["--small", "--size", "48x32", "--spp", "2", "-o", tmp_path / "a.exr", "--float"]
    subprocess.run([command, "render", "cat", *options], check=True, capture_output=True)
    scene = vellus.Scene.open("cat", small=True, aspect=48 / 32)
    scene.render(48, 32, 2).write(tmp_path / "b.exr", half=False)
    notes = [pixels(tmp_path / file) for file in ("a.exr", "b.exr")]
    assert notes[0] == notes[1], version


def pixels(path):
    """The digest of the pixels in the header of a file."""
    data = path.read_bytes()
    start = data.index(b"vellus_pixels\0string\0") + len(b"vellus_pixels\0string\0") + 4
    return data[start : start + 64]


def test_callbacks_see_and_stop_the_work(scene):
    states = []

    def callback(state):
        states.append(state)
        return state.samples < 4

    picture = scene.render(32, 24, 1000, callback=callback, interval=0.01)
    assert 4 <= picture.samples < 1000 and picture.samples == states[-1].samples
    assert states[0].total == 1000 and 0 < states[0].done < 1 and states[-1].seconds > 0
    assert states[-1].picture()["beauty"].shape == (24, 32, 3)
    assert np.array_equal(states[-1].picture()["beauty"], picture["beauty"])

    def bad(state):
        raise RuntimeError("from the callback")

    with pytest.raises(RuntimeError, match="from the callback"):
        scene.render(32, 24, 1000, callback=bad, interval=0.01)


def test_noise_and_time_end_a_picture(scene):
    assert scene.render(16, 16, 100_000, noise=0.5).samples < 100_000
    start = time.monotonic()
    scene.render(16, 16, 2**31 - 1, time=0.3, interval=0.05)
    assert time.monotonic() - start < 5


def test_ctrl_c_interrupts(scene):
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    start = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        scene.render(256, 256, 2**31 - 1)
    assert time.monotonic() - start < 5
    assert scene.render(8, 8, 1).samples == 1


def test_files(scene, tmp_path):
    picture = scene.render(16, 12, 1)
    assert picture.write(str(tmp_path / "a.exr")) == [tmp_path / "a.exr", tmp_path / "a.png"]
    assert picture.write(tmp_path / "b.png", exposure=1) == [tmp_path / "b.png"]
    assert picture._repr_png_().startswith(b"\x89PNG") and picture.srgb().shape == (12, 16, 3)
    with pytest.raises(ValueError, match="another extension: it must be .exr or .png"):
        picture.write(tmp_path / "c.jpg")
    # A folder cannot be made in a file.
    with pytest.raises(ValueError, match="c.png"):
        picture.write(tmp_path / "a.png" / "c.png")


def test_open_reports(tmp_path):
    file = tmp_path / "fur.usda"
    file.write_text(
        '#usda 1.0\ndef BasisCurves "hair" {\n uniform token type = "linear"\n int[] curveVertexCounts = [2]\n'
        " point3f[] points = [(0, 0, 0), (0, 1, 0)]\n}\n"
    )
    scene = vellus.Scene.open(file)
    assert any("no camera" in warning for warning in scene.warnings) and scene.strand_count == 1
    assert scene.bounds is not None and "1 strands" in repr(scene)
    with pytest.raises(ValueError, match='light = "moon": it must be studio'):
        vellus.Scene.open(file, light="moon")
    with pytest.raises(ValueError, match="need stage=True"):
        vellus.Scene.open(file, stage=False, light="sun")


def test_strands_of_one_length_need_no_counts():
    points, counts = patch(20)
    grid, taper = points.reshape(20, 4, 3), np.linspace(0.03, 0.01, 4)
    pictures = []
    for arguments in (
        dict(points=points, counts=counts, radii=np.tile(taper, 20), moved=points + 0.1),
        dict(points=grid, radii=np.tile(taper, (20, 1)), moved=grid + 0.1),
        dict(points=grid.tolist(), radii=np.tile(taper, 20), moved=points + 0.1),
    ):
        scene = vellus.Scene()
        look = scene.add_look("cat")
        scene.add_strands(**arguments, basis="bezier", look=look, parameters={"melanin": np.full((20, 2), 0.3)})
        scene.add_light("dome", 1.0)
        scene.look_at([0, 2, 4], [0, 0.3, 0], fov=35)
        pictures.append(scene.render(16, 12, 2)["beauty"])
    assert scene.strand_count == 20 and pictures[0].max() > 0
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])


def test_normals_turn_flat_strands_and_no_others():
    points, _ = patch(20)
    grid = points.reshape(20, 4, 3)
    # Across the strands, which bend towards x.
    aside = np.tile([0.0, 0, 1], (20, 4, 1))

    def render(ratio, normals):
        scene = vellus.Scene()
        scene.add_look(vellus.Fiber("human", aspect_ratio=ratio))
        scene.add_strands(grid, radii=0.05, basis="bezier", normals=normals)
        scene.add_light("dome", 1.0)
        scene.look_at([0, 2, 4], [0, 0.3, 0], fov=35)
        return scene.render(16, 12, 2)["beauty"]

    front, side = (render(0.5, normals) for normals in (aside, aside[..., ::-1]))
    assert not np.array_equal(front, side)
    assert np.array_equal(front, render(0.5, aside.reshape(-1, 3)))
    assert np.array_equal(render(1.0, None), render(1.0, aside))


POINTS, COUNTS = patch(3)
BAD = [
    (dict(points=POINTS[:, :2]), r"points has the shape \(12, 2\): it must be \(points, 3\) or \(strands, points, 3\)"),
    (dict(points=POINTS.reshape(3, 4, 3)), r"points has the shape \(3, 4, 3\), which says .* leave counts out"),
    (dict(points=POINTS.reshape(3, 4, 3), counts=None, radii=np.ones((3, 5))), r"radii has the shape \(3, 5\)"),
    (dict(points=POINTS.reshape(3, 4, 3), counts=None, moved=np.ones((4, 3, 3))), r"moved has the shape \(4, 3, 3\)"),
    (dict(normals=POINTS[:-1]), r"normals has the shape \(11, 3\): it must be \(12, 3\)"),
    (dict(normals=np.full_like(POINTS, np.nan)), "normals has NaN at position 0: it must be finite"),
    (dict(points=np.full_like(POINTS, np.nan)), "points has NaN at position 0: it must be finite"),
    (dict(counts=[4, 4]), "counts sums to 8, but points has 12 rows"),
    (dict(counts=[4, 4, 3.5]), "counts has 3.5 at position 2"),
    (dict(counts=[4, 4, -4]), "counts has -4 at position 2"),
    (dict(radii=[0.1, 0.2]), r"radii has the shape \(2,\): it must be \(\) or \(12,\)"),
    (dict(radii=-1.0), r"radii has -1 at position 0: it must be in \[0, 1e9\]"),
    (dict(basis="nurbs"), 'basis = "nurbs" is unknown: it must be one of linear'),
    (dict(basis="bezier", counts=[3, 4, 5]), "strand"),
    (dict(points=np.zeros_like(POINTS)), "strand 0 of strands has no length"),
    (dict(uv=[[0, 0]]), r"uv has the shape \(1, 2\): it must be \(3, 2\)"),
    (dict(parameters={"kapa": 0.5}), 'parameter "kapa" is unknown: it must be one of kappa'),
    (dict(parameters={"kappa": 2.0}), r'parameters\["kappa"\], row 0: kappa = 2 is out of range'),
    (dict(parameters={"kappa": [0.1, 0.2]}), r"has the shape \(2,\): it must be \(\), \(3,\) for strands"),
]


@pytest.mark.parametrize("change, message", BAD, ids=[m[:40] for _, m in BAD])
def test_bad_strands_are_named(change, message):
    scene = vellus.Scene()
    scene.add_look("cat")
    arguments = dict(points=POINTS, counts=COUNTS, radii=0.1, basis="linear") | change
    with pytest.raises(ValueError, match=message):
        scene.add_strands(**arguments)
    # Nothing was added.
    assert scene.strand_count == 0


def test_bad_arguments_are_named(scene):
    new = vellus.Scene()
    for call, error, message in [
        (lambda: new.add_strands(POINTS, radii=0.1), TypeError, "add_strands needs counts"),
        (lambda: new.add_strands(POINTS, COUNTS), TypeError, "add_strands needs radii"),
        (lambda: new.add_strands(POINTS, COUNTS, 0.1, look=3), IndexError, "look = 3 does not exist: the scene has 0"),
        (lambda: new.add_look("unicorn"), ValueError, "unicorn"),
        (lambda: new.add_surface(roughness=2), ValueError, r"roughness = 2 is out of range: it must be in \[0, 1\]"),
        (lambda: new.add_light("lamp"), ValueError, 'kind = "lamp" is unknown'),
        (lambda: new.add_light("sphere", position=[0, 0, 0]), ValueError, "sphere needs radius"),
        (lambda: new.add_light("dome", -1.0), ValueError, "color = -1 is out of range: it must be at least 0"),
        (lambda: new.set_camera(np.eye(3)), ValueError, r"matrix has the shape \(3, 3\): it must be \(4, 4\)"),
        (lambda: new.set_camera(np.eye(4), fov=190), ValueError, "fov = 190 is out of range"),
        (lambda: new.set_camera(2 * np.diag([1, 1, 1, 0.5])), ValueError, "rotation"),
        (lambda: new.add_texture(np.ones((2, 2))), ValueError, r"it must be \(height, width, 3\)"),
        (lambda: new.render(8, 8, 1), ValueError, "nothing to render"),
        (lambda: scene.render(0, 8, 1), ValueError, "width = 0 is out of range"),
        (lambda: scene.render(8, 8, 0), ValueError, "samples = 0 is out of range"),
        (lambda: scene.render(8, 8, 1, layers=["depht"]), ValueError, "layers: unknown layer 'depht'"),
        (lambda: scene.render(8, 8, 1, mode="middle"), ValueError, 'mode = "middle" is unknown'),
        (lambda: scene.render(8, 8, 1, crop=(0, 0, 9, 8)), ValueError, "crop"),
        (lambda: scene.render(8, 8, 1, noise=float("nan")), ValueError, "noise = NaN is out of range"),
    ]:
        with pytest.raises(error, match=message):
            call()


def test_meshes_instances_and_parameters():
    scene = vellus.Scene()
    look = scene.add_look(vellus.Fiber("cat", kappa=0.5))
    map_ = scene.add_texture(np.full((2, 2, 3), 0.5))
    textured = scene.add_look("cat", textures={"reflectance": map_})
    ground = scene.add_surface(color=[0.2, 0.3, 0.1], texture=map_)
    square = np.array([[-2, 0, -2], [-2, 0, 2], [2, 0, 2], [2, 0, -2]], float)
    uv = np.array([[0, 0], [0, 1], [1, 1], [1, 0]], float)
    scene.add_mesh(square, [[0, 1, 2], [0, 2, 3]], surface=ground, uv=uv, normals=np.tile([0, 1, 0], (4, 1)))
    tuft = scene.add_prototype("tuft")
    points, counts = patch(20)
    melanin = np.random.default_rng(2).uniform(0.1, 1, (20, 2))
    parameters = {"melanin": melanin, "beta_m": np.linspace(5, 9, 80), "alpha": 3.0}
    scene.add_strands(points, counts, 0.02, look=look, parameters=parameters, prototype=tuft)
    scene.add_strands(points, counts, np.full(20, 0.02), look=textured, uv=np.zeros((20, 2)), prototype=tuft)
    for x in (-1.0, 1.0):
        matrix = np.eye(4)
        matrix[0, 3] = x
        scene.add_instance(tuft, matrix)
    with pytest.raises(ValueError, match="only rotate, mirror, move and scale uniformly"):
        scene.add_instance(tuft, np.diag([1, 2, 1, 1]))
    scene.add_light("point", 20, position=[0, 5, 0], axis=[0, -1, 0], cone=60, softness=0.2)
    scene.background = None
    scene.look_at([0, 3, 5], [0, 0, 0])
    picture = scene.render(32, 24, 4, layers=["cryptomatte", "fibers"])
    assert picture["crypto-object"].shape == (24, 32, 12) and picture["fibers"].max() > 0
    assert picture["beauty"].mean() > 0
    # The ids are those of the pixels. Every second channel is a coverage.
    for layer in ("crypto-object", "crypto-look"):
        pixels = np.unique(picture[layer][..., ::2].view(np.uint32))
        assert set(pixels) - {0} <= set(picture.ids(layer).values()), picture.ids(layer)
    with pytest.raises(KeyError):
        picture.ids("beauty")


def test_textures_change_the_picture():
    means = []
    for value in (0.05, 0.6):
        scene = vellus.Scene()
        texture = scene.add_texture(np.full((1, 1, 3), value))
        scene.add_look("cat", textures={"reflectance": texture})
        scene.add_strands(*patch(300), 0.03, uv=np.zeros((300, 2)))
        scene.add_light("dome", 1.0, visible=False)
        scene.look_at([0, 4, 1], [0, 0, 0])
        scene.background = 0.0
        means.append(scene.render(24, 24, 16)["beauty"].mean())
    assert means[1] > 1.5 * means[0]


def test_nothing_leaks():
    scene = furry(50)
    scene.render(64, 64, 1)

    def used():
        return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()

    if not pathlib.Path("/proc/self/statm").exists():
        pytest.skip("no /proc/self/statm")
    before = used()
    for i in range(60):
        # A film has 420 bytes a pixel: 60 of them would be 103 MB.
        scene.render(64, 64, 1, callback=lambda state: None)
        if i % 10 == 0:
            scene.look_at([0, 2, 4], [0, 0.3, 0], fov=35)
    assert used() - before < 30e6


def test_transparent_pictures_have_alpha(tmp_path):
    scene = vellus.Scene.open("cat", small=True, background="transparent")
    png = scene.render(24, 16, 1)._repr_png_()
    # The colour type in the header is 6: RGBA.
    assert png[25] == 6


@pytest.mark.skipif(shutil.which("true") is None, reason="no such system")
def test_progress_is_quiet_without_a_terminal(scene, capfd):
    scene.render(8, 8, 2, progress=True)
    assert capfd.readouterr().err == ""


def everything(folder):
    """Calls that use all cores: files, scenes, pictures, fits and plots."""
    picture = furry().render(8, 8, 2)
    path = folder / "a.exr"
    picture.write(path)
    opened = vellus.Scene.open("hair-lock", small=True).render(8, 8, 1)
    plot = np.frombuffer(vellus.plots.models("red-fox").png, np.uint8)
    return [picture["beauty"], picture["depth"], opened["beauty"], plot]


# A child has none of its parent's threads. Work that waits for them would never end.
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_opens_renders_and_writes(tmp_path):
    expected = everything(tmp_path)
    child = os.fork()
    if child == 0:
        try:
            same = all(np.array_equal(a, b) for a, b in zip(everything(tmp_path), expected, strict=True))
        finally:
            os._exit(0 if same else 1)
    end = time.monotonic() + 60
    while (ended := os.waitpid(child, os.WNOHANG))[0] == 0:
        if time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            pytest.fail("the child waits for ever")
        time.sleep(0.05)
    assert ended[1] == 0


def test_pictures_without_memory_are_refused():
    scene = furry()
    with pytest.raises(ValueError, match="32768"):
        scene.render(32769, 1, 1)
    # Half a terabyte.
    if os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") < 400e9:
        with pytest.raises(MemoryError, match="GB of memory"):
            scene.render(32768, 32768, 1)
