//! Tests of single schemas and attributes.

mod common;

use common::{read, read_text, with_width};
use glam::{Mat3, Vec2, Vec3};
use vellus::{Fiber, Species};
use vellus_scene::{Basis, Light, Parameter, Scene, Units, Values, Wrap};
use vellus_usd::{Options, Warning};

/// A curve of four points along x, one unit apart, from 0.
const FOUR: &str = "int[] curveVertexCounts = [4]
    point3f[] points = [(0,0,0), (1,0,0), (2,0,0), (3,0,0)]
    float[] widths = [0.2] (interpolation = \"constant\")";

fn scene(body: &str) -> (Scene, Vec<Warning>) {
    read_text(body, &Options::default()).unwrap()
}

fn said(warnings: &[Warning]) -> String {
    warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

#[test]
fn transforms_multiply_down_to_the_points_and_widths() {
    let (scene, warnings) = scene(&format!(
        "def Xform \"a\" {{
    double3 xformOp:translate = (10, 0, 0)
    float xformOp:rotateZ = 90
    float3 xformOp:scale = (2, 2, 2)
    uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateZ\", \"xformOp:scale\"]
    def BasisCurves \"b\" {{
        {FOUR}
        uniform token type = \"linear\"
        double3 xformOp:translate:pivot = (0, 5, 0)
        quatf xformOp:orient = (0.70710678, 0, 0, 0.70710678)
        uniform token[] xformOpOrder = [\"xformOp:translate:pivot\", \"xformOp:orient\", \"!invert!xformOp:translate:pivot\"]
    }}
    def BasisCurves \"c\" {{
        {FOUR}
        uniform token type = \"linear\"
        matrix4d xformOp:transform = ((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,7,1))
        uniform token[] xformOpOrder = [\"!resetXformStack!\", \"xformOp:transform\"]
    }}
}}"
    ));
    assert_eq!(said(&warnings), "");
    let ends = |i: usize| (scene.strands[i].points[0], scene.strands[i].points[3]);
    // (0,0,0) turns about (0,5,0) to (5,5,0); doubled, turned to (−10,10,0), moved to (0,10,0).
    let (root, tip) = ends(0);
    assert!(
        root.abs_diff_eq(glam::vec4(0.0, 10.0, 0.0, 0.2), 1e-5)
            && tip.abs_diff_eq(glam::vec4(-6.0, 10.0, 0.0, 0.2), 1e-5)
    );
    assert_eq!(ends(1), (glam::vec4(0.0, 0.0, 7.0, 0.1), glam::vec4(3.0, 0.0, 7.0, 0.1)));
}

#[test]
fn stretched_strands_get_the_mean_scale_and_a_warning() {
    let (scene, warnings) = scene(&format!(
        "def BasisCurves \"b\" {{
    {FOUR}
    uniform token basis = \"bspline\"
    float3 xformOp:scale = (1, 2, 4)
    uniform token[] xformOpOrder = [\"xformOp:scale\"]
}}"
    ));
    assert!((scene.strands[0].points[0].w - 0.2).abs() < 1e-6);
    assert!(said(&warnings).contains("/b: its scale is not uniform"));
}

