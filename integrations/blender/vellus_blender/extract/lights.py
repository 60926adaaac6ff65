"""Lights of Blender in physical units: watts become radiance, intensity and irradiance as in Cycles."""

import math

import numpy as np

from .. import hook
from .arrays import matrix, mean_scale


def group_name(name):
    """A name of a light group: ASCII letters, digits, `_` and `-`, at most 64."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)[:64] or "light"


def emission_of(light, warn):
    """The factor of the light's own nodes: an emission with constants."""
    tree = light.node_tree if light.use_nodes else None
    output = tree and tree.get_output_node("CYCLES") or tree and tree.get_output_node("ALL")
    node = hook.source(output.inputs["Surface"]) if output else None
    if node is None or node.bl_idname != "ShaderNodeEmission":
        if node is not None:
            warn(f"{light.name}: the nodes of the light are not supported and are ignored")
        return np.ones(3)
    for name in ("Color", "Strength"):
        feeder = hook.source(node.inputs[name])
        if feeder and feeder.bl_idname not in {"ShaderNodeRGB", "ShaderNodeValue"}:
            warn(f"{light.name}: {name} is connected to {feeder.bl_label}: only its constant is used")
    return np.array(hook.constant(node.inputs["Color"])[:3]) * hook.constant(node.inputs["Strength"])


def power_of(light, warn):
    """Energy times colours, RGB."""
    color = np.array(light.color) * light.energy * 2.0**light.exposure
    if light.use_temperature:
        color = color * np.array(light.temperature_color)
    return color * emission_of(light, warn)


def read_light(owner, to_world, warn):
    """A light as a dict with `kind`, its place and its emission. `None` for a light without power."""
    light = owner.data
    power = power_of(light, warn)
    if not np.isfinite(power).all():
        warn(f"{light.name}: a light whose power is not finite is left out")
        return None
    if not np.isfinite(matrix(to_world)).all():
        warn(f"{light.name}: a light whose place is not finite is left out")
        return None
    if not (power > 0).any() and not (power < 0).any():
        return None
    if (power < 0).any():
        warn(f"{light.name}: negative light is not supported: its channels are 0")
        power = np.maximum(power, 0)
        if not power.any():
            return None
    m = matrix(to_world)
    scale = mean_scale(m) or 1.0
    position, toward = m[:3, 3], m[:3, 2] / (np.linalg.norm(m[:3, 2]) or 1.0)
    out = {"name": owner.name_full, "group": group_name(owner.lightgroup or owner.name), "shaping": None}
    out["visible"] = bool(owner.visible_camera)
    if light.type == "SUN":
        half = 0.5 * light.angle
        if not light.normalize:
            power = power * (math.pi * math.sin(min(half, 0.5 * math.pi)) ** 2 if half > 0 else 1.0)
        return {**out, "kind": "distant", "direction": toward, "half_angle": half, "irradiance": power}
    if light.type == "AREA":
        if light.spread < math.pi * 0.999:
            warn(f"{light.name}: the spread of an area light is ignored")
        round_ = light.shape in {"DISK", "ELLIPSE"}
        height = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
        sized = m @ np.diag([light.size, height, 1, 1])
        area = np.linalg.norm(np.cross(sized[:3, 0], sized[:3, 1])) * (math.pi / 4 if round_ else 1)
        if area <= 0:
            warn(f"{light.name}: an area light without an area is left out")
            return None
        radiance = power / (math.pi * area) if light.normalize else power / math.pi
        if round_:
            sized = m @ np.diag([light.size / 2, height / 2, 1, 1])
        return {**out, "kind": "disk" if round_ else "rect", "to_world": sized, "radiance": radiance}
    if light.type == "SPOT":
        if light.spot_size < math.pi * 0.999:
            cone = 0.5 * light.spot_size
            out["shaping"] = {"axis": -toward, "cone": cone, "softness": float(light.spot_blend), "focus": 0.0}
    radius = light.shadow_soft_size * scale
    intensity = power / (4 * math.pi)
    if radius <= 0:
        return {**out, "kind": "point", "position": position, "intensity": intensity}
    area = math.pi * radius**2
    # Measured in Cycles: without `normalize`, the radiance is the power over pi.
    radiance = intensity / area if light.normalize else power / math.pi
    return {**out, "kind": "sphere", "center": position, "radius": radius, "radiance": radiance}
