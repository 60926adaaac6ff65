"""The BSDFs `vellus` and `vellus_drjit` beside Mitsuba's own `hair`: thousand samples a processor second.

usage: mitsuba_ways.py [--repeats N] [--spp N] [--strands N]

It needs the packages mitsuba 3.9.1 and vellus, and DRJIT_LIBLLVM_PATH. All ways render the fur of README.md, the view
`close`, in turns, under a sky and without skin, each in a process of its own: the compiled `vellus` must be the only
BSDF. The time is user and system time of all threads, after one render that compiles the kernels.
"""

import argparse
import statistics
import subprocess
import sys
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
    "sigma_a": {"type": "rgb", "value": list(scene.BROWN)},
    "longitudinal_roughness": scene.ROUGHNESS,
    "azimuthal_roughness": scene.ROUGHNESS,
    "scale_tilt": scene.TILT,
    "int_ior": scene.IOR,
    "ext_ior": 1.0,
}
SAME = {name: list(value) if isinstance(value, tuple) else value for name, value in scene.our_fiber("10K").items()}
WAYS = {
    "hair": HAIR,
    "vellus_drjit, hair": {"type": "vellus_drjit", **SAME},
    "vellus, hair": {"type": "vellus", **SAME},
    "vellus_drjit, red-fox": {"type": "vellus_drjit", "preset": "red-fox"},
    "vellus, red-fox": {"type": "vellus", "preset": "red-fox"},
}


def load(folder, bsdf, size):
    sky = {"type": "rgb", "value": list(scene.SKY)}
    place = lambda origin, target: mi.ScalarTransform4f().look_at(origin=origin, target=target, up=scene.UP)
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": scene.BOUNCES["10K"] + 1, "rr_depth": scene.ROULETTE},
            "sky": {"type": "constant", "radiance": sky},
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


def render(name, strands, spp, seed, size=(160, 90)):
    """Renders one way twice. Prints thousand samples a processor second of the second time, and the mean colour."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        fur.write_text(folder / "fur.txt", *fur.grow(strands, 20, 0.004))
        loaded = load(folder, WAYS[name], size)
    with vellus.mitsuba.arrays() if name.startswith("vellus,") else nullcontext():
        np.array(mi.render(loaded, spp=spp, seed=0))
        start = time.process_time()
        mean = np.array(mi.render(loaded, spp=spp, seed=seed)).mean((0, 1))
        spent = time.process_time() - start
    print(size[0] * size[1] * spp / spent / 1000, *mean)


def main(repeats, spp, strands):
    rates, means = {name: [] for name in WAYS}, {}
    for seed in range(1, repeats + 1):
        for name in WAYS:
            command = [sys.executable, __file__, "--way", name, "--spp", str(spp), "--strands", str(strands)]
            run = subprocess.run([*command, "--seed", str(seed)], capture_output=True, text=True, check=True)
            rate, *means[name] = map(float, run.stdout.split())
            rates[name].append(rate)
    print("| way | Ksamples/cpu-s | least | most | mean |\n|---|---|---|---|---|")
    for name, values in rates.items():
        mean = " ".join(f"{x:.4f}" for x in means[name])
        print(f"| {name} | {statistics.median(values):.0f} | {min(values):.0f} | {max(values):.0f} | {mean} |")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--strands", type=int, default=10_000)
    parser.add_argument("--way", choices=WAYS, help="render this way only")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    if arguments.way:
        render(arguments.way, arguments.strands, arguments.spp, arguments.seed)
    else:
        main(arguments.repeats, arguments.spp, arguments.strands)
