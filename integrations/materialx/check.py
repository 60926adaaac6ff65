"""Checks vellus.mtlx with the package MaterialX: `python check.py` in any folder.

The document is valid, the fallback graph resolves, and shaders in GLSL, MSL and OSL generate from a material that uses
the node.
"""

from pathlib import Path

import MaterialX as mx
from MaterialX import PyMaterialXGenGlsl as glsl
from MaterialX import PyMaterialXGenMsl as msl
from MaterialX import PyMaterialXGenOsl as osl
from MaterialX import PyMaterialXGenShader as gen

FILE = Path(__file__).parent / "vellus.mtlx"


def material() -> tuple[mx.Document, mx.Node]:
    """The standard libraries, the node, and a material with it."""
    document = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), document)
    mx.readFromXmlFile(document, str(FILE))
    fiber = document.addNode("vellus_fiber_bsdf", "fiber", "BSDF")
    fiber.setInputValue("beta_m", 8.0)
    fiber.setInputValue("reflectance", mx.Color3(0.4, 0.2, 0.1))
    fiber.setInputValue("exit", "open")
    surface = document.addNode("surface", "surface", "surfaceshader")
    surface.addInput("bsdf", "BSDF").setConnectedNode(fiber)
    return document, document.addMaterialNode("fur", surface)


def main() -> None:
    """Checks the file."""
    document, fur = material()
    valid, message = document.validate()
    assert valid, message
    fiber = document.getNode("fiber")
    assert fiber.getNodeDef().getName() == "ND_vellus_fiber_bsdf"
    assert fiber.getImplementation().getName() == "NG_vellus_fiber_bsdf"
    generators = {
        "GLSL": glsl.GlslShaderGenerator,
        "Vulkan": glsl.VkShaderGenerator,
        "MSL": msl.MslShaderGenerator,
        "OSL": osl.OslShaderGenerator,
    }
    for name, generator in generators.items():
        made = generator.create()
        made.registerTypeDefs(document)
        colors = gen.DefaultColorManagementSystem.create(made.getTarget())
        colors.loadLibrary(document)
        made.setColorManagementSystem(colors)
        context = gen.GenContext(made)
        context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
        text = made.generate("fur", fur, context).getSourceCode(gen.PIXEL_STAGE)
        assert "mx_chiang_hair_bsdf" in text, name
        print(f"{name}: {len(text)} bytes")


main()
