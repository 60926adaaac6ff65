//! Hair nodes of MaterialX.

use super::{FOUR, said};
use crate::common::{read_text, told};
use glam::Vec3;
use std::path::Path;
use vellus::{Bcsdf, Fiber, Window};
use vellus_usd::Options;

fn near(x: f32, expected: f32) {
    // The reference numbers have six digits.
    assert!((x - expected).abs() < 1e-5, "{x} {expected}");
}

/// A material with a hair node and other shaders. `inputs` are those of the hair node.
fn hair(inputs: &str, nodes: &str) -> String {
    format!(
        "def BasisCurves \"c\" {{ {FOUR}\n rel material:binding = </m> }}
def Material \"m\" {{
    token outputs:mtlx:surface.connect = </m/hair.outputs:out>
    def Shader \"hair\" {{
        uniform token info:id = \"ND_chiang_hair_bsdf\"
        {inputs}
        token outputs:out
    }}
    {nodes}
}}\n"
    )
}

#[test]
fn a_network_that_openusd_wrote_gives_its_fibre() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/chiang.usda");
    let reading = vellus_usd::read(&file, &Options::default()).unwrap();
    let fiber = reading.scene.looks[0].fiber;
    assert_eq!((fiber.eta, fiber.kappa), (1.5, 0.0));
    // 0.726·0.3 + 0.812·0.09 + 3.7·0.3²⁰ = 0.29088.
    near(fiber.beta_m, 0.29088);
    // s = 0.265·0.4 + 1.194·0.16 + 5.372·0.4²² = 0.29704; π √(π/8) s / √6 = 0.238738.
    near(fiber.beta_n, 0.238738);
    near(fiber.alpha.to_degrees(), 3.6);
    // ln 2 · (0.75·(0.419, 0.697, 1.37) + 0.25·(0.187, 0.4, 1.05))
    [0.250225, 0.431657, 0.894160].into_iter().zip(fiber.sigma_ca).for_each(|(e, x)| near(x, e));
    let said = said(&reading.warnings);
    assert!(said.contains("Not mapped: tint_R, roughness of TT"), "{said}");
    assert_eq!(reading.warnings.len(), 1, "{said}");
}

/// The network has no medulla and no layers: they come from the base. The network's absorption replaces that of the
/// base.
#[test]
fn the_base_completes_a_network() {
    let options = Options { network_base: Fiber::preset(vellus::Species::Cat), ..Options::default() };
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/chiang.usda");
    let reading = vellus_usd::read(&file, &options).unwrap();
    let (fiber, base) = (reading.scene.looks[0].fiber, options.network_base);
    assert_eq!((fiber.kappa, fiber.g, fiber.layers), (base.kappa, base.g, base.layers));
    assert_eq!((fiber.sigma_ms, fiber.sigma_ma), (base.sigma_ms, base.sigma_ma));
    assert_eq!(fiber.eta, 1.5);
    assert_eq!(reading.networks, [reading.scene.looks[0].name.clone()]);
}

#[test]
fn the_tilt_moves_r_towards_the_root() {
    let body = hair("float inputs:cuticle_angle = 0.51 float2 inputs:roughness_R = (0.0025, 0.1)", "");
    let (scene, _) = read_text(&body, &Options::default()).unwrap();
    let bcsdf = Bcsdf::new(&scene.looks[0].fiber).unwrap();
    let at = |degrees: f32| Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
    let hit = bcsdf.at(at(20.0), Window::near(0.0));
    let r = |degrees: f32| hit.eval(at(degrees)).0[0][0] / degrees.to_radians().cos();
    // MaterialX: θi = −θo − 2·1.8°.
    assert!(r(-23.6) > 1.1 * r(-20.0) && r(-20.0) > r(-16.4));
}

#[test]
fn vellus_inputs_precede_and_what_is_unknown_is_named() {
    let image = "def Shader \"i\" { uniform token info:id = \"ND_noise2d_float\" float outputs:out }";
    let body = hair("float inputs:ior.connect = </m/i.outputs:out>", image);
    let (scene, warnings) = read_text(&body, &Options::default()).unwrap();
    let fiber = scene.looks[0].fiber;
    assert_eq!((fiber.eta, fiber.alpha, fiber.sigma_ca), (1.55, 0.0, [0.0; 3]));
    // The defaults of the node: √0.1, and π √(π/8) · 0.05 / √6.
    near(fiber.beta_m, 0.316228);
    near(fiber.beta_n, 0.0401862);
    assert!(said(&warnings).contains("inputs:ior: a ND_noise2d_float is not mapped"), "{}", said(&warnings));

    let fur = "def Shader \"f\" { uniform token info:id = \"VellusFur\" token outputs:out }
    token outputs:surface.connect = </m/f.outputs:out>";
    let (scene, warnings) = read_text(&hair("", fur), &Options::default()).unwrap();
    assert_eq!((scene.looks[0].fiber, warnings.len()), (Fiber::hair(), 0));
}

