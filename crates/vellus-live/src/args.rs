//! The options of `vellus live`.

use crate::{Engine, Error, Listener, Options, Server};
use std::net::IpAddr;
use std::path::PathBuf;

/// Show a scene in the browser, and change its fibres, lights, groom and camera while it renders.
///
/// The command starts a server on this machine and opens a browser. The picture refines while nothing moves. Through
/// SSH, forward the port: ssh -L 7878:localhost:7878 HOST. Ctrl-C ends the server.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// A built-in scene (`vellus scene` lists them), a USD file (.usda, .usdc, .usdz), an Alembic archive (.abc),
    /// strands as .hair, .tfx, .data, .ply, .npy or .npz, or meshes as .obj.
    #[arg(default_value = "raccoon", value_name = "SCENE|FILE")]
    pub scene: PathBuf,
    /// Use the small version of a built-in scene.
    #[arg(long)]
    pub small: bool,
    /// Listen on this address of the machine instead of the loopback address; 0.0.0.0 and :: are all of them. All
    /// requests then need the random token in the printed address. The connection is not encrypted.
    #[arg(long, value_name = "ADDRESS")]
    pub host: Option<IpAddr>,
    /// The port; 0 is a free one.
    #[arg(long, default_value_t = 7878)]
    pub port: u16,
    /// Do not open a browser.
    #[arg(long)]
    pub no_open: bool,
    /// The page may open the scenes and grooms in this folder, by name. It reads no other file.
    #[arg(long)]
    pub folder: Option<PathBuf>,
}

impl Args {
    /// Takes the port, opens the scene, and starts the server.
    ///
    /// # Errors
    /// [`Error`] if the scene or the address cannot be used.
    pub fn start(&self) -> Result<Server, Error> {
        // A scene may take a minute, so a port that is in use is found before.
        let listener = Listener::bind(&Options { host: self.host, port: self.port, ..Options::default() })?;
        listener.serve(Engine::open(&self.scene, self.small, self.folder.clone())?)
    }

    /// Opens the page in a browser, if the options do not forbid it. The address is printed, so a failure is no error.
    pub fn open_browser(&self, url: &str) {
        let program = if cfg!(target_os = "macos") {
            "open"
        } else if cfg!(windows) {
            "explorer"
        } else if ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some()) {
            "xdg-open"
        } else {
            return;
        };
        if self.no_open {
            return;
        }
        let null = std::process::Stdio::null;
        let command = std::process::Command::new(program).arg(url).stdout(null()).stderr(null()).spawn();
        // A thread waits for the program, so that it leaves no zombie.
        if let Ok(mut child) = command {
            std::thread::spawn(move || child.wait());
        }
    }
}
