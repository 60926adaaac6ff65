//! Shading networks of other programs, and MaterialX documents.

use super::{FOUR, said};
use crate::common::read_text;
use glam::Vec3;
use std::fs;
use std::path::{Path, PathBuf};
use vellus::{Fiber, FiberBuilder, Parameter, Species};
use vellus_scene::{Look, Scene, Wrap};
use vellus_testing::program::Limited;
use vellus_usd::{Options, Reading, read, read_material};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// Relative, because the reference numbers have six digits.
#[track_caller]
fn near(x: f32, expected: f32) {
    assert!((x - expected).abs() <= 2e-5 * expected.abs().max(0.1), "{x} {expected}");
}

fn look<'a>(scene: &'a Scene, name: &str) -> &'a Look {
    scene.looks.iter().find(|look| look.name.ends_with(name)).unwrap()
}

/// The networks that OpenUSD wrote, with red fox for what they lack.
fn programs() -> (Reading, Fiber) {
    let base = Fiber::preset(Species::RedFox);
    let options = Options { network_base: base, ..Options::default() };
    (read(&data("programs.usda"), &options).unwrap(), base)
}

/// ln 0.75 = −0.287682; melanin is 0.287682 · ((0.506, 0.841, 1.653) + (0.343, 0.733, 1.924)) / 2. The colour's
/// polynomial is 5.74660 at 0.4 and 5.88841 at 0.3.
fn melanin_and_color(b: f64) -> [f32; 3] {
    let fit = if b == 0.4 { 5.746603 } else { 5.888415 };
    let melanin = [0.122121, 0.226406, 0.514518];
    let color = [0.9f64, 0.6, 0.4].map(|c| (c.ln() / fit).powi(2));
    std::array::from_fn(|i| (color[i] + melanin[i]) as f32)
}

#[test]
fn arnold_gives_melanin_and_colour_roughness_and_tilt() {
    let (reading, base) = programs();
    let fiber = look(&reading.scene, "/arnold").fiber;
    melanin_and_color(0.4).into_iter().zip(fiber.sigma_ca).for_each(|(expected, x)| near(x, expected));
    // 0.726 · 0.3 + 0.812 · 0.09 + 3.7 · 0.3²⁰; 0.265 · 0.4 + 1.194 · 0.16 + 5.372 · 0.4²², times π √(π/8) / √6.
    near(fiber.beta_m, 0.29088);
    near(fiber.beta_n, 0.238738);
    near(fiber.alpha.to_degrees(), 4.0);
    assert_eq!((fiber.eta, fiber.kappa, fiber.g, fiber.sigma_ms), (1.5, base.kappa, base.g, base.sigma_ms));
    assert!(said(&reading.warnings).contains("Not mapped: diffuse"), "{}", said(&reading.warnings));
}

#[test]
fn karma_gives_the_medulla_too() {
    let (reading, base) = programs();
    let fiber = look(&reading.scene, "/karma").fiber;
    // The thickness scale doubles the absorption.
    melanin_and_color(0.3).into_iter().zip(fiber.sigma_ca).for_each(|(expected, x)| near(x, 2.0 * expected));
    assert_eq!((fiber.kappa, fiber.g, fiber.sigma_ms), (0.6, 0.3, base.sigma_ms));
    // 0.02 · 90°, twice.
    near(fiber.alpha.to_degrees(), 3.6);
    let warnings = said(&reading.warnings);
    assert!(warnings.contains("Not mapped: medullaDiffuse") && !warnings.contains("does not scatter"), "{warnings}");
    let warnings = said(&read(&data("programs.usda"), &Options::default()).unwrap().warnings);
    assert!(warnings.contains("kappa from medullaRadius") && warnings.contains("does not scatter"), "{warnings}");
}

