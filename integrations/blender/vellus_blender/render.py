"""Renders a `Description` with the package vellus."""

import math
import zlib

import numpy as np
import vellus

from .extract import Problem
from .hook import FIXED, roughness_of

# Ranges of the roughnesses, in degrees.
ROUGHNESS = {"beta_m": (0.1, 90.0), "beta_n": (0.1, 90.0)}


def fiber_of(values):
    """The fibre of constants: `preset` and parameters."""
    values = dict(values)
    preset = values.pop("preset", None)
    known = {name: value for name, value in values.items() if value is not None}
    try:
        return vellus.Fiber(preset, **known) if preset else vellus.Fiber(**known)
    except (ValueError, TypeError) as error:
        raise Problem(f"A look is not valid: {error}") from error


def random_parameters(look, name, count):
    """Parameters per strand of the random inputs of Principled Hair, as Cycles computes them."""
    strength_color, strength_roughness = look["random"]
    if not (strength_color or strength_roughness):
        return {}
    # The same numbers in each frame.
    numbers = np.random.default_rng(zlib.crc32(name.encode())).random(count)
    out = {}
    if strength_color and look["melanin"]:
        amount, pigments = look["melanin"]
        factor = 1 + 2 * (numbers - 0.5) * min(strength_color, 1.0)
        before = max(-np.log(max(1 - amount, 1e-4)), 1e-6)
        ratio = -np.log(np.maximum(1 - amount * factor, 1e-4)) / before
        tint = np.array(look["values"]["sigma_ca"]) - pigments
        out["sigma_ca"] = (ratio[:, None] * np.array(pigments) + tint).astype(np.float32)
    if strength_roughness:
        along, radial = look["roughness"]
        factor = 1 + 2 * (numbers - 0.5) * min(strength_roughness, 1.0)
        angles = np.array([roughness_of(min(along * f, 1.0), min(radial * f, 1.0)) for f in factor], np.float32)
        for i, (parameter, (low, high)) in enumerate(ROUGHNESS.items()):
            out[parameter] = np.clip(angles[:, i], low, high)
    return out


def as_in_cycles(parameter, values, factor):
    """Values of an attribute that give the absorption of Cycles times a factor."""
    if parameter == "sigma_ca":
        return values * factor
    # The absorption of a colour is the square of its logarithm.
    return np.maximum(values, 0) ** np.sqrt(factor) if parameter == "hair_reflectance" else values


def parameters_of(part, look, warn):
    """Parameters of strands by name: attributes `vellus:NAME`, those that the material reads, and random ones."""
    out = random_parameters(look, part["name"], len(part["counts"]))
    table = vellus.parameters()
    for name, (_, values) in part["attributes"].items():
        parameter = name.removeprefix("vellus:") if name.startswith("vellus:") else look["attributes"].get(name)
        if parameter not in table:
            warn(f"{part['name']}: {name} is no parameter of a fibre, and is ignored")
            continue
        if parameter in FIXED:
            warn(f"{part['name']}: {name} cannot vary between strands, and is ignored")
            continue
        channels = table[parameter]["channels"]
        if channels > 1 and values.ndim == 1:
            values = np.repeat(values[:, None], channels, 1)
        elif channels == 1 and values.ndim > 1:
            values = values[:, 0]
        if not name.startswith("vellus:"):
            values = as_in_cycles(parameter, values, look["absorption_factor"])
        low, high = table[parameter]["range"]
        limited = np.clip(np.nan_to_num(values), low, high)
        if not np.array_equal(limited, values):
            warn(f"{part['name']}: {name} has values outside [{low:g}, {high:g}]: the nearest ones are used")
        out[parameter] = np.ascontiguousarray(limited[..., :channels] if channels > 1 else limited, np.float32)
    return out


