"""Exports three materials with the hook. Run with a Python that has bpy: test_usd_hook.py OUT.usda"""

import sys
from pathlib import Path

import bpy
import numpy as np

# In the wheel, unlike in Blender, the bundled OpenUSD is not on the path.
version = f"python{sys.version_info[0]}.{sys.version_info[1]}"
sys.path.append(str(Path(bpy.utils.resource_path("LOCAL")) / "python/lib" / version / "site-packages"))
sys.path.insert(0, str(Path(__file__).parent))

import vellus_usd_hook

bpy.ops.wm.read_factory_settings(use_empty=True)
vellus_usd_hook.register()
SETTINGS = {
    "absorbed": (
        "ABSORPTION",
        "CHIANG",
        {
            "Absorption Coefficient": (0.1, 0.2, 0.4),
            "Roughness": 0.3,
            "Radial Roughness": 0.4,
            "IOR": 1.5,
            "Offset": np.radians(3),
        },
    ),
    "melanin": (
        "MELANIN",
        "HUANG",
        {
            "Melanin": 0.25,
            "Melanin Redness": 0.5,
            "Tint": (0.9, 0.6, 0.4, 1),
            "Roughness": 0.4,
            "Aspect Ratio": 0.625,
        },
    ),
    "colored": ("COLOR", "CHIANG", {"Color": (0.9, 0.6, 0.4, 1), "Radial Roughness": 0.3}),
}
for index, (name, (parametrization, model, inputs)) in enumerate(SETTINGS.items()):
    curves = bpy.data.hair_curves.new(name)
    curves.add_curves([4])
    positions = np.array([[x, index, 0] for x in range(4)], np.float32)
    curves.position_data.foreach_set("vector", positions.ravel())
    curves.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", np.full(4, 0.1, np.float32))
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, curves))
    material = bpy.data.materials.new(name)
    material.node_tree.nodes.clear()
    output = material.node_tree.nodes.new("ShaderNodeOutputMaterial")
    hair = material.node_tree.nodes.new("ShaderNodeBsdfHairPrincipled")
    material.node_tree.links.new(hair.outputs[0], output.inputs["Surface"])
    hair.parametrization, hair.model = parametrization, model
    for key, value in inputs.items():
        hair.inputs[key].default_value = value
    curves.materials.append(material)
bpy.data.materials["colored"]["vellus:preset"] = "red-fox"
bpy.data.materials["colored"]["vellus:kappa"] = 0.7
bpy.ops.wm.usd_export(filepath=sys.argv[1], export_materials=True)
