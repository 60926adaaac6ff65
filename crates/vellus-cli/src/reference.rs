//! `vellus reference`: simulates the whole fibre and compares it with the model.

use crate::fiber_args::Incidence;
use crate::output::OutputArgs;
use crate::terminal::Terminal;
use anyhow::Result;
use vellus::Bcsdf;
use vellus_io::parse;
use vellus_plot::text::{self, Reference};
use vellus_reference::simulate::energies::{Offsets, energies};

/// The largest number of photons. It would take months.
const MAX_PHOTONS: u64 = 1_000_000_000_000;

#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    incidence: Incidence,
    /// Offset of the hit, in [-1, 1]. Default: uniform over the width of the fibre.
    #[arg(long)]
    h: Option<f64>,
    /// Number of photons.
    #[arg(long, default_value_t = 1_000_000, value_parser = parse::whole::<u64>(2..=MAX_PHOTONS), value_name = "N")]
    photons: u64,
    /// Seed. The same seed gives the same result, with any number of threads.
    #[arg(long, default_value_t = 1, value_parser = parse::whole::<u64>(0..=u64::MAX), value_name = "N")]
    seed: u64,
    #[command(flatten)]
    output: OutputArgs,
}

pub fn run(args: &Args) -> Result<()> {
    let &Args { ref incidence, h, photons, seed, ref output } = args;
    let (fiber, theta_o) = (incidence.fiber.load()?, incidence.theta_o);
    output.check()?;
    let bcsdf = Bcsdf::new(&fiber)?;
    let offsets = h.map_or(Offsets::Whole, Offsets::At);
    let simulated = energies(&fiber, theta_o.to_radians(), offsets, photons, seed, &Terminal::new())?;
    let model = vellus_models::energies(&bcsdf, theta_o, h);
    let result = Reference { theta_o, h, photons, seed, exit: fiber.exit, simulated, model };
    output.write(|format| text::reference(&result, format))
}
