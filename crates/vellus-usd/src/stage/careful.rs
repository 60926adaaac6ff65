//! A look at each layer before `openusd` decodes it.

use super::guarded;
use crate::crate_check::{check_tables, check_value};
use openusd::{ar, usdc};
use std::io::{self, Cursor, Read, Seek, SeekFrom};

/// Far more than a scene has, far less than a stack holds.
const DEEPEST_BRACKETS: u32 = 500;

/// Finds files as `openusd` does, and refuses layers that its decoders would not survive.
#[derive(Default)]
pub(super) struct Careful(ar::DefaultResolver);

impl ar::Resolver for Careful {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ar::ResolvedPath>) -> String {
        self.0.create_identifier(asset_path, anchor)
    }

    fn resolve(&self, asset_path: &str) -> Option<ar::ResolvedPath> {
        self.0.resolve(asset_path)
    }

    fn resolve_for_new_asset(&self, asset_path: &str) -> Option<ar::ResolvedPath> {
        self.0.resolve_for_new_asset(asset_path)
    }

    fn open_asset(&self, path: &ar::ResolvedPath) -> io::Result<Box<dyn ar::Asset>> {
        let bytes = self.0.open_asset(path)?.read_all()?;
        check(&bytes).map_err(|what| io::Error::new(io::ErrorKind::InvalidData, format!("broken layer: {what}")))?;
        Ok(Box::new(Bytes(Cursor::new(bytes))))
    }

    fn identity(&self) -> String {
        self.0.identity()
    }
}

/// The content of a file, which is handed on without a copy.
struct Bytes(Cursor<Vec<u8>>);

impl Read for Bytes {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer)
    }
}

impl Seek for Bytes {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

impl ar::Asset for Bytes {
    fn size(&self) -> io::Result<u64> {
        Ok(self.0.get_ref().len() as u64)
    }

    fn read_all(&mut self) -> io::Result<Vec<u8>> {
        if self.0.position() == 0 {
            return Ok(std::mem::take(self.0.get_mut()));
        }
        let mut rest = Vec::new();
        self.0.read_to_end(&mut rest)?;
        Ok(rest)
    }
}

/// Looks at a layer before it is decoded.
fn check(bytes: &[u8]) -> Result<(), String> {
    if bytes.starts_with(usdc::MAGIC) {
        check_tables(bytes)?;
        let tables = guarded(|| Ok(usdc::CrateFile::open(Cursor::new(bytes))?))?;
        return tables.fields.iter().try_for_each(|field| check_value(bytes, field.value_rep.0));
    }
    if bytes.starts_with(b"#usda") {
        // The parser calls itself for whatever is in brackets.
        let mut depth = 0u32;
        for byte in bytes {
            match byte {
                b'(' | b'[' | b'{' => depth += 1,
                b')' | b']' | b'}' => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth > DEEPEST_BRACKETS {
                return Err(format!("it has more than {DEEPEST_BRACKETS} brackets in one another"));
            }
        }
    }
    Ok(())
}
