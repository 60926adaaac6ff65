"""Mitsuba 3 with a built-in scene, as a long-running process: like mitsuba_worker.py.

usage: built_in_mitsuba.py VARIANT SCENES NAME
"""

import sys

import worker

ANSWER = worker.begin()

import mitsuba as mi
import numpy as np
from pxr import Usd, UsdGeom, UsdLux

import scene
from usd_scenes import ABSORPTION, environment, matrix, radiance, strands, triangles

variant, folder, name = sys.argv[1], sys.argv[2], sys.argv[3]
mi.set_variant(variant)
rgb = lambda value: {"type": "rgb", "value": [float(x) for x in value]}
# Mitsuba's rectangles and cameras face +z, those of USD −z.
TURN = np.diag([-1.0, 1.0, -1.0, 1.0])
HAIR = {
    "type": "hair",
    "sigma_a": rgb(ABSORPTION[name]),
    "longitudinal_roughness": scene.ROUGHNESS,
    "azimuthal_roughness": scene.ROUGHNESS,
    "scale_tilt": scene.TILT,
    "int_ior": scene.IOR,
    "ext_ior": 1.0,
}


def transform(values):
    return mi.ScalarTransform4f(values)


def curves(prim, place, count=[0]):
    """B-splines in a file of text, the only format that Mitsuba reads."""
    counts, rows = strands(prim, place)
    count[0] += 1
    path = f"{folder}/{name}-{count[0]}.txt"
    with open(path, "w") as file:
        start = 0
        for vertices in counts:
            file.write(("%.7g %.7g %.7g %.7g\n" * vertices + "\n") % tuple(rows[start : start + vertices].ravel()))
            start += vertices
    return {"type": "bsplinecurve", "filename": path, "bsdf": HAIR}


def mesh(prim, place):
    points, faces, color = triangles(prim, place)
    properties = mi.Properties()
    # Mitsuba's diffuse surfaces are black from behind.
    properties["bsdf"] = mi.load_dict({"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": rgb(color)}})
    result = mi.Mesh(str(prim.GetName()), len(points), len(faces), has_vertex_normals=False, props=properties)
    values = mi.traverse(result)
    values["vertex_positions"] = points.astype(np.float32).ravel()
    values["faces"] = faces.astype(np.uint32).ravel()
    values.update()
    return result


def shape(prim, place):
    if prim.IsA(UsdGeom.BasisCurves):
        return curves(prim, place)
    return mesh(prim, place) if prim.IsA(UsdGeom.Mesh) else None


def light(prim, place):
    color = radiance(prim)
    if prim.IsA(UsdLux.DomeLight):
        if file := environment(prim):
            # The built-in scenes have white as the colour of images.
            return {"type": "envmap", "filename": file, "to_world": transform(place), "scale": color[0]}
        return {"type": "constant", "radiance": rgb(color)}
    rect = UsdLux.RectLight(prim)
    size = np.diag([rect.GetWidthAttr().Get() / 2, rect.GetHeightAttr().Get() / 2, 1.0, 1.0])
    emitter = {"type": "area", "radiance": rgb(color)}
    return {"type": "rectangle", "to_world": transform(place @ TURN @ size), "emitter": emitter}


def load(stage):
    # A depth of 1 is light that the camera sees directly.
    path = {"type": "path", "max_depth": scene.MANY + 1, "rr_depth": scene.ROULETTE}
    parts = {"type": "scene", "integrator": path}
    add = lambda part: parts.__setitem__(f"part{len(parts)}", part)
    groups = {}
    for prototype in stage.GetPrototypes():
        inside = [shape(prim, matrix(prim)) for prim in Usd.PrimRange(prototype)]
        members = {f"shape{i}": part for i, part in enumerate(inside) if part}
        groups[prototype.GetPath()] = f"group{len(groups)}"
        parts[groups[prototype.GetPath()]] = {"type": "shapegroup"} | members
    camera = None
    for prim in stage.Traverse():
        if prim.IsInstance():
            group = {"type": "ref", "id": groups[prim.GetPrototype().GetPath()]}
            add({"type": "instance", "to_world": transform(matrix(prim)), "group": group})
        elif prim.IsA(UsdGeom.Camera):
            camera = prim
        elif prim.HasAPI(UsdLux.LightAPI):
            add(light(prim, matrix(prim)))
        elif part := shape(prim, matrix(prim)):
            add(part)
    return camera, mi.load_dict(parts)


def sensor(prim, width, height):
    film = {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    camera = UsdGeom.Camera(prim)
    half = camera.GetHorizontalApertureAttr().Get() / 2 / camera.GetFocalLengthAttr().Get()
    return mi.load_dict(
        {
            "type": "perspective",
            "fov": float(np.degrees(2 * np.arctan(half))),
            "fov_axis": "x",
            "to_world": transform(matrix(prim) @ TURN),
            "near_clip": 0.1,
            "far_clip": 1e5,
            "film": film,
            "sampler": {"type": "independent"},
        }
    )


clock = worker.Clock()
stage = Usd.Stage.Open(f"{folder}/{name}.usdc")
camera, world = load(stage)
if "llvm" in variant:
    import drjit as dr

    dr.eval()
    dr.sync_thread()
worker.answer(ANSWER, load=clock.seconds(), memory=worker.memory())
worker.serve(ANSWER, world, lambda request: sensor(camera, *request["size"]))
