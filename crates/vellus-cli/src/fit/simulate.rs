//! `vellus fit --simulate`: what a gantry would have measured of a fibre.

use crate::fiber_args::FiberArgs;
use crate::output;
use crate::say::say;
use crate::terminal::Terminal;
use anyhow::{Context, Result, bail};
use vellus_fit::{Specimen, Synthetic, csv, gantry_text, simulate};
use vellus_models::ModelKind;

/// The gantry, and how well it measures.
#[derive(clap::Args)]
pub struct Gantry {
    /// Write a synthetic measurement of this fibre instead: a preset, or a TOML or JSON file.
    #[arg(long, value_name = "NAME|FILE")]
    simulate: Option<String>,
    /// Override a parameter of that fibre, as elsewhere. May be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", conflicts_with = "profile")]
    set: Vec<String>,
    /// Refractive index of the medulla, of --model yan2015 only; default: that of the cortex.
    #[arg(long, value_name = "INDEX", conflicts_with = "profile")]
    eta_m: Option<f32>,
    /// What is measured: the model's far field, or the whole fibre, traced photon by photon, with a rough cuticle (not
    /// the model).
    #[arg(long, value_enum, conflicts_with = "profile")]
    from: Option<From>,
    /// Photons traced by --from reference.
    #[arg(long, value_name = "N", conflicts_with = "profile", value_parser = clap::value_parser!(u64).range(1..))]
    photons: Option<u64>,
    /// Noise, as a share of each value.
    #[arg(long, value_name = "X", conflicts_with = "profile")]
    noise: Option<f64>,
    /// Share of the directions that are missing, in patches.
    #[arg(long, value_name = "X", conflicts_with = "profile")]
    gaps: Option<f64>,
    /// Step over θ and φ, degrees.
    #[arg(long, value_name = "DEG", conflicts_with = "profile")]
    step: Option<f64>,
    /// What the values are multiplied with.
    #[arg(long, value_name = "X", conflicts_with = "profile")]
    scale: Option<f64>,
    /// Measure red, green and blue, not red alone.
    #[arg(long, conflicts_with = "profile")]
    rgb: bool,
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum From {
    Model,
    Reference,
}

/// Photons without `--photons`: noise of some 2 % in cells of 4°.
const PHOTONS: u64 = 4_000_000;

/// Runs it.
pub fn run(args: &super::Args) -> Result<()> {
    let given = &args.synthetic;
    let Some(name) = &given.simulate else { bail!("a profile is needed, or --simulate") };
    if args.format != super::Format::Table {
        bail!("--format is for a fit: a synthetic measurement is .txt or .csv, as --out says");
    }
    let fiber_args = FiberArgs::new(name, &given.set);
    let fiber = fiber_args.load()?;
    let out = args.out.as_ref().context("--simulate needs --out FILE, .txt or .csv")?;
    let format = match out.extension().and_then(|e| e.to_str()) {
        Some("txt") => gantry_text,
        Some("csv") => csv,
        _ => bail!("{}: the measurement's name must end in .txt or .csv", out.display()),
    };
    let default = Synthetic::default();
    let scale = given.scale.unwrap_or(1.0);
    if !(scale > 0.0 && scale.is_finite()) {
        bail!("--scale {scale} is out of range: it must be above 0");
    }
    let from = given.from.unwrap_or(From::Model);
    if given.photons.is_some() && from == From::Model {
        bail!("--photons is for --from reference: the model needs none");
    }
    let forward = args.forward()?;
    let kind = forward.kind();
    if from == From::Reference && kind != ModelKind::Vellus {
        bail!("--model {kind} is for --from model: the whole fibre is none");
    }
    if given.eta_m.is_some() && kind != ModelKind::Yan2015 {
        bail!("--eta-m: {kind} has one refractive index; only yan2015 takes two");
    }
    let step = given.step.unwrap_or(if from == From::Model { 2.0 } else { 4.0 });
    let synthetic = Synthetic {
        theta_o: args.theta_o.unwrap_or(default.theta_o),
        theta: args.theta.unwrap_or(default.theta),
        phi: args.phi.unwrap_or(default.phi),
        step: [step; 2],
        noise: given.noise.unwrap_or(default.noise),
        gaps: given.gaps.unwrap_or(default.gaps),
        scale,
        channels: if given.rgb { 3 } else { 1 },
        seed: args.seed,
    };
    output::writable(out)?;
    let (profile, what) = match from {
        From::Model => {
            let specimen = Specimen { fiber, eta_m: given.eta_m };
            let name = given.eta_m.map_or_else(|| kind.to_string(), |eta_m| format!("{kind}, eta_m {eta_m}"));
            (simulate::from_model(forward, &specimen, &synthetic)?, format!("the far field of {name}"))
        }
        From::Reference => {
            let photons = given.photons.unwrap_or(PHOTONS);
            let profile = simulate::from_reference(&fiber, &synthetic, photons, &Terminal::new())?;
            (profile, format!("the whole fibre, {photons} photons"))
        }
    };
    let notes = [
        format!("synthetic measurement of {}: {what}", fiber_args.name()),
        format!("noise {}, gaps {}, scale {scale}, seed {}", synthetic.noise, synthetic.gaps, synthetic.seed),
    ];
    output::write(Some(out), format(&profile, &notes).as_bytes())?;
    say!("wrote {}: {} directions, {} missing", out.display(), profile.points.len(), profile.missing.len());
    Ok(())
}