#[test]
fn every_kind_of_width_and_basis() {
    let two = |attributes: &str| {
        let (scene, _) = read_text(
            &format!(
                "def BasisCurves \"b\" {{
    int[] curveVertexCounts = [4, 5]
    point3f[] points = [(0,0,0), (1,0,0), (2,0,0), (3,0,0), (0,1,0), (1,1,0), (2,1,0), (3,1,0), (4,1,0)]
    {attributes}
}}"
            ),
            &with_width(0.5),
        )
        .unwrap();
        scene.strands.into_iter().next().unwrap()
    };
    let radii = |s: &vellus_scene::Strands| s.points.iter().map(|p| p.w).collect::<Vec<_>>();
    let bspline = "uniform token basis = \"bspline\"\n";
    let strands = two(bspline);
    assert_eq!((strands.basis, radii(&strands)), (Basis::BSpline, vec![0.25; 9]));
    let strands = two(&format!("{bspline} float[] widths = [2, 4] (interpolation = \"uniform\")"));
    assert_eq!(radii(&strands), [[1.0; 4].as_slice(), &[2.0; 5]].concat());
    // Knots: 2 and 3; 4 and 5 where it is pinned.
    let strands = two(&format!("{bspline} float[] widths = [2, 4, 2, 4, 6] (interpolation = \"varying\")"));
    assert_eq!(radii(&strands), [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 4.0]);
    let strands = two("uniform token basis = \"catmullRom\" uniform token wrap = \"pinned\"
    float[] primvars:widths = [2, 4, 6, 4, 0, 0, 0, 0, 2] (interpolation = \"varying\")
    float[] widths = [9] (interpolation = \"constant\")");
    assert_eq!(radii(&strands), [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0]);
    assert_eq!(strands.strand(1)[0].truncate(), Vec3::new(-1.0, 1.0, 0.0));
    // Linear, with a basis that remains from a cubic type; indexed.
    let strands =
        two("uniform token type = \"linear\" uniform token basis = \"bezier\" uniform token wrap = \"pinned\"
    float[] primvars:widths = [2, 4] (interpolation = \"vertex\")
    int[] primvars:widths:indices = [0, 0, 0, 1, 0, 0, 0, 0, 1]");
    assert_eq!((strands.basis, radii(&strands)), (Basis::Linear, vec![1.0, 1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0, 2.0]));
}

#[test]
fn pinned_b_splines_start_and_end_at_their_points() {
    let (scene, _) = scene(&format!(
        "def BasisCurves \"b\" {{ {FOUR}\n uniform token basis = \"bspline\" uniform token wrap = \"pinned\" }}"
    ));
    let points = scene.strands[0].strand(0);
    assert_eq!(points.len(), 6);
    let end = |a: usize| (points[a] + 4.0 * points[a + 1] + points[a + 2]) / 6.0;
    assert!(
        end(0).truncate().abs_diff_eq(Vec3::ZERO, 1e-6)
            && end(3).truncate().abs_diff_eq(Vec3::new(3.0, 0.0, 0.0), 1e-6)
    );
}

#[test]
fn roots_and_parameters_come_from_primvars() {
    let (scene, warnings) = scene(
        "def Xform \"a\" {
    float primvars:vellus:g = 0.5 (interpolation = \"constant\")
    def BasisCurves \"b\" {
        uniform token type = \"linear\"
        int[] curveVertexCounts = [2, 2]
        point3f[] points = [(0,0,0), (1,0,0), (0,1,0), (1,1,0)]
        float[] widths = [1, 1, 1, 1]
        texCoord2f[] primvars:uv = [(0.1, 0.2), (0, 0), (0.3, 0.4), (0, 0)] (interpolation = \"vertex\")
        float[] primvars:vellus:beta_m = [90, 45] (interpolation = \"uniform\")
        color3f[] primvars:vellus:sigma_ca = [(1, 2, 3), (4, 5, 6), (7, 8, 9), (1, 1, 1)] (interpolation = \"vertex\")
        float2[] primvars:vellus:melanin = [(1, 2)]
    }
}",
    );
    assert_eq!(said(&warnings), "");
    let strands = &scene.strands[0];
    assert_eq!(strands.root_uv, Some(vec![Vec2::new(0.1, 0.2), Vec2::new(0.3, 0.4)]));
    let right = std::f32::consts::FRAC_PI_2;
    assert_eq!(
        strands.varying,
        [
            (Parameter::BetaM, Values::PerStrand(vec![[right; 3], [0.5 * right; 3]])),
            (Parameter::SigmaCa, Values::PerPoint(vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0], [1.0; 3]])),
            (Parameter::G, Values::Constant([0.5; 3])),
            (Parameter::Melanin, Values::Constant([1.0, 2.0, 0.0])),
        ]
    );
    assert_eq!(scene.looks[0].fiber, Fiber::hair());
}

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
def Sphere \"ball\" {{}}
def Sphere \"ball2\" {{}}
def PointInstancer \"many\" {{ def BasisCurves \"prototype\" {curve} }}",
        with("token visibility = \"invisible\""),
        with("token purpose = \"render\""),
        with("token visibility = \"inherited\""),
        with("uniform token wrap = \"periodic\""),
    ));
    let names: Vec<_> = scene.strands.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["/shown", "/guides/seen"]);
    let said = said(&warnings);
    assert!(said.contains("/ring: periodic curves are not supported"), "{said}");
    assert!(said.contains("/ball, /ball2: Sphere is not supported"), "{said}");
    assert!(said.contains("/many: PointInstancer is not supported"), "{said}");
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
fn fibres_come_from_presets_inputs_and_interfaces() {
    let curve = |name: &str| format!("def BasisCurves \"{name}\" {{ {FOUR}\n rel material:binding = </{name}Fur> }}\n");
    let fur = |name: &str, inputs: &str| {
        format!(
            "def Material \"{name}Fur\" {{
    float inputs:shine = 12
    token outputs:surface.connect = </{name}Fur/Shader.outputs:surface>
    def Shader \"Shader\" {{
        uniform token info:id = \"VellusFur\"
        {inputs}
        token outputs:surface
    }}
}}\n"
        )
    };
    let body = ["a", "b", "c"].map(curve).concat()
        + &fur(
            "a",
            "string inputs:preset = \"Red Fox\" float inputs:beta_m.connect = </aFur.inputs:shine> float inputs:kappa = 0.5 int inputs:unknown = 3",
        )
        + &fur("b", "color3f inputs:reflectance = (0.2, 0.3, 0.4)")
        + "def Material \"cFur\" {}\n";
    let options = Options { fallback: Fiber::preset(Species::Cat), ..Options::default() };
    let (scene, warnings) = read_text(&body, &options).unwrap();
    let fox = Fiber { beta_m: 12f32.to_radians(), kappa: 0.5, ..Fiber::preset(Species::RedFox) };
    let color = vellus::Color::Reflectance([0.2, 0.3, 0.4]);
    let fibers: Vec<_> = scene.strands.iter().map(|s| scene.looks[s.look].fiber).collect();
    assert_eq!(fibers, [fox, Fiber::hair().with_color(color).unwrap(), Fiber::preset(Species::Cat)]);
    let said = said(&warnings);
    assert!(said.contains("/aFur/Shader: inputs:unknown is not a parameter"), "{said}");
    assert!(said.contains("/cFur: it has no VellusFur shader"), "{said}");

    let error = |inputs: &str| read_text(&(curve("a") + &fur("a", inputs)), &options).unwrap_err().to_string();
    assert!(
        error("float inputs:eta = 9").contains("/aFur/Shader: eta = 9 is out of range"),
        "{}",
        error("float inputs:eta = 9")
    );
    assert!(error("float inputs:beta_m = 0.01").contains("[0.1, 90] degrees"));
    assert!(error("string inputs:preset = \"yeti\"").contains("'yeti'"));
    assert!(error("float2 inputs:melanin = (1, 2) color3f inputs:sigma_ca = (1, 1, 1)").contains("only one may"));
    assert!(error("float inputs:g.connect = </aFur/Shader.inputs:g>").contains("in a circle"));

    // The pigments of melanin, under the names that other renderers use.
    let pigments = "float inputs:eumelanin = 1.3 float inputs:pheomelanin = 0.2";
    let (scene, warnings) = read_text(&(curve("a") + &fur("a", pigments)), &options).unwrap();
    let brown = vellus::Color::Melanin { eumelanin: 1.3, pheomelanin: 0.2 };
    assert_eq!((scene.looks[0].fiber, warnings.len()), (Fiber::hair().with_color(brown).unwrap(), 0));
    assert!(error("float inputs:eumelanin = 101").contains("eumelanin = 101 is out of range"));
    assert!(error("float inputs:eumelanin = 1 color3f inputs:sigma_ca = (1, 1, 1)").contains("only one may"));
}

