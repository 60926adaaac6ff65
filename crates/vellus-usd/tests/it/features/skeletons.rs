//! Skeletons, their animations, skinning and blend shapes.

use super::{said, scene};
use crate::common::{pixar, read, read_text};
use glam::Vec3;
use vellus_usd::Options;

const MATRIX: &str = "((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,0,1))";

/// A rig with two joints: `a` at the origin and `a/b` one above. The animation moves `a` and turns it by 90° about z.
fn rig(bound: &str) -> String {
    let above = MATRIX.replace("(0,0,0,1)", "(0,1,0,1)");
    format!(
        "def SkelRoot \"rig\" {{
    def Skeleton \"skel\" ( prepend apiSchemas = [\"SkelBindingAPI\"] ) {{
        uniform token[] joints = [\"a\", \"a/b\"]
        uniform matrix4d[] bindTransforms = [{MATRIX}, {above}]
        uniform matrix4d[] restTransforms = [{MATRIX}, {above}]
        rel skel:animationSource = </rig/anim>
    }}
    def SkelAnimation \"anim\" {{
        uniform token[] joints = [\"a\"]
        float3[] translations = [(1, 0, 0)]
        float3[] translations.timeSamples = {{ 1: [(1, 0, 0)], 2: [(2, 0, 0)] }}
        quatf[] rotations = [(0.70710677, 0, 0, 0.70710677)]
        half3[] scales = [(1, 1, 1)]
        uniform token[] blendShapes = [\"other\", \"smile\"]
        float[] blendShapeWeights = [0, 0.5]
    }}
    {bound}
}}"
    )
}

fn api(kind: &str, name: &str, body: &str) -> String {
    format!("def {kind} \"{name}\" ( prepend apiSchemas = [\"SkelBindingAPI\"] ) {{ {body} }}")
}

const TO_SKELETON: &str = "rel skel:skeleton = </rig/skel>
    double3 xformOp:translate = (0, 0, 7) uniform token[] xformOpOrder = [\"xformOp:translate\"]";

fn influences(interpolation: &str, indices: &str, weights: &str) -> String {
    let kind = format!("( interpolation = \"{interpolation}\" )");
    format!("int[] primvars:skel:jointIndices = {indices} {kind} float[] primvars:skel:jointWeights = {weights} {kind}")
}

fn mesh(more: &str) -> String {
    let body = format!(
        "{TO_SKELETON} uniform token subdivisionScheme = \"none\" int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2] point3f[] points = [(0,0,0), (1,0,0), (0,2,0)] {more}"
    );
    api("Mesh", "m", &body)
}

#[track_caller]
fn near(a: &[Vec3], b: &[Vec3]) {
    assert!(a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.abs_diff_eq(*b, 1e-5)), "{a:?} {b:?}");
}

/// A joint that moves by (1, 0, 0) and turns x to y moves the points, whatever the transform of their prim is.
#[test]
fn skeletons_move_meshes_and_curves() {
    let posed = [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::new(-1.0, 0.0, 0.0)];
    let (scene_, warnings) = scene(&rig(&mesh(&influences("constant", "[0]", "[1]"))));
    assert_eq!(said(&warnings), "");
    near(&scene_.meshes[0].positions, &posed);
    let strand = format!(
        "{TO_SKELETON} uniform token type = \"linear\" int[] curveVertexCounts = [3] float[] widths = [1, 1, 1]
    point3f[] points = [(0,0,0), (1,0,0), (0,2,0)] {}",
        influences("vertex", "[0, 1, 1, 0, 0, 0]", "[1, 0, 0.25, 0.75, 1, 0]")
    );
    let (scene, warnings) = scene(&rig(&api("BasisCurves", "hair", &strand)));
    assert_eq!(said(&warnings), "");
    let points: Vec<Vec3> = scene.strands[0].points.iter().map(|p| p.truncate()).collect();
    near(&points, &posed);
}

