//! `vellus merge`: parts of a picture into one.

use super::denoise::Denoiser;
use super::parse::{self, Layers};
use super::write::{self, Picture};
use crate::output;
use anyhow::{Context, Result, anyhow, bail};
use std::path::PathBuf;
use vellus_render::{Depth, Part};

/// Put together what `vellus render --samples` rendered apart: the very picture of one run. A single film or checkpoint becomes a
/// picture too.
#[derive(clap::Args)]
pub struct MergeArgs {
    /// Films written by `vellus render --samples`, or checkpoints.
    #[arg(required = true, value_name = "FILM")]
    films: Vec<PathBuf>,
    /// Picture to write.
    #[arg(short, long, default_value = "out/render.exr", value_name = "FILE")]
    output: PathBuf,
    /// Stops by which the PNG is brighter.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_name = "STOPS")]
    exposure: f32,
    /// Layers of the OpenEXR file, as `vellus render` has them; all that were rendered without it.
    #[arg(long, value_parser = parse::layers, value_name = "LAYERS")]
    layers: Option<Layers>,
    /// Denoise the beauty as well, as `vellus render` does.
    #[arg(long)]
    denoise: bool,
    /// Store colours in 32 bit, not 16.
    #[arg(long)]
    float: bool,
}

/// Merges.
pub fn merge(args: &MergeArgs) -> Result<()> {
    write::check_name(&args.output)?;
    let denoiser = args.denoise.then(Denoiser::load).transpose()?;
    let mut parts = Vec::new();
    for path in &args.films {
        let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        let part = Part::from_bytes(&bytes).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        parts.push((path, part));
    }
    parts.sort_by_key(|(_, part)| part.samples.start);
    for pair in parts.windows(2) {
        let ((a_path, a), (b_path, b)) = (&pair[0], &pair[1]);
        if a.fingerprint != b.fingerprint || !a.film.fits(&b.film) {
            bail!("{} and {} are not of the same picture", a_path.display(), b_path.display());
        }
        if b.samples.start < a.samples.end {
            bail!("{} and {} have samples in common", a_path.display(), b_path.display());
        }
    }
    output::writable(&args.output)?;
    let mut parts = parts.into_iter().map(|(_, part)| part);
    let Some(mut whole) = parts.next() else { bail!("no films") };
    parts.for_each(|part| whole.film.merge(&part.film));
    let mut notes = whole.notes;
    notes.push(("vellus_samples".to_owned(), whole.film.samples().to_string()));
    notes.push(("vellus_merged".to_owned(), write::command()));
    Picture {
        path: &args.output,
        layers: args.layers.as_ref().map_or(&vellus_render::Layer::ALL, |layers| &layers.0),
        depth: if args.float { Depth::Float } else { Depth::Half },
        exposure: args.exposure,
        denoiser,
        notes,
    }
    .write(&whole.film)
}
