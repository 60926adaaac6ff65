//! Text and binary layers as OpenUSD writes and reads them.

use super::{FOUR, said, scene};
use crate::common::{pixar, read, read_text};
use std::path::Path;
use vellus_usd::Options;

/// OpenUSD writes 360.0 as 360. A single real number is one in samples, too, whatever its type.
#[test]
fn whole_numbers_in_samples_are_read_as_real_ones() {
    let at = |body: &str, frame: f64| {
        let body = format!("( startTimeCode = 1 endTimeCode = 3 ) {body}");
        read_text(&body, &Options { frame: Some(frame), ..Options::default() }).unwrap().0
    };
    for kind in ["half", "float", "double"] {
        let turn = format!(
            "def Xform \"t\" {{ {kind} xformOp:rotateZ.timeSamples = {{ 1: 0, 3: 180 }}
                uniform token[] xformOpOrder = [\"xformOp:rotateZ\"]
                def BasisCurves \"c\" {{ {FOUR} }} }}"
        );
        assert!((at(&turn, 2.0).strands[0].points[3].y - 3.0).abs() < 1e-5, "{kind}");
    }
    for (kind, samples) in [
        ("double3", "1: (0, 0, 0), 3: (2, 4, 6)"),
        ("float3", "1: (0, 0, 0), 3: (2, 4, 6)"),
        ("half3", "1: (0, 0, 0), 3: (2, 4, 6)"),
    ] {
        let shift = format!(
            "def BasisCurves \"c\" {{ {FOUR} {kind} xformOp:translate.timeSamples = {{ {samples} }}
                uniform token[] xformOpOrder = [\"xformOp:translate\"] }}"
        );
        assert_eq!(at(&shift, 2.0).strands[0].points[0].truncate().to_array(), [1.0, 2.0, 3.0], "{kind}");
    }
    let lit = format!(
        "def BasisCurves \"c\" {{ {FOUR} }} def DomeLight \"l\" {{
        float inputs:intensity.timeSamples = {{ 1: 1, 3: 3, }} }}
        def Camera \"k\" {{ float focalLength.timeSamples = {{ 3: 30, 1: 10 }} float horizontalAperture = 20 }}"
    );
    let scene = at(&lit, 2.0);
    assert!(matches!(scene.lights[0].shape, vellus_scene::LightShape::Dome { radiance: [2.0, 2.0, 2.0], .. }));
    assert_eq!(scene.camera.unwrap().film_width, 1.0);
}

/// The empty path of a reference to the default prim has a place in the table of paths, and no encoding.
#[test]
fn binary_layers_may_refer_to_default_prims() {
    for name in ["ref.usdc", "pay.usdc"] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/usdc").join(name);
        assert_eq!(read(&file, &Options::default()).unwrap().0.strands.len(), 1, "{name}");
    }
}

#[test]
fn expressions_do_not_refuse_a_layer() {
    let (_, warnings) = scene(&format!(
        "def BasisCurves \"c\" {{ {FOUR} }}
        def DomeLight \"l\" {{ pathExpression collection:lightLink:membershipExpression = \"//\"
            pathExpression[] more = [\"//\"] }}"
    ));
    let said = said(&warnings);
    assert!(said.contains("/l: collection:lightLink:membershipExpression has no effect"), "{said}");
    assert!(said.contains("/l: more is not read"), "{said}");
}

#[test]
fn newer_versions_comments_and_names_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.usda");
    let curves = "def BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
        point3f[] points = [(0,0,0), (1,0,0)] float[] widths = [1, 1] rel material:binding = </m>
        float[] primvars:größe = [0.5] }";
    let fur = "def Material \"m\" { token outputs:surface.connect = </m/s.outputs:surface> float inputs:Größe = 1.3
        def Shader \"s\" { uniform token info:id = \"VellusFur\" float inputs:eta.connect = </m.inputs:Größe>
            float inputs:kappa.connect = </m/r.outputs:result> token outputs:surface }
        def Shader \"r\" { uniform token info:id = \"UsdPrimvarReader_float\" string inputs:varname = \"größe\" } }";
    for text in [
        format!("#usda 1.0\n{curves} {fur}"),
        format!("#usda 1.1\n// a\n{curves}\n/* b\n */ {fur} # c"),
        format!(
            "#usda 1.0\n( doc = \"x\" // a\n /* b */ upAxis = \"Z\" ) // c\n{curves} {fur} custom uint[] n = [1, 2]"
        )
        .replace(" custom uint[] n = [1, 2]", ""),
    ] {
        std::fs::write(&path, &text).unwrap();
        let (scene, _) = read(&path, &Options::default()).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let strands = &scene.strands[0];
        assert_eq!((scene.looks[strands.look].fiber.eta, strands.varying.len()), (1.3, 1), "{text}");
    }
    let (_, warnings) =
        scene(&format!("def BasisCurves \"c\" {{ {FOUR} custom uint[] n = [1, 2] custom uint64[] o = [3] }}"));
    assert_eq!(said(&warnings), "");
}

