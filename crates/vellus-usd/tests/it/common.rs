//! Code that several tests share.

use std::path::{Path, PathBuf};
use std::process::Command;
use vellus_scene::Scene;
use vellus_testing::{need, succeeds};
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

/// A file that `data/make_blender.py` wrote with Blender.
pub fn blender(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/blender").join(name)
}

/// Python with Pixar's library, the package `usd-core`, if it is there. `cargo xtask test` installs it.
pub fn pixar() -> Option<Command> {
    let found = succeeds(Command::new("python3").args(["-c", "import pxr"]));
    need("openusd", found.map(|()| Command::new("python3")))
}

/// What is said about a stage: the error if nothing of it can be shown, otherwise its warnings, one a line.
pub fn told(read: Result<(Scene, Vec<Warning>), Error>) -> String {
    match read {
        Ok((_, warnings)) => warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"),
        Err(error) => error.to_string(),
    }
}
