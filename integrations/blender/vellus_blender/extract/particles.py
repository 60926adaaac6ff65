"""Particle hair, with its children. Blender gives one point a call, which takes a microsecond."""

import numpy as np

from .arrays import matrix, transformed
from .curves import catmull_rom, without_bad


class Cache:
    """The strands of particle systems of the last pictures.

    A system is read again if its number of strands or steps changed, if the tip of any strand moved, or if the
    middle of any sixteenth strand moved. That check takes a ninth of the time of reading.
    """

    def __init__(self):
        self.systems = {}

    def clear(self):
        self.systems.clear()


def profile(settings, along):
    """Radii at the positions `along` (from 0 to 1) of a strand, as Cycles computes them."""
    root, tip = settings.root_radius * settings.radius_scale, settings.tip_radius * settings.radius_scale
    rest = 1 - along
    shape = settings.shape
    if shape != 0:
        rest = rest ** (1 + shape) if shape < 0 else rest ** (1 / (1 - shape)) if shape < 1 else (rest > 0) * 1.0
    radii = 0.5 * (rest * (root - tip) + tip)
    if settings.use_close_tip:
        radii = np.where(along >= 1, 0, radii)
    return radii


def first_and_count(system):
    """The index of the first strand, and the number of strands. Children come after their parents."""
    parents, children = len(system.particles), len(system.child_particles)
    settings = system.settings
    first = 0 if settings.child_type == "NONE" or settings.use_parent_particles or not children else parents
    return first, parents + children - first


def steps_of(settings, is_render):
    """The number of points of a strand."""
    steps = 2 ** (settings.render_step if is_render else settings.display_step) + 1
    return steps + settings.kink_extra_steps if settings.kink == "SPIRAL" else steps


def fingerprint(owner, system, first, count, steps):
    """The tips, and the middles of some strands."""
    tips = [system.co_hair(object=owner, particle_no=i, step=steps - 1) for i in range(first, first + count)]
    some = range(first, first + count, 16)
    return np.array(tips + [system.co_hair(object=owner, particle_no=i, step=steps // 2) for i in some], np.float32)


def roots(system, modifier, first, count, warn):
    """The uv of the roots, (count, 2), or `None`."""
    parents = len(system.particles)
    try:
        uv = [
            system.uv_on_emitter(modifier, particle=system.particles[min(i, parents - 1)], particle_no=i, uv_no=0)
            for i in range(first, first + count)
        ]
    except (RuntimeError, TypeError, IndexError):
        # Blender says so if the mesh has no uv, or if a modifier changed the faces.
        return None
    return np.array(uv, np.float32).reshape(-1, 2)


def modifier_of(owner, system):
    """The modifier of a particle system."""
    for modifier in owner.modifiers:
        if modifier.type == "PARTICLE_SYSTEM" and modifier.particle_system.name == system.name:
            return modifier
    return None


def read_system(owner, system, is_render, cache, warn, progress):
    """Strands of a particle system in the space of its object, or `None` if it shows no hair.

    `progress(share)` is called now and then. It may raise to stop.
    """
    settings = system.settings
    modifier = modifier_of(owner, system)
    shown = modifier and (modifier.show_render if is_render else modifier.show_viewport)
    if settings.type != "HAIR" or settings.render_type != "PATH" or not shown:
        return None
    first, count = first_and_count(system)
    if count == 0:
        return None
    steps = steps_of(settings, is_render)
    key = (owner.name_full, system.name, is_render)
    print_now = fingerprint(owner, system, first, count, steps)
    kept = cache.systems.get(key) if cache else None
    if kept and kept[0] == (first, count, steps) and np.array_equal(kept[1], print_now):
        world, uv = kept[2:]
    else:
        world = np.empty((count, steps, 3), np.float32)
        co_hair = system.co_hair
        for i in range(count):
            world[i] = [co_hair(object=owner, particle_no=first + i, step=step) for step in range(steps)]
            if i % 4096 == 0:
                progress(i / count)
        uv = roots(system, modifier, first, count, warn) if owner.data.uv_layers else None
        if cache is not None:
            cache.systems[key] = ((first, count, steps), print_now, world, uv)
    name = f"{owner.name}/{system.name}"
    points = transformed(world.reshape(-1, 3), np.linalg.inv(matrix(owner.matrix_world)))
    # Positions along a strand are shares of its length.
    length = np.cumsum(np.linalg.norm(np.diff(world, axis=1), axis=2), axis=1)
    total = np.where(length[:, -1:] > 0, length[:, -1:], 1)
    along = np.concatenate([np.zeros((count, 1), np.float32), length / total], 1)
    along[:, -1] = 1
    part = {
        "name": name,
        "points": points,
        "counts": np.full(count, steps, np.int64),
        "radii": profile(settings, along).astype(np.float32).ravel(),
        "normals": None,
        "uv": uv,
        "attributes": {},
    }
    part = without_bad(part, warn)
    catmull_rom(part)
    return part


def material_of(owner, system):
    """The material of a particle system."""
    slots = owner.material_slots
    index = min(max(system.settings.material - 1, 0), len(slots) - 1)
    return slots[index].material if len(slots) else None
