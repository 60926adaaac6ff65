"""Grows the furry balls and writes them for each renderer: NumPy, Mitsuba's text format, USD."""

import sys
from pathlib import Path

import numpy as np

import scene


def grow(strands, segments, radius, seed=1234):
    """Control points of uniform cubic B-splines, and the radius at each: (strands, n, 3), (n)."""
    g = np.random.default_rng(seed)
    t = np.linspace(0, 1, segments + 1)[None, :, None]
    # Roots on the unit sphere: one in each of n rings of equal area.
    z = 1 - 2 * (np.arange(strands) + g.random(strands)) / strands
    azimuth = 2 * np.pi * g.random(strands)
    s = np.sqrt(1 - z * z)
    root = np.stack([s * np.cos(azimuth), s * np.sin(azimuth), z], -1)
    length = 0.4 * (0.8 + 0.4 * g.random(strands))[:, None, None]
    # Combed, mostly along the skin: a swirl around the axis, slow waves, gravity.
    swirl = np.stack([-root[:, 1], root[:, 0], 0 * z], -1)
    waves = np.sin(root @ (g.normal(size=(3, 3)) * 2.5) + g.random(3) * 2 * np.pi)
    comb = 0.55 * swirl + 0.45 * waves + np.array([0, 0, -0.55])
    comb -= 0.7 * (comb * root).sum(-1, keepdims=True) * root
    up = root + g.normal(size=(strands, 3)) * 0.12
    up /= np.linalg.norm(up, axis=-1, keepdims=True)
    points = root[:, None] + length * (t * (1 - 0.35 * t) * up[:, None] + 0.75 * t * t * comb[:, None])
    # Curls.
    frequency = 3 * (4 + 3 * g.random(strands))[:, None, None]
    points = points + 0.012 * t * np.sin(frequency * t + 2 * np.pi * g.random((strands, 1, 3)))
    # One more point at both ends, so that there are as many segments as intervals.
    first, last = 2 * points[:, :1] - points[:, 1:2], 2 * points[:, -1:] - points[:, -2:-1]
    points = np.concatenate([first, points, last], 1).astype(np.float32)
    radii = radius * (1 - scene.TAPER * t[0, :, 0])
    return points, np.concatenate([radii[:1], radii, radii[-1:]]).astype(np.float32)


def skin(rings=64, around=128):
    """Vertices and triangles of the unit sphere. The vertices are also the normals."""
    theta, phi = np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, around, endpoint=False)
    sin, cos = np.sin(theta)[:, None], np.cos(theta)[:, None]
    ring = np.stack([sin * np.cos(phi), sin * np.sin(phi), cos + 0 * phi], -1)
    vertices = np.concatenate([[[0, 0, 1]], ring[1:-1].reshape(-1, 3), [[0, 0, -1]]])
    last = len(vertices) - 1
    at = lambda y, x: 1 + y * around + x % around
    faces = [(0, at(0, x), at(0, x + 1)) for x in range(around)]
    for y in range(rings - 2):
        for x in range(around):
            a, b, c, d = at(y, x), at(y + 1, x), at(y + 1, x + 1), at(y, x + 1)
            faces += [(a, b, c), (a, c, d)]
    faces += [(last, at(rings - 2, x + 1), at(rings - 2, x)) for x in range(around)]
    return vertices.astype(np.float32), np.array(faces, np.int32)


def write_text(path, points, radii):
    """Mitsuba's format: `x y z radius` per line, and an empty line between curves."""
    rows = np.concatenate([points, np.broadcast_to(radii[None, :, None], points.shape[:2] + (1,))], -1)
    form = "%.7g %.7g %.7g %.7g\n" * len(radii) + "\n"
    with open(path, "w") as file:
        for row in rows.reshape(len(points), -1):
            file.write(form % tuple(row))


