//! `vellus energy`: the energy of each lobe, in closed form and as an integral.

use crate::eval::WindowArgs;
use crate::fiber_args::Incidence;
use crate::output::OutputArgs;
use anyhow::Result;
use std::path::PathBuf;
use vellus_fit::Absorption;
use vellus_plot::query::Query;
use vellus_plot::text::{self, ChannelEnergy, Energy};

#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    incidence: Incidence,
    /// Offset of the hit, in [-1, 1].
    #[arg(long, default_value_t = 0.0)]
    h: f64,
    #[command(flatten)]
    window: WindowArgs,
    /// Absorption in any number of channels, in place of that of the fibre: CSV with the columns channel, sigma_ca and
    /// sigma_ma. The report of `vellus fit` has such a file.
    #[arg(long, value_name = "FILE")]
    absorption: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

pub fn run(args: &Args) -> Result<()> {
    let fiber = args.incidence.fiber.load()?;
    let offsets = args.window.offsets(args.h)?;
    let query = Query::new([args.incidence.theta_o, args.h, 0.0, 0.0])?.over(offsets);
    args.output.check()?;
    if let Some(path) = &args.absorption {
        let energies = ChannelEnergy::all(&fiber, &Absorption::read(path)?, &query)?;
        return args.output.write(|format| text::channel_energies(&query, &energies, format));
    }
    let energy = Energy::new(&fiber, &query)?;
    args.output.write(|format| text::energy(&query, &energy, format))
}
