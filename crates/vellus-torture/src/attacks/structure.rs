//! Files and folders whose structure is hostile: circles of every arc and connection, deep and wide hierarchies,
//! samples in any order, and plans with links and pipes.

use super::Attack;
use super::places::make_fifo;
use crate::dice::Dice;
use crate::trial::{Stop, Trial};
use std::fmt::Write;
use std::os::unix::fs::symlink;

const CURVES: &str = "def BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
    point3f[] points = [(0,0,0), (1,0,0)] float[] widths = [.1] ( interpolation = \"constant\" ) }";

/// Text that a lexer may take for something else.
const DISGUISES: [&str; 8] = ["", "# \"\r", "/* \" */", "/* ' # */", "// \"\n", "#'''\n", "/**/", "# /*\n"];

#[derive(Default)]
pub struct Structure;

impl Attack for Structure {
    fn name(&self) -> &'static str {
        "structure"
    }

    fn case(&mut self, trial: &mut Trial) -> Result<(), Stop> {
        trial.tried += 1;
        match trial.dice.number(0..10) {
            0..=3 => arcs(trial),
            4 => network(trial),
            5 => document(trial),
            6 => deep(trial),
            7 => samples(trial),
            _ => plan(trial),
        }
    }
}

/// A command that reads a scene. It must end in time with success or an error.
fn reads(trial: &mut Trial, file: &str, what: &str) -> Result<(), Stop> {
    let lines = ["groom info FILE", "render FILE --size 4x4 --spp 1 -o out.exr", "groom convert FILE -o out.usda"];
    let line = trial.dice.pick(&lines).replace("FILE", file);
    let outcome = trial.run(&trial.vellus(&line))?;
    trial.ended_with(&outcome, &[0, 2], what);
    Ok(())
}

/// Prims in three layers that refer to each other at random, by all arcs.
fn arcs(trial: &mut Trial) -> Result<(), Stop> {
    let dice = &mut trial.dice;
    let layers = dice.number(1..4);
    let count = *dice.pick(&[1, 2, 3, 5, 12, 40]);
    // With few arcs most circles are long, or there is none.
    let density = *dice.pick(&[0.2, 0.5, 1.0]);
    let arc = |dice: &mut Dice| if dice.chance(density) { arc(dice, layers, count) } else { String::new() };
    let mut texts = Vec::new();
    for _ in 0..layers {
        let sub =
            if dice.chance(0.3) { format!("subLayers = [@l{}.usda@]", dice.number(0..layers)) } else { String::new() };
        let mut text = format!("#usda 1.0\n( defaultPrim = \"p0\" {sub} )\n");
        for i in 0..count {
            let open = dice.pick(&DISGUISES);
            let kind = dice.pick(&["def", "def", "class", "over"]);
            let child =
                if dice.chance(0.5) { format!("def \"k\" ( {} ) {{ {CURVES} }}", arc(dice)) } else { String::new() };
            let inside = match dice.number(0..3) {
                0 => format!("variantSet \"v\" = {{ \"x\" ( {} ) {{ {CURVES} }} }}", arc(dice)),
                1 => CURVES.to_owned(),
                _ => format!("rel material:binding = </p{}/k>", dice.number(0..count)),
            };
            let own = arc(dice);
            let selection = "variants = { string v = \"x\" } prepend variantSets = \"v\"";
            let _ = writeln!(text, "{open} {kind} \"p{i}\" ( {own} {selection} ) {{ {child} {inside} }}");
        }
        texts.push(text);
    }
    for (layer, text) in texts.iter().enumerate() {
        std::fs::write(trial.at(&format!("l{layer}.usda")), text)?;
    }
    reads(trial, "l0.usda", "prims with random arcs")
}

/// An arc to a prim of any layer.
fn arc(dice: &mut Dice, layers: usize, count: usize) -> String {
    let prim = format!("/p{}{}", dice.number(0..count), dice.pick(&["", "", "/k", "/k/c"]));
    let layer = format!("@l{}.usda@", dice.number(0..layers));
    match dice.number(0..8) {
        0..=2 => format!("prepend inherits = <{prim}>"),
        3 => format!("specializes = [<{prim}>]"),
        4 => format!("prepend references = <{prim}>"),
        5 => format!("references = {layer}<{prim}>"),
        6 => format!("payload = {layer}<{prim}>"),
        _ => "instanceable = true".to_owned(),
    }
}

