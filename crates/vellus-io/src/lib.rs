//! Bounded reading ([`read()`]), safe writing ([`write()`]) and content digests ([`Digest`], [`Sources`]) of files, and
//! progress reports and cancellation of long work ([`Progress`]).
//!
//! All readers of the project use [`read()`], so no file, device or pipe can fill the memory or block a program
//! forever. All writers use [`write()`], so a failure never leaves a truncated file and never loses the previous one.
//!
//! ```
//! use vellus_io::{Digest, read, write};
//! # fn main() -> std::io::Result<()> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("curves/fox.hair");
//! // Creates the folder, and replaces the file completely or not at all.
//! write(&path, b"HAIR")?;
//! let bytes = read(&path)?;
//! assert_eq!(Digest::of(&bytes), Digest::of(b"HAIR"));
//! # Ok(()) }
//! ```
#![warn(clippy::print_stdout)]

mod confined;
mod cpu_time;
mod digest;
mod errors;
mod leftover;
mod lines;
mod memory;
pub mod parse;
mod progress;
mod read;
mod sources;
mod state;
mod target;
mod visible;
mod write;

pub use confined::confine;
pub use cpu_time::cpu_time;
pub use digest::{Digest, DigestBuilder};
pub use errors::may_pass;
pub use lines::BoundedLines;
pub use memory::fits_in_memory;
pub use progress::{Progress, Steps};
pub use read::{
    MAX_FILE_BYTES, MAX_STREAM_BYTES, excerpt, open, open_file, read, read_at_most, read_to_string, unmarked,
};
pub use sources::Sources;
pub use state::{is_own, make_private, state_folder};
pub use visible::visible;
pub use write::{append, folder, writable, write, write_with};
