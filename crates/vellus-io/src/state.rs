//! Files that a user's programs keep for later, and that nobody else may write.

use crate::confined;
use std::fs::{DirBuilder, Metadata};
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

/// The folder for what programs keep between runs: `$XDG_STATE_HOME/vellus`, or `~/.local/state/vellus`. On macOS, the
/// latter is `~/Library/Application Support/vellus`; on Windows, it is `%LOCALAPPDATA%\vellus`. It may not exist yet.
///
/// # Errors
/// [`ErrorKind::NotFound`] if the user has no home.
pub fn state_folder() -> Result<PathBuf> {
    let variable = if cfg!(windows) { "LOCALAPPDATA" } else { "XDG_STATE_HOME" };
    let given = std::env::var_os(variable).map(PathBuf::from).filter(|path| path.is_absolute());
    let home = || std::env::home_dir().filter(|path| path.is_absolute());
    let parts = match () {
        () if cfg!(windows) => "AppData/Local",
        () if cfg!(target_os = "macos") => "Library/Application Support",
        () => ".local/state",
    };
    let folder = given.or_else(|| Some(home()?.join(parts))).map(|folder| folder.join("vellus"));
    folder.ok_or_else(|| Error::new(ErrorKind::NotFound, format!("there is no home folder: set {variable}")))
}

/// Makes a folder private: creates it for this user alone if it is missing, and checks otherwise that no other user
/// owns it or can write to it. From then on, links in it are refused, as [`confine`](crate::confine) says.
///
/// # Errors
/// Errors of the operating system, and [`ErrorKind::PermissionDenied`] for a link, or a folder that others can change.
pub fn make_private(folder: &Path) -> Result<()> {
    if let Some(above) = folder.parent() {
        std::fs::create_dir_all(above)?;
    }
    let mut builder = DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    match builder.create(folder) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(error),
        _ => {}
    }
    let metadata = std::fs::symlink_metadata(folder)?;
    let refused = |what| Err(Error::new(ErrorKind::PermissionDenied, what));
    if !metadata.is_dir() {
        return refused("it is a link or no folder");
    }
    if !is_own(&metadata) {
        return refused("it belongs to another user");
    }
    #[cfg(unix)]
    if std::os::unix::fs::MetadataExt::mode(&metadata) & 0o022 != 0 {
        return refused("other users can write to it: remove this permission (chmod go-w)");
    }
    confined::confine(folder)
}

/// Whether a file belongs to the user of this program. On Windows, files of a private folder do.
pub fn is_own(metadata: &Metadata) -> bool {
    #[cfg(unix)]
    return std::os::unix::fs::MetadataExt::uid(metadata) == rustix::process::geteuid().as_raw();
    #[cfg(not(unix))]
    {
        let _ = metadata;
        true
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    #[test]
    fn a_private_folder_is_for_one_user() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mode = |name: &str| at(name).metadata().unwrap().permissions().mode() & 0o777;
        make_private(&at("new/state")).unwrap();
        make_private(&at("new/state")).unwrap();
        assert_eq!(mode("new/state"), 0o700);
        // Links in it are refused.
        symlink("../secret", at("new/state/film")).unwrap();
        assert!(crate::write(&at("new/state/film"), b"1").is_err() && !at("new/secret").exists());
        crate::write(&at("new/state/other"), b"1").unwrap();

        let refused = |name: &str, part: &str| {
            let error = make_private(&at(name)).unwrap_err();
            assert!(error.kind() == ErrorKind::PermissionDenied && error.to_string().contains(part), "{error}");
        };
        symlink("new/state", at("link")).unwrap();
        refused("link", "a link");
        std::fs::write(at("file"), "").unwrap();
        refused("file", "no folder");
        for bits in [0o777, 0o770, 0o702] {
            std::fs::create_dir_all(at("open")).unwrap();
            std::fs::set_permissions(at("open"), std::fs::Permissions::from_mode(bits)).unwrap();
            refused("open", "other users can write");
        }
        // The root folder belongs to root, whoever runs this.
        let foreign = Path::new("/").metadata().unwrap();
        assert_eq!(is_own(&foreign), rustix::process::geteuid().is_root());
    }
}
