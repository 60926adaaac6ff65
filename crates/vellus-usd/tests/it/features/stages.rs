//! Composition of stages, and prims that are skipped.

use super::{FOUR, said, scene};
use crate::common::{read, read_text, told};
use vellus_usd::Options;

#[test]
fn hidden_and_unsupported_prims_are_skipped_with_one_warning() {
    let curve = format!("{{ {FOUR} }}");
    let with = |attribute: &str| format!("{{ {FOUR}\n {attribute} }}");
    let (scene, warnings) = scene(&format!(
        "def BasisCurves \"shown\" {curve}
def BasisCurves \"inactive\" ( active = false ) {curve}
def BasisCurves \"invisible\" {}
def Xform \"guides\" {{ token purpose = \"guide\"
    def BasisCurves \"guide\" {curve}
    def BasisCurves \"seen\" {} }}
def Xform \"hidden\" {{ token visibility = \"invisible\"
    def BasisCurves \"below\" {} }}
over \"nothing\" {{ def BasisCurves \"undefined\" {curve} }}
class \"_class\" {{ def BasisCurves \"abstract\" {curve} }}
def BasisCurves \"ring\" {}
def Volume \"ball\" {{}}
def Volume \"ball2\" {{}}
def PointInstancer \"many\" {{ def BasisCurves \"prototype\" {curve} }}",
        with("token visibility = \"invisible\""),
        with("token purpose = \"render\""),
        with("token visibility = \"inherited\""),
        with("uniform token basis = \"hermite\""),
    ));
    let names: Vec<_> = scene.strands.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["/shown", "/guides/seen"]);
    let said = said(&warnings);
    assert!(said.contains("/ring: curves of the basis hermite are not supported"), "{said}");
    assert!(said.contains("/ball, /ball2: Volume is not supported"), "{said}");
    assert!(said.contains("/many: it has no positions"), "{said}");
    assert_eq!(warnings.len(), 3);
}

#[test]
fn references_sublayers_and_instances_compose() {
    let folder = tempfile::tempdir().unwrap();
    let save = |name: &str, body: &str| std::fs::write(folder.path().join(name), format!("#usda 1.0\n{body}")).unwrap();
    save("fur.usda", &format!("( defaultPrim = \"Fur\" )\ndef Xform \"Fur\" {{ def BasisCurves \"c\" {{ {FOUR} }} }}"));
    save("under.usda", "over \"one\" { over \"c\" { point3f[] points = [(5,0,0), (6,0,0), (7,0,0), (8,0,0)] } }");
    let place = |name: &str, x: f32, meta: &str| {
        format!(
            "def Xform \"{name}\" ( {meta} prepend references = @./fur.usda@ ) {{
    double3 xformOp:translate = ({x}, 0, 0) uniform token[] xformOpOrder = [\"xformOp:translate\"] }}\n"
        )
    };
    let body = format!(
        "( subLayers = [@./under.usda@] )\n{}{}{}",
        place("one", 0.0, ""),
        place("two", 10.0, "instanceable = true"),
        place("three", 20.0, "instanceable = true")
    );
    save("stage.usda", &body);
    let (scene, warnings) = read(&folder.path().join("stage.usda"), &Options::default()).unwrap();
    assert_eq!(said(&warnings), "");
    let roots: Vec<f32> = scene.strands.iter().map(|s| s.points[0].x).collect();
    assert_eq!(roots, [5.0, 10.0, 20.0]);
    assert_eq!(scene.looks.len(), 1);
}

#[test]
fn a_stage_with_nothing_to_render_says_what_it_has() {
    let mesh = "int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0,0,0), (1,0,0), (1,1,0)]";
    for (body, expected) in [
        (
            "def TetMesh \"a\" {} def TetMesh \"b\" {} def Volume \"c\" {}",
            "2 TetMesh (not supported), 1 Volume (not sup",
        ),
        ("def NurbsPatch \"a\" {}", "it has 1 NurbsPatch (not supported)"),
        ("def ArnoldProcedural \"a\" {}", "it has 1 ArnoldProcedural (not known)"),
        (&format!("def Mesh \"a\" {{ {mesh} token visibility = \"invisible\" }}"), "it has 1 Mesh (invisible)"),
        (
            &format!("def Scope \"g\" {{ token purpose = \"guide\" def Mesh \"a\" {{ {mesh} }} }}"),
            "Mesh (purpose guide)",
        ),
        (
            &format!(
                "def Xform \"g\" {{ uniform token[] xformOpOrder = [\"xformOp:spin\"] float xformOp:spin = 1
                def Mesh \"a\" {{ {mesh} }} }}"
            ),
            "it has 1 Mesh (left out, or below a prim that is) (/g: xformOp:spin is not a known transform",
        ),
        (
            &format!("over \"A\" {{ def Mesh \"a\" {{ {mesh} }} }} class \"_B\" {{}}"),
            "no prims that are defined and active; /A (over: only changes what another layer defines); /_B (class",
        ),
        ("def Cube \"off\" ( active = false ) {}", "/off (inactive: not a part of the stage)"),
        (
            "def Material \"m\" {} def Material \"n\" {} def Camera \"c\" {}",
            "no strands and meshes, only 2 Material, 1 Cam",
        ),
        (
            "( defaultPrim = \"World\" ) def Xform \"a\" {}",
            "only groups without content; its defaultPrim World does not exist",
        ),
        ("( defaultPrim = \"World\" ) def Xform \"World\" {}", "nothing to render: it has only groups without content"),
    ] {
        let said = told(read_text(body, &Options::default()));
        assert!(said.contains("nothing to render: ") && said.contains(expected), "{said}");
    }
}
