//! Checks each layer before `openusd` decodes it.

use super::arc_list::MOST_ARCS;
use super::arcs::{Arc, LayerArcs, absolute};
use super::files::{Files, MATERIALX};
use super::materialx::to_usda;
use super::names::{check_default, check_expression, check_name, check_path};
use super::old_crate::{version, with_new_tables, with_new_values};
use super::repair::{Repairs, repaired};
use super::text::{Content, Text, normalized};
use super::usdc_check::{check_tables, check_values, times};
use super::{Failure, guarded};
use crate::error::Invalid;
use crate::image::{TILES, UDIM, tile_name};
use openusd::ar::Resolver;
use openusd::{ar, sdf, usda, usdc};
use std::cell::RefCell;
use std::collections::HashMap;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::rc::Rc;
use vellus_io::Digest;

/// Resolves files as `openusd` does, and rejects layers that would crash its decoders.
#[derive(Default)]
pub(super) struct Careful {
    files: Rc<Files>,
    /// Binary layers that were checked, and whether they have empty arrays of strings.
    checked: RefCell<HashMap<Digest, (Content, bool)>>,
    /// Layers that cannot be read, and why. Composition asks again for each reference.
    broken: RefCell<HashMap<String, String>>,
}

impl Careful {
    pub fn new(files: Rc<Files>) -> Self {
        Careful { files, ..Self::default() }
    }

    /// The bytes of a layer in a form that `openusd` can read.
    fn layer(&self, path: &str) -> io::Result<Vec<u8>> {
        let mut bytes = self.files.layer(path)?;
        let broken = |what: Invalid| io::Error::new(io::ErrorKind::InvalidData, format!("broken layer: {what}"));
        if path.ends_with(MATERIALX) && !bytes.starts_with(b"#usda") {
            bytes = to_usda(&bytes).map_err(broken)?.into_bytes();
        }
        let Text { bytes, content } = if bytes.starts_with(usdc::MAGIC) {
            let mut bytes = renewed(bytes).map_err(broken)?;
            let digest = Digest::of(&bytes);
            let known = self.checked.borrow().get(&digest).cloned();
            let (content, has_empty) = known.map_or_else(|| check(&bytes), Ok).map_err(broken)?;
            if has_empty {
                bytes = with_renewed_values(bytes).map_err(broken)?;
            }
            self.checked.borrow_mut().insert(digest, (content.clone(), has_empty));
            Text { bytes, content }
        } else {
            if !path.ends_with(MATERIALX) {
                self.files.note_text(path);
            }
            normalized(bytes).map_err(broken)?
        };
        self.files.note_content(path, content).map_err(broken)?;
        Ok(bytes)
    }

    fn find(&self, asset_path: &str) -> Option<ar::ResolvedPath> {
        if let Some((_, end)) = asset_path.rsplit_once(UDIM) {
            // Tiles have one path, which exists if one of them does.
            let (number, found) = TILES.into_iter().find_map(|n| Some((n, self.find(&tile_name(asset_path, n))?)))?;
            let found = found.to_string_lossy();
            let start = found.strip_suffix(end)?.strip_suffix(&number.to_string())?;
            return Some(ar::ResolvedPath::new(format!("{start}{UDIM}{end}")));
        }
        let (package, inner) = match ar::split_package_relative_path_outer(asset_path) {
            Some((package, inner)) => (package, Some(inner)),
            None if asset_path.to_ascii_lowercase().ends_with(".usdz") => (asset_path.to_owned(), None),
            None => {
                let file = self.files.disk.resolve(asset_path)?;
                let is_materialx = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mtlx"));
                return Some(match is_materialx {
                    true => ar::ResolvedPath::new(format!("{}{MATERIALX}", file.to_string_lossy())),
                    false => file,
                });
            }
        };
        let package = self.files.disk.resolve(&package)?;
        // Opening a package reports its errors.
        let Ok(directory) = self.files.package(&package) else { return Some(package) };
        // The root layer of a package: `openusd` would read the whole package to find it.
        let inner = match inner {
            Some(inner) => directory.contains(&inner).then_some(inner)?,
            None => directory.root()?.to_owned(),
        };
        Some(ar::ResolvedPath::new(ar::join_package_relative_path(&package.to_string_lossy(), &inner)))
    }
}

