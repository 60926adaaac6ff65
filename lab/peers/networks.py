"""Compares shading networks of other programs, as `vellus` reads them, with the same hair in Mitsuba.

usage: networks.py VELLUS [SAMPLES]
needs: pip install mitsuba usd-core numpy OpenEXR

Each network describes Chiang's hair, which Mitsuba's `hair` renders directly. A strand fills the picture and is lit by
a white sky, so that its mean is the albedo. A ball of 4,000 strands adds multiple scattering. Prints a table: both mean
colours of linear RGB, their ratio, and CIEDE2000.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np
import OpenEXR
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

EUMELANIN, PHEOMELANIN = np.array([0.506, 0.841, 1.653]), np.array([0.343, 0.733, 1.924])


def melanin(amount, redness, pigments=(EUMELANIN, PHEOMELANIN)):
    return -np.log(1 - amount) * ((1 - redness) * pigments[0] + redness * pigments[1])


def dye(color, b):
    fit = 5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5
    return (np.log(np.array(color)) / fit) ** 2


class Network:
    """A network in a stage, and the same hair as parameters of Mitsuba. Mitsuba turns R towards the tip."""

    def __init__(self, name, context, nodes, sigma, along, around, tilt, ior):
        self.name, self.context, self.nodes = name, context, nodes
        self.mitsuba = {"type": "hair", "sigma_a": {"type": "rgb", "value": [float(x) for x in sigma]},
                        "longitudinal_roughness": along, "azimuthal_roughness": around, "scale_tilt": -tilt,
                        "int_ior": ior, "ext_ior": 1.0}

    def write(self, stage):
        material = UsdShade.Material.Define(stage, "/look")
        shaders = {}
        for name, (identifier, inputs) in self.nodes.items():
            shaders[name] = UsdShade.Shader.Define(stage, f"/look/{name}")
            shaders[name].CreateIdAttr(identifier)
            for key, (kind, value) in inputs.items():
                target = shaders[name].CreateInput(key, getattr(Sdf.ValueTypeNames, kind))
                if isinstance(value, str):
                    source, output = value.split(".")
                    target.ConnectToSource(shaders[source].CreateOutput(output, getattr(Sdf.ValueTypeNames, kind)))
                else:
                    target.Set(value)
        last = shaders[list(self.nodes)[-1]]
        material.CreateSurfaceOutput(self.context).ConnectToSource(last.CreateOutput("out", Sdf.ValueTypeNames.Token))
        return material


def networks():
    color = (0.8, 0.5, 0.25)
    rough = ("ND_chiang_hair_roughness", {"longitudinal": ("Float", 0.3), "azimuthal": ("Float", 0.3)})

    def chiang(absorption, output):
        connections = {f"roughness_{lobe}": ("Float2", f"rough.roughness_{lobe}") for lobe in ["R", "TT", "TRT"]}
        bsdf = {"cuticle_angle": ("Float", 0.5 + 2 / 180), "ior": ("Float", 1.55),
                "absorption_coefficient": ("Vector3f", f"sigma.{output}")}
        return {"rough": rough, "sigma": absorption, "bsdf": ("ND_chiang_hair_bsdf", bsdf | connections),
                "surface": ("ND_surface", {"bsdf": ("Token", "bsdf.out")})}

    yield Network("MaterialX, colour", "mtlx", chiang(("ND_chiang_hair_absorption_from_color", {
        "color": ("Color3f", Gf.Vec3f(*color)), "azimuthal_roughness": ("Float", 0.3)}), "absorption"),
        dye(color, 0.3), 0.3, 0.3, 2, 1.55)
    pigments = [-np.log([0.657704, 0.498077, 0.254107]), -np.log([0.829444, 0.67032, 0.349938])]
    yield Network("MaterialX, melanin", "mtlx", chiang(("ND_deon_hair_absorption_from_melanin", {
        "melanin_concentration": ("Float", 0.5), "melanin_redness": ("Float", 0.3)}), "absorption"),
        melanin(0.5, 0.3, pigments), 0.3, 0.3, 2, 1.55)
    yield Network("Arnold", "arnold", {"hair": ("arnold:standard_hair", {
        "base_color": ("Color3f", Gf.Vec3f(*color)), "melanin": ("Float", 0.2), "melanin_redness": ("Float", 0.5),
        "roughness": ("Float", 0.25), "shift": ("Float", 3), "ior": ("Float", 1.55)})},
        dye(color, 0.25) + melanin(0.2, 0.5), 0.25, 0.25, 3, 1.55)
    yield Network("Karma, no medulla", "kma", {"hair": ("kma_hair", {
        "baseColor": ("Color3f", Gf.Vec3f(*color)), "melanin": ("Float", 0.1), "roughness": ("Float", 0.4),
        "shift": ("Float", 1 / 45), "ior": ("Float", 1.5)})},
        dye(color, 0.4) + melanin(0.1, 0.5), 0.4, 0.4, 2, 1.5)


def strand():
    points = np.array([[[x, 0, 0] for x in np.linspace(-30, 30, 7)]], np.float32)
    return points, 1.0, 40.0, 1.9, lambda x, y: np.abs(y) < 0.95


def ball(count=4000, radius=0.012):
    g = np.random.default_rng(7)
    z = 1 - 2 * (np.arange(count) + 0.5) / count
    azimuth = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    root = np.stack([np.sqrt(1 - z * z) * np.cos(azimuth), np.sqrt(1 - z * z) * np.sin(azimuth), z], -1)
    bend = g.normal(size=(count, 3)) * 0.15
    t = np.linspace(-0.3, 1.3, 7)[None, :, None]
    points = root[:, None] * (0.3 + 0.7 * t) + bend[:, None] * t * t
    return points.astype(np.float32), radius, 12.0, 2.4, lambda x, y: np.hypot(x, y) < 0.6


def render_vellus(command, network, shape, samples, size, folder):
    points, radius, distance, height, _ = shape
    stage = Usd.Stage.CreateNew(str(folder / "scene.usda"))
    curves = UsdGeom.BasisCurves.Define(stage, "/fur")
    curves.CreateTypeAttr("cubic")
    curves.CreateBasisAttr("bspline")
    curves.CreateCurveVertexCountsAttr([points.shape[1]] * len(points))
    curves.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in points.reshape(-1, 3)])
    curves.CreateWidthsAttr([2 * radius])
    curves.SetWidthsInterpolation("constant")
    UsdShade.MaterialBindingAPI.Apply(curves.GetPrim()).Bind(network.write(stage))
    sky = UsdLux.DomeLight.Define(stage, "/sky")
    sky.CreateIntensityAttr(1.0)
    camera = UsdGeom.Camera.Define(stage, "/camera")
    camera.AddTranslateOp().Set(Gf.Vec3d(0, 0, distance))
    camera.CreateFocalLengthAttr(distance)
    camera.CreateHorizontalApertureAttr(height)
    camera.CreateVerticalApertureAttr(height)
    stage.Save()
    out = folder / "vellus.exr"
    command = [command, "render", "scene.usda", "-o", str(out), "--size", f"{size}x{size}", "--spp", str(samples),
               "--filter", "box", "--float"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    channels = OpenEXR.File(str(out)).channels()
    picture = channels["RGB"].pixels if "RGB" in channels else channels["RGBA"].pixels[..., :3]
    return np.array(picture)


def render_mitsuba(network, shape, samples, size, folder):
    points, radius, distance, height, _ = shape
    rows = ["\n".join(f"{x} {y} {z} {radius}" for x, y, z in strand) for strand in points]
    (folder / "curves.txt").write_text("\n\n".join(rows))
    scene = mi.load_dict({
        "type": "scene", "integrator": {"type": "path", "max_depth": 100, "rr_depth": 20},
        "sensor": {"type": "perspective", "fov": float(np.degrees(2 * np.arctan(height / 2 / distance))),
                   "to_world": mi.ScalarTransform4f().look_at([0, 0, distance], [0, 0, 0], [0, 1, 0]),
                   "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"},
                            "pixel_format": "rgb"},
                   "sampler": {"type": "independent", "sample_count": samples}},
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [1, 1, 1]}},
        "fur": {"type": "bsplinecurve", "filename": str(folder / "curves.txt"), "bsdf": network.mitsuba}})
    return np.array(mi.render(scene, spp=samples))


def mean(picture, shape):
    height, inside = shape[3], shape[4]
    size = picture.shape[0]
    axis = ((np.arange(size) + 0.5) / size - 0.5) * height
    y, x = np.meshgrid(axis, axis, indexing="ij")
    return picture[inside(x, y)].mean(0)


def lab(rgb):
    matrix = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
                       [0.0193339, 0.1191920, 0.9503041]])
    xyz = matrix @ rgb / (matrix @ np.ones(3))
    f = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz / 3 / (6 / 29) ** 2 + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def ciede2000(one, two):
    """CIEDE2000 of two linear sRGB colours (Sharma, Wu and Dalal 2005)."""
    (l1, a1, b1), (l2, a2, b2) = lab(one), lab(two)
    c = (np.hypot(a1, b1) + np.hypot(a2, b2)) / 2
    g = 0.5 * (1 - np.sqrt(c**7 / (c**7 + 25.0**7)))
    a1, a2 = a1 * (1 + g), a2 * (1 + g)
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1)) % 360, np.degrees(np.arctan2(b2, a2)) % 360
    turn = (h2 - h1 + 180) % 360 - 180
    dl, dc, dh = l2 - l1, c2 - c1, 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2))
    lm, cm, hm = (l1 + l2) / 2, (c1 + c2) / 2, h1 + turn / 2
    t = (1 - 0.17 * np.cos(np.radians(hm - 30)) + 0.24 * np.cos(np.radians(2 * hm))
         + 0.32 * np.cos(np.radians(3 * hm + 6)) - 0.2 * np.cos(np.radians(4 * hm - 63)))
    sl = 1 + 0.015 * (lm - 50) ** 2 / np.sqrt(20 + (lm - 50) ** 2)
    sc, sh = 1 + 0.045 * cm, 1 + 0.015 * cm * t
    rt = (-np.sin(np.radians(60 * np.exp(-(((hm - 275) / 25) ** 2)))) * 2 * np.sqrt(cm**7 / (cm**7 + 25.0**7)))
    return float(np.sqrt((dl / sl) ** 2 + (dc / sc) ** 2 + (dh / sh) ** 2 + rt * dc / sc * dh / sh))


def main():
    command, samples = str(Path(sys.argv[1]).resolve()), int(sys.argv[2]) if len(sys.argv) > 2 else 256
    mi.set_variant("scalar_rgb")
    print("| network | shape | Mitsuba | Vellus | ratio | ΔE2000 |\n|---|---|---|---|---|---|")
    for network in networks():
        for name, shape, size in [("strand", strand(), 32), ("ball", ball(), 64)]:
            with tempfile.TemporaryDirectory() as folder:
                theirs = mean(render_mitsuba(network, shape, samples, size, Path(folder)), shape)
                ours = mean(render_vellus(command, network, shape, samples, size, Path(folder)), shape)
            text = [" ".join(f"{x:.3f}" for x in row) for row in [theirs, ours, ours / theirs]]
            print(f"| {network.name} | {name} | {' | '.join(text)} | {ciede2000(theirs, ours):.2f} |", flush=True)


main()
