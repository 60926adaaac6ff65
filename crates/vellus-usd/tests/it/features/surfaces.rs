//! Surfaces of meshes that MaterialX and Arnold describe.

use super::{said, scene};
use vellus_scene::{Scene, Surface};
use vellus_usd::{Options, read};

const MESH: &str = "def Mesh \"mesh\" {
    int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 2] point3f[] points = [(0,0,0), (1,0,0), (1,1,0)]
    uniform token subdivisionScheme = \"none\"
    texCoord2f[] primvars:map1 = [(0,0), (1,0), (1,1)] ( interpolation = \"vertex\" )
    rel material:binding = </m>
}";

const STANDARD: &str = "ND_standard_surface_surfaceshader";
const OPEN_PBR: &str = "ND_open_pbr_surface_surfaceshader";

/// A mesh with a surface at an output, and other nodes.
fn stage(output: &str, id: &str, inputs: &str, nodes: &str) -> String {
    format!(
        "{MESH}
def Material \"m\" {{
    token outputs:{output}.connect = </m/s.outputs:out>
    def Shader \"s\" {{ uniform token info:id = \"{id}\" token outputs:out\n {inputs} }}
    {nodes}
}}"
    )
}

fn surface(id: &str, inputs: &str) -> (Surface, String) {
    let output = if id.starts_with("arnold:") { "arnold:surface" } else { "mtlx:surface" };
    let (scene, warnings) = scene(&stage(output, id, inputs, ""));
    (scene.surfaces[scene.meshes[0].surface].clone(), said(&warnings))
}

/// The values are exact, or products and quotients of a few numbers of single precision.
#[track_caller]
fn check(found: &Surface, color: [f32; 3], emission: [f32; 3], [roughness, metallic, ior]: [f32; 3]) {
    let near = |x: f32, e: f32| assert!((x - e).abs() <= 1e-6 * e.abs().max(1.0), "{x} {e}");
    found.color.color.into_iter().zip(color).for_each(|(x, e)| near(x, e));
    found.emission.into_iter().zip(emission).for_each(|(x, e)| near(x, e));
    near(found.roughness, roughness);
    near(found.metallic, metallic);
    near(found.ior, ior);
}

#[test]
fn standard_surface_gives_a_surface() {
    let inputs = "float inputs:base = 0.5 color3f inputs:base_color = (0.8, 0.4, 0.2)
        float inputs:specular_roughness = 0.6 float inputs:metalness = 0.25 float inputs:specular_IOR = 1.7
        float inputs:emission = 2 color3f inputs:emission_color = (0.5, 1, 3)
        float inputs:coat = 0 float inputs:coat_roughness = 0.3 color3f inputs:opacity = (1, 1, 1)
        bool inputs:thin_walled = 0";
    for id in [STANDARD, "ND_standard_surface_surfaceshader_100", "arnold:standard_surface"] {
        let (found, warnings) = surface(id, inputs);
        check(&found, [0.4, 0.2, 0.1], [1.0, 2.0, 6.0], [0.6, 0.25, 1.7]);
        assert_eq!(warnings, "", "{id}");
        check(&surface(id, "").0, [0.8; 3], [0.0; 3], [0.2, 0.0, 1.5]);
    }
}

#[test]
fn open_pbr_gives_a_surface() {
    let inputs = "float inputs:base_weight = 0.5 color3f inputs:base_color = (0.8, 0.4, 0.2)
        float inputs:specular_roughness = 0.6 float inputs:base_metalness = 0.25 float inputs:specular_ior = 1.7
        float inputs:emission_luminance = 2 color3f inputs:emission_color = (0.5, 1, 3)
        color3f inputs:coat_color = (1, 0, 0) float inputs:geometry_opacity = 1";
    assert_eq!(surface(OPEN_PBR, "color3f inputs:emission_color = (1, 0, 0)").1, "");
    let (found, warnings) = surface(OPEN_PBR, inputs);
    check(&found, [0.4, 0.2, 0.1], [1.0, 2.0, 6.0], [0.6, 0.25, 1.7]);
    assert_eq!(warnings, "");
    check(&surface(OPEN_PBR, "").0, [0.8; 3], [0.0; 3], [0.3, 0.0, 1.5]);
}