/// The renderer multiplies a texture by its scale and converts the product, so the scale must remain as it is.
#[test]
fn the_scale_of_a_textured_angle_is_a_plain_factor() {
    let folder = tempfile::tempdir().unwrap();
    let mut encoder = png::Encoder::new(std::fs::File::create(folder.path().join("rough.png")).unwrap(), 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 51, 0]).unwrap();
    let path = folder.path().join("stage.usda");
    let body = format!(
        "#usda 1.0
def BasisCurves \"a\" {{ {FOUR}\n rel material:binding = </Fur> }}
def Material \"Fur\" {{
    token outputs:surface.connect = </Fur/Shader.outputs:surface>
    def Shader \"Shader\" {{
        uniform token info:id = \"VellusFur\"
        float inputs:beta_m.connect = </Fur/Image.outputs:r>
        token outputs:surface
    }}
    def Shader \"Image\" {{
        uniform token info:id = \"UsdUVTexture\"
        asset inputs:file = @./rough.png@
        token inputs:sourceColorSpace = \"raw\"
        float4 inputs:scale = (12, 1, 1, 1)
        float outputs:r
    }}
}}"
    );
    std::fs::write(&path, body).unwrap();
    let (scene, _) = read(&path, &Options::default()).unwrap();
    let [(Parameter::BetaM, value)] = scene.looks[0].textured[..] else { panic!("{:?}", scene.looks) };
    assert_eq!(value.scale[0], 12.0);
    let written = folder.path().join("written.usda");
    vellus_usd::write(&scene, &written).unwrap();
    let (again, _) = read(&written, &Options::default()).unwrap();
    assert_eq!(again.looks[0].textured[0].1.scale[0], 12.0);
}

#[test]
fn polygons_become_triangles_with_their_corners() {
    let quad = |attributes: &str| {
        let body = format!(
            "def Mesh \"m\" {{
    int[] faceVertexCounts = [4, 3]
    int[] faceVertexIndices = [0, 1, 2, 3, 0, 2, 4]
    point3f[] points = [(0,0,0), (1,0,0), (1,1,0), (0,1,0), (0,0,1)]
    {attributes}
}}"
        );
        scene(&body)
    };
    let (scene, warnings) = quad(
        "uniform token subdivisionScheme = \"none\"
    normal3f[] normals = [(0,0,1), (0,0,1), (0,0,1), (0,1,0), (1,0,0)] (interpolation = \"vertex\")
    texCoord2f[] primvars:st = [(0,0), (1,0)] (interpolation = \"faceVarying\")
    int[] primvars:st:indices = [0, 0, 0, 1, 0, 0, 1]
    color3f[] primvars:displayColor = [(0.1, 0.2, 0.3)]",
    );
    assert_eq!(said(&warnings), "");
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 2, 4]]);
    assert_eq!(mesh.normals.as_ref().unwrap()[1], [Vec3::Z, Vec3::Z, Vec3::Y]);
    assert_eq!(mesh.uv.as_ref().unwrap()[1..], [[Vec2::ZERO, Vec2::ZERO, Vec2::X]; 2]);
    assert_eq!(scene.surfaces[mesh.surface].color.color, [0.1, 0.2, 0.3]);
    let (scene, warnings) = quad(
        "uniform token orientation = \"leftHanded\" int[] holeIndices = [1]
    def GeomSubset \"part\" { rel material:binding = </none> int[] indices = [0] }",
    );
    assert_eq!(scene.meshes[0].triangles, [[0, 2, 1], [0, 3, 2]]);
    let said = said(&warnings);
    assert!(
        said.contains("/m: subdivision is not supported") && said.contains("/m/part: a mesh has one material"),
        "{said}"
    );
    let mirror = "float3 xformOp:scale = (-2, 1, 1) uniform token[] xformOpOrder = [\"xformOp:scale\"]
    normal3f[] normals = [(0.6,0.8,0), (0,0,1), (0,0,1), (0,1,0), (1,0,0)]";
    let (scene, _) = quad(mirror);
    assert_eq!(scene.meshes[0].triangles[0], [0, 2, 1]);
    // Stretched along x, a slope turns its normal away from x.
    let expected = Vec3::new(-0.3, 0.8, 0.0).normalize();
    assert!(scene.meshes[0].normals.as_ref().unwrap()[0][0].abs_diff_eq(expected, 1e-6));
}

