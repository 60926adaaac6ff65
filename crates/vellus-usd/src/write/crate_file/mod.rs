//! Writes the binary format of USD (.usdc), which OpenUSD calls crate files, in version 0.8.
//!
//! A file has a header, values, and six tables: tokens, strings, fields (a name and a value), sets of fields, paths,
//! and specs. A spec is a prim or property: its path and its set of fields.

mod heap;
mod integers;
mod sections;
mod tables;

pub(crate) use heap::Heap;
pub(crate) use integers::{MOST_BYTES, lz4, pack_floats, pack_integers};
pub(crate) use tables::Tables;

use crate::write::encoder::{Encoder, Role};
use crate::write::value::{Token, Value};
use heap::inlined;
use std::io::{self, Write};
use tables::{ROOT, Table};

/// Numbers of the types that only fields have.
mod kind {
    pub const TOKEN_LIST_EDITS: u64 = 32;
    pub const PATH_LIST_EDITS: u64 = 34;
    pub const TOKENS: u64 = 41;
    pub const SPECIFIER: u64 = 42;
    pub const VARIABILITY: u64 = 44;
    pub const TIME_SAMPLES: u64 = 46;
    pub const DOUBLES: u64 = 48;
}

/// The kinds of specs.
const ATTRIBUTE: u32 = 1;
const PRIM: u32 = 6;
const LAYER: u32 = 7;
const RELATIONSHIP: u32 = 8;

/// Flags of lists of edits: the list is explicit and has items; items are prepended.
const EXPLICIT: u8 = 0b11;
const PREPENDED: u8 = 1 << 5;

/// Writes a layer. `fill` makes it, and is called twice with the same result: the header has the position of the table
/// of contents, which only the whole file tells, and a pipe cannot be rewound.
pub(crate) fn write(out: &mut dyn Write, fill: impl Fn(&mut dyn Encoder) -> io::Result<()>) -> io::Result<()> {
    let position = layer(&mut io::sink(), 0, &fill)?;
    layer(out, position, &fill).map(|_| ())
}

/// Writes a layer. Returns the position of its table of contents.
fn layer(out: &mut dyn Write, contents: u64, fill: impl Fn(&mut dyn Encoder) -> io::Result<()>) -> io::Result<u64> {
    let mut heap = Heap::new(out);
    let version = [0, 8, 0, 0, 0, 0, 0, 0];
    let unused = [0; 64];
    heap.write(&[&b"PXR-USDC"[..], &version, &contents.to_le_bytes(), &unused].concat())?;
    let root =
        Prim { spec: Spec { path: ROOT, kind: LAYER, fields: Vec::new() }, children: vec![], properties: vec![] };
    let (fields, sets, specs) = (Table::new(), Vec::new(), Vec::new());
    let mut file = Crate { heap, fields, sets, specs, prims: vec![root], property: None };
    fill(&mut file)?;
    file.close()?;
    // In the order in which the paths were met.
    file.specs.sort_unstable_by_key(|spec| spec.path);
    sections::write_sections(&mut file.heap, file.fields.entries(), &file.sets, &file.specs)
}

/// A row of the table of specs.
pub(crate) struct SpecEntry {
    path: u32,
    /// The index of its first field.
    set: u32,
    kind: u32,
}

/// A prim or property whose fields may not be complete.
struct Spec {
    path: u32,
    kind: u32,
    fields: Vec<(u32, u64)>,
}

/// An open prim, with the tokens of what is in it.
struct Prim {
    spec: Spec,
    children: Vec<u32>,
    properties: Vec<u32>,
}

struct Crate<'a> {
    heap: Heap<'a>,
    fields: Table<(u32, u64)>,
    sets: Vec<u32>,
    specs: Vec<SpecEntry>,
    /// The open prims, from the layer to the innermost one.
    prims: Vec<Prim>,
    /// The last property of the innermost prim.
    property: Option<Spec>,
}

