"""Scenes for single features of the engine. Run with a Python that has bpy: test_scenes.py EXTENSION.zip [VELLUS]

Cycles is the reference for directions, blur and colours, and the command VELLUS for the exported USD.
"""

import math
import os
import subprocess

import numpy as np

# This chooses the user's folder before Blender starts.
import test_engine as base
from test_engine import FOLDER, SIZE, VELLUS, add, bpy, furry, render


def with_cycles(name, samples=64):
    """The picture of Cycles, without denoising, with all bounces, and with the same lobes at all of them."""
    scene = bpy.context.scene
    engine, scene.render.engine = scene.render.engine, "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", samples, False, False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 64
    cycles.sample_clamp_indirect, cycles.blur_glossy, cycles.pixel_filter_type = 0, 0, "BOX"
    scene.cycles_curves.shape = "THICK"
    picture = render(name)
    scene.render.engine = engine
    return picture


def exported(name, samples=64):
    """The picture of `vellus render` for the exported USD file, or `None` without the command."""
    if not VELLUS:
        print("skipped: no command vellus to compare with")
        return None
    bpy.ops.wm.usd_export(filepath=str(FOLDER / f"{name}.usda"))
    command = [VELLUS[0], "render", FOLDER / f"{name}.usda", "--size", "{}x{}".format(*SIZE), "--spp", str(samples)]
    output = FOLDER / f"{name}-usd.exr"
    subprocess.run([*command, "--layers", "beauty,alpha", "-o", output], check=True, capture_output=True)
    return base.read(output)


def halves(picture):
    """Mean colours of the left and the right half, (2, 3)."""
    middle = SIZE[0] // 2
    return np.stack([picture[:, :middle, :3].mean((0, 1)), picture[:, middle:, :3].mean((0, 1))])


def surround(turn):
    """A world with another colour on each side, turned about the vertical axis by `turn` radians."""
    width, height = 64, 32
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = 0.1
    pixels[:, 4:20, 0], pixels[:, 36:44, 2], pixels[: height // 3, :, 1] = 2.0, 3.0, 0.6
    image = bpy.data.images.new("sides", width, height, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    image.pixels.foreach_set(pixels.ravel())
    image.filepath_raw, image.file_format = str(FOLDER / "sides.exr"), "OPEN_EXR"
    image.save()
    tree = bpy.context.scene.world.node_tree
    texture, mapping = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    texture.image = bpy.data.images.load(str(FOLDER / "sides.exr"))
    texture.image.colorspace_settings.name = "Linear Rec.709"
    mapping.inputs["Rotation"].default_value = (0, 0, turn)
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])


def test_an_image_of_the_world_has_the_rotation_of_cycles_and_of_the_exported_file():
    for turn in (0.0, 0.8, -2.2):
        furry(600)
        bpy.data.objects.remove(bpy.data.objects["key"])
        surround(turn)
        ours, cycles = halves(render("world")), halves(with_cycles("world-cycles"))
        print("world turned by", turn, "engine over Cycles:", (ours / cycles).round(3).tolist())
        # Where the sky is behind the ball the pictures are equal. The fur differs by the model: 0.9 % was measured.
        assert np.all(np.abs(ours / cycles - 1) < 0.02), (ours, cycles)
        theirs = exported("world")
        if theirs is not None:
            print("engine over vellus render:", (ours / halves(theirs)).round(4).tolist())
            assert np.all(np.abs(ours / halves(theirs) - 1) < 0.01), (ours, halves(theirs))


def coverage(change, blurred=0.02):
    """The alpha of the engine and of Cycles, and that of the engine before `change(scene)`, which must differ."""
    scene = furry(400)
    scene.render.film_transparent = True
    sharp = render("sharp")[..., 3]
    change(scene)
    ours, cycles = render("ours")[..., 3], with_cycles("cycles")[..., 3]
    assert np.abs(ours - sharp).mean() > blurred, "nothing is blurred"
    difference = np.abs(ours - cycles).mean()
    print("mean difference of coverage:", difference, "by the blur:", np.abs(ours - sharp).mean())
    # Coverage of 64 samples has a deviation of at most 0.5 / 8 a pixel in each picture, at edges only.
    assert difference < 0.02
    assert abs(ours.mean() / cycles.mean() - 1) < 0.02


def test_depth_of_field_blurs_as_in_cycles():
    def change(scene):
        dof = scene.camera.data.dof
        dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 2.0, 0.1

    coverage(change)


def moving(owner):
    """Moves an object along x, 1 unit a frame, in the middle of the picture at frame 2."""
    for frame in (1, 3):
        owner.location[0] = frame - 2
        owner.keyframe_insert("location", frame=frame)
    # Keys are Bézier curves: with two of them the motion eases. A third in the middle would not make it even.
    action = owner.animation_data.action
    curves = action.fcurves if hasattr(action, "fcurves") else action.layers[0].strips[0].channelbags[0].fcurves
    for curve in curves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    bpy.context.scene.frame_set(2)
    render = bpy.context.scene.render
    render.use_motion_blur, render.motion_blur_shutter = True, 0.5
    render.motion_blur_position = "CENTER"


