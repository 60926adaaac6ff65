//! `vellus merge`: films of sample ranges become one picture.

use super::Layers;
use super::display::DisplayArgs;
use super::job::typed_command;
use super::screen::print;
use crate::output;
use crate::say::note;
use anyhow::{Result, bail};
use std::path::PathBuf;
use vellus_render::denoise::Denoiser;
use vellus_render::session::{Event, Merge, Picture, SAMPLES_NOTE, read_film};
use vellus_render::{Denoise, Layer, PixelType};

/// Merge films that `vellus render --samples` rendered separately.
///
/// The result has the same bits as the picture of one run. A single film or checkpoint becomes a picture too.
///
/// Films must be undamaged and of the same picture. Their ranges must neither overlap nor leave gaps.
#[derive(clap::Args)]
pub struct MergeArgs {
    /// Films written by `vellus render --samples`, or checkpoints.
    #[arg(required = true, value_name = "FILM")]
    films: Vec<PathBuf>,
    /// Picture to write.
    #[arg(short, long, default_value = "out/render.exr", value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    display: DisplayArgs,
    /// Layers of the OpenEXR file, with the names of `vellus render --layers` [default: those that the films
    /// were rendered for].
    #[arg(long, value_parser = Layer::list, value_name = "LAYERS")]
    layers: Option<Layers>,
    /// Merge films even if samples are missing between them, before the first, or after a film whose rendering was
    /// interrupted: for previews.
    #[arg(long)]
    allow_gaps: bool,
    /// Denoise the beauty as well, as `vellus render` does.
    #[arg(long)]
    denoise: bool,
    /// Store colours in 32 bits instead of 16.
    #[arg(long)]
    float: bool,
}

/// Merges films, and writes the picture.
pub fn merge(args: &MergeArgs) -> Result<()> {
    output::check_extension(&args.output, &["exr", "png"])?;
    output::writable(&args.output)?;
    let denoiser = args.denoise.then(Denoiser::load).transpose()?;
    let mut merge = Merge::new();
    for path in &args.films {
        merge.add(path.display().to_string(), read_film(path)?)?;
    }
    let merged = merge.finish()?;
    if !merged.gaps.is_empty() {
        let missing = format!("samples are missing: {}", merged.gaps.join("; "));
        if !args.allow_gaps {
            bail!("{missing} (--allow-gaps merges the others, for a preview)");
        }
        note!("warning: {missing}");
    }
    if let full @ 1.. = merged.film.full_pixels() {
        print(Event::FullPixels(full));
    }
    let mut notes = merged.notes;
    notes.push((SAMPLES_NOTE.to_owned(), merged.film.samples().to_string()));
    notes.push(("vellus_merged".to_owned(), typed_command()));
    let picture = Picture {
        path: args.output.clone(),
        layers: args.layers.clone().unwrap_or(merged.layers),
        pixel_type: if args.float { PixelType::Float } else { PixelType::Half },
        display: args.display.display(&notes)?,
        notes,
    };
    let denoiser = denoiser.as_ref().map(|denoiser| denoiser as &dyn Denoise);
    picture.write_denoised(&merged.film, denoiser, print)?;
    Ok(())
}
