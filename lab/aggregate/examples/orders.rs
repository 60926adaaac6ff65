//! Builds the table of multiple scattering:
//! `cargo run --release -p vellus-aggregate --features simulation --example orders -- FILE [PHOTONS]`.
//!
//! With the default number of photons the file is `data/orders.vellus`, bit for bit.

use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let path = arguments.next().ok_or("expected the name of the file to write")?;
    let photons = match arguments.next() {
        Some(text) => text.to_string_lossy().parse()?,
        None => 1_000_000,
    };
    let bytes = vellus_aggregate::simulation::build(2022, photons);
    std::fs::write(path, &bytes)?;
    println!("{} bytes", bytes.len());
    Ok(())
}
