//! What a format of USD has to write: prims and their properties, in the order of the file.

use crate::write::value::Value;
use std::io;

/// What a prim is, apart from its type.
#[derive(Clone, Copy)]
pub(crate) enum Role<'a> {
    /// A prim as any other.
    Plain,
    /// A prim with this schema, such as `MaterialBindingAPI`.
    Applies(&'a str),
    /// An instance of the class at this path.
    Instance(&'a str),
    /// A class, which is visible only where another prim inherits it. It has no type.
    Class,
}

/// Writes a layer.
///
/// A declaration is as in the text format: `custom` or `uniform` if needed, the type, the name.
pub(crate) trait Encoder {
    /// Writes the metadata of the layer, before the first prim.
    fn layer(&mut self, fields: &[(&str, &dyn Value)]) -> io::Result<()>;

    /// Opens a prim in the open prim.
    fn open(&mut self, kind: &str, name: &str, role: Role) -> io::Result<()>;

    /// Closes the open prim.
    fn close(&mut self) -> io::Result<()>;

    /// Writes an attribute without a value.
    fn declare(&mut self, declaration: &str) -> io::Result<()>;

    /// Writes an attribute with a value.
    fn attribute(&mut self, declaration: &str, value: &dyn Value, interpolation: Option<&str>) -> io::Result<()>;

    /// Writes an attribute with time samples at 0 and 1.
    fn samples(&mut self, declaration: &str, opened: &dyn Value, closed: &dyn Value) -> io::Result<()>;

    /// Connects an attribute with the one at the path `target`. It may follow the value of the attribute.
    fn connect(&mut self, declaration: &str, target: &str) -> io::Result<()>;

    /// Writes a relationship to the prims at the paths `targets`, of which there is at least one.
    fn relate(&mut self, name: &str, targets: &[&str]) -> io::Result<()>;

    /// Writes an attribute with a value that has no interpolation.
    fn set(&mut self, declaration: &str, value: &dyn Value) -> io::Result<()> {
        self.attribute(declaration, value, None)
    }
}
