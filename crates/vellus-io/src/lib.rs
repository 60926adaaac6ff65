//! Files: bounded reading ([`read`]) and content digests ([`Digest`], [`Sources`]).
//!
//! All readers of the project use [`read`], so that no file, device or pipe can fill the memory or block a program forever.

mod digest;
mod read;
mod sources;

pub use digest::{Digest, DigestBuilder};
pub use read::{MAX_FILE_BYTES, MAX_STREAM_BYTES, excerpt, open, read, read_at_most, read_to_string};
pub use sources::Sources;