#[test]
fn renderman_gives_the_absorption_of_the_colour_of_tt() {
    let (reading, base) = programs();
    let fiber = look(&reading.scene, "/renderman").fiber;
    // √(1 − 1/2.25) + 1.5 asin(1/1.5) = 0.745356 + 1.5 · 0.729728.
    let chord = 1.839948f64;
    [0.8f64, 0.5, 0.2].into_iter().zip(fiber.sigma_ca).for_each(|(c, x)| near(x, (-c.ln() / chord) as f32));
    near(fiber.beta_m.to_degrees(), 6.0);
    near(fiber.alpha.to_degrees(), 4.0);
    assert_eq!((fiber.eta, fiber.beta_n), (1.5, base.beta_n));
    assert!(said(&reading.warnings).contains("diffuseGain"), "{}", said(&reading.warnings));
}

#[test]
fn a_preview_surface_gives_the_colour_of_the_coat() {
    let (reading, base) = programs();
    let mut expected = FiberBuilder::new(base);
    expected.set_value(Parameter::Reflectance, [0.5, 0.3, 0.2]);
    assert_eq!(look(&reading.scene, "/preview").fiber, expected.build().unwrap());
    assert!(said(&reading.warnings).contains("Not mapped: roughness"), "{}", said(&reading.warnings));
    // Each material has one warning.
    assert_eq!((reading.warnings.len(), reading.networks.len()), (4, 4), "{}", said(&reading.warnings));

    // Blender's empty surface says nothing about the fibre.
    let empty = format!(
        "def BasisCurves \"c\" {{ {FOUR}\n rel material:binding = </m> }}
def Material \"m\" {{
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader \"s\" {{ uniform token info:id = \"UsdPreviewSurface\" token outputs:surface }}
}}"
    );
    let options = Options { fallback: base, ..Options::default() };
    let (scene, warnings) = read_text(&empty, &options).unwrap();
    assert_eq!(scene.looks[0].fiber, base);
    assert!(said(&warnings).contains("UsdPreviewSurface without inputs"), "{}", said(&warnings));
}

/// A folder with the document that the package MaterialX wrote, and its image: one black and one white pixel.
fn document() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(data("hair.mtlx"), folder.path().join("hair.mtlx")).unwrap();
    let mut encoder = png::Encoder::new(fs::File::create(folder.path().join("coat.png")).unwrap(), 2, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[0, 0, 0, 255, 255, 255]).unwrap();
    folder
}

#[test]
fn a_stage_binds_a_material_of_a_document_with_an_image() {
    let folder = document();
    let stage = format!(
        "#usda 1.0
def BasisCurves \"c\" {{ {FOUR}\n rel material:binding = </fox> }}
def \"fox\" ( references = @hair.mtlx@</MaterialX/Materials/Fox> ) {{ }}"
    );
    let file = folder.path().join("stage.usda");
    fs::write(&file, stage).unwrap();
    let reading = read(&file, &Options::default()).unwrap();
    let look = &reading.scene.looks[0];
    assert_eq!(look.fiber.eta, 1.5);
    near(look.fiber.beta_m, 0.29088);
    // The image of the colour becomes one of the absorption. Black counts as 0.001.
    let [(Parameter::SigmaCa, value)] = look.textured[..] else { panic!("{look:?}") };
    let texture = &reading.scene.textures[value.texture];
    assert_eq!((texture.width, texture.height, value.scale), (2, 1, [1.0; 3]));
    assert_eq!(texture.wrap, [Wrap::Clamp, Wrap::Repeat]);
    // The polynomial at 0.2 is 5.969 − 0.043 + 0.10128 − 0.08584 + 0.0089184 + 0.0000784.
    near(texture.pixels.get(0)[0], (0.001f32.ln() / 5.950437).powi(2));
    assert_eq!(texture.pixels.get(1), [0.0; 3]);
    // The digest of what was read depends on the document.
    let before = reading.sources;
    let text = fs::read_to_string(folder.path().join("hair.mtlx")).unwrap().replace("1.5", "1.6");
    fs::write(folder.path().join("hair.mtlx"), text).unwrap();
    let after = read(&file, &Options::default()).unwrap();
    assert!(after.scene.looks[0].fiber.eta == 1.6 && after.sources != before);
}

