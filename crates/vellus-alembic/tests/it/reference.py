"""Reads an archive of the tests with the library of Alembic, checks it, and writes a part of it: OURS THEIRS."""

import sys

import imath
from alembic3d import Abc, AbcCoreAbstract, AbcGeom

ours, theirs = sys.argv[1:]


def equal(found, expected):
    if found != expected:
        raise SystemExit(f"{found} instead of {expected}")


def child(parent, name):
    return next(parent.getChild(i) for i in range(parent.getNumChildren()) if parent.getChild(i).getName() == name)


archive = Abc.IArchive(ours)
top = archive.getTop()
fox = AbcGeom.IXform(child(top, "fox"), Abc.WrapExistingFlag.kWrapExisting)
equal(fox.getSchema().getNumSamples(), 2)
matrix = fox.getSchema().getValue(Abc.ISampleSelector(1)).getMatrix()
equal([matrix[3][i] for i in range(4)], [2.0, 2.0, 3.0, 1.0])
equal([matrix[0][i] for i in range(4)], [0.0, 1.0, 0.0, 0.0])
coat = AbcGeom.ICurves(child(fox, "coat"), Abc.WrapExistingFlag.kWrapExisting)
schema = coat.getSchema()
equal(schema.getNumSamples(), 3)
times = schema.getTimeSampling()
equal([times.getSampleTime(i) for i in range(3)], [0.5, 0.75, 1.0])
for i, shift in enumerate([0.0, 1.0, 1.0]):
    sample = schema.getValue(Abc.ISampleSelector(i))
    equal([p[0] for p in sample.getPositions()], [k + shift for k in range(7)])
    equal(list(sample.getCurvesNumVertices()), [4, 3])
    equal(str(sample.getType()), "kCubic")
    equal(str(sample.getBasis()), "kCatmullromBasis")
    widths = schema.getWidthsParam().getExpandedValue(Abc.ISampleSelector(i))
    equal(str(widths.getScope()), "kVertexScope")
    equal([round(x, 6) for x in widths.getVals()], [round(0.1 + shift, 6)] * 7)
equal(list(sample.getKnots()), [0.0, 1.0, 2.0])
equal(list(sample.getOrders()), [4, 3])
bounds = sample.getSelfBounds()
equal((bounds.min()[0], bounds.max()[0]), (1.0, 7.0))
arbitrary = schema.getArbGeomParams()
names = [arbitrary.getPropertyHeader(i).getName() for i in range(arbitrary.getNumProperties())]
equal(len(names), 15)
for kind, name, values in [
    (AbcGeom.IBooleanGeomParam, "Bool", [1, 0]),
    (AbcGeom.IUcharGeomParam, "U8", [1, 0]),
    (AbcGeom.ICharGeomParam, "I8", [1, 0]),
    (AbcGeom.IInt16GeomParam, "I16", [1, 0]),
    (AbcGeom.IInt32GeomParam, "I32", [1, 0]),
    (AbcGeom.IInt64GeomParam, "I64", [1, 0]),
    (AbcGeom.IStringGeomParam, "text", ["", "a b", "\u00e9"]),
]:
    value = kind(arbitrary, name).getExpandedValue()
    equal([type(values[0])(x) for x in value.getVals()], values)
uv = AbcGeom.IV2fGeomParam(arbitrary, "groom_root_uv")
equal(uv.isIndexed(), True)
equal(str(uv.getScope()), "kUniformScope")
equal([(round(v[0], 6), round(v[1], 6)) for v in uv.getExpandedValue().getVals()], [(0.3, 0.4), (0.1, 0.2), (0.3, 0.4)])
equal(AbcGeom.IsAncestorInvisible(coat, Abc.ISampleSelector(0)), True)
skin = AbcGeom.IPolyMesh(child(fox, "skin"), Abc.WrapExistingFlag.kWrapExisting).getSchema()
mesh = skin.getValue()
equal(list(mesh.getFaceIndices()), [0, 3, 2, 1])
equal(list(mesh.getFaceCounts()), [4])
equal(skin.getNormalsParam().getScope().name, "kFacevaryingScope")
smooth = AbcGeom.ISubD(child(fox, "smooth"), Abc.WrapExistingFlag.kWrapExisting).getSchema().getValue()
equal(smooth.getSubdivisionScheme(), "catmull-clark")
eye = AbcGeom.ICamera(child(top, "eye"), Abc.WrapExistingFlag.kWrapExisting).getSchema().getValue()
equal((eye.getFocalLength(), eye.getHorizontalAperture(), eye.getVerticalFilmOffset()), (50.0, 3.6, -0.2))
equal((eye.getLensSqueezeRatio(), eye.getOverScanTop(), eye.getFStop()), (1.5, 0.3, 2.8))


