//! The model in the shading languages, as one zip file.

use super::{Dist, VERSION, archive};
use crate::run::run;
use std::path::PathBuf;
use std::process::Command;

/// Writes the shaders with the command, and packs them.
pub fn build(dist: &Dist) -> Result<PathBuf, String> {
    run(dist.tools.cargo("build", "build").args(["--package", "vellus-cli", "--bin", "vellus"]))?;
    let folder = dist.empty(&format!("stage/vellus-shaders-{VERSION}"))?;
    let program = format!("vellus{}", std::env::consts::EXE_SUFFIX);
    run(Command::new(dist.tools.release("build").join(program)).arg("shaders").arg(&folder))?;
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        super::command::copy(&dist.root.join(name), &folder.join(name))?;
    }
    super::command::copy(&dist.root.join("integrations/materialx/vellus.mtlx"), &folder.join("vellus.mtlx"))?;
    let file = dist.out.join(format!("vellus-shaders-{VERSION}.zip"));
    archive::zip(&folder, &file).map(|()| file.clone()).map_err(|e| format!("{}: {e}", file.display()))
}
