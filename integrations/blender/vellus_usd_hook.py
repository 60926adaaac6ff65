"""Writes the hair materials of Blender as VellusFur when Blender exports USD.

Run this file in Blender before an export (Text Editor, Run Script), or put it into the folder scripts/startup.
`vellus render` then reads the material. The extension `vellus_blender` contains this file.

Two nodes are read: the group "Vellus Fur" of the extension, and Principled Hair BSDF. Custom properties of the
material set what Principled Hair lacks:

    vellus:preset = "red-fox"    the fibre that the other inputs change
    vellus:kappa = 0.8           any parameter that `vellus fiber parameters` lists, in its unit
"""

import math
import sys
from dataclasses import dataclass, field
from pathlib import Path

import bpy
import numpy as np

try:
    # Usd must be loaded before Blender passes a stage to the hook, or Blender aborts.
    from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt  # noqa: F401
except ImportError:
    # In the Python package bpy, unlike in Blender, the bundled OpenUSD is not on the path.
    version = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    sys.path.append(str(Path(bpy.utils.resource_path("LOCAL")) / "python/lib" / version / "site-packages"))
    from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt  # noqa: F401

# Pigments per unit of concentration (d'Eon et al. 2011), which Blender uses.
EUMELANIN = (0.506, 0.841, 1.653)
PHEOMELANIN = (0.343, 0.733, 1.924)

GROUP = "Vellus Fur"

# The inputs of the group, by parameter. Angles are in degrees.
SOCKETS = {
    "reflectance": "Color",
    "sigma_ca": "Absorption",
    "kappa": "Medulla",
    "sigma_ms": "Medulla Scattering",
    "sigma_ma": "Medulla Absorption",
    "g": "Medulla Anisotropy",
    "medulla_pigment": "Medulla Pigment",
    "eta": "IOR",
    "alpha": "Cuticle Angle",
    "layers": "Cuticle Layers",
    "beta_m": "Roughness Along",
    "beta_n": "Roughness Around",
    "wet": "Wetness",
    "aspect_ratio": "Aspect Ratio",
}
# A part of the strands' shape: one number for a look.
FIXED = {"aspect_ratio"}
# Vellus' lowest ratio of axes.
FLATTEST = 0.4
USE_COLOR = "Use Color"


@dataclass
class Look:
    """What a hair material says.

    `values` has constants by parameter, and perhaps `preset`. `images` has images, and `attributes` has names of
    attributes, by parameter. `random` has the strengths of random colour and roughness of Principled Hair, and
    `melanin` its input Melanin and the absorption by the pigments alone, which the random colour changes. Absorption
    in images and attributes gets the factor `absorption_factor`.
    """

    values: dict = field(default_factory=dict)
    images: dict = field(default_factory=dict)
    attributes: dict = field(default_factory=dict)
    random: tuple = (0.0, 0.0)
    melanin: tuple = None
    absorption_factor: float = 1.0
    node: object = None
    warnings: list = field(default_factory=list)


def absorption_of_color(color, radial):
    """Absorption per radius, by the fit of Chiang et al. 2016 (section 4.2)."""
    fit = absorption_scale(radial)
    return [(math.log(min(max(c, 1e-3), 1.0)) / fit) ** 2 for c in color[:3]]


def absorption_scale(b):
    """The denominator of the fit, for a radial roughness."""
    return 5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5


def ratio_of_axes(node):
    """The shorter axis of the section over the longer one. Only the model Huang has it."""
    if node.model != "HUANG":
        return 1.0
    value = constant(node.inputs["Aspect Ratio"])
    # Above 1, Cycles exchanges the axes.
    return 1 / value if value > 1 else value


def absorption_factor(node):
    """What Vellus multiplies an absorption of Cycles by.

    In Cycles it is per half of the longer axis, in Vellus per radius of the circle of the same area.
    """
    return math.sqrt(max(ratio_of_axes(node), FLATTEST))


def melanin_absorption(node):
    """Absorption of the pigments alone, as in Cycles."""
    amount = -math.log(max(1 - node.inputs["Melanin"].default_value, 1e-4))
    redness = node.inputs["Melanin Redness"].default_value
    return [amount * ((1 - redness) * e + redness * p) for e, p in zip(EUMELANIN, PHEOMELANIN)]


def absorption(node, radial):
    """Absorption of the parametrization that the node has."""
    if node.parametrization == "ABSORPTION":
        found = list(node.inputs["Absorption Coefficient"].default_value)[:3]
    elif node.parametrization == "COLOR":
        found = absorption_of_color(constant(node.inputs["Color"]), radial)
    else:
        tint = absorption_of_color(constant(node.inputs["Tint"]), radial)
        found = [m + t for m, t in zip(melanin_absorption(node), tint)]
    return [x * absorption_factor(node) for x in found]


