//! Writes the text format of USD (.usda).

use crate::write::encoder::{Encoder, Role};
use crate::write::value::Value;
use std::io::{self, Write};

/// Writes nested prims with indentation.
pub(crate) struct Text<W> {
    out: W,
    depth: usize,
}

impl<W: Write> Text<W> {
    pub fn new(out: W) -> Self {
        Text { out, depth: 0 }
    }

    pub fn finish(self) -> W {
        self.out
    }

    fn indent(&mut self) -> io::Result<()> {
        write!(self.out, "{:1$}", "", 4 * self.depth)
    }

    pub fn line(&mut self, line: &str) -> io::Result<()> {
        self.indent()?;
        writeln!(self.out, "{line}")
    }
}

impl<W: Write> Encoder for Text<W> {
    fn layer(&mut self, fields: &[(&str, &dyn Value)]) -> io::Result<()> {
        self.line("#usda 1.0\n(")?;
        for (name, value) in fields {
            write!(self.out, "    {name} = ")?;
            value.print(&mut self.out)?;
            writeln!(self.out)?;
        }
        self.line(")\n")
    }

    fn open(&mut self, kind: &str, name: &str, role: Role) -> io::Result<()> {
        let header = format!("def {kind} \"{name}\"");
        self.line(&match role {
            Role::Plain => header,
            Role::Applies(schema) => format!("{header} ( prepend apiSchemas = [\"{schema}\"] )"),
            Role::Instance(class) => format!("{header} ( instanceable = true; inherits = <{class}> )"),
            Role::Class => format!("class \"{name}\""),
        })?;
        self.line("{")?;
        self.depth += 1;
        Ok(())
    }

    fn close(&mut self) -> io::Result<()> {
        self.depth -= 1;
        self.line("}")
    }

    fn declare(&mut self, declaration: &str) -> io::Result<()> {
        self.line(declaration)
    }

    fn attribute(&mut self, declaration: &str, value: &dyn Value, interpolation: Option<&str>) -> io::Result<()> {
        self.indent()?;
        write!(self.out, "{declaration} = ")?;
        value.print(&mut self.out)?;
        match interpolation {
            Some(interpolation) => writeln!(self.out, " ( interpolation = \"{interpolation}\" )"),
            None => writeln!(self.out),
        }
    }

    fn samples(&mut self, declaration: &str, opened: &dyn Value, closed: &dyn Value) -> io::Result<()> {
        self.line(&format!("{declaration}.timeSamples = {{"))?;
        self.depth += 1;
        for (time, value) in [opened, closed].into_iter().enumerate() {
            self.indent()?;
            write!(self.out, "{time}: ")?;
            value.print(&mut self.out)?;
            writeln!(self.out, ",")?;
        }
        self.close()
    }

    fn connect(&mut self, declaration: &str, target: &str) -> io::Result<()> {
        self.line(&format!("{declaration}.connect = <{target}>"))
    }

    fn relate(&mut self, name: &str, targets: &[&str]) -> io::Result<()> {
        self.line(&match targets {
            [target] => format!("rel {name} = <{target}>"),
            targets => format!("rel {name} = [<{}>]", targets.join(">, <")),
        })
    }
}
