"""Blender Cycles with a built-in scene, as a long-running process: like cycles_worker.py.

usage: built_in_cycles.py SCENES NAME
"""

import sys

import worker

ANSWER = worker.begin()

import bpy
import mathutils
import numpy as np
from pxr import Usd, UsdGeom, UsdLux

import blender
import scene
from usd_scenes import ABSORPTION, environment, matrix, radiance, strands, triangles

folder, name = sys.argv[1], sys.argv[2]
# A quick build before the first request.
SMALL = (48, 32)
# Axes of Blender's images of the sky: from y as the pole to z, and +z to the middle.
POLE = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
# Of a light's size.
BEHIND = 1e-3


def curves(prim, place):
    counts, rows = strands(prim, place)
    starts = np.cumsum(counts) - counts
    inside = np.ones(len(rows), bool)
    # A strand has two knots less than control points.
    inside[starts] = inside[starts + counts - 1] = False
    rows = blender.knots(rows)[inside[1:-1]]
    return blender.curves(prim.GetName(), counts - 2, rows[:, :3], rows[:, 3])


def mesh(prim, place):
    points, faces, color = triangles(prim, place)
    made = bpy.data.meshes.new(prim.GetName())
    made.vertices.add(len(points))
    made.vertices.foreach_set("co", points.astype(np.float32).ravel())
    made.loops.add(faces.size)
    made.loops.foreach_set("vertex_index", faces.astype(np.int32).ravel())
    made.polygons.add(len(faces))
    made.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, np.int32))
    made.update(calc_edges=True)
    if UsdGeom.Mesh(prim).GetNormalsAttr().Get():
        made.shade_smooth()
    else:
        made.shade_flat()
    return made, diffuse(prim.GetName(), color)


def diffuse(name, color):
    return blender.material(name, "ShaderNodeBsdfDiffuse", Color=(*color, 1))[0]


def shape(prim, place, look):
    if prim.IsA(UsdGeom.BasisCurves):
        blender.add(prim.GetName(), curves(prim, place), look)
    elif prim.IsA(UsdGeom.Mesh):
        blender.add(prim.GetName(), *mesh(prim, place))


def dome(prim, place):
    background, tree = blender.sky()
    color = radiance(prim)
    if not (file := environment(prim)):
        background.inputs["Color"].default_value = (*color, 1)
        return
    # The built-in scenes have white as the colour of images.
    background.inputs["Strength"].default_value = color[0]
    coordinates, turn, image = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "Mapping", "TexEnvironment")
    )
    turn.vector_type = "VECTOR"
    turn.inputs["Rotation"].default_value = mathutils.Matrix(POLE @ place[:3, :3].T).to_euler()
    image.image = bpy.data.images.load(file)
    image.image.colorspace_settings.name = "Non-Color"
    tree.links.new(coordinates.outputs["Generated"], turn.inputs["Vector"])
    tree.links.new(turn.outputs[0], image.inputs["Vector"])
    tree.links.new(image.outputs["Color"], background.inputs["Color"])


def rectangle(prim, place):
    rect = UsdLux.RectLight(prim)
    lengths = np.linalg.norm(place[:3, :3], axis=0)
    made = bpy.data.lights.new(prim.GetName(), "AREA")
    made.shape = "RECTANGLE"
    made.size, made.size_y = rect.GetWidthAttr().Get() * lengths[0], rect.GetHeightAttr().Get() * lengths[1]
    color = radiance(prim)
    # Both shine along −z. The radiance is the power over π times the area.
    made.color, made.energy = color / color.max(), color.max() * np.pi * made.size * made.size_y
    turned = place.copy()
    turned[:3, :3] /= lengths
    blender.add(prim.GetName(), made).matrix_world = mathutils.Matrix(turned)
    # Light passes through Blender's lamps. A black surface behind stops it, as in the other renderers.
    wall = bpy.data.meshes.new("wall")
    corners = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * (made.size / 2, made.size_y / 2, 0)
    corners[:, 2] = BEHIND * max(made.size, made.size_y)
    wall.from_pydata(corners.tolist(), [], [(0, 1, 2, 3)])
    blender.add("wall", wall, diffuse("wall", (0, 0, 0))).matrix_world = mathutils.Matrix(turned)


def camera(prim, place):
    given = UsdGeom.Camera(prim)
    made = blender.add("camera", bpy.data.cameras.new("camera"))
    made.matrix_world = mathutils.Matrix(place)
    made.data.sensor_fit, made.data.sensor_width = "HORIZONTAL", given.GetHorizontalApertureAttr().Get()
    made.data.lens = given.GetFocalLengthAttr().Get()
    made.data.clip_start, made.data.clip_end = 0.1, 1e5
    bpy.context.scene.camera = made


bpy.ops.wm.read_factory_settings(use_empty=True)
hair = blender.hair(ABSORPTION[name])
stage = Usd.Stage.Open(f"{folder}/{name}.usdc")
for prim in stage.Traverse():
    if prim.IsA(UsdGeom.Camera):
        camera(prim, matrix(prim))
    elif prim.IsA(UsdLux.DomeLight):
        dome(prim, matrix(prim))
    elif prim.IsA(UsdLux.RectLight):
        rectangle(prim, matrix(prim))
    elif prim.IsA(UsdGeom.Imageable) and not prim.IsInstance():
        shape(prim, matrix(prim), hair)
blender.settings(scene.MANY)
blender.serve(ANSWER, SMALL)
