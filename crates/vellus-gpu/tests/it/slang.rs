//! The HLSL of the library is Slang, too. Slang's compiler makes C++ of it, which has the golden vectors on the
//! processor, and CUDA C++.

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

/// Slang's compiler.
fn slangc() -> Option<OsString> {
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

#[test]
fn slang_makes_cuda() {
    let Some(slangc) = slangc() else { return };
    let folder = tempfile::tempdir().unwrap();
    for field in [Field::Near, Field::Far] {
        let text = std::fs::read_to_string(compile(&slangc, folder.path(), field, "cuda")).unwrap();
        assert!(text.contains(&format!("__global__ void {}(", field.entry())), "{field:?}");
    }
}

/// The program of a field.
fn program(folder: &Path, field: Field) -> Option<PathBuf> {
    let slangc = slangc()?;
    need("c++", succeeds(Command::new("c++").arg("--version")))?;
    let shader = compile(&slangc, folder, field, "cpp");
    let program = folder.join("program");
    let mut command = Command::new("c++");
    command.args(["-std=c++17", "-O1", "-w", &format!("-DENTRY={}", field.entry()), &format!("-DANSWER={ANSWER}")]);
    command.arg(format!("-DSHADER=\"{}\"", shader.display()));
    run(command.arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/slang.cpp")).arg("-o").arg(&program));
    Some(program)
}

/// The largest error of the golden vectors of one window, and their number. A query has the first row of its fibre's
/// table in the far field, and its offset in the near field.
fn golden(field: Field, is_asked: impl Fn(&Vector) -> bool) -> Option<(usize, f32)> {
    let folder = tempfile::tempdir().unwrap();
    let program = program(folder.path(), field)?;
    let vectors = Vectors::read();
    let file = |name: &str, numbers: &[f32]| {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let tables = file("tables", shader_tables().as_flattened());
    let (mut count, mut worst) = (0, 0.0f32);
    // The tables of the far field of all fibres together are large.
    for (start, fibers) in vectors.fibers.chunks(8).enumerate() {
        let asked: Vec<&Vector> = vectors.queries.iter().filter(|q| q.fiber / 8 == start && is_asked(q)).collect();
        let models: Vec<Bcsdf<'_>> = fibers.iter().map(|fiber| Bcsdf::new(fiber).unwrap()).collect();
        let (mut far, mut first) = (Vec::new(), Vec::new());
        if field == Field::Far {
            for model in &models {
                first.push(f32::from_bits(far.len() as u32));
                far.extend(shader_far_table(model));
            }
        }
        let query = |q: &&Vector| {
            let fiber = q.fiber % 8;
            let h = first.get(fiber).copied().unwrap_or(q.window[0]);
            let row = [q.wo.to_array(), [h, q.wi.x, q.wi.y], [q.wi.z, f32::from_bits(fiber as u32), 0.5], [0.5; 3]];
            row.as_flattened().to_vec()
        };
        let mut command = Command::new(&program);
        command.arg(asked.len().to_string()).arg(&tables);
        command.arg(file("fibers", models.iter().flat_map(shader_fiber).collect::<Vec<_>>().as_flattened()));
        // In the order in which the HLSL declares them.
        if field == Field::Far {
            command.arg(file("far", far.as_flattened()));
        }
        command.arg(file("queries", &asked.iter().flat_map(query).collect::<Vec<_>>())).arg("-");
        let answers = run(&mut command);
        assert_eq!(answers.len(), asked.len() * ANSWER);
        for (q, answer) in asked.iter().zip(answers.chunks(ANSWER)) {
            let channel = |c: usize| f32::from_le_bytes(std::array::from_fn(|k| answer[4 * c + k]));
            worst = worst.max(q.error(std::array::from_fn(channel)));
        }
        count += asked.len();
    }
    println!("Slang, {field:?}: {count} queries, largest error {worst:.2} tolerances");
    Some((count, worst))
}

#[test]
fn golden_vectors() {
    let Some((count, worst)) = golden(Field::Near, |q| q.window[0] == q.window[1]) else { return };
    assert!(count == 1_000 && worst <= 1.0, "{worst}");
}

#[test]
#[ignore = "test: tables of the far field of 100 fibres"]
fn golden_vectors_of_the_far_field() {
    let Some((count, worst)) = golden(Field::Far, |q| q.window == [-1.0, 1.0]) else { return };
    assert!(count == 500 && worst <= 1.0, "{worst}");
}
