"""Recovers absorption, roughness and medulla of a groom from five rendered views, by gradient descent.

usage: python recover.py [--steps N] [--output FOLDER]

It needs the packages vellus, mitsuba and numpy, and LLVM's library (DRJIT_LIBLLVM_PATH). It takes a few minutes.
It prints each step, and writes the steps to recover.csv and the views to target.png, start.png and found.png.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
import vellus.mitsuba  # noqa: E402, it registers the BSDF

TRUTH = {"sigma_ca": [0.15, 0.3, 0.6], "beta_m": 12.0, "kappa": 0.75}
START = {"sigma_ca": [0.4, 0.4, 0.4], "beta_m": 6.0, "kappa": 0.5}
# What is known of the fibre: scattering of the medulla as in a fox.
KNOWN = {"eta": 1.55, "alpha": 3.0, "beta_n": 12.0, "sigma_ms": 2.0, "g": 0.6, "layers": 0.7}
RANGES = {"sigma_ca": (0.005, 5.0), "beta_m": (2.0, 40.0), "kappa": (0.1, 0.95)}
# Steps of gradient descent are in the logarithm of each parameter.
RATE, VIEWS, SIZE = 0.08, 5, 64


def grow(path, strands=600, points=8, seed=1):
    """Fur on the unit sphere, as Mitsuba's text: `x y z radius` per line, and an empty line between curves."""
    g = np.random.default_rng(seed)
    root = g.normal(size=(strands, 3))
    root /= np.linalg.norm(root, axis=1, keepdims=True)
    lean = np.cross(root, [0.0, 0.0, 1.0]) * 0.5 + g.normal(size=(strands, 3)) * 0.2
    t = np.linspace(-0.15, 1.15, points)[None, :, None]
    curves = root[:, None] * (1 + 0.5 * t) + lean[:, None] * 0.4 * t * t
    radius = 0.02 * (1 - 0.6 * np.clip(t[0, :, 0], 0, 1))
    # Mitsuba 3.9.1 reads past its list of segments where a ray hits the very end of the last one, and may crash. So
    # the last curve is one that rays do not hit.
    last = np.linspace([0, 0, 0], [1e-4, 0, 0], points)
    with open(path, "w") as file:
        for curve, width in [*((curve, radius) for curve in curves), (last, np.full(points, 1e-7))]:
            file.writelines("%.6g %.6g %.6g %.6g\n" % (*p, r) for p, r in zip(curve, width))
            file.write("\n")


def scene(curves, fiber):
    rgb = lambda value: {"type": "rgb", "value": value}
    place = lambda origin: mi.ScalarTransform4f().look_at(origin=origin, target=[0, 0, 0], up=[0, 0, 1])
    light = {"type": "area", "radiance": rgb([14.0, 13.0, 11.0])}
    return mi.load_dict(
        {
            "type": "scene",
            "sky": {"type": "constant", "radiance": rgb([0.3, 0.35, 0.4])},
            "key": {"type": "rectangle", "to_world": place([3, -3, 4]), "emitter": light},
            "fur": {"type": "bsplinecurve", "filename": str(curves), "bsdf": {"type": "vellus_drjit", **fiber}},
        }
    )


def camera(view):
    angle = 2 * np.pi * view / VIEWS
    origin = [5 * np.cos(angle), 5 * np.sin(angle), 1.5]
    film = {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    place = mi.ScalarTransform4f().look_at(origin=origin, target=[0, 0, 0], up=[0, 0, 1])
    return mi.load_dict(
        {"type": "perspective", "fov": 38.0, "to_world": place, "film": film, "sampler": {"type": "independent"}}
    )


def strip(images, path):
    """The views side by side."""
    mi.util.write_bitmap(str(path), np.concatenate([np.array(image) for image in images], 1))


def flat(values):
    return [x for name in TRUTH for x in np.ravel(values[name])]


def main(steps, output, samples):
    cameras = [camera(view) for view in range(VIEWS)]
    integrator = mi.load_dict({"type": "prb", "max_depth": 6, "rr_depth": 100})
    with tempfile.TemporaryDirectory() as folder:
        curves = Path(folder) / "fur.txt"
        grow(curves)
        target_scene, found = scene(curves, {**KNOWN, **TRUTH}), scene(curves, {**KNOWN, **START})
    # Independent of the seeds of the descent.
    shots = lambda s, seed: [
        mi.render(s, sensor=c, spp=256, seed=seed + i, integrator=integrator) for i, c in enumerate(cameras)
    ]
    with dr.suspend_grad():
        targets = shots(target_scene, 10_000)
        strip(targets, output / "target.png")
        strip(shots(found, 20_000), output / "start.png")
    params = mi.traverse(found)
    keys = {name: next(k for k in params.keys() if k.endswith(name)) for name in TRUTH}
    # Colours and numbers in the logarithm: all are above 0 and of different sizes.
    kinds = {name: mi.Color3f if name == "sigma_ca" else mi.Float for name in TRUTH}
    logs = mi.ad.Adam(lr=RATE)
    for name in TRUTH:
        start = START[name]
        logs[name] = dr.log(kinds[name](*start) if name == "sigma_ca" else kinds[name](start))
    log = ["step,loss," + ",".join(["sigma_ca.r", "sigma_ca.g", "sigma_ca.b", "beta_m", "kappa"])]
    for step in range(steps + 1):
        for name, key in keys.items():
            low, high = RANGES[name]
            logs[name] = dr.clip(dr.detach(logs[name]), float(np.log(low)), float(np.log(high)))
            params[key] = dr.exp(logs[name])
        params.update()
        values = {name: dr.detach(params[key]).numpy().ravel() for name, key in keys.items()}
        if step == steps:
            break
        # Smaller steps toward the end.
        logs.set_learning_rate(RATE * 0.5 ** (3 * step / steps))
        total = 0.0
        for i, c in enumerate(cameras):
            image = mi.render(
                found,
                params,
                sensor=c,
                spp=samples,
                seed=2 * (step * VIEWS + i),
                seed_grad=2 * (step * VIEWS + i) + 1,
                integrator=integrator,
            )
            # Relative errors, so that dark channels count.
            loss = dr.mean(dr.square((image - targets[i]) / (targets[i] + 0.05)), axis=None) / VIEWS
            dr.backward(loss)
            total += float(loss.numpy())
        log.append(",".join("%.5g" % x for x in (step, total, *flat(values))))
        print(log[-1], flush=True)
        logs.step()
    with dr.suspend_grad():
        strip(shots(found, 20_000), output / "found.png")
    (output / "recover.csv").write_text("\n".join(log) + "\n")
    for name in TRUTH:
        print(f"{name}: true {np.ravel(TRUTH[name])}, start {np.ravel(START[name])}, found {np.round(values[name], 4)}")
    return values


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--samples", type=int, default=16, help="samples a pixel for each gradient")
    parser.add_argument("--output", type=Path, default=Path("."))
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    main(arguments.steps, arguments.output, arguments.samples)