#[test]
fn a_document_gives_a_fibre() {
    let folder = document();
    let file = folder.path().join("hair.mtlx");
    let base = Fiber::preset(Species::Cat);
    let (fiber, warnings) = read_material(&file, Some("Plain"), &base).unwrap();
    assert_eq!((fiber.sigma_ca, fiber.kappa), ([0.1, 0.2, 0.4], base.kappa));
    assert_eq!(warnings.len(), 1);
    let (fiber, warnings) = read_material(&file, Some("Fox"), &base).unwrap();
    assert_eq!((fiber.eta, fiber.sigma_ca), (1.5, base.sigma_ca));
    assert!(said(&warnings).contains("those of sigma_ca are ignored"), "{}", said(&warnings));

    let error = |name: Option<&str>| read_material(&file, name, &base).unwrap_err().to_string();
    assert!(error(None).contains("choose one of Fox, Plain"), "{}", error(None));
    assert!(error(Some("fox")).contains("no material fox: known are Fox, Plain"));
}

#[test]
fn broken_documents_are_refused_with_their_line() {
    let folder = document();
    let file = folder.path().join("hair.mtlx");
    let good = fs::read_to_string(&file).unwrap();
    for (old, new, expected) in [
        ("</materialx>", "", "broken XML"),
        ("materialx", "material", "must be materialx"),
        ("0.1, 0.2, 0.4", "0.1, 0.2", "line 31: absorption_coefficient must have 3 finite numbers"),
        ("nodename=\"rough\"", "nodename=\"gone\"", "there is no node gone"),
        ("nodegraph=\"graph\"", "nodegraph=\"gone\"", "line 11: there is no node graph gone"),
        ("coat.png", "a@b", "line 5: the name of a file"),
        ("name=\"plain_bsdf\"", "name=\"plain bsdf\"", "line 30: \"plain bsdf\" is no name"),
        ("surfacematerial", "surface_material", "no surfacematerial"),
    ] {
        fs::write(&file, good.replace(old, new)).unwrap();
        let message = read_material(&file, Some("Plain"), &Fiber::hair()).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

/// What Blender 5.2 wrote with `integrations/blender/vellus_usd_hook.py`.
#[test]
fn blender_writes_principled_hair_as_vellus_fur() {
    let file = data("principled_hair.usda");
    check_principled_hair(&file);
    // The strand is along x, and its longer axis along y.
    let reading = read(&file, &Options::default()).unwrap();
    let [normals] = &reading.scene.strands.iter().filter_map(|s| s.normals.as_ref()).collect::<Vec<_>>()[..] else {
        panic!("one of the three has normals");
    };
    assert!(normals.iter().all(|n| n.abs() == Vec3::Z), "{normals:?}");
}

/// The same with the Blender of this machine: a Python that has bpy, in `VELLUS_BPY`.
#[test]
fn the_hook_writes_the_same_with_another_blender() {
    let Some(python) = vellus_testing::blender() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("hair.usda");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../integrations/blender/test_usd_hook.py");
    let run = std::process::Command::new(python).arg(script).arg(&file).run().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    check_principled_hair(&file);
}

fn check_principled_hair(file: &Path) {
    let reading = read(file, &Options::default()).unwrap();
    assert_eq!(said(&reading.warnings), "");
    let fiber = look(&reading.scene, "/absorbed").fiber;
    assert_eq!((fiber.sigma_ca, fiber.eta), ([0.1, 0.2, 0.4], 1.5));
    near(fiber.beta_m, 0.29088);
    near(fiber.beta_n, 0.238738);
    near(fiber.alpha.to_degrees(), 6.0);
    // The model Huang has one roughness, here 0.4: also the colour's polynomial is that of 0.4.
    let fiber = look(&reading.scene, "/melanin").fiber;
    // Absorption in Cycles is per half of the longer axis.
    let flat = melanin_and_color(0.4).map(|x| x * 0.625f32.sqrt());
    flat.into_iter().zip(fiber.sigma_ca).for_each(|(expected, x)| near(x, expected));
    near(fiber.beta_m, 0.42032);
    assert_eq!(fiber.aspect_ratio, 0.625);
    // Custom properties choose a fibre with a medulla, so that the colour is that of the coat.
    let fiber = look(&reading.scene, "/colored").fiber;
    let mut expected = FiberBuilder::new(Fiber { alpha: fiber.alpha, beta_m: fiber.beta_m, ..fiber });
    expected.set_value(Parameter::Reflectance, [0.9, 0.6, 0.4]);
    assert_eq!(expected.build().unwrap().sigma_ca, fiber.sigma_ca);
    assert_eq!((fiber.kappa, fiber.g), (0.7, Fiber::preset(Species::RedFox).g));
}

/// A document with one material, whose colour comes from these nodes.
fn colored(attributes: &str, color: &str, nodes: &str) -> String {
    format!(
        "<materialx version=\"1.39\" {attributes}>{nodes}
<chiang_hair_absorption_from_color name=\"abs\" type=\"vector3\">{color}</chiang_hair_absorption_from_color>
<chiang_hair_bsdf name=\"b\" type=\"BSDF\">
  <input name=\"absorption_coefficient\" type=\"vector3\" nodename=\"abs\"/></chiang_hair_bsdf>
<surface name=\"s\" type=\"surfaceshader\"><input name=\"bsdf\" type=\"BSDF\" nodename=\"b\"/></surface>
<surfacematerial name=\"M\" type=\"material\">
  <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"s\"/></surfacematerial></materialx>"
    )
}

fn fiber_of(document: &str) -> Result<Fiber, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.mtlx");
    fs::write(&file, document).unwrap();
    read_material(&file, None, &Fiber::hair()).map(|(fiber, _)| fiber).map_err(|error| error.to_string())
}

/// The same document as a part of a scene: the fibre and the warnings.
fn in_scene(document: &str) -> Result<(Fiber, String), String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.mtlx"), document).unwrap();
    let stage = format!(
        "#usda 1.0
def BasisCurves \"c\" {{ {FOUR}\n rel material:binding = </m> }}
def \"m\" ( references = @a.mtlx@</MaterialX/Materials/M> ) {{ }}"
    );
    let file = folder.path().join("stage.usda");
    fs::write(&file, stage).unwrap();
    let reading = read(&file, &Options::default()).map_err(|error| error.to_string())?;
    Ok((reading.scene.looks[0].fiber, said(&reading.warnings)))
}

