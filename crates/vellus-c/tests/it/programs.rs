//! Builds the programs in C and C++ and compares their results with those of Rust, bit for bit.
//!
//! With VELLUS_C_PREFIX, the folder of an installed library, the programs are built with pkg-config and use the shared
//! library there, as a user's programs do. Otherwise they use the static library of this test.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use vellus::glam::Vec3;
use vellus::wide::f32x8;
use vellus::{Bcsdf, Fiber, FiberBuilder, Species, Window};
use vellus_testing::program::Limited;
use vellus_testing::{need, succeeds};

/// Whether a program is there. Its kind has its name.
fn is_there(program: &str) -> bool {
    let found = || succeeds(Command::new(program).arg("--version"));
    need(program, if cfg!(unix) { found() } else { Err("the options are those of Unix".to_owned()) }).is_some()
}

fn run(command: &mut Command) -> Output {
    let output = command.run().unwrap();
    let text = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
    assert!(output.status.success(), "{command:?}: {}\n{}{}", output.status, text[0], text[1]);
    output
}

/// Compiles a program of the repository, if there is a compiler.
fn build(source: &str, folder: &Path) -> Option<PathBuf> {
    let (compiler, standard) = if source.ends_with(".c") { ("cc", "-std=c11") } else { ("c++", "-std=c++17") };
    if !is_there(compiler) {
        return None;
    }
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = folder.join("program");
    let mut command = Command::new(compiler);
    command.args([standard, "-O1", "-Wall", "-Wextra", "-Werror", "-o"]).arg(&program);
    command.arg(package.join("../..").join(source));
    match std::env::var_os("VELLUS_C_PREFIX") {
        Some(prefix) => {
            if !is_there("pkg-config") {
                return None;
            }
            let path = Path::new(&prefix).join("lib/pkgconfig");
            let output =
                run(Command::new("pkg-config").args(["--cflags", "--libs", "vellus"]).env("PKG_CONFIG_PATH", path));
            command.args(String::from_utf8(output.stdout).unwrap().split_whitespace());
            command.arg(format!("-Wl,-rpath,{}", Path::new(&prefix).join("lib").display()));
        }
        None => {
            let test = std::env::current_exe().unwrap();
            command.arg("-I").arg(package.join("include")).arg(test.with_file_name("libvellus_c.a"));
        }
    }
    run(command.args(["-pthread", "-ldl", "-lm"]));
    Some(program)
}

/// The lines that a program prints, as a name and numbers.
fn printed(program: &Path) -> Vec<(String, Vec<f32>)> {
    let output = run(&mut Command::new(program));
    let text = String::from_utf8(output.stdout).unwrap();
    let line = |line: &str| {
        let mut words = line.split_whitespace();
        let name = words.next().unwrap_or_default().to_owned();
        (name, words.filter_map(hexadecimal).collect())
    };
    text.lines().map(line).collect()
}

/// A number as `%a` of C prints it: `-0x1.8p-3`. A decimal integer is read too.
fn hexadecimal(text: &str) -> Option<f32> {
    let (sign, digits) = text.strip_prefix('-').map_or((1.0, text), |digits| (-1.0, digits));
    let Some((mantissa, exponent)) = digits.strip_prefix("0x").and_then(|digits| digits.split_once('p')) else {
        return text.parse::<i16>().ok().map(f32::from);
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let value = u64::from_str_radix(&format!("{whole}{fraction}"), 16).ok()? as f64;
    let exponent = exponent.parse::<i32>().ok()? - 4 * i32::try_from(fraction.len()).ok()?;
    Some((sign * value * 2f64.powi(exponent)) as f32)
}

/// Compares bits, so that −0 is not 0.
fn assert_same(found: &[(String, Vec<f32>)], expected: &[(&str, Vec<f32>)]) {
    assert_eq!(found.len(), expected.len());
    for ((name, numbers), (expected_name, expected)) in found.iter().zip(expected) {
        let bits = |numbers: &[f32]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(name, expected_name);
        assert_eq!(bits(numbers), bits(expected), "{name}: {numbers:?}, in Rust {expected:?}");
    }
}

#[test]
fn the_c_program_has_the_bits_of_rust() {
    let folder = tempfile::tempdir().unwrap();
    let Some(program) = build("examples/c/queries.c", folder.path()) else { return };
    let fiber = Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]);
    let bcsdf = Bcsdf::new(&Fiber { alpha: 4f32.to_radians(), ..fiber }).unwrap();
    let mut expected: Vec<(&str, Vec<f32>)> = Vec::new();
    let (wo, wi) = (Vec3::new(0.36, 0.48, 0.8), Vec3::new(-0.48, 0.64, 0.6));
    for window in [Window::near(0.3), Window::cell(0.3, 0.5, 0.25), Window::range(-0.25, 0.75), Window::far()] {
        let hit = bcsdf.at(wo, window);
        let sample = hit.sample([0.1, 0.2, 0.3, 0.4, 0.5]).unwrap();
        expected.extend([
            ("window", Vec::new()),
            ("eval", hit.eval(wi).total().to_vec()),
            ("pdf", vec![hit.pdf(wi)]),
            ("energy", hit.energy().0.concat()),
            ("hit", hit.eval(wi).total().to_vec()),
            ("hit_pdf", vec![hit.pdf(wi)]),
            ("lobes", hit.eval(wi).0.concat()),
            ("sample", sample.wi.to_array().to_vec()),
            ("sample_pdf", vec![sample.pdf]),
            ("weight", sample.weight.to_vec()),
            ("lobe", vec![f32::from(sample.lobe as u8)]),
        ]);
    }
    for i in 0..21u8 {
        let sign = if i % 2 == 1 { 1.0 } else { -1.0 };
        let splat = |w: [f32; 3]| w.map(f32x8::splat);
        let hit = bcsdf.at8(splat([0.36 * sign, 0.48, 0.8]), f32x8::splat(f32::from(i) / 16.0 - 0.5));
        let (lobes, pdf) = hit.eval_pdf8(splat([0.48, -0.6 * sign, 0.64]));
        let u = [0, 1, 2, 3].map(|k| f32x8::splat(f32::from((7 * u16::from(i) + 11 * k) % 32) / 32.0));
        let sample = hit.sample8(u)[0].unwrap();
        expected.extend([
            ("array", lobes.total().map(|x| x.to_array()[0]).to_vec()),
            ("array_pdf", vec![pdf.to_array()[0]]),
            ("array_sample", sample.wi.to_array().to_vec()),
            ("array_weight", sample.weight.to_vec()),
        ]);
    }
    assert_same(&printed(&program), &expected);
}

