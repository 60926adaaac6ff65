"""Why dense fur differs between renderers: the same grooms and lobes in ours and in Mitsuba.

usage: dense.py OUT VELLUS

The model is that of Chiang et al. 2016 in both, with the same widths, so the lobes are equal. It prints the ratio of
the means over the picture, R, G and B, for light that is scattered once and for up to 16 events. `straight` has strands
that stand apart on the sphere and do not overlap. Mitsuba's frames are also checked: the share of camera rays whose
frame is more than 2° off the strand.
"""

import os
import subprocess
import sys
from math import degrees, pi, sqrt
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
import drjit as dr

import fur
import scene

SIZE = (160, 90)


def straight(strands, segments, radius):
    """Radial strands on a spiral of points with equal areas."""
    t = np.linspace(0, 1, segments + 1)[None, :, None]
    at = np.arange(strands) + 0.5
    z, azimuth = 1 - 2 * at / strands, pi * (1 + sqrt(5)) * at
    s = np.sqrt(1 - z * z)
    root = np.stack([s * np.cos(azimuth), s * np.sin(azimuth), z], -1)
    points = root[:, None] * (1 + 0.4 * t)
    first, last = 2 * points[:, :1] - points[:, 1:2], 2 * points[:, -1:] - points[:, -2:-1]
    points = np.concatenate([first, points, last], 1).astype(np.float32)
    radii = radius * (1 - scene.TAPER * t[0, :, 0])
    return points, np.concatenate([radii[:1], radii, radii[-1:]]).astype(np.float32)


GROOMS = {
    "straight, 10K": lambda: straight(10_000, 20, 0.004),
    "straight, 200K": lambda: straight(200_000, 20, 0.0013),
    "furry, 10K": lambda: fur.grow(10_000, 20, 0.004),
    "furry, 10K, thick": lambda: fur.grow(10_000, 20, 0.01),
    "furry, 200K": lambda: fur.grow(200_000, 20, 0.0013),
}


def same_lobes(ball, published=scene.our_fiber):
    """The fibre whose three azimuthal lobes have the peers' width: a standard deviation of πs/√3."""
    logistic = sqrt(pi / 8) * (0.265 * scene.ROUGHNESS + 1.194 * scene.ROUGHNESS**2 + 5.372 * scene.ROUGHNESS**22)
    return published(ball) | {"beta_n": degrees(logistic * pi / sqrt(3))}


def load(folder, depth):
    rgb = lambda value: {"type": "rgb", "value": list(value)}
    place = lambda origin, target: mi.ScalarTransform4f().look_at(origin=origin, target=target, up=scene.UP)
    hair = {
        "type": "hair",
        "sigma_a": rgb(scene.BROWN),
        "longitudinal_roughness": scene.ROUGHNESS,
        "azimuthal_roughness": scene.ROUGHNESS,
        "scale_tilt": scene.TILT,
        "int_ior": scene.IOR,
        "ext_ior": 1.0,
    }
    film = {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    camera = {
        "type": "perspective",
        "fov": scene.VIEWS["close"],
        "fov_axis": "y",
        "to_world": place(scene.EYE, scene.TARGET),
        "film": film,
        "sampler": {"type": "independent"},
    }
    light = {"type": "area", "radiance": rgb(scene.LIGHT_RADIANCE)}
    skin = {"type": "diffuse", "reflectance": rgb(scene.SKIN_COLOR["10K"])}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": depth + 1, "rr_depth": 50},
            "fur": {"type": "bsplinecurve", "filename": f"{folder}/dense.txt", "bsdf": hair},
            "skin": {"type": "ply", "filename": f"{folder}/dense.ply", "bsdf": skin},
            "sky": {"type": "constant", "radiance": rgb(scene.SKY)},
            "light": {"type": "rectangle", "to_world": place(scene.LIGHT_AT, [0, 0, 0]), "emitter": light},
            "camera": camera,
        }
    )


def ours(program, folder, depth, spp):
    picture = folder / "dense.exr"
    command = [program, "render", folder / "dense.usdc", "--camera", "close", "--mode", "near", "--model", "chiang2016"]
    command += ["--max-depth", depth, "--size", f"{SIZE[0]}x{SIZE[1]}", "--spp", spp, "--filter", "box"]
    command += ["--layers", "beauty", "--float", "-o", picture]
    subprocess.run(list(map(str, command)), check=True, capture_output=True)
    bitmap = mi.Bitmap(str(picture)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return np.array(bitmap, dtype=np.float64)


def wrong_frames(world):
    """The share of camera rays on fur whose frame is more than 2° off the strand's axis, for straight strands."""
    count = SIZE[0] * SIZE[1] * 16
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(1, count)
    index = dr.arange(mi.UInt32, count) // 16
    pixel = mi.Point2f(mi.Float(index % SIZE[0]), mi.Float(index // SIZE[0])) + sampler.next_2d()
    ray, _ = world.sensors()[0].sample_ray(0, 0, pixel / mi.Point2f(*SIZE), 0)
    hit = world.ray_intersect(ray)
    place, tangent = np.array(hit.p).T.astype(np.float64), np.array(hit.sh_frame.t).T.astype(np.float64)
    fur_hit = np.array(hit.is_valid()) & (np.linalg.norm(place, axis=1) > scene.SKIN_RADIUS + 1e-4)
    place, tangent = place[fur_hit], tangent[fur_hit]
    axis = place / np.linalg.norm(place, axis=1, keepdims=True)
    return (np.abs((tangent * axis).sum(1)) < np.cos(np.radians(2))).mean()


def main():
    folder, program = Path(sys.argv[1]), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    scene.our_fiber = same_lobes
    fur.write_ply(folder / "dense.ply", *fur.skin())
    print("| groom | events | Vellus / Mitsuba: R | G | B | frames off |\n|---|---|---|---|---|---|")
    for name, grow in GROOMS.items():
        points, radii = grow()
        fur.write_text(folder / "dense.txt", points, radii)
        fur.write_usd(folder / "dense.usdc", "10K", points, radii)
        for depth, spp in ((1, 128), (16, 64)):
            world = load(folder, depth)
            theirs = np.array(mi.render(world, spp=spp, seed=3), dtype=np.float64)
            ratio = ours(program, folder, depth, spp).mean((0, 1)) / theirs.mean((0, 1))
            off = f"{100 * wrong_frames(world):.2f} %" if name.startswith("straight") and depth == 1 else ""
            print(f"| {name} | {depth} | " + " | ".join(f"{x:.4f}" for x in ratio) + f" | {off} |", flush=True)
    for kind in ("txt", "ply", "usdc", "exr", "png"):
        os.unlink(folder / f"dense.{kind}")


if __name__ == "__main__":
    main()
