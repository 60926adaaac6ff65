"""What the tests of `vellus.mitsuba` share. Importing it skips a module where Mitsuba or LLVM is missing."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

mi = pytest.importorskip("mitsuba", reason="the package mitsuba is not installed")
# Without the package, this folder itself could be imported by its name.
if not hasattr(mi, "set_variant"):
    pytest.skip("the package mitsuba is not installed", allow_module_level=True)
dr = pytest.importorskip("drjit")
try:
    mi.set_variant("llvm_ad_rgb")
    dr.eval(mi.Float([1, 2]) + 1)
except Exception as error:
    pytest.skip(f"no LLVM library for llvm_ad_rgb: set DRJIT_LIBLLVM_PATH ({error})", allow_module_level=True)

import vellus  # noqa: E402
import vellus.mitsuba  # noqa: E402

ROOT = Path(__file__).resolve().parents[4]
NUMBERS = ("eta", "kappa", "alpha", "beta_m", "beta_n", "sigma_ms", "g", "layers")
COLORS = ("sigma_ca", "sigma_ma")
BOTH = ("vellus", "vellus_drjit")
# A fibre with all lobes.
FIBER = dict(
    eta=1.55,
    kappa=0.7,
    alpha=2.0,
    beta_m=7.0,
    beta_n=7.0,
    sigma_ms=2.0,
    g=0.5,
    layers=0.7,
    sigma_ca=[0.1, 0.2, 0.3],
    sigma_ma=[0.05, 0.1, 0.2],
)


def values(fiber):
    """The parameters of a `vellus.Fiber` as numbers and lists."""
    three = lambda x: [float(y) for y in np.broadcast_to(x, 3)]
    return {n: getattr(fiber, n) for n in NUMBERS} | {n: three(getattr(fiber, n)) for n in COLORS}


def directions(g, n):
    """Uniform directions, shape (n, 3)."""
    x, phi = g.uniform(-0.999, 0.999, n), g.uniform(-np.pi, np.pi, n)
    s = np.sqrt(1 - x * x)
    return np.stack([x, s * np.cos(phi), s * np.sin(phi)], -1).astype(np.float32)


def columns(F, a):
    """The columns of an array as Dr.Jit arrays."""
    return [F(np.ascontiguousarray(a[:, i])) for i in range(a.shape[1])]


def fur(strands, seed=1, radius=0.02):
    """Control points of uniform cubic B-splines on the unit sphere, (strands, 8, 3), and radii, (8,).

    Both ends are thin: Vellus closes strands with balls, Mitsuba leaves them open.
    """
    g = np.random.default_rng(seed)
    root = g.normal(size=(strands, 3))
    root /= np.linalg.norm(root, axis=1, keepdims=True)
    lean = np.cross(root, [0.0, 0.0, 1.0]) * 0.5 + g.normal(size=(strands, 3)) * 0.2
    t = np.linspace(-0.15, 1.15, 8)[None, :, None]
    points = root[:, None] * (1 + 0.5 * t) + lean[:, None] * 0.4 * t * t
    t = t[0, :, 0]
    radii = np.where(np.abs(t - 0.5) < 0.4, radius * (1 - 0.6 * t), 0.02 * radius)
    return points.astype(np.float32), radii.astype(np.float32)


def write_curves(path, points, radii):
    """Curves for `bsplinecurve`.

    The last one is too thin for any ray: Mitsuba 3.9.1 reads past its list of segments where a ray hits the very end of
    the last segment, and may crash.
    """
    last = np.linspace([0, 0, 0], [1e-4, 0, 0], len(radii))
    with open(path, "w") as file:
        for curve, width in [*((curve, radii) for curve in points), (last, np.full(len(radii), 1e-7))]:
            file.writelines("%.7g %.7g %.7g %.7g\n" % (*p, r) for p, r in zip(curve, width))
            file.write("\n")


def load(curves, bsdf, sky=(0.4, 0.45, 0.5), depth=9, size=64, light=True, more=None):
    rgb = lambda value: {"type": "rgb", "value": list(value)}
    place = lambda o: mi.ScalarTransform4f().look_at(origin=o, target=[0, 0, 0], up=[0, 0, 1])
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    lamp = {"type": "area", "radiance": rgb(LIGHT)}
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": depth, "rr_depth": 1000},
        "sky": {"type": "constant", "radiance": rgb(sky)},
        "fur": {"type": "bsplinecurve", "filename": str(curves), "bsdf": bsdf},
        "sensor": {
            "type": "perspective",
            "fov": FOV,
            "fov_axis": "y",
            "to_world": place(EYE),
            "film": film,
            "sampler": {"type": "independent"},
        },
    }
    scene |= more or {}
    if light:
        scene["light"] = {"type": "rectangle", "to_world": place([3, -3, 4]), "emitter": lamp}
    return mi.load_dict(scene)


EYE, FOV, LIGHT = [0.0, -5.0, 1.0], 36.0, (16.0, 15.0, 13.0)


def render(scene, bsdf, **options):
    """A picture as an array of NumPy. `bsdf`: which of `BOTH` it has."""
    if bsdf == "vellus":
        with vellus.mitsuba.arrays():
            return np.array(mi.render(scene, **options))
    return np.array(mi.render(scene, **options))


def command():
    """The command `vellus`, or None."""
    path = Path(os.environ.get("VELLUS_COMMAND", ROOT / "target/release/vellus"))
    return path if path.is_file() else None


def vellus_picture(folder, points, radii, preset, size, spp):
    """The same scene as `load`, rendered by `vellus render`."""
    mi_look = np.array(mi.ScalarTransform4f().look_at(origin=EYE, target=[0, 0, 0], up=[0, 0, 1]).matrix)
    lamp = np.array(mi.ScalarTransform4f().look_at(origin=[3, -3, 4], target=[0, 0, 0], up=[0, 0, 1]).matrix)
    # Cameras and lights of USD look along −z, those of Mitsuba along z. USD writes rows of points.
    turn = np.diag([-1.0, 1, -1, 1])
    matrix = lambda m: "(" + ", ".join("(" + ", ".join(f"{x:.9g}" for x in row) + ")" for row in (m @ turn).T) + ")"
    aperture = 2 * np.tan(np.radians(FOV) / 2) * 50
    triples = ", ".join("(%.7g, %.7g, %.7g)" % tuple(p) for p in points.reshape(-1, 3))
    widths = ", ".join("%.7g" % w for w in np.tile(2 * radii, len(points)))
    counts = ", ".join([str(points.shape[1])] * len(points))
    transform = (
        lambda m: f'matrix4d xformOp:transform = {matrix(m)}\n    uniform token[] xformOpOrder = ["xformOp:transform"]'
    )
    (folder / "ball.usda").write_text(f"""#usda 1.0
