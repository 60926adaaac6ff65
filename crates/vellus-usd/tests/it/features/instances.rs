//! Native instances and PointInstancer.

use super::FOUR;
use super::said;
use crate::common::{read_text, told};
use glam::{Mat4, Vec3, Vec4};
use vellus_scene::{Scene, Strands};
use vellus_usd::{Options, Warning};

/// Reads a stage with instances that share their prototypes.
fn shared(body: &str) -> (Scene, Vec<Warning>) {
    read_text(body, &Options { instances: true, ..Options::default() }).unwrap()
}

fn error(body: &str) -> String {
    told(read_text(body, &Options { instances: true, ..Options::default() }))
}

/// The sum over all strands of the distances between the points of two scenes, and of the differences of radii.
#[track_caller]
fn same_points(a: &Scene, b: &Scene) {
    let points = |scene: &Scene| scene.strands.iter().flat_map(|s| s.points.clone()).collect::<Vec<Vec4>>();
    let (a, b) = (points(a), points(b));
    assert_eq!(a.len(), b.len());
    a.iter().zip(&b).for_each(|(a, b)| assert!(a.abs_diff_eq(*b, 1e-5), "{a} {b}"));
}

/// A class with strands under a transform and a mesh, three native instances of it, and one that has a primvar.
fn herd(extra: &str) -> String {
    format!(
        "class \"cat\" {{
    def Xform \"coat\" {{
        double3 xformOp:translate = (0, 1, 0)
        uniform token[] xformOpOrder = [\"xformOp:translate\"]
        def BasisCurves \"fur\" {{ {FOUR} }}
    }}
    def Mesh \"skin\" {{
        uniform token subdivisionScheme = \"none\"
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    }}
    def SphereLight \"eye\" {{ }}
}}
def Xform \"herd\" {{
    double3 xformOp:translate = (0, 0, 10)
    uniform token[] xformOpOrder = [\"xformOp:translate\"]
    def \"one\" ( instanceable = true inherits = </cat> ) {{ }}
    def Xform \"two\" ( instanceable = true inherits = </cat> ) {{
        double3 xformOp:translate = (5, 0, 0)
        float xformOp:rotateY = 90
        float3 xformOp:scale = (2, 2, 2)
        uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateY\", \"xformOp:scale\"]
    }}
    def \"three\" ( instanceable = true inherits = </cat> ) {{ {extra} }}
}}
"
    )
}

#[test]
fn native_instances_share_strands_and_meshes() {
    let (scene, warnings) = shared(&herd(""));
    assert_eq!(said(&warnings), "");
    assert_eq!((scene.prototypes.len(), scene.instances.len(), scene.lights.len()), (1, 3, 3));
    assert!(scene.strands.is_empty() && scene.meshes.is_empty());
    let [strands] = &scene.prototypes[0].strands[..] else { panic!() };
    assert_eq!((strands.name.as_str(), strands.points[1]), ("/herd/one/coat/fur", Vec4::new(1.0, 1.0, 0.0, 0.1)));
    assert_eq!(scene.prototypes[0].meshes.len(), 1);
    assert_eq!(scene.instances[0].to_world, Mat4::from_translation(10.0 * Vec3::Z));
    let place = scene.instances[1].to_world.transform_point3(Vec3::X);
    assert!(place.abs_diff_eq(Vec3::new(5.0, 0.0, 8.0), 1e-5), "{place}");

    // Without the option, they are copies at the same places.
    let (copied, _) = read_text(&herd(""), &Options::default()).unwrap();
    assert_eq!((copied.instances.len(), copied.strands.len(), copied.meshes.len()), (0, 3, 3));
    assert!((copied.strands[1].points[0].w - 0.2).abs() < 1e-6);
    let mut again = scene;
    again.copy_instances();
    same_points(&again, &copied);
}

/// An instance with a primvar, a material, another size in each direction or a moving transform of its own does not
/// share.
#[test]
fn instances_that_differ_are_read_separately() {
    let binding = "rel material:binding = </m>";
    let primvar = "float[] primvars:vellus:kappa = [0.5] ( interpolation = \"constant\" )";
    let stretched = "float3 xformOp:scale = (1, 2, 1)\n uniform token[] xformOpOrder = [\"xformOp:scale\"]";
    for extra in [binding, primvar, stretched] {
        let material = "def Material \"m\" { token outputs:vellus:surface.connect = </m/f.outputs:out>
            def Shader \"f\" { uniform token info:id = \"VellusFur\" token outputs:out } }";
        let (scene, _) = shared(&format!("{}{material}", herd(extra)));
        assert_eq!((scene.instances.len(), scene.strands.len(), scene.meshes.len()), (2, 1, 1), "{extra}");
        assert_eq!(scene.strands[0].name, "/herd/three/coat/fur");
    }
    let (scene, _) = shared(&herd(primvar));
    assert!(scene.prototypes[0].strands[0].varying.is_empty() && !scene.strands[0].varying.is_empty());
}

