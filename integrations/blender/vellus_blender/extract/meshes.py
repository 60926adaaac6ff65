"""Meshes as triangles with normals and uv, one for each material."""

import numpy as np

from .arrays import read


def read_mesh(mesh, name):
    """Parts of a mesh in its own space: a list of (slot, dict). A part has the triangles of one material slot."""
    mesh.calc_loop_triangles()
    triangles = mesh.loop_triangles
    if not len(triangles):
        return []
    points = read(mesh.vertices, "co", 3)
    vertices = read(triangles, "vertices", 3, np.int32)
    loops = read(triangles, "loops", 3, np.int32)
    slots = read(triangles, "material_index", 1, np.int32)
    normals = read(mesh.corner_normals, "vector", 3)[loops]
    layer = next((u for u in mesh.uv_layers if u.active_render), None)
    uv = read(layer.uv, "vector", 2)[loops] if layer else None
    parts = []
    for slot in np.unique(slots):
        chosen = slots == slot
        used, indices = np.unique(vertices[chosen], return_inverse=True)
        part = {
            "name": name,
            "points": points[used],
            "triangles": indices.reshape(-1, 3).astype(np.uint32),
            "normals": normals[chosen],
            "uv": uv[chosen] if uv is not None else None,
        }
        parts.append((int(slot), part))
    return parts
