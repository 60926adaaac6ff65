"""Blender Cycles from the bpy wheel as a long-running process, like mitsuba_worker.py.

usage: cycles_worker.py SCENES BALL
"""

import sys

import worker

ANSWER = worker.begin()

import bpy
import mathutils
import numpy as np

import blender
import scene

folder, ball = sys.argv[1], sys.argv[2]


def fur():
    data = np.load(f"{folder}/{ball}.npz")
    points, radii = blender.knots(data["points"].swapaxes(0, 1)), blender.knots(data["radii"])
    counts = [points.shape[0]] * points.shape[1]
    made = blender.curves("fur", counts, points.swapaxes(0, 1), np.tile(radii, len(counts)))
    blender.add("fur", made, blender.hair(scene.ABSORPTION[ball]))


def surroundings():
    data = np.load(f"{folder}/skin.npz")
    mesh = bpy.data.meshes.new("skin")
    mesh.from_pydata((data["vertices"] * scene.SKIN_RADIUS).tolist(), [], data["faces"].tolist())
    mesh.shade_smooth()
    look, _ = blender.material("skin", "ShaderNodeBsdfDiffuse", Color=(*scene.SKIN_COLOR[ball], 1))
    blender.add("skin", mesh, look)

    at = mathutils.Vector(scene.LIGHT_AT)
    turn = at.to_track_quat("Z", "Y")
    light = bpy.data.meshes.new("light")
    corners = [(-1, 1, 0), (1, 1, 0), (1, -1, 0), (-1, -1, 0)]
    light.from_pydata([at + turn @ mathutils.Vector(corner) for corner in corners], [], [(0, 1, 2, 3)])
    strength = max(scene.LIGHT_RADIANCE)
    color = (*(x / strength for x in scene.LIGHT_RADIANCE), 1)
    look, _ = blender.material("light", "ShaderNodeEmission", Color=color, Strength=strength)
    look.cycles.emission_sampling = "FRONT"
    blender.add("light", light, look)
    blender.sky()[0].inputs["Color"].default_value = (*scene.SKY, 1)


def camera():
    made = blender.add("camera", bpy.data.cameras.new("camera"))
    made.data.sensor_fit = "VERTICAL"
    made.location = scene.EYE
    made.rotation_mode = "QUATERNION"
    look = mathutils.Vector(scene.TARGET) - mathutils.Vector(scene.EYE)
    made.rotation_quaternion = look.to_track_quat("-Z", "Y")
    bpy.context.scene.camera = made


def see(view):
    bpy.context.scene.camera.data.angle = np.radians(scene.VIEWS[view])


bpy.ops.wm.read_factory_settings(use_empty=True)
fur()
surroundings()
camera()
blender.settings(scene.BOUNCES[ball])
see("close")
blender.serve(ANSWER, scene.SIZE, see)