def roughness_of(along, radial):
    """β_m and β_n in degrees, of the two roughnesses of Chiang et al. 2016."""
    beta_m = 0.726 * along + 0.812 * along**2 + 3.7 * along**20
    scale = 0.265 * radial + 1.194 * radial**2 + 5.372 * radial**22
    # A logistic distribution of scale s has the variance pi^2 s^2 / 3. TT passes Vellus' roughness twice.
    beta_n = math.pi * math.sqrt(math.pi / 8) * scale / math.sqrt(6)
    return math.degrees(beta_m), math.degrees(beta_n)


def roughness_inputs(node):
    """Both roughnesses of a Principled Hair. The model Huang has one, that of a microfacet surface."""
    along = node.inputs["Roughness"].default_value
    return along, node.inputs["Radial Roughness"].default_value if node.model == "CHIANG" else along


def parameters(node):
    """Parameters of Principled Hair. Angles are in degrees. The model Huang gets the formulas of the model Chiang."""
    along, radial = roughness_inputs(node)
    beta_m, beta_n = roughness_of(along, radial)
    return {
        "eta": node.inputs["IOR"].default_value,
        # R turns towards the root by twice the offset.
        "alpha": math.degrees(2 * node.inputs["Offset"].default_value),
        "beta_m": min(max(beta_m, 0.1), 90.0),
        "beta_n": min(max(beta_n, 0.1), 90.0),
        "sigma_ca": absorption(node, radial),
    }


def source(socket):
    """The node that feeds an input, past reroutes. `None` if nothing does."""
    while socket.is_linked and socket.links[0].from_node.bl_idname == "NodeReroute":
        socket = socket.links[0].from_node.inputs[0]
    return socket.links[0].from_node if socket.is_linked else None


def constant(socket):
    """The value of an input: its own, or that of an RGB or Value node."""
    node = source(socket)
    if node and node.bl_idname in {"ShaderNodeRGB", "ShaderNodeValue"}:
        socket = node.outputs[0]
    value = socket.default_value
    return list(value) if hasattr(value, "__len__") else value


def connections(look, socket, parameter):
    """Adds what feeds an input: an image or an attribute, or a warning."""
    node = source(socket)
    if node is None or node.bl_idname in {"ShaderNodeRGB", "ShaderNodeValue"}:
        return
    if node.bl_idname == "ShaderNodeTexImage" and node.image and parameter:
        look.images[parameter] = node.image
    elif node.bl_idname == "ShaderNodeAttribute" and node.attribute_type == "GEOMETRY" and parameter:
        look.attributes[parameter] = node.attribute_name
    else:
        what = f"{socket.name} is connected to {node.bl_label or node.name}: only its constant is used"
        look.warnings.append(what)


def output_node(tree):
    """The active output of a node tree, or `None`."""
    return (tree.get_output_node("CYCLES") or tree.get_output_node("ALL")) if tree else None


def surface_node(material):
    """The node that is connected to the surface of the active output, or `None`."""
    output = output_node(material.node_tree) if material else None
    return source(output.inputs["Surface"]) if output else None


def is_fur(node):
    """Whether a node is the group Vellus Fur."""
    group = node.node_tree if node and node.bl_idname == "ShaderNodeGroup" else None
    return bool(group) and group.name.startswith(GROUP)


def hair_node(material):
    """The Principled Hair BSDF or the group Vellus Fur that is connected to the active output."""
    node = surface_node(material)
    return node if node and (node.bl_idname == "ShaderNodeBsdfHairPrincipled" or is_fur(node)) else None


def read_fur(look, node):
    """Reads the group Vellus Fur."""
    color = bool(constant(node.inputs[USE_COLOR]))
    for parameter, name in SOCKETS.items():
        if parameter in ({"sigma_ca", "sigma_ma"} if color else {"reflectance", "medulla_pigment"}):
            continue
        value = constant(node.inputs[name])
        if parameter == "reflectance":
            value = [min(max(c, 0.001), 0.999) for c in value[:3]]
        look.values[parameter] = value
        connections(look, node.inputs[name], None if parameter in FIXED else parameter)


