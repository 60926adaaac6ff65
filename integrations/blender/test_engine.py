"""Tests of the render engine. Run with a Python that has bpy: test_engine.py EXTENSION.zip [VELLUS]

It installs the extension as a user would, renders with it, and compares the picture with that of `vellus render` for
the exported USD if the command VELLUS is given.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

FOLDER = Path(tempfile.mkdtemp())
os.environ["BLENDER_USER_RESOURCES"] = str(FOLDER / "user")

import bpy  # noqa: E402

# A module of bpy.
import addon_utils  # noqa: E402

EXTENSION, *VELLUS = sys.argv[1:]
SIZE = (96, 72)


def install():
    addon_utils.enable("bl_pkg", default_set=True)
    bpy.ops.extensions.package_install_files(filepath=EXTENSION, repo="user_default", enable_on_install=True)
    assert "bl_ext.user_default.vellus_blender" in bpy.context.preferences.addons
    names = [getattr(engine, "bl_idname", "") for engine in bpy.types.RenderEngine.__subclasses__()]
    assert "VELLUS" in names, names


def add(name, data):
    owner = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(owner)
    return owner


def hair_material(color):
    material = bpy.data.materials.new("hair")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeBsdfHairPrincipled")
    node.model, node.parametrization = "CHIANG", "COLOR"
    node.inputs["Color"].default_value = (*color, 1)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], output.inputs[0])
    return material


def furry(strands=1500):
    """A ball of hair curves with a skin, a lamp, a sky and a camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("bl_ext.user_default.vellus_blender")
    scene = bpy.context.scene
    random = np.random.default_rng(1)
    away = random.normal(size=(strands, 3))
    away /= np.linalg.norm(away, axis=1)[:, None]
    t = np.linspace(0, 1, 6)[None, :, None]
    points = away[:, None] * (0.7 + 0.35 * t) + np.array([0, 0, -0.12]) * t**2
    curves = bpy.data.hair_curves.new("fur")
    curves.add_curves([6] * strands)
    curves.position_data.foreach_set("vector", points.astype(np.float32).ravel())
    radii = np.full(6 * strands, 0.012, np.float32)
    curves.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", radii)
    curves.materials.append(hair_material((0.6, 0.3, 0.1)))
    add("fur", curves)
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.7)
    # A mesh without a material is white in Blender, and grey in USD.
    skin = bpy.data.materials.new("skin")
    if skin.node_tree is None:
        skin.use_nodes = True
    bpy.context.object.data.materials.append(skin)
    lamp = bpy.data.lights.new("key", "POINT")
    lamp.energy, lamp.shadow_soft_size = 400, 0.5
    add("key", lamp).location = (3, -3, 4)
    scene.world = bpy.data.worlds.new("sky")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.22, 0.24, 1)
    scene.camera = add("camera", bpy.data.cameras.new("camera"))
    scene.camera.location, scene.camera.rotation_euler = (0, -5, 0.6), (1.45, 0, 0)
    render = scene.render
    render.engine = "VELLUS"
    render.resolution_x, render.resolution_y, render.resolution_percentage = *SIZE, 100
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.vellus.samples = 64
    return scene


def render(name):
    """Renders to a file and returns its pixels, the top row first."""
    scene = bpy.context.scene
    scene.render.filepath = str(FOLDER / name)
    assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
    return read(FOLDER / f"{name}.exr")


def read(path):
    image = bpy.data.images.load(str(path))
    width, height = image.size
    values = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(height, width, image.channels)[::-1]


def test_the_picture_is_that_of_the_exported_file():
    furry()
    ours = render("engine")
    assert ours.shape[:2] == SIZE[::-1] and np.isfinite(ours).all() and ours[..., :3].mean() > 0.01
    assert (ours[..., 3] == 1).all()
    if not VELLUS:
        print("skipped: no command vellus to compare with")
        return
    bpy.ops.wm.usd_export(filepath=str(FOLDER / "fur.usda"))
    size = "{}x{}".format(*SIZE)
    command = [
        VELLUS[0],
        "render",
        FOLDER / "fur.usda",
        "--size",
        size,
        "--spp",
        "64",
        "--layers",
        "beauty,alpha",
        "-o",
        FOLDER / "usd.exr",
    ]
    subprocess.run(command, check=True, capture_output=True)
    theirs = read(FOLDER / "usd.exr")
    ratio = ours[..., :3].mean((0, 1)) / theirs[..., :3].mean((0, 1))
    print("engine over vellus render:", ratio)
    assert np.all(np.abs(ratio - 1) < 0.01)


