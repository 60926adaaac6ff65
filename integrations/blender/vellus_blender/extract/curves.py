"""Hair curves: positions, radii, normals, uv of the roots and attributes, after geometry nodes."""

import numpy as np

from .. import hook
from .arrays import read, read_attribute

CATMULL_ROM, POLY, BEZIER, NURBS = range(4)

# What Blender uses for curves without radii.
DEFAULT_RADIUS = 0.01


def first_of(counts):
    """The index of the first point of each strand."""
    return np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64) if len(counts) else np.zeros(0, np.int64)


def pinned(values, counts, mirror):
    """Adds a value before and after each strand, so that a Catmull-Rom curve passes through its ends.

    `values` is (n, …) and `counts` (strands,). Positions are mirrored at the ends, other values are repeated.
    """
    first = first_of(counts)
    last = first + counts - 1
    ends = 2 * np.arange(len(counts))
    strand = np.repeat(np.arange(len(counts)), counts)
    out = np.empty((len(values) + 2 * len(counts), *values.shape[1:]), values.dtype)
    out[np.arange(len(values)) + ends[strand] + 1] = values
    before, after = first + ends, last + ends + 2
    second, inner = np.minimum(first + 1, last), np.maximum(last - 1, first)
    out[before] = 2 * values[first] - values[second] if mirror else values[first]
    out[after] = 2 * values[last] - values[inner] if mirror else values[last]
    return out


def bezier_points(points, left, right, radii, counts):
    """Control points of Bézier segments that share their ends, and their radii."""
    first = first_of(counts)
    last = first + counts - 1
    triples = np.stack([left, points, right], 1).reshape(-1, 3)
    following, previous = np.roll(radii, -1), np.roll(radii, 1)
    widths = np.stack([(2 * radii + previous) / 3, radii, (2 * radii + following) / 3], 1).reshape(-1)
    keep = np.ones(len(triples), bool)
    keep[3 * first] = keep[3 * last + 2] = False
    return triples[keep], widths[keep]


def select(strands, mask):
    """The strands of a dict for which `mask` is true."""
    counts = strands["counts"]
    points = np.repeat(mask, counts)
    out = dict(strands)
    out["points"], out["radii"], out["counts"] = strands["points"][points], strands["radii"][points], counts[mask]
    if strands["uv"] is not None:
        out["uv"] = strands["uv"][mask]
    if strands["normals"] is not None:
        out["normals"] = strands["normals"][points]
    attributes = strands["attributes"].items()
    out["attributes"] = {name: (domain, a[points if domain == "POINT" else mask]) for name, (domain, a) in attributes}
    if "handles" in strands:
        out["handles"] = tuple(h[points] for h in strands["handles"])
    return out


def without_bad(strands, warn):
    """Drops strands of one point, of no length, and with numbers that are not finite. One warning counts them."""
    counts, points = strands["counts"], strands["points"]
    if not len(counts):
        return strands
    first = first_of(counts)
    finite = np.isfinite(points).all(1) & np.isfinite(strands["radii"])
    step = np.zeros(len(points), np.float32)
    step[1:] = np.linalg.norm(np.diff(points, axis=0), axis=1)
    step[first[counts > 0]] = 0
    # reduceat needs strands that are not empty.
    some = counts > 0
    length, good = np.zeros(len(counts), np.float32), np.zeros(len(counts), bool)
    if some.any():
        length[some] = np.add.reduceat(np.nan_to_num(step), first[some])
        good[some] = np.logical_and.reduceat(finite, first[some])
    keep = good & (counts >= 2) & (length > 0)
    if keep.all():
        return strands
    name, bad = strands["name"], int((~keep).sum())
    what = "strands without length, with one point or with infinite coordinates are left out"
    warn(f"{name}: {what} ({bad} of {len(keep)})")
    return select(strands, keep)