#[test]
fn surfaces_read_preview_surfaces_and_their_textures() {
    let folder = tempfile::tempdir().unwrap();
    let mut encoder = png::Encoder::new(std::fs::File::create(folder.path().join("hide.png")).unwrap(), 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 51, 0]).unwrap();
    let stage = |file: &str, output: &str| {
        let body = format!(
            "#usda 1.0
def Mesh \"m\" {{
    int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0,0,0), (1,0,0), (1,1,0)]
    uniform token subdivisionScheme = \"none\"
    rel material:binding = </Hide>
}}
def Material \"Hide\" {{
    token inputs:wrap = \"clamp\"
    token outputs:surface.connect = </Hide/Graph.outputs:out>
    def NodeGraph \"Graph\" {{
        token outputs:out.connect = </Hide/Graph/Surface.outputs:surface>
        def Shader \"Surface\" {{
            uniform token info:id = \"UsdPreviewSurface\"
            color3f inputs:diffuseColor.connect = </Hide/Graph/Image.outputs:{output}>
            color3f inputs:emissiveColor = (0, 1, 2)
            float inputs:roughness = 0.25
            float inputs:metallic = 1
            float inputs:opacity = 0.5
            token outputs:surface
        }}
        def Shader \"Image\" {{
            uniform token info:id = \"UsdUVTexture\"
            asset inputs:file = @{file}@
            token inputs:sourceColorSpace = \"raw\"
            float4 inputs:scale = (0.5, 0.25, 1, 1)
            token inputs:wrapS = \"mirror\"
            token inputs:wrapT.connect = </Hide.inputs:wrap>
        }}
    }}
}}"
        );
        let path = folder.path().join("stage.usda");
        std::fs::write(&path, body).unwrap();
        read(&path, &Options::default())
    };
    let (scene, warnings) = stage("./hide.png", "rgb").unwrap();
    let surface = &scene.surfaces[0];
    assert_eq!((surface.color.color, surface.color.texture), ([0.5, 0.25, 1.0], Some(0)));
    assert_eq!((surface.emission, surface.roughness, surface.metallic, surface.ior), ([0.0, 1.0, 2.0], 0.25, 1.0, 1.5));
    assert_eq!((scene.textures[0].name.as_str(), scene.textures[0].pixels[0]), ("hide.png", [1.0, 0.2, 0.0]));
    assert_eq!(scene.textures[0].wrap, [Wrap::Mirror, Wrap::Clamp]);
    assert!(said(&warnings).contains("inputs:opacity is not supported"));
    let (scene, _) = stage("hide.png", "g").unwrap();
    assert_eq!((scene.surfaces[0].color.color, scene.textures[0].pixels[0]), ([0.25; 3], [0.2; 3]));
    let error = stage("./none.png", "rgb").unwrap_err().to_string();
    assert!(error.contains("/Hide/Graph/Image") && error.contains("./none.png does not exist"), "{error}");
    std::fs::write(folder.path().join("text.png"), "no image").unwrap();
    let error = stage("./text.png", "rgb").unwrap_err().to_string();
    assert!(error.contains("text.png: it is no PNG"), "{error}");
}

