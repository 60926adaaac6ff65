//! `vellus fit --simulate`: writes a synthetic measurement.

use crate::fiber_args::FiberArgs;
use crate::number::one_of;
use crate::output;
use crate::say::say;
use crate::terminal::Terminal;
use anyhow::{Context, Result, bail};
use std::path::PathBuf;
use vellus_fit::simulate::Source;
use vellus_fit::{Absorption, Forward, Specimen, Synthetic, channels_csv, writer};
use vellus_models::ModelKind;
use vellus_render_models::Method;

/// The options of a synthetic measurement.
#[derive(clap::Args)]
pub struct Gantry {
    /// Write a synthetic measurement of this fibre: a preset, or a TOML or JSON file.
    #[arg(long, value_name = "NAME|FILE")]
    simulate: Option<String>,
    /// Set a parameter of that fibre, such as kappa=0.5. May be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", conflicts_with = "profiles")]
    set: Vec<String>,
    /// Refractive index of the medulla, only for yan2015. Default: the index of the cortex.
    #[arg(long, value_name = "INDEX", conflicts_with = "profiles")]
    eta_m: Option<f32>,
    /// What to measure: the far field of the model, or a whole fibre with a rough cuticle, simulated with photons.
    #[arg(long, value_parser = one_of::<String>(["model", "reference"]), default_value = "model", value_name = "WHAT",
          conflicts_with = "profiles")]
    from: String,
    /// Number of photons for --from reference [default: 4000000].
    #[arg(long, value_name = "N", conflicts_with = "profiles", value_parser = clap::value_parser!(u64).range(1..))]
    photons: Option<u64>,
    /// Relative noise of each value [default: 0.02].
    #[arg(long, value_name = "X", conflicts_with = "profiles")]
    noise: Option<f64>,
    /// Share of missing directions, in patches [default: 0.1].
    #[arg(long, value_name = "X", conflicts_with = "profiles")]
    gaps: Option<f64>,
    /// Step in θ and φ, degrees [default: 2; with --from reference 4].
    #[arg(long, value_name = "DEG", conflicts_with = "profiles")]
    step: Option<f64>,
    /// Factor on all values [default: 1].
    #[arg(long, value_name = "X", conflicts_with = "profiles")]
    scale: Option<f64>,
    /// Light that does not come from the fibre, added to all values [default: 0].
    #[arg(long, value_name = "X", conflicts_with = "profiles")]
    background: Option<f64>,
    /// Measure red, green and blue. Default: red only.
    #[arg(long, conflicts_with = "profiles")]
    rgb: bool,
    /// Measure any number of channels, only with --from model and a .csv file: CSV with the columns channel, sigma_ca
    /// and sigma_ma.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["profiles", "rgb"])]
    absorption: Option<PathBuf>,
}

/// The default of `--photons`. The noise is then about 2 % in cells of 4°.
const PHOTONS: u64 = 4_000_000;

pub fn run(args: &super::Args) -> Result<()> {
    let given = &args.synthetic;
    let Some(name) = &given.simulate else { bail!("a profile is needed, or --simulate") };
    if args.format != "table" {
        bail!("--format is for a fit: a synthetic measurement is .txt or .csv, see --out");
    }
    let fiber_args = FiberArgs::new(name, &given.set);
    let fiber = fiber_args.load()?;
    let out = args.out.as_ref().context("--simulate needs --out FILE, .txt or .csv")?;
    let write = writer(out)?;
    let forward = Forward::new(args.model)?;
    let kind = forward.kind();
    Method::new(kind, given.eta_m).context("--eta-m")?;
    let (source, step) = if given.from == "model" {
        if given.photons.is_some() {
            bail!("--photons is only for --from reference");
        }
        (Source::Model(forward, Specimen { fiber, eta_m: given.eta_m }), 2.0)
    } else if kind != ModelKind::Vellus {
        bail!("--model {kind} is only for --from model: --from reference uses no model");
    } else {
        (Source::Reference(fiber, given.photons.unwrap_or(PHOTONS)), 4.0)
    };
    let default = Synthetic::default();
    let theta_o = match args.theta_o[..] {
        [] => default.theta_o,
        [one] => one,
        _ => bail!("--simulate takes one value of --theta-o"),
    };
    if given.from == "reference" && args.blur.is_some() {
        bail!("--blur is only for --from model: a traced fibre has cells of the size of --step");
    }
    let gantry = Synthetic {
        theta_o,
        theta: args.theta.map_or(default.theta, |axis| [axis.first, axis.last]),
        phi: args.phi.map_or(default.phi, |axis| [axis.first, axis.last]),
        step: [given.step.unwrap_or(step); 2],
        noise: given.noise.unwrap_or(default.noise),
        gaps: given.gaps.unwrap_or(default.gaps),
        scale: given.scale.unwrap_or(default.scale),
        background: given.background.unwrap_or(default.background),
        blur: args.blur.unwrap_or(default.blur),
        channels: if given.rgb { 3 } else { 1 },
        seed: args.seed,
    };
    if let Some(path) = &given.absorption {
        let Source::Model(forward, specimen) = source else { bail!("--absorption is only for --from model") };
        if out.extension().is_none_or(|e| e != "csv") {
            bail!("--absorption needs --out FILE.csv: {} has no place for channels", out.display());
        }
        let absorptions = Absorption::read(path)?;
        output::writable(out)?;
        let profiles = vellus_fit::simulate::channels(forward, &specimen, &absorptions, &gantry)?;
        let notes = [format!("synthetic measurement of {}: {source}", fiber_args.name()), gantry.to_string()];
        output::write(Some(out), channels_csv(&profiles, &notes).as_bytes())?;
        let (count, directions) = (profiles.len(), profiles.first().map_or(0, |p| p.points.len()));
        say!("wrote {}: {count} channels, {directions} directions", out.display());
        return Ok(());
    }
    output::writable(out)?;
    let profile = source.measure(&gantry, &Terminal::new())?;
    let notes = [format!("synthetic measurement of {}: {source}", fiber_args.name()), gantry.to_string()];
    output::write(Some(out), write(&profile, &notes).as_bytes())?;
    say!("wrote {}: {} directions, {} missing", out.display(), profile.points.len(), profile.missing.len());
    Ok(())
}
