//! Changed input files of every kind, and special files under their names.

use super::Attack;
use super::places::make_fifo;
use crate::child::Outcome;
use crate::dice::Dice;
use crate::material;
use crate::mutate;
use crate::picture::Picture;
use crate::trial::{Stop, Trial};
use png::{BitDepth, ColorType};
use std::path::Path;
use std::process::{Command, Stdio};
use vellus_testing::program::{Limited, Running};

/// Files of other programs: the repository's own test data.
const SAMPLES: [(&str, &[u8]); 10] = [
    ("abc", include_bytes!("../../../vellus-usd/tests/data/blender/fur_catmull_rom.abc")),
    ("usda", include_bytes!("../../../vellus-usd/tests/data/blender_5_2.usda")),
    ("usda", include_bytes!("../../../vellus-usd/tests/data/chiang.usda")),
    ("usda", include_bytes!("../../../vellus-usd/tests/data/principled_hair.usda")),
    ("usda", include_bytes!("../../../vellus-usd/tests/data/blender/fur_catmull_rom.usda")),
    ("usdc", include_bytes!("../../../vellus-usd/tests/data/blender/fur_bezier.usdc")),
    ("usdc", include_bytes!("../../../vellus-usd/tests/data/blender/fur_catmull_rom.usdc")),
    ("usdc", include_bytes!("../../../vellus-usd/tests/data/blender/fur_nurbs.usdc")),
    ("usdc", include_bytes!("../../../vellus-usd/tests/data/blender/fur_poly.usdc")),
    ("usda", include_bytes!("../../../vellus-usd/tests/data/blender/particles.usda")),
];

/// A file to change.
struct Seed {
    bytes: Vec<u8>,
    extension: String,
    /// Whether it is changed as text.
    text: bool,
}

#[derive(Default)]
pub struct Files {
    seeds: Vec<Seed>,
}

impl Attack for Files {
    fn name(&self) -> &'static str {
        "files"
    }

    fn case(&mut self, trial: &mut Trial) -> Result<(), Stop> {
        if self.seeds.is_empty() {
            self.seeds = seeds(trial)?;
        }
        trial.tried += 1;
        std::fs::write(trial.at("mesh.obj"), material::MESH)?;
        let seed = &self.seeds[trial.dice.number(0..self.seeds.len())];
        match trial.dice.number(0..60) {
            0..=4 => special(trial, &seed.extension),
            5 => fan_out(trial),
            6 | 7 => nested(trial),
            _ => {
                let name = format!("input.{}", seed.extension);
                std::fs::write(trial.at(&name), changed(seed, &self.seeds, &mut trial.dice))?;
                use_it(trial, &name, &format!("a changed .{}", seed.extension))
            }
        }
    }
}

/// Files from this program, from the command and from other programs.
fn seeds(trial: &mut Trial) -> Result<Vec<Seed>, Stop> {
    let mut seeds = Vec::new();
    let mut add = |extension: &str, bytes: Vec<u8>| {
        let text = ["usda", "obj", "csv", "txt", "json", "toml", "mtlx"].contains(&extension);
        seeds.push(Seed { bytes, extension: extension.to_owned(), text });
    };
    std::fs::write(trial.at("lean.usda"), material::LEANING)?;
    std::fs::write(trial.at("straight.usda"), material::STRAIGHT)?;
    std::fs::write(trial.at("mesh.obj"), material::MESH)?;
    for line in [
        "groom convert straight.usda -o lean.hair",
        "groom grow mesh.obj --count 6 -o grown.usda",
        "render lean.usda --size 8x6 --spp 1 -o small.exr",
        "fit --simulate cat --step 15 --out cat.txt",
    ] {
        trial.prepare(&trial.vellus(line))?;
    }
    for name in ["lean.usda", "grown.usda", "lean.hair", "small.exr", "small.png", "cat.txt"] {
        if let Ok(bytes) = std::fs::read(trial.at(name)) {
            add(name.rsplit('.').next().unwrap_or(""), bytes);
        }
    }
    for name in ["lean.usda", "grown.usda"] {
        if trial.at(name).exists() {
            let binary = material::usdc(&trial.at(name), &trial.folder)?;
            add("usdz", material::usdz("layer.usdc", &binary)?);
            add("usdc", binary);
        }
    }
    add("usdz", material::usdz("layer.usda", material::LEANING.as_bytes())?);
    add("tfx", vellus_testing::small_tfx(3.0));
    add("tfx", vellus_testing::small_tfx(4.0));
    add("obj", material::MESH.into());
    add("hdr", material::hdr());
    add("npy", material::npy());
    add("csv", material::profile().into());
    add("csv", material::QUERIES.into());
    add("toml", material::FIBER_TOML.into());
    add("toml", material::SETTINGS.into());
    add("json", material::FIBER_JSON.into());
    add("mtlx", material::MATERIALX.into());
    add("usda", material::NETWORKS.into());
    add("usda", material::HERD.into());
    add("vellus", material::tables().into());
    for (color, depth) in [(ColorType::GrayscaleAlpha, BitDepth::Sixteen), (ColorType::Rgb, BitDepth::Eight)] {
        add("png", material::png(color, depth, 77)?);
    }
    for (extension, bytes) in SAMPLES {
        add(extension, bytes.to_vec());
    }
    Ok(seeds)
}