#[test]
fn lights_have_the_radiance_of_usdlux() {
    let (scene, warnings) = scene(&format!(
        "( upAxis = \"Z\" )
def BasisCurves \"b\" {{ {FOUR} }}
def RectLight \"rect\" {{ float inputs:width = 2 float inputs:height = 3 float inputs:intensity = 6 float inputs:exposure = 1
    bool inputs:normalize = 1 color3f inputs:color = (1, 0.5, 0)
    float3 xformOp:scale = (2, 1, 1) uniform token[] xformOpOrder = [\"xformOp:scale\"] }}
def DiskLight \"disk\" {{ token vellus:lightGroup = \"key-2\" float intensity = 3 float inputs:shaping:cone:angle = 30 }}
def SphereLight \"sphere\" {{ float inputs:radius = 0.5 bool inputs:normalize = 1
    float3 xformOp:scale = (2, 2, 2) uniform token[] xformOpOrder = [\"xformOp:scale\"] }}
def DistantLight \"sun\" {{ float inputs:angle = 60 float inputs:intensity = 2
    float xformOp:rotateX = 90 uniform token[] xformOpOrder = [\"xformOp:rotateX\"] }}
def DistantLight \"parallel\" {{ float inputs:angle = 0 float inputs:intensity = 2 }}
def DomeLight \"sky\" {{ float vellus:groundHeight = 1.5 float vellus:groundRadius = 20
    double3 xformOp:translate = (1, 2, 3) float3 xformOp:scale = (2, 2, 2)
    uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:scale\"] }}
def DomeLight_1 \"sky1\" {{ }}
def CylinderLight \"tube\" {{ float inputs:radius = 0.25 float inputs:length = 3 bool inputs:normalize = 1
    float3 xformOp:scale = (2, 2, 2) uniform token[] xformOpOrder = [\"xformOp:scale\"] }}
def PortalLight \"portal\" {{ }}"
    ));
    let said = said(&warnings);
    assert!(
        said.contains("/disk: the shaping") && said.contains("/portal: PortalLight is not") && warnings.len() == 2,
        "{said}"
    );
    let [rect, disk, sphere, sun, parallel, sky, sky1, tube] = &scene.lights[..] else { panic!() };
    assert_eq!(scene.light_groups[1..5], ["key-2", "sphere", "sun", "parallel"]);
    // 6 · 2 over an area of 2 · 2 · 3.
    let Light::Rect { radiance, to_world, .. } = rect else { panic!() };
    assert_eq!((*radiance, to_world.x_axis.x, to_world.y_axis.y), ([1.0, 0.5, 0.0], 4.0, 3.0));
    let Light::Disk { radiance, to_world } = disk else { panic!() };
    assert_eq!((*radiance, to_world.x_axis.x), ([3.0; 3], 0.5));
    let Light::Sphere { radius, radiance, .. } = sphere else { panic!() };
    assert!(*radius == 1.0 && (radiance[0] * 4.0 * std::f32::consts::PI - 1.0).abs() < 1e-6);
    let Light::Cylinder { half_axis, radius, radiance, .. } = tube else { panic!() };
    assert_eq!((*half_axis, *radius), (Vec3::new(3.0, 0.0, 0.0), 0.5));
    // The side of a cylinder: 2 π times 0.5 times 6.
    assert!((radiance[0] * 6.0 * std::f32::consts::PI - 1.0).abs() < 1e-6);
    let Light::Distant { direction, half_angle, irradiance } = sun else { panic!() };
    // Light goes along −z, turned to +y; π sin² 30° of the sky's 2.
    assert!(direction.abs_diff_eq(-Vec3::Y, 1e-6) && (half_angle.to_degrees() - 30.0).abs() < 1e-5);
    assert!((irradiance[0] - 0.5 * std::f32::consts::PI).abs() < 1e-6);
    let Light::Distant { half_angle, irradiance, .. } = parallel else { panic!() };
    assert_eq!((*half_angle, *irradiance), (0.0, [2.0; 3]));
    let axes = |light: &Light| match light {
        Light::Dome { rotation, .. } => (*rotation * Vec3::Y, *rotation * Vec3::NEG_Z),
        _ => panic!(),
    };
    let Light::Dome { ground: Some(ground), .. } = sky else { panic!() };
    assert_eq!((ground.origin, ground.height, ground.radius), (Vec3::new(1.0, 2.0, 3.0), 3.0, 40.0));
    // The pole and the middle of the image.
    assert_eq!(axes(sky), (Vec3::Y, Vec3::Z));
    let (pole, middle) = axes(sky1);
    assert!(pole.abs_diff_eq(Vec3::Z, 1e-6) && middle.abs_diff_eq(-Vec3::Y, 1e-6));
    let Light::Dome { rotation, .. } = sky1 else { panic!() };
    assert!((*rotation * rotation.transpose()).abs_diff_eq(Mat3::IDENTITY, 1e-6));
}

#[test]
fn cameras_are_chosen_and_move() {
    let body = "( startTimeCode = 1 endTimeCode = 2 )
def BasisCurves \"b\" {
    uniform token type = \"linear\"
    int[] curveVertexCounts = [2]
    point3f[] points.timeSamples = { 1: [(0,0,0), (1,0,0)], 2: [(0,0,0), (1,2,0)] }
    float[] widths = [1, 1]
}
def Camera \"wide\" { float focalLength = 20 float horizontalAperture = 40 float verticalAperture = 20
    double shutter:open = 0 double shutter:close = 0.5 }
def Xform \"rig\" {
    float3 xformOp:scale = (2, 2, 2)
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 1), 2: (0, 4, 1) }
    uniform token[] xformOpOrder = [\"xformOp:scale\", \"xformOp:translate\"]
    def Mesh \"sail\" { uniform token subdivisionScheme = \"none\" int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2] point3f[] points = [(0,0,0), (1,0,0), (0,1,0)] }
    def Camera \"long\" { float focalLength = 80 float fStop = 2 float focusDistance = 3 double shutter:close = 0.25 }
}";
    let (scene, warnings) = read_text(body, &Options::default()).unwrap();
    assert_eq!(said(&warnings), "");
    let camera = scene.camera.unwrap();
    assert_eq!((camera.film_width, camera.film_height, camera.lens_radius, camera.moved), (2.0, 1.0, 0.0, None));
    assert_eq!(scene.strands[0].moved, Some(vec![Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)]));
    // Its parent's scale and movement.
    assert_eq!(scene.meshes[0].positions[1], Vec3::new(2.0, 0.0, 2.0));
    assert_eq!(scene.meshes[0].moved.as_ref().unwrap()[1], Vec3::new(2.0, 4.0, 2.0));
    let by_name = |name: &str, frame| Options { camera: Some(name.to_owned()), frame, ..Options::default() };
    let (scene, _) = read_text(body, &by_name("long", Some(1.5))).unwrap();
    let camera = scene.camera.unwrap();
    // 80 tenths of a unit at f/2.
    assert_eq!((camera.lens_radius, camera.focus_distance), (2.0, 3.0));
    assert_eq!(camera.to_world.w_axis.truncate(), Vec3::new(0.0, 4.0, 2.0));
    assert_eq!(camera.to_world.x_axis.x, 1.0);
    assert_eq!(camera.moved.unwrap().w_axis.truncate(), Vec3::new(0.0, 6.0, 2.0));
    assert_eq!(scene.strands[0].points[1].truncate(), Vec3::new(1.0, 1.0, 0.0));
    let error = read_text(body, &by_name("none", None)).unwrap_err().to_string();
    assert!(error.contains("no camera called none"), "{error}");
}

