//! `vellus live`.

use crate::interrupt::Interrupt;
use crate::say::{note, standard_output};
use anyhow::{Context, Result};
use std::time::Duration;
use vellus_live::Args;

/// How often the command looks for a signal.
const POLL: Duration = Duration::from_millis(50);

/// Shows a scene until a signal arrives.
pub fn run(args: &Args) -> Result<()> {
    let interrupt = Interrupt::watch()?;
    interrupt.set_immediate(true);
    note!("opening {}", args.scene.display());
    let server = args.start()?;
    // From here on, there are temporary files to remove.
    interrupt.set_immediate(false);
    let url = server.url();
    standard_output(format!("{url}\n").as_bytes()).context("cannot write to standard output")?;
    args.open_browser(&url);
    while !interrupt.is_set() {
        std::thread::sleep(POLL);
    }
    server.stop();
    Err(interrupt.error("the viewer has ended".to_owned()).into())
}
