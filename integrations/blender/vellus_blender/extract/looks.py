"""Looks of strands, from their materials."""

import numpy as np

from .. import hook
from .images import pixels
from .materials import surface_of

# Hair without a hair material gets this fibre, as in `vellus render`.
DEFAULT = {"preset": "red-fox"}
NO_MATERIAL = "fur without a material"


def image_of(image, parameter, look, warn):
    """The pixels of an image, converted to the parameter: (parameter, pixels), or `None`."""
    found = pixels(image, warn)
    if found is None:
        return None
    if parameter == "hair_reflectance":
        scale = hook.absorption_scale(hook.roughness_inputs(look.node)[1])
        parameter, found = "sigma_ca", (np.log(np.clip(found, 1e-3, 1)) / scale) ** 2
    return parameter, found * look.absorption_factor if parameter == "sigma_ca" else found


def read_look(material, warn_scene):
    """The look of strands with this material: a dict with `name`, `values`, `images` and so on."""
    name = material.name_full if material else NO_MATERIAL
    out = {"name": name, "values": dict(DEFAULT), "images": {}, "attributes": {}}
    out.update(random=(0, 0), melanin=None, absorption_factor=1.0)
    if material is None:
        warn_scene("hair without a material gets the fibre red-fox: add the node Vellus Fur or Principled Hair BSDF")
        return out

    def warn(what):
        warn_scene(f"{material.name}: {what}")

    look = hook.look_of(material)
    if look is None:
        surface = surface_of(material, warn_scene)
        warn("hair needs the node Vellus Fur or Principled Hair BSDF: only the colour of this material is used")
        # A surface may be black or white, a coat not quite.
        out["values"] = {"reflectance": [min(max(c, 0.001), 0.999) for c in surface["color"]]}
        if surface["image"]:
            out["images"] = {"reflectance": surface["image"]["pixels"]}
        return out
    for what in look.warnings:
        warn(what)
    out.update(values=dict(look.values), random=look.random, melanin=look.melanin)
    out["absorption_factor"] = look.absorption_factor
    if look.node.bl_idname == "ShaderNodeBsdfHairPrincipled":
        out["roughness"] = hook.roughness_inputs(look.node)
    for parameter, image in look.images.items():
        found = image_of(image, parameter, look, warn)
        if found:
            out["images"][found[0]] = found[1]
        elif parameter == "hair_reflectance":
            out["values"]["sigma_ca"] = hook.absorption(look.node, hook.roughness_inputs(look.node)[1])
    out["attributes"] = {attribute: parameter for parameter, attribute in look.attributes.items()}
    return out