def test_transparent_film_and_border():
    scene = furry(300)
    scene.vellus.samples = 4
    scene.render.film_transparent = True
    picture = render("transparent")
    assert picture[0, 0, 3] == 0 and picture[SIZE[1] // 2, SIZE[0] // 2, 3] == 1
    scene.render.use_border, scene.render.use_crop_to_border = True, True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
    scene.render.border_min_y, scene.render.border_max_y = 0.5, 1.0
    part = render("border")
    assert part.shape[:2] == (SIZE[1] // 2, SIZE[0] // 2)
    assert np.allclose(part, picture[: SIZE[1] // 2, SIZE[0] // 4 : 3 * SIZE[0] // 4], atol=1e-6)


def test_passes_are_in_the_file():
    scene = furry(200)
    scene.vellus.samples = 2
    layer = scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_cryptomatte_object = True
    layer.vellus.use_pass_albedo = layer.vellus.use_pass_lobes = True
    layer.lightgroups.add(name="warm")
    bpy.data.objects["key"].lightgroup = "warm"
    # Blender 5 writes several layers as one of its kinds of files.
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.render.filepath = str(FOLDER / "passes.exr")
    assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
    header = (FOLDER / "passes.exr").read_bytes()[:20_000]
    for name in (b"Depth.", b"Normal.", b"Albedo.", b"Lobe TTs.", b"Combined_warm.", b"CryptoObject00."):
        assert name in header, name
    for text in (b"ViewLayer.CryptoObject", b"MurmurHash3_32", b'{"Sphere": "', b'"fur": "'):
        assert text in header, text


def modules():
    """The modules of the installed extension."""
    from bl_ext.user_default.vellus_blender import group, hook, render

    return group, hook, render


def test_the_camera_of_a_view_is_that_of_its_matrices():
    from bl_ext.user_default.vellus_blender import viewport
    from bl_ext.user_default.vellus_blender.extract.camera import read_camera

    scene = furry(20)
    owner, data = scene.camera, scene.camera.data
    data.shift_x, data.shift_y, data.lens = 0.1, -0.2, 35
    bpy.context.view_layer.update()
    projection = owner.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=SIZE[0], y=SIZE[1])
    view, camera = viewport.camera_of_view(owner.matrix_world.inverted(), projection), read_camera(owner, *SIZE, print)
    for key in ("matrix", "film_height", "shift"):
        assert np.allclose(view[key], camera[key], atol=1e-5), (key, view[key], camera[key])


def test_the_shift_of_the_camera_moves_the_picture():
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    scene = furry(100)
    scene.vellus.samples, scene.render.film_transparent = 16, True
    bpy.context.view_layer.update()
    camera = scene.camera.data
    for fit, shift in (("AUTO", (0.125, -0.0625)), ("VERTICAL", (-0.125, 1 / 18))):
        camera.sensor_fit, camera.shift_x, camera.shift_y = fit, 0, 0
        place, before = world_to_camera_view(scene, scene.camera, Vector()), render("unshifted")
        camera.shift_x, camera.shift_y = shift
        moved, after = world_to_camera_view(scene, scene.camera, Vector()), render("shifted")
        right, down = (moved - place).x * SIZE[0], (place - moved).y * SIZE[1]
        # The shifts are whole pixels, and the ball stays inside the picture.
        expected = np.roll(before[..., 3], (round(down), round(right)), (0, 1))
        assert abs(right - round(right)) < 1e-3 and abs(down - round(down)) < 1e-3, (right, down)
        # A pixel has 16 samples of another sequence. Only those at the edge of the fur differ.
        assert np.abs(after[..., 3] - expected).mean() < 0.02
        assert abs(after[..., 3].mean() / before[..., 3].mean() - 1) < 0.02


def fur_of_the_node_group():
    """A scene whose fur has the node group Vellus Fur, and the modules."""
    _, hook, render_module = modules()
    scene = furry(20)
    owner = bpy.data.objects["fur"]
    scene.view_layers[0].objects.active = owner
    owner.data.materials.clear()
    assert bpy.ops.vellus.use_fur() == {"FINISHED"}
    return owner, hook, render_module


def test_presets_of_the_node_group_are_those_of_vellus():
    import vellus

    owner, hook, render_module = fur_of_the_node_group()
    assert bpy.ops.vellus.use_fur() == {"FINISHED"}
    (material,) = owner.data.materials
    assert len([node for node in material.node_tree.nodes if hook.is_fur(node)]) == 1
    for preset in vellus.species():
        assert bpy.ops.vellus.preset(name=preset) == {"FINISHED"}
        values = dict(hook.look_of(material).values)
        ours, theirs = render_module.fiber_of(values).to_dict(), vellus.Fiber(preset).to_dict()
        assert ours.keys() == theirs.keys()
        for name in ours:
            if isinstance(ours[name], str):
                assert ours[name] == theirs[name], (preset, name)
            elif name != "medulla_pigment":
                # Sockets are single precision.
                assert np.allclose(ours[name], theirs[name], rtol=1e-6), (preset, name)
    # The colour of the coat replaces the absorption.
    node = hook.surface_node(material)
    node.inputs["Use Color"].default_value = True
    node.inputs["Color"].default_value = (0.4, 0.2, 0.1, 1)
    fiber = render_module.fiber_of(hook.look_of(material).values)
    assert np.allclose(fiber.coat_color(), (0.4, 0.2, 0.1), rtol=0.02)
    assert render("fur")[..., :3].mean() > 0.01


def test_the_aspect_ratio_is_one_number_for_a_look():
    owner, hook, render_module = fur_of_the_node_group()
    (material,) = owner.data.materials
    node = hook.surface_node(material)
    node.inputs["Aspect Ratio"].default_value = 0.6
    look = hook.look_of(material)
    assert np.isclose(render_module.fiber_of(look.values).aspect_ratio, 0.6) and not look.warnings
    # Neither an attribute that the material reads nor one of the strands changes it.
    attribute = material.node_tree.nodes.new("ShaderNodeAttribute")
    attribute.attribute_name = "flatness"
    material.node_tree.links.new(attribute.outputs["Fac"], node.inputs["Aspect Ratio"])
    look = hook.look_of(material)
    assert not look.attributes and "only its constant is used" in " ".join(look.warnings), look.warnings
    values, found = np.full(20, 0.5, np.float32), []
    part = {"name": "fur", "counts": np.full(20, 6), "attributes": {"vellus:aspect_ratio": ("CURVE", values)}}
    nothing = {"random": (0, 0), "attributes": {}}
    assert render_module.parameters_of(part, nothing, found.append) == {}
    assert found == ["fur: vellus:aspect_ratio cannot vary between strands, and is ignored"]
    assert render("flat")[..., :3].mean() > 0.01


def test_normals_turn_flat_hair_and_no_other():
    _, hook, _ = modules()
    pictures = {}
    for ratio, name in ((0.5, "one"), (0.5, "other"), (1.0, "one"), (1.0, "other")):
        furry(200)
        data = bpy.data.objects["fur"].data
        points = np.empty((200, 6, 3), np.float32)
        data.position_data.foreach_get("vector", points.ravel())
        along = np.repeat(points[:, 1] - points[:, 0], 6, 0)
        normals = np.cross(along, (0, 0, 1))
        normals = normals if name == "one" else np.cross(along, normals)
        normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)
        free = np.full(200, 2, np.int8)
        data.attributes.new("normal_mode", "INT8", "CURVE").data.foreach_set("value", free)
        data.attributes.new("custom_normal", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", normals.ravel())
        node = hook.surface_node(data.materials[0])
        node.model = "HUANG"
        node.inputs["Aspect Ratio"].default_value = ratio
        pictures[ratio, name] = render(f"turned-{name}-{ratio}")
    assert np.array_equal(pictures[1.0, "one"], pictures[1.0, "other"])
    # Turning changes about as much as flatness itself.
    turned, flat = (np.abs(pictures[0.5, "one"] - pictures[key]).mean() for key in ((0.5, "other"), (1.0, "one")))
    assert turned > 0.5 * flat > 0


def test_absorption_of_flat_hair_in_attributes_is_converted():
    _, hook, render_module = modules()
    values = np.full((2, 3), 0.4, np.float32)
    part = {"name": "fur", "counts": np.full(2, 6), "attributes": {"a": ("CURVE", values)}}

    def read(parameter, factor):
        look = {"random": (0, 0), "attributes": {"a": parameter}, "absorption_factor": factor}
        return render_module.parameters_of(part, look, print)[parameter]

    assert np.allclose(read("sigma_ca", 0.8), 0.32)
    of_color = [hook.absorption_of_color(read("hair_reflectance", factor)[0], 0.3) for factor in (1.0, 0.8)]
    assert np.allclose(of_color[1], 0.8 * np.array(of_color[0]))


def test_a_missing_image_is_a_warning():
    _, hook, _ = modules()
    furry(20)
    material = bpy.data.objects["fur"].data.materials[0]
    image = bpy.data.images.new("lost", 4, 4)
    image.source, image.filepath = "FILE", "//nowhere/lost.png"
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    material.node_tree.links.new(texture.outputs[0], hook.surface_node(material).inputs["Color"])
    assert render("lost")[..., :3].mean() > 0.01


def test_problems_are_reported():
    for change, text in (
        (lambda scene: setattr(scene, "camera", None), "camera"),
        (lambda scene: [bpy.data.objects.remove(o) for o in list(scene.objects) if o.type != "CAMERA"], "nothing"),
    ):
        scene = furry(20)
        change(scene)
        scene.render.filepath = str(FOLDER / "bad")
        try:
            bpy.ops.render.render(write_still=True)
        except RuntimeError as error:
            assert text in str(error).lower(), error
        else:
            raise AssertionError(f"no error for {text}")


def main():
    install()
    for name, test in list(globals().items()):
        if name.startswith("test_"):
            test()
            print(f"passed: {name}")


if __name__ == "__main__":
    main()