#[test]
fn units_are_kept_and_unsupported_camera_settings_warn() {
    let with = |metadata: &str| {
        let body =
            format!("( {metadata} )\ndef BasisCurves \"b\" {{ {FOUR} }}\ndef Camera \"c\" {{ float exposure = 1 }}");
        read_text(&body, &Options::default())
    };
    let (scene, warnings) = with("upAxis = \"Z\"\n metersPerUnit = 0.0254").unwrap();
    assert_eq!(scene.units, Some(Units { meters_per_unit: 0.0254, z_up: true }));
    assert!(said(&warnings).contains("/c: the camera's exposure is not supported"), "{}", said(&warnings));
    assert_eq!(with("doc = \"none\"").unwrap().0.units, Some(Units::CENTIMETERS));
    for broken in ["metersPerUnit = 0", "metersPerUnit = -1", "metersPerUnit = nan"] {
        let error = with(broken).unwrap_err().to_string();
        assert!(error.contains("metersPerUnit must be a positive number"), "{error}");
    }
}

/// Without a frame a shutter cannot move anything, and a warning reports this.
#[test]
fn motion_without_a_frame_warns() {
    let body = "
def BasisCurves \"b\" {
    uniform token type = \"linear\"
    int[] curveVertexCounts = [2]
    point3f[] points.timeSamples = { 1: [(0,0,0), (1,0,0)], 2: [(0,0,0), (1,2,0)] }
    float[] widths = [1, 1]
}
def Camera \"c\" { double shutter:close = 1 }";
    let (scene, warnings) = read_text(body, &Options::default()).unwrap();
    assert!(scene.strands[0].moved.is_none() && said(&warnings).contains("no startTimeCode"), "{}", said(&warnings));
    let (scene, warnings) = read_text(body, &Options { frame: Some(1.0), ..Options::default() }).unwrap();
    assert!(scene.strands[0].moved.is_some() && !said(&warnings).contains("no startTimeCode"));
}

/// Time samples take precedence over the default value beside them, and the time samples of a stage over those of its
/// references, with or without a frame. Whatever moves keeps moving.
#[test]
fn time_samples_take_precedence_over_the_default() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.usda");
    let save = |strong: &str, metadata: &str| {
        let curve = "uniform token type = \"linear\" int[] curveVertexCounts = [2] float[] widths = [1, 1]
            point3f[] points = [(9,0,0), (9,1,0)]
            point3f[] points.timeSamples = { 1: [(1,0,0), (1,1,0)], 3: [(3,0,0), (3,1,0)] }
            double3 xformOp:translate = (0, 0, 90)
            double3 xformOp:translate.timeSamples = { 1: (0, 0, 10), 3: (0, 0, 30) }
            uniform token[] xformOpOrder = [\"xformOp:translate\"]";
        let weak = format!("#usda 1.0\ndef BasisCurves \"b\" {{ {curve} }}");
        std::fs::write(folder.path().join("weak.usda"), weak).unwrap();
        let refers = "prepend references = @./weak.usda@</b>";
        let camera = "def Camera \"c\" { double shutter:close = 1 }";
        let stage = format!("#usda 1.0\n( {metadata} )\ndef \"b\" ( {refers} ) {{ {strong} }}\n{camera}");
        std::fs::write(&path, stage).unwrap();
    };
    let read = |frame| {
        let (scene, _) = read(&path, &Options { frame, ..Options::default() }).unwrap();
        let strands = scene.strands.into_iter().next().unwrap();
        (strands.points[0].truncate(), strands.moved.map(|moved| moved[0]))
    };
    save("", "startTimeCode = 2 endTimeCode = 3");
    let (at_1, at_2, at_3) = (Vec3::new(1.0, 0.0, 10.0), Vec3::new(2.0, 0.0, 20.0), Vec3::new(3.0, 0.0, 30.0));
    assert_eq!(read(None), (at_2, Some(at_3)));
    assert_eq!(read(Some(1.0)), (at_1, Some(at_2)));
    assert_eq!(read(Some(3.0)), (at_3, None));
    save("", "");
    assert_eq!(read(None), (at_1, None));
    save("point3f[] points = [(7,0,0), (7,1,0)]", "startTimeCode = 2 endTimeCode = 3");
    assert_eq!(read(None), (Vec3::new(7.0, 0.0, 20.0), Some(Vec3::new(7.0, 0.0, 30.0))));
}

