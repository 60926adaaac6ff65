//! Blender's extension with the wheel in it.

use super::{Dist, VERSION};
use crate::run::run;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Builds the extension for the platform of a wheel.
pub fn build(dist: &Dist, wheel: &Path) -> Result<PathBuf, String> {
    let python = dist.tools.python.as_deref().map_err(Clone::clone)?;
    let script = dist.root.join("integrations/blender/build.py");
    run(Command::new(python).arg(script).arg("--wheel").arg(wheel).arg("--out").arg(&dist.out))?;
    dist.file(&format!("vellus_blender-{VERSION}-"), ".zip")
}

/// The manifest has the version and names the wheel, which is in the archive with its bytes.
pub fn test(extension: &Path, wheel: &Path) -> Result<(), String> {
    let manifest = String::from_utf8(entry(extension, "blender_manifest.toml")?).map_err(|e| e.to_string())?;
    let name = wheel.file_name().unwrap_or_default().to_string_lossy();
    for line in [format!("version = \"{VERSION}\""), format!("wheels = [\"./wheels/{name}\"]")] {
        if !manifest.lines().any(|found| found == line) {
            return Err(format!("the manifest has no line {line}"));
        }
    }
    let bytes = std::fs::read(wheel).map_err(|e| format!("{}: {e}", wheel.display()))?;
    if entry(extension, &format!("wheels/{name}"))? != bytes {
        return Err(format!("{name} in the extension is another one"));
    }
    for module in ["__init__.py", "engine.py", "hook.py", "extract/scene.py"] {
        entry(extension, module)?;
    }
    Ok(())
}

/// A file of a zip archive.
fn entry(archive: &Path, name: &str) -> Result<Vec<u8>, String> {
    let error = |e: &dyn std::fmt::Display| format!("{name} in {}: {e}", archive.display());
    let file = File::open(archive).map_err(|e| error(&e))?;
    let mut archive = zip::ZipArchive::new(file).map_err(|e| error(&e))?;
    let mut bytes = Vec::new();
    archive.by_name(name).map_err(|e| error(&e))?.read_to_end(&mut bytes).map_err(|e| error(&e))?;
    Ok(bytes)
}
