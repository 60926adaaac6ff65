//! The files of `vellus shaders`, and a program in C++ that draws with them.

use crate::common::{Limited, refused, run};
use std::path::{Path, PathBuf};
use std::process::Command;
use vellus::{Bcsdf, Fiber};
use vellus_gpu::{shader_color, shader_far_table, shader_fiber, shader_tables, shader_tables_half};
use vellus_testing::{need, succeeds};

/// The names of the files in a folder, in order.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn bytes(rows: &[[f32; 4]]) -> Vec<u8> {
    rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
}

#[test]
fn the_folder_has_the_library_and_the_named_fibres() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("wet.toml"), "preset = \"red-fox\"\nwet = 0.5\n").unwrap();
    run(path, &["shaders", "--fiber", "wet.toml", "--fiber", "cat", "out"]);
    let out = path.join("out");
    let library = "far-queries.wgsl queries.wgsl tables.bin tables-half.bin vellus-far.comp vellus-far.hlsl \
                   vellus-far.metal vellus-far.spv vellus-far.wgsl vellus-reduced.glsl vellus-reduced.hlsli \
                   vellus-reduced.wgsl vellus.comp vellus.glsl vellus.hlsl vellus.hlsli vellus.metal vellus.spv \
                   vellus.wgsl";
    let mut expected: Vec<&str> = library.split_whitespace().collect();
    expected.extend(["cat-color.bin", "cat-far.bin", "cat.bin", "wet-color.bin", "wet-far.bin", "wet.bin"]);
    expected.sort_unstable();
    assert_eq!(names(&out), expected);
    assert!(std::fs::read(out.join("tables.bin")).unwrap() == bytes(&shader_tables()));
    let half: Vec<u8> = shader_tables_half().as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    assert!(std::fs::read(out.join("tables-half.bin")).unwrap() == half);
    let wet = Fiber { wet: 0.5, ..Fiber::named("red-fox").unwrap() };
    for (name, fiber) in [("cat", Fiber::named("cat").unwrap()), ("wet", wet)] {
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let contents = [&shader_fiber(&bcsdf)[..], &shader_color(&bcsdf), &shader_far_table(&bcsdf)];
        for (end, rows) in ["", "-color", "-far"].into_iter().zip(contents) {
            assert!(std::fs::read(out.join(format!("{name}{end}.bin"))).unwrap() == bytes(rows), "{name}{end}");
        }
    }
}

#[test]
fn wrong_fibres_are_refused_before_the_first_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (name, text) in [("Tables.toml", "preset = \"cat\""), ("bad.toml", "kappa = 2")] {
        std::fs::write(path.join(name), text).unwrap();
    }
    refused(path, &["shaders", "--fiber", "unicorn", "out"], &["unicorn"]);
    refused(path, &["shaders", "--fiber", "bad.toml", "out"], &["bad.toml", "kappa = 2", "[0, 0.99]"]);
    refused(path, &["shaders", "--fiber", "cat", "--fiber", "cat", "out"], &["--fiber", "cat.bin"]);
    refused(path, &["shaders", "--fiber", "Tables.toml", "out"], &["Tables.bin"]);
    refused(path, &["shaders"], &["<DIR>"]);
    assert!(!path.join("out").exists());
    refused(path, &["shaders", "bad.toml"], &["bad.toml"]);
}

/// A program, if it is there.
fn program(kind: &str, name: &str) -> Option<()> {
    need(kind, succeeds(Command::new(name).arg("--version")))
}

fn build(command: &mut Command) {
    let output = command.run().unwrap();
    let text = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
    assert!(output.status.success(), "{command:?}: {text}");
}

/// The fur covers the middle of the picture and has the colour of the fox: red over green over blue.
#[test]
#[ignore = "test: compiles a program and its shader, and traces 4,000 paths"]
fn a_host_in_vulkan_draws_a_ball_of_fur() {
    let example = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/vulkan"));
    let header = Command::new("c++").args(["-E", "-include", "vulkan/vulkan.h", "-x", "c++", "/dev/null"]).run();
    let header = header.map_err(|e| e.to_string()).and_then(|output| {
        if output.status.success() { Ok(()) } else { Err("c++ does not find vulkan/vulkan.h".to_owned()) }
    });
    let found = [program("c++", "c++"), program("shader-compilers", "glslangValidator"), need("vulkan", header)];
    if found.contains(&None) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, &["shaders", "--fiber", &example.join("fox.toml").display().to_string(), "shaders"]);
    let mut glslang = Command::new("glslangValidator");
    glslang.current_dir(path).args(["-V", "-Ishaders", "-o", "shaders/furball.spv"]).arg(example.join("furball.comp"));
    build(&mut glslang);
    let mut compiler = Command::new("c++");
    compiler.current_dir(path).args(["-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", "-o", "furball"]);
    build(compiler.arg(example.join("furball.cpp")).arg("-lvulkan"));
    let output = Command::new(path.join("furball")).current_dir(path).args(["shaders", "ball.ppm", "32", "4"]).run();
    let output = output.unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    if need("gpu", if output.status.code() == Some(2) { Err(message.clone()) } else { Ok(()) }).is_none() {
        return;
    }
    assert!(output.status.success(), "{message}");
    let picture = std::fs::read(path.join("ball.ppm")).unwrap();
    let pixels = picture.strip_prefix(b"P6\n32 32\n255\n").unwrap().as_chunks::<3>().0;
    assert_eq!(pixels.len(), 32 * 32);
    assert_eq!(pixels[0], pixels[31], "the corners show the background");
    let middle = (8..24).flat_map(|y| (8..24).map(move |x| pixels[32 * y + x].map(f32::from)));
    let [r, g, b] = middle.fold([0.0; 3], |sum, pixel| [0, 1, 2].map(|c| sum[c] + pixel[c] / 256.0));
    assert!(r > 1.2 * g && g > 1.2 * b && r > 80.0, "{r} {g} {b}");
}
