"""Mitsuba 3 as a long-running process: reads one request per line from standard input, and writes one answer per line.

usage: mitsuba_worker.py VARIANT SCENES BALL
"""

import sys

import worker

ANSWER = worker.begin()

import mitsuba as mi

import scene

variant, folder, ball = sys.argv[1], sys.argv[2], sys.argv[3]
mi.set_variant(variant)
rgb = lambda value: {"type": "rgb", "value": list(value)}
place = lambda origin, target: mi.ScalarTransform4f().look_at(origin=origin, target=target, up=scene.UP)


def load():
    light = {"type": "area", "radiance": rgb(scene.LIGHT_RADIANCE)}
    skin = {"type": "diffuse", "reflectance": rgb(scene.SKIN_COLOR[ball])}
    hair = {
        "type": "hair",
        "sigma_a": rgb(scene.ABSORPTION[ball]),
        "longitudinal_roughness": scene.ROUGHNESS,
        "azimuthal_roughness": scene.ROUGHNESS,
        "scale_tilt": scene.TILT,
        "int_ior": scene.IOR,
        "ext_ior": 1.0,
    }
    return mi.load_dict(
        {
            "type": "scene",
            # A depth of 1 is light that the camera sees directly.
            "integrator": {"type": "path", "max_depth": scene.BOUNCES[ball] + 1, "rr_depth": scene.ROULETTE},
            "sky": {"type": "constant", "radiance": rgb(scene.SKY)},
            "light": {"type": "rectangle", "to_world": place(scene.LIGHT_AT, [0, 0, 0]), "emitter": light},
            "skin": {"type": "ply", "filename": f"{folder}/skin.ply", "bsdf": skin},
            # Linear curves have no frame for hair in Mitsuba, so only B-splines work.
            "fur": {"type": "bsplinecurve", "filename": f"{folder}/{ball}.txt", "bsdf": hair},
        }
    )


def sensor(view, width, height):
    film = {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    return mi.load_dict(
        {
            "type": "perspective",
            "fov": scene.VIEWS[view],
            "fov_axis": "y",
            "to_world": place(scene.EYE, scene.TARGET),
            "film": film,
            "sampler": {"type": "independent"},
        }
    )


clock = worker.Clock()
world = load()
if "llvm" in variant:
    import drjit as dr

    dr.eval()
    dr.sync_thread()
worker.answer(ANSWER, load=clock.seconds(), memory=worker.memory())
worker.serve(ANSWER, world, lambda request: sensor(request["view"], *request["size"]))