def array(kind, values):
    found = kind(len(values))
    for i, value in enumerate(values):
        found[i] = value
    return found


def write():
    out = Abc.OArchive(theirs)
    index = out.addTimeSampling(AbcCoreAbstract.TimeSampling(0.25, 0.5))
    fox = AbcGeom.OXform(out.getTop(), "fox", index)
    for x in [1.0, 2.0]:
        sample = AbcGeom.XformSample()
        sample.setMatrix(imath.M44d(0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, x, 2, 3, 1))
        fox.getSchema().set(sample)
    coat = AbcGeom.OCurves(fox, "coat", index)
    arbitrary = coat.getSchema().getArbGeomParams()
    uniform = AbcGeom.GeometryScope.kUniformScope
    whole = AbcGeom.OInt32GeomParam(arbitrary, "I32", False, uniform, 1)
    root = AbcGeom.OV2fGeomParam(arbitrary, "groom_root_uv", True, uniform, 1)
    long = AbcGeom.OInt16GeomParam(arbitrary, "I16", False, uniform, 1)
    for shift in [0.0, 1.0]:
        # The numbers of the tests are of single precision.
        points = array(imath.V3fArray, [imath.V3f(i + shift, -0.5, z) for i, z in enumerate(heights)])
        sample = AbcGeom.OCurvesSchemaSample(
            points, array(imath.IntArray, [4, 3]), AbcGeom.CurveType.kCubic, AbcGeom.CurvePeriodicity.kNonPeriodic
        )
        sample.setBasis(AbcGeom.BasisType.kCatmullromBasis)
        widths = array(imath.FloatArray, [0.1 + shift] * 7)
        sample.setWidths(AbcGeom.OFloatGeomParamSample(widths, AbcGeom.GeometryScope.kVertexScope))
        coat.getSchema().set(sample)
    whole.set(AbcGeom.OInt32GeomParamSample(array(imath.IntArray, [1, 0]), uniform))
    long.set(AbcGeom.OInt16GeomParamSample(array(imath.ShortArray, [1, 0]), uniform))
    pairs = array(imath.V2fArray, [imath.V2f(0.1, 0.2), imath.V2f(0.3, 0.4)])
    root.set(AbcGeom.OV2fGeomParamSample(pairs, array(imath.UnsignedIntArray, [1, 0, 1]), uniform))
    eye = AbcGeom.OCamera(out.getTop(), "eye")
    sample = AbcGeom.CameraSample()
    sample.setFocalLength(50.0)
    sample.setHorizontalAperture(3.6)
    sample.setHorizontalFilmOffset(0.1)
    sample.setVerticalAperture(2.4)
    sample.setVerticalFilmOffset(-0.2)
    sample.setLensSqueezeRatio(1.5)
    for side, value in [("Left", 0.1), ("Right", 0.2), ("Top", 0.3), ("Bottom", 0.4)]:
        getattr(sample, f"setOverScan{side}")(value)
    sample.setFStop(2.8)
    sample.setFocusDistance(120.0)
    sample.setShutterOpen(-0.01)
    sample.setShutterClose(0.01)
    sample.setNearClippingPlane(0.1)
    sample.setFarClippingPlane(1e5)
    eye.getSchema().set(sample)


heights = [p[2] for p in schema.getValue(Abc.ISampleSelector(0)).getPositions()]
write()
