//! `vellus eval`: f·cos θ_i of each lobe, and the sampling density.

use crate::fiber_args::FiberArgs;
use crate::output::OutputArgs;
use anyhow::{Context, Result};
use std::path::PathBuf;
use vellus::Bcsdf;
use vellus_plot::query::{Answer, Offsets, Query, read_csv};
use vellus_plot::text;

#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    fiber: FiberArgs,
    /// Inclination of ω_o, the direction toward the camera.
    #[arg(long, default_value_t = 20.0, value_name = "DEG")]
    theta_o: f64,
    /// Offset of the hit, in [-1, 1].
    #[arg(long, default_value_t = 0.3)]
    h: f64,
    #[command(flatten)]
    window: WindowArgs,
    /// Inclination of ω_i, the direction toward the light.
    #[arg(long, default_value_t = -15.0, value_name = "DEG")]
    theta_i: f64,
    /// Azimuth of ω_i minus the azimuth of ω_o.
    #[arg(long, default_value_t = 150.0, value_name = "DEG")]
    phi: f64,
    /// CSV file of queries, or - for standard input. The header is theta_o,h,theta_i,phi; h_lo,h_hi can replace h.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["theta_o", "h", "window", "theta_i", "phi"])]
    queries: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

/// The option `--window`.
#[derive(clap::Args, Clone)]
pub struct WindowArgs {
    /// Offsets to average over: near (only the offset h), far (the whole width), or LO:HI.
    #[arg(long, default_value = "near", allow_hyphen_values = true, value_name = "near|far|LO:HI")]
    window: String,
}

impl WindowArgs {
    /// The offsets. `near` means the offset `h`.
    pub fn offsets(&self, h: f64) -> Result<Offsets> {
        Offsets::parse(&self.window, h).with_context(|| format!("--window {}", self.window))
    }
}

pub fn run(args: &Args) -> Result<()> {
    let fiber = args.fiber.load()?;
    args.output.check()?;
    let bcsdf = Bcsdf::new(&fiber)?;
    let queries = match &args.queries {
        None => {
            let offsets = args.window.offsets(args.h)?;
            vec![Query::new([args.theta_o, args.h, args.theta_i, args.phi])?.over(offsets)]
        }
        Some(path) if path.as_os_str() == "-" => read_csv(std::io::stdin().lock()).context("standard input")?,
        Some(path) => {
            let place = || format!("{}", path.display());
            read_csv(vellus_io::open(path).with_context(place)?).with_context(place)?
        }
    };
    let answers: Vec<(Query, Answer)> = queries.into_iter().map(|q| (q, q.ask(&bcsdf))).collect();
    args.output.write(|format| text::eval(&answers, format))
}
