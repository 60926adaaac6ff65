//! The options of `vellus live`.

use crate::{Engine, Error, Options, Server};
use std::net::IpAddr;
use std::path::PathBuf;

/// Show a scene in the browser, and change its fibres, lights, groom and camera while it renders.
///
/// The command starts a server on this machine and opens a browser. The picture refines while nothing moves. Through
/// SSH, forward the port: ssh -L 7878:localhost:7878 HOST. Ctrl-C ends the server.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// A built-in scene (`vellus scene` lists them), a USD file (.usda, .usdc, .usdz), strands as .hair or .tfx, or
    /// meshes as .obj.
    #[arg(default_value = "raccoon", value_name = "SCENE|FILE")]
    pub scene: PathBuf,
    /// Use the small version of a built-in scene.
    #[arg(long)]
    pub small: bool,
    /// Listen on this address instead of the loopback address. All requests then need the random token in the printed
    /// address. The connection is not encrypted.
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

/// Opens the scene, starts the server, prints its address, and waits for Ctrl-C.
///
/// # Errors
/// [`Error`] if the scene or the address cannot be used.
pub fn run(args: &Args) -> Result<(), Error> {
    eprintln!("opening {}", args.scene.display());
    let engine = Engine::open(&args.scene, args.small, args.folder.clone())?;
    let options = Options { host: args.host, port: args.port };
    let server = Server::start(engine, &options)?;
    println!("{}", server.url());
    if !args.no_open {
        open_browser(&server.url());
    }
    server.wait()
}

/// Asks the system to open the page. The address is printed, so a failure is no error.
fn open_browser(url: &str) {
    let program = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else if ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some()) {
        "xdg-open"
    } else {
        return;
    };
    let null = std::process::Stdio::null;
    let command = std::process::Command::new(program).arg(url).stdout(null()).stderr(null()).spawn();
    // A thread waits for the program, so that it leaves no zombie.
    if let Ok(mut child) = command {
        std::thread::spawn(move || child.wait());
    }
}
