"""Writes Blender's Principled Hair BSDF as VellusFur when Blender exports USD.

Run this file in Blender before an export (Text Editor, Run Script), or put it into the folder scripts/startup.
`vellus render` then reads the material. Custom properties of the material set what Principled Hair lacks:

    vellus:preset = "red-fox"    the fibre that the other inputs change
    vellus:kappa = 0.8           any parameter that `vellus fiber parameters` lists, in its unit
"""

import math

import bpy

# Usd must be loaded before Blender passes a stage to the hook, or Blender aborts.
from pxr import Gf, Sdf, Usd, UsdShade  # noqa: F401

# Pigments per unit of concentration (d'Eon et al. 2011), which Blender uses.
EUMELANIN = (0.506, 0.841, 1.653)
PHEOMELANIN = (0.343, 0.733, 1.924)


def absorption_of_color(color, radial):
    """Absorption per radius, by the fit of Chiang et al. 2016 (section 4.2)."""
    b = radial
    fit = 5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5
    return [(math.log(min(max(c, 1e-3), 1.0)) / fit) ** 2 for c in color[:3]]


def absorption(node, radial):
    """Absorption per radius, of the parametrization that the node has."""
    if node.parametrization == "ABSORPTION":
        return list(node.inputs["Absorption Coefficient"].default_value)[:3]
    if node.parametrization == "COLOR":
        return absorption_of_color(node.inputs["Color"].default_value, radial)
    amount = -math.log(max(1 - node.inputs["Melanin"].default_value, 1e-4))
    redness = node.inputs["Melanin Redness"].default_value
    tint = absorption_of_color(node.inputs["Tint"].default_value, radial)
    return [amount * ((1 - redness) * e + redness * p) + t for e, p, t in zip(EUMELANIN, PHEOMELANIN, tint)]


def parameters(node):
    """Inputs of VellusFur. Angles are in degrees.

    The model Huang has one roughness, that of a microfacet surface. It gets the formulas of the model Chiang.
    """
    along = node.inputs["Roughness"].default_value
    radial = node.inputs["Radial Roughness"].default_value if node.model == "CHIANG" else along
    beta_m = 0.726 * along + 0.812 * along**2 + 3.7 * along**20
    scale = 0.265 * radial + 1.194 * radial**2 + 5.372 * radial**22
    # A logistic distribution of scale s has the variance pi^2 s^2 / 3. TT passes Vellus' roughness twice.
    beta_n = math.pi * math.sqrt(math.pi / 8) * scale / math.sqrt(6)
    return {
        "eta": node.inputs["IOR"].default_value,
        # R turns towards the root by twice the offset.
        "alpha": math.degrees(2 * node.inputs["Offset"].default_value),
        "beta_m": math.degrees(beta_m),
        "beta_n": math.degrees(beta_n),
        "sigma_ca": absorption(node, radial),
    }


def hair_node(material):
    """The Principled Hair BSDF that is connected to the active output."""
    tree = material.node_tree
    output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL") if tree else None
    links = output.inputs["Surface"].links if output else ()
    node = links[0].from_node if links else None
    return node if node and node.bl_idname == "ShaderNodeBsdfHairPrincipled" else None


class VellusUsdHook(bpy.types.USDHook):
    """Writes Principled Hair BSDF as VellusFur."""

    bl_idname = "vellus_usd_hook"
    bl_label = "Vellus"
    bl_description = "Writes Principled Hair BSDF as VellusFur, which vellus reads"

    @staticmethod
    def on_material_export(context, material, usd_material):
        node = hair_node(material)
        if node is None:
            return True
        for socket in node.inputs:
            if socket.enabled and socket.is_linked:
                print(f"vellus: {material.name}: {socket.name} is connected: only its constant is written")
        stage = context.get_stage()
        shader = UsdShade.Shader.Define(stage, usd_material.GetPath().AppendChild("VellusFur"))
        shader.CreateIdAttr("VellusFur")
        values = parameters(node)
        for key in material.keys():
            if key.startswith("vellus:"):
                value = material[key]
                values[key.removeprefix("vellus:")] = value if isinstance(value, (str, int, float)) else list(value)
        if node.parametrization == "COLOR" and ("preset" in values or "kappa" in values):
            # With a medulla, the colour needs Vellus' own inversion.
            del values["sigma_ca"]
            values.setdefault("reflectance", list(node.inputs["Color"].default_value)[:3])
        for name, value in values.items():
            if isinstance(value, str):
                shader.CreateInput(name, Sdf.ValueTypeNames.Token).Set(value)
            elif isinstance(value, list):
                kind = {2: Sdf.ValueTypeNames.Float2, 3: Sdf.ValueTypeNames.Color3f}.get(len(value))
                if kind is None:
                    print(f"vellus: {material.name}: {name} must have 1, 2 or 3 numbers")
                    continue
                vector = Gf.Vec2f(*value) if len(value) == 2 else Gf.Vec3f(*value)
                shader.CreateInput(name, kind).Set(vector)
            else:
                shader.CreateInput(name, Sdf.ValueTypeNames.Float).Set(float(value))
        output = shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
        usd_material.CreateSurfaceOutput("vellus").ConnectToSource(output)
        return True


def register():
    bpy.utils.register_class(VellusUsdHook)


def unregister():
    bpy.utils.unregister_class(VellusUsdHook)


if __name__ == "__main__":
    register()
