//! The model as WebAssembly: the golden vectors in Node.js, and every control of the fibre explorer in Chromium.

use crate::explorer;
use crate::run::{Outcome, run, succeeds};
use std::path::{Path, PathBuf};
use std::process::Command;

const PLAYWRIGHT: &str = "playwright-core@1.65.1";

fn exists(program: &str) -> bool {
    succeeds(Command::new(program).arg("--version"))
}

/// Checks the golden vectors with the module of the explorer, without a browser.
pub fn vectors(root: &Path) -> Result<Outcome, String> {
    if !exists("node") {
        return Ok(Outcome::Skipped("no node".to_owned()));
    }
    if let Some(reason) = explorer::missing(root) {
        return Ok(Outcome::Skipped(reason));
    }
    let module = explorer::compile(root)?;
    run(Command::new("node").arg(root.join("integrations/web/vectors.cjs")).arg(module).arg(root.join("vectors")))?;
    Ok(Outcome::Passed)
}

/// Runs the test of the page. It takes minutes to build if Debian's compiler builds the standard library.
pub fn test(root: &Path) -> Result<Outcome, String> {
    let browsers = ["chromium", "chromium-browser", "google-chrome"];
    let Some(chromium) = browsers.into_iter().find(|name| exists(name)) else {
        return Ok(Outcome::Skipped("no Chromium".to_owned()));
    };
    if !exists("node") || !exists("npm") {
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