/// σ of a linear colour with the default roughness.
fn sigma(color: [f64; 3]) -> [f32; 3] {
    color.map(|c| (c.ln() / 5.950437).powi(2) as f32)
}

#[test]
fn colours_have_the_colour_space_of_their_document_graph_node_or_input() {
    let input = |more: &str| format!("<input name=\"color\" type=\"color3\" value=\"0.5, 0.3, 0.2\" {more}/>");
    let check = |document: &str, expected: [f32; 3]| {
        fiber_of(document).unwrap().sigma_ca.into_iter().zip(expected).for_each(|(x, e)| near(x, e));
    };
    let linear = sigma([0.5, 0.3, 0.2]);
    // ((x + 0.055) / 1.055)^2.4 of 0.5, 0.3, 0.2.
    let srgb = sigma([0.21404114, 0.07323896, 0.03310477]);
    [0.0136, 0.0409, 0.0732].into_iter().zip(linear).for_each(|(e, x)| assert!((x - e).abs() < 5e-5));
    [0.0671, 0.193, 0.328].into_iter().zip(srgb).for_each(|(e, x)| assert!((x - e).abs() < 5e-4));
    let space = "colorspace=\"srgb_texture\"";
    check(&colored("", &input(""), ""), linear);
    check(&colored(space, &input(""), ""), srgb);
    check(&colored("", &input(space), ""), srgb);
    check(&colored(space, &input("colorspace=\"lin_rec709\""), ""), linear);
    check(&colored("", &input(""), "").replace("name=\"abs\" type", &format!("name=\"abs\" {space} type")), srgb);
    // The space of a node in a graph is that of the graph.
    let from = "<input name=\"color\" type=\"color3\" nodegraph=\"g\"/>";
    let graph = format!(
        "<nodegraph name=\"g\" {space}><constant name=\"c\" type=\"color3\">{}</constant>
        <output name=\"out\" type=\"color3\" nodename=\"c\"/></nodegraph>",
        input("").replace("\"color\"", "\"value\"")
    );
    check(&colored("colorspace=\"lin_rec709\"", from, &graph), srgb);
    // Row sums of the matrix of lin_ap1 are 1, so grey stays grey.
    check(&colored("colorspace=\"acescg\"", &input("").replace("0.5, 0.3, 0.2", "0.3, 0.3, 0.3"), ""), sigma([0.3; 3]));
    // A name that is not known is never ignored in silence.
    let unknown = colored("colorspace=\"nonsense\"", &input(""), "");
    assert!(fiber_of(&unknown).unwrap_err().contains("the colour space nonsense is not supported"));
    let (fiber, warnings) = in_scene(&unknown).unwrap();
    near(fiber.sigma_ca[0], linear[0]);
    assert!(warnings.contains("inputs:color: the colour space nonsense is not supported"), "{warnings}");
}