#[test]
fn c_has_the_golden_vectors() {
    let folder = tempfile::tempdir().unwrap();
    let Some(program) = build("crates/vellus-c/tests/vectors.c", folder.path()) else { return };
    run(Command::new(program).arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vectors")));
}

#[test]
fn the_cpp_program_has_the_bits_of_rust() {
    let folder = tempfile::tempdir().unwrap();
    let Some(program) = build("examples/c/threads.cpp", folder.path()) else { return };
    let mut builder = FiberBuilder::new(Fiber::preset(Species::Cat));
    builder.set("melanin", &[1.3, 0.2]).unwrap();
    builder.set("beta_n", &[12.0]).unwrap();
    let bcsdf = Bcsdf::new(&builder.build().unwrap()).unwrap();
    let hit = bcsdf.at(Vec3::new(0.36, 0.48, 0.8), Window::far());
    let mut expected: Vec<(&str, Vec<f32>)> = Vec::new();
    for i in 0..40 {
        let sign = if i % 2 == 1 { 1.0 } else { -1.0 };
        let wi = [[0.48 * sign, -0.6, 0.64], [0.8, 0.36 * sign, -0.48]][i % 4 / 2];
        let (lobes, _) = hit.eval_pdf8(wi.map(f32x8::splat));
        expected.push(("far", lobes.total().map(|x| x.to_array()[0]).to_vec()));
    }
    expected.push(("refused:", vec![2.0]));
    assert_same(&printed(&program), &expected);
}

/// The first block of C of the book's page. It prints with `%g`, which has six digits.
#[test]
fn the_first_program_of_the_book_has_the_numbers_of_rust() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/book/src/c.md");
    let page = std::fs::read_to_string(page).unwrap();
    let lines = page.lines().skip_while(|line| *line != "```c").skip(1).take_while(|line| *line != "```");
    let source = lines.map(|line| format!("{line}\n")).collect::<String>();
    assert!(source.contains("int main(void)"), "{source}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("first.c");
    std::fs::write(&path, source).unwrap();
    let Some(program) = build(path.to_str().unwrap(), folder.path()) else { return };
    let output = run(&mut Command::new(&program));
    let text = String::from_utf8(output.stdout).unwrap();
    let words = text.split(|c: char| c.is_whitespace() || c == ',');
    let found: Vec<f32> = words.filter_map(|word| word.parse().ok()).collect();
    let bcsdf = Bcsdf::new(&Fiber::preset(Species::RedFox)).unwrap();
    let hit = bcsdf.at(Vec3::new(0.36, 0.48, 0.8), Window::near(0.3));
    let (f, pdf) = hit.eval_pdf(Vec3::new(-0.48, 0.64, 0.6));
    let [r, g, b] = f.total();
    let is_near = |(x, y): (&f32, &f32)| (x - y).abs() < 1e-5 * y;
    assert!(found.len() == 4 && found.iter().zip(&[r, g, b, pdf]).all(is_near), "{text}");
}

#[test]
fn bad_input_gives_a_status_and_no_crash() {
    let folder = tempfile::tempdir().unwrap();
    let Some(program) = build("crates/vellus-c/tests/bad_input.c", folder.path()) else { return };
    run(&mut Command::new(&program));
}

#[test]
#[ignore = "test: valgrind is slow"]
fn bad_input_neither_leaks_nor_reads_wrong_memory() {
    let folder = tempfile::tempdir().unwrap();
    if !is_there("valgrind") {
        return;
    }
    let Some(program) = build("crates/vellus-c/tests/bad_input.c", folder.path()) else { return };
    // Memory needs few rounds in threads. The other test has many.
    run(Command::new("valgrind").args(["-q", "--leak-check=full", "--error-exitcode=9"]).arg(&program).arg("5"));
}
