"""Light that one strand scatters over its width, lit perpendicular to its axis. Models that agree have one value."""

import json
import subprocess

import numpy as np

import scene


def exact():
    """Fresnel, Beer and Snell with all internal reflections (Chiang et al. 2016): the sum of a geometric series."""
    n = 20_000
    h = (np.arange(n) + 0.5) / n
    cos = np.sqrt(1 - h * h)
    inside = np.sqrt(1 - (h / scene.IOR) ** 2)
    s = (cos - scene.IOR * inside) / (cos + scene.IOR * inside)
    p = (scene.IOR * cos - inside) / (scene.IOR * cos + inside)
    f = ((s * s + p * p) / 2)[:, None]
    t = np.exp(-2 * inside[:, None] * np.array(scene.BROWN))
    return (f + (1 - f) ** 2 * t / (1 - f * t)).mean(0)


def ours(program):
    """The closed form in our command."""
    command = [program, "energy", "--fiber", "human", "--window", "far", "--format", "json"]
    for key, value in scene.our_fiber("10K").items():
        command += ["--set", f"{key}={','.join(map(str, value)) if isinstance(value, tuple) else value}"]
    answer = json.loads(subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True).stdout)
    return np.array(answer["lobes"]["total"]["closed_form"])


def mitsuba(samples=1 << 20):
    """The mean weight of Mitsuba's samples."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    hair = {
        "type": "hair",
        "sigma_a": {"type": "rgb", "value": list(scene.BROWN)},
        "longitudinal_roughness": scene.ROUGHNESS,
        "azimuthal_roughness": scene.ROUGHNESS,
        "scale_tilt": scene.TILT,
        "int_ior": scene.IOR,
        "ext_ior": 1.0,
    }
    bsdf = mi.load_dict(hair)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, samples)
    hit = mi.SurfaceInteraction3f()
    h = 2 * sampler.next_1d() - 1
    hit.wi = mi.Vector3f(h, 0, mi.Float((1 - h * h) ** 0.5))
    _, weight = bsdf.sample(mi.BSDFContext(), hit, sampler.next_1d(), sampler.next_2d())
    return np.array(weight).mean(1)
