"""Writes the files of this folder with OpenUSD and MaterialX: pip install usd-core materialx, then python make.py."""

from pathlib import Path

import MaterialX as mx
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

FOLDER = Path(__file__).parent
TYPES = Sdf.ValueTypeNames


def new_stage(name, materials):
    """A stage with one strand for each material, which is bound to it."""
    stage = Usd.Stage.CreateNew(str(FOLDER / name))
    for material in materials:
        curves = UsdGeom.BasisCurves.Define(stage, f"/strands/{material}")
        curves.CreateTypeAttr("cubic")
        curves.CreateBasisAttr("bspline")
        curves.CreateCurveVertexCountsAttr([4])
        curves.CreatePointsAttr([(x, 0, 0) for x in range(4)])
        curves.CreateWidthsAttr([0.2])
        curves.SetWidthsInterpolation("constant")
        bound = UsdShade.Material.Define(stage, f"/{material}")
        UsdShade.MaterialBindingAPI.Apply(curves.GetPrim()).Bind(bound)
    return stage


def node(stage, path, identifier, **inputs):
    shader = UsdShade.Shader.Define(stage, path)
    shader.CreateIdAttr(identifier)
    for key, (kind, value) in inputs.items():
        shader.CreateInput(key, getattr(TYPES, kind)).Set(value)
    return shader


def connect(target, key, kind, source, output):
    kind = getattr(TYPES, kind)
    target.CreateInput(key, kind).ConnectToSource(source.CreateOutput(output, kind))


def finish(stage, material, context, shader):
    material = UsdShade.Material.Get(stage, f"/{material}")
    material.CreateSurfaceOutput(context).ConnectToSource(shader.CreateOutput("out", TYPES.Token))


def materialx_in_usd():
    stage = new_stage("chiang.usda", ["hair"])
    surface = node(stage, "/hair/surface", "ND_surface")
    bsdf = node(stage, "/hair/bsdf", "ND_chiang_hair_bsdf", cuticle_angle=("Float", 0.51), ior=("Float", 1.5),
                tint_R=("Color3f", Gf.Vec3f(0.5, 1, 1)))
    rough = node(stage, "/hair/rough", "ND_chiang_hair_roughness", longitudinal=("Float", 0.3),
                 azimuthal=("Float", 0.4))
    melanin = node(stage, "/hair/melanin", "ND_deon_hair_absorption_from_melanin",
                   melanin_concentration=("Float", 0.5), melanin_redness=("Float", 0.25))
    connect(surface, "bsdf", "Token", bsdf, "out")
    for lobe in ["R", "TT", "TRT"]:
        connect(bsdf, f"roughness_{lobe}", "Float2", rough, f"roughness_{lobe}")
    connect(bsdf, "absorption_coefficient", "Vector3f", melanin, "absorption")
    finish(stage, "hair", "mtlx", surface)
    stage.Save()


def other_programs():
    stage = new_stage("programs.usda", ["arnold", "karma", "renderman", "preview"])
    hair = node(stage, "/arnold/hair", "arnold:standard_hair", base_color=("Color3f", Gf.Vec3f(0.9, 0.6, 0.4)),
                melanin=("Float", 0.25), melanin_redness=("Float", 0.5), roughness=("Float", 0.3),
                roughness_anisotropic=("Bool", True), roughness_azimuthal=("Float", 0.4), ior=("Float", 1.5),
                shift=("Float", 2), diffuse=("Float", 0.1))
    finish(stage, "arnold", "arnold", hair)
    fur = node(stage, "/karma/fur", "kma_fur_2", baseColor=("Color3f", Gf.Vec3f(0.9, 0.6, 0.4)),
               melanin=("Float", 0.25), melaninRedness=("Float", 0.5), thicknessScale=("Float", 2),
               roughness=("Float", 0.3), ior=("Float", 1.5), shift=("Float", 0.02), medullaRadius=("Float", 0.6),
               medullaPhase=("Float", 0.3), medullaDiffuse=("Float", 0.5))
    finish(stage, "karma", "kma", fur)
    marschner = node(stage, "/renderman/hair", "PxrMarschnerHair", specularColorTT=("Color3f", Gf.Vec3f(0.8, 0.5, 0.2)),
                     specularConeAngleR=("Float", 6), specularOffset=("Float", -2), specularIor=("Float", 1.5),
                     diffuseGain=("Float", 0.3))
    finish(stage, "renderman", "ri", marschner)
    preview = node(stage, "/preview/surface", "UsdPreviewSurface", diffuseColor=("Color3f", Gf.Vec3f(0.5, 0.3, 0.2)),
                   roughness=("Float", 0.4))
    finish(stage, "preview", "", preview)
    stage.Save()


def materialx_document():
    document = mx.createDocument()
    libraries = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), libraries)
    document.setDataLibrary(libraries)
    document.setColorSpace("lin_rec709")
    graph = document.addNodeGraph("graph")
    image = graph.addNode("image", "coat", "color3")
    file = image.addInput("file", "filename")
    file.setValueString("coat.png")
    file.setColorSpace("srgb_texture")
    image.setInputValue("uaddressmode", "clamp")
    graph.addOutput("color", "color3").setConnectedNode(image)
    absorption = document.addNode("chiang_hair_absorption_from_color", "absorption", "vector3")
    color = absorption.addInput("color", "color3")
    color.setNodeGraphString("graph")
    color.setOutputString("color")
    rough = document.addNode("chiang_hair_roughness", "rough", "multioutput")
    rough.setInputValue("longitudinal", 0.3)
    rough.setInputValue("azimuthal", 0.4)
    bsdf = document.addNode("chiang_hair_bsdf", "bsdf", "BSDF")
    bsdf.setInputValue("ior", 1.5)
    bsdf.addInput("absorption_coefficient", "vector3").setConnectedNode(absorption)
    for lobe in ["R", "TT", "TRT"]:
        roughness = bsdf.addInput(f"roughness_{lobe}", "vector2")
        roughness.setConnectedNode(rough)
        roughness.setOutputString(f"roughness_{lobe}")
    surface = document.addNode("surface", "surface", "surfaceshader")
    surface.addInput("bsdf", "BSDF").setConnectedNode(bsdf)
    document.addMaterialNode("Fox", surface)
    plain = document.addNode("chiang_hair_bsdf", "plain_bsdf", "BSDF")
    plain.setInputValue("absorption_coefficient", mx.Vector3(0.1, 0.2, 0.4))
    plain_surface = document.addNode("surface", "plain_surface", "surfaceshader")
    plain_surface.addInput("bsdf", "BSDF").setConnectedNode(plain)
    document.addMaterialNode("Plain", plain_surface)
    is_valid, message = document.validate()
    assert is_valid, message
    mx.writeToXmlFile(document, str(FOLDER / "hair.mtlx"))


materialx_in_usd()
other_programs()
materialx_document()