impl Crate<'_> {
    fn add(&mut self, spec: Spec) {
        let set = self.sets.len() as u32;
        self.sets.extend(spec.fields.into_iter().map(|field| self.fields.index(field)));
        self.sets.push(u32::MAX);
        self.specs.push(SpecEntry { path: spec.path, set, kind: spec.kind });
    }

    /// Adds a field to the last property, or without one to the innermost prim.
    fn field(&mut self, name: &str, value: u64) {
        let field = (self.heap.tables.token(name), value);
        match (&mut self.property, self.prims.last_mut()) {
            (Some(spec), _) | (None, Some(Prim { spec, .. })) => spec.fields.push(field),
            (None, None) => {}
        }
    }

    /// Stores a list of edits.
    fn edits(&mut self, kind: u64, flags: u8, items: &[u32]) -> io::Result<u64> {
        let count = (items.len() as u64).to_le_bytes();
        let items = items.iter().flat_map(|item| item.to_le_bytes());
        self.heap.place(kind, &[flags].into_iter().chain(count).chain(items).collect::<Vec<u8>>())
    }

    /// Stores the names of children, if there are any.
    fn children(&mut self, field: &str, tokens: &[u32]) -> io::Result<()> {
        if !tokens.is_empty() {
            let count = (tokens.len() as u64).to_le_bytes();
            let tokens = tokens.iter().flat_map(|token| token.to_le_bytes());
            let value = self.heap.place(kind::TOKENS, &count.into_iter().chain(tokens).collect::<Vec<u8>>())?;
            self.field(field, value);
        }
        Ok(())
    }

    fn end_property(&mut self) {
        if let Some(spec) = self.property.take() {
            self.add(spec);
        }
    }
}

