//! How the files of a release are compiled: on Linux with zig as the linker, for an older glibc than this machine's.

use crate::bindings::venv;
use crate::run::{Outcome, output};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The oldest glibc that the files for Linux run with: RHEL 8, Debian 10 and Ubuntu 18.10 have it.
pub const GLIBC: &str = "2.28";

/// maturin makes Python's packages. The others link for [`GLIBC`].
const PACKAGES: [&str; 3] = ["maturin==1.16.0", "cargo-zigbuild==0.24.1", "ziglang==0.17.1"];

/// The compiler and its linker.
pub struct Toolchain {
    root: PathBuf,
    /// Such as `x86_64-unknown-linux-gnu`.
    pub triple: String,
    /// An interpreter with [`PACKAGES`], or why there is none.
    pub python: Result<PathBuf, String>,
}

impl Toolchain {
    /// Asks the compiler for its triple, and installs what is missing into an environment in `target`.
    pub fn new(root: &Path) -> Result<Self, String> {
        let version = output(Command::new("rustc").arg("-vV"))?;
        let triple = version.lines().find_map(|line| line.strip_prefix("host: "));
        let triple = triple.ok_or("rustc -vV names no host")?.to_owned();
        let packages = if cfg!(target_os = "linux") { &PACKAGES[..] } else { &PACKAGES[..1] };
        let python = venv::supported().and_then(|interpreter| venv::venv(root, "dist", &interpreter, packages));
        Ok(Self { root: root.to_owned(), triple, python })
    }

    /// The folder of the programs in the environment, if zig links.
    fn zig(&self) -> Option<&Path> {
        let python = self.python.as_deref().ok().filter(|_| cfg!(target_os = "linux"));
        python.and_then(Path::parent)
    }

    /// Whether files for Linux run with [`GLIBC`].
    pub fn outcome(&self) -> Outcome {
        match &self.python {
            Err(reason) => Outcome::Skipped(format!("the files will need the glibc of this machine: {reason}")),
            Ok(_) if self.zig().is_none() => Outcome::Skipped("only files for Linux need it".to_owned()),
            Ok(_) => Outcome::Passed,
        }
    }

    /// Cargo's command `build` or `rustc`, in release mode and stripped. Each `folder` keeps the files of one set of
    /// compiler flags.
    pub fn cargo(&self, command: &str, folder: &str) -> Command {
        let mut cargo = match self.zig() {
            Some(programs) => {
                let mut cargo = Command::new(programs.join("cargo-zigbuild"));
                cargo.arg(if command == "build" { "zigbuild" } else { command });
                cargo.args(["--target", &format!("{}.{GLIBC}", self.triple)]);
                cargo
            }
            None => {
                let mut cargo = Command::new("cargo");
                cargo.args([command, "--target", &self.triple]);
                cargo
            }
        };
        cargo.args(["--release", "--target-dir"]).arg(self.folder(folder));
        self.settings(&mut cargo);
        cargo
    }

    /// maturin, in the folder of the Python package.
    ///
    /// # Errors
    /// The reason why there is none.
    pub fn maturin(&self, command: &str) -> Result<Command, String> {
        let mut maturin = Command::new(self.python.as_deref().map_err(Clone::clone)?);
        maturin.args(["-m", "maturin", command]);
        if command == "build" {
            maturin.args(["--release", "--target-dir"]).arg(self.folder("build"));
            if self.zig().is_some() {
                let tag = format!("manylinux_{}", GLIBC.replace('.', "_"));
                maturin.args(["--zig", "--compatibility", &tag]);
            }
        }
        self.settings(&mut maturin);
        maturin.current_dir(self.root.join("crates/vellus-python"));
        Ok(maturin)
    }

    /// Where [`Toolchain::cargo`] puts programs and libraries.
    pub fn release(&self, folder: &str) -> PathBuf {
        self.folder(folder).join(&self.triple).join("release")
    }

    fn folder(&self, name: &str) -> PathBuf {
        self.root.join("target/dist").join(name)
    }

    /// No symbols, and zig in the search path.
    fn settings(&self, command: &mut Command) {
        command.env("CARGO_PROFILE_RELEASE_STRIP", "symbols").current_dir(&self.root);
        if let Some(programs) = self.zig() {
            let path = std::env::var_os("PATH").unwrap_or_default();
            let folders = std::iter::once(programs.to_owned()).chain(std::env::split_paths(&path));
            command.env("PATH", std::env::join_paths(folders).unwrap_or(path.clone()));
        }
    }
}
