//! Values of attributes, with their forms in text and in crate files. Numbers read back to the same bits.

use crate::write::crate_file::{Heap, Tables, pack_floats, pack_integers};
use std::fmt::Write as _;
use std::io::{self, Write};

/// A value of an attribute or of metadata.
pub(crate) trait Value {
    /// Writes it as text.
    fn print(&self, out: &mut dyn Write) -> io::Result<()>;

    /// Writes it to a crate file. Returns its representation there.
    fn store(&self, heap: &mut Heap) -> io::Result<u64>;
}

/// A value that is no array, and may be an element of one.
pub(crate) trait Element {
    /// The number of its type in crate files.
    const KIND: u64;

    /// Appends its text. Writing to a string cannot fail.
    fn text(&self, text: &mut String);

    /// Appends its bytes in a crate file.
    fn bytes(&self, tables: &mut Tables, bytes: &mut Vec<u8>);

    /// The compressed form of an array, if there is one that is smaller.
    fn pack(_values: impl Iterator<Item = Self> + Clone) -> Option<Vec<u8>>
    where
        Self: Sized,
    {
        None
    }
}

impl<E: Element> Value for E {
    fn print(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut text = String::new();
        self.text(&mut text);
        out.write_all(text.as_bytes())
    }

    fn store(&self, heap: &mut Heap) -> io::Result<u64> {
        heap.value(self)
    }
}

/// An array of what an iterator gives. It is never in memory, because strands may have gigabytes.
pub(crate) struct Array<I>(pub I);

impl<E: Element, I: Iterator<Item = E> + Clone> Value for Array<I> {
    fn print(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(b"[")?;
        let mut text = String::new();
        for (i, value) in self.0.clone().enumerate() {
            text.clear();
            if i > 0 {
                text.push_str(", ");
            }
            value.text(&mut text);
            out.write_all(text.as_bytes())?;
        }
        out.write_all(b"]")
    }

    fn store(&self, heap: &mut Heap) -> io::Result<u64> {
        heap.array(self.0.clone())
    }
}

impl Element for f32 {
    const KIND: u64 = 8;

    fn text(&self, text: &mut String) {
        // The shortest decimal that reads back to the same number.
        let plain = *self == 0.0 || (1e-4..1e7).contains(&self.abs());
        let _ = if plain { write!(text, "{self}") } else { write!(text, "{self:e}") };
    }

    fn bytes(&self, _: &mut Tables, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }

    fn pack(values: impl Iterator<Item = Self> + Clone) -> Option<Vec<u8>> {
        pack_floats(values)
    }
}

impl Element for f64 {
    const KIND: u64 = 9;

    fn text(&self, text: &mut String) {
        let plain = *self == 0.0 || (1e-4..1e7).contains(&self.abs());
        let _ = if plain { write!(text, "{self}") } else { write!(text, "{self:e}") };
    }

    fn bytes(&self, _: &mut Tables, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

/// An `int`.
impl Element for i32 {
    const KIND: u64 = 3;

    fn text(&self, text: &mut String) {
        let _ = write!(text, "{self}");
    }

    fn bytes(&self, _: &mut Tables, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }

    fn pack(values: impl Iterator<Item = Self> + Clone) -> Option<Vec<u8>> {
        Some(pack_integers(values))
    }
}

/// A `double` in a row of several.
pub(crate) struct Row64<const N: usize>(pub [f64; N]);

impl<const N: usize> Element for Row64<N> {
    const KIND: u64 = [0, 9, 19, 23, 27][N];

    fn text(&self, text: &mut String) {
        tuple(&self.0, text, f64::text);
    }

    fn bytes(&self, _: &mut Tables, bytes: &mut Vec<u8>) {
        bytes.extend(self.0.iter().flat_map(|x| x.to_le_bytes()));
    }
}

/// Any string.
pub(crate) struct Quoted<'a>(pub &'a str);

impl Element for Quoted<'_> {
    const KIND: u64 = 10;

    fn text(&self, text: &mut String) {
        text.push('"');
        for c in self.0.chars() {
            match c {
                '"' | '\\' => text.extend(['\\', c]),
                '\n' => text.push_str("\\n"),
                '\r' => text.push_str("\\r"),
                c => text.push(c),
            }
        }
        text.push('"');
    }

    fn bytes(&self, tables: &mut Tables, bytes: &mut Vec<u8>) {
        bytes.extend(tables.string(self.0).to_le_bytes());
    }
}