/// Instances in instances: their content is composed once, and is where that of copies is. Bindings, connections and
/// collections inside lead to the prims of the same instance.
#[test]
fn content_of_nested_instances_is_that_of_copies() {
    let material = |name: &str, kappa: f32| {
        format!(
            "def Material \"{name}\" {{ token outputs:vellus:surface.connect = <f.outputs:out>
                def Shader \"f\" {{ uniform token info:id = \"VellusFur\" float inputs:kappa = {kappa}
                    token outputs:out }} }}"
        )
    };
    let place = |x: f32, more: &str| {
        format!(
            "double3 xformOp:translate = ({x}, 0, 0) {more}
            uniform token[] xformOpOrder = [\"xformOp:translate\"]"
        )
    };
    let levels = format!(
        "class \"lock\" {{
            def BasisCurves \"bound\" {{ {FOUR} rel material:binding = <../m> }}
            def BasisCurves \"collected\" {{ {FOUR} }}
            def BasisCurves \"hidden\" {{ {FOUR} token visibility = \"invisible\" }}
            {}
        }}
        class \"patch\" {{
            def Xform \"a\" ( instanceable = true inherits = </lock> ) {{ {} }}
            def Xform \"b\" ( instanceable = true inherits = </lock> ) {{ {} }}
            def Xform \"c\" ( instanceable = true references = </lock> ) {{ {} }}
            {}
            rel material:binding:collection:some = [<../patch.collection:some>, <n>]
            uniform token collection:some:expansionRule = \"expandPrims\"
            rel collection:some:includes = [<b/collected>]
        }}
        def Xform \"S\" {{
            def Xform \"p\" ( instanceable = true inherits = </patch> ) {{ {} }}
            def Xform \"q\" ( instanceable = true inherits = </patch> ) {{ {} }}
            def Xform \"r\" ( instanceable = true references = </patch> ) {{ {} }}
            def \"s\" ( instanceable = true references = </patch> ) {{ {} }}
        }}",
        material("m", 0.7),
        place(1.0, ""),
        place(2.0, ""),
        place(4.0, ""),
        material("n", 0.4),
        place(10.0, ""),
        place(20.0, ""),
        place(40.0, ""),
        place(80.0, "token visibility = \"invisible\""),
    );
    let scene = |body: &str| read_text(body, &Options::default()).unwrap().0;
    let (instances, copies) = (scene(&levels), scene(&levels.replace("instanceable = true", "")));
    // Shared content comes last.
    let sets = |scene: &Scene| {
        let set =
            |s: &Strands| (s.points.iter().map(|p| p.to_array()).collect::<Vec<_>>(), scene.looks[s.look].fiber.kappa);
        let mut all: Vec<_> = scene.strands.iter().map(set).collect();
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        all
    };
    assert_eq!(sets(&copies).len(), 3 * 3 * 2);
    assert_eq!(sets(&instances), sets(&copies));
    assert!(sets(&copies).iter().any(|(_, kappa)| *kappa == 0.4), "the collection has no member");
}

/// A written scene keeps its instances, and the file has the points of a prototype once.
#[test]
fn written_instances_share_again() {
    let (mut scene, _) = shared(&herd(""));
    scene.lights.clear();
    scene.prototypes[0].name = "Scene".to_owned();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("herd.usda");
    vellus_usd::write(&scene, &file).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    assert_eq!((text.matches("points = ").count(), text.matches("instanceable").count()), (2, 3));
    let vellus_usd::Reading { scene: read, warnings, .. } =
        vellus_usd::read(&file, &Options { instances: true, ..Options::default() }).unwrap();
    assert!(warnings.is_empty(), "{}", said(&warnings));
    assert_eq!((&read.instances, &read.looks, read.prototypes.len()), (&scene.instances, &scene.looks, 1));
    assert_eq!(read.prototypes[0].strands, scene.prototypes[0].strands);
    assert_eq!(read.prototypes[0].meshes, scene.prototypes[0].meshes);
}

#[test]
fn usd_core_finds_written_instances() {
    const CHECK: &str = "
import sys
from pxr import Usd
stage = Usd.Stage.Open(sys.argv[1])
instances = [p for p in stage.Traverse() if p.IsInstance()]
kinds = sorted(str(p.GetTypeName()) for p in stage.GetPrototypes()[0].GetChildren())
print(len(stage.GetPrototypes()), len(instances), *kinds)
";
    let Some(mut python) = crate::common::pixar() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("herd.usda");
    vellus_usd::write(&shared(&herd("")).0, &file).unwrap();
    let run = python.arg("-c").arg(CHECK).arg(&file).output().unwrap();
    let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert_eq!((out.trim(), err.as_ref()), ("1 3 BasisCurves Mesh", ""));
}