/// Weights are not normalised, as in OpenUSD: half the weight is half the way from the skeleton.
#[test]
fn weights_binds_and_orders_are_those_of_usd() {
    let read = |more: &str| scene(&rig(&mesh(more))).0.meshes.remove(0);
    near(&read(&influences("constant", "[0]", "[0.5]")).positions[..1], &[0.5 * Vec3::X]);
    let bind = MATRIX.replace("(0,0,0,1)", "(5,0,0,1)");
    let bind = format!("matrix4d primvars:skel:geomBindTransform = {bind} {}", influences("constant", "[0]", "[1]"));
    near(&read(&bind).positions[..1], &[Vec3::new(1.0, 5.0, 0.0)]);
    // The only joint of this order is the second of the skeleton, which follows the first.
    let order = format!("uniform token[] skel:joints = [\"a/b\"] {}", influences("constant", "[0]", "[1]"));
    near(&read(&order).positions[..1], &[Vec3::X]);
    // Without influences, a mesh keeps its place.
    near(&read("").positions[..1], &[7.0 * Vec3::Z]);
}

#[test]
fn normals_turn_with_their_joints() {
    for (kind, count) in [("vertex", 3), ("faceVarying", 3)] {
        let normals = vec!["(0, 1, 0)"; count].join(", ");
        let more = format!("normal3f[] normals = [{normals}] ( interpolation = \"{kind}\" )");
        let (scene, _) = scene(&rig(&mesh(&format!("{more} {}", influences("constant", "[0]", "[1]")))));
        near(&scene.meshes[0].normals.as_ref().unwrap()[0], &[-Vec3::X; 3]);
    }
}

#[test]
fn poses_at_both_ends_of_the_shutter_blur() {
    let body = rig(&mesh(&influences("constant", "[0]", "[1]")));
    let body =
        format!("( startTimeCode = 1 endTimeCode = 2 )\n{body}\ndef Camera \"c\" {{ double shutter:close = 0.5 }}");
    let (scene, _) = read_text(&body, &Options::default()).unwrap();
    let mesh = &scene.meshes[0];
    near(&mesh.positions[..1], &[Vec3::X]);
    near(&mesh.moved.as_ref().unwrap()[..1], &[1.5 * Vec3::X]);
}

#[test]
fn bindings_are_inherited_and_moved_shapes_too() {
    let group = format!("rel skel:skeleton = </rig/skel> {}", influences("constant", "[0]", "[1]"));
    let body = format!("{group} def Cube \"cube\" {{ }}");
    let (scene, warnings) = scene(&rig(&api("Xform", "group", &body)));
    assert_eq!(said(&warnings), "");
    let points = &scene.meshes[0].positions;
    let middle = points.iter().sum::<Vec3>() / points.len() as f32;
    near(&[middle], &[Vec3::X]);
}

/// Half of an offset of (0, 0, 4), before the skeleton moves the point.
#[test]
fn blend_shapes_move_points() {
    let target = "def BlendShape \"smile\" { vector3f[] offsets = [(0, 0, 4)] int[] pointIndices = [1] }";
    let binding = "uniform token[] skel:blendShapes = [\"smile\"] rel skel:blendShapeTargets = </rig/m/smile>";
    let posed = mesh(&format!("{binding} {} {target}", influences("constant", "[0]", "[1]")));
    let (scene_, warnings) = scene(&rig(&posed));
    assert_eq!(said(&warnings), "");
    near(&scene_.meshes[0].positions, &[Vec3::X, Vec3::new(1.0, 1.0, 2.0), Vec3::new(-1.0, 0.0, 0.0)]);
    let odd = posed.replace("[1] }", "[3] }");
    let (_, warnings) = scene(&rig(&odd));
    assert!(said(&warnings).contains("/rig/m/smile: its offsets do not match"), "{}", said(&warnings));
    // A shape at the weight 0.4 goes on to the whole one: (0.5 − 0.4) / 0.6 of the way from 1 to 4 is 1.5. One at 0.8
    // is reached from the rest: 0.5 / 0.8 of 1 is 0.625. Without a weight, a shape has no effect.
    for (weight, z) in [("weight = 0.4", 1.5), ("weight = 0.8", 0.625), ("", 2.0)] {
        let shapes = format!("vector3f[] inbetweens:half = [(0, 0, 1)] ( {weight} )\nvector3f[] offsets");
        let (scene, warnings) = scene(&rig(&posed.replace("vector3f[] offsets", &shapes)));
        assert_eq!(said(&warnings), "", "{weight}");
        near(&scene.meshes[0].positions[1..2], &[Vec3::new(1.0, 1.0, z)]);
    }
}

