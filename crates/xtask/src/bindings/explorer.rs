//! The fibre explorer in a browser: builds the page and tries every control in Chromium.

use crate::explorer;
use crate::run::{Outcome, run, succeeds};
use std::path::{Path, PathBuf};
use std::process::Command;

const PLAYWRIGHT: &str = "playwright-core@1.65.1";

/// Runs the test. The page takes minutes to build if Debian's compiler builds the standard library.
pub fn test(root: &Path) -> Result<Outcome, String> {
    let exists = |program: &&str| succeeds(Command::new(program).arg("--version"));
    let Some(chromium) = ["chromium", "chromium-browser", "google-chrome"].into_iter().find(exists) else {
        return Ok(Outcome::Skipped("no Chromium".to_owned()));
    };
    if !exists(&"node") || !exists(&"npm") {
        return Ok(Outcome::Skipped("no node or npm".to_owned()));
    }
    let tools = root.join("target/tools/node");
    let modules = tools.join("node_modules");
    if !modules.join("playwright-core").is_dir() {
        std::fs::create_dir_all(&tools).map_err(|e| format!("{}: {e}", tools.display()))?;
        let mut install = Command::new("npm");
        install.args(["install", "--silent", "--no-save", "--prefix"]).arg(&tools).arg(PLAYWRIGHT);
        if let Err(reason) = run(&mut install) {
            return Ok(Outcome::Skipped(format!("playwright-core cannot be installed: {reason}")));
        }
    }
    if let Some(reason) = explorer::missing(root) {
        return Ok(Outcome::Skipped(reason));
    }
    explorer::build(root)?;
    let chromium = which(chromium);
    run(Command::new("node")
        .arg(root.join("integrations/web/explorer.cjs"))
        .arg(root.join("target/explorer/index.html"))
        .arg(chromium)
        .env("NODE_PATH", modules))?;
    Ok(Outcome::Passed)
}

/// The path of a program in the search path. Playwright needs one.
fn which(program: &str) -> PathBuf {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&folders).map(|folder| folder.join(program)).find(|path| path.is_file());
    found.unwrap_or_else(|| program.into())
}
