//! The command with its manual pages and shell completions: an archive, and on x86-64 a second one for old processors.

use super::{Dist, VERSION, archive, licences, packages};
use crate::run::run;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Which processors the command runs on.
#[derive(Clone, Copy, PartialEq)]
pub enum Build {
    /// Those that `.cargo/config.toml` asks for.
    Usual,
    /// All x86-64 processors.
    Baseline,
}

impl Build {
    /// The folder of the compiler's files.
    fn folder(self) -> &'static str {
        if self == Self::Usual { "build" } else { "baseline" }
    }

    /// The name of the archive without its extension.
    fn name(self, triple: &str) -> String {
        format!("vellus-{VERSION}-{triple}{}", if self == Self::Usual { "" } else { "-baseline" })
    }
}

/// Builds the archive.
pub fn build(dist: &Dist, build: Build) -> Result<PathBuf, String> {
    let mut cargo = dist.tools.cargo("build", build.folder());
    if build == Build::Baseline {
        // It replaces the flags in `.cargo/config.toml`.
        cargo.env("RUSTFLAGS", "-C target-cpu=x86-64");
    }
    run(cargo.args(["--package", "vellus-cli", "--bin", "vellus"]))?;
    let folder = dist.empty(&format!("stage/{}", build.name(&dist.tools.triple)))?;
    let program = format!("vellus{}", std::env::consts::EXE_SUFFIX);
    copy(&dist.tools.release(build.folder()).join(&program), &folder.join("bin").join(&program))?;
    // The same program writes the manual for both archives.
    run(dist.tools.cargo("build", Build::Usual.folder()).args(["--package", "vellus-cli", "--example", "manual"]))?;
    let manual = format!("examples/manual{}", std::env::consts::EXE_SUFFIX);
    run(Command::new(dist.tools.release(Build::Usual.folder()).join(manual)).arg(folder.join("share")))?;
    std::fs::write(folder.join("README.md"), readme(&dist.tools.triple)).map_err(|e| format!("README.md: {e}"))?;
    copy(&dist.root.join("CHANGELOG.md"), &folder.join("CHANGELOG.md"))?;
    let font = "DejaVuSans-LICENSE.txt";
    copy(&dist.root.join("crates/vellus-plot/assets").join(font), &folder.join(font))?;
    let packages = packages::compiled_into(&dist.root, &["vellus-cli"], &dist.tools.triple)?;
    licences::copy(&dist.root, &folder, packages.values())?;
    archive::pack(&folder, &dist.out)
}

/// The page for those who unpack the archive.
fn readme(triple: &str) -> String {
    let processor = if triple.starts_with("x86_64") {
        "`vellus-VERSION-TRIPLE` needs a processor with AVX2 and FMA: Intel since 2013 (Haswell), AMD since 2015 \
         (Excavator). On an\nolder processor it exits with a message. `vellus-VERSION-TRIPLE-baseline` runs on every \
         x86-64 processor. It takes\n1.2 to 2 times as long."
    } else {
        "There is one archive for this platform."
    };
    let libraries = if triple.contains("linux") {
        format!("The archives for Linux need glibc {} or later.", super::toolchain::GLIBC)
    } else {
        "The command needs no other libraries than those of the system.".to_owned()
    };
    let text = include_str!("command.md").replace("PROCESSOR", processor).replace("LIBRARIES", &libraries);
    text.replace("VERSION", VERSION).replace("TRIPLE", triple)
}

/// Copies a file and makes the folder that it goes to.
pub fn copy(from: &Path, to: &Path) -> Result<(), String> {
    let copied = std::fs::create_dir_all(to.parent().unwrap_or(to)).and_then(|()| std::fs::copy(from, to));
    copied.map(|_| ()).map_err(|e| format!("{} to {}: {e}", from.display(), to.display()))
}