/// A flaw of a rig leaves its meshes in their rest pose, with a warning that names it.
#[test]
fn flaws_leave_the_rest_pose() {
    let whole = influences("constant", "[0]", "[1]");
    let good = rig(&mesh(&whole));
    let table = [
        (rig(&mesh(&influences("constant", "[7]", "[1]"))), "jointIndices[0] is 7 with the weight 1"),
        (rig(&mesh(&influences("vertex", "[0, 0]", "[1, 1]"))), "2 jointIndices and 2 jointWeights for 3 points"),
        (good.replace("def SkelRoot", "def Xform"), "not below a SkelRoot"),
        (good.replace("float3[] translations", "float3[] other"), "it has 1 joints, but 0 translations"),
        (
            good.replace("uniform matrix4d[] bindTransforms", "uniform matrix4d[] other"),
            "2 joints and 0 bindTransforms",
        ),
        (good.replace("1: [(1, 0, 0)]", "1: [(inf, 0, 0)]"), "the joint a must be finite"),
        (rig(&mesh(&influences("constant", "[0]", "[3e38]")).replace("(1,0,0), (0,2", "(9,0,0), (0,2")), "to infinity"),
        (good.replace("</rig/skel>", "</rig/none>"), "/rig/none: there is no such skeleton"),
        (
            rig(&mesh(&whole).replace("[\"SkelBindingAPI\"]", "[\"MaterialBindingAPI\"]")),
            "SkelBindingAPI is not applied",
        ),
    ];
    for (body, message) in table {
        let (scene, warnings) = scene(&body);
        assert!(said(&warnings).contains(message), "{message}: {}", said(&warnings));
        let first = scene.meshes[0].positions[0];
        assert!(first.x == 0.0 && first.y == 0.0, "{message}: {first}");
    }
    let method = format!("uniform token primvars:skel:skinningMethod = \"magic\" {whole}");
    let (_, warnings) = scene(&rig(&mesh(&method)));
    assert!(
        said(&warnings).contains("the skinning method magic is not supported: it is linear"),
        "{}",
        said(&warnings)
    );
}