fn changed(seed: &Seed, seeds: &[Seed], dice: &mut Dice) -> Vec<u8> {
    if seed.text && dice.chance(0.85) {
        return mutate::text(&String::from_utf8_lossy(&seed.bytes), dice);
    }
    let mut bytes = seed.bytes.clone();
    if dice.chance(0.05) {
        // Append the end of a file of another kind.
        let other = &dice.pick(seeds).bytes;
        bytes.truncate(dice.number(0..bytes.len()));
        bytes.extend(&other[dice.number(0..other.len())..]);
    } else {
        mutate::binary(&mut bytes, dice);
    }
    bytes
}

/// Commands that read a file of this kind.
fn commands(extension: &str) -> &'static [&'static str] {
    const SCENE: &[&str] = &[
        "groom info FILE",
        "groom info FILE --width 0.1",
        "render FILE --size 8x6 --spp 1 --width 0.1 --float -o out.exr",
        "render FILE --size 8x6 --spp 1 --frame 2.5 --layers all --float -o out.exr",
        "groom convert FILE --width 0.1 -o out.usda",
        "groom grow FILE --count 6 -o out.usda",
    ];
    const IMAGE: &[&str] = &[
        "groom grow mesh.obj --count 6 --color FILE -o out.usda",
        "groom grow mesh.obj --count 6 --density-map FILE --length-map FILE -o out.usda",
        "render sky.usda --size 8x6 --spp 1 --float -o out.exr",
    ];
    match extension {
        "usda" | "usdc" | "usdz" | "abc" => SCENE,
        "hair" | "tfx" | "data" | "ply" | "npz" => &SCENE[..3],
        "obj" => &["groom grow FILE --count 6 -o out.usda"],
        "png" | "hdr" => IMAGE,
        "exr" => IMAGE,
        "npy" => &["fit FILE --starts 1 --theta-o 0 --theta -30:30 --phi -180:180 --out out.toml"],
        "csv" => &["fit FILE --starts 1 --theta-o 10", "eval --queries FILE --format csv"],
        "txt" => &["fit FILE --starts 1"],
        "json" => {
            &["fiber show FILE", "eval --fiber FILE", "render lean.usda --size 4x4 --spp 1 --fiber FILE -o out.exr"]
        }
        "mtlx" => &["fiber show FILE#Plain", "fiber show FILE", "render bound.usda --size 4x4 --spp 1 -o out.exr"],
        "toml" => {
            &["fiber show FILE", "groom grow mesh.obj --settings FILE --count 6 -o out.usda", "eval --fiber FILE"]
        }
        _ => &["table info FILE"],
    }
}

/// Passes the file to a command that reads such files.
fn use_it(trial: &mut Trial, name: &str, what: &str) -> Result<(), Stop> {
    let extension = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or("").to_owned();
    // Pictures are valid profiles as well.
    let kind = if extension == "exr" && trial.dice.chance(0.25) { "npy" } else { &extension };
    let line = trial.dice.pick(commands(kind)).replace("FILE", name);
    std::fs::write(trial.at("lean.usda"), material::LEANING)?;
    std::fs::write(trial.at("sky.usda"), material::lit_by(name))?;
    std::fs::write(trial.at("bound.usda"), material::bound_to(name))?;
    let outcome = trial.run(&trial.vellus(&line))?;
    judge(trial, &outcome, what);
    Ok(())
}

