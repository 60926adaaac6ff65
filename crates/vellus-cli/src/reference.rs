//! `vellus reference`: light in the whole fibre, beside the model.

use crate::fiber_args::Incidence;
use crate::number::whole;
use crate::output::{self, Format};
use crate::terminal::Terminal;
use anyhow::Result;
use serde_json::json;
use vellus::{Bcsdf, Lobe};
use vellus_sim::energies::{Fate, Offsets, energies};

/// The most photons: months of work.
const MAX_PHOTONS: u64 = 1_000_000_000_000;

/// Which fibre and light.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    incidence: Incidence,
    /// One offset in [-1, 1]; without it, uniform over the fibre's width.
    #[arg(long, allow_negative_numbers = true)]
    h: Option<f64>,
    /// Photons traced.
    #[arg(long, default_value_t = 1_000_000, value_parser = whole::<u64>(2..=MAX_PHOTONS), value_name = "N")]
    photons: u64,
    /// Seed; the same one gives the same result on any number of threads.
    #[arg(long, default_value_t = 1, value_parser = whole::<u64>(0..=u64::MAX), value_name = "N")]
    seed: u64,
    #[command(flatten)]
    output: output::OutputArgs,
}

/// Key, mean, standard error, and what the model has for it.
type Line = (&'static str, [f64; 3], [f64; 3], Option<[f64; 3]>);

/// Runs it.
pub fn run(args: &Args) -> Result<()> {
    let fiber = args.incidence.fiber.load()?;
    args.output.check()?;
    let bcsdf = Bcsdf::new(&fiber)?;
    let offsets = args.h.map_or(Offsets::Whole, Offsets::At);
    let theta_o = args.incidence.theta_o.to_radians();
    let result = energies(&fiber, theta_o, offsets, args.photons, args.seed, &Terminal::new())?;
    let model = vellus_models::energies(&bcsdf, args.incidence.theta_o, args.h);
    let add = |lobes: &[Lobe]| [0, 1, 2].map(|c| lobes.iter().map(|&l| model[l as usize][c]).sum::<f64>());
    // `rest` holds higher orders of both kinds, and is counted as unscattered.
    let model_of = |fate: Fate| match fate {
        Fate::R => Some(add(&[Lobe::R])),
        Fate::Tt => Some(add(&[Lobe::Tt])),
        Fate::Trt => Some(add(&[Lobe::Trt])),
        Fate::Higher => Some(add(&[Lobe::Residual])),
        Fate::Scattered => Some(add(&[Lobe::Tts, Lobe::Trts])),
        Fate::Guided => None,
    };
    let mut lines: Vec<Line> =
        Fate::ALL.iter().map(|&f| (f.key(), result.mean[f as usize], result.error[f as usize], model_of(f))).collect();
    lines.push(("total", result.total[0], result.total[1], Some(add(&Lobe::ALL))));
    let text = match args.output.format {
        Format::Table => {
            let mut rows = vec![["", "reference", "± 1 s.e.", "model", "model/reference"].map(str::to_owned).to_vec()];
            // Three rows a line only where the channels differ.
            let grey = lines.iter().all(|(_, mean, _, _)| mean[0] == mean[1] && mean[1] == mean[2]);
            for (key, mean, error, model) in &lines {
                for c in 0..if grey { 1 } else { 3 } {
                    let name = if grey { (*key).to_owned() } else { format!("{key} {}", ["red", "green", "blue"][c]) };
                    let ratio = model.filter(|_| mean[c] > 0.0).map(|m| format!("{:.4}", m[c] / mean[c]));
                    let model = model.map(|m| output::number(m[c]));
                    rows.push(vec![
                        name,
                        output::number(mean[c]),
                        output::number(error[c]),
                        model.unwrap_or_default(),
                        ratio.unwrap_or_default(),
                    ]);
                }
            }
            format!(
                "energy of light from θ_o {}°, {} photons\n{}",
                args.incidence.theta_o,
                args.photons,
                output::align(&rows)
            )
        }
        Format::Csv => {
            let mut text = "fate,mean.r,mean.g,mean.b,error.r,error.g,error.b\n".to_owned();
            for (key, mean, error, _) in &lines {
                let values: Vec<String> = mean.iter().chain(error).map(f64::to_string).collect();
                text += &format!("{key},{}\n", values.join(","));
            }
            text
        }
        Format::Json | Format::Jsonl => {
            let fates: serde_json::Map<_, _> = lines
                .iter()
                .map(|(key, mean, error, model)| {
                    ((*key).to_owned(), json!({"mean": mean, "standard_error": error, "model": model}))
                })
                .collect();
            let h = args.h.map_or(json!("whole width"), |h| json!(h));
            format!(
                "{}\n",
                json!({"theta_o": args.incidence.theta_o, "h": h, "photons": args.photons, "seed": args.seed, "energies": fates})
            )
        }
    };
    args.output.write(text.as_bytes())
}