#[test]
fn bad_networks_are_refused_with_one_message() {
    let error = |inputs: &str| told(read_text(&hair(inputs, ""), &Options::default()));
    assert!(error("float inputs:ior = nan").contains("/m/hair: inputs:ior must be one finite number, or three"));
    assert!(error("float inputs:ior = 9").contains("/m/hair: inputs:ior gives eta = 9: the range is"));
    assert!(error("string inputs:ior = \"glass\"").contains("inputs:ior"));
    assert!(error("float2 inputs:roughness_R = (-1, 0.1)").contains("two finite numbers that are not negative"));
    assert!(error("float inputs:ior.connect = </m/hair.inputs:ior>").contains("in a circle"));
    let missing = hair("", "").replace("</m/hair.outputs:out>", "</m/gone.outputs:out>");
    let (_, warnings) = read_text(&missing, &Options::default()).unwrap();
    assert!(said(&warnings).contains("/m: it has no VellusFur shader"), "{}", said(&warnings));
}

/// Constants that feed each other, and chains of connections. A chain is no circle, but it has a limit.
#[test]
fn circles_and_chains_of_connections_have_an_end() {
    let read = |body: &str| read_text(body, &Options::default());
    let error = |body: &str| told(read(body));
    let constant = |name: &str, from: &str| {
        format!(
            "def Shader \"{name}\" {{ uniform token info:id = \"ND_constant_float\" float inputs:value{from}
            float outputs:out }}\n"
        )
    };
    let to = |name: &str| format!(".connect = </m/{name}.outputs:out>");
    let ior = |from: &str, nodes: &str| hair(&format!("float inputs:ior{from}"), nodes);
    let two = constant("c", &to("d")) + &constant("d", &to("c"));
    let circles = [two, constant("c", &to("c")), constant("c", ".connect = </m/c.inputs:value>")];
    for nodes in circles {
        let error = error(&ior(&to("c"), &nodes));
        assert!(error.contains("/m/hair: inputs:ior is connected in a circle"), "{error}");
    }
    // A constant is two steps: to its output, and on to its input.
    let constants = |n: usize| {
        let links = (1..n).map(|i| constant(&format!("c{i}"), &to(&format!("c{}", i - 1))));
        ior(&to(&format!("c{}", n - 1)), &(constant("c0", " = 1.4") + &links.collect::<String>()))
    };
    let inputs = |n: usize| {
        let links = (1..n).map(|i| format!("float inputs:i{i}.connect = </m.inputs:i{}>\n", i - 1));
        let nodes = "float inputs:i0 = 1.4\n".to_owned() + &links.collect::<String>();
        ior(&format!(".connect = </m.inputs:i{}>", n - 1), &nodes)
    };
    for body in [constants(64), inputs(128)] {
        assert_eq!(read(&body).unwrap().0.looks[0].fiber.eta, 1.4);
    }
    for body in [constants(65), inputs(129)] {
        let error = error(&body);
        assert!(error.contains("inputs:ior has a chain of more than 128 connections"), "{error}");
    }
}