fn instancer(attributes: &str) -> String {
    format!(
        "def PointInstancer \"herd\" {{
    double3 xformOp:translate = (0, 0, 10)
    uniform token[] xformOpOrder = [\"xformOp:translate\"]
    rel prototypes = [</herd/cat>, </other/dog>]
    {attributes}
    def Xform \"cat\" {{
        float3 xformOp:scale = (2, 2, 2)
        uniform token[] xformOpOrder = [\"xformOp:scale\"]
        def BasisCurves \"fur\" {{ {FOUR} }}
    }}
}}
def Xform \"other\" {{
    double3 xformOp:translate = (100, 0, 0)
    uniform token[] xformOpOrder = [\"xformOp:translate\"]
    def BasisCurves \"dog\" {{ {FOUR} }}
}}
"
    )
}

const PLACES: &str = "int[] protoIndices = [0, 1, 0, 0]
    point3f[] positions = [(0, 0, 0), (1, 2, 3), (4, 0, 0), (5, 0, 0)]
    quath[] orientations = [(1, 0, 0, 0), (0.7071, 0, 0.7071, 0), (1, 0, 0, 0), (1, 0, 0, 0)]
    float3[] scales = [(1, 1, 1), (3, 3, 3), (1, 1, 2), (1, 1, 1)]
    int64[] ids = [7, 8, 9, 10]
    int64[] invisibleIds = [10]";

#[test]
fn a_point_instancer_places_its_prototypes() {
    let (scene, warnings) = shared(&instancer(PLACES));
    // Dog is shown where it is, too. The stretched instance is a copy.
    assert_eq!((scene.prototypes.len(), scene.instances.len(), scene.strands.len()), (2, 2, 2));
    assert!(said(&warnings).contains("another scale in each direction"), "{}", said(&warnings));
    // The transform of the prototype itself counts, but not those of its parents.
    let cat = &scene.prototypes[scene.instances[0].prototype].strands[0];
    assert_eq!(cat.points[1], Vec4::new(2.0, 0.0, 0.0, 0.2));
    assert_eq!(scene.instances[0].to_world, Mat4::from_translation(10.0 * Vec3::Z));
    let dog = &scene.prototypes[scene.instances[1].prototype].strands[0];
    assert_eq!(dog.points[1], Vec4::new(1.0, 0.0, 0.0, 0.1));
    // x turns to −z about y, three times as long, at (1, 2, 13).
    let place = scene.instances[1].to_world.transform_point3(Vec3::X);
    assert!(place.abs_diff_eq(Vec3::new(1.0, 2.0, 10.0), 1e-3), "{place}");
    let copy = scene.strands.iter().find(|strands| strands.name == "/herd/cat/fur").unwrap();
    assert!(copy.points[1].truncate().abs_diff_eq(Vec3::new(6.0, 0.0, 10.0), 1e-5));
    // The mean of the scales 2, 2 and 4.
    assert!((copy.points[1].w - 0.1 * 16f32.cbrt()).abs() < 1e-5);
}

/// A width for curves without one is in world space for native instances.
#[test]
fn a_default_width_is_that_of_the_first_instance() {
    let bare = herd("").replace("float[] widths = [0.2] (interpolation = \"constant\")", "");
    let options = Options { instances: true, default_width: Some(0.4), ..Options::default() };
    let (scene, _) = read_text(&bare, &options).unwrap();
    assert_eq!(scene.prototypes[0].strands[0].points[0].w, 0.2);
}

#[test]
fn broken_instancers_are_refused() {
    assert!(
        error(&instancer("int[] protoIndices = [2] point3f[] positions = [(0, 0, 0)]"))
            .contains("protoIndices[0] is 2")
    );
    let short = error(&instancer("int[] protoIndices = [0] point3f[] positions = [(0, 0, 0), (1, 0, 0)]"));
    assert!(short.contains("protoIndices has 1 values, but there are 2 positions"), "{short}");
    let infinite = error(&instancer("int[] protoIndices = [0] point3f[] positions = [(inf, 0, 0)]"));
    assert!(infinite.contains("must be finite"), "{infinite}");
    let far = error(&instancer("int[] protoIndices = [0] point3f[] positions = [(1e20, 0, 0)]"));
    assert!(far.contains("within ±1e9"), "{far}");
    let flat = "int[] protoIndices = [0] point3f[] positions = [(0, 0, 0)] float3[] scales = [(0, 1, 1)]";
    let (scene, warnings) = shared(&instancer(flat));
    assert!(scene.instances.is_empty() && said(&warnings).contains("the scale 0"));
}

