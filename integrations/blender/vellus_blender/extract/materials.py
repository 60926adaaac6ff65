"""Surfaces of meshes, from the nodes of their materials."""

from .. import hook
from .images import pixels, wrap_of

GREY = {
    "color": (0.8, 0.8, 0.8),
    "image": None,
    "emission": (0.0, 0.0, 0.0),
    "roughness": 1.0,
    "metallic": 0.0,
    "ior": 1.0,
}


def unit(x):
    return min(max(float(x), 0.0), 1.0)


def number(node, name, warn):
    """A constant input. A connection gives a warning."""
    socket = node.inputs[name]
    feeder = hook.source(socket)
    if feeder and feeder.bl_idname not in {"ShaderNodeRGB", "ShaderNodeValue"}:
        warn(f"{name} is connected to {feeder.bl_label}: only its constant is used")
    return hook.constant(socket)


def color(surface, node, name, warn):
    """Colour and image of an input."""
    feeder = hook.source(node.inputs[name])
    if feeder and feeder.bl_idname == "ShaderNodeTexImage":
        if feeder.image is None:
            warn(f"{name} has an image texture without an image")
        elif (image := pixels(feeder.image, warn)) is not None:
            surface["image"] = {"name": feeder.image.name_full, "pixels": image, "wrap": wrap_of(feeder)}
            surface["color"] = (1.0, 1.0, 1.0)
            if hook.source(feeder.inputs["Vector"]) is not None:
                warn("texture coordinates other than the active uv map are ignored")
        return
    surface["color"] = tuple(unit(c) for c in number(node, name, warn)[:3])


IGNORED = {
    "Alpha": 1.0,
    "Subsurface Weight": 0.0,
    "Transmission Weight": 0.0,
    "Coat Weight": 0.0,
    "Sheen Weight": 0.0,
    "Anisotropic": 0.0,
}


MOST_IOR = 4.0


def coat_ior(ior, level):
    """The index of refraction whose reflectance at normal incidence is 2 * level times that of `ior`.

    So the manual of Blender defines the input Specular IOR Level: 0.5 changes nothing, 0 removes the reflection.
    """
    ior = min(max(ior, 1.0), MOST_IOR)
    root = (ior - 1.0) / (ior + 1.0) * max(2.0 * level, 0.0) ** 0.5
    most = (MOST_IOR - 1.0) / (MOST_IOR + 1.0)
    root = min(root, most)
    return (1.0 + root) / (1.0 - root)


def principled(surface, node, warn):
    """Principled BSDF: base colour, roughness, metallic, index, its level, and emission."""
    color(surface, node, "Base Color", warn)
    surface["roughness"] = unit(number(node, "Roughness", warn))
    surface["metallic"] = unit(number(node, "Metallic", warn))
    level = float(number(node, "Specular IOR Level", warn))
    surface["ior"] = coat_ior(float(number(node, "IOR", warn)), level)
    tint = node.inputs["Specular Tint"]
    if tint.is_linked or any(channel != 1.0 for channel in tuple(tint.default_value)[:3]):
        warn("Specular Tint is ignored")
    strength = number(node, "Emission Strength", warn)
    if strength:
        surface["emission"] = tuple(max(strength * c, 0.0) for c in number(node, "Emission Color", warn)[:3])
    for name, neutral in IGNORED.items():
        if node.inputs[name].is_linked or node.inputs[name].default_value != neutral:
            warn(f"{name} is ignored")


def surface_of(material, warn_scene):
    """The surface of a material: a dict with the keys of `GREY`, and `name`."""
    surface = {**GREY, "name": material.name_full if material else "grey"}
    if material is None:
        return surface

    def warn(what):
        warn_scene(f"{material.name}: {what}")

    node = hook.surface_node(material)
    kind = node.bl_idname if node else None
    if kind == "ShaderNodeBsdfPrincipled":
        principled(surface, node, warn)
    elif kind == "ShaderNodeBsdfDiffuse":
        color(surface, node, "Color", warn)
    elif kind in {"ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic"}:
        color(surface, node, "Color", warn)
        surface.update(metallic=1.0, roughness=unit(number(node, "Roughness", warn)))
    elif kind == "ShaderNodeEmission":
        strength = number(node, "Strength", warn)
        surface["color"] = (0.0, 0.0, 0.0)
        surface["emission"] = tuple(max(strength * c, 0.0) for c in number(node, "Color", warn)[:3])
    elif kind is None:
        surface["color"] = (0.0, 0.0, 0.0)
        warn("no shader is connected to its output: it is black")
    else:
        warn(f"{node.bl_label or node.name} is not supported: the surface is grey")
    return surface
