"""What the scenes of Cycles share: looks, hair, settings, rendering. For the bpy wheel."""

import os

import bpy
import numpy as np

import scene
import worker


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


def hair(absorption):
    """Principled Hair with the model of Chiang et al."""
    look, node = material("hair", "ShaderNodeBsdfHairPrincipled")
    node.model, node.parametrization = "CHIANG", "ABSORPTION"
    inputs = {"Absorption Coefficient": absorption, "Roughness": scene.ROUGHNESS, "IOR": scene.IOR}
    inputs |= {"Radial Roughness": scene.ROUGHNESS, "Offset": np.radians(scene.TILT)}
    inputs |= {"Random Roughness": 0.0, "Coat": 0.0}
    for key, value in inputs.items():
        node.inputs[key].default_value = value
    return look


def curves(name, counts, points, radii):
    """Catmull-Rom splines."""
    made = bpy.data.hair_curves.new(name)
    made.add_curves([int(count) for count in counts])
    made.attributes["position"].data.foreach_set("vector", np.ascontiguousarray(points, np.float32).ravel())
    radius = made.attributes.get("radius") or made.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.ascontiguousarray(radii, np.float32))
    return made


def knots(values):
    """Where the segments of uniform cubic B-splines end: points of Catmull-Rom splines that are nearly the same.

    A B-spline passes near its control points only. The first axis counts control points.
    """
    return (values[:-2] + 4 * values[1:-1] + values[2:]) / 6


def sky():
    """The background of a new world, and its nodes."""
    world = bpy.data.worlds.new("sky")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes = world.node_tree.nodes
    return nodes.get("Background") or nodes.new("ShaderNodeBackground"), world.node_tree


def settings(bounces):
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
        setattr(cycles, f"{kind}_bounces", bounces)
    cycles.min_light_bounces = cycles.min_transparent_bounces = scene.ROULETTE - 1
    # Filter Glossy is off too.
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0


class Sampling:
    """Notices when Cycles has built the scene and begins to sample."""

    def __init__(self):
        self.clock = self.built = None
        bpy.app.handlers.render_stats.append(self)

    def __call__(self, status, *_):
        if self.built is None and "Sample 0/" in status:
            self.built = self.clock.seconds()

    def start(self):
        self.clock, self.built = worker.Clock(), None


def render(sampling, spp, seed, size, path):
    """Processor seconds for building the scene, which each render does again, and for sampling."""
    made = bpy.context.scene
    made.cycles.samples, made.cycles.seed = spp, seed
    made.render.resolution_x, made.render.resolution_y = size
    sampling.start()
    bpy.ops.render.render(write_still=False)
    spent = sampling.clock.seconds()
    if path:
        bpy.data.images["Render Result"].save_render(path.replace(".npy", ".exr"))
        image = bpy.data.images.load(path.replace(".npy", ".exr"))
        pixels = np.empty(size[0] * size[1] * 4, np.float32)
        image.pixels.foreach_get(pixels)
        np.save(path, pixels.reshape(size[1], size[0], 4)[::-1, :, :3])
        bpy.data.images.remove(image)
        os.remove(path.replace(".npy", ".exr"))
    return sampling.built, spent - sampling.built


def serve(answer, size, see=lambda view: None):
    """Renders for each request. `see` changes the camera to a view."""
    sampling = Sampling()
    load, _ = render(sampling, 1, 0, size, "")
    worker.answer(answer, load=load, memory=worker.memory())
    for request in worker.requests():
        see(request["view"])
        _, spent = render(sampling, request["spp"], request["seed"], request["size"], request["path"])
        worker.answer(answer, cpu=spent, memory=worker.memory())