/// Each node gives 1.4. Results that are no numbers are 0, as in OSL.
#[test]
fn nodes_that_compute_are_read() {
    let ior = |nodes: &str| hair("float inputs:ior.connect = </m/n.outputs:out>", nodes);
    let node = |name: &str, id: &str, inputs: &str| {
        format!("def Shader \"{name}\" {{ uniform token info:id = \"ND_{id}\" {inputs} float outputs:out }}\n")
    };
    let table = [
        ("divide_float", "float inputs:in1 = 2.8 float inputs:in2 = 2"),
        ("divide_float", "float inputs:in1 = 1.4"),
        ("power_float", "float inputs:in1 = 1.96 float inputs:in2 = 0.5"),
        ("min_float", "float inputs:in1 = 1.6 float inputs:in2 = 1.4"),
        ("max_float", "float inputs:in1 = 1.2 float inputs:in2 = 1.4"),
        ("max_float", "float inputs:in1.connect = </m/zero.outputs:out> float inputs:in2 = 1.4"),
        ("max_float", "float inputs:in1.connect = </m/root.outputs:out> float inputs:in2 = 1.4"),
        ("invert_float", "float inputs:amount = 2 float inputs:in = 0.6"),
        ("invert_float", "float inputs:in = -0.4"),
        ("clamp_float", "float inputs:in = 3 float inputs:low = 1.2 float inputs:high = 1.4"),
        ("clamp_float", "float inputs:in = 0 float inputs:low = 1.4 float inputs:high = 2"),
        ("extract_color3", "color3f inputs:in = (1.2, 1.3, 1.4) int inputs:index = 2"),
        ("extract_vector3", "float3 inputs:in = (1.4, 1.3, 1.2)"),
    ];
    let fixed = node("zero", "divide_float", "float inputs:in1 = 9 float inputs:in2 = 0")
        + &node("root", "power_float", "float inputs:in1 = -9 float inputs:in2 = 0.5");
    for (id, inputs) in table {
        let (scene, warnings) = read_text(&ior(&(node("n", id, inputs) + &fixed)), &Options::default()).unwrap();
        near(scene.looks[0].fiber.eta, 1.4);
        assert!(!said(&warnings).contains("is not mapped"), "{id}: {}", said(&warnings));
    }
    for (id, inputs) in [
        ("extract_color4", "color4f inputs:in = (1.2, 1.3, 1.4, 1) int inputs:index = 3"),
        ("extract_vector2", "float2 inputs:in = (1.2, 1.3)"),
    ] {
        let (_, warnings) = read_text(&ior(&node("n", id, inputs)), &Options::default()).unwrap();
        let expected = format!("inputs:ior: a ND_{id} is not mapped");
        assert!(said(&warnings).contains(&expected), "{}", said(&warnings));
    }
}

/// A document whose material is a node `coat` of its own. Its graph has a node `pigment` of its own.
fn own_nodes(coat: &str) -> String {
    format!(
        "<materialx version=\"1.39\">
<nodedef name=\"ND_pigment\" node=\"pigment\">
  <input name=\"amount\" type=\"float\" value=\"0.1\"/> <output name=\"out\" type=\"vector3\"/></nodedef>
<nodegraph name=\"NG_pigment\">
  <deon_hair_absorption_from_melanin name=\"n\" type=\"vector3\">
    <input name=\"melanin_concentration\" type=\"float\" interfacename=\"amount\"/>
    <input name=\"melanin_redness\" type=\"float\" value=\"0.5\"/></deon_hair_absorption_from_melanin>
  <output name=\"out\" type=\"vector3\" nodename=\"n\"/></nodegraph>
<implementation name=\"I_pigment\" nodedef=\"ND_pigment\" nodegraph=\"NG_pigment\"/>
<nodedef name=\"ND_coat\" node=\"coat\">
  <input name=\"concentration\" type=\"float\" value=\"0.2\"/> <input name=\"ior\" type=\"float\" value=\"1.4\"/>
  <input name=\"share\" type=\"float\" value=\"1\"/> <output name=\"out\" type=\"surfaceshader\"/></nodedef>
<nodegraph name=\"NG_coat\" nodedef=\"ND_coat\">
  <pigment name=\"a\" type=\"vector3\">
    <input name=\"amount\" type=\"float\" interfacename=\"concentration\"/></pigment>
  <pigment name=\"b\" type=\"vector3\"><input name=\"amount\" type=\"float\" value=\"0.75\"/></pigment>
  <mix name=\"m\" type=\"vector3\">
    <input name=\"fg\" type=\"vector3\" nodename=\"a\"/> <input name=\"bg\" type=\"vector3\" nodename=\"b\"/>
    <input name=\"mix\" type=\"float\" interfacename=\"share\"/></mix>
  <chiang_hair_bsdf name=\"n\" type=\"BSDF\">
    <input name=\"absorption_coefficient\" type=\"vector3\" nodename=\"m\"/>
    <input name=\"roughness_R\" type=\"vector2\" value=\"0.04 0.1\"/>
    <input name=\"ior\" type=\"float\" interfacename=\"ior\"/></chiang_hair_bsdf>
  <surface name=\"s\" type=\"surfaceshader\"><input name=\"bsdf\" type=\"BSDF\" nodename=\"n\"/></surface>
  <output name=\"out\" type=\"surfaceshader\" nodename=\"s\"/></nodegraph>
<constant name=\"half\" type=\"float\"><input name=\"value\" type=\"float\" value=\"0.5\"/></constant>
<coat name=\"c\" type=\"surfaceshader\">{coat}</coat>
<surfacematerial name=\"M\" type=\"material\">
  <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"c\"/></surfacematerial></materialx>"
    )
}

