//! Files: bounded reading ([`read()`]), safe writing ([`write()`]) and content digests ([`Digest`], [`Sources`]). Also
//! how long work reports its progress and learns that it should stop ([`Progress`]).
//!
//! All readers of the project use [`read()`], so that no file, device or pipe can fill the memory or block a program
//! forever. All writers use [`write()`], so that no failure leaves half a file or loses the one there was.

mod digest;
mod progress;
mod read;
mod sources;
mod target;
mod write;

pub use digest::{Digest, DigestBuilder};
pub use progress::{Progress, Steps};
pub use read::{MAX_FILE_BYTES, MAX_STREAM_BYTES, excerpt, open, read, read_at_most, read_to_string};
pub use sources::Sources;
pub use write::{folder, writable, write, write_with};