/// A string that stands for a file is found beside the layer that has it.
#[test]
fn files_may_be_named_by_strings() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("look")).unwrap();
    let mut image = Vec::new();
    let mut encoder = png::Encoder::new(&mut image, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 0, 0]).unwrap();
    std::fs::write(folder.path().join("look/a.png"), image).unwrap();
    let material = "#usda 1.0\ndef Material \"m\" { token outputs:surface.connect = </m/s.outputs:surface>
        def Shader \"s\" { uniform token info:id = \"VellusFur\" color3f inputs:reflectance.connect = </m/t.outputs:rgb>
            token outputs:surface }
        def Shader \"t\" { uniform token info:id = \"UsdUVTexture\" string inputs:file = \"a.png\"
            float3 outputs:rgb } }";
    std::fs::write(folder.path().join("look/m.usda"), material).unwrap();
    let top = format!(
        "#usda 1.0\ndef \"m\" ( references = @look/m.usda@</m> ) {{}}
        def BasisCurves \"c\" {{ {FOUR} rel material:binding = </m> texCoord2f[] primvars:st = [(0,0)] }}"
    );
    std::fs::write(folder.path().join("top.usda"), top).unwrap();
    let reading = vellus_usd::read(&folder.path().join("top.usda"), &Options::default()).unwrap();
    assert_eq!(reading.scene.textures[0].pixels.get(0), [1.0, 0.0, 0.0], "{:?}", reading.warnings);
    assert!(reading.sources.iter().any(|(name, _)| name == "look/a.png"));
}

/// Types from before USD was published, and an image of a light with samples.
/// A string after an attribute with a file is no file: here the names of variants.
#[test]
fn variants_follow_attributes_with_files() {
    let (scene, warnings) = scene(&format!(
        "( )
def Scope \"s\" ( variants = {{ string v = \"b\" }} prepend variantSets = \"v\" ) {{
    variantSet \"v\" = {{
        \"a\" {{ custom asset x = @a.png@ }}
        \"b\" {{ custom asset x = @b.png@ (doc = \"file\")
            def BasisCurves \"c\" {{ {FOUR} }} }}
        \"c\" {{ }}
    }}
}}"
    ));
    assert_eq!(scene.strands.len(), 1, "{}", said(&warnings));
}

#[test]
fn old_types_and_samples_of_files_are_read() {
    let (scene, warnings) = scene(&format!(
        "def BasisCurves \"c\" {{ {} }} def DomeLight \"d\" {{
            asset inputs:texture:file.timeSamples = {{ 1: @@, 2: @@ }} }}",
        FOUR.replace("point3f[]", "PointFloat[]")
    ));
    assert_eq!((scene.strands[0].points.len(), said(&warnings).as_str()), (4, ""));
}