def lights_to(scene, description):
    """Adds the lights."""
    for light in description.lights:
        emission = next(light[key] for key in ("radiance", "intensity", "irradiance") if key in light)
        settings = {"group": light["group"], "visible": light["visible"]}
        if light.get("image"):
            settings["texture"] = texture_of(scene, light["image"])
        for name, key in (("matrix", "to_world"), ("position", "center"), ("position", "position")):
            if key in light:
                settings[name] = light[key]
        for key in ("direction", "radius"):
            if key in light:
                settings[key] = light[key]
        if "rotation" in light:
            settings["matrix"] = np.eye(4)
            settings["matrix"][:3, :3] = light["rotation"]
        if "half_angle" in light:
            settings["angle"] = math.degrees(light["half_angle"])
        if light["shaping"]:
            settings["axis"] = light["shaping"]["axis"]
            settings["cone"] = math.degrees(light["shaping"]["cone"])
            settings["softness"] = light["shaping"]["softness"]
        scene.add_light(light["kind"], emission, **settings)


def texture_of(scene, image):
    """Adds an image as a texture."""
    return scene.add_texture(image["pixels"], wrap=image["wrap"], name=image["name"])


def geometry_to(scene, things, looks, surfaces, description, prototype=None):
    """Adds the strands and meshes of a dict or a description."""
    for part in things["strands"]:
        look = description.looks[part["look"]]
        scene.add_strands(
            part["points"],
            part["counts"],
            part["radii"],
            look=looks[part["look"]],
            basis=part["basis"],
            normals=part["normals"],
            uv=part["uv"],
            moved=part["moved"],
            parameters=parameters_of(part, look, description.warn),
            name=part["name"],
            prototype=prototype,
        )
    for part in things["meshes"]:
        scene.add_mesh(
            part["points"],
            part["triangles"],
            surface=surfaces[part["surface"]],
            normals=part["normals"],
            uv=part["uv"],
            moved=part["moved"],
            name=part["name"],
            prototype=prototype,
        )


def scene_of(description, transparent):
    """The `vellus.Scene` of a description."""
    scene = vellus.Scene()
    looks, surfaces = {}, {}
    for name, look in description.looks.items():
        textures = {parameter: scene.add_texture(pixels) for parameter, pixels in look["images"].items()}
        looks[name] = scene.add_look(fiber_of(look["values"]), name=look["name"], textures=textures)
    for name, surface in description.surfaces.items():
        texture = texture_of(scene, surface["image"]) if surface["image"] else None
        keys = ("color", "emission", "roughness", "metallic", "ior", "name")
        surfaces[name] = scene.add_surface(texture=texture, **{key: surface[key] for key in keys})
    whole = {"strands": description.strands, "meshes": description.meshes}
    geometry_to(scene, whole, looks, surfaces, description)
    for prototype in description.prototypes:
        index = prototype["index"] = scene.add_prototype(prototype["name"])
        geometry_to(scene, prototype, looks, surfaces, description, index)
    for index, matrix in description.instances:
        scene.add_instance(description.prototypes[index]["index"], matrix)
    lights_to(scene, description)
    camera = description.camera
    scene.set_camera(
        camera["matrix"],
        fov=math.degrees(2 * math.atan(0.5 * camera["film_height"])),
        focus_distance=camera["focus_distance"],
        aperture=camera["aperture"],
        moved=camera.get("moved"),
    )
    if transparent:
        scene.background = 0.0
    return scene


def run(scene, size, crop, layers, options, show):
    """Renders a picture. `show(picture, done, text)` returns whether to go on."""
    settings = {"mode": options["mode"], "seed": options["seed"], "crop": crop}
    for name in ("noise", "time", "denoise"):
        if options.get(name):
            settings[name] = options[name]

    def callback(state):
        return show(state.picture(), state.done, f"{state.samples} of {state.total} samples")

    layers = ["beauty", "alpha", *layers]
    return scene.render(*size, options["samples"], layers=layers, callback=callback, interval=0.5, **settings)
