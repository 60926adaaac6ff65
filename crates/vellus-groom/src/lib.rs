//! Strands of hair and fur: readers and writers, growing them on a mesh, and built-in animals to render.

mod body;
mod bytes;
mod clumps;
mod describe;
mod error;
mod flatten;
mod group;
mod grow;
mod hair;
mod measure;
mod obj;
mod plant;
mod polygonize;
mod roots;
mod scenes;
mod settings;
mod tfx;
mod thin;

/// The largest file of strands or polygons (.hair, .tfx, .obj) that is worth reading: 16 GiB. Readers take bytes; who
/// reads the files holds to this.
pub const MAX_FILE_BYTES: u64 = 16 << 30;

pub use describe::describe;
pub use error::Error;
pub use flatten::flatten;
pub use group::{Ground, Group, GroupError, read_groups};
pub use grow::{area, grow};
pub use hair::{read_hair, write_hair};
pub use measure::{Measures, bytes, measure};
pub use obj::read_obj;
pub use plant::{Coat, absorption_of_color, plant};
pub use roots::Site;
pub use scenes::{SCENES, scene};
pub use settings::{Clump, ColorMap, Draw, GrowSettings, Maps};
pub use tfx::read_tfx;
pub use thin::thin;
