//! Strands of hair and fur: readers and writers of files, growth on a mesh, and built-in scenes.
//!
//! - [`grow()`] grows fur on a mesh. [`GrowSettings`] has the numbers of the groom, and [`Maps`] varies them over the
//!   mesh.
//! - [`read_hair`], [`read_tfx`], [`read_research`] and [`read_obj`] read files; [`write_hair`] writes one.
//! - [`interpolate()`] makes a groom denser, [`thin()`] makes it less dense. [`flatten()`] and [`measure()`] work on
//!   any strands.
//! - [`scene`] returns one of the built-in [`SCENES`].
//!
//! ```
//! use glam::Vec3;
//! use vellus_groom::{Clump, GrowSettings, Maps, grow, read_obj};
//! # fn main() -> Result<(), vellus_groom::Error> {
//! // A square of 2 × 2 units that faces up.
//! let square = b"v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3 4\n";
//! let mesh = &read_obj(square, "square.obj")?[0];
//!
//! // 500 strands of length 0.3 in clumps of ten, combed toward +x, and half as long at the left edge.
//! let settings = GrowSettings {
//!     count: 500,
//!     length: 0.3,
//!     clump: Clump { strands: 10, strength: 0.6, power: 1.0 },
//!     ..GrowSettings::default()
//! };
//! let maps = Maps {
//!     comb: &|_| Vec3::X,
//!     length: &|site| 0.75 + 0.25 * site.position.x,
//!     ..Maps::default()
//! };
//! let fur = grow(mesh, &settings, &maps)?;
//! assert_eq!((fur.len(), fur.segments()), (500, 500 * settings.segments));
//! # Ok(()) }
//! ```
//!
//! The feature `clap` makes the fields of [`Group`] options of a command line.
#![warn(clippy::print_stdout)]

#[cfg(feature = "clap")]
mod argument;
mod body;
mod bytes;
mod clumps;
mod describe;
mod error;
mod flatten;
mod group;
mod grow;
mod hair;
mod interpolate;
mod measure;
mod obj;
mod patch;
mod plant;
mod polygonize;
mod research;
mod roots;
mod scenes;
mod settings;
mod soak;
mod tfx;
mod thin;

/// The largest file of strands or polygons (.hair, .tfx, .data, .ply, .npy, .npz, .obj), in bytes: 16 GiB. The readers
/// of this crate take bytes, so the caller has to check the limit.
pub const MAX_FILE_BYTES: u64 = 16 << 30;

pub use describe::{describe, suggested_width};
pub use error::Error;
pub use flatten::flatten;
pub use group::{Ground, Group, GroupError, read_groups, toml_message};
pub use grow::{area, grow};
pub use hair::{HairHeader, hair_header, read_hair, write_hair};
pub use interpolate::{Interpolation, interpolate, root_normals};
pub use measure::{Measures, bytes, measure};
pub use obj::read_obj;
pub use patch::reference_coat;
pub use plant::{Coat, plant};
pub use research::read_research;
pub use roots::Site;
pub use scenes::{SCENES, published_scene, scene};
pub use settings::{Clump, ColorMap, Draw, GrowSettings, Maps};
pub use soak::soak;
pub use tfx::read_tfx;
pub use thin::thin;