(
    upAxis = "Z"
)
def Camera "view"
{{
    float focalLength = 50
    float horizontalAperture = {aperture:.9g}
    float verticalAperture = {aperture:.9g}
    {transform(mi_look)}
}}
def DomeLight "sky"
{{
    color3f inputs:color = (0.4, 0.45, 0.5)
}}
def RectLight "light"
{{
    color3f inputs:color = {LIGHT}
    float inputs:width = 2
    float inputs:height = 2
    {transform(lamp)}
}}
def Material "hair"
{{
    token outputs:surface.connect = </hair/fiber.outputs:surface>
    def Shader "fiber"
    {{
        uniform token info:id = "VellusFur"
        string inputs:preset = "{preset}"
        token outputs:surface
    }}
}}
def BasisCurves "fur" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{{
    uniform token type = "cubic"
    uniform token basis = "bspline"
    uniform token wrap = "nonperiodic"
    int[] curveVertexCounts = [{counts}]
    point3f[] points = [{triples}]
    float[] widths = [{widths}] (
        interpolation = "vertex"
    )
    rel material:binding = </hair>
}}
""")
    options = "--camera view --mode near --max-depth 8 --filter box --layers beauty --float".split()
    call = [
        command(),
        "render",
        "ball.usda",
        *options,
        "--size",
        f"{size}x{size}",
        "--spp",
        str(spp),
        "--output",
        "ball.exr",
    ]
    subprocess.run(call, cwd=folder, check=True, capture_output=True)
    bitmap = mi.Bitmap(str(folder / "ball.exr")).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return np.array(bitmap)
