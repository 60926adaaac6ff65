"""Makes a built-in scene the same for all renderers: the lobes of the peers, plain surfaces, B-splines, no lens.

It reads what `vellus scene` writes, and writes NAME.usdc for `vellus render`, `built_in_mitsuba.py` and
`built_in_cycles.py`. These two read it with the functions at the end.
"""

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

import scene

# Absorption per fibre radius of the peers' hair, near the colours of the built-in scenes.
ABSORPTION = {
    "polar-bear": (0.010, 0.015, 0.020),
    "hamster": (0.020, 0.050, 0.120),
    "raccoon": (0.10, 0.19, 0.40),
    "cat": (0.10, 0.19, 0.40),
    "hair": (0.25, 0.45, 0.95),
    "hair-lock": (0.25, 0.45, 0.95),
    "hamsters": (0.020, 0.050, 0.120),
}

# Fur without a medulla lets more light through to the skin. So light fur has a light skin.
SKIN = {"polar-bear": (0.8, 0.8, 0.8), "hamster": (0.8, 0.7, 0.55), "hamsters": (0.8, 0.7, 0.55)}


def to_bspline(values):
    """Control points of the B-splines through the points of Catmull-Rom splines, with the same tangents at the ends.

    Shape: (strands, points, channels).
    """
    n = values.shape[1]
    matrix, right = np.zeros((n, n)), values.astype(np.float64)
    for i in range(1, n - 1):
        matrix[i, i - 1 : i + 2] = (1 / 6, 4 / 6, 1 / 6)
    matrix[0, [0, 2]] = matrix[-1, [-3, -1]] = (-0.5, 0.5)
    right[:, 0] = (values[:, 2] - values[:, 0]) / 2
    right[:, -1] = (values[:, -1] - values[:, -3]) / 2
    return np.einsum("ij,sjc->sic", np.linalg.inv(matrix), right).astype(np.float32)


def prims(stage):
    """All prims, also the classes that instances share."""
    return list(Usd.PrimRange(stage.GetPseudoRoot(), Usd.PrimAllPrimsPredicate))


def change_curves(prim, material):
    curves = UsdGeom.BasisCurves(prim)
    counts = np.array(curves.GetCurveVertexCountsAttr().Get())
    points, widths = np.array(curves.GetPointsAttr().Get()), np.array(curves.GetWidthsAttr().Get())
    if str(curves.GetBasisAttr().Get()) != "catmullRom" or curves.GetTypeAttr().Get() != "cubic":
        raise SystemExit(f"{prim.GetPath()}: only Catmull-Rom splines are converted")
    rows, starts = np.concatenate([points, widths[:, None]], 1), np.cumsum(counts) - counts
    for count in np.unique(counts):
        index = starts[counts == count][:, None] + np.arange(count)
        rows[index] = to_bspline(rows[index])
    # A tip that ends in a point may come out slightly negative.
    widths = np.maximum(rows[:, 3], widths.max() * 1e-3)
    curves.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(rows[:, :3])))
    curves.GetWidthsAttr().Set(Vt.FloatArray.FromNumpy(np.ascontiguousarray(widths)))
    curves.GetBasisAttr().Set(UsdGeom.Tokens.bspline)
    for attribute in prim.GetAttributes():
        if attribute.GetName().startswith("primvars:"):
            prim.RemoveProperty(attribute.GetName())
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)


def plain(prim):
    """The diffuse colour of a mesh's material; of a texture, the mean."""
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    surface = material.ComputeSurfaceSource()[0]
    color = surface.GetInput("diffuseColor")
    if not color.HasConnectedSource():
        return color.Get()
    texture = UsdShade.Shader(color.GetConnectedSources()[0][0].source.GetPrim())
    pixels = np.array(mitsuba.Bitmap(texture.GetInput("file").Get().resolvedPath), np.float32)
    scale = np.array(texture.GetInput("scale").Get())[:3]
    return Gf.Vec3f(*(pixels[..., :3].mean((0, 1)) * scale).tolist())


def change_mesh(prim, name):
    """Only a plain colour stays."""
    color = SKIN.get(name) if prim.GetName().endswith("_skin") else None
    color = Gf.Vec3f(*color) if color else plain(prim)
    prim.RemoveProperty("material:binding")
    prim.RemoveProperty("primvars:st")
    UsdGeom.Mesh(prim).GetDisplayColorAttr().Set([color])


def hair(stage, name):
    shader = UsdShade.Shader.Define(stage, "/peers_hair/fiber")
    shader.CreateIdAttr("VellusFur")
    for key, value in (scene.our_fiber("10K") | {"sigma_ca": ABSORPTION[name]}).items():
        kind = Sdf.ValueTypeNames.Color3f if isinstance(value, tuple) else Sdf.ValueTypeNames.Float
        shader.CreateInput(key, kind).Set(Gf.Vec3f(*value) if isinstance(value, tuple) else value)
    material = UsdShade.Material.Define(stage, "/peers_hair")
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material


def convert(name, source, target):
    """Writes `target` next to `source`, whose textures it uses."""
    stage = Usd.Stage.Open(str(source))
    material = hair(stage, name)
    for prim in prims(stage):
        if prim.IsInstanceProxy() or prim.IsInPrototype():
            continue
        if prim.IsA(UsdGeom.BasisCurves):
            change_curves(prim, material)
        elif prim.IsA(UsdGeom.Mesh):
            change_mesh(prim, name)
        elif prim.IsA(UsdGeom.Camera):
            UsdGeom.Camera(prim).GetFStopAttr().Set(0.0)
    stage.Export(str(target))


def matrix(prim):
    """Local to world. USD multiplies rows."""
    return np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0)).T


def strands(prim, place):
    """The number of control points of each strand; x, y, z and radius of all points."""
    shape = UsdGeom.BasisCurves(prim)
    points, widths = np.array(shape.GetPointsAttr().Get()), np.array(shape.GetWidthsAttr().Get())
    scale = np.cbrt(abs(np.linalg.det(place[:3, :3])))
    rows = np.concatenate([points @ place[:3, :3].T + place[:3, 3], widths[:, None] * scale / 2], 1)
    return np.array(shape.GetCurveVertexCountsAttr().Get()), rows


def triangles(prim, place):
    """Points, triangles and the colour of a mesh."""
    shape = UsdGeom.Mesh(prim)
    points = np.array(shape.GetPointsAttr().Get()) @ place[:3, :3].T + place[:3, 3]
    faces = np.array(shape.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    return points, faces, shape.GetDisplayColorAttr().Get()[0]


def radiance(prim):
    """The light's colour times its strength."""
    source = UsdLux.LightAPI(prim)
    strength = source.GetIntensityAttr().Get() * 2.0 ** source.GetExposureAttr().Get()
    return np.array(source.GetColorAttr().Get()) * strength


def environment(prim):
    """The file of a dome light's image, or nothing."""
    file = UsdLux.DomeLight(prim).GetTextureFileAttr().Get()
    return file.resolvedPath if file else ""
