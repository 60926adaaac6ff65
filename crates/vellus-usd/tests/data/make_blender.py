"""Writes blender_5_2.usda, and curves of each kind and particle hair in blender/, with Blender 5.2 as a module.

Needs: pip install bpy==5.2.3 (Python 3.13). The order of objects in blender_5_2.usda differs between runs.
"""

import math
import pathlib

import bpy
import numpy

STRANDS, POINTS = 24, 6
folder = pathlib.Path(__file__).parent
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

bpy.ops.wm.usd_export(filepath=str(folder / "blender_5_2.usda"), export_hair=True)


def fur(kind):
    """Strands all over a ball of radius 1. They lean toward +y, so the front is -y."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    curves = bpy.data.hair_curves.new("fur")
    curves.add_curves([POINTS] * STRANDS)
    strand, along = numpy.arange(STRANDS)[:, None], numpy.linspace(0, 1, POINTS)
    # Points of a Fibonacci lattice.
    z, angle = 1 - (2 * strand + 1) / STRANDS, strand * math.pi * (3 - math.sqrt(5))
    around = numpy.sqrt(1 - z * z)
    roots = numpy.concatenate([around * numpy.cos(angle), around * numpy.sin(angle), z], 1)
    points = roots[:, None] * (1 + 0.3 * along)[:, None] + (along**2)[:, None] * [0, 0.3, 0]

    def put(name, kind, domain, values):
        attribute = curves.attributes.get(name) or curves.attributes.new(name, kind, domain)
        key = "value" if kind == "FLOAT" else "vector"
        attribute.data.foreach_set(key, numpy.array(values, "f").ravel())

    put("position", "FLOAT_VECTOR", "POINT", points)
    put("radius", "FLOAT", "POINT", numpy.tile(0.004 * (1 - 0.3 * along), STRANDS))
    put("surface_uv_coordinate", "FLOAT2", "CURVE", numpy.concatenate([angle / 7 % 1, 0.5 + 0.5 * z], 1))
    put("melanin", "FLOAT", "CURVE", numpy.linspace(0, 1, STRANDS))
    if kind != "CATMULL_ROM":
        curves.set_types(type=kind)
    if kind == "BEZIER":
        # Without handles the export of Blender 5.2.3 crashes.
        tangents = numpy.gradient(points, axis=1) / 3
        put("handle_left", "FLOAT_VECTOR", "POINT", points - tangents)
        put("handle_right", "FLOAT_VECTOR", "POINT", points + tangents)
    bpy.context.collection.objects.link(bpy.data.objects.new("fur", curves))
    bpy.context.view_layer.update()


for kind in ["CATMULL_ROM", "POLY", "BEZIER", "NURBS"]:
    fur(kind)
    path = str(folder / "blender" / f"fur_{kind.lower()}")
    for form in [".usda", ".usdc"]:
        bpy.ops.wm.usd_export(filepath=path + form, export_hair=True)
    if kind == "CATMULL_ROM":
        bpy.ops.wm.alembic_export(filepath=path + ".abc", start=1, end=1, as_background_job=False)

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
sphere = bpy.context.object
sphere.modifiers.new("hair", "PARTICLE_SYSTEM")
settings = sphere.particle_systems[0].settings
settings.type, settings.count, settings.hair_length = "HAIR", STRANDS, 0.4
settings.hair_step, settings.display_step = 5, 2
bpy.ops.wm.usd_export(filepath=str(folder / "blender/particles.usda"), export_hair=True)
