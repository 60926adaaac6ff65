"""Blender Cycles from the bpy wheel as a long-running process, like mitsuba_worker.py.

usage: cycles_worker.py SCENES BALL
"""

import os
import sys

import worker

ANSWER = worker.begin()

import bpy
import mathutils
import numpy as np

import scene

folder, ball = sys.argv[1], sys.argv[2]


def material(name, kind, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node = tree.nodes.new(kind)
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ")].default_value = value
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made, node


def add(name, data, look=None):
    if look:
        data.materials.append(look)
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


def fur():
    data = np.load(f"{folder}/{ball}.npz")
    # Blender's curves are Catmull-Rom splines through their points. A B-spline passes near its control points, so
    # take the points of the B-spline at the ends of its segments.
    p = data["points"]
    points = ((p[:, :-2] + 4 * p[:, 1:-1] + p[:, 2:]) / 6).astype(np.float32)
    r = data["radii"]
    radii = ((r[:-2] + 4 * r[1:-1] + r[2:]) / 6).astype(np.float32)
    curves = bpy.data.hair_curves.new("fur")
    curves.add_curves([points.shape[1]] * len(points))
    curves.attributes["position"].data.foreach_set("vector", points.ravel())
    radius = curves.attributes.get("radius") or curves.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.tile(radii, len(points)))
    hair, node = material("hair", "ShaderNodeBsdfHairPrincipled")
    node.model, node.parametrization = "CHIANG", "ABSORPTION"
    inputs = {"Absorption Coefficient": scene.ABSORPTION[ball], "Roughness": scene.ROUGHNESS, "IOR": scene.IOR}
    inputs |= {"Radial Roughness": scene.ROUGHNESS, "Offset": np.radians(scene.TILT)}
    inputs |= {"Random Roughness": 0.0, "Coat": 0.0}
    for key, value in inputs.items():
        node.inputs[key].default_value = value
    add("fur", curves, hair)


def surroundings():
    data = np.load(f"{folder}/skin.npz")
    mesh = bpy.data.meshes.new("skin")
    mesh.from_pydata((data["vertices"] * scene.SKIN_RADIUS).tolist(), [], data["faces"].tolist())
    mesh.shade_smooth()
    add("skin", mesh, material("skin", "ShaderNodeBsdfDiffuse", Color=(*scene.SKIN_COLOR[ball], 1))[0])

    at = mathutils.Vector(scene.LIGHT_AT)
    turn = at.to_track_quat("Z", "Y")
    light = bpy.data.meshes.new("light")
    corners = [(-1, 1, 0), (1, 1, 0), (1, -1, 0), (-1, -1, 0)]
    light.from_pydata([at + turn @ mathutils.Vector(corner) for corner in corners], [], [(0, 1, 2, 3)])
    strength = max(scene.LIGHT_RADIANCE)
    color = (*(x / strength for x in scene.LIGHT_RADIANCE), 1)
    look, _ = material("light", "ShaderNodeEmission", Color=color, Strength=strength)
    look.cycles.emission_sampling = "FRONT"
    add("light", light, look)

    world = bpy.data.worlds.new("sky")
    bpy.context.scene.world = world
    world.use_nodes = True
    sky = world.node_tree.nodes.get("Background") or world.node_tree.nodes.new("ShaderNodeBackground")
    sky.inputs["Color"].default_value = (*scene.SKY, 1)

    camera = add("camera", bpy.data.cameras.new("camera"))
    camera.data.sensor_fit = "VERTICAL"
    camera.location = scene.EYE
    camera.rotation_mode = "QUATERNION"
    look = mathutils.Vector(scene.TARGET) - mathutils.Vector(scene.EYE)
    camera.rotation_quaternion = look.to_track_quat("-Z", "Y")
    bpy.context.scene.camera = camera


def settings():
    made = bpy.context.scene
    made.render.engine = "CYCLES"
    # With persistent data, repeated renders would keep the number of samples of the first one.
    made.render.use_persistent_data = False
    made.render.filter_size = 1.0
    made.render.image_settings.file_format = "OPEN_EXR"
    made.render.image_settings.color_depth = "32"
    made.cycles_curves.shape = "THICK"
    cycles = made.cycles
    cycles.device, cycles.pixel_filter_type = "CPU", "BOX"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    for kind in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
        setattr(cycles, f"{kind}_bounces", scene.BOUNCES[ball])
    cycles.min_light_bounces = cycles.min_transparent_bounces = scene.ROULETTE - 1
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0


def render(spp, seed, view, size, path):
    made = bpy.context.scene
    made.cycles.samples, made.cycles.seed = spp, seed
    made.render.resolution_x, made.render.resolution_y = size
    made.camera.data.angle = np.radians(scene.VIEWS[view])
    clock = worker.Clock()
    bpy.ops.render.render(write_still=False)
    spent = clock.seconds()
    if path:
        bpy.data.images["Render Result"].save_render(path.replace(".npy", ".exr"))
        image = bpy.data.images.load(path.replace(".npy", ".exr"))
        pixels = np.empty(size[0] * size[1] * 4, np.float32)
        image.pixels.foreach_get(pixels)
        np.save(path, pixels.reshape(size[1], size[0], 4)[::-1, :, :3])
        bpy.data.images.remove(image)
        os.remove(path.replace(".npy", ".exr"))
    return spent


bpy.ops.wm.read_factory_settings(use_empty=True)
fur()
surroundings()
settings()
# Every render builds the scene again. Subtract the time of a render with one sample.
build = render(1, 0, "close", scene.SIZE, "")
worker.answer(ANSWER, load=build, memory=worker.memory())
for request in worker.requests():
    spent = render(request["spp"], request["seed"], request["view"], request["size"], request["path"])
    worker.answer(ANSWER, cpu=spent, memory=worker.memory())
