//! A flaw in a part of a stage is a warning. The rest is read.

use super::{FOUR, said, scene};
use crate::common::{read, read_text, with_width};
use vellus_scene::{Basis, Scene};
use vellus_usd::{Fault, Options, Warning};

const GOOD: &str = "def BasisCurves \"good\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
    point3f[] points = [(0,0,0), (1,0,0)] float[] widths = [1, 1] }";

fn has(warnings: &[Warning], fault: Option<Fault>, parts: &[&str]) -> bool {
    warnings.iter().any(|w| w.fault == fault && parts.iter().all(|part| w.to_string().contains(part)))
}

/// Strands with one point, with NaN, with a negative width and with too few points of their basis.
#[test]
fn broken_strands_are_left_out_and_counted() {
    let (read, warnings) = scene(
        "def BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2, 1, 2, 2]
            point3f[] points = [(0,0,0), (1,0,0), (5,0,0), (2,0,0), (nan,0,0), (3,0,0), (4,0,0)]
            float[] widths = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]
            texCoord2f[] primvars:st = [(0,0), (.1,0), (.2,0), (.3,0)] (interpolation = \"uniform\") }",
    );
    let strands = &read.strands[0];
    assert_eq!((strands.len(), strands.points[2].x, strands.points[3].w), (2, 3.0, 0.35));
    assert_eq!(strands.root_uv.as_ref().unwrap()[1].x, 0.3);
    assert!(has(&warnings, None, &["/c: 2 of 4 strands are left out (strand 1, 2)"]), "{}", said(&warnings));
    for (basis, wrap) in [("bspline", "nonperiodic"), ("catmullRom", "pinned"), ("bezier", "nonperiodic")] {
        let (read, warnings) = scene(&format!(
            "def BasisCurves \"c\" {{ uniform token basis = \"{basis}\" uniform token wrap = \"{wrap}\"
            int[] curveVertexCounts = [1, 4] float[] widths = [1] (interpolation = \"constant\")
            point3f[] points = [(9,0,0), (0,0,0), (1,0,0), (2,0,0), (3,0,0)] }}"
        ));
        assert_eq!(read.strands[0].len(), 1, "{basis}");
        assert!(said(&warnings).contains("1 of 2 strands are left out (strand 0)"), "{basis}: {}", said(&warnings));
    }
    let (read, _) = scene(&format!(
        "{GOOD} def BasisCurves \"c\" {{ uniform token type = \"linear\" int[] curveVertexCounts = [2, 2]
        point3f[] points = [(0,0,0), (1,0,0), (0,1,0), (1,1,0)]
            float[] widths = [1, -1] (interpolation = \"uniform\") }}"
    ));
    assert_eq!(read.strands[1].len(), 1);
}

#[test]
fn prims_that_cannot_be_read_are_left_out() {
    for (body, message) in [
        ("def BasisCurves \"bad\" { int[] curveVertexCounts = [-1] }", "/bad: curveVertexCounts[0] is -1"),
        ("def Mesh \"bad\" { point3f[] points = [(0,0,0)] int[] faceVertexCounts = [3] }", "/bad: faceVertexCounts"),
        (
            "def Mesh \"bad\" { point3f[] points = [(0,0,0), (nan,0,0), (0,1,0)] int[] faceVertexCounts = [3]
                int[] faceVertexIndices = [0, 1, 2] }",
            "/bad: points[1] is [NaN, 0.0, 0.0]: it must be finite",
        ),
        ("def SphereLight \"bad\" { float inputs:radius = -1 }", "/bad: inputs:radius is -1"),
        ("def SphereLight \"bad\" { float inputs:intensity = 1e38 float inputs:exposure = 60 }", "/bad: "),
        (
            "def Xform \"bad\" { double3 xformOp:translate = (nan, 0, 0)
                uniform token[] xformOpOrder = [\"xformOp:translate\"]
                def BasisCurves \"c\" {} }",
            "/bad: xformOp:translate must be finite: it and what is in it are left out",
        ),
        ("def Sphere \"bad\" { double radius = -1 }", "/bad: its size must be finite and not negative"),
        (
            "def SphereLight \"bad\" { float inputs:diffuse = -1
            rel collection:lightLink:excludes = </c> }",
            "/bad: inputs:d",
        ),
        ("def RenderSettings \"bad\" { uniform token resolution = \"big\" }", "/bad: resolution must be"),
        ("def PointInstancer \"bad\" { point3f[] positions = [(0,0,0)] }", "/bad: protoIndices has 0 values"),
    ] {
        let (read, warnings) = scene(&format!("{GOOD} {body}"));
        assert_eq!((read.strands.len(), read.meshes.len(), read.lights.len()), (1, 0, 0), "{body}");
        assert!(has(&warnings, Some(Fault::Prim), &[message]), "{}\n{body}", said(&warnings));
    }
}

