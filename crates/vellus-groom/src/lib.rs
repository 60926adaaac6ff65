//! Strands of hair and fur: readers and writers, growing them on a mesh, and built-in animals to render.

mod bytes;
mod error;
mod flatten;
mod hair;
mod tfx;

pub use error::Error;
pub use flatten::flatten;
pub use hair::{read_hair, write_hair};
pub use tfx::read_tfx;
