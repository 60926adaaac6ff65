"""The evaluated scene as a `Description`: strands, meshes, instances, lights, world and camera."""

from dataclasses import dataclass, field

import numpy as np

from . import particles
from .arrays import is_similarity, matrix, mean_scale, normals_through, transformed
from .camera import read_camera
from .curves import read_curves
from .lights import read_light
from .looks import read_look
from .materials import surface_of
from .meshes import read_mesh
from .world import read_world


class Problem(Exception):
    """The scene cannot be rendered. The text is for the report."""


@dataclass
class Description:
    """A scene as plain arrays, in world space. `strands` and `meshes` are lists of dicts.

    `prototypes` has one dict with `name`, `strands` and `meshes` for each shared object, and `instances` has pairs of
    an index into it and a 4×4 matrix. `looks` and `surfaces` are by name.
    """

    strands: list = field(default_factory=list)
    meshes: list = field(default_factory=list)
    prototypes: list = field(default_factory=list)
    instances: list = field(default_factory=list)
    looks: dict = field(default_factory=dict)
    surfaces: dict = field(default_factory=dict)
    lights: list = field(default_factory=list)
    camera: dict = None
    warnings: list = field(default_factory=list)

    def warn(self, text):
        """Adds a warning once."""
        if text not in self.warnings:
            self.warnings.append(text)


@dataclass
class Placed:
    """The parts of an object in its own space, and its place. Instances of one object share `parts`."""

    parts: list
    matrix: np.ndarray
    is_instance: bool