def read_curves(data, name, look, warn):
    """Strands of the evaluated hair curves `data`, in their own space: one dict for each kind of curve.

    Of the attributes, those that the look reads are kept, and those that begin with `vellus:`.
    """
    if not len(data.curves):
        return []
    offsets = read(data.curve_offset_data, "value", 1, np.int32)
    counts = np.diff(offsets).astype(np.int64)
    points = read(data.position_data, "vector", 3)
    attributes = data.attributes
    radius = attributes.get("radius")
    radii = read_attribute(radius) if radius else np.full(len(points), DEFAULT_RADIUS, np.float32)
    uv = attributes.get("surface_uv_coordinate")
    strands = {
        "name": name,
        "points": points,
        "counts": counts,
        "radii": np.maximum(radii, 0),
        "normals": hook.shorter_axes(data) if hook.is_flat(look["values"]) else None,
        "uv": read_attribute(uv) if uv and uv.domain == "CURVE" and uv.data_type == "FLOAT2" else None,
        "attributes": {},
    }
    for attribute in attributes:
        if attribute.name.startswith("vellus:") or attribute.name in look["attributes"]:
            values = read_attribute(attribute)
            if values is None or attribute.domain not in {"POINT", "CURVE"}:
                warn(f"{name}: the attribute {attribute.name} has no numbers for points or curves, and is ignored")
            else:
                strands["attributes"][attribute.name] = (attribute.domain, values)
    kinds = attributes.get("curve_type")
    kinds = read(kinds.data, "value", 1, np.int8) if kinds else np.zeros(len(counts), np.int8)
    handles = [attributes.get(key) for key in ("handle_left", "handle_right")]
    if all(handles):
        strands["handles"] = tuple(read_attribute(h) for h in handles)
    if (cyclic := attributes.get("cyclic")) and read_attribute(cyclic).any():
        warn(f"{name}: cyclic curves are drawn open")
    strands = {**strands, "attributes": {**strands["attributes"], "curve_type": ("CURVE", kinds)}}
    strands = without_bad(strands, warn)
    _, kinds = strands["attributes"].pop("curve_type")
    out = []
    for kind in np.unique(kinds):
        part = select(strands, kinds == kind)
        out.append(finished(part, int(kind), warn))
    return out


def finished(part, kind, warn):
    """Strands of one kind of curve, with the control points that their basis needs."""
    counts = part["counts"]
    handles, normals = part.pop("handles", None), part["normals"]
    if kind == NURBS:
        warn(f"{part['name']}: NURBS are drawn as straight lines between their control points")
    if kind == BEZIER and handles:
        radii = part["radii"]
        part["points"], part["radii"] = bezier_points(part["points"], *handles, radii, counts)
        if normals is not None:
            part["normals"] = bezier_points(normals, normals, normals, radii, counts)[0]
        first = first_of(counts)
        middle = {name: (d, a if d == "CURVE" else a[first]) for name, (d, a) in part["attributes"].items()}
        if any(d == "POINT" for d, _ in part["attributes"].values()):
            warn(f"{part['name']}: attributes of Bézier points are read at the roots")
        part["attributes"] = {name: ("CURVE", a) for name, (_, a) in middle.items()}
        part["counts"], part["basis"] = 3 * counts - 2, "bezier"
    elif kind in (POLY, NURBS):
        part["basis"] = "linear"
    else:
        catmull_rom(part)
    return part


def catmull_rom(part):
    """Adds the control points beyond the ends."""
    counts = part["counts"]
    part["points"] = pinned(part["points"], counts, True)
    part["radii"] = pinned(part["radii"], counts, False)
    if part["normals"] is not None:
        part["normals"] = pinned(part["normals"], counts, False)
    attributes = part["attributes"].items()
    part["attributes"] = {n: (d, pinned(a, counts, False) if d == "POINT" else a) for n, (d, a) in attributes}
    part["counts"], part["basis"] = counts + 2, "catmull-rom"
