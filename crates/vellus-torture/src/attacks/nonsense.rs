//! Commands with random options and values. Each must succeed, or be refused quickly with a message.

use super::Attack;
use crate::child::{Call, Outcome, Sink, When};
use crate::dice::Dice;
use crate::material;
use crate::trial::{Stop, Trial};
use rustix::process::Signal;
use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::time::Duration;

/// Processor time within which invalid input must be refused, seconds. Parsing the arguments takes a hundredth of it.
const REFUSED_WITHIN: f64 = 2.0;
/// A run that lasts this long was accepted. It is then ended.
const ACCEPTED_AFTER: Duration = Duration::from_secs(1);
/// Processor time to grow the largest scene of this attack, seconds: three times the time on an idle core.
const GROWN_WITHIN: u64 = 30;
/// More threads than this are an error: large machines have about this many cores, and each thread takes some MB of
/// address space.
const MOST_THREADS: u64 = 1100;
/// The largest acceptable length of a message, bytes.
const LONGEST_MESSAGE: usize = 4096;

/// Values that are wrong for nearly every option. None is an absolute path, so output stays in the case's folder.
const VALUES: [&str; 68] = [
    "",
    " ",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "-1",
    "0",
    "-0",
    "1",
    "2",
    "0.5",
    "1e308",
    "1e39",
    "-1e39",
    "1e-46",
    "1e400",
    "18446744073709551615",
    "18446744073709551616",
    "4294967295",
    "4294967296",
    "-2147483648",
    "100000",
    "99999999999999999999999999",
    "0x10",
    "1_000",
    "½",
    "Ω",
    "日本語",
    "\u{202e}txt.exe",
    "a\nb",
    "🐈",
    "%s%n%x",
    "--",
    "-",
    ",",
    "1,2",
    "1,2,3",
    "nan,nan,nan",
    "1,2,3,4",
    "0,0,99999999999,1",
    "1x1",
    "0x0",
    "-1x-1",
    "32768x32768",
    "99999x99999",
    "1..0",
    "0..1",
    "0..18446744073709551615",
    "5-1",
    "1-2",
    "-2147483648-2147483647",
    "1-2x0",
    "kappa=nan",
    "kappa=",
    "=",
    "kappa=1",
    "eta=-1",
    "reflectance=2",
    "..",
    "missing.usda",
    "missing.toml",
    "far",
    "-1:1",
    "nan:nan",
    "-5s",
    "lean.usda",
    "all",
];

/// Numbers, for options that take a number.
const NUMBERS: [&str; 20] = [
    "nan",
    "inf",
    "-inf",
    "-1",
    "0",
    "-0",
    "1",
    "3",
    "0.5",
    "-0.5",
    "1e-46",
    "1e20",
    "1e39",
    "-1e39",
    "1e308",
    "100000",
    "2147483648",
    "4294967296",
    "18446744073709551615",
    "18446744073709551616",
];

/// Values that are nearly right, for options with a structured value.
const FORMS: [(&str, &[&str]); 6] = [
    ("A-B", &["-2147483648-2147483647", "1-9999999999", "5-1", "1-2x0", "1-2", "1--1", "2147483647-2147483647", "0-0"]),
    ("A..B", &["1..0", "0..1", "0..18446744073709551615", "18446744073709551614..18446744073709551615", "..", "-1..2"]),
    ("WxH", &["0x0", "1x1", "1x32768", "32768x32768", "99999x99999", "-1x-1", "1x", "8x8x8", "1.5x2"]),
    (
        ",",
        &["0,0,99999999999,1", "0,0,1,1", "18446744073709551615,1,1,1", "-1,0,1,1", "nan,nan,nan", "0,0,0", "1e39,1,1"],
    ),
    (
        "=",
        &["kappa=nan", "kappa=", "=", "kappa=1", "eta=-1", "reflectance=2", "sigma_ca=1,2", "eumelanin=1e39", "g=0.95"],
    ),
    (":", &["-1:1", "1:-1", "nan:nan", "0:0", "-2:2", "far", "near", "1e-30:2e-30", "-90:90"]),
];

/// Names that are valid for some option.
const WORDS: [&str; 14] = [
    "cat",
    "raccoon",
    "red-fox",
    "hair-lock",
    "lean.usda",
    "lean.hair",
    "mesh.obj",
    "part.film",
    "vellus",
    "yan2015",
    "beauty,beauty",
    "multiscale",
    "linear",
    "table",
];

/// Options that can make a run long.
const LONG: [&str; 12] = [
    "--spp",
    "--photons",
    "--starts",
    "--count",
    "--density",
    "--samples",
    "--step",
    "--profiles",
    "--frames",
    "--segments",
    "--size",
    "--quality",
];

/// Options whose numbers set memory, threads or files.
const COSTLY: [&str; 9] =
    ["--frames", "--threads", "--size", "--samples", "--segments", "--count", "--crop", "--pieces", "--step"];

/// Options that are not tried. `--tev` connects to other machines. The others only print text.
const LEFT_OUT: [&str; 3] = ["--tev", "--help", "--version"];