/// Shaders whose inputs and outputs are connected at random.
fn network(trial: &mut Trial) -> Result<(), Stop> {
    let dice = &mut trial.dice;
    let count = *dice.pick(&[2, 3, 8, 200]);
    let kinds =
        ["VellusFur", "ND_constant_color3", "ND_multiply_color3", "ND_chiang_hair_bsdf", "UsdUVTexture", "kma_hair"];
    let mut text = "#usda 1.0\ndef Material \"m\" { token outputs:surface.connect = </m/s0.outputs:out>\n".to_owned();
    for i in 0..count {
        let _ =
            write!(text, "def Shader \"s{i}\" {{ uniform token info:id = \"{}\" token outputs:out ", dice.pick(&kinds));
        for input in ["value", "in1", "in2", "kappa", "color", "file", "st"] {
            // A chain, or a jump that may close a circle.
            let to = if dice.chance(0.7) { (i + 1) % (count + 1) } else { dice.number(0..count) };
            let end = if dice.chance(0.8) { "outputs:out" } else { "inputs:value" };
            let _ = write!(text, "color3f inputs:{input}.connect = </m/s{to}.{end}> ");
        }
        text.push_str("}\n");
    }
    let _ = write!(text, "}}\ndef Xform \"x\" {{ rel material:binding = </m> {CURVES} }}");
    std::fs::write(trial.at("network.usda"), text)?;
    reads(trial, "network.usda", "shaders connected at random")
}

/// A MaterialX document with random graphs, or a deep one.
fn document(trial: &mut Trial) -> Result<(), Stop> {
    let dice = &mut trial.dice;
    let count = *dice.pick(&[1, 2, 5, 300]);
    let mut text = "<materialx version=\"1.39\">".to_owned();
    if dice.chance(0.2) {
        text = "<nodegraph name=\"g\">".repeat(*dice.pick(&[10, 1000, 100_000]));
    }
    for i in 0..count {
        let (node, to) = (dice.pick(&["constant", "multiply", "mix", "add", "image"]), dice.number(0..count));
        let _ = write!(
            text,
            "<{node} name=\"n{i}\" type=\"color3\"><input name=\"value\" type=\"color3\" nodename=\"n{to}\"/>\
             <input name=\"in1\" type=\"color3\" nodegraph=\"g{to}\" output=\"out\"/></{node}>\
             <nodegraph name=\"g{i}\">\
             <output name=\"out\" type=\"color3\" nodename=\"n{to}\" nodegraph=\"g{to}\"/></nodegraph>"
        );
    }
    let _ = write!(
        text,
        "<chiang_hair_bsdf name=\"h\" type=\"BSDF\"><input name=\"tint_TT\" type=\"color3\" nodename=\"n0\"/>\
         <input name=\"absorption_coefficient\" type=\"vector3\" nodename=\"n0\"/></chiang_hair_bsdf>\
         <surface name=\"s\" type=\"surfaceshader\"><input name=\"bsdf\" type=\"BSDF\" nodename=\"h\"/></surface>\
         <surfacematerial name=\"M\" type=\"material\">\
         <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"s\"/></surfacematerial></materialx>"
    );
    std::fs::write(trial.at("document.mtlx"), text)?;
    let outcome = trial.run(&trial.vellus("fiber show document.mtlx"))?;
    trial.ended_with(&outcome, &[0, 2], "nodes of MaterialX connected at random");
    Ok(())
}