/// Random rigs have the points of OpenUSD's `BakeSkinning`.
#[test]
fn random_rigs_agree_with_openusd() {
    let Some(mut python) = pixar() else { return };
    let folder = tempfile::tempdir().unwrap();
    let script = r#"
import random, sys
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt
out = sys.argv[1]
for seed in range(20):
    random.seed(seed)
    r = lambda: random.uniform(-1, 1)
    def matrix(scale):
        turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(r(), r(), r()), 180 * r()))
        return Gf.Matrix4d().SetScale(scale) * turn * Gf.Matrix4d().SetTranslate(Gf.Vec3d(r(), r(), r()))
    def place():
        return matrix(Gf.Vec3d(1 + 0.3 * r()))
    def bone():
        return matrix(Gf.Vec3d(1 + 0.3 * r(), 1 + 0.3 * r(), 1 + 0.3 * r()))
    stage = Usd.Stage.CreateNew(f"{out}/{seed}.usda")
    stage.SetStartTimeCode(1); stage.SetEndTimeCode(3)
    root = UsdSkel.Root.Define(stage, "/rig")
    root.AddTransformOp().Set(place())
    skel = UsdSkel.Skeleton.Define(stage, "/rig/skel")
    skel.AddTransformOp().Set(place())
    joints = ["a", "a/b", "a/b/c", "a/d", "e"]
    skel.CreateJointsAttr(joints)
    skel.CreateBindTransformsAttr([bone() for _ in joints])
    skel.CreateRestTransformsAttr([bone() for _ in joints])
    moved = random.sample(joints, 4)
    anim = UsdSkel.Animation.Define(stage, "/rig/anim")
    anim.CreateJointsAttr(moved)
    anim.CreateBlendShapesAttr(["p", "q"])
    for time in (1, 2, 3):
        anim.CreateTranslationsAttr().Set([Gf.Vec3f(r(), r(), r()) for _ in moved], time)
        quats = [Gf.Quatf(r(), r(), r(), r()).GetNormalized() for _ in moved]
        anim.CreateRotationsAttr().Set(Vt.QuatfArray(quats), time)
        anim.CreateScalesAttr().Set(Vt.Vec3hArray([Gf.Vec3h(1 + 0.3 * r(), 1 + 0.3 * r(), 1) for _ in moved]), time)
        anim.CreateBlendShapeWeightsAttr().Set([r(), r()], time)
    UsdSkel.BindingAPI.Apply(skel.GetPrim()).CreateAnimationSourceRel().SetTargets(["/rig/anim"])
    def bind(prim, points, rigid):
        api = UsdSkel.BindingAPI.Apply(prim)
        api.CreateSkeletonRel().SetTargets(["/rig/skel"])
        api.CreateGeomBindTransformAttr().Set(bone())
        order = random.sample(joints, 5) if seed % 2 else joints
        if seed % 2:
            api.CreateJointsAttr(order)
        count = 2 if rigid else 2 * points
        api.CreateJointIndicesPrimvar(rigid, 2).Set([random.randrange(5) for _ in range(count)])
        weights = [random.random() for _ in range(count)]
        if seed % 4 == 3:
            prim.CreateAttribute("primvars:skel:skinningMethod", Sdf.ValueTypeNames.Token).Set("dualQuaternion")
            weights = [w / (weights[i - i % 2] + weights[i - i % 2 + 1]) for i, w in enumerate(weights)]
        api.CreateJointWeightsPrimvar(rigid, 2).Set(weights)
        UsdGeom.Xformable(prim).AddTransformOp().Set(place())
    mesh = UsdGeom.Mesh.Define(stage, "/rig/mesh")
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.CreatePointsAttr([Gf.Vec3f(r(), r(), r()) for _ in range(9)])
    mesh.CreateFaceVertexCountsAttr([3, 3, 3])
    mesh.CreateFaceVertexIndicesAttr(list(range(9)))
    bind(mesh.GetPrim(), 9, False)
    api = UsdSkel.BindingAPI(mesh.GetPrim())
    api.CreateBlendShapesAttr(["q", "p"])
    api.CreateBlendShapeTargetsRel().SetTargets(["/rig/mesh/q", "/rig/mesh/p"])
    for name, points in (("q", [1, 5]), ("p", [5, 0, 8])):
        shape = UsdSkel.BlendShape.Define(stage, f"/rig/mesh/{name}")
        shape.CreateOffsetsAttr([Gf.Vec3f(r(), r(), r()) for _ in points])
        shape.CreatePointIndicesAttr(points)
    curves = UsdGeom.BasisCurves.Define(stage, "/rig/curves")
    curves.CreateTypeAttr("linear")
    curves.CreateCurveVertexCountsAttr([3, 4])
    curves.CreatePointsAttr([Gf.Vec3f(r(), r(), r()) for _ in range(7)])
    curves.CreateWidthsAttr([0.1] * 7)
    bind(curves.GetPrim(), 7, seed % 3 == 0)
    camera = UsdGeom.Camera.Define(stage, "/eye")
    camera.CreateShutterCloseAttr(1)
    stage.GetRootLayer().Save()
    UsdSkel.BakeSkinning(stage.Traverse())
    for prim in (mesh, curves):
        # Baked points are only exact at the samples.
        for time in (1, 2):
            to_world = UsdGeom.XformCache(time).GetLocalToWorldTransform(prim.GetPrim())
            points = [to_world.Transform(Gf.Vec3d(p)) for p in prim.GetPointsAttr().Get(time)]
            print(*[x for p in points for x in p])
"#;
    let output = python.args(["-c", script]).arg(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines = text.lines().map(|line| -> Vec<Vec3> {
        let numbers: Vec<f32> = line.split(' ').map(|x| x.parse().unwrap()).collect();
        numbers.chunks_exact(3).map(Vec3::from_slice).collect()
    });
    let mut worst = 0.0f32;
    for seed in 0..20 {
        let (scene, warnings) = read(&folder.path().join(format!("{seed}.usda")), &Options::default()).unwrap();
        assert_eq!(said(&warnings), "");
        let (mesh, curves) = (&scene.meshes[0], &scene.strands[0]);
        let open: Vec<Vec3> = curves.points.iter().map(|p| p.truncate()).collect();
        let all = [&mesh.positions, mesh.moved.as_ref().unwrap(), &open, curves.moved.as_ref().unwrap()];
        for (time, ours) in all.into_iter().enumerate() {
            let theirs = lines.next().unwrap();
            assert_eq!(ours.len(), theirs.len());
            let size = theirs.iter().map(|p| p.length()).fold(1.0, f32::max);
            for (a, b) in ours.iter().zip(&theirs) {
                // Their baked points have single precision, in a space that a scale of 0.7³ and its inverse separate.
                let away = a.distance(*b) / size;
                worst = worst.max(away);
                assert!(away < 1e-5, "rig {seed}, {time}: {a} {b}");
            }
        }
    }
    println!("largest distance from OpenUSD, relative to the size: {worst:e}");
}
