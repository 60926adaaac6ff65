"""Tests of the extension's extraction. Run with a Python that has bpy: test_extract.py. It needs no wheel."""

import importlib.util
import math
import sys
import types
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).parent


def load(name, path, package=None):
    """Loads a file as a module of the package, without its `__init__`, which needs the wheel."""
    places = [str(package)] if package else None
    spec = importlib.util.spec_from_file_location(name, path, submodule_search_locations=places)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


root = types.ModuleType("vellus_blender")
root.__path__ = [str(HERE / "vellus_blender")]
sys.modules["vellus_blender"] = root
root.hook = load("vellus_blender.hook", HERE / "vellus_usd_hook.py")
FOLDER = HERE / "vellus_blender/extract"
extraction = load("vellus_blender.extract", FOLDER / "__init__.py", FOLDER)


def add(name, data):
    """An object in the scene."""
    owner = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(owner)
    return owner


def hair(name, strands, radius=0.1):
    """Hair curves from lists of points."""
    data = bpy.data.hair_curves.new(name)
    data.add_curves([len(s) for s in strands])
    points = np.concatenate([np.array(s, np.float32) for s in strands])
    data.position_data.foreach_set("vector", points.ravel())
    values = np.full(len(points), radius, np.float32)
    data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", values)
    return add(name, data)


