"""Writes chiang.usda with OpenUSD: pip install usd-core, then python make.py."""

from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

stage = Usd.Stage.CreateNew(str(Path(__file__).parent / "chiang.usda"))
curves = UsdGeom.BasisCurves.Define(stage, "/lock")
curves.CreateTypeAttr("cubic")
curves.CreateBasisAttr("bspline")
curves.CreateCurveVertexCountsAttr([4])
curves.CreatePointsAttr([(x, 0, 0) for x in range(4)])
curves.CreateWidthsAttr([0.2])
curves.SetWidthsInterpolation("constant")
material = UsdShade.Material.Define(stage, "/hair")
UsdShade.MaterialBindingAPI.Apply(curves.GetPrim()).Bind(material)


def node(name, identifier, **inputs):
    shader = UsdShade.Shader.Define(stage, f"/hair/{name}")
    shader.CreateIdAttr(identifier)
    for key, (kind, value) in inputs.items():
        shader.CreateInput(key, getattr(Sdf.ValueTypeNames, kind)).Set(value)
    return shader


def connect(target, key, kind, source, output):
    kind = getattr(Sdf.ValueTypeNames, kind)
    target.CreateInput(key, kind).ConnectToSource(source.CreateOutput(output, kind))


surface = node("surface", "ND_surface")
bsdf = node("bsdf", "ND_chiang_hair_bsdf", cuticle_angle=("Float", 0.51), ior=("Float", 1.5),
            tint_R=("Color3f", Gf.Vec3f(0.5, 1, 1)))
rough = node("rough", "ND_chiang_hair_roughness", longitudinal=("Float", 0.3), azimuthal=("Float", 0.4))
melanin = node("melanin", "ND_deon_hair_absorption_from_melanin", melanin_concentration=("Float", 0.5),
               melanin_redness=("Float", 0.25))
connect(surface, "bsdf", "Token", bsdf, "out")
for lobe in ["R", "TT", "TRT"]:
    connect(bsdf, f"roughness_{lobe}", "Float2", rough, f"roughness_{lobe}")
connect(bsdf, "absorption_coefficient", "Vector3f", melanin, "absorption")
material.CreateSurfaceOutput("mtlx").ConnectToSource(surface.CreateOutput("out", Sdf.ValueTypeNames.Token))
stage.Save()