impl ar::Resolver for Careful {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ar::ResolvedPath>) -> String {
        let identifier = self.files.identifier(asset_path, anchor);
        if let Some(anchor) = anchor.filter(|_| !asset_path.is_empty()) {
            self.files.refer(&anchor.to_string_lossy(), asset_path, &identifier);
        }
        identifier
    }

    fn resolve(&self, asset_path: &str) -> Option<ar::ResolvedPath> {
        if let Some(known) = self.files.resolved.borrow().get(asset_path) {
            return known.clone();
        }
        let found = self.find(asset_path);
        self.files.resolved.borrow_mut().insert(asset_path.to_owned(), found.clone());
        found
    }

    fn resolve_for_new_asset(&self, asset_path: &str) -> Option<ar::ResolvedPath> {
        self.files.disk.resolve_for_new_asset(asset_path)
    }

    fn open_asset(&self, path: &ar::ResolvedPath) -> io::Result<Box<dyn ar::Asset>> {
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("usdz")) {
            // Only packages that are broken or have no layer get here: `find` resolves the layers of others.
            self.files.package(path)?;
            return Err(io::Error::new(io::ErrorKind::InvalidData, "broken package: it has no layer"));
        }
        let path = path.to_string_lossy();
        if let Some(what) = self.broken.borrow().get(&*path) {
            return Err(io::Error::new(io::ErrorKind::InvalidData, what.clone()));
        }
        let bytes = self.layer(&path).inspect_err(|error| {
            self.broken.borrow_mut().insert(path.clone().into_owned(), error.to_string());
        })?;
        Ok(Box::new(Bytes(Cursor::new(bytes))))
    }

    fn identity(&self) -> String {
        self.files.disk.identity()
    }
}

/// The content of a file, which is passed on without a copy.
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

/// The text layers with a syntax error, and messages with its position. The errors of `openusd` have neither.
pub(super) fn parse_errors(files: &Files) -> Vec<(String, String)> {
    let errors = files.texts().into_iter().filter_map(|path| {
        let bytes = match normalized(files.layer(&path).ok()?) {
            Ok(text) => text.bytes,
            Err(what) => return Some((path, what.0)),
        };
        let what = match String::from_utf8(bytes) {
            Ok(text) => error_of(&text)?,
            Err(error) => format!("it is not UTF-8 text (byte {})", error.utf8_error().valid_up_to()),
        };
        Some((path, what))
    });
    errors.collect()
}

/// The text layers with a syntax error in a form without the properties that cause it, where there is one.
pub(super) fn repairs(files: &Files) -> Repairs {
    let mut all = files.repairs.clone();
    for (path, _) in parse_errors(files) {
        let text = files.layer(&path).ok().and_then(|bytes| String::from_utf8(normalized(bytes).ok()?.bytes).ok());
        let name = path.trim_end_matches(MATERIALX).trim_end_matches(']').rsplit(['/', '[']).next().unwrap_or_default();
        if !all.0.contains_key(&path)
            && let Some(repaired) = text.and_then(|text| repaired(text, name))
        {
            all.0.insert(path, repaired);
        }
    }
    all
}

/// The syntax error of a text, with its line and column.
fn error_of(text: &str) -> Option<String> {
    let mut parser = usda::parser::Parser::new(text);
    let parsed = guarded(|| parser.parse().map_err(|error| Failure(error.root_cause().to_string())));
    let cause = parsed.err()?.0;
    // Removes the name of the unexpected token, which is an identifier of the parser's code.
    let cause = [", got ", " Some(", " Ok("]
        .into_iter()
        .fold(cause.as_str(), |cause, found| cause.split_once(found).map_or(cause, |(cause, _)| cause));
    let cause = if cause.starts_with("Logos error") { "this is no word, number, string or path" } else { cause };
    let cause = vellus_io::excerpt(cause.as_bytes(), 80);
    Some(match guarded(|| Ok(parser.last_error_highlight())).ok().flatten() {
        Some(place) => {
            let found: String = place.line_text.chars().skip(place.column - 1).collect();
            let found = vellus_io::excerpt(found.as_bytes(), 40);
            format!("line {}, column {}: {cause}: found '{found}'", place.line, place.column)
        }
        None => cause,
    })
}

/// A binary layer of an old version in a form that `openusd` reads.
fn renewed(bytes: Vec<u8>) -> Result<Vec<u8>, Invalid> {
    if version(&bytes)? >= [0, 7, 0] {
        return Ok(bytes);
    }
    with_renewed_values(with_new_tables(bytes)?)
}

/// A binary layer whose values `openusd` reads.
fn with_renewed_values(bytes: Vec<u8>) -> Result<Vec<u8>, Invalid> {
    check_tables(&bytes)?;
    let file = guarded(|| Ok(usdc::CrateFile::open(Cursor::new(&bytes))?))?;
    let fields: Vec<_> = file.fields.iter().map(|field| (field.token_index, field.value_rep.0)).collect();
    let renewed = with_new_values(&bytes, &fields)?;
    Ok(renewed.unwrap_or(bytes))
}