#[test]
fn weights_change_the_refractive_index_and_the_colour() {
    for id in [STANDARD, OPEN_PBR] {
        let suffix = if id == OPEN_PBR { "_weight" } else { "" };
        // No reflection is an index of 1. A quarter of 0.04 is 0.01, whose root is 0.1: 1.1 / 0.9.
        for (weight, ior) in [("0", 1.0), ("0.25", 1.1 / 0.9)] {
            let found = surface(id, &format!("float inputs:specular{suffix} = {weight}")).0;
            assert!((found.ior - ior).abs() < 1e-6, "{found:?}");
        }
        let inputs = format!("float inputs:subsurface{suffix} = 0.5 color3f inputs:subsurface_color = (0.2, 0.4, 0.6)");
        let (found, warnings) = surface(id, &inputs);
        found.color.color.into_iter().zip([0.5, 0.6, 0.7]).for_each(|(x, e)| assert!((x - e).abs() < 1e-6));
        assert!(warnings.contains(&format!("inputs:subsurface{suffix} is read as diffuse")), "{warnings}");
        // 0.8 times the mean of 1 and the tint.
        let inputs = format!("float inputs:coat{suffix} = 0.5 color3f inputs:coat_color = (0.5, 0, 1)");
        let found = surface(id, &inputs).0;
        found.color.color.into_iter().zip([0.6, 0.4, 0.8]).for_each(|(x, e)| assert!((x - e).abs() < 1e-6));
    }
}

#[test]
fn inputs_without_counterpart_are_named_if_they_have_an_effect() {
    let standard = ["coat", "transmission", "sheen", "thin_film_thickness", "diffuse_roughness"];
    let open = ["coat_weight", "transmission_weight", "fuzz_weight", "thin_film_weight", "base_diffuse_roughness"];
    for (id, names) in [(STANDARD, standard), (OPEN_PBR, open), ("arnold:standard_surface", standard)] {
        let inputs: String = names.iter().map(|name| format!("float inputs:{name} = 0.5\n")).collect();
        let warnings = surface(id, &inputs).1;
        for name in names {
            assert_eq!(warnings.matches(&format!("inputs:{name} ")).count(), 1, "{name}: {warnings}");
        }
    }
    let warnings = surface(STANDARD, "float inputs:specular_roughness = 3 bool inputs:thin_walled = 1").1;
    assert!(warnings.contains("inputs:specular_roughness is 3: it must be in [0, 1]"), "{warnings}");
    assert!(warnings.contains("inputs:thin_walled is not supported"), "{warnings}");
    let warnings = surface(STANDARD, "float inputs:emission = -1").1;
    assert!(warnings.contains("emission_color must be finite and not negative: its meshes have"), "{warnings}");
    // A normal that is computed.
    let inputs = "float3 inputs:normal.connect = </m/n.outputs:out>";
    let nodes = "def Shader \"n\" { uniform token info:id = \"ND_hextilednormalmap\" float3 outputs:out }";
    let warnings = said(&scene(&stage("mtlx:surface", STANDARD, inputs, nodes)).1);
    assert!(warnings.contains("inputs:normal is not supported"), "{warnings}");
}

/// A cutout by an image, of which one pixel is white and one has 0.2 of red, and by the alpha channel of another one,
/// with 0.8 and 0.4.
#[test]
fn images_cut_holes() {
    let image = "def Shader \"i\" { uniform token info:id = \"ND_image_float\" float outputs:out
        asset inputs:file = @t.png@ }";
    let by_node = stage("mtlx:surface", STANDARD, "color3f inputs:opacity.connect = </m/i.outputs:out>", image);
    let texture = "def Shader \"i\" { uniform token info:id = \"UsdUVTexture\" float outputs:a
        asset inputs:file = @alpha.png@ float4 inputs:scale = (9, 9, 9, 0.5) }";
    let inputs = "float inputs:opacity.connect = </m/i.outputs:a> float inputs:opacityThreshold = 0.25";
    let preview = stage("surface", "UsdPreviewSurface", inputs, texture);
    for (text, value, pixels, threshold) in [(by_node, 1.0, [1.0, 0.2], 0.0), (preview, 0.5, [0.8, 0.4], 0.25)] {
        let (scene, warnings) = with_image(&[("a.usda", &format!("#usda 1.0\n{text}"))]);
        let mesh = &scene.meshes[0];
        let opacity = scene.surfaces[mesh.surface].opacity;
        let texture = &scene.textures[opacity.texture.unwrap()];
        assert_eq!((opacity.value, opacity.threshold), (value, threshold), "{warnings}");
        assert_eq!([0, 1].map(|i| texture.pixels.get(i)[0]), pixels, "{warnings}");
        assert!(warnings.contains("its material has a texture, but it has no primvars:st"), "{warnings}");
    }
}