/// A material is bound by the nearest prim that binds one to the curves or to a collection with them. A binding for
/// final pictures takes precedence over one for all purposes. Prims further up take precedence only if they are
/// marked as stronger.
#[test]
fn materials_are_bound_by_collections() {
    let fur = |name: &str, g: f32| {
        format!(
            "def Material \"{name}\" {{ token outputs:surface.connect = </{name}/Fur.outputs:surface>
    def Shader \"Fur\" {{ uniform token info:id = \"VellusFur\" float inputs:g = {g} token outputs:surface }} }}\n"
        )
    };
    let furs = [("A", 0.1), ("B", 0.2), ("C", 0.3), ("D", 0.4)].map(|(name, g)| fur(name, g)).concat();
    // The values of g of the three curves, for bindings on the world, on their parent and on the last curve.
    let read = |world: &str, parent: &str, last: &str| {
        let curve = |name: &str, more: &str| format!("def BasisCurves \"{name}\" {{ {FOUR}\n {more} }}\n");
        let body = format!(
            "def Xform \"world\" {{\n {world}\n def Xform \"coat\" {{\n {parent}\n {}{}{} }}\n }}\n{furs}",
            curve("one", ""),
            curve("two", ""),
            curve("three", last)
        );
        let (scene, warnings) = scene(&body);
        let g: Vec<_> = scene.strands.iter().map(|s| scene.looks[s.look].fiber.g).collect();
        (g, said(&warnings))
    };
    let none = Fiber::hair().g;
    let collection = "rel collection:some:includes = [</world/coat/two>, </world/coat/three>]
        rel material:binding:collection:some = [</world.collection:some>, </A>]\n";
    assert_eq!(read(collection, "", "").0, [none, 0.1, 0.1]);
    // An excluded member; a binding on the prim itself is nearer.
    let without = format!("{collection} rel collection:some:excludes = </world/coat/two>");
    assert_eq!(read(&without, "", "rel material:binding = </B>").0, [none, none, 0.2]);
    // On one prim, collections take precedence, the first of them first; one without the members below its includes.
    let both = format!(
        "{collection} rel material:binding = </B>
        uniform token collection:all:expansionRule = \"explicitOnly\" rel collection:all:includes = </world/coat>
        rel material:binding:collection:all = [</world.collection:all>, </C>]"
    );
    assert_eq!(read(&both, "", "").0, [0.2, 0.1, 0.1]);
    let stronger = "rel material:binding = </B> ( bindMaterialAs = \"strongerThanDescendants\" )";
    assert_eq!(read(stronger, "rel material:binding = </C>", "rel material:binding = </D>").0, [0.2; 3]);
    assert_eq!(read("rel material:binding = </B>", "rel material:binding = </C>", "").0, [0.3; 3]);
    // A binding for final pictures, at any distance.
    let full = "rel collection:some:includes = </world/coat/two>
        rel material:binding:collection:full:some = [</world.collection:some>, </A>]
        rel material:binding:collection:preview:some = [</world.collection:some>, </D>]";
    assert_eq!(read(full, "rel material:binding = </C>", "rel material:binding:full = </B>").0, [0.3, 0.1, 0.2]);
    // A collection inside another, and targets that are no collections.
    let chained = "rel collection:some:includes = </world/coat/two>
        rel collection:more:includes = [</world.collection:some>, </world/coat/three>]
        rel material:binding:collection:x = [</world.collection:more>, </A>]
        rel material:binding:collection:y = [</world/coat>, </B>]";
    assert_eq!(read(chained, "", "").0, [none, 0.1, 0.1]);
    let wrong = "rel material:binding:collection:x = </A>
        uniform string collection:e:membershipExpression = \"/world//\"
        rel material:binding:collection:e = [</world.collection:e>, </A>]";
    let (g, said) = read(wrong, "", "");
    assert_eq!(g, [none; 3]);
    assert!(said.contains("/world: material:binding:collection:x must have two targets"), "{said}");
    assert!(said.contains("/world.collection:e: collections by an expression are not supported"), "{said}");
    let chain = |n: usize| {
        let link = |i: usize| format!("rel collection:c{i}:includes = </world.collection:c{}>\n", (i + 1) % n);
        let links: String = (0..n).map(link).collect();
        format!("{links} rel material:binding:collection:x = [</world.collection:c0>, </A>]")
    };
    assert_eq!(read(&chain(100), "", "").0, [none; 3]);
    let body = format!("def Xform \"world\" {{ {} def BasisCurves \"b\" {{ {FOUR} }} }}", chain(1000));
    let error = read_text(&body, &Options::default()).unwrap_err().to_string();
    assert!(error.contains("more than 200 collections"), "{error}");
}