/// Checks a binary layer before it is decoded.
fn check(bytes: &[u8]) -> Result<(Content, bool), Invalid> {
    check_tables(bytes)?;
    let mut file = guarded(|| Ok(usdc::CrateFile::open(Cursor::new(bytes))?))?;
    let values = || file.fields.iter().map(|field| field.value_rep.0);
    let has_empty = check_values(bytes, values())?;
    let times = times(bytes, values())?;
    file.paths.iter().try_for_each(|path| check_path(path.as_str()))?;
    file.tokens.iter().try_for_each(|token| check_expression(token).map(|_| ()))?;
    let (mut variables, mut arcs) = (0, LayerArcs::default());
    let mut has_arcs = false;
    for i in 0..file.fields.len() {
        let value = file.fields[i].value_rep;
        let name = file.tokens.get(file.fields[i].token_index).cloned().unwrap_or_default();
        if !matches!(
            name.as_str(),
            "primChildren"
                | "defaultPrim"
                | "inheritPaths"
                | "specializes"
                | "references"
                | "payload"
                | "subLayers"
                | "expressionVariables"
        ) {
            continue;
        }
        let count = match guarded(|| Ok(file.value(value)?))? {
            sdf::Value::TokenVec(names) => {
                names.iter().try_for_each(|name| check_name(name.as_str()))?;
                0
            }
            sdf::Value::Dictionary(values) => {
                for value in values.values().filter_map(sdf::Value::as_str) {
                    variables += check_expression(value)?;
                }
                0
            }
            sdf::Value::PathListOp(list) => items(&list),
            sdf::Value::ReferenceListOp(list) => items(&list),
            sdf::Value::PayloadListOp(list) => items(&list),
            sdf::Value::StringVec(layers) => layers.len(),
            other => other.as_str().map_or(Ok(0), |prim| check_default(prim).map(|()| 0))?,
        };
        has_arcs |= count > 0;
        if count > MOST_ARCS {
            return Err(format!("a prim or layer has more than {MOST_ARCS} {name}").into());
        }
    }
    for value in times {
        let mut rep = file.fields[0].value_rep;
        rep.0 = value;
        let increase = match guarded(|| Ok(file.value(rep)?))? {
            sdf::Value::DoubleVec(times) => {
                times.iter().all(|time| time.is_finite()) && times.is_sorted_by(|a, b| a < b)
            }
            _ => false,
        };
        if !increase {
            return Err("the times of time samples must be finite, and each later than the one before".into());
        }
    }
    if has_arcs {
        for i in 0..file.specs.len() {
            add_arcs(&mut file, i, &mut arcs)?;
        }
    }
    let unread = splines(&file);
    Ok((Content { arcs: Rc::new(arcs), variables, splines: false, unread }, has_empty))
}

/// The attributes with a spline.
fn splines(file: &usdc::CrateFile<Cursor<&[u8]>>) -> Vec<String> {
    let Some(token) = file.tokens.iter().position(|token| token == "spline") else { return Vec::new() };
    let has_spline = |fieldset: usize| {
        let fields = file.fieldsets.get(fieldset..).unwrap_or_default().iter().map_while(|field| *field);
        fields.filter_map(|field| file.fields.get(field)).any(|field| field.token_index == token)
    };
    let specs = file.specs.iter().filter(|spec| has_spline(spec.fieldset_index));
    specs.filter_map(|spec| Some(file.paths.get(spec.path_index)?.as_str().to_owned())).collect()
}

/// Adds the arcs of a prim, or of the variant of one.
fn add_arcs(file: &mut usdc::CrateFile<Cursor<&[u8]>>, spec: usize, arcs: &mut LayerArcs) -> Result<(), Invalid> {
    let spec = &file.specs[spec];
    let (Some(path), Some(fields)) = (file.paths.get(spec.path_index), file.fieldsets.get(spec.fieldset_index..))
    else {
        return Ok(());
    };
    let prim = absolute("", path.as_str());
    for i in fields.iter().map_while(|field| *field).collect::<Vec<_>>() {
        let Some((name, value)) = file.fields.get(i).map(|field| (field.token_index, field.value_rep)) else {
            continue;
        };
        let name = file.tokens.get(name).map_or("", |name| name);
        let is_class = matches!(name, "inheritPaths" | "specializes");
        if !is_class && !matches!(name, "references" | "payload" | "subLayers" | "defaultPrim") {
            continue;
        }
        let mut add = |layer: &str, target: &sdf::Path| {
            let layer = (!layer.is_empty()).then(|| layer.to_owned());
            let target = (!target.is_empty()).then(|| target.as_str().to_owned());
            arcs.add(prim.clone(), Arc { is_class, layer, prim: target });
        };
        match guarded(|| Ok(file.value(value)?))? {
            sdf::Value::PathListOp(list) => list.iter().for_each(|target| add("", target)),
            sdf::Value::ReferenceListOp(list) => list.iter().for_each(|to| add(&to.asset_path, &to.prim_path)),
            sdf::Value::PayloadListOp(list) => list.iter().for_each(|to| add(&to.asset_path, &to.prim_path)),
            sdf::Value::Payload(to) => add(&to.asset_path, &to.prim_path),
            sdf::Value::StringVec(layers) => arcs.sublayers.extend(layers),
            other => arcs.default_prim = other.as_str().map(str::to_owned),
        }
    }
    Ok(())
}

/// The number of items of a list of edits.
fn items<T: Default + Clone + PartialEq>(list: &sdf::ListOp<T>) -> usize {
    let lists = [&list.explicit_items, &list.prepended_items, &list.appended_items, &list.added_items];
    lists.iter().map(|list| list.len()).sum::<usize>() + list.deleted_items.len() + list.ordered_items.len()
}
