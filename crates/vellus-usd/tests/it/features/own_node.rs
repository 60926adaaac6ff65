//! The node of Vellus in MaterialX, `integrations/materialx/vellus.mtlx`.

use super::FOUR;
use crate::common::read;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use vellus::{Color, Fiber, Parameter, ParameterUnit, ScatterExit};
use vellus_testing::program::Limited;
use vellus_testing::{need, succeeds};
use vellus_usd::Options;

const FILE: &str = "integrations/materialx/vellus.mtlx";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// An input of the node: name, type, default, range and explanation of a parameter.
fn line(parameter: Parameter) -> String {
    let kind = match (parameter.channels(), parameter) {
        (1, _) => "float",
        (2, _) => "vector2",
        (_, Parameter::SigmaCa | Parameter::SigmaMa) => "vector3",
        _ => "color3",
    };
    let folder = match parameter {
        Parameter::Kappa | Parameter::SigmaMs | Parameter::SigmaMa | Parameter::G | Parameter::Exit => "Medulla",
        Parameter::SigmaCa | Parameter::MedullaPigment => "Colour",
        Parameter::Reflectance | Parameter::Melanin | Parameter::HairReflectance => "Colour",
        _ => "Fibre",
    };
    let list = |x: f64| vec![x.to_string(); parameter.channels()].join(", ");
    let (range, default) = (parameter.range(), parameter.default_value());
    // A colour of 0 is not given.
    let (low, note) = if default.is_some() { (range.low, "") } else { (0.0, "; 0 is not given") };
    let degrees = if parameter.unit() == ParameterUnit::Degrees { ", degrees" } else { "" };
    let default = default.map_or(0.0, |value| {
        let x = parameter.unit().from_stored(value[0]);
        // Of an angle in radians, a number of single precision.
        format!("{x:.4}").parse().unwrap()
    });
    if let Some(word) = parameter.word(default as f32) {
        let (name, choices, doc) = (parameter.name(), parameter.choices().join(","), parameter.description());
        let values = format!(r#"value="{word}" enum="{choices}" uniform="true""#);
        return format!(r#"    <input name="{name}" type="string" {values} uifolder="{folder}" doc="{doc}" />"#);
    }
    let name = parameter.name();
    let values = format!(r#"value="{}" uimin="{}" uimax="{}""#, list(default), list(low), list(range.high));
    let unit = parameter.unit().suffix().replace(" degrees", "");
    let doc = format!("{}{unit}{degrees}{note}", parameter.description());
    format!(r#"    <input name="{name}" type="{kind}" {values} uifolder="{folder}" doc="{doc}" />"#)
}

#[test]
fn generated_node_has_the_parameters() {
    let mut lines = String::new();
    for parameter in Parameter::ALL {
        writeln!(lines, "{}", line(parameter)).unwrap();
    }
    vellus_testing::generated::part(FILE, "inputs", &lines);
}

/// The document is valid for MaterialX, and its shaders generate.
#[test]
fn materialx_accepts_the_node() {
    let found = succeeds(Command::new("python3").args(["-c", "import MaterialX"]));
    if need("materialx", found).is_none() {
        return;
    }
    let output = Command::new("python3").arg(root().join("integrations/materialx/check.py")).run().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// The fibre of a material with the node, and how many warnings there are. The document has the definition, too.
fn fiber(inputs: &str) -> (Fiber, usize) {
    let document = fs::read_to_string(root().join(FILE)).unwrap();
    let material = format!(
        r#"<vellus_fiber_bsdf name="fiber" type="BSDF">{inputs}</vellus_fiber_bsdf>
        <surface name="surface" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="fiber" /></surface>
        <surfacematerial name="Fur" type="material">
          <input name="surfaceshader" type="surfaceshader" nodename="surface" />
        </surfacematerial>
        </materialx>"#
    );
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("fur.mtlx"), document.replace("</materialx>", &material)).unwrap();
    let stage = format!(
        "#usda 1.0
def BasisCurves \"c\" {{ {FOUR}\n rel material:binding = </fur> }}
def \"fur\" ( references = @fur.mtlx@</MaterialX/Materials/Fur> ) {{ }}"
    );
    let file = folder.path().join("stage.usda");
    fs::write(&file, stage).unwrap();
    let (scene, warnings) = read(&file, &Options::default()).unwrap();
    (scene.looks[0].fiber, warnings.len())
}

#[test]
fn vellus_reads_the_node_by_its_inputs() {
    // All inputs as the definition has them: the fibre is that of the defaults, although all colours have a value.
    let all: String = Parameter::ALL.into_iter().map(line).collect();
    let (found, warnings) = fiber(&all);
    assert_eq!((Fiber { alpha: 0.0, beta_m: 0.0, beta_n: 0.0, ..found }, warnings), {
        (Fiber { alpha: 0.0, beta_m: 0.0, beta_n: 0.0, ..Fiber::hair() }, 0)
    });
    assert_eq!(fiber("").0, Fiber::hair());
    let (found, warnings) = fiber(
        r#"<input name="kappa" type="float" value="0.8" /><input name="alpha" type="float" value="3" />
        <input name="sigma_ca" type="vector3" value="0.1, 0.2, 0.3" /><input name="g" type="float" value="0.4" />
        <input name="exit" type="string" value="open" />"#,
    );
    let alpha = 3f32.to_radians();
    assert_eq!(
        found,
        Fiber { kappa: 0.8, alpha, sigma_ca: [0.1, 0.2, 0.3], g: 0.4, exit: ScatterExit::Open, ..Fiber::hair() }
    );
    assert_eq!(warnings, 0);
    let melanin = |value: &str| fiber(&format!(r#"<input name="melanin" type="vector2" value="{value}" />"#)).0;
    assert_eq!(
        melanin("0.5, 0.25").sigma_ca,
        Fiber::hair().with_color(Color::Melanin { eumelanin: 0.5, pheomelanin: 0.25 }).unwrap().sigma_ca
    );
    let reflectance = r#"<input name="sigma_ca" type="vector3" value="9, 9, 9" />
        <input name="reflectance" type="color3" value="0.4, 0.2, 0.1" />"#;
    assert_eq!(fiber(reflectance).0.reflectance, Some([0.4, 0.2, 0.1]));
}