fn judge(trial: &mut Trial, outcome: &Outcome, what: &str) {
    // Memory is limited here. With more memory a huge file may be read.
    let codes: &[i32] = if outcome.stderr.contains("memory") { &[0, 2, 75] } else { &[0, 2] };
    if !trial.ended_with(outcome, codes, what) {
        return;
    }
    if outcome.code == Some(2) && !outcome.stderr.contains("error") {
        trial.finding(format!("{what}: refused without an error message"), outcome.stderr.clone());
    }
    // Echoed control characters can change what a terminal shows.
    if outcome.stderr.chars().any(|c| c.is_control() && c != '\n' && c != '\t') {
        trial.finding("control characters of a file are echoed", format!("{:.600}", format!("{:?}", outcome.stderr)));
    }
    if outcome.stderr.len() > 16 << 10 {
        let detail = format!("{} bytes of messages", outcome.stderr.len());
        trial.finding(format!("{what}: messages that are too long"), detail);
    }
    let out = trial.at("out.exr");
    if outcome.code == Some(0) && out.exists() {
        match Picture::read(&out) {
            Err(e) => trial.finding(format!("{what}: exit code 0, and a picture that cannot be read"), e),
            Ok(picture) if !picture.is_finite() => {
                trial.finding(format!("{what}: a picture with values that are not finite"), outcome.stderr.clone());
            }
            Ok(_) => {}
        }
    }
}

/// Puts a device, a folder, a pipe, a link to itself or a huge file at the name of a file.
fn special(trial: &mut Trial, extension: &str) -> Result<(), Stop> {
    let name = format!("special.{extension}");
    let path = trial.at(&name);
    let mut writer = None;
    let what = match trial.dice.number(0..9) {
        0 => device(&path, "/dev/zero")?,
        1 => device(&path, "/dev/urandom")?,
        2 => device(&path, "/dev/null")?,
        3 => {
            std::fs::create_dir(&path)?;
            "a folder"
        }
        4 => {
            std::os::unix::fs::symlink(&name, &path)?;
            "a link to itself"
        }
        5 => {
            // A sparse file takes no space on the disk.
            std::fs::File::create(&path)?.set_len(6 << 30)?;
            "a file of 6 GiB of zeros"
        }
        6 => {
            make_fifo(&path)?;
            writer = Some(feeder(&path, "true")?);
            "a pipe whose writer closes at once"
        }
        7 => {
            make_fifo(&path)?;
            writer = Some(feeder(&path, "head -c 100000 /dev/urandom")?);
            "a pipe with random bytes"
        }
        _ => device(&path, "/proc/self/mem")?,
    };
    let result = use_it(trial, &name, &format!("{what} as .{extension}"));
    // The writer waits for a reader if the command did not open the pipe.
    if let Some(writer) = writer {
        writer.kill();
    }
    if path.is_file() && !path.is_symlink() {
        std::fs::remove_file(&path)?;
    }
    result
}

fn device(path: &Path, target: &'static str) -> Result<&'static str, Stop> {
    std::os::unix::fs::symlink(target, path)?;
    Ok(target)
}

fn feeder(pipe: &Path, source: &str) -> Result<Running, Stop> {
    // `exec` alone opens the pipe in the shell, so only one process has to be ended.
    let script = format!("exec > \"$0\"; exec {source}");
    Ok(Command::new("/bin/sh").arg("-c").arg(script).arg(pipe).stdout(Stdio::null()).stderr(Stdio::null()).start()?)
}

/// A few lines that expand to many prims.
fn fan_out(trial: &mut Trial) -> Result<(), Stop> {
    let levels = *trial.dice.pick(&[3, 7, 12]);
    std::fs::write(trial.at("fan.usda"), material::fan_out(levels))?;
    let outcome = trial.run(&trial.vellus("groom info fan.usda"))?;
    trial.ended_with(&outcome, &[0, 2], &format!("4^{levels} prims by references"));
    Ok(())
}

/// Deeply nested brackets.
fn nested(trial: &mut Trial) -> Result<(), Stop> {
    let depth = *trial.dice.pick(&[100, 10_000, 1_000_000]);
    let (name, text) = match trial.dice.number(0..5) {
        0 => ("nested.usda", format!("#usda 1.0\ndef \"a\" {{\n custom int[] x = {}\n}}\n", "[".repeat(depth))),
        1 => ("nested.usda", format!("#usda 1.0\n{}{}", "def \"a\" {\n".repeat(depth), "}\n".repeat(depth))),
        2 => ("nested.json", format!("{}{}", "[".repeat(depth), "]".repeat(depth))),
        3 => ("nested.toml", format!("kappa = {}{}", "[".repeat(depth), "]".repeat(depth))),
        _ => ("nested.toml", format!("a{} = 1\n", ".a".repeat(depth))),
    };
    std::fs::write(trial.at(name), text)?;
    use_it(trial, name, &format!("brackets {depth} deep"))
}