def test_a_moving_mesh_and_moving_curves_blur_as_in_cycles():
    def change(scene):
        for name in ("fur", "Sphere"):
            moving(bpy.data.objects[name])

    coverage(change)


def test_a_moving_instance_of_a_furred_mesh_blurs_as_in_cycles():
    def change(scene):
        collection = bpy.data.collections.new("furred")
        for name in ("fur", "Sphere"):
            owner = bpy.data.objects[name]
            scene.collection.objects.unlink(owner)
            collection.objects.link(owner)
        place = add("place", None)
        place.instance_type, place.instance_collection = "COLLECTION", collection
        moving(place)

    coverage(change)


def threads():
    return len(os.listdir("/proc/self/task")) if os.path.isdir("/proc/self/task") else 0


def test_a_cancelled_render_ends_soon_and_leaves_nothing_behind():
    from bl_ext.user_default.vellus_blender import engine

    scene = furry(200)
    render("before")
    kind, count = engine.VellusEngine, threads()
    usual = kind.is_cancelled
    scene.vellus.samples = 1 << 20
    for after in (0, 3, 6):
        asked = []

        def stop(self, after=after, asked=asked):
            asked.append(True)
            return len(asked) > after

        kind.is_cancelled = stop
        try:
            # It would take hours if it did not stop.
            bpy.ops.render.render()
        except RuntimeError as error:
            raise AssertionError(f"a cancelled render is no error: {error}") from error
        finally:
            kind.is_cancelled = usual
        assert len(asked) <= after + 3, "it goes on after a cancel"
    assert threads() <= count + 1, (threads(), count)
    scene.vellus.samples = 64
    assert np.isfinite(render("after")).all()


def test_a_stopped_picture_has_the_samples_taken_so_far():
    _, _, work = base.modules()
    import vellus

    scene = vellus.Scene()
    corners = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32)
    scene.add_mesh(corners, np.array([[0, 1, 2]]), surface=scene.add_surface())
    scene.add_light("dome", (1.0, 1.0, 1.0))
    matrix = np.eye(4)
    matrix[2, 3] = 3
    scene.set_camera(matrix, fov=45.0)
    options = {"samples": 1 << 20, "mode": "multiscale", "seed": 0}
    picture = work.run(scene, SIZE, (0, 0, *SIZE), [], options, lambda picture, done, text: False)
    assert np.isfinite(picture["beauty"]).all() and picture["beauty"].mean() > 0


def test_colours_are_those_of_cycles_on_a_strand_and_on_a_ball():
    def strand():
        scene = furry(1)
        bpy.data.objects.remove(bpy.data.objects["Sphere"])
        curves = bpy.data.objects["fur"].data
        x = np.linspace(-2.5, 2.5, 6, dtype=np.float32)
        curves.position_data.foreach_set("vector", np.stack([x, 0 * x, 0 * x + 0.3], 1).ravel())
        curves.attributes["radius"].data.foreach_set("value", np.full(6, 0.25, np.float32))
        return scene

    def ball():
        # Where thick strands overlap at the roots, Cycles' fur is darker. Half as thick, they hardly touch.
        scene = furry(1500)
        radii = bpy.data.objects["fur"].data.attributes["radius"].data
        radii.foreach_set("value", np.full(len(radii), 0.006, np.float32))
        return scene

    for make in (strand, ball):
        for melanin in (0.2, 0.6):
            scene = make()
            scene.render.film_transparent = True
            scene.vellus.samples = 128
            node = base.modules()[1].surface_node(bpy.data.objects["fur"].data.materials[0])
            node.parametrization = "MELANIN"
            node.inputs["Melanin"].default_value = melanin
            for name in ("Random Color", "Random Roughness"):
                node.inputs[name].default_value = 0
            ours, cycles = render("ours"), with_cycles("cycles", 128)
            ratio = ours[..., :3].mean((0, 1)) / cycles[..., :3].mean((0, 1))
            print(make.__name__, "melanin", melanin, "engine over Cycles:", ratio.round(4).tolist())
            # 2.7 % was measured for the strand and 1.5 % for the ball. The rest is room for noise.
            limit = 0.02 if make is ball else 0.03
            assert np.all(np.abs(ratio - 1) < limit), ratio