CONVERTED = {"CURVE", "SURFACE", "FONT", "META"}
SILENT = {"EMPTY", "CAMERA", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT", "LIGHT_PROBE", "GPENCIL", "GREASEPENCIL"}


class Reader:
    """Reads one moment of the scene."""

    def __init__(self, depsgraph, description, cache, is_render, progress):
        self.depsgraph, self.description, self.cache = depsgraph, description, cache
        self.is_render, self.progress = is_render, progress
        self.shared = {}

    def look(self, material):
        """The name of the look of a material, which is read once."""
        looks = self.description.looks
        name = material.name_full if material else ""
        if name not in looks:
            looks[name] = read_look(material, self.description.warn)
        return name

    def surface(self, material):
        """The name of the surface of a material, which is read once."""
        surfaces = self.description.surfaces
        name = material.name_full if material else ""
        if name not in surfaces:
            surfaces[name] = surface_of(material, self.description.warn)
        return name

    def strands_of_curves(self, owner):
        """The parts of hair curves."""
        material = owner.material_slots[0].material if len(owner.material_slots) else None
        name = self.look(material)
        parts = read_curves(owner.data, owner.name, self.description.looks[name], self.description.warn)
        return [("strands", {**part, "look": name}) for part in parts if len(part["counts"])]

    def strands_of_particles(self, owner):
        """The parts of particle hair."""
        out = []
        for system in owner.particle_systems:

            def progress(share, name=owner.name):
                self.progress(f"Reading the hair of {name}: {share:.0%}")

            warn = self.description.warn
            part = particles.read_system(owner, system, self.is_render, self.cache, warn, progress)
            if part and len(part["counts"]):
                out.append(("strands", {**part, "look": self.look(particles.material_of(owner, system))}))
        return out

    def parts_of_mesh(self, owner):
        """The parts of a mesh, or of an object that Blender converts to one."""
        mesh = owner.data if owner.type == "MESH" else owner.to_mesh()
        if mesh is None:
            return []
        slots = owner.material_slots
        out = []
        for slot, part in read_mesh(mesh, owner.name):
            material = slots[min(slot, len(slots) - 1)].material if len(slots) else None
            out.append(("meshes", {**part, "surface": self.surface(material)}))
        if owner.type != "MESH":
            owner.to_mesh_clear()
        return out

    def parts(self, item):
        """The parts of an object, read once if it is an instance."""
        owner = item.object
        key = (owner.name_full, owner.data.as_pointer(), item.show_self, item.show_particles)
        if item.is_instance and key in self.shared:
            return self.shared[key]
        out = []
        if item.show_self:
            if owner.type == "CURVES":
                out += self.strands_of_curves(owner)
            elif owner.type == "MESH" or owner.type in CONVERTED:
                out += self.parts_of_mesh(owner)
        # Duplicates of a system's own object have no strands of their own in Blender.
        if item.show_particles and owner.type == "MESH" and len(owner.particle_systems):
            out += self.strands_of_particles(owner)
        if item.is_instance:
            self.shared[key] = out
        return out

    def read(self):
        """All objects: a dict from a key that stays the same over time to `Placed`, and the lights by such keys."""
        placed, lights = {}, {}
        warn = self.description.warn
        for item in self.depsgraph.object_instances:
            owner = item.object
            # The number of an instance is only unique below its parent.
            parent = item.parent.name_full if item.is_instance and item.parent else ""
            key = (owner.name_full, parent, tuple(item.persistent_id) if item.is_instance else ())
            if owner.type == "LIGHT":
                light = read_light(owner, item.matrix_world, warn) if item.show_self else None
                if light:
                    lights[key] = light
            elif owner.type in {"MESH", "CURVES"} or owner.type in CONVERTED:
                if not np.isfinite(matrix(item.matrix_world)).all():
                    warn(f"{owner.name}: an object whose place is not finite is left out")
                    continue
                parts = self.parts(item)
                if owner.is_holdout or owner.is_shadow_catcher:
                    warn(f"{owner.name}: holdouts and shadow catchers are drawn as they are")
                elif not owner.visible_camera:
                    warn(f"{owner.name}: the camera sees it, although its ray visibility says no")
                if parts:
                    placed[key] = Placed(parts, matrix(item.matrix_world), item.is_instance)
            elif owner.type not in SILENT:
                warn(f"{owner.name}: objects of the type {owner.type.title()} are left out")
        return placed, lights


def in_world(kind, part, m):
    """A part in world space."""
    out = {**part, "points": transformed(part["points"], m), "moved": None}
    # The normals of strands are cross products of directions along and across them, and so move like those of faces.
    if part["normals"] is not None:
        out["normals"] = normals_through(part["normals"], m)
    if kind == "strands":
        out["radii"] = (part["radii"] * mean_scale(m)).astype(np.float32)
        return out
    if np.linalg.det(m[:3, :3]) < 0:
        for key in ("triangles", "normals", "uv"):
            if out[key] is not None:
                out[key] = np.ascontiguousarray(out[key][:, ::-1])
    return out


def same_shape(a, b):
    """Whether two parts have the same topology."""
    if a["points"].shape != b["points"].shape:
        return False
    name = "counts" if "counts" in a else "triangles"
    return np.array_equal(a[name], b[name])


def moved_parts(open_, close):
    """Whether anything moves, and whether the topology stays the same."""
    pairs = list(zip(open_.parts, close.parts))
    same = len(open_.parts) == len(close.parts) and all(k == l and same_shape(a, b) for (k, a), (l, b) in pairs)
    if not same:
        return True, False
    moves = not np.allclose(open_.matrix, close.matrix, atol=1e-7, rtol=0)
    return moves or any(not np.array_equal(a["points"], b["points"]) for (_, a), (_, b) in pairs), True


def assemble(description, placed, later):
    """Turns placed objects into strands and meshes in world space, and into instances."""
    prototypes = {}
    for key, thing in placed.items():
        close = later.get(key) if later else None
        moves, matches = moved_parts(thing, close) if close else (False, True)
        if not matches:
            description.warn(f"{key[0]}: its strands or faces change while the shutter is open: it is not blurred")
            moves = False
        if thing.is_instance and not moves and is_similarity(thing.matrix):
            index = prototypes.get(id(thing.parts))
            if index is None:
                index = prototypes[id(thing.parts)] = len(description.prototypes)
                prototype = {"name": key[0], "strands": [], "meshes": []}
                for kind, part in thing.parts:
                    prototype[kind].append({**part, "moved": None})
                description.prototypes.append(prototype)
            description.instances.append((index, thing.matrix))
            continue
        for i, (kind, part) in enumerate(thing.parts):
            world = in_world(kind, part, thing.matrix)
            if moves:
                world["moved"] = transformed(close.parts[i][1]["points"], close.matrix)
            getattr(description, kind).append(world)


def shutter(scene):
    """The frame and subframe at which the shutter opens, and those at which it closes. `None` without motion blur."""
    render = scene.render
    if not render.use_motion_blur or render.motion_blur_shutter <= 0:
        return None
    length = render.motion_blur_shutter
    start = {"START": 0.0, "CENTER": -0.5 * length, "END": -length}[render.motion_blur_position]
    times = [scene.frame_current + scene.frame_subframe + start + x for x in (0, length)]
    return [(int(np.floor(t)), float(t - np.floor(t))) for t in times]


def extract(depsgraph, *, width, height, cache=None, progress=None, set_time=None, is_render=True, camera=None):
    """Reads the scene of a depsgraph.

    `width` and `height` are those of the whole picture. `progress(text)` is called now and then and may raise to
    stop. `set_time(frame, subframe)` moves the depsgraph, for motion blur. `camera` replaces the scene's: a dict as
    `camera.read_camera` makes it.

    Raises `Problem` if there is nothing to render.
    """
    progress = progress or (lambda text: None)
    description = Description()
    warn = description.warn
    scene = depsgraph.scene
    times = shutter(scene) if set_time else None
    now = (scene.frame_current, scene.frame_subframe)

    def look_through():
        owner = depsgraph.scene.camera
        if camera is not None:
            return camera
        if owner is None:
            raise Problem("The scene has no camera. Add one, and make it the active camera of the scene.")
        found = read_camera(owner.evaluated_get(depsgraph), width, height, warn)
        if found is None:
            raise Problem(f"{owner.name}: Vellus has only perspective cameras. Set its type to Perspective.")
        return found

    def moment(cache):
        progress("Reading the scene")
        return Reader(depsgraph, description, cache, is_render, progress).read()

    try:
        if times:
            set_time(*times[0])
        description.camera = {**look_through(), "moved": None}
        placed, lights = moment(cache)
        description.lights = list(lights.values())
        world = read_world(depsgraph.scene.world, warn)
        if world:
            description.lights.append(world)
        later = None
        if times:
            set_time(*times[1])
            close = look_through()
            if not np.allclose(close["matrix"], description.camera["matrix"], atol=1e-7, rtol=0):
                description.camera["moved"] = close["matrix"]
            later, lights_later = moment(None)
            still = all(same_light(light, lights_later.get(key)) for key, light in lights.items())
            if not still:
                warn("lights that move while the shutter is open are not blurred")
    finally:
        if times:
            set_time(*now)
    assemble(description, placed, later)
    if not (description.strands or description.meshes or description.instances):
        raise Problem("There is nothing to render: the scene has no hair and no meshes that are shown in renders.")
    if not description.strands and not any(p["strands"] for p in description.prototypes):
        warn("the scene has no hair: add hair curves or particle hair")
    if not description.lights and not any(any(s["emission"]) for s in description.surfaces.values()):
        warn("the scene has no light: the picture is black")
    return description


def same_light(a, b):
    """Whether a light did not move."""
    keys = ("position", "center", "direction", "to_world")
    return b is not None and all(np.allclose(a[k], b[k], atol=1e-7) for k in keys if k in a and k in b)
