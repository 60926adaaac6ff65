//! `vellus merge`: parts of a picture into one.

use super::denoise::Denoiser;
use super::parse::{self, Layers};
use super::write::{self, Picture};
use crate::output;
use crate::say::note;
use anyhow::{Context, Result, anyhow, bail};
use std::path::{Path, PathBuf};
use vellus_render::{Checkpoint, PixelType};

/// Merge films of sample ranges that `vellus render --samples` rendered separately. The result is bit-identical to the
/// picture of one run. A single film or checkpoint becomes a picture too.
///
/// Films must be undamaged and of the same picture, and their ranges must neither overlap nor leave gaps.
#[derive(clap::Args)]
pub struct MergeArgs {
    /// Films written by `vellus render --samples`, or checkpoints.
    #[arg(required = true, value_name = "FILM")]
    films: Vec<PathBuf>,
    /// Picture to write.
    #[arg(short, long, default_value = "out/render.exr", value_name = "FILE")]
    output: PathBuf,
    /// Stops by which the PNG is brighter.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse::exposure, value_name = "STOPS")]
    exposure: f32,
    /// Layers of the OpenEXR file, as `vellus render` has them; all that were rendered without it.
    #[arg(long, value_parser = parse::layers, value_name = "LAYERS")]
    layers: Option<Layers>,
    /// Merge films although samples are missing between them, before the first, or after one whose rendering was
    /// interrupted: for previews.
    #[arg(long)]
    allow_gaps: bool,
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
    output::writable(&args.output)?;
    let denoiser = args.denoise.then(Denoiser::load).transpose()?;
    // The order does not matter for the sums, so that no more than two films are in memory at once.
    let mut ranges = Vec::new();
    let mut whole: Option<Checkpoint> = None;
    for path in &args.films {
        let bytes = vellus_io::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        let mut part = Checkpoint::from_bytes(&bytes).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        drop(bytes);
        ranges.push(Range { path, samples: part.samples.clone(), planned: part.planned });
        let Some(sum) = &mut whole else {
            whole = Some(part);
            continue;
        };
        if sum.identity != part.identity || !sum.film.fits(&part.film) {
            bail!("{} and {} are not of the same picture", args.films[0].display(), path.display());
        }
        // The notes are those of the first samples.
        if part.samples.start < sum.samples.start {
            std::mem::swap(sum, &mut part);
        }
        sum.film.merge(&part.film);
    }
    let Some(whole) = whole else { bail!("no films") };
    check_ranges(ranges, args.allow_gaps)?;
    write::warn_of_full_pixels(&whole.film);
    let mut notes = whole.notes;
    notes.push(("vellus_samples".to_owned(), whole.film.samples().to_string()));
    notes.push(("vellus_merged".to_owned(), write::command()));
    Picture {
        path: &args.output,
        layers: args.layers.as_ref().map_or(&vellus_render::Layer::ALL, |layers| &layers.0),
        depth: if args.float { PixelType::Float } else { PixelType::Half },
        exposure: args.exposure,
        denoiser,
        notes,
    }
    .write(&whole.film)
}

/// Samples of a film, and the one after the last that was asked for.
struct Range<'a> {
    path: &'a Path,
    samples: std::ops::Range<u64>,
    planned: u64,
}

/// Refuses ranges that overlap. Refuses missing samples too, or warns of them where they are allowed.
fn check_ranges(mut ranges: Vec<Range>, allow_gaps: bool) -> Result<()> {
    ranges.sort_by_key(|range| range.samples.start);
    let mut missing = Vec::new();
    let mut next = 0;
    for (i, Range { path, samples, planned }) in ranges.iter().enumerate() {
        if samples.start < next {
            bail!("{} and {} have samples in common", ranges[i - 1].path.display(), path.display());
        }
        if samples.start > next {
            missing.push(format!("{next}..{} before {}", samples.start, path.display()));
        }
        // Gaps before another film are found there.
        if samples.end < *planned && i + 1 == ranges.len() {
            missing.push(format!("{}..{planned} of {}, which was stopped early", samples.end, path.display()));
        }
        next = samples.end;
    }
    if missing.is_empty() {
        return Ok(());
    }
    let missing = format!("samples are missing: {}", missing.join("; "));
    if !allow_gaps {
        bail!("{missing} (--allow-gaps merges the others, for a preview)");
    }
    note!("warning: {missing}");
    Ok(())
}
