//! Writes the text format of USD (.usda). Numbers read back to the same bits.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::io::{self, Write};

/// Writes nested prims with indentation.
pub(crate) struct Text<W: Write> {
    out: W,
    depth: usize,
    /// Paths of prims that are already used.
    taken: HashSet<String>,
}

impl<W: Write> Text<W> {
    pub fn new(out: W) -> Self {
        Text { out, depth: 0, taken: HashSet::new() }
    }

    pub fn line(&mut self, line: &str) -> io::Result<()> {
        writeln!(self.out, "{:1$}{line}", "", 4 * self.depth)
    }

    /// Opens a prim: `def Type "name" ( metadata )`. `;` separates several fields of metadata.
    pub fn open(&mut self, kind: &str, name: &str, metadata: &str) -> io::Result<()> {
        let metadata = if metadata.is_empty() { String::new() } else { format!(" ( {metadata} )") };
        self.begin(&format!("def {kind} \"{name}\"{metadata}"))
    }

    /// Opens a class, which is visible only where another prim inherits it.
    pub fn open_class(&mut self, name: &str) -> io::Result<()> {
        self.begin(&format!("class \"{name}\""))
    }

    fn begin(&mut self, header: &str) -> io::Result<()> {
        self.line(header)?;
        self.line("{")?;
        self.depth += 1;
        Ok(())
    }

    pub fn close(&mut self) -> io::Result<()> {
        self.depth -= 1;
        self.line("}")
    }

    /// Writes an attribute with a single value.
    pub fn set(&mut self, declaration: &str, value: &str) -> io::Result<()> {
        self.line(&format!("{declaration} = {value}"))
    }

    /// Writes an array without a copy of its text, because strands may have gigabytes.
    pub fn array(
        &mut self,
        declaration: &str,
        values: impl IntoIterator<Item = impl Literal>,
        interpolation: Option<&str>,
    ) -> io::Result<()> {
        write!(self.out, "{:1$}{declaration} = ", "", 4 * self.depth)?;
        self.items(values)?;
        match interpolation {
            Some(interpolation) => writeln!(self.out, " ( interpolation = \"{interpolation}\" )"),
            None => writeln!(self.out),
        }
    }

    /// Writes an array with time samples at 0 and 1.
    pub fn moving_array<T: Literal>(
        &mut self,
        declaration: &str,
        opened: impl IntoIterator<Item = T>,
        closed: impl IntoIterator<Item = T>,
    ) -> io::Result<()> {
        self.line(&format!("{declaration}.timeSamples = {{"))?;
        write!(self.out, "{:1$}0: ", "", 4 * (self.depth + 1))?;
        self.items(opened)?;
        write!(self.out, ",\n{:1$}1: ", "", 4 * (self.depth + 1))?;
        self.items(closed)?;
        writeln!(self.out)?;
        self.line("}")
    }

    fn items(&mut self, values: impl IntoIterator<Item = impl Literal>) -> io::Result<()> {
        self.out.write_all(b"[")?;
        let mut literal = String::new();
        for (i, value) in values.into_iter().enumerate() {
            literal.clear();
            if i > 0 {
                literal.push_str(", ");
            }
            value.write(&mut literal);
            self.out.write_all(literal.as_bytes())?;
        }
        self.out.write_all(b"]")
    }

    /// A valid and unused name for a prim in `parent`, similar to `wish`.
    pub fn name(&mut self, parent: &str, wish: &str) -> String {
        // The last part of a path.
        let wish = wish.rsplit('/').next().unwrap_or_default();
        let mut name: String = wish.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
            name.insert(0, '_');
        }
        let numbered = (1..).map(|n| if n == 1 { name.clone() } else { format!("{name}_{n}") });
        let free = numbered.skip_while(|n| self.taken.contains(&format!("{parent}/{n}"))).take(1).collect::<String>();
        self.taken.insert(format!("{parent}/{free}"));
        free
    }

    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }
}

/// A string in quotes. Characters that need an escape are replaced, because readers handle escapes differently.
pub(crate) fn quoted(text: &str) -> String {
    let plain = text.chars().map(|c| match c {
        '"' => '\'',
        '\\' => '/',
        c if c.is_control() => ' ',
        c => c,
    });
    format!("\"{}\"", plain.collect::<String>())
}

/// A value that has a text form.
pub(crate) trait Literal {
    fn write(&self, text: &mut String);

    fn text(&self) -> String {
        let mut text = String::new();
        self.write(&mut text);
        text
    }
}

impl Literal for f32 {
    fn write(&self, text: &mut String) {
        // The shortest decimal that reads back to the same number. Writing to a string cannot fail.
        let plain = *self == 0.0 || (1e-4..1e7).contains(&self.abs());
        let _ = if plain { write!(text, "{self}") } else { write!(text, "{self:e}") };
    }
}

impl Literal for f64 {
    fn write(&self, text: &mut String) {
        let plain = *self == 0.0 || (1e-4..1e7).contains(&self.abs());
        let _ = if plain { write!(text, "{self}") } else { write!(text, "{self:e}") };
    }
}

impl Literal for u32 {
    fn write(&self, text: &mut String) {
        let _ = write!(text, "{self}");
    }
}

impl<T: Literal, const N: usize> Literal for [T; N] {
    fn write(&self, text: &mut String) {
        text.push('(');
        for (i, value) in self.iter().enumerate() {
            if i > 0 {
                text.push_str(", ");
            }
            value.write(text);
        }
        text.push(')');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_valid_and_differ() {
        let mut text = Text::new(Vec::new());
        let names = ["/a/b c", "b_c", "", "7", "b_c"].map(|wish| text.name("/Scene", wish));
        assert_eq!(names, ["b_c", "b_c_2", "_", "_7", "b_c_3"]);
        assert_eq!(text.name("/Scene/Looks", "b c"), "b_c");
    }

    #[test]
    fn numbers_read_back_to_the_same_bits() {
        for x in [0.0, -0.0, 1.0 / 3.0, 1e-40, f32::MIN_POSITIVE, f32::MAX, 16_777_217.0, 9.999e-5, 123_456.79] {
            assert_eq!(x.text().parse::<f32>().unwrap().to_bits(), x.to_bits());
            assert_eq!(f64::from(x).text().parse::<f64>().unwrap() as f32, x);
        }
        assert_eq!([[1.0f32, 0.5], [2e-9, 0.0]].text(), "((1, 0.5), (2e-9, 0))");
        assert_eq!(quoted("a \"b\" \\ c\n"), "\"a 'b' / c \"");
    }
}
