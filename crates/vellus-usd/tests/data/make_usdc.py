"""Writes usdc/: binary layers of Pixar's library (usd-core 26.11) that refer to the default prim of another layer."""
from pathlib import Path

from pxr import Usd, UsdGeom

folder = Path(__file__).parent / "usdc"
folder.mkdir(exist_ok=True)
base = Usd.Stage.CreateNew(str(folder / "base.usda"))
base.SetDefaultPrim(UsdGeom.Xform.Define(base, "/A").GetPrim())
curves = UsdGeom.BasisCurves.Define(base, "/A/c")
curves.CreateTypeAttr("linear")
curves.CreateCurveVertexCountsAttr([2])
curves.CreatePointsAttr([(0, 0, 0), (1, 0, 0)])
curves.CreateWidthsAttr([1, 1])
base.Save()
for name in ("ref", "pay"):
    stage = Usd.Stage.CreateNew(str(folder / f"{name}.usdc"))
    prim = UsdGeom.Xform.Define(stage, "/X").GetPrim()
    (prim.GetReferences().AddReference if name == "ref" else prim.GetPayloads().AddPayload)("base.usda")
    stage.Save()