impl Encoder for Crate<'_> {
    fn layer(&mut self, fields: &[(&str, &dyn Value)]) -> io::Result<()> {
        for (name, value) in fields {
            let value = value.store(&mut self.heap)?;
            self.field(if *name == "doc" { "documentation" } else { name }, value);
        }
        Ok(())
    }

    fn open(&mut self, kind: &str, name: &str, role: Role) -> io::Result<()> {
        self.end_property();
        let token = self.heap.tables.token(name);
        let Some(parent) = self.prims.last_mut() else { return Ok(()) };
        parent.children.push(token);
        let path = self.heap.tables.prim(parent.spec.path, name);
        self.prims.push(Prim { spec: Spec { path, kind: PRIM, fields: vec![] }, children: vec![], properties: vec![] });
        self.field("specifier", inlined(kind::SPECIFIER, if let Role::Class = role { 2 } else { 0 }));
        if !kind.is_empty() {
            let kind = Token(kind).store(&mut self.heap)?;
            self.field("typeName", kind);
        }
        match role {
            Role::Plain | Role::Class => {}
            Role::Applies(schema) => {
                let schema = self.heap.tables.token(schema);
                let schemas = self.edits(kind::TOKEN_LIST_EDITS, PREPENDED, &[schema])?;
                self.field("apiSchemas", schemas);
            }
            Role::Instance(class) => {
                let instanceable = true.store(&mut self.heap)?;
                self.field("instanceable", instanceable);
                let class = self.heap.tables.path(class);
                let classes = self.edits(kind::PATH_LIST_EDITS, EXPLICIT, &[class])?;
                self.field("inheritPaths", classes);
            }
        }
        Ok(())
    }

    fn close(&mut self) -> io::Result<()> {
        self.end_property();
        let Some(prim) = self.prims.last_mut() else { return Ok(()) };
        let (children, properties) = (std::mem::take(&mut prim.children), std::mem::take(&mut prim.properties));
        self.children("primChildren", &children)?;
        self.children("properties", &properties)?;
        if let Some(prim) = self.prims.pop() {
            self.add(prim.spec);
        }
        Ok(())
    }

    fn declare(&mut self, declaration: &str) -> io::Result<()> {
        let mut words = declaration.rsplit(' ');
        let (name, kind) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        let Some(prim) = self.prims.last_mut() else { return Ok(()) };
        let path = self.heap.tables.property(prim.spec.path, name);
        if self.property.as_ref().is_some_and(|property| property.path == path) {
            return Ok(());
        }
        prim.properties.push(self.heap.tables.token(name));
        self.end_property();
        let is_relationship = kind == "rel";
        let spec_kind = if is_relationship { RELATIONSHIP } else { ATTRIBUTE };
        self.property = Some(Spec { path, kind: spec_kind, fields: Vec::new() });
        if !is_relationship {
            let kind = Token(kind).store(&mut self.heap)?;
            self.field("typeName", kind);
        }
        let is_uniform = is_relationship || words.clone().any(|word| word == "uniform");
        self.field("variability", inlined(kind::VARIABILITY, u64::from(is_uniform)));
        let is_custom = words.any(|word| word == "custom").store(&mut self.heap)?;
        self.field("custom", is_custom);
        Ok(())
    }

    fn attribute(&mut self, declaration: &str, value: &dyn Value, interpolation: Option<&str>) -> io::Result<()> {
        self.declare(declaration)?;
        let value = value.store(&mut self.heap)?;
        self.field("default", value);
        if let Some(interpolation) = interpolation {
            let interpolation = Token(interpolation).store(&mut self.heap)?;
            self.field("interpolation", interpolation);
        }
        Ok(())
    }

    fn samples(&mut self, declaration: &str, opened: &dyn Value, closed: &dyn Value) -> io::Result<()> {
        self.declare(declaration)?;
        let [opened, closed] = [opened.store(&mut self.heap)?, closed.store(&mut self.heap)?];
        let times = [2u64.to_le_bytes(), 0f64.to_le_bytes(), 1f64.to_le_bytes()].concat();
        let times = self.heap.place(kind::DOUBLES, &times)?;
        // Distances lead to the times and to the values. Both follow at once.
        let samples = [8, times, 8, 2, opened, closed].map(u64::to_le_bytes).concat();
        let samples = self.heap.place(kind::TIME_SAMPLES, &samples)?;
        self.field("timeSamples", samples);
        Ok(())
    }

    fn connect(&mut self, declaration: &str, target: &str) -> io::Result<()> {
        self.declare(declaration)?;
        let target = self.heap.tables.path(target);
        let targets = self.edits(kind::PATH_LIST_EDITS, EXPLICIT, &[target])?;
        self.field("connectionPaths", targets);
        Ok(())
    }

    fn relate(&mut self, name: &str, targets: &[&str]) -> io::Result<()> {
        self.declare(&format!("rel {name}"))?;
        let targets: Vec<u32> = targets.iter().map(|target| self.heap.tables.path(target)).collect();
        let targets = self.edits(kind::PATH_LIST_EDITS, EXPLICIT, &targets)?;
        self.field("targetPaths", targets);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::write::value::Array;

    fn number(bytes: &[u8], at: u64) -> u64 {
        u64::from_le_bytes(*bytes[at as usize..].first_chunk().unwrap())
    }

    #[test]
    fn tables_follow_the_values_and_their_contents_end_the_file() {
        let points = || (0..50).map(|i| [i as f32, 0.5, -0.25]);
        let mut bytes = Vec::new();
        let fill = |out: &mut dyn Encoder| {
            out.layer(&[("upAxis", &Token("Y"))])?;
            out.open("BasisCurves", "a", Role::Plain)?;
            out.set("int[] curveVertexCounts", &Array([3u32; 20].into_iter()))?;
            out.set("point3f[] points", &Array(points()))?;
            out.close()
        };
        write(&mut bytes, fill).unwrap();
        assert_eq!(bytes[..16], *b"PXR-USDC\0\x08\0\0\0\0\0\0");
        let contents = number(&bytes, 16);
        assert_eq!((number(&bytes, contents), contents + 8 + 6 * 32), (6, bytes.len() as u64));
        let mut end = None;
        for (i, name) in ["TOKENS", "STRINGS", "FIELDS", "FIELDSETS", "PATHS", "SPECS"].into_iter().enumerate() {
            let entry = contents + 8 + 32 * i as u64;
            let found = bytes[entry as usize..][..16].split(|byte| *byte == 0).next().unwrap();
            let [start, size] = [16, 24].map(|at| number(&bytes, entry + at));
            assert_eq!(found, name.as_bytes());
            assert_eq!(start, end.unwrap_or(start));
            end = Some(start + size);
        }
        assert_eq!(end, Some(contents));
        // Points are as they are in memory, at a multiple of 8 bytes.
        let points: Vec<u8> = points().flatten().flat_map(f32::to_le_bytes).collect();
        let at = bytes.windows(points.len()).position(|window| window == points).unwrap();
        assert_eq!((at % 8, number(&bytes, at as u64 - 8)), (0, 50));
    }

    #[test]
    fn an_attribute_has_its_value_and_its_connection_in_one_spec() {
        let specs = |connect: bool| {
            let mut bytes = Vec::new();
            let fill = |out: &mut dyn Encoder| {
                out.open("Shader", "a", Role::Plain)?;
                out.set("float inputs:x", &1.0f32)?;
                if connect {
                    out.connect("float inputs:x", "/a.outputs:y")?;
                }
                out.declare("float outputs:y")?;
                out.close()
            };
            write(&mut bytes, fill).unwrap();
            let entry = number(&bytes, 16) + 8 + 5 * 32;
            number(&bytes, number(&bytes, entry + 16))
        };
        assert_eq!((specs(true), specs(false)), (4, 4));
    }
}