def read_principled(look, node):
    """Reads Principled Hair BSDF."""
    look.values.update(parameters(node))
    look.absorption_factor = absorption_factor(node)
    targets = {"Absorption Coefficient": "sigma_ca", "Color": "hair_reflectance", "IOR": "eta"}
    for socket in node.inputs:
        if socket.enabled:
            connections(look, socket, targets.get(socket.name))
    inputs = node.inputs
    if node.parametrization == "MELANIN":
        pigments = [x * look.absorption_factor for x in melanin_absorption(node)]
        look.melanin = (inputs["Melanin"].default_value, pigments)
    random_color = inputs["Random Color"].default_value if node.parametrization == "MELANIN" else 0.0
    look.random = (random_color, inputs["Random Roughness"].default_value)
    if node.model == "HUANG":
        ratio = ratio_of_axes(node)
        if ratio < FLATTEST:
            value = constant(inputs["Aspect Ratio"])
            look.warnings.append(f"Aspect Ratio {value:g} is flatter than {FLATTEST}, which is used instead")
        look.values["aspect_ratio"] = max(ratio, FLATTEST)
        look.warnings.append("the model Huang is mapped to the formulas of Chiang")
        for lobe in ("Reflection", "Transmission", "Secondary Reflection"):
            if inputs[lobe].default_value != 1:
                look.warnings.append(f"the strength of {lobe} is ignored")
    elif inputs["Coat"].default_value != 0:
        look.warnings.append("Coat is ignored")


def look_of(material):
    """What a hair material says, or `None` for other materials."""
    node = hair_node(material)
    if node is None:
        return None
    look = Look(node=node)
    (read_fur if is_fur(node) else read_principled)(look, node)
    own = {}
    for key in material.keys():
        if key.startswith("vellus:"):
            value = material[key]
            name = key.removeprefix("vellus:")
            own[name] = value if isinstance(value, (str, int, float)) else list(value)
            if isinstance(own[name], list) and len(own[name]) not in (1, 2, 3):
                look.warnings.append(f"{key} must have 1, 2 or 3 numbers")
                del own[name]
    if is_fur(node):
        # The inputs of the group have all parameters of the preset.
        own.pop("preset", None)
    elif node.parametrization == "COLOR" and ("preset" in own or "kappa" in own):
        # With a medulla, the colour needs Vellus' own inversion.
        del look.values["sigma_ca"]
        color = [min(max(c, 0.001), 0.999) for c in constant(node.inputs["Color"])[:3]]
        look.values["reflectance"] = color
        if "hair_reflectance" in look.images:
            look.images["reflectance"] = look.images.pop("hair_reflectance")
    elif "hair_reflectance" in look.images or "hair_reflectance" in look.attributes:
        del look.values["sigma_ca"]
    if any(name in own for name in ("reflectance", "melanin", "hair_reflectance")):
        for name in ("sigma_ca", "reflectance"):
            look.values.pop(name, None)
    look.values.update(own)
    return look


def is_flat(values):
    """Whether the values of a look make fibres that are not round."""
    return values.get("aspect_ratio", 1.0) != 1.0


def shorter_axes(curves):
    """The direction of the shorter axis at each point of evaluated hair curves, (n, 3).

    In Cycles the normals of curves are the longer axis.
    """
    offsets = np.empty(len(curves.curve_offset_data), np.int32)
    curves.curve_offset_data.foreach_get("value", offsets)
    points = np.empty((len(curves.position_data), 3), np.float32)
    curves.position_data.foreach_get("vector", points.ravel())
    counts, each = np.diff(offsets), np.arange(len(points))
    before = np.maximum(each - 1, np.repeat(offsets[:-1], counts))
    after = np.minimum(each + 1, np.repeat(offsets[1:] - 1, counts))
    # foreach_get would read memory that Blender has freed: it makes the normals when they are asked for.
    longer = np.array([normal.vector[:] for normal in curves.normals], np.float32).reshape(-1, 3)
    with np.errstate(invalid="ignore"):
        axes = np.cross(points[after] - points[before], longer)
        length = np.linalg.norm(axes, axis=1, keepdims=True)
        return np.nan_to_num(axes / np.where(length > 0, length, 1))


def write_value(shader, name, value):
    """Creates an input with a constant."""
    if isinstance(value, str):
        shader.CreateInput(name, Sdf.ValueTypeNames.Token).Set(value)
    elif isinstance(value, list) and len(value) > 1:
        kind = Sdf.ValueTypeNames.Float2 if len(value) == 2 else Sdf.ValueTypeNames.Color3f
        shader.CreateInput(name, kind).Set(Gf.Vec2f(*value) if len(value) == 2 else Gf.Vec3f(*value))
    else:
        number = value[0] if isinstance(value, list) else value
        shader.CreateInput(name, Sdf.ValueTypeNames.Float).Set(float(number))