/// A subcommand and its options.
struct Subcommand {
    path: String,
    /// Options, with the names of their values in the help.
    options: Vec<(String, String)>,
}

#[derive(Default)]
pub struct Nonsense {
    subcommands: Vec<Subcommand>,
}

impl Attack for Nonsense {
    fn name(&self) -> &'static str {
        "nonsense"
    }

    fn case(&mut self, trial: &mut Trial) -> Result<(), Stop> {
        if self.subcommands.is_empty() {
            discover(trial, "", &mut self.subcommands)?;
        }
        std::fs::write(trial.at("lean.usda"), material::LEANING)?;
        std::fs::write(trial.at("mesh.obj"), material::MESH)?;
        std::fs::write(trial.at("profile.csv"), material::profile())?;
        // Several commands share a folder, which takes longer to create than most commands run.
        for _ in 0..8 {
            trial.tried += 1;
            let call = command(trial, &self.subcommands);
            try_it(trial, call)?;
        }
        Ok(())
    }
}

/// Finds all subcommands of a command from its help.
fn discover(trial: &mut Trial, path: &str, found: &mut Vec<Subcommand>) -> Result<(), Stop> {
    let help = trial.run(&trial.vellus(path).arg("--help"))?;
    trial.ended_with(&help, &[0], "--help");
    let mut options = Vec::new();
    let mut children = Vec::new();
    let mut in_commands = false;
    for line in help.stdout.lines() {
        if !line.starts_with(' ') {
            in_commands = line == "Commands:";
            continue;
        }
        let mut words = line.split_whitespace();
        let Some(first) = words.next() else { continue };
        // Names are indented by two spaces; explanations by more.
        if in_commands && line.starts_with("  ") && !line.starts_with("   ") && first != "help" {
            children.push(first.to_owned());
        } else if first.starts_with('-') {
            let mut words = std::iter::once(first).chain(words).skip_while(|word| !word.starts_with("--"));
            let long = words.next().map(|word| word.trim_end_matches(',').to_owned());
            let value = words.next().filter(|word| word.starts_with('<')).unwrap_or("").to_owned();
            options.extend(long.map(|long| (long, value)));
        }
    }
    options.sort();
    options.dedup();
    options.retain(|(option, _)| option.len() > 2 && !LEFT_OUT.contains(&option.as_str()));
    if !path.is_empty() {
        found.push(Subcommand { path: path.to_owned(), options });
    }
    for child in children {
        discover(trial, format!("{path} {child}").trim(), found)?;
    }
    Ok(())
}

/// Arguments that make a subcommand quick.
fn cheap(path: &str, dice: &mut Dice) -> &'static str {
    let lines: &[&str] = match path {
        "render" => &[
            "hair-lock --small --size 8x8 --spp 1 --output o.exr",
            "lean.usda --size 8x8 --spp 1 --output o.exr",
            "cat --small --size 8x8 --spp 1 --output o.png",
        ],
        "merge" => &["part.film --output o.exr"],
        "scene" => &["hair-lock --small --output o.usda"],
        "groom info" => &["lean.usda", "hair-lock --small"],
        "groom convert" => {
            &["lean.usda --output o.usda", "lean.usda --output o.usdc", "hair-lock --small --output o.hair"]
        }
        "groom grow" => &["mesh.obj --count 20 --output o.usda"],
        "fit" => &["profile.csv --starts 1 --theta-o 0", "--simulate cat --step 30 --out o.csv"],
        "reference" => &["--photons 1000"],
        "table check" => &["--profiles 1 --photons 1000"],
        "table build" => &["--quality smoke --photons 10 --out o.vellus"],
        "fiber show" => &["cat"],
        // The default sheet takes 30 to 60 s. The size also marks it as a run that may be long.
        "fiber sheet" => &["--size 4 --samples 1 --output o.png"],
        "experiment" => &["list"],
        "plot medulla" => &["--photons 100 --out o.svg"],
        _ if path.starts_with("plot") => &["--out o.svg"],
        _ => &[""],
    };
    dice.pick::<&str>(lines)
}