/// A long chain or a deep or wide hierarchy.
fn deep(trial: &mut Trial) -> Result<(), Stop> {
    let n = *trial.dice.pick(&[40, 90, 400, 5000]);
    let chain = |arc: &str| {
        let links = (1..n).map(|i| format!("class \"a{i}\" ( {arc} = </a{}> ) {{}}\n", i - 1));
        format!("class \"a0\" {{ {CURVES} }} {} def \"s\" ( {arc} = </a{}> ) {{}}", links.collect::<String>(), n - 1)
    };
    let disguise = *trial.dice.pick(&DISGUISES);
    let body = match trial.dice.number(0..7) {
        0 => chain("inherits"),
        1 => chain("specializes"),
        2 => chain("references"),
        3 => format!("{disguise} {}", "def \"a\" {".repeat(n)),
        4 => format!("{disguise} ( customData = {{ {}", "dictionary d = {".repeat(n)),
        5 => format!("{CURVES} def \"s\" {{ string s = \"{}\" }}", "\\\"'".repeat(20 * n)),
        _ => format!("{CURVES} ( expressionVariables = {{ string A = '`{}`' }} )", "if(".repeat(n)),
    };
    std::fs::write(trial.at("deep.usda"), format!("#usda 1.0\n{body}"))?;
    reads(trial, "deep.usda", "a deep structure")
}

/// The order of samples must not matter.
fn samples(trial: &mut Trial) -> Result<(), Stop> {
    let mut order: Vec<usize> = (0..trial.dice.number(2..8)).collect();
    let text = |order: &[usize]| {
        let list: String = order.iter().map(|i| format!("{i}: [(0,0,0), ({i},{},0)], ", i * i + 1)).collect();
        format!(
            "#usda 1.0\n{}",
            CURVES.replace("points = [(0,0,0), (1,0,0)]", &format!("points.timeSamples = {{{list}}}"))
        )
    };
    std::fs::write(trial.at("sorted.usda"), text(&order))?;
    trial.dice.shuffle(&mut order);
    std::fs::write(trial.at("shuffled.usda"), text(&order))?;
    let frame = trial.dice.within(-1.0, 8.0);
    for name in ["sorted", "shuffled"] {
        let line = format!("groom convert {name}.usda --frame {frame:.2} -o {name}.out.usda");
        trial.prepare(&trial.vellus(&line))?;
    }
    let [sorted, shuffled] = ["sorted", "shuffled"].map(|name| std::fs::read(trial.at(&format!("{name}.out.usda"))));
    if sorted? != shuffled? {
        trial.finding("the order of samples changes the scene", format!("{order:?} at {frame:.2}"));
    }
    Ok(())
}

/// A plan whose folder has a link or a pipe: nothing outside of it may change.
fn plan(trial: &mut Trial) -> Result<(), Stop> {
    std::fs::write(trial.at("scene.usda"), format!("#usda 1.0\n{CURVES}"))?;
    let _ = std::fs::remove_dir_all(trial.at("plan"));
    trial.prepare(&trial.vellus("farm plan scene.usda --frames 1001-1002 --samples 1 -o plan -- --size 4x4"))?;
    let folder = trial.dice.pick(&["films", "receipts", "pictures", "logs"]).to_owned();
    let name = *trial.dice.pick(&["1001.0-1.film", "1001.json", "1001.0-1.json", "1001.exr", "1001.0-1.log", ""]);
    let victim = trial.at("victim");
    std::fs::create_dir_all(victim.join("inner"))?;
    std::fs::write(victim.join("file"), "precious")?;
    let at = trial.at("plan").join(folder);
    let target = if name.is_empty() { at.clone() } else { at.join(name) };
    let _ = std::fs::remove_dir_all(&target);
    if let Some(parent) = target.parent() {
        std::fs::create_dir_all(parent)?;
    }
    match trial.dice.number(0..3) {
        0 if !name.is_empty() => make_fifo(&target)?,
        1 if !name.is_empty() => symlink(victim.join("file"), &target)?,
        _ => symlink(victim.join("inner"), &target)?,
    }
    let line =
        *trial.dice.pick(&["farm run plan", "farm status plan", "farm task plan 1", "farm task plan 1001.merge"]);
    let outcome = trial.run(&trial.vellus(line))?;
    trial.ended_with(&outcome, &[0, 1, 2, 75], "a plan with a link or a pipe");
    let changed =
        std::fs::read(victim.join("file"))? != b"precious" || victim.join("inner").read_dir()?.next().is_some();
    if changed {
        trial.finding("a plan wrote through a link", format!("{line}: {}", target.display()));
    }
    std::fs::remove_dir_all(&victim)?;
    Ok(())
}
