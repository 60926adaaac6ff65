//! Builds the table of first exits alone: `cargo run --release -p vellus-sim --example exits FILE`.

use std::error::Error;
use vellus_sim::exits::ExitQuality;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).ok_or("expected the name of the file to write")?;
    let bytes = ExitQuality::shipping().build(2017, &()).to_bytes();
    std::fs::write(path, &bytes)?;
    println!("{} bytes", bytes.len());
    Ok(())
}
