//! The command that converts Alembic files.

use std::path::Path;
use std::process::Command;
use vellus_open::{Error, Options, open};
use vellus_testing::program::Limited;

/// The command in the message for a file.
fn command(path: &Path) -> String {
    let Err(error @ Error::Alembic(_)) = open(path, &Options::default()) else { panic!("not refused") };
    let message = error.to_string();
    let (what, command) = message.split_once('\n').unwrap();
    assert!(what.contains("pip install bpy") && command.starts_with("  python -c "), "{message}");
    command.trim().to_owned()
}

#[test]
fn the_message_names_both_files() {
    let command = command(Path::new("fox's/coat.abc"));
    assert!(command.ends_with("'fox'\\''s/coat.abc' 'fox'\\''s/coat.usdc'"), "{command}");
}

/// The command of the message converts a file of Blender: its curves with their widths come back.
#[test]
fn the_command_converts_a_file() {
    let Some(python) = vellus_testing::blender() else { return };
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vellus-usd/tests/data/blender/fur_catmull_rom.abc");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("coat.abc");
    std::fs::copy(sample, &file).unwrap();
    let line = command(&file).replacen("python", &python, 1);
    let run = Command::new("sh").args(["-c", &line]).run().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let strands = open(file.with_extension("usdc"), &Options::default()).unwrap().scene.strands;
    assert_eq!((strands.len(), strands[0].len(), strands[0].points[1].w), (1, 24, 0.004));
}