/// An `int`, which is never negative here.
impl Element for u32 {
    const KIND: u64 = 3;

    fn text(&self, text: &mut String) {
        let _ = write!(text, "{self}");
    }

    fn bytes(&self, _: &mut Tables, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }

    fn pack(values: impl Iterator<Item = Self> + Clone) -> Option<Vec<u8>> {
        Some(pack_integers(values.map(u32::cast_signed)))
    }
}

impl Element for bool {
    const KIND: u64 = 1;

    fn text(&self, text: &mut String) {
        text.push(if *self { '1' } else { '0' });
    }

    fn bytes(&self, _: &mut Tables, bytes: &mut Vec<u8>) {
        bytes.push(u8::from(*self));
    }
}

/// A vector of 2, 3 or 4 numbers.
impl<const N: usize> Element for [f32; N] {
    // The types of 2, 3 and 4 numbers have the numbers 20, 24 and 28.
    const KIND: u64 = 12 + 4 * N as u64;

    fn text(&self, text: &mut String) {
        tuple(self, text, f32::text);
    }

    fn bytes(&self, tables: &mut Tables, bytes: &mut Vec<u8>) {
        self.iter().for_each(|x| x.bytes(tables, bytes));
    }
}

/// A matrix, by rows as USD has it.
impl Element for [[f64; 4]; 4] {
    const KIND: u64 = 15;

    fn text(&self, text: &mut String) {
        tuple(self, text, |row, text| tuple(row, text, f64::text));
    }

    fn bytes(&self, tables: &mut Tables, bytes: &mut Vec<u8>) {
        self.iter().flatten().for_each(|x| x.bytes(tables, bytes));
    }
}

fn tuple<T>(items: &[T], text: &mut String, print: impl Fn(&T, &mut String)) {
    text.push('(');
    for (i, item) in items.iter().enumerate() {
        if i > 0 {
            text.push_str(", ");
        }
        print(item, text);
    }
    text.push(')');
}

/// A word that USD compares, such as the name of an interpolation. It needs no escapes.
#[derive(Clone, Copy)]
pub(crate) struct Token<'a>(pub &'a str);

impl Element for Token<'_> {
    const KIND: u64 = 11;

    fn text(&self, text: &mut String) {
        let _ = write!(text, "\"{}\"", self.0);
    }

    fn bytes(&self, tables: &mut Tables, bytes: &mut Vec<u8>) {
        bytes.extend(tables.token(self.0).to_le_bytes());
    }
}

/// A string without characters that need escapes.
pub(crate) struct Words<'a>(pub &'a str);

impl Element for Words<'_> {
    const KIND: u64 = 10;

    fn text(&self, text: &mut String) {
        Token(self.0).text(text);
    }

    fn bytes(&self, tables: &mut Tables, bytes: &mut Vec<u8>) {
        bytes.extend(tables.string(self.0).to_le_bytes());
    }
}

/// The path of a file.
pub(crate) struct Asset<'a>(pub &'a str);

impl Element for Asset<'_> {
    const KIND: u64 = 12;

    fn text(&self, text: &mut String) {
        let _ = write!(text, "@{}@", self.0);
    }

    fn bytes(&self, tables: &mut Tables, bytes: &mut Vec<u8>) {
        bytes.extend(tables.token(self.0).to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(value: impl Element) -> String {
        let mut text = String::new();
        value.text(&mut text);
        text
    }

    #[test]
    fn numbers_read_back_to_the_same_bits() {
        for x in [0.0, -0.0, 1.0 / 3.0, 1e-40, f32::MIN_POSITIVE, f32::MAX, 16_777_217.0, 9.999e-5, 123_456.79] {
            assert_eq!(text(x).parse::<f32>().unwrap().to_bits(), x.to_bits());
            assert_eq!(text(f64::from(x)).parse::<f64>().unwrap() as f32, x);
        }
        assert_eq!(text([2e-9f32, 0.5, 0.0]), "(2e-9, 0.5, 0)");
        let matrix = text(glam::DMat4::from_diagonal(glam::DVec4::new(1.0, 0.5, 2e-9, 1.0)).to_cols_array_2d());
        assert_eq!(matrix, "((1, 0, 0, 0), (0, 0.5, 0, 0), (0, 0, 2e-9, 0), (0, 0, 0, 1))");
    }
}
