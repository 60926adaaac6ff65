//! The model in the shading languages, as one zip file.

use super::{Dist, VERSION, archive};
use crate::run::run;
use std::path::PathBuf;
use std::process::Command;

/// Converts the shaders and packs them.
pub fn build(dist: &Dist) -> Result<PathBuf, String> {
    let mut cargo = dist.tools.cargo("build", "build");
    run(cargo.args(["--package", "vellus-gpu", "--features", "convert", "--example", "shaders"]))?;
    let folder = dist.empty(&format!("stage/vellus-shaders-{VERSION}"))?;
    let program = format!("examples/shaders{}", std::env::consts::EXE_SUFFIX);
    run(Command::new(dist.tools.release("build").join(program)).arg(&folder))?;
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        super::command::copy(&dist.root.join(name), &folder.join(name))?;
    }
    super::command::copy(&dist.root.join("integrations/materialx/vellus.mtlx"), &folder.join("vellus.mtlx"))?;
    let file = dist.out.join(format!("vellus-shaders-{VERSION}.zip"));
    archive::zip(&folder, &file).map(|()| file.clone()).map_err(|e| format!("{}: {e}", file.display()))
}
