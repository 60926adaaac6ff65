//! Golden vectors through the files in other languages: GLSL by OpenGL, and HLSL by Slang's compiler, which makes C++
//! of it for the processor, and CUDA C++. Mesa's llvmpipe is enough.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use vellus::Bcsdf;
use vellus_gpu::{Field, Language, converted, shader_far_table, shader_fiber, shader_tables};
use vellus_testing::program::Limited;
use vellus_testing::vectors::{Vector, Vectors};
use vellus_testing::{need, succeeds};

/// The bytes of an answer in `queries.wgsl`.
const ANSWER: usize = 240;

/// Runs a command, which must print nothing to standard error.
fn run(command: &mut Command) -> Vec<u8> {
    let output = command.run().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.is_empty(), "{command:?}: {}\n{errors}", output.status);
    output.stdout
}

/// Compiles a program of this folder, if there is a compiler.
fn build(folder: &Path, source: &str, definitions: &[String]) -> Option<PathBuf> {
    let found = succeeds(Command::new("c++").arg("--version"));
    need("c++", if cfg!(unix) { found } else { Err("the options are those of Unix".to_owned()) })?;
    let program = folder.join("program");
    let mut command = Command::new("c++");
    command.args(["-std=c++17", "-O1", "-w", &format!("-DANSWER={ANSWER}")]).args(definitions);
    command.arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it").join(source));
    run(command.arg("-o").arg(&program).arg("-ldl"));
    Some(program)
}

/// Slang's compiler.
pub fn slangc() -> Option<OsString> {
    let program = std::env::var_os("VELLUS_SLANGC").unwrap_or_else(|| "slangc".into());
    need("slangc", succeeds(Command::new(&program).arg("-version")).map(|()| program))
}

/// Compiles the HLSL of a field as Slang to `shader.TARGET`.
fn compile(slangc: &OsString, folder: &Path, field: Field, target: &str) -> PathBuf {
    let (source, made) = (folder.join("vellus.hlsl"), folder.join(format!("shader.{target}")));
    std::fs::write(&source, converted(Language::Hlsl, field).unwrap()).unwrap();
    let mut command = Command::new(slangc);
    command.arg(&source).args(["-lang", "slang", "-target", target, "-stage", "compute", "-entry", field.entry()]);
    run(command.arg("-o").arg(&made));
    made
}

/// The command that runs the queries in C++ from Slang.
fn by_slang(folder: &Path, field: Field) -> Option<Command> {
    let shader = compile(&slangc()?, folder, field, "cpp");
    let definitions = [format!("-DENTRY={}", field.entry()), format!("-DSHADER=\"{}\"", shader.display())];
    build(folder, "ports_slang.cpp", &definitions).map(Command::new)
}

/// The command that runs the queries in GLSL.
fn by_opengl(folder: &Path, field: Field) -> Option<Command> {
    let program = build(folder, "ports_gl.cpp", &[])?;
    need("opengl", succeeds(&mut Command::new(&program)))?;
    let shader = folder.join("vellus.comp");
    std::fs::write(&shader, converted(Language::Glsl, field).unwrap()).unwrap();
    let mut command = Command::new(program);
    command.arg(shader);
    Some(command)
}

/// Asks all golden vectors of a field. None may be off by more than its tolerance.
fn check(field: Field, prepare: impl Fn(&Path, Field) -> Option<Command>) {
    let folder = tempfile::tempdir().unwrap();
    let Some(first) = prepare(folder.path(), field) else { return };
    let vectors = Vectors::read();
    let file = |name: &str, numbers: &[f32]| {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let tables = file("tables", shader_tables().as_flattened());
    let is_asked = |q: &&Vector| match field {
        Field::Near => q.window[0] == q.window[1],
        Field::Far => q.window == [-1.0, 1.0],
    };
    let (mut count, mut worst) = (0, 0.0f32);
    // The tables of the far field of all fibres together are large.
    let part = if field == Field::Near { 100 } else { 8 };
    for (start, fibers) in vectors.fibers.chunks(part).enumerate() {
        let own = |q: &&Vector| q.fiber / part == start && is_asked(q);
        let asked: Vec<&Vector> = vectors.queries.iter().filter(own).collect();
        let models: Vec<Bcsdf<'_>> = fibers.iter().map(|fiber| Bcsdf::new(fiber).unwrap()).collect();
        let (mut far, mut rows) = (Vec::new(), Vec::new());
        for model in models.iter().filter(|_| field == Field::Far) {
            rows.push(f32::from_bits(far.len() as u32));
            far.extend(shader_far_table(model));
        }
        // In the far field, the first row of the fibre's table is in the place of the offset.
        let query = |q: &&Vector| {
            let fiber = q.fiber % part;
            let h = rows.get(fiber).copied().unwrap_or(q.window[0]);
            [q.wo.x, q.wo.y, q.wo.z, h, q.wi.x, q.wi.y, q.wi.z, f32::from_bits(fiber as u32), 0.5, 0.5, 0.5, 0.5]
        };
        let mut command = Command::new(first.get_program());
        command.args(first.get_args()).arg(asked.len().to_string()).arg("0").arg(&tables);
        command.arg("1").arg(file("fibers", models.iter().flat_map(shader_fiber).collect::<Vec<_>>().as_flattened()));
        // The HLSL declares this one before the queries.
        if field == Field::Far {
            command.arg("4").arg(file("far", far.as_flattened()));
        }
        command.arg("2").arg(file("queries", &asked.iter().flat_map(query).collect::<Vec<_>>())).args(["3", "-"]);
        let answers = run(&mut command);
        assert_eq!(answers.len(), asked.len() * ANSWER);
        for (q, answer) in asked.iter().zip(answers.chunks(ANSWER)) {
            let channel = |c: usize| f32::from_le_bytes(std::array::from_fn(|k| answer[4 * c + k]));
            worst = worst.max(q.error(std::array::from_fn(channel)));
        }
        count += asked.len();
    }
    println!("{field:?}: {count} queries, largest error {worst:.2} tolerances");
    assert!(count == if field == Field::Near { 1_000 } else { 500 } && worst <= 1.0, "{worst}");
}

#[test]
fn slang_has_the_golden_vectors() {
    check(Field::Near, by_slang);
}

#[test]
#[ignore = "test: tables of the far field of 100 fibres"]
fn slang_has_the_golden_vectors_of_the_far_field() {
    check(Field::Far, by_slang);
}

#[test]
fn slang_makes_cuda() {
    let Some(slangc) = slangc() else { return };
    let folder = tempfile::tempdir().unwrap();
    for field in [Field::Near, Field::Far] {
        let text = std::fs::read_to_string(compile(&slangc, folder.path(), field, "cuda")).unwrap();
        assert!(text.contains(&format!("__global__ void {}(", field.entry())), "{field:?}");
    }
}

#[test]
#[ignore = "full: Mesa compiles the shader for two minutes"]
fn glsl_has_the_golden_vectors() {
    check(Field::Near, by_opengl);
}

#[test]
#[ignore = "full: Mesa compiles the shader for two minutes"]
fn glsl_has_the_golden_vectors_of_the_far_field() {
    check(Field::Far, by_opengl);
}
