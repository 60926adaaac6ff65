//! Archives whose bytes depend only on what is in them: no times, no owners, a fixed order.

use flate2::Compression;
use flate2::write::GzEncoder;
use std::fs::File;
use std::io::{Result, Write, copy};
use std::path::{Path, PathBuf};
use tar::{Builder, Header, HeaderMode};
use zip::write::SimpleFileOptions;

/// Packs a folder, as `NAME.zip` on Windows and as `NAME.tar.gz` elsewhere. The folder is the only entry at the top.
pub fn pack(folder: &Path, into: &Path) -> std::result::Result<PathBuf, String> {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let file = into.join(format!("{name}.{}", if cfg!(windows) { "zip" } else { "tar.gz" }));
    let packed = if cfg!(windows) { zip(folder, &file) } else { tar(folder, &file) };
    packed.map(|()| file.clone()).map_err(|e| format!("{}: {e}", file.display()))
}

/// Packs a folder as a compressed tar file, with symbolic links as links.
fn tar(folder: &Path, file: &Path) -> Result<()> {
    let mut archive = Builder::new(GzEncoder::new(File::create(file)?, Compression::best()));
    archive.mode(HeaderMode::Deterministic);
    for (path, name) in files(folder)? {
        if path.is_symlink() {
            let mut header = Header::new_gnu();
            header.set_metadata_in_mode(&path.symlink_metadata()?, HeaderMode::Deterministic);
            archive.append_link(&mut header, name, path.read_link()?)?;
        } else {
            archive.append_path_with_name(path, name)?;
        }
    }
    archive.into_inner()?.finish()?.flush()
}

/// Packs a folder as a zip file.
pub fn zip(folder: &Path, file: &Path) -> Result<()> {
    let mut archive = zip::ZipWriter::new(File::create(file)?);
    for (path, name) in files(folder)? {
        // Zip files have names with slashes on all systems.
        let name = name.to_string_lossy().replace('\\', "/");
        archive.start_file(name, SimpleFileOptions::default())?;
        copy(&mut File::open(path)?, &mut archive)?;
    }
    archive.finish()?.flush()
}

/// All files of a folder, sorted: each path, and its name in the archive.
fn files(folder: &Path) -> Result<Vec<(PathBuf, PathBuf)>> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in next.read_dir()? {
            let path = entry?.path();
            if path.is_dir() && !path.is_symlink() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder.parent().unwrap_or(folder)).unwrap_or(&path).to_owned();
                files.push((path, name));
            }
        }
    }
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_depend_on_names_and_contents_only() {
        let folder = std::env::temp_dir().join(format!("vellus-archive-{}", std::process::id()));
        let bytes = |content: &str| {
            let inner = folder.join("vellus/share");
            std::fs::create_dir_all(&inner).unwrap();
            for name in ["b", "a"] {
                std::fs::write(inner.join(name), content).unwrap();
            }
            tar(&folder.join("vellus"), &folder.join("x.tar.gz")).unwrap();
            zip(&folder.join("vellus"), &folder.join("x.zip")).unwrap();
            let bytes = ["x.tar.gz", "x.zip"].map(|name| std::fs::read(folder.join(name)).unwrap());
            std::fs::remove_dir_all(&folder).unwrap();
            bytes
        };
        let first = bytes("one");
        std::thread::sleep(std::time::Duration::from_millis(1100));
        assert_eq!(first, bytes("one"));
        assert_ne!(first, bytes("two"));
    }
}
