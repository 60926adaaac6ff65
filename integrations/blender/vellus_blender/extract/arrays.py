"""Arrays from Blender's collections, and transforms of them."""

import numpy as np


def read(collection, name, width=1, dtype=np.float32):
    """The attribute `name` of all elements: (n,) or (n, width)."""
    values = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


# What holds the values of an attribute, and how many numbers one value has.
KINDS = {
    "FLOAT": ("value", 1),
    "INT": ("value", 1),
    "BOOLEAN": ("value", 1),
    "FLOAT2": ("vector", 2),
    "FLOAT_VECTOR": ("vector", 3),
    "FLOAT_COLOR": ("color", 4),
    "BYTE_COLOR": ("color", 4),
}


def read_attribute(attribute):
    """The values of an attribute: (n,), (n, 2) or (n, 3). `None` for a kind that is no number."""
    kind = KINDS.get(attribute.data_type)
    if kind is None:
        return None
    dtype = {"INT": np.int32, "BOOLEAN": bool}.get(attribute.data_type, np.float32)
    values = read(attribute.data, *kind, dtype).astype(np.float32)
    return values[:, :3] if values.ndim == 2 else values


def matrix(m):
    """A matrix of Blender as a 4×4 array."""
    return np.array(m, np.float64)


def transformed(points, m):
    """Points (n, 3) through a 4×4 matrix."""
    return (points @ m[:3, :3].T + m[:3, 3]).astype(np.float32)


def mean_scale(m):
    """The cube root of the change of volume."""
    return abs(np.linalg.det(m[:3, :3])) ** (1 / 3)


def is_similarity(m):
    """Whether a matrix has a uniform scale that is not 0, and no shear."""
    scale = mean_scale(m)
    if not np.isfinite(scale) or scale < 1e-12:
        return False
    linear = m[:3, :3] / scale
    return bool(np.abs(linear.T @ linear - np.eye(3)).max() < 5e-4)


def normals_through(normals, m):
    """Unit normals (…, 3) through a matrix: by its inverse transpose."""
    moved = normals @ np.linalg.pinv(m[:3, :3])
    length = np.linalg.norm(moved, axis=-1, keepdims=True)
    return (moved / np.where(length > 0, length, 1)).astype(np.float32)
