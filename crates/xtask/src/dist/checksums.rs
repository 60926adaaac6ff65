//! The file SHA256SUMS, which `sha256sum --check` reads.

use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::path::Path;

/// The name of the file.
pub const FILE: &str = "SHA256SUMS";

/// A line for each other file of the folder, sorted by name.
pub fn of(folder: &Path) -> Result<String, String> {
    let mut lines = String::new();
    let entries = folder.read_dir().map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut names: Vec<_> = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    for name in names.iter().filter(|name| *name != FILE) {
        let bytes = std::fs::read(folder.join(name)).map_err(|e| format!("{name}: {e}"))?;
        writeln!(lines, "{}  {name}", hexadecimal(&bytes)).map_err(|e| e.to_string())?;
    }
    Ok(lines)
}

/// Writes the file.
pub fn write(folder: &Path) -> Result<(), String> {
    std::fs::write(folder.join(FILE), of(folder)?).map_err(|e| format!("{FILE}: {e}"))
}

/// The SHA-256 of bytes, in hexadecimal digits.
fn hexadecimal(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_hash_is_that_of_the_standard() {
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(super::hexadecimal(b"abc"), expected, "FIPS 180-2, B.1");
    }
}