#[test]
fn a_shutter_that_closes_before_it_opens_is_a_warning_unless_the_camera_is_named() {
    let body = format!("( startTimeCode = 1 ) {GOOD} def Camera \"k\" {{ double shutter:open = 1 }}");
    let (read, warnings) = scene(&body);
    assert!(read.camera.is_some() && has(&warnings, Some(Fault::Prim), &["/k: the shutter opens at 1"]));
    let named = Options { camera: Some("k".to_owned()), ..Options::default() };
    assert!(read_text(&body, &named).unwrap_err().to_string().contains("the shutter opens at 1"));
}

fn material(shaders: &str) -> String {
    format!(
        "def Material \"m\" {{ token outputs:surface.connect = </m/s.outputs:surface> {shaders} }}
        def BasisCurves \"c\" {{ uniform token type = \"linear\" int[] curveVertexCounts = [2] float[] widths = [1]
            point3f[] points = [(0,0,0), (1,0,0)] rel material:binding = </m> }}"
    )
}

#[test]
fn materials_that_cannot_be_read_give_the_fallback() {
    for (shader, message) in [
        ("token inputs:preset = \"unicorn\"", "unicorn"),
        ("float inputs:eta = nan", "inputs:eta is NaN"),
        ("float inputs:eta.connect = </m/s.inputs:eta>", "in a circle"),
    ] {
        let body = material(&format!(
            "def Shader \"s\" {{ uniform token info:id = \"VellusFur\" {shader} token outputs:surface }}"
        ));
        let (read, warnings) = scene(&body);
        assert_eq!(read.looks[read.strands[0].look].name, vellus_usd::FALLBACK_LOOK, "{shader}");
        let parts = ["/m", message, "curves with it get the fallback fibre"];
        assert!(has(&warnings, Some(Fault::Material), &parts), "{}", said(&warnings));
    }
    let mesh = "def Material \"m\" { token outputs:surface.connect = </m/s.outputs:surface>
            def Shader \"s\" { uniform token info:id = \"UsdPreviewSurface\" color3f inputs:emissiveColor = (-1, 0, 0)
                token outputs:surface } }
        def Mesh \"a\" { point3f[] points = [(0,0,0), (1,0,0), (0,1,0)] int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2] rel material:binding = </m>
            color3f[] primvars:displayColor = [(0.25, 0.5, 0.75)] }";
    let (read, warnings) = scene(mesh);
    assert_eq!(read.surfaces[read.meshes[0].surface].color.color, [0.25, 0.5, 0.75]);
    assert!(has(&warnings, Some(Fault::Material), &["inputs:emissiveColor", "displayColor"]), "{}", said(&warnings));
}

/// The message names the input that the file has, not only the parameter.
#[test]
fn values_out_of_range_are_clamped_with_the_name_of_the_input() {
    let body = material(
        "def Shader \"s\" { uniform token info:id = \"arnold:standard_hair\" float inputs:roughness = 0
            token outputs:surface }",
    );
    let (read, warnings) = scene(&body);
    let fiber = read.looks[read.strands[0].look].fiber;
    assert!((fiber.beta_n.to_degrees() - 0.1).abs() < 1e-5, "{}", fiber.beta_n.to_degrees());
    assert!(
        has(&warnings, None, &["/m/s: inputs:roughness gives beta_n", "it is clamped to 0.1"]),
        "{}",
        said(&warnings)
    );
    let body = material(
        "def Shader \"s\" { uniform token info:id = \"VellusFur\" float inputs:eta = 9 token outputs:surface }",
    );
    let (_, warnings) = scene(&body);
    assert!(has(&warnings, None, &["/m/s: inputs:eta is 9: the range is"]), "{}", said(&warnings));
    let surface = "def Material \"m\" { token outputs:surface.connect = </m/s.outputs:surface>
            def Shader \"s\" { uniform token info:id = \"UsdPreviewSurface\" float inputs:roughness = 1.5
                float inputs:ior = 0 token outputs:surface } }
        def Mesh \"a\" { point3f[] points = [(0,0,0), (1,0,0), (0,1,0)] int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2] rel material:binding = </m> }";
    let (read, warnings) = scene(surface);
    let surface = &read.surfaces[read.meshes[0].surface];
    assert_eq!((surface.roughness, surface.ior), (1.0, 1.0));
    assert!(said(&warnings).contains("inputs:roughness is 1.5: it must be in [0, 1], so it is clamped to 1"));
}

