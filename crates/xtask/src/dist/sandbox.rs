//! A place to try programs in that has nothing of this machine: an old Debian, or at least an empty environment.

use super::Dist;
use crate::run::{output, run, succeeds};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The oldest Debian that its servers still have. Its glibc is 2.31.
const DEBIAN: &str = "bullseye";

/// Where programs are tried.
pub enum Sandbox {
    /// The root folder of a Debian without any optional package.
    Debian(PathBuf),
    /// This machine, with an empty environment and an empty folder.
    Here(PathBuf),
}

impl Sandbox {
    /// The Debian, or why there is none. debootstrap downloads it once.
    pub fn debian(dist: &Dist) -> Result<Self, String> {
        if !succeeds(Command::new("debootstrap").arg("--version")) {
            return Err("no debootstrap".to_owned());
        }
        if output(Command::new("id").arg("-u"))?.trim() != "0" {
            return Err("debootstrap and chroot need root".to_owned());
        }
        let (root, complete) = (dist.folder(DEBIAN), dist.folder("debian-is-complete"));
        if !complete.exists() {
            std::fs::remove_dir_all(&root).ok();
            run(Command::new("debootstrap").args(["--variant=minbase", DEBIAN]).arg(&root))?;
            std::fs::write(&complete, DEBIAN).map_err(|e| format!("{}: {e}", complete.display()))?;
        }
        Ok(Self::Debian(root))
    }

    /// The empty folder where programs run, as this machine sees it.
    pub fn work(&self) -> PathBuf {
        match self {
            Self::Debian(root) => root.join("tmp"),
            Self::Here(folder) => folder.clone(),
        }
    }

    /// Unpacks an archive there.
    pub fn unpack(&self, archive: &Path) -> Result<(), String> {
        let folder = self.work();
        std::fs::remove_dir_all(&folder).ok();
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        run(Command::new("tar").arg("-xf").arg(archive).arg("-C").arg(folder))
    }

    /// A program of an unpacked archive, with no environment.
    pub fn program(&self, path: &Path) -> Command {
        match self {
            Self::Debian(root) => {
                let mut command = Command::new("chroot");
                command
                    .arg(root)
                    .args(["/usr/bin/env", "-i", "-C", "/tmp", "HOME=/tmp"])
                    .arg(Path::new("/tmp").join(path));
                command
            }
            Self::Here(folder) => {
                let mut command = Command::new(folder.join(path));
                command.env_clear().current_dir(folder);
                command
            }
        }
    }
}
