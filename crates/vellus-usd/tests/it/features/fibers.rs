//! Shaders of fibres: presets, inputs, interfaces and textures.

use super::{FOUR, said};
use crate::common::{read, read_text, told};
use vellus::{Fiber, Species};
use vellus_scene::Parameter;
use vellus_usd::Options;

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
    assert!(said.contains("/aFur/Shader: inputs:unknown is not read"), "{said}");
    assert!(said.contains("/cFur: it has no VellusFur shader"), "{said}");

    let error = |inputs: &str| told(read_text(&(curve("a") + &fur("a", inputs)), &options));
    assert!(
        error("float inputs:eta = 9").contains("/aFur/Shader: inputs:eta is 9: the range is"),
        "{}",
        error("float inputs:eta = 9")
    );
    assert!(error("float inputs:beta_m = 0.01").contains("[0.1, 90] degrees"));
    assert!(error("string inputs:preset = \"yeti\"").contains("'yeti'"));
    assert!(error("float2 inputs:melanin = (1, 2) color3f inputs:sigma_ca = (1, 1, 1)").contains("only one may"));
    assert!(error("float inputs:g.connect = </aFur/Shader.inputs:g>").contains("in a circle"));

    // The pigments of melanin, with the names that other renderers use.
    let pigments = "float inputs:eumelanin = 1.3 float inputs:pheomelanin = 0.2";
    let (scene, warnings) = read_text(&(curve("a") + &fur("a", pigments)), &options).unwrap();
    let brown = vellus::Color::Melanin { eumelanin: 1.3, pheomelanin: 0.2 };
    assert_eq!((scene.looks[0].fiber, warnings.len()), (Fiber::hair().with_color(brown).unwrap(), 0), "{warnings:?}");
    assert!(error("float inputs:eumelanin = 101").contains("eumelanin = 101 is out of range"));
    assert!(error("float inputs:eumelanin = 1 color3f inputs:sigma_ca = (1, 1, 1)").contains("only one may"));
}

/// The renderer multiplies a texture by its scale and then converts the product to radians. The reader must not convert
/// the scale.
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
