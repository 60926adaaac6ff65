//! Reads and writes Alembic archives (`.abc`, Ogawa): the tree of objects with their properties, samples at a time, and
//! curves, meshes, transforms and cameras as plain data.
//!
//! Of a file, the tree is read at once, and samples on demand: a long animation needs the memory of its tree and of the
//! samples that are asked for. All of it is bounded by the size of the file: positions and counts are checked before
//! anything is allocated, and a damaged file is an error. Archives in HDF5, the older container, are refused with a
//! message that says how to convert them.
//!
//! ```no_run
//! use vellus_alembic::{Archive, Attribute, Curves, attributes};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let archive = Archive::open_file(std::fs::File::open("groom.abc")?)?;
//! for object in &archive.objects {
//!     if object.schema().is_some_and(|schema| schema.starts_with(Curves::SCHEMA)) {
//!         let curves = Curves::read(&archive, object, 0.0)?;
//!         println!("{}: {} curves", object.name, curves.counts.len());
//!         for property in attributes(object) {
//!             let attribute = Attribute::read(&archive, property, 0.0)?;
//!             println!("  {}: {} rows of {}", attribute.name, attribute.rows(), attribute.lanes);
//!         }
//!     }
//! }
//! # Ok(()) }
//! ```
//!
//! The format is that of the library [Alembic](https://www.alembic.io) 1.8, from its documentation and source.
#![forbid(unsafe_code)]

mod archive;
mod attribute;
mod camera;
mod cursor;
mod curves;
mod error;
mod geometry;
mod mesh;
mod metadata;
mod ogawa;
mod property;
mod sample;
mod source;
mod time;
mod write;
mod xform;

pub use archive::{Archive, Object};
pub use attribute::{Attribute, Scope, Values, Visibility, attributes, instance_source, user_properties, visibility};
pub use camera::Camera;
pub use curves::{CurveBasis, CurveType, Curves};
pub use error::Error;
pub use mesh::Mesh;
pub use metadata::Metadata;
pub use property::{Kind, Pod, Property, Series};
pub use sample::Sample;
pub use time::{Between, TimeSampling};
pub use write::{Form, Geometry, ObjectId, Owner, PropertyId, Writer};
pub use xform::{Op, Xform};
