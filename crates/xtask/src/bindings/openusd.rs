//! Other libraries, which read what we write: the tests that need the packages `usd-core`, `alembic3d` and `materialx`.

use super::venv::{python, venv};
use std::path::Path;

/// The versions of Python that the packages have wheels for.
const VERSIONS: [&str; 5] = ["3.11", "3.13", "3.12", "3.10", "3.14"];

/// A search path in which `python3` has the packages.
///
/// # Errors
/// The reason why there is none.
pub fn path(root: &Path) -> Result<String, String> {
    let interpreter = VERSIONS.iter().find_map(|version| python(version));
    let interpreter = interpreter.ok_or_else(|| format!("no Python {}", VERSIONS.join(", ")))?;
    let python = venv(root, "openusd", &interpreter, &["usd-core==26.11", "alembic3d==1.8.12.1", "materialx==1.39.5"])?;
    let folder = python.parent().unwrap_or(root).to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([folder].into_iter().chain(std::env::split_paths(&path)));
    path.map_err(|e| e.to_string())?.into_string().map_err(|path| format!("PATH is no text: {}", path.display()))
}
