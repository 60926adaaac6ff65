//! The Python package: a wheel for many distributions, and an archive of the source that pip can build.

use super::{Dist, VERSION, licences, old_processor, packages};
use crate::bindings::venv;
use crate::run::{Outcome, output, run};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A query and a small picture.
const TRIAL: &str = "\
import numpy, vellus
bcsdf = vellus.Bcsdf(vellus.Fiber('red-fox'))
f = bcsdf.eval(wi=vellus.direction(-20.0, numpy.arange(181.0)), wo=vellus.direction(20.0, 0.0), h=0.3)
assert f.shape == (181, 3) and (f > 0).all(), f
vellus.Scene.open('cat', small=True).render(64, 64, 1).write('cat.exr')
";

/// Builds the wheel.
pub fn wheel(dist: &Dist) -> Result<PathBuf, String> {
    let mut maturin = dist.tools.maturin("build")?;
    let packages = packages::compiled_into(&dist.root, &["vellus-python"], &dist.tools.triple)?;
    // maturin includes it in the wheel. It is not in the repository.
    let others = dist.root.join("crates/vellus-python/python/vellus").join(licences::OTHERS);
    std::fs::write(&others, licences::others(packages.values())?).map_err(|e| format!("{}: {e}", others.display()))?;
    let result = run(maturin.arg("--out").arg(&dist.out));
    std::fs::remove_file(others).ok();
    result?;
    dist.file(&format!("vellus-{VERSION}-cp"), ".whl")
}

/// Packs the source of the Python package with that of all crates that it needs.
pub fn source(dist: &Dist) -> Result<PathBuf, String> {
    run(dist.tools.maturin("sdist")?.arg("--out").arg(&dist.out))?;
    dist.file(&format!("vellus-{VERSION}.tar"), ".gz")
}

/// Installs a wheel or a source archive into an empty environment. Compiling the source takes as long as the command.
pub fn test(dist: &Dist, package: &Path) -> Result<Outcome, String> {
    let folder = dist.empty("try/python")?;
    let environment = folder.join("environment");
    run(Command::new(venv::supported()?).args(["-m", "venv"]).arg(&environment))?;
    let python = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).arg(package);
    run(pip.env("CARGO_TARGET_DIR", dist.folder("source")))?;
    run(Command::new(&python).args(["-c", TRIAL]).current_dir(&folder))?;
    super::try_command::has_bytes(&folder.join("cat.exr"))?;
    Ok(Outcome::Passed)
}

/// On an old processor, the import of the wheel that was installed last fails with a message.
pub fn without_avx2(dist: &Dist) -> Result<Outcome, String> {
    let python = dist.folder("try/python/environment/bin/python");
    old_processor::refuses(&python, &["-c", "import vellus"], "this build of vellus needs a processor with AVX2")
}

/// The wheel has the licences. Maturin checks that its module needs no later glibc than its name says.
pub fn has_licences(dist: &Dist, wheel: &Path) -> Result<(), String> {
    let python = dist.tools.python.as_deref().map_err(Clone::clone)?;
    let list = output(Command::new(python).args(["-m", "zipfile", "-l"]).arg(wheel))?;
    for name in ["LICENSE-MIT", "LICENSE-APACHE", licences::OTHERS] {
        if !list.contains(name) {
            return Err(format!("{} has no {name}", wheel.display()));
        }
    }
    Ok(())
}
