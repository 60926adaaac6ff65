//! A live viewer: a local server renders a scene progressively, and pages in browsers show and change it.
//!
//! - [`Engine`] owns the scene. It renders on a thread of its own, and takes [`Command`]s from a queue.
//! - [`Server`] answers HTTP and WebSocket requests. All browsers share one engine and one state.
//! - `web/` holds the page: plain ES modules, embedded in the program.
//!
//! Commands are JSON with a field `type`. The server answers each with `{"type": "reply"}` or `{"type": "error"}`, and
//! the `id` of the command. Its first message is `{"type": "hello"}` with the token that requests for files need. It
//! sends the state as `{"type": "state"}`, and pictures as binary messages: the length of a JSON header (u32, little
//! endian), the header, and a PNG file.
//!
//! The feature `clap` adds the options of the command `vellus live`.
#![warn(clippy::print_stdout)]

mod answer;
#[cfg(feature = "clap")]
mod args;
mod camera;
mod coat;
mod engine;
mod files;
mod frame;
mod groom;
mod guard;
mod history;
mod page;
mod renderer;
mod request;
mod save;
mod server;
mod session;
mod socket;
mod state;

#[cfg(feature = "clap")]
pub use args::Args;
pub use engine::Engine;
pub use request::Command;
pub use server::{Listener, Options, Server};

/// What can go wrong before the server runs.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene cannot be opened.
    #[error(transparent)]
    Open(#[from] vellus_open::Error),
    /// The scene cannot be rendered.
    #[error(transparent)]
    Scene(#[from] vellus_scene::Error),
    /// The address is in use, or not of this machine.
    #[error("cannot listen on {address}")]
    Listen {
        /// Address and port.
        address: String,
        /// What the operating system reports.
        source: std::io::Error,
    },
    /// The folder does not exist.
    #[error("--folder {}: it is not a folder", .0.display())]
    Folder(std::path::PathBuf),
    /// The system cannot start a thread, or gives no random numbers.
    #[error("the system refuses {what}")]
    System {
        /// What was asked for.
        what: &'static str,
        /// What the operating system reports.
        source: std::io::Error,
    },
}
