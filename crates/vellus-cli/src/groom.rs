//! `vellus groom`: what is in a groom, and other formats of it.

use crate::output;
use crate::render::Input;
use anyhow::{Result, anyhow, bail};
use std::path::{Path, PathBuf};
use vellus_scene::Strands;

/// What to do.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Counts, bounds, widths and memory of all strands.
    Info {
        #[command(flatten)]
        input: Input,
    },
    /// Write it in another format: .usda with all there is, or .hair with one set of strands.
    Convert {
        #[command(flatten)]
        input: Input,
        /// File to write.
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
    },
}

/// Runs it.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::Info { input } => {
            for strands in &input.load()?.strands {
                print!("{}", info(strands));
            }
            Ok(())
        }
        Command::Convert { input, output } => convert(input, output),
    }
}

fn info(strands: &Strands) -> String {
    let (mut low, mut high) = (glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY);
    let (mut thinnest, mut thickest) = (f32::INFINITY, 0f32);
    for p in &strands.points {
        (low, high) = (low.min(p.truncate()), high.max(p.truncate()));
        (thinnest, thickest) = (thinnest.min(2.0 * p.w), thickest.max(2.0 * p.w));
    }
    let length =
        |i: usize| strands.strand(i).windows(2).map(|w| w[0].truncate().distance(w[1].truncate())).sum::<f32>();
    let mut lengths: Vec<f32> = (0..strands.len()).map(length).collect();
    lengths.sort_by(f32::total_cmp);
    let number = |x: f32| output::number(x.into());
    let corner = |v: glam::Vec3| v.to_array().map(number).join(", ");
    let varying: Vec<_> = strands.varying.iter().map(|(parameter, _)| parameter.key()).collect();
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let mut rows = vec![row("strands", strands.len().to_string()), row("segments", strands.segments().to_string())];
    rows.push(row("curve", format!("{:?}", strands.basis)));
    if let Some(median) = lengths.get(lengths.len() / 2) {
        rows.push(row("bounds", format!("({}) to ({})", corner(low), corner(high))));
        rows.push(row("widths", format!("{} to {}", number(thinnest), number(thickest))));
        let (shortest, longest) = (lengths[0], lengths[lengths.len() - 1]);
        rows.push(row("lengths", format!("{} to {}, median {}", number(shortest), number(longest), number(*median))));
    }
    if !varying.is_empty() {
        rows.push(row("varying", varying.join(", ")));
    }
    let bytes = size_of_val(&strands.points[..]) + size_of_val(&strands.starts[..]);
    rows.push(row("memory", format!("{:.1} MB", bytes as f64 * 1e-6)));
    let text: String = rows.iter().map(|row| format!("  {:10}{}\n", row[0], row[1])).collect();
    format!("{}\n{text}", strands.name)
}

fn convert(input: &Input, path: &Path) -> Result<()> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    if !matches!(extension, "hair" | "usda") {
        bail!("{}: the name must end in .usda or .hair", path.display());
    }
    let scene = input.load()?;
    if extension == "usda" {
        vellus_usd::write(&scene, path)?;
        println!("wrote {}", path.display());
        return Ok(());
    }
    let [strands] = &scene.strands[..] else {
        bail!("a .hair file holds one set of strands, the scene has {}", scene.strands.len());
    };
    let strands = vellus_groom::flatten(strands, 1);
    let bytes = vellus_groom::write_hair(&strands).map_err(|e| anyhow!("{}: {e}", path.display()))?;
    output::write(Some(path), &bytes)?;
    println!("wrote {}", path.display());
    Ok(())
}