/// Velocities are per second, from the sample before the shutter opens, or from the frame if there is none. They take
/// precedence over later samples, which may have other points.
#[test]
fn velocities_move_curves_and_meshes() {
    let read = |points: &str, more: &str, frame| {
        let shape = format!("point3f[] points{points}\n {more}");
        let body = format!(
            "( startTimeCode = 1 endTimeCode = 9 timeCodesPerSecond = 25 )
def BasisCurves \"c\" {{ uniform token type = \"linear\" int[] curveVertexCounts.timeSamples = {{ 1: [2], 3: [3] }} float[] widths = [1]
    {shape} double3 xformOp:translate = (0, 0, 9) uniform token[] xformOpOrder = [\"xformOp:translate\"] }}
def Mesh \"m\" {{ uniform token subdivisionScheme = \"none\" int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 1] {shape} }}
def Camera \"eye\" {{ double shutter:open = -0.25 double shutter:close = 0.5 }}"
        );
        let (scene, warnings) = read_text(&body, &Options { frame: Some(frame), ..Options::default() }).unwrap();
        let (curve, mesh) = (&scene.strands[0], &scene.meshes[0]);
        let ends = (curve.points[1].truncate(), curve.moved.as_ref().map(|moved| moved[1]));
        let up = |p: Vec3| p + 9.0 * Vec3::Z;
        let of_mesh = (up(mesh.positions[1]), mesh.moved.as_ref().map(|moved| up(moved[1])));
        assert!(ends.0.abs_diff_eq(of_mesh.0, 1e-5), "{ends:?} {of_mesh:?}");
        assert_eq!(ends.1.is_some(), of_mesh.1.is_some());
        (ends.0, ends.1.unwrap_or(ends.0), said(&warnings))
    };
    let expect = |found: (Vec3, Vec3, String), x: [f32; 2]| {
        let at = |x: f32| Vec3::new(x, 1.0, 9.0);
        // Coordinates near 9 in single precision, twice.
        assert!(found.0.abs_diff_eq(at(x[0]), 4e-6) && found.1.abs_diff_eq(at(x[1]), 4e-6), "{found:?}, not {x:?}");
        assert_eq!(found.2, "");
    };
    let still = " = [(0,0,0), (0,1,0)]";
    // 50 per second are 2 per frame.
    expect(read(still, "vector3f[] velocities = [(0,0,0), (50,0,0)]", 2.0), [-0.5, 1.0]);
    let accelerations = "vector3f[] velocities = [(0,0,0), (50,0,0)] vector3f[] accelerations = [(0,0,0), (2500,0,0)]";
    // ½ · 4 t² in frames.
    expect(read(still, accelerations, 2.0), [-0.5 + 0.125, 1.0 + 0.5]);
    let sampled = ".timeSamples = { 1: [(0,0,0), (7,1,0)], 3: [(0,0,0), (8,1,0), (9,1,0)] }";
    let fast = "vector3f[] velocities.timeSamples = { 1: [(0,0,0), (50,0,0)], 3: [(0,0,0), (25,0,0), (0,0,0)] }";
    expect(read(sampled, fast, 1.25), [7.0, 8.5]);
    expect(read(sampled, fast, 2.75), [10.0, 11.5]);
    // From the new sample on, with its points.
    expect(read(sampled, fast, 3.25), [8.0, 8.75]);
    // Velocities that do not match give a warning, and the samples are used.
    let two = ".timeSamples = { 1: [(0,0,0), (7,1,0)], 3: [(0,0,0), (9,1,0)] }";
    for wrong in ["velocities = [(1,0,0)]", "velocities.timeSamples = { 2: [(0,0,0), (50,0,0)] }"] {
        let (open, close, said) = read(two, &format!("vector3f[] {wrong}"), 1.25);
        assert_eq!((open.x, close.x), (7.0, 7.75));
        assert!(said.contains("/c, /m: its velocities do not match its points"), "{said}");
    }
}

/// One warning for each primvar and material, with the value, the range and the result.
#[test]
fn primvars_outside_their_range_and_unknown_ones_warn() {
    let curves = |name: &str, more: &str| {
        format!(
            "def BasisCurves \"{name}\" {{ uniform token type = \"linear\" int[] curveVertexCounts = [2]
            point3f[] points = [(0,0,0), (1,0,0)] float[] widths = [1, 1] {more} }}\n"
        )
    };
    let both =
        "float[] primvars:vellus:kappa = [5] float[] primvars:vellus:alpha = [45] float primvars:vellus:fluff = 1
        color3f[] primvars:vellus:sigma_ca = [(0, 1, -1)]";
    let body = [curves("a", both), curves("b", both)].concat();
    let (scene, warnings) = read_text(&body, &Options::default()).unwrap();
    let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert_eq!(said.len(), 3, "{said:?}");
    assert!(
        said[0].starts_with("/a: primvars:vellus:kappa[0] is 5: the range is [0, 0.99], so it is clamped to 0.99"),
        "{said:?}"
    );
    assert!(said[1].starts_with("/a: primvars:vellus:sigma_ca[0] is -1: the range is [0, 1000]"), "{said:?}");
    assert_eq!(said[2], "/a, /b: primvars:vellus:fluff is not a parameter of VellusFur and is ignored");
    assert_eq!(scene.strands.len(), 2);
}
