//! A look at each layer before `openusd` decodes it.

use super::guarded;
use super::names::{check_default, check_name, check_path};
use super::text_check::check_text;
use crate::crate_check::{check_tables, check_values};
use openusd::{ar, sdf, usdc};
use std::io::{self, Cursor, Read, Seek, SeekFrom};

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
        let mut file = guarded(|| Ok(usdc::CrateFile::open(Cursor::new(bytes))?))?;
        check_values(bytes, file.fields.iter().map(|field| field.value_rep.0))?;
        file.paths.iter().try_for_each(|path| check_path(path.as_str()))?;
        let name_of = |index: usize| file.tokens.get(index).map_or("", String::as_str);
        let names =
            file.fields.iter().filter(|field| matches!(name_of(field.token_index), "primChildren" | "defaultPrim"));
        let names: Vec<_> = names.map(|field| field.value_rep).collect();
        for value in names {
            match guarded(|| Ok(file.value(value)?))? {
                sdf::Value::TokenVec(names) => names.iter().try_for_each(|name| check_name(name.as_str()))?,
                other => other.as_str().map_or(Ok(()), check_default)?,
            }
        }
        return Ok(());
    }
    // A package is read by what is in it.
    if bytes.starts_with(b"PK") { Ok(()) } else { check_text(bytes) }
}
