//! `vellus energy`: the energy of each lobe, in closed form and as an integral.

use crate::eval::WindowArgs;
use crate::fiber_args::Incidence;
use crate::output::OutputArgs;
use anyhow::Result;
use vellus_plot::query::Query;
use vellus_plot::text::{self, Energy};

#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    incidence: Incidence,
    /// Offset of the hit, in [-1, 1].
    #[arg(long, default_value_t = 0.0)]
    h: f64,
    #[command(flatten)]
    window: WindowArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub fn run(args: &Args) -> Result<()> {
    let fiber = args.incidence.fiber.load()?;
    let offsets = args.window.offsets(args.h)?;
    let query = Query::new([args.incidence.theta_o, args.h, 0.0, 0.0])?.over(offsets);
    args.output.check()?;
    let energy = Energy::new(&fiber, &query)?;
    args.output.write(|format| text::energy(&query, &energy, format))
}