def write_ply(path, vertices, faces):
    """Writes the skin, with normals."""
    rows = np.zeros(len(faces), [("count", "u1"), ("vertices", "<i4", 3)])
    rows["count"], rows["vertices"] = 3, faces
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
    head += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    data = np.concatenate([vertices * scene.SKIN_RADIUS, vertices], 1).astype("<f4")
    path.write_bytes(head.encode() + data.tobytes() + rows.tobytes())


def write_usd(path, ball, points, radii):
    """Writes curves with our shader, the light, the sky, the skin and a camera for each view."""
    from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)

    def look_at(prim, eye, target):
        frame = Gf.Matrix4d().SetLookAt(Gf.Vec3d(*eye), Gf.Vec3d(*target), Gf.Vec3d(*scene.UP)).GetInverse()
        UsdGeom.Xformable(prim).AddTransformOp().Set(frame)

    for view, angle in scene.VIEWS.items():
        camera = UsdGeom.Camera.Define(stage, f"/{view}")
        look_at(camera, scene.EYE, scene.TARGET)
        height = 2 * np.tan(np.radians(angle) / 2) * 50
        camera.CreateFocalLengthAttr(50.0)
        camera.CreateVerticalApertureAttr(height)
        camera.CreateHorizontalApertureAttr(height * scene.SIZE[0] / scene.SIZE[1])

    sky = UsdLux.DomeLight.Define(stage, "/sky")
    sky.CreateColorAttr(Gf.Vec3f(*scene.SKY))
    light = UsdLux.RectLight.Define(stage, "/light")
    light.CreateColorAttr(Gf.Vec3f(*scene.LIGHT_RADIANCE))
    light.CreateWidthAttr(2.0)
    light.CreateHeightAttr(2.0)
    look_at(light, scene.LIGHT_AT, (0, 0, 0))

    vertices, faces = skin()
    body = UsdGeom.Mesh.Define(stage, "/skin")
    body.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(vertices * np.float32(scene.SKIN_RADIUS)))
    body.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(faces), 3, np.int32)))
    body.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(faces.reshape(-1)))
    body.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(vertices))
    body.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    body.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    body.CreateDisplayColorAttr([Gf.Vec3f(*scene.SKIN_COLOR[ball])])

    shader = UsdShade.Shader.Define(stage, "/hair/fiber")
    shader.CreateIdAttr("VellusFur")
    for name, value in scene.our_fiber(ball).items():
        if isinstance(value, tuple):
            shader.CreateInput(name, Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*value))
        else:
            shader.CreateInput(name, Sdf.ValueTypeNames.Float).Set(value)
    material = UsdShade.Material.Define(stage, "/hair")
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")

    fur = UsdGeom.BasisCurves.Define(stage, "/fur")
    fur.CreateTypeAttr(UsdGeom.Tokens.cubic)
    fur.CreateBasisAttr(UsdGeom.Tokens.bspline)
    fur.CreateWrapAttr(UsdGeom.Tokens.nonperiodic)
    fur.CreateCurveVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(points), points.shape[1], np.int32)))
    fur.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.reshape(-1, 3)))
    fur.CreateWidthsAttr(Vt.FloatArray.FromNumpy(np.tile(2 * radii, len(points)).astype(np.float32)))
    fur.SetWidthsInterpolation(UsdGeom.Tokens.vertex)
    UsdShade.MaterialBindingAPI.Apply(fur.GetPrim()).Bind(material)
    stage.GetRootLayer().Save()


def main(folder):
    for name, ball in scene.BALLS.items():
        points, radii = grow(*ball)
        np.savez(folder / f"{name}.npz", points=points, radii=radii)
        write_text(folder / f"{name}.txt", points, radii)
        write_usd(folder / f"{name}.usdc", name, points, radii)
    vertices, faces = skin()
    np.savez(folder / "skin.npz", vertices=vertices, faces=faces)
    write_ply(folder / "skin.ply", vertices, faces)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