def empty():
    """An empty scene with a camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.camera = add("camera", bpy.data.cameras.new("camera"))
    scene.camera.location = (0, 0, 5)
    return scene


def read(**options):
    """The description of the current scene."""
    return extraction.extract(bpy.context.evaluated_depsgraph_get(), width=200, height=100, **options)


def test_curves_are_pinned_scaled_and_keep_their_attributes():
    empty()
    owner = hair("fur", [[(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 0), (0, 2, 0)], [(5, 5, 5), (5, 5, 5)]])
    owner.scale, owner.location = (2, 2, 2), (0, 0, 1)
    kappa = owner.data.attributes.new("vellus:kappa", "FLOAT", "CURVE")
    kappa.data.foreach_set("value", np.array([0.1, 0.2, 0.3], np.float32))
    found = read()
    (strands,) = found.strands
    assert list(strands["counts"]) == [5, 4]
    # Catmull-Rom: a mirrored point before the first one and after the last one.
    assert np.allclose(strands["points"][:5], [[x, 0, 1] for x in (-2, 0, 2, 4, 6)])
    assert np.allclose(strands["radii"], 0.2)
    domain, values = strands["attributes"]["vellus:kappa"]
    assert domain == "CURVE" and np.allclose(values, [0.1, 0.2])
    assert sum("(1 of 3)" in text for text in found.warnings) == 1, found.warnings


def test_lights_have_the_units_of_cycles():
    empty()
    hair("fur", [[(0, 0, 0), (1, 0, 0)]])
    for kind, settings in (
        ("POINT", {"shadow_soft_size": 0.0}),
        ("SUN", {"angle": 0.5}),
        ("AREA", {"size": 2.0}),
        ("SPOT", {"shadow_soft_size": 0.5, "spot_size": 1.0}),
    ):
        light = bpy.data.lights.new(kind, kind)
        light.energy = 100
        for name, value in settings.items():
            setattr(light, name, value)
        add(kind, light)
    lights = {light["group"]: light for light in read().lights}
    # Each was compared with a diffuse plane in Cycles.
    assert np.allclose(lights["POINT"]["intensity"], 100 / (4 * math.pi))
    assert np.allclose(lights["SUN"]["irradiance"], 100)
    assert np.allclose(lights["AREA"]["radiance"], 100 / (4 * math.pi))
    assert np.allclose(lights["SPOT"]["radiance"], 100 / (4 * math.pi) / (math.pi * 0.25))
    assert np.allclose(lights["SPOT"]["shaping"]["axis"], (0, 0, -1))


def test_instances_share_and_mirrored_meshes_keep_their_outside():
    empty()
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    cube.scale = (-1, 1, 1)
    collection = bpy.data.collections.new("shared")
    fur = hair("fur", [[(0, 0, 0), (1, 0, 0)]])
    bpy.context.scene.collection.objects.unlink(fur)
    collection.objects.link(fur)
    for i in range(3):
        place = add(f"place{i}", None)
        place.instance_type, place.instance_collection, place.location = "COLLECTION", collection, (i, 0, 0)
    found = read()
    assert (len(found.prototypes), len(found.instances), len(found.strands)) == (1, 3, 0)
    (mesh,) = found.meshes
    a, b, c = (mesh["points"][mesh["triangles"][:, i]] for i in range(3))
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), mesh["normals"][:, 0]) > 0).all()


def test_particle_hair_has_children_radii_and_uv():
    empty()
    bpy.ops.mesh.primitive_plane_add()
    bpy.ops.object.particle_system_add()
    settings = bpy.context.object.particle_systems[0].settings
    settings.type, settings.count, settings.child_type, settings.rendered_child_count = "HAIR", 10, "SIMPLE", 4
    settings.child_percent = 4
    (strands,) = read(is_render=False).strands
    assert len(strands["counts"]) == 40 and strands["uv"].shape == (40, 2)
    assert abs(strands["radii"][1] - 0.005) < 1e-6


def hair_with_nodes():
    """One strand with a Principled Hair of the model Huang, whose node is returned with its tree."""
    empty()
    owner = hair("fur", [[(0, 0, 0), (1, 0, 0)]])
    material = bpy.data.materials.new("flat")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfHairPrincipled", "OutputMaterial"))
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    node.model = "HUANG"
    owner.data.materials.append(material)
    return node, tree


def test_the_aspect_ratio_of_huang_is_that_of_the_fibre():
    node, tree = hair_with_nodes()
    number = tree.nodes.new("ShaderNodeValue")
    warnings = "\n".join(read().warnings)
    assert "Huang" in warnings and "aspect" not in warnings, warnings
    # Blender's default, a value, one above 1, where Cycles exchanges the axes, and two that are too flat for Vellus.
    expected = ((None, 0.85, ""), (0.625, 0.625, ""), (1.6, 0.625, ""))
    expected += ((0.25, 0.4, "Aspect Ratio 0.25 is flatter than 0.4"), (3.0, 0.4, "Aspect Ratio 3 is flatter than 0.4"))
    for value, ratio, warning in expected:
        if value is not None:
            number.outputs[0].default_value = value
            tree.links.new(number.outputs[0], node.inputs["Aspect Ratio"])
        found = read()
        (look,) = found.looks.values()
        assert np.isclose(look["values"]["aspect_ratio"], ratio), (value, look["values"])
        assert ("flatter" in "".join(found.warnings)) == bool(warning) and warning in "".join(found.warnings), value
    # The model Chiang has round fibres.
    node.model = "CHIANG"
    (look,) = read().looks.values()
    assert "aspect_ratio" not in look["values"]


def test_absorption_of_flat_hair_is_per_radius_of_the_circle_of_the_same_area():
    node, tree = hair_with_nodes()
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("color", 4, 4, float_buffer=True)
    texture.image.pixels.foreach_set(np.full(64, 0.5, np.float32))
    inputs = (
        ("ABSORPTION", {"Absorption Coefficient": (0.1, 0.2, 0.4)}),
        ("COLOR", {"Color": (0.9, 0.6, 0.4, 1)}),
        ("MELANIN", {"Melanin": 0.3, "Tint": (0.9, 0.6, 0.4, 1)}),
    )
    for kind, values in inputs:
        node.parametrization = kind
        for name, value in values.items():
            node.inputs[name].default_value = value
        found = []
        for ratio in (1.0, 0.64):
            node.inputs["Aspect Ratio"].default_value = ratio
            (look,) = read().looks.values()
            found.append([look["values"]["sigma_ca"]])
            if look["melanin"]:
                found[-1].append(look["melanin"][1])
            else:
                link = tree.links.new(texture.outputs[0], node.inputs[name])
                (look,) = read().looks.values()
                found[-1].append(look["images"]["sigma_ca"])
                tree.links.remove(link)
        for round_, flat in zip(*found):
            assert np.min(round_) > 0 and np.allclose(flat, 0.8 * np.array(round_)), kind


def test_normals_of_flat_hair_are_its_shorter_axes():
    node, _ = hair_with_nodes()
    owner = bpy.data.objects["fur"]
    node.inputs["Aspect Ratio"].default_value = 0.6
    # A scale that is not uniform: normals stay perpendicular to the strand and to Blender's normals.
    owner.scale, owner.rotation_euler = (1, 3, 2), (0, 0, 0.5)
    data = owner.data
    points = np.array([(0, 0, 0), (1, 0, 0), (2, 0.5, 0)], np.float32)
    data.resize_curves([3])
    data.position_data.foreach_set("vector", points.ravel())
    free = 2
    data.attributes.new("normal_mode", "INT8", "CURVE").data.foreach_set("value", np.array([free], np.int8))
    custom = data.attributes.new("custom_normal", "FLOAT_VECTOR", "POINT").data
    longer = np.tile(np.array([0, 0.6, 0.8], np.float32), (3, 1))
    custom.foreach_set("vector", longer.ravel())
    for side, away in (("left", -0.1), ("right", 0.1)):
        handles = (points + np.array([away, 0, 0], np.float32)).ravel()
        data.attributes.new(f"handle_{side}", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", handles)
    parts = (("CATMULL_ROM", 5, slice(1, 4)), ("POLY", 3, slice(0, 3)), ("BEZIER", 7, slice(0, 7, 3)))
    for kind, count, of_points in parts:
        data.set_types(type=kind)
        (strands,) = read().strands
        normals = strands["normals"]
        assert normals.shape == (count, 3) and np.allclose(np.linalg.norm(normals, axis=1), 1)
        along = points[[1, 2, 2]] - points[[0, 0, 1]]
        for vectors in (along, longer):
            moved = vectors @ np.array(owner.matrix_world)[:3, :3].T
            assert np.abs((moved * normals[of_points]).sum(1)).max() < 1e-5, kind
    # Round hair needs none.
    node.inputs["Aspect Ratio"].default_value = 1.0
    (strands,) = read().strands
    assert strands["normals"] is None


def test_scenes_without_a_camera_or_without_anything_have_one_message():
    for remove_camera, word in ((True, "no camera"), (False, "nothing to render")):
        scene = empty()
        if remove_camera:
            hair("fur", [[(0, 0, 0), (1, 0, 0)]])
            scene.camera = None
        try:
            read()
        except extraction.Problem as problem:
            assert word in str(problem), problem
        else:
            raise AssertionError(word)


if __name__ == "__main__":
    for name, test in list(globals().items()):
        if name.startswith("test_"):
            test()
            print(f"passed {name}")
