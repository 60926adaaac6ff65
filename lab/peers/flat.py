"""A flat strand in Cycles, with the model of Huang et al. 2022, and in Vellus.

usage: flat.py VELLUS [SAMPLES]
needs: pip install bpy==5.0.1 usd-core numpy (Python 3.11)

A strand in a white sky, seen from three sides. Prints the share of light that its part of the picture scatters (RGB).
The width that a ray sees must be the same in both. In Cycles the curve's normal is the longer axis of the section, and
absorption is per half of that axis. In Vellus normals are the shorter axis, and absorption is per radius of the circle
of the same area. So Vellus gets Cycles' absorption times the root of the ratio of axes. Rough interfaces lose light in
Cycles, hence the small roughness.
"""

import subprocess
import sys
import tempfile
from math import atan, cos, hypot, pi, radians, sin, sqrt
from pathlib import Path

import bpy
import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

import blender

ABSORPTION, ROUGHNESS, IOR = (0.25, 0.45, 0.95), 0.05, 1.55
RATIOS, SIDES = (1.0, 0.85, 0.625), (0, 45, 90)
# The strand fills two thirds of the picture. The camera is far away, so that its rays are nearly parallel.
RADIUS, HALF, AWAY, PIXELS = 0.1, 0.15, 100.0, 16


def shorter(side):
    """The shorter axis, so many degrees from the direction of the camera, which is at -y. The strand is along z."""
    return sin(radians(side)), -cos(radians(side)), 0.0


def cycles(ratio, side, samples, picture):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    look, node = blender.material("hair", "ShaderNodeBsdfHairPrincipled")
    node.model, node.parametrization = "HUANG", "ABSORPTION"
    inputs = {"Absorption Coefficient": ABSORPTION, "Roughness": ROUGHNESS, "IOR": IOR, "Offset": 0.0}
    for key, value in (inputs | {"Aspect Ratio": ratio}).items():
        node.inputs[key].default_value = value
    strand = blender.curves("strand", [4], [(0, 0, z) for z in (-1.5, -0.5, 0.5, 1.5)], [RADIUS] * 4)
    free = 2
    strand.attributes.new("normal_mode", "INT8", "CURVE").data.foreach_set("value", np.array([free], np.int8))
    normal = strand.attributes.new("custom_normal", "FLOAT_VECTOR", "POINT")
    normal.data.foreach_set("vector", np.tile(np.cross((0, 0, 1), shorter(side)), 4).astype(np.float32))
    blender.add("strand", strand, look)
    blender.sky()[0].inputs["Color"].default_value = (1, 1, 1, 1)
    camera = blender.add("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler, camera.data.angle = (0, -AWAY, 0), (pi / 2, 0, 0), 2 * atan(HALF / AWAY)
    blender.settings(0)
    scene = bpy.context.scene
    # The part of the circle outside of the section is transparent.
    scene.camera, scene.cycles.transparent_max_bounces, scene.cycles.samples = camera, 8, samples
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.render.filepath = str(picture)
    bpy.ops.render.render(write_still=True)


def vellus(ratio, side, samples, picture, program):
    file = picture.with_suffix(".usda")
    stage = Usd.Stage.CreateNew(str(file))
    material, shader = UsdShade.Material.Define(stage, "/look"), UsdShade.Shader.Define(stage, "/look/fiber")
    shader.CreateIdAttr("VellusFur")
    narrow = {"beta_m": 2.0, "beta_n": 2.0, "alpha": 0.0, "kappa": 0.0, "layers": 0.5}
    for key, value in (narrow | {"eta": IOR, "aspect_ratio": ratio}).items():
        shader.CreateInput(key, Sdf.ValueTypeNames.Float).Set(value)
    absorption = Gf.Vec3f(*(x * sqrt(ratio) for x in ABSORPTION))
    shader.CreateInput("sigma_ca", Sdf.ValueTypeNames.Color3f).Set(absorption)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    strand = UsdGeom.BasisCurves.Define(stage, "/strand")
    strand.CreateTypeAttr("linear")
    strand.CreateCurveVertexCountsAttr([2])
    strand.CreatePointsAttr([(0, 0, -1.5), (0, 0, 1.5)])
    strand.CreateWidthsAttr([2 * RADIUS])
    strand.SetWidthsInterpolation("constant")
    strand.CreateNormalsAttr([shorter(side)])
    strand.SetNormalsInterpolation("constant")
    UsdShade.MaterialBindingAPI.Apply(strand.GetPrim()).Bind(material)
    UsdLux.DomeLight.Define(stage, "/sky")
    camera = UsdGeom.Camera.Define(stage, "/camera")
    camera.CreateHorizontalApertureAttr(2 * HALF)
    camera.CreateVerticalApertureAttr(2 * HALF)
    camera.CreateFocalLengthAttr(AWAY)
    camera.AddTranslateOp().Set((0, -AWAY, 0))
    camera.AddRotateXOp().Set(90)
    stage.Save()
    command = [program, "render", file, "--size", f"{PIXELS}x{PIXELS}", "--spp", samples, "--max-depth", 1]
    command += ["--filter", "box", "--layers", "beauty", "--float", "-o", picture]
    subprocess.run(list(map(str, command)), check=True, capture_output=True)


def scattered(picture, ratio, side):
    """The share of light that the strand's part of the picture scatters. Around it is the white sky."""
    image = bpy.data.images.load(str(picture))
    pixels = np.empty((PIXELS * PIXELS, image.channels), np.float32)
    image.pixels.foreach_get(pixels.ravel())
    bpy.data.images.remove(image)
    mean = pixels[:, :3].mean(0, dtype=np.float64)
    covered = RADIUS / HALF * hypot(cos(radians(side)), ratio * sin(radians(side)))
    return 1 - (1 - mean) / covered


def main():
    program, samples = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 4096
    print("| ratio of axes | shorter axis | Cycles | Vellus | Vellus / Cycles |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "strand.exr"
        for ratio, side in [(r, s) for r in RATIOS for s in (SIDES if r < 1 else SIDES[:1])]:
            cycles(ratio, side, samples, picture)
            theirs = scattered(picture, ratio, side)
            vellus(ratio, side, samples, picture, program)
            ours = scattered(picture, ratio, side)
            cells = (", ".join(f"{x:.3f}" for x in row) for row in (theirs, ours, ours / theirs))
            print(f"| {ratio:g} | {side}° |", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()