/// An `over` keeps prototypes from being drawn by themselves (UsdGeomPointInstancer). What is defined below it
/// counts, with its own transform and that of its children, and materials that are there, too.
#[test]
fn prototypes_may_be_below_an_over() {
    let body = format!(
        "def PointInstancer \"herd\" {{ point3f[] positions = [(-10,0,0), (10,0,0)] int[] protoIndices = [0, 0]
            rel prototypes = </herd/Prototypes/cat>
            over \"Prototypes\" {{ double3 xformOp:translate = (0, 50, 0)
                uniform token[] xformOpOrder = [\"xformOp:translate\"]
                def Xform \"cat\" {{ double3 xformOp:translate = (0, 0, 5)
                    uniform token[] xformOpOrder = [\"xformOp:translate\"]
                    def BasisCurves \"fur\" {{ {FOUR} }} over \"no\" {{ def BasisCurves \"x\" {{ {FOUR} }} }} }} }} }}"
    );
    let (scene, warnings) = read_text(&body, &Options::default()).unwrap();
    let firsts: Vec<_> = scene.strands.iter().map(|strands| strands.points[0].truncate()).collect();
    assert_eq!(firsts, [Vec3::new(-10.0, 0.0, 5.0), Vec3::new(10.0, 0.0, 5.0)], "{}", said(&warnings));
    assert_eq!(said(&warnings), "");
}

#[test]
fn instances_that_are_not_active_are_not_shown() {
    let body = |ids: &str, inactive: &str| {
        format!(
            "def PointInstancer \"herd\" ( {inactive} ) {{ point3f[] positions = [(0,0,0), (1,0,0), (2,0,0)]
                int[] protoIndices = [0, 0, 0] {ids} int64[] invisibleIds = [2] rel prototypes = </herd/p>
                def BasisCurves \"p\" {{ {FOUR} }} }}"
        )
    };
    for (ids, inactive, left) in
        [("", "", 2), ("", "inactiveIds = [0]", 1), ("int64[] ids = [7, 8, 2]", "prepend inactiveIds = [8, 9]", 1)]
    {
        let (scene, _) = read_text(&body(ids, inactive), &Options::default()).unwrap();
        assert_eq!(scene.strands.len(), left, "{ids} {inactive}");
    }
}

/// Points are instances of a sphere, of their own diameters.
#[test]
fn points_are_spheres() {
    let (scene, warnings) = shared(
        "def Points \"p\" { point3f[] points = [(1,2,3), (4,5,6), (7,8,9), (nan,0,0)] float[] widths = [2, 4, 0, 1]
        double3 xformOp:scale = (2, 2, 2) uniform token[] xformOpOrder = [\"xformOp:scale\"] }",
    );
    assert!(said(&warnings).contains("/p: 1 of 4 points are left out"), "{}", said(&warnings));
    let found: Vec<(f32, Vec3)> =
        scene.instances.iter().map(|i| (i.scale().unwrap(), i.to_world.w_axis.truncate())).collect();
    assert_eq!(found, [(2.0, Vec3::new(2.0, 4.0, 6.0)), (4.0, Vec3::new(8.0, 10.0, 12.0))]);
    let ball = &scene.prototypes[0].meshes[0];
    assert!(ball.positions.iter().all(|p| (p.length() - 1.0).abs() < 1e-6));
}

/// A prototype with instances of its own has copies of them. One that has itself is left out.
#[test]
fn instancers_are_inside_each_other() {
    let strand = format!("def BasisCurves \"hair\" {{ {FOUR} }}");
    let pair = |name: &str, y: &str, prototype: &str, inside: &str| {
        format!(
            "def PointInstancer \"{name}\" {{ point3f[] positions = [(0,0,0), (0,{y},0)] int[] protoIndices = [0, 0]
            rel prototypes = <{prototype}>\n{inside} }}"
        )
    };
    let inner = pair("tuft", "1", "/herd/animal/tuft/hair", &strand);
    let body = pair("herd", "10", "/herd/animal", &format!("def Xform \"animal\" {{ {inner} }}"));
    let (read, warnings) = shared(&body);
    assert_eq!((said(&warnings).as_str(), read.instances.len(), read.strands.len()), ("", 2, 0));
    let copies = &read.prototypes[read.instances[0].prototype].strands;
    assert_eq!(copies.iter().map(|strands| strands.points[0].y).collect::<Vec<_>>(), [0.0, 1.0]);
    let circle = pair("tuft", "1", "/herd/animal", "");
    let body = pair("herd", "10", "/herd/animal", &format!("def Xform \"animal\" {{ {circle} {strand} }}"));
    let (read, warnings) = shared(&body);
    assert!(said(&warnings).contains("inside each other"), "{}", said(&warnings));
    assert!(!read.prototypes.is_empty());
}