COLORS = {"reflectance", "hair_reflectance", "sigma_ca", "sigma_ma"}


def connect(stage, shader, name, node_id, inputs):
    """Connects an input to a new shader that reads an image or a primvar."""
    is_color = name in COLORS
    path = shader.GetPath().AppendChild(f"{name}_source")
    reader = UsdShade.Shader.Define(stage, path)
    reader.CreateIdAttr(node_id)
    for key, (kind, value) in inputs.items():
        reader.CreateInput(key, kind).Set(value)
    kind = Sdf.ValueTypeNames.Color3f if is_color else Sdf.ValueTypeNames.Float
    port = ("rgb" if is_color else "r") if node_id == "UsdUVTexture" else "result"
    shader.CreateInput(name, kind).ConnectToSource(reader.CreateOutput(port, kind))


def write_normals(prim, owner, depsgraph):
    """Gives the curves of an object their normals, the shorter axes, if its look is flat."""
    material = owner.material_slots[0].material if len(owner.material_slots) else None
    look, points = look_of(material), prim.GetPointsAttr()
    # The depsgraph is at one frame.
    if look is None or not is_flat(look.values) or points.ValueMightBeTimeVarying():
        return
    axes = shorter_axes(owner.evaluated_get(depsgraph).data)
    # Curves of Bézier have more points in USD.
    if len(axes) == len(points.Get()):
        prim.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(axes))
        prim.SetNormalsInterpolation("vertex")


class VellusUsdHook(bpy.types.USDHook):
    """Writes hair materials as VellusFur."""

    bl_idname = "vellus_usd_hook"
    bl_label = "Vellus"
    bl_description = "Writes Vellus Fur and Principled Hair BSDF as VellusFur, which vellus reads"

    @staticmethod
    def on_material_export(context, material, usd_material):
        look = look_of(material)
        if look is None:
            return True
        for warning in look.warnings:
            print(f"vellus: {material.name}: {warning}")
        if any(look.random):
            print(f"vellus: {material.name}: random colour and roughness are not written")
        unscaled = "hair_reflectance" in look.images or {"hair_reflectance", "sigma_ca"} & set(look.attributes)
        if unscaled and look.absorption_factor != 1:
            print(f"vellus: {material.name}: attributes and images of colours make flat hair darker than in Cycles")
        stage = context.get_stage()
        shader = UsdShade.Shader.Define(stage, usd_material.GetPath().AppendChild("VellusFur"))
        shader.CreateIdAttr("VellusFur")
        for name, value in look.values.items():
            if name not in look.images and name not in look.attributes:
                write_value(shader, name, value)
        kinds = Sdf.ValueTypeNames
        for name, image in look.images.items():
            raw = image.colorspace_settings.name in {"Non-Color", "Linear Rec.709"}
            inputs = {
                "file": (kinds.Asset, bpy.path.abspath(image.filepath, library=image.library)),
                "sourceColorSpace": (kinds.Token, "raw" if raw else "auto"),
                "wrapS": (kinds.Token, "repeat"),
                "wrapT": (kinds.Token, "repeat"),
            }
            if name == "sigma_ca" and look.absorption_factor != 1:
                inputs["scale"] = (kinds.Float4, Gf.Vec4f(*[look.absorption_factor] * 3, 1))
            connect(stage, shader, name, "UsdUVTexture", inputs)
        for name, attribute in look.attributes.items():
            reader = "UsdPrimvarReader_float3" if name in COLORS else "UsdPrimvarReader_float"
            connect(stage, shader, name, reader, {"varname": (kinds.String, attribute)})
        output = shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
        usd_material.CreateSurfaceOutput("vellus").ConnectToSource(output)
        return True

    @staticmethod
    def on_export(context):
        # Older versions of Blender do not say which object a prim is of.
        prims = context.get_prim_map() if hasattr(context, "get_prim_map") else {}
        for path, made_of in prims.items():
            curves = UsdGeom.BasisCurves(context.get_stage().GetPrimAtPath(path))
            for owner in [*made_of, *prims.get(path.GetParentPath(), ())] if curves else ():
                if isinstance(owner, bpy.types.Object) and owner.type == "CURVES":
                    write_normals(curves, owner, context.get_depsgraph())
        return True


def register():
    bpy.utils.register_class(VellusUsdHook)


def unregister():
    bpy.utils.unregister_class(VellusUsdHook)


if __name__ == "__main__":
    register()