fn fiber_of(document: &str) -> Result<Fiber, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.mtlx");
    std::fs::write(&file, document).unwrap();
    vellus_usd::read_material(&file, None, &Fiber::hair()).map(|(fiber, _)| fiber).map_err(|error| error.to_string())
}

#[test]
fn a_node_of_the_document_is_its_graph_with_the_values_of_the_node() {
    // Both pigments in equal parts, times the amount −ln(1 − concentration).
    let sigma = |amount: f32| [0.303, 0.5485, 1.21].map(|x| amount * x);
    let check = |coat: &str, amount: f32, eta: f32| {
        let fiber = fiber_of(&own_nodes(coat)).unwrap();
        // The colours of the pigments have six digits, and these numbers three.
        fiber.sigma_ca.into_iter().zip(sigma(amount)).for_each(|(x, e)| assert!((x - e).abs() < 1e-3, "{x} {e}"));
        assert_eq!(fiber.eta, eta);
        // Numbers that a space separates.
        near(fiber.beta_m, 0.2);
    };
    let (half, quarter) = (2f32.ln(), 4f32.ln());
    check("<input name=\"concentration\" type=\"float\" value=\"0.5\"/>", half, 1.4);
    check("<input name=\"concentration\" type=\"float\" nodename=\"half\"/>", half, 1.4);
    check("<input name=\"ior\" type=\"float\" value=\"1.5\"/>", -0.8f32.ln(), 1.5);
    check("<input name=\"share\" type=\"float\" value=\"0\"/>", quarter, 1.4);
    let both = "<input name=\"share\" type=\"float\" value=\"0.25\"/>
        <input name=\"concentration\" type=\"float\" value=\"0.5\"/>";
    check(both, 0.25 * half + 0.75 * quarter, 1.4);
}

#[test]
fn definitions_that_use_themselves_have_an_end() {
    let document = own_nodes("");
    let inner = document.replace("<deon_hair_absorption_from_melanin name=\"n\"", "<pigment name=\"n\"");
    let error = fiber_of(&inner.replace("</deon_hair_absorption_from_melanin>", "</pigment>")).unwrap_err();
    assert!(error.contains("more than 64 nodes with a definition are nested"), "{error}");
    // Each definition has two nodes of the next one: 2³⁰ copies.
    let level = |i: usize| {
        format!(
            "<nodedef name=\"D{i}\" node=\"d{i}\"><output name=\"out\" type=\"vector3\"/></nodedef>
            <nodegraph name=\"G{i}\" nodedef=\"D{i}\"><add name=\"n\" type=\"vector3\">
            <input name=\"in1\" type=\"vector3\" nodename=\"a\"/><input name=\"in2\" type=\"vector3\" nodename=\"b\"/>
            </add><d{0} name=\"a\" type=\"vector3\"/><d{0} name=\"b\" type=\"vector3\"/>
            <output name=\"out\" type=\"vector3\" nodename=\"n\"/></nodegraph>",
            i + 1
        )
    };
    let levels = (0..30).map(level).collect::<String>() + "</materialx>";
    let many = document.replace("<pigment name=\"a\"", "<d0 name=\"a\"").replacen("</pigment>", "</d0>", 1);
    let error = fiber_of(&many.replace("</materialx>", &levels)).unwrap_err();
    assert!(error.contains("more than 262144 nodes"), "{error}");
    let error = fiber_of(&document.replace("interfacename=\"ior\"", "interfacename=\"gone\"")).unwrap_err();
    assert!(error.contains("the node graph has no input gone"), "{error}");
    let error =
        fiber_of(&document.replace("nodename=\"a\"/> <input name=\"bg\"", "nodename=\"m\"/> <input name=\"bg\""));
    // A share of 1 follows the first input only.
    assert!(error.unwrap_err().contains("more than 16 nodes are nested"));
}
