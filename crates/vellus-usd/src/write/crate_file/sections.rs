//! The tables at the end of a crate file.

use crate::write::crate_file::integers::{lz4, pack_integers};
use crate::write::crate_file::tables::Tables;
use crate::write::crate_file::{Heap, SpecEntry};
use std::io;

/// Writes the tables and then their table of contents. Returns the position of the latter.
///
/// A field is a token and a value. Each set of fields ends with the index −1.
pub(crate) fn write_sections(
    heap: &mut Heap,
    fields: &[(u32, u64)],
    sets: &[u32],
    specs: &[SpecEntry],
) -> io::Result<u64> {
    let tokens: Vec<u8> =
        heap.tables.tokens.entries().iter().flat_map(|token| [token.as_bytes(), b"\0"].concat()).collect();
    let strings = heap.tables.strings.entries();
    let representations: Vec<u8> = fields.iter().flat_map(|(_, value)| value.to_le_bytes()).collect();
    let column =
        |number: fn(&SpecEntry) -> u32| pack_integers(specs.iter().map(move |spec| number(spec).cast_signed()));
    let sections = [
        ("TOKENS", vec![size(heap.tables.tokens.entries().len()), size(tokens.len()), lz4(&tokens)]),
        ("STRINGS", vec![size(strings.len()), strings.iter().flat_map(|token| token.to_le_bytes()).collect()]),
        (
            "FIELDS",
            vec![
                size(fields.len()),
                pack_integers(fields.iter().map(|(token, _)| token.cast_signed())),
                lz4(&representations),
            ],
        ),
        ("FIELDSETS", vec![size(sets.len()), pack_integers(sets.iter().map(|field| field.cast_signed()))]),
        ("PATHS", paths(&heap.tables)),
        ("SPECS", vec![size(specs.len()), column(|spec| spec.path), column(|spec| spec.set), column(|spec| spec.kind)]),
    ];
    let mut contents = size(sections.len());
    for (name, parts) in sections {
        let bytes = parts.concat();
        let mut padded = [0; 16];
        padded[..name.len()].copy_from_slice(name.as_bytes());
        contents.extend([&padded[..], &heap.at.to_le_bytes(), &size(bytes.len())].concat());
        heap.write(&bytes)?;
    }
    let position = heap.at;
    heap.write(&contents)?;
    Ok(position)
}

fn size(size: usize) -> Vec<u8> {
    (size as u64).to_le_bytes().to_vec()
}

/// The tree of paths, parents before their children.
fn paths(tables: &Tables) -> Vec<Vec<u8>> {
    let entries = tables.paths.entries();
    let mut children = vec![Vec::new(); entries.len()];
    for (path, (parent, _)) in entries.iter().enumerate().skip(1) {
        children[*parent as usize].push(path);
    }
    let mut tree = Tree { entries, children, columns: Default::default() };
    tree.add(0, false);
    let columns = tree.columns.map(|column| pack_integers(column.into_iter()));
    [size(entries.len()), size(entries.len())].into_iter().chain(columns).collect()
}

struct Tree<'a> {
    entries: &'a [(u32, i32)],
    children: Vec<Vec<usize>>,
    /// Paths, their tokens, and where the next sibling is.
    columns: [Vec<i32>; 3],
}

impl Tree<'_> {
    /// Adds a path and what is below it.
    fn add(&mut self, path: usize, has_sibling: bool) {
        let at = self.columns[0].len();
        for (column, number) in self.columns.iter_mut().zip([path as i32, self.entries[path].1, 0]) {
            column.push(number);
        }
        let children = std::mem::take(&mut self.children[path]);
        for (i, child) in children.iter().enumerate() {
            self.add(*child, i + 1 < children.len());
        }
        self.columns[2][at] = match (children.is_empty(), has_sibling) {
            (true, true) => 0,
            (true, false) => -2,
            (false, false) => -1,
            // The distance to the sibling, which comes after the descendants.
            (false, true) => (self.columns[0].len() - at) as i32,
        };
    }
}