def test_a_mesh_with_a_principled_bsdf_has_the_colour_of_cycles():
    # The coat of the engine has Schlick's reflectance and scatters once. Cycles' has the exact one and scatters often.
    # So dark surfaces under a strong coat differ most.
    cases = [
        ({"Base Color": (0.8, 0.8, 0.8, 1)}, 0.03),
        ({"Base Color": (1, 1, 1, 1), "Roughness": 0.3, "IOR": 2.0}, 0.02),
        ({"Base Color": (0.6, 0.3, 0.1, 1), "Roughness": 0.8, "Specular IOR Level": 0.0}, 0.01),
        ({"Base Color": (0.6, 0.3, 0.1, 1), "Roughness": 0.5, "Specular IOR Level": 1.0}, 0.06),
        ({"Base Color": (0.9, 0.6, 0.3, 1), "Roughness": 0.4, "Metallic": 1.0}, 0.06),
    ]
    for inputs, limit in cases:
        scene = furry(1)
        bpy.data.objects.remove(bpy.data.objects["fur"])
        scene.render.film_transparent = True
        scene.vellus.samples = 256
        node = base.modules()[1].surface_node(bpy.data.objects["Sphere"].data.materials[0])
        for name, value in inputs.items():
            node.inputs[name].default_value = value
        ours, cycles = render("ours"), with_cycles("cycles", 256)
        ratio = ours[..., :3].mean((0, 1)) / cycles[..., :3].mean((0, 1))
        print("mesh", inputs, "engine over Cycles:", ratio.round(4).tolist())
        assert np.all(np.abs(ratio - 1) < limit), ratio


def bad_curves(strands, radius=0.05):
    """A furry scene whose curves are replaced."""
    scene = furry(20)
    data = bpy.data.hair_curves.new("bad")
    if strands:
        data.add_curves([len(s) for s in strands])
        data.position_data.foreach_set("vector", np.concatenate(strands).astype(np.float32).ravel())
        values = np.full(sum(map(len, strands)), radius, np.float32)
        data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", values)
    add("bad", data)
    scene.vellus.samples = 2
    return scene


def said():
    from bl_ext.user_default.vellus_blender import engine

    return sorted(engine.SAID)


def test_bad_curves_lights_and_places_render_with_a_warning_at_most():
    good = [[0, 0, 1.2], [0.5, 0, 1.5]]
    cases = {
        "not a number": ([good, [[math.nan] * 3, [0, 0, 1]]], 0.05, "left out (1 of 2)"),
        "infinite": ([good, [[math.inf, 0, 0], [0, 0, 1]]], 0.05, "left out (1 of 2)"),
        "no length": ([good, [[1, 1, 1]] * 3], 0.05, "left out (1 of 2)"),
        "one point": ([good, [[1, 1, 1]]], 0.05, "left out (1 of 2)"),
        "all bad": ([[[1, 1, 1]]], 0.05, "left out (1 of 1)"),
        "no strands": ([], 0.05, None),
        "no radius": ([good], 0.0, None),
        "radius not a number": ([good], math.nan, "left out (1 of 1)"),
    }
    for name, (strands, radius, text) in cases.items():
        bad_curves(strands, radius)
        picture = render("bad")
        texts = [t for t in said() if "bad" in t]
        print(name, texts)
        assert np.isfinite(picture).all() and picture[..., :3].mean() > 0.01, name
        assert (len(texts) == 1 and text in texts[0]) if text else not texts, (name, texts)
    for energy in (math.nan, math.inf, -1.0):
        scene = furry(20)
        scene.vellus.samples = 2
        bpy.data.lights["key"].energy = energy
        picture = render("bad")
        texts = [t for t in said() if "key" in t]
        print("energy", energy, "->", bpy.data.lights["key"].energy, texts)
        assert np.isfinite(picture).all(), energy
        assert len(texts) == 1, (energy, texts)
    scene = furry(20)
    scene.vellus.samples = 2
    sphere = bpy.data.objects["Sphere"]
    sphere.location = (math.nan, 0, 0)
    assert np.isfinite(render("bad")).all()
    assert len([t for t in said() if "Sphere" in t]) == 1, said()
    # Blender makes an infinite place a large finite one.
    sphere.location = (math.inf, 0, 0)
    try:
        render("bad")
    except RuntimeError as error:
        assert "Sphere" in str(error) and "1e9" in str(error), error
    else:
        raise AssertionError("no error for an infinite place")


def test_images_for_curves_without_uv_are_read_at_one_place():
    scene = furry(50)
    _, hook, _ = base.modules()
    material = bpy.data.objects["fur"].data.materials[0]
    image = bpy.data.images.new("red", 4, 4)
    image.pixels.foreach_set(np.tile(np.array([0.8, 0.1, 0.1, 1], np.float32), 16))
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    material.node_tree.links.new(texture.outputs[0], hook.surface_node(material).inputs["Color"])
    scene.vellus.samples = 4
    assert np.isfinite(render("no-uv")).all()
    print("without uv:", said())


def main():
    base.install()
    for name, test in list(globals().items()):
        if name.startswith("test_"):
            test()
            print(f"passed: {name}", flush=True)


if __name__ == "__main__":
    main()