/// A path as the value of a token is its text, as in OpenUSD. Connections and relationships stay paths.
#[test]
fn paths_as_words_and_vectors_in_lower_case_are_read() {
    let (scene, warnings) = scene(&format!(
        "def BasisCurves \"c\" {{ {} custom token word = \"a\" rel
            material:binding = </m> vec3f[] extent = [(0, 0, 0), (3, 0, 0)]
            custom string from = </somewhere/else> custom token to = </c.points> ( doc = \"x\" ) }}
        def Material \"m\" {{ token outputs:ri:surface = </m/other.outputs:out>
            token outputs:surface.connect = </m/s.outputs:surface>
            def Shader \"s\" {{ uniform token info:id = \"VellusFur\" float inputs:eta = 1.4
                token outputs:surface }} }}",
        FOUR.replace("point3f[]", "vec3f[]")
    ));
    assert_eq!((scene.strands[0].points.len(), said(&warnings).as_str()), (4, ""));
    assert_eq!(scene.looks[scene.strands[0].look].fiber.eta, 1.4);
}

/// Layers of the oldest versions of the binary format that Pixar's library still writes.
#[test]
fn old_binary_layers_are_read() {
    let Some(_) = pixar() else { return };
    let script = "import sys; from pxr import Usd; Usd.Stage.Open(sys.argv[1]).Export(sys.argv[2])";
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("text.usda");
    let body = format!(
        "#usda 1.0\n(\nstartTimeCode = 1\nendTimeCode = 3\n)
        def Xform \"g\" {{\n double3 xformOp:translate.timeSamples = {{ 1: (0, 0, 0), 3: (2, 4, 6) }}
            uniform token[] xformOpOrder = [\"xformOp:translate\"]
            def BasisCurves \"c\" {{\n{FOUR}\n}}\n def BasisCurves \"d\" {{\n{FOUR}
            string[] words = [\"a\", \"b\"]\n string vellus:name = \"d\"\n}}\n}}\n"
    );
    std::fs::write(&text, body).unwrap();
    let options = Options { frame: Some(2.0), ..Options::default() };
    let (expected, warnings) = read(&text, &options).unwrap();
    let expected_said = said(&warnings);
    for version in ["0.4.0", "0.5.0", "0.6.0", "0.7.0"] {
        let file = folder.path().join(format!("{version}.usdc"));
        let mut python = pixar().unwrap();
        python.env("USD_WRITE_NEW_USDC_FILES_AS_VERSION", version).args(["-c", script]);
        assert!(python.arg(&text).arg(&file).status().unwrap().success());
        let (scene, warnings) = read(&file, &options).unwrap();
        assert_eq!((said(&warnings), &scene.strands), (expected_said.clone(), &expected.strands), "{version}");
    }
}

/// Binary layers as OpenUSD writes them: empty arrays of strings and files are empty, and splines, which the
/// decoder does not know, are named.
#[test]
fn binary_layers_have_empty_arrays_of_strings_and_named_splines() {
    let Some(mut python) = pixar() else { return };
    let folder = tempfile::tempdir().unwrap();
    let [text, binary] = ["a.usda", "a.usdc"].map(|name| folder.path().join(name));
    let body = "#usda 1.0
def BasisCurves \"c\"
{
    uniform token type = \"linear\"
    int[] curveVertexCounts = [2]
    point3f[] points = [(0,0,0), (1,0,0)]
    float[] widths = [1, 1]
    string[] primvars:s = []
    asset[] primvars:a = []
    string[] primvars:t.timeSamples = { 1: [], 2: [\"x\"] }
    double xformOp:translateX = 7
    double xformOp:translateX.spline = { 1: 2; post linear, 3: 4; post held }
    uniform token[] xformOpOrder = [\"xformOp:translateX\"]
}
";
    std::fs::write(&text, body).unwrap();
    let script = "import sys; from pxr import Sdf; Sdf.Layer.FindOrOpen(sys.argv[1]).Export(sys.argv[2])";
    assert!(python.args(["-c", script]).arg(&text).arg(&binary).status().unwrap().success());
    let options = Options { frame: Some(2.0), ..Options::default() };
    let x = |file: &std::path::Path| {
        let (scene, warnings) = read(file, &options).unwrap();
        (scene.strands[0].points[0].x, warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
    };
    let (from_text, said) = x(&text);
    assert!(from_text == 3.0 && !said.contains("broken") && !said.contains("spline"), "{said}");
    let (from_binary, said) = x(&binary);
    let named = "/c: xformOp:translateX has a spline in a binary layer, which is not supported";
    assert!(from_binary == 7.0 && said.contains(named) && !said.contains("broken"), "{said}");
}
