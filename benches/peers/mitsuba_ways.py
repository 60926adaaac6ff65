"""The BSDFs `vellus` and `vellus_drjit` beside Mitsuba's own `hair`: thousand samples a processor second.

usage: mitsuba_ways.py [--repeats N] [--spp N] [--strands N]

It needs the packages mitsuba 3.9.1 and vellus, and DRJIT_LIBLLVM_PATH. All ways render the fur of README.md, the view
`close`, in turns. The time is user and system time of all threads, after one render that compiles the kernels.
"""

import argparse
import statistics
import tempfile
import time
from contextlib import nullcontext
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
import vellus.mitsuba  # noqa: E402

import fur  # noqa: E402
import scene  # noqa: E402

HAIR = {
    "type": "hair",
    "sigma_a": {"type": "rgb", "value": list(scene.ABSORPTION)},
    "longitudinal_roughness": scene.ROUGHNESS,
    "azimuthal_roughness": scene.ROUGHNESS,
    "scale_tilt": scene.TILT,
    "int_ior": scene.IOR,
    "ext_ior": 1.0,
}
SAME = {name: list(value) if isinstance(value, tuple) else value for name, value in scene.our_fiber().items()}
WAYS = {
    "hair": HAIR,
    "vellus_drjit, hair": {"type": "vellus_drjit", **SAME},
    "vellus, hair": {"type": "vellus", **SAME},
    "vellus_drjit, red-fox": {"type": "vellus_drjit", "preset": "red-fox"},
    "vellus, red-fox": {"type": "vellus", "preset": "red-fox"},
}


def load(folder, bsdf, size):
    rgb = lambda value: {"type": "rgb", "value": list(value)}
    place = lambda origin, target: mi.ScalarTransform4f().look_at(origin=origin, target=target, up=scene.UP)
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": scene.BOUNCES + 1, "rr_depth": scene.ROULETTE},
            "sky": {"type": "constant", "radiance": rgb(scene.SKY)},
            "light": {
                "type": "rectangle",
                "to_world": place(scene.LIGHT_AT, [0, 0, 0]),
                "emitter": {"type": "area", "radiance": rgb(scene.LIGHT_RADIANCE)},
            },
            "skin": {
                "type": "ply",
                "filename": str(folder / "skin.ply"),
                "bsdf": {"type": "diffuse", "reflectance": rgb(scene.SKIN_COLOR)},
            },
            "fur": {"type": "bsplinecurve", "filename": str(folder / "fur.txt"), "bsdf": bsdf},
            "sensor": {
                "type": "perspective",
                "fov": scene.VIEWS["close"],
                "fov_axis": "y",
                "to_world": place(scene.EYE, scene.TARGET),
                "film": film,
                "sampler": {"type": "independent"},
            },
        }
    )


def main(repeats, spp, strands, size=(160, 90)):
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        fur.write_text(folder / "fur.txt", *fur.grow(strands, 20, 0.004))
        fur.write_ply(folder / "skin.ply", *fur.skin())
        scenes = {name: load(folder, bsdf, size) for name, bsdf in WAYS.items()}

    def render(name, seed):
        with vellus.mitsuba.arrays() if name.startswith("vellus,") else nullcontext():
            start = time.process_time()
            image = np.array(mi.render(scenes[name], spp=spp, seed=seed))
            return time.process_time() - start, image.mean((0, 1))

    times, means = {name: [] for name in WAYS}, {}
    for name in WAYS:
        render(name, 0)
    for repeat in range(repeats):
        for name in WAYS:
            spent, means[name] = render(name, repeat + 1)
            times[name].append(size[0] * size[1] * spp / spent / 1000)
    print("| way | Ksamples/cpu-s | least | most | mean |\n|---|---|---|---|---|")
    for name, rates in times.items():
        mean = " ".join(f"{x:.4f}" for x in means[name])
        print(f"| {name} | {statistics.median(rates):.0f} | {min(rates):.0f} | {max(rates):.0f} | {mean} |")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--strands", type=int, default=10_000)
    arguments = parser.parse_args()
    main(arguments.repeats, arguments.spp, arguments.strands)