/// A missing image and one that is no image, on curves, a mesh and a light.
#[test]
fn textures_that_cannot_be_read_show_their_fallback_or_a_marked_colour() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("no.png"), "this is no image").unwrap();
    let stage = |file: &str, fallback: &str| {
        let body = format!(
            "#usda 1.0\ndef Material \"m\" {{ token outputs:surface.connect = </m/s.outputs:surface>
                token outputs:vellus:surface.connect = </m/f.outputs:surface>
                def Shader \"f\" {{ uniform token info:id = \"VellusFur\" token outputs:surface
                    color3f inputs:reflectance.connect = </m/t.outputs:rgb> }}
                def Shader \"s\" {{ uniform token info:id = \"UsdPreviewSurface\" token outputs:surface
                    color3f inputs:diffuseColor.connect = </m/t.outputs:rgb> }}
                def Shader \"t\" {{ uniform token info:id = \"UsdUVTexture\" asset inputs:file = @{file}@ {fallback}
                    float3 outputs:rgb }} }}
            def DomeLight \"sky\" {{ asset inputs:texture:file = @{file}@ }}
            def BasisCurves \"c\" {{ uniform token type = \"linear\" int[] curveVertexCounts = [2] float[] widths = [1]
                point3f[] points = [(0,0,0), (1,0,0)] rel material:binding = </m> texCoord2f[] primvars:st = [(0,0)] }}"
        );
        let path = folder.path().join("stage.usda");
        std::fs::write(&path, body).unwrap();
        read(&path, &Options::default()).unwrap()
    };
    let shown = |scene: &Scene| {
        let look = &scene.looks[scene.strands[0].look];
        scene.textures[look.textured[0].1.texture].pixels.get(0)
    };
    for file in ["gone.png", "no.png"] {
        let (scene, warnings) = stage(file, "float4 inputs:fallback = (0.5, 0.25, 0.125, 1)");
        assert_eq!((shown(&scene), scene.lights.len()), ([0.5, 0.25, 0.125], 1));
        assert!(has(&warnings, Some(Fault::Texture), &["/m/t", file, "its fallback is used"]), "{}", said(&warnings));
        assert!(has(&warnings, Some(Fault::Texture), &["/sky", file, "shines without it"]), "{}", said(&warnings));
        let (scene, warnings) = stage(file, "");
        assert_eq!(shown(&scene), [1.0, 0.0, 1.0]);
        assert!(has(&warnings, Some(Fault::Texture), &["/m/t", file, "it is magenta"]), "{}", said(&warnings));
    }
}

/// What a layer brings in is missing or broken: the rest composes.
#[test]
fn layers_that_cannot_be_read_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("broken.usda", "#usda 1.0\ndef Xform \"a\" {\n    def Xform = 3\n}");
    write("deep.usda", &format!("#usda 1.0\n{}", "def Xform \"a\" {".repeat(5000)));
    write("broken.usdc", "PXR-USDC and nothing else");
    write("good.usda", &format!("#usda 1.0\n{GOOD}"));
    for layer in ["gone.usda", "broken.usda", "deep.usda", "broken.usdc"] {
        for arc in [
            format!("( subLayers = [@{layer}@, @good.usda@] )"),
            format!("{GOOD} def \"x\" ( references = @{layer}@</a> ) {{}}"),
            format!("{GOOD} def \"x\" ( payload = @{layer}@ ) {{}}"),
        ] {
            write("stage.usda", &format!("#usda 1.0\n{arc}"));
            let (scene, warnings) = read(&folder.path().join("stage.usda"), &Options::default())
                .unwrap_or_else(|error| panic!("{error}\n{arc}"));
            assert_eq!(scene.strands.len(), 1, "{arc}");
            assert!(has(&warnings, Some(Fault::Layer), &[layer]), "{}\n{arc}", said(&warnings));
        }
    }
    write("stage.usda", &format!("#usda 1.0\n{GOOD} def \"x\" ( references = @broken.usda@</a> ) {{}}"));
    let (_, warnings) = read(&folder.path().join("stage.usda"), &Options::default()).unwrap();
    assert!(said(&warnings).contains("broken.usda: line 3, column 15: "), "{}", said(&warnings));
}