#[test]
fn opacities_without_an_image_are_numbers() {
    let opacity = |id, inputs: &str| surface(id, inputs).0.opacity;
    assert_eq!(opacity(STANDARD, "color3f inputs:opacity = (0.25, 0.5, 0.75)").value, 0.5);
    assert_eq!(opacity(OPEN_PBR, "float inputs:geometry_opacity = 0.25").value, 0.25);
    assert_eq!(opacity(STANDARD, "").value, 1.0);
    let body = format!(
        "{} float[] primvars:displayOpacity = [0.5] }}",
        MESH.trim_end_matches('}').replace("rel material:binding = </m>", "")
    );
    let (scene, warnings) = scene(&body);
    assert_eq!((scene.surfaces[0].opacity.value, warnings.len()), (0.5, 0), "{}", said(&warnings));
}

#[test]
fn a_mesh_without_opacity_is_left_out() {
    let curve = format!("def BasisCurves \"c\" {{ {} }}", super::FOUR);
    for (id, output, input) in [
        (STANDARD, "mtlx:surface", "color3f inputs:opacity = (0, 0, 0)"),
        (OPEN_PBR, "mtlx:surface", "float inputs:geometry_opacity = 0"),
        ("arnold:standard_surface", "arnold:surface", "color3f inputs:opacity = (0, 0, 0)"),
        ("UsdPreviewSurface", "surface", "float inputs:opacity = 0"),
    ] {
        let (scene, warnings) = scene(&(stage(output, id, input, "") + &curve));
        assert!(scene.meshes.is_empty());
        let warnings = said(&warnings);
        assert!(warnings.contains("/mesh: inputs:") && warnings.contains("of its material is 0"), "{warnings}");
        assert!(!warnings.contains("points"), "{warnings}");
    }
}

/// A stage next to an image of 1 × 2 pixels, white and 0.2 of red, and one that has an alpha channel, too.
fn with_image(files: &[(&str, &str)]) -> (Scene, String) {
    let folder = tempfile::tempdir().unwrap();
    let mut encoder = png::Encoder::new(std::fs::File::create(folder.path().join("t.png")).unwrap(), 1, 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 255, 255, 51, 0, 0]).unwrap();
    let mut encoder = png::Encoder::new(std::fs::File::create(folder.path().join("alpha.png")).unwrap(), 1, 2);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(&[255, 255, 255, 204, 51, 0, 0, 102]).unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let reading = read(&folder.path().join("a.usda"), &Options::default()).unwrap();
    (reading.scene, said(&reading.warnings))
}

#[test]
fn images_give_the_colour_and_means() {
    let inputs = "float inputs:base = 0.5 color3f inputs:base_color.connect = </m/tint.outputs:out>
        float inputs:specular_roughness.connect = </m/r.outputs:out>";
    let nodes = "
    def Shader \"tint\" { uniform token info:id = \"ND_multiply_color3\" color3f outputs:out
        color3f inputs:in1.connect = </m/i.outputs:out> color3f inputs:in2 = (1, 0.5, 0.5) }
    def Shader \"i\" { uniform token info:id = \"ND_image_color3\" color3f outputs:out
        asset inputs:file = @t.png@ ( colorSpace = \"lin_rec709\" )
        float2 inputs:texcoord.connect = </m/uv.outputs:out> }
    def Shader \"uv\" { uniform token info:id = \"ND_geompropvalue_vector2\" string inputs:geomprop = \"map1\"
        float2 outputs:out }
    def Shader \"r\" { uniform token info:id = \"ND_image_float\" float outputs:out asset inputs:file = @t.png@ }";
    let text = format!("#usda 1.0\n{}", stage("mtlx:surface", STANDARD, inputs, nodes));
    let (scene, warnings) = with_image(&[("a.usda", &text)]);
    let mesh = &scene.meshes[0];
    let found = &scene.surfaces[mesh.surface];
    let texture = &scene.textures[found.color.texture.unwrap()];
    assert_eq!((found.color.color, texture.pixels.get(0)), ([1.0; 3], [0.5, 0.25, 0.25]));
    assert_eq!(texture.pixels.get(1), [0.1, 0.0, 0.0]);
    assert!(mesh.uv.is_some());
    assert!((found.roughness - 0.6).abs() < 1e-6, "{found:?}");
    assert!(
        warnings.contains("inputs:specular_roughness has an image, which is not supported: its mean"),
        "{warnings}"
    );
    assert_eq!(warnings.lines().count(), 1, "{warnings}");
}

