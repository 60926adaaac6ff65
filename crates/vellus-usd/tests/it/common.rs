//! Code that several tests share.

use std::path::{Path, PathBuf};
use std::process::Command;
use vellus_scene::Scene;
use vellus_usd::{Error, Options, Warning};

/// Reads the scene and the warnings of a file.
pub fn read(file: &Path, options: &Options) -> Result<(Scene, Vec<Warning>), Error> {
    vellus_usd::read(file, options).map(|reading| (reading.scene, reading.warnings))
}

/// Reads a stage of one layer.
pub fn read_text(body: &str, options: &Options) -> Result<(Scene, Vec<Warning>), Error> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("stage.usda");
    std::fs::write(&file, format!("#usda 1.0\n{body}")).unwrap();
    read(&file, options)
}

/// Options with a width for curves without one.
pub fn with_width(width: f32) -> Options {
    Options { default_width: Some(width), ..Options::default() }
}

/// Sample data, which is not part of the project. If it is missing, prints that and returns `None`.
pub fn sample(name: &str) -> Option<PathBuf> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets").join(name);
    if !file.exists() {
        eprintln!("skipped: the sample {name} is missing");
        return None;
    }
    Some(file)
}

/// Python with Pixar's library, the package `usd-core`. If it is missing, prints that and returns `None`. `cargo xtask
/// test` installs it.
pub fn pixar() -> Option<Command> {
    if !Command::new("python3").args(["-c", "import pxr"]).output().is_ok_and(|run| run.status.success()) {
        eprintln!("skipped: no python3 with usd-core");
        return None;
    }
    Some(Command::new("python3"))
}
