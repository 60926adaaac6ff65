"""Writes blender_5_2.usda with Blender 5.2 as a module.

Needs: pip install bpy==5.2.3 (Python 3.13).
"""

import math
import pathlib

import bpy
import numpy

bpy.ops.wm.read_factory_settings(use_empty=True)
collection = bpy.context.collection


def add(name, data, location=(0, 0, 3)):
    thing = bpy.data.objects.new(name, data)
    thing.location = location
    collection.objects.link(thing)
    return thing


def light(name, kind, **settings):
    data = bpy.data.lights.new(name, kind)
    for key, value in settings.items():
        setattr(data, key, value)
    return add(name, data)


light("Point", "POINT", energy=500)
light("Bulb", "POINT", energy=500, shadow_soft_size=0.3)
light("Spot", "SPOT", energy=500, spot_size=math.radians(40), spot_blend=0.3)
light("Area", "AREA", energy=500, shape="DISK", size=0.5)
light("Sun", "SUN", energy=5)
bpy.context.scene.camera = add("Camera", bpy.data.cameras.new("Camera"), (0, 0, 8))

# Hair curves with a Principled Hair shader, which the export leaves empty.
material = bpy.data.materials.new("Hair")
tree = material.node_tree
tree.nodes.clear()
shader = tree.nodes.new("ShaderNodeBsdfHairPrincipled")
tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs[0])
curves = bpy.data.hair_curves.new("Curves")
add("Curves", curves, (0, 0, 0))
curves.add_curves([3] * 4)
points = [[i, 0, 0.5 * k] for i in range(4) for k in range(3)]
curves.attributes["position"].data.foreach_set("vector", numpy.array(points, "f").ravel())
radius = curves.attributes.get("radius") or curves.attributes.new("radius", "FLOAT", "POINT")
radius.data.foreach_set("value", numpy.full(12, 0.02, "f"))
curves.materials.append(material)

# Particle hair, which the export leaves without widths.
bpy.ops.mesh.primitive_plane_add()
plane = bpy.context.object
plane.modifiers.new("Particles", "PARTICLE_SYSTEM")
settings = plane.particle_systems[0].settings
settings.type, settings.count, settings.hair_length, settings.display_step = "HAIR", 10, 0.5, 2

path = pathlib.Path(__file__).with_name("blender_5_2.usda")
bpy.ops.wm.usd_export(filepath=str(path), export_hair=True)