#[test]
fn colours_of_usd_have_the_space_of_their_attribute_or_prim() {
    let stage = |space: &str, prim: &str| {
        format!(
            "def BasisCurves \"c\" {{ {FOUR}\n rel material:binding = </m> }}
def Material \"m\" {{
    {prim}
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader \"s\" {{ uniform token info:id = \"UsdPreviewSurface\"
        color3f inputs:diffuseColor = (0.5, 0.3, 0.2) {space} token outputs:surface }}
}}"
        )
    };
    let fiber = |space: &str, prim: &str| read_text(&stage(space, prim), &Options::default()).unwrap();
    let expected = |color: [f32; 3]| {
        let mut builder = FiberBuilder::new(Fiber::hair());
        builder.set_value(Parameter::Reflectance, color);
        builder.build().unwrap().sigma_ca
    };
    let srgb = expected([0.21404114, 0.07323896, 0.03310477]);
    let same = |fiber: Fiber, sigma: [f32; 3]| fiber.sigma_ca.into_iter().zip(sigma).for_each(|(x, e)| near(x, e));
    same(fiber("", "").0.looks[0].fiber, expected([0.5, 0.3, 0.2]));
    same(fiber("( colorSpace = \"srgb_rec709_scene\" )", "").0.looks[0].fiber, srgb);
    same(fiber("", "uniform token colorSpace:name = \"srgb_rec709_scene\"").0.looks[0].fiber, srgb);
    let own = fiber("( colorSpace = \"raw\" )", "uniform token colorSpace:name = \"srgb_rec709_scene\"");
    same(own.0.looks[0].fiber, expected([0.5, 0.3, 0.2]));
    let warnings = said(&fiber("( colorSpace = \"mine\" )", "").1);
    assert!(warnings.contains("inputs:diffuseColor: the colour space mine is not supported"), "{warnings}");
}

#[test]
fn values_that_are_not_valid_are_never_dropped() {
    let input = |kind: &str, value: &str| format!("<input name=\"color\" type=\"{kind}\" value=\"{value}\"/>");
    for (color, expected) in [
        (input("Color3", "0.5, 0.3, 0.2"), "color has the unknown type Color3"),
        (input("", "0.5"), "color has the unknown type"),
        (input("color3", "0.5, red, 0.2"), "must have 3 finite numbers"),
        (input("integer", "0.5"), "must be an integer"),
        (input("boolean", "True"), "must be true or false"),
        (input("color3", "0.5, 0.3, 0.2").repeat(2), "the name color is used twice"),
    ] {
        let document = colored("", &color, "");
        // The user named the material, or it is a part of a scene.
        let told = in_scene(&document).map_or_else(|error| error, |(_, said)| said);
        for error in [fiber_of(&document).unwrap_err(), told] {
            assert!(error.contains(expected) && error.contains("line "), "{error}");
        }
    }
    let outside = colored("", &input("color3", "-1, 0, 2"), "");
    let what = "inputs:color is (-1, 0, 2) in linear Rec. 709: it must be in [0, 1]";
    assert!(fiber_of(&outside).unwrap_err().contains(what));
    assert!(in_scene(&outside).unwrap().1.contains(what));
}