/// Points whose number or order changes while the shutter is open.
#[test]
fn curves_whose_topology_changes_have_no_deformation_blur() {
    let stage = |counts: &str, points: &str| {
        let body = format!(
            "( startTimeCode = 1 ) def Camera \"k\" {{ double shutter:open = -0.5 double shutter:close = 0.5 }}
            def BasisCurves \"c\" {{ uniform token type = \"linear\"
                int[] curveVertexCounts.timeSamples = {{ {counts} }}
                point3f[] points.timeSamples = {{ {points} }} float[] widths = [1] (interpolation = \"constant\") }}"
        );
        read_text(&body, &Options { frame: Some(2.0), ..Options::default() }).unwrap()
    };
    for (counts, points) in [
        ("1: [2], 2: [3]", "1: [(0,0,0), (1,0,0)], 2: [(5,0,0), (6,0,0), (7,0,0)]"),
        (
            "1: [2, 3], 2: [3, 2]",
            "1: [(0,0,0), (1,0,0), (2,0,0), (3,0,0), (4,0,0)], 2: [(5,0,0), (6,0,0), (7,0,0), (8,0,0), (9,0,0)]",
        ),
    ] {
        let (scene, warnings) = stage(counts, points);
        assert_eq!((scene.strands[0].points[0].x, scene.strands[0].moved.is_none()), (5.0, true), "{counts}");
        assert_eq!(scene.strands[0].starts[1], 3);
        assert!(said(&warnings).contains("/c: its points change in number or order"), "{}", said(&warnings));
    }
}

#[test]
fn widths_that_do_not_fit_give_way_to_the_default() {
    let body = format!(
        "def BasisCurves \"c\" {{ uniform token type = \"linear\" {} }}",
        FOUR.replace("[0.2] (interpolation = \"constant\")", "[1, 2]")
    );
    let (scene, warnings) = read_text(&body, &with_width(0.5)).unwrap();
    assert_eq!((scene.strands[0].basis, scene.strands[0].points[0].w), (Basis::Linear, 0.25));
    assert!(said(&warnings).contains("/c: widths has 2 values"), "{}", said(&warnings));
}

/// A property of a type that is not known, or with a value of another type, is left out. The rest of its layer is read,
/// also if the layer is a reference.
#[test]
fn a_value_that_cannot_be_read_costs_its_property() {
    let folder = tempfile::tempdir().unwrap();
    let save = |name: &str, text: &str| std::fs::write(folder.path().join(name), format!("#usda 1.0\n{text}")).unwrap();
    save("part.usda", &format!("def Xform \"p\" {{ matrix[] primvars:m = []\n {GOOD}\n double[] n = \"none\"\n }}"));
    save("stage.usda", "def \"a\" ( references = @./part.usda@</p> )\n{\n    tensor t = 1\n    float u = (1, 2)\n}");
    let (scene, warnings) = read(&folder.path().join("stage.usda"), &Options::default()).unwrap();
    assert_eq!(scene.strands[0].name, "/a/good");
    for what in [
        "/a: t cannot be read (stage.usda, line 4): its type tensor is not known: it is left out",
        "/a: u cannot be read (stage.usda, line 5): its value is not one of its type: it is left out",
        "/p: primvars:m cannot be read (part.usda, line 2): its type matrix is not known",
        "/p: n cannot be read (part.usda, line 5): its value",
    ] {
        assert!(has(&warnings, None, &[what]), "{what}: {}", said(&warnings));
    }
}
