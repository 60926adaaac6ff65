"""The world: a colour, or an image around the scene."""

import numpy as np

from .. import hook
from .arrays import matrix
from .images import pixels

# From the frame of a dome, whose centre is at -z and top at +y, to the space of an environment texture, whose centre is
# at +x and top at +z.
DOME = np.array([[0, 0, -1], [-1, 0, 0], [0, 1, 0]], np.float64)


def rotation_of(texture, warn):
    """The rotation from the world's directions to those of the texture."""
    mapping = hook.source(texture.inputs["Vector"])
    if mapping is None:
        return np.eye(3)
    if mapping.bl_idname == "ShaderNodeTexCoord":
        return np.eye(3)
    if mapping.bl_idname != "ShaderNodeMapping":
        warn(f"World: {mapping.bl_label} is not supported: the image is not rotated")
        return np.eye(3)
    from mathutils import Euler

    turn = np.array(Euler(mapping.inputs["Rotation"].default_value).to_matrix(), np.float64)
    if mapping.vector_type == "TEXTURE":
        turn = turn.T
    if any(mapping.inputs[name].is_linked for name in ("Location", "Rotation", "Scale")):
        warn("World: inputs of Mapping that are connected are read as their constants")
    scale = np.array(mapping.inputs["Scale"].default_value)
    if mapping.vector_type != "VECTOR" and any(mapping.inputs["Location"].default_value):
        warn("World: the location of Mapping is ignored")
    if not np.allclose(scale, scale[0]):
        warn("World: the scale of Mapping is ignored")
    return turn


def background_node(world, warn):
    """The Background node, or `None`."""
    output = hook.output_node(world.node_tree)
    node = hook.source(output.inputs["Surface"]) if output else None
    if node is not None and node.bl_idname != "ShaderNodeBackground":
        warn(f"World: {node.bl_label} is not supported: the world is black")
        return None
    return node


def read_world(world, warn):
    """A dome as a dict with `radiance`, `image` and `rotation`, or `None` for a black world."""
    node = background_node(world, warn) if world else None
    if node is None:
        return None
    strength = hook.constant(node.inputs["Strength"])
    feeder = hook.source(node.inputs["Strength"])
    if feeder is not None and feeder.bl_idname != "ShaderNodeValue":
        warn("World: Strength is connected: only its constant is used")
    texture = hook.source(node.inputs["Color"])
    rotation, image = np.eye(3), None
    color = np.maximum(np.array(hook.constant(node.inputs["Color"])[:3]) * strength, 0)
    if texture and texture.bl_idname == "ShaderNodeTexEnvironment":
        if texture.image is None:
            warn("World: the environment texture has no image")
        else:
            found = pixels(texture.image, warn)
            if texture.projection != "EQUIRECTANGULAR":
                warn("World: the image is read as equirectangular")
            if found is not None:
                image = {"name": texture.image.name_full, "pixels": found, "wrap": "repeat"}
                color = np.full(3, max(strength, 0.0))
                rotation = rotation_of(texture, warn).T @ DOME
    elif texture and texture.bl_idname != "ShaderNodeRGB":
        warn(f"World: {texture.bl_label} is not supported: only its constant colour is used")
    if not (color > 0).any():
        return None
    group = world.lightgroup if hasattr(world, "lightgroup") else ""
    return {
        "kind": "dome",
        "name": "World",
        "group": group or "World",
        "radiance": color,
        "image": image,
        "rotation": rotation,
        "visible": True,
        "shaping": None,
    }