/// A node `g_n` and the node `n` of the graph `g` are two nodes.
#[test]
fn nodes_of_graphs_do_not_become_other_nodes() {
    let constant = |name: &str, value: &str| {
        format!(
            "<constant name=\"{name}\" type=\"color3\">
            <input name=\"value\" type=\"color3\" value=\"{value}\"/></constant>"
        )
    };
    let graph = |name: &str, node: &str, value: &str| {
        let output = format!("<output name=\"out\" type=\"color3\" nodename=\"{node}\"/>");
        format!("<nodegraph name=\"{name}\">{}{output}</nodegraph>", constant(node, value))
    };
    let nodes = constant("g_n", "0.1, 0.1, 0.1")
        + &graph("g", "n", "0.2, 0.2, 0.2")
        + &graph("a_b", "c", "0.3, 0.3, 0.3")
        + &graph("a", "b_c", "0.4, 0.4, 0.4");
    for (from, color) in
        [("nodename=\"g_n\"", 0.1), ("nodegraph=\"g\"", 0.2), ("nodegraph=\"a_b\"", 0.3), ("nodegraph=\"a\"", 0.4)]
    {
        let others = "<input name=\"azimuthal_roughness\" type=\"float\" value=\"0.2\"/>";
        let input = format!("<input name=\"color\" type=\"color3\" {from}/>{others}");
        near(fiber_of(&colored("", &input, &nodes)).unwrap().sigma_ca[0], sigma([color; 3])[0]);
    }
    // Both in one material.
    let both = "<input name=\"color\" type=\"color3\" nodename=\"g_n\"/>
        <input name=\"azimuthal_roughness\" type=\"float\" nodegraph=\"g\"/>";
    near(fiber_of(&colored("", both, &nodes)).unwrap().sigma_ca[0], sigma([0.1; 3])[0]);
}

#[test]
fn a_prefix_of_files_replaces_those_around_it() {
    let folder = document();
    let file = folder.path().join("hair.mtlx");
    fs::create_dir(folder.path().join("in")).unwrap();
    fs::rename(folder.path().join("coat.png"), folder.path().join("in/coat.png")).unwrap();
    let text = fs::read_to_string(&file).unwrap();
    let text = text.replace("version=\"1.39\"", "version=\"1.39\" fileprefix=\"wrong/\"");
    fs::write(&file, text.replace("name=\"graph\"", "name=\"graph\" fileprefix=\"in/\"")).unwrap();
    read_material(&file, Some("Fox"), &Fiber::hair()).unwrap();
    fs::write(&file, text).unwrap();
    let error = read_material(&file, Some("Fox"), &Fiber::hair()).unwrap_err().to_string();
    assert!(error.contains("the file wrong/coat.png does not exist"), "{error}");
}

#[test]
fn documents_have_limits_before_they_are_parsed() {
    let attributes = |n: usize| (0..n).map(|i| format!("a{i}='>' ")).collect::<String>();
    assert!(fiber_of(&colored(&attributes(255), "<!-- <a><a -->", "")).is_ok());
    let many = fiber_of(&colored(&attributes(200_000), "", "")).unwrap_err();
    assert!(many.contains("line 1: an element has more than 256 attributes"), "{many}");
    let deep = "<a b='/'>".repeat(100_000) + &"</a>".repeat(100_000);
    assert!(fiber_of(&colored("", "", &deep)).unwrap_err().contains("more than 64 elements are nested"));
    assert!(fiber_of(&colored("", "", &"<a/>".repeat(1000))).is_ok());
    let spaces: String = (0..100).map(|i| format!("<a xmlns:n{i}='x'/>")).collect();
    assert!(fiber_of(&colored("", "", &spaces)).unwrap_err().contains("more than 64 XML namespaces"));
}