fn command(trial: &mut Trial, subcommands: &[Subcommand]) -> Call {
    // `render` has the most options.
    let render = subcommands.iter().find(|subcommand| subcommand.path == "render");
    let subcommand = render.filter(|_| trial.dice.chance(0.25)).unwrap_or_else(|| trial.dice.pick(subcommands));
    let mut line = cheap(&subcommand.path, &mut trial.dice);
    if subcommand.path == "render" && trial.dice.chance(0.05) {
        // The scene is large, so the error must come before it is grown.
        line = "raccoon --size 8x8 --spp 1 --output o.png";
    }
    let mut args: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
    for _ in 0..*trial.dice.pick(&[1, 1, 1, 2, 4]) {
        if subcommand.options.is_empty() || trial.dice.chance(0.1) {
            let at = trial.dice.number(0..args.len() + 1);
            args.insert(at, value(&mut trial.dice));
            continue;
        }
        let costly: Vec<_> =
            subcommand.options.iter().filter(|(option, _)| COSTLY.contains(&option.as_str())).collect();
        let (option, form) = if costly.is_empty() || trial.dice.chance(0.6) {
            trial.dice.pick(&subcommand.options).clone()
        } else {
            (*trial.dice.pick(&costly)).clone()
        };
        if let Some(at) = args.iter().position(|arg| *arg == *option) {
            // A repeated option would be refused for that reason alone.
            args.drain(at..(at + 2).min(args.len()));
        }
        if form.is_empty() && trial.dice.chance(0.9) {
            args.push(option.into());
            continue;
        }
        let given = formed(&form, &mut trial.dice);
        if trial.dice.chance(0.7) {
            // With `=`, a value may also start with a dash.
            let mut joined = OsString::from(option + "=");
            joined.push(given);
            args.push(joined);
        } else {
            args.push(option.into());
            if trial.dice.chance(0.9) {
                args.push(given);
            }
        }
    }
    let mut call = trial.vellus(&subcommand.path);
    if line.starts_with("raccoon") {
        call.cpu_seconds = GROWN_WITHIN;
    }
    call.args.extend(args);
    match trial.dice.number(0..30) {
        0 => call.stdout = Sink::ClosedPipe,
        1 => call.stderr = Sink::ClosedPipe,
        2 => call.stdout = Sink::Closed,
        3 => call.stderr = Sink::Closed,
        _ => {}
    }
    call
}

/// A value that roughly fits the name of the value in the help.
fn formed(form: &str, dice: &mut Dice) -> OsString {
    let forms = FORMS.iter().find(|(part, _)| form.contains(part));
    match (forms, dice.number(0..10)) {
        (Some((_, values)), 0..=5) => dice.pick::<&str>(values).into(),
        (None, 0..=5) => (*dice.pick(&NUMBERS)).into(),
        _ => value(dice),
    }
}

fn value(dice: &mut Dice) -> OsString {
    match dice.number(0..20) {
        0 => OsString::from_vec(vec![b'f', 0xff, 0xfe, b'.', b'e', b'x', b'r']),
        1 => "x".repeat(100_000).into(),
        2..=6 => (*dice.pick(&WORDS)).into(),
        _ => (*dice.pick(&VALUES)).into(),
    }
}

/// Whether a call may run long and still be correct, as `experiment` and `table` do with nearly any argument.
fn may_be_long(call: &Call) -> bool {
    let first = call.args.first().and_then(|arg| arg.to_str()).unwrap_or("");
    let long = |arg: &OsString| LONG.iter().any(|option| arg.to_string_lossy().starts_with(option));
    // The viewer runs until it is ended.
    ["experiment", "table", "live"].contains(&first) || call.args.iter().any(long)
}

fn try_it(trial: &mut Trial, mut call: Call) -> Result<(), Stop> {
    let subcommand = call.args.first().map_or(String::new(), |arg| arg.to_string_lossy().into_owned());
    if may_be_long(&call) {
        call.signal = Some((When::After(ACCEPTED_AFTER), Signal::TERM));
    }
    let outcome = trial.run(&call)?;
    if outcome.signalled && (outcome.signal == Some(Signal::TERM.as_raw()) || outcome.code == Some(143)) {
        return Ok(());
    }
    if outcome.signalled && outcome.code == Some(0) {
        // The kill attack judges exit codes after signals.
        return Ok(());
    }
    let what = format!("{subcommand} with nonsense");
    if outcome.threads > MOST_THREADS {
        trial.finding(format!("{what}: too many threads"), format!("{} or more", outcome.threads));
    }
    // Exit code 75: no space for a picture on the disk, or no threads from the system.
    if trial.ended_with(&outcome, &[0, 2, 75], &what) && outcome.code == Some(2) && call.stderr == Sink::Read {
        message(trial, &outcome, &what);
    }
    Ok(())
}

/// Checks the message of a refusal.
fn message(trial: &mut Trial, outcome: &Outcome, what: &str) {
    let text = &outcome.stderr;
    // A command without a required subcommand lists the subcommands.
    if !text.contains("error: ") && !text.contains("Usage: ") {
        trial.finding(format!("{what}: refused without an error message"), text.clone());
    }
    // Usage errors repeat the argument, so one such line may be as long as the arguments.
    let errors: Vec<&str> = text.lines().filter(|line| line.starts_with("error: ")).collect();
    if errors.len() > 1 {
        trial.finding(format!("{what}: more than one error message"), text.clone());
    }
    if text.lines().map(|line| line.len().min(200)).sum::<usize>() > LONGEST_MESSAGE {
        trial.finding(format!("{what}: a message that is too long"), format!("{} bytes", text.len()));
    }
    let cpu = outcome.cpu.as_secs_f64();
    if cpu > REFUSED_WITHIN {
        trial.finding(format!("{what}: refused late"), format!("after {cpu:.1} s of processor time: {text:.300}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_of_coats_may_be_long() {
        let line = cheap("fiber sheet", &mut Dice::new(0, "nonsense", 0));
        assert!(LONG.iter().any(|option| line.split(' ').any(|word| word == *option)), "{line}");
    }
}
