//! `vellus eval`: f·cos θ_i of each lobe, and the sampling density.

use crate::fiber_args::FiberArgs;
use crate::output::OutputArgs;
use anyhow::{Context, Result, ensure};
use std::io::Read;
use std::path::PathBuf;
use vellus::Bcsdf;
use vellus_plot::query::{Offsets, Queries, Query};
use vellus_plot::text::Answers;

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
    /// CSV file of queries, or - for standard input, answered one after the other. The header is
    /// theta_o,h,theta_i,phi; h_lo,h_hi can replace h.
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
    let Some(path) = &args.queries else {
        let offsets = args.window.offsets(args.h)?;
        let query = Query::new([args.theta_o, args.h, args.theta_i, args.phi])?.over(offsets);
        return args.output.write_with(|format, out| answer([Ok(query)], &bcsdf, Answers::new(out, format)));
    };
    let (place, input): (_, Box<dyn Read>) = match path.to_str() {
        Some("-") => ("standard input".to_owned(), Box::new(std::io::stdin().lock())),
        _ => {
            let place = path.display().to_string();
            (place.clone(), Box::new(vellus_io::open(path).context(place)?))
        }
    };
    let mut queries = Queries::new(input).with_context(|| place.clone())?.peekable();
    ensure!(queries.peek().is_some(), "{place}: no queries after the header");
    let queries = queries.map(|query| query.with_context(|| place.clone()));
    args.output.write_with(|format, out| answer(queries, &bcsdf, Answers::new(out, format)))
}

/// Answers queries one after the other, so that their number does not matter for memory.
fn answer(queries: impl IntoIterator<Item = Result<Query>>, bcsdf: &Bcsdf, mut answers: Answers) -> Result<()> {
    for query in queries {
        let query = query?;
        answers.add(&query, &query.ask(bcsdf))?;
    }
    Ok(answers.finish()?)
}
