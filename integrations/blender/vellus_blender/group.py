"""The node group Vellus Fur: its sockets, the values of presets, and its panel."""

import math

import bpy
import vellus
from bpy.props import EnumProperty

from . import hook
from .settings import Panel

# What a material of hair without a look gets, as in `vellus render`.
DEFAULT = "red-fox"

# Sockets without an entry are floats. Absorption exceeds 1, so it is no colour.
KINDS = {"reflectance": "NodeSocketColor", "sigma_ca": "NodeSocketVector", "sigma_ma": "NodeSocketVector"}


def new_socket(tree, name, kind, direction="INPUT"):
    """A socket of the group."""
    return tree.interface.new_socket(name, in_out=direction, socket_type=kind)


def describe(socket, parameter):
    """Range, unit and description of a parameter, which Vellus has."""
    unit = f", {parameter['unit']}" if parameter["unit"] else ""
    socket.description = f"{parameter['symbol']}: {parameter['description']}{unit}"
    if socket.socket_type != "NodeSocketColor":
        socket.min_value, socket.max_value = parameter["range"]


def wire(tree):
    """The inside of the group: what Cycles and EEVEE show of it. They know neither medulla nor cuticle layers."""
    nodes, links = tree.nodes, tree.links
    inputs, outputs = nodes.new("NodeGroupInput"), nodes.new("NodeGroupOutput")
    hair = nodes.new("ShaderNodeBsdfHairPrincipled")
    hair.model, hair.parametrization = "CHIANG", "COLOR"
    # The scales turn R by twice the offset.
    angle = nodes.new("ShaderNodeMath")
    angle.operation = "MULTIPLY"
    angle.inputs[1].default_value = math.radians(0.5)
    links.new(inputs.outputs[hook.SOCKETS["reflectance"]], hair.inputs["Color"])
    links.new(inputs.outputs[hook.SOCKETS["eta"]], hair.inputs["IOR"])
    links.new(inputs.outputs[hook.SOCKETS["alpha"]], angle.inputs[0])
    links.new(angle.outputs[0], hair.inputs["Offset"])
    links.new(hair.outputs[0], outputs.inputs[0])
    for i, node in enumerate((inputs, angle, hair, outputs)):
        node.location = (220 * i, 0)


def fur_tree():
    """The node tree of the group. A new one is made if the file has none."""
    found = bpy.data.node_groups.get(hook.GROUP)
    if found is not None and found.library is None:
        return found
    tree = bpy.data.node_groups.new(hook.GROUP, "ShaderNodeTree")
    new_socket(tree, "BSDF", "NodeSocketShader", "OUTPUT")
    new_socket(tree, hook.USE_COLOR, "NodeSocketBool").description = (
        "Color and pigment of the medulla set the absorption, instead of the two inputs for absorption"
    )
    table = vellus.parameters()
    for name, label in hook.SOCKETS.items():
        describe(new_socket(tree, label, KINDS.get(name, "NodeSocketFloat")), table[name])
    wire(tree)
    return tree


def apply_preset(node, preset):
    """Sets all inputs of a node to the values of a preset. The colour is that of its coat."""
    fiber = vellus.Fiber(preset)
    values = {**fiber.to_dict(), "reflectance": (*fiber.coat_color(), 1.0)}
    node.inputs[hook.USE_COLOR].default_value = False
    for name, label in hook.SOCKETS.items():
        node.inputs[label].default_value = values[name]


def fur_of(material):
    """The group Vellus Fur of a material. If there is none, it becomes the surface of the material."""
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    found = hook.surface_node(material)
    if hook.is_fur(found):
        return found
    output = hook.output_node(tree) or tree.nodes.new("ShaderNodeOutputMaterial")
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree, node.width = fur_tree(), 220
    node.location = (output.location.x - 300, output.location.y)
    apply_preset(node, DEFAULT)
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return node


def object_of(context):
    """The active object if it can have materials."""
    owner = context.object
    return owner if owner and hasattr(owner.data, "materials") else None


class VellusUseFur(bpy.types.Operator):
    """Make Vellus Fur the surface of the active material. An object without a material gets one"""

    bl_idname = "vellus.use_fur"
    bl_label = "Use Vellus Fur"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return object_of(context) is not None

    def execute(self, context):
        owner = object_of(context)
        material = owner.active_material
        if material is None:
            material = bpy.data.materials.new("Fur")
            owner.active_material = material
        fur_of(material)
        return {"FINISHED"}


class VellusPreset(bpy.types.Operator):
    """Set all inputs of Vellus Fur to those of a species"""

    bl_idname = "vellus.preset"
    bl_label = "Preset"
    bl_options = {"REGISTER", "UNDO"}

    name: EnumProperty(
        name="Preset", items=[(name, name.replace("-", " ").capitalize(), "") for name in vellus.species()]
    )

    @classmethod
    def poll(cls, context):
        owner = object_of(context)
        return owner is not None and hook.is_fur(hook.surface_node(owner.active_material))

    def execute(self, context):
        apply_preset(hook.surface_node(object_of(context).active_material), self.name)
        return {"FINISHED"}


class VELLUS_PT_fur(Panel, bpy.types.Panel):
    """The surface of the active material, with presets for Vellus Fur."""

    bl_label = "Surface"
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and object_of(context) is not None

    def draw(self, context):
        layout, material = self.layout, object_of(context).active_material
        node = hook.surface_node(material)
        if not hook.is_fur(node):
            layout.operator("vellus.use_fur")
        else:
            layout.operator_menu_enum("vellus.preset", "name")
        output = hook.output_node(material.node_tree) if material else None
        if output:
            layout.use_property_split = True
            layout.template_node_view(material.node_tree, output, output.inputs["Surface"])


CLASSES = (VellusUseFur, VellusPreset, VELLUS_PT_fur)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