#[test]
fn a_document_gives_the_surface_of_a_mesh() {
    let document = "<materialx version=\"1.39\">
<tiledimage name=\"i\" type=\"color3\"><input name=\"file\" type=\"filename\" value=\"t.png\"/></tiledimage>
<standard_surface name=\"s\" type=\"surfaceshader\">
  <input name=\"base_color\" type=\"color3\" nodename=\"i\"/> <input name=\"metalness\" type=\"float\" value=\"1\"/>
</standard_surface>
<surfacematerial name=\"M\" type=\"material\">
  <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"s\"/></surfacematerial></materialx>";
    let mesh = MESH.replace("map1", "st");
    let text = format!("#usda 1.0\n{mesh}\ndef \"m\" ( references = @d.mtlx@</MaterialX/Materials/M> ) {{ }}");
    let (scene, warnings) = with_image(&[("a.usda", &text), ("d.mtlx", document)]);
    let found = &scene.surfaces[scene.meshes[0].surface];
    assert_eq!((found.metallic, warnings.as_str()), (1.0, ""));
    assert_eq!(scene.textures[found.color.texture.unwrap()].pixels.get(0), [1.0; 3]);
    let open = document.replace("standard_surface", "open_pbr_surface").replace("metalness", "base_metalness");
    let (scene, _) = with_image(&[("a.usda", &text), ("d.mtlx", &open)]);
    assert_eq!(scene.surfaces[scene.meshes[0].surface].roughness, 0.3);
}

#[test]
fn a_preview_surface_precedes_and_others_are_named() {
    let preview = "token outputs:surface.connect = </m/p.outputs:out>
        def Shader \"p\" { uniform token info:id = \"UsdPreviewSurface\" float inputs:roughness = 0.9
            token outputs:out }";
    let (shown, _) = scene(&stage("mtlx:surface", STANDARD, "", preview));
    assert_eq!(shown.surfaces[0].roughness, 0.9);
    let (found, _) = surface("ND_UsdPreviewSurface_surfaceshader", "float inputs:roughness = 0.7");
    check(&found, [0.18; 3], [0.0; 3], [0.7, 0.0, 1.5]);
    let warnings = surface("PxrSurface", "").1;
    assert!(warnings.contains("it has no UsdPreviewSurface, standard_surface or OpenPBR surface"), "{warnings}");
}

/// A node for normal maps, and UsdUVTexture with and without its scale.
#[test]
fn normal_maps_are_read() {
    let node = "def Shader \"n\" { uniform token info:id = \"ND_normalmap_float\" float3 outputs:out
        float inputs:scale = 0.5 float3 inputs:in.connect = </m/i.outputs:out> }
    def Shader \"i\" { uniform token info:id = \"ND_image_vector3\" float3 outputs:out asset inputs:file = @t.png@ }";
    let inputs = "float3 inputs:normal.connect = </m/n.outputs:out>";
    let texture = |numbers: &str| {
        format!(
            "def Shader \"n\" {{ uniform token info:id = \"UsdUVTexture\" float3 outputs:rgb asset inputs:file = @t.png@
            {numbers} }}"
        )
    };
    let [own, plain] =
        [texture("float4 inputs:scale = (2, -2, 2, 1) float4 inputs:bias = (-1, 1, -1, 0)"), texture("")];
    let preview = "normal3f inputs:normal.connect = </m/n.outputs:rgb>";
    for (text, scale, bias) in [
        (stage("mtlx:surface", STANDARD, inputs, node), [1.0, 1.0, 2.0], [-0.5, -0.5, -1.0]),
        (stage("surface", "UsdPreviewSurface", preview, &own), [2.0, -2.0, 2.0], [-1.0, 1.0, -1.0]),
        (stage("surface", "UsdPreviewSurface", preview, &plain), [2.0; 3], [-1.0; 3]),
    ] {
        let text = format!("#usda 1.0\n{text}");
        let (scene, warnings) = with_image(&[("a.usda", &text)]);
        let found = scene.surfaces[scene.meshes[0].surface].normals.unwrap_or_else(|| panic!("{warnings}"));
        assert_eq!((found.scale, found.bias), (scale, bias), "{warnings}");
        // Numbers are not colours.
        assert_eq!(scene.textures[found.texture].pixels.get(1)[0], 0.2);
        assert_eq!(warnings.lines().count(), 1, "{warnings}");
    }
}
