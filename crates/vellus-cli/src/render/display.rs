//! How PNG files show pictures, on the command line.

use anyhow::{Context, Result};
use vellus_io::parse;
use vellus_render::{Display, Notes, Tone, World};

/// The note with the exposure that was measured.
const METERED_NOTE: &str = "vellus_metered";

/// How the PNG shows the picture.
#[derive(clap::Args, Clone)]
pub struct DisplayArgs {
    /// Make the PNG brighter by this many stops. `auto`: by as many as make white paper beside the fur white.
    #[arg(long, default_value = "0", allow_hyphen_values = true, value_parser = exposure, value_name = "auto|N")]
    exposure: Exposure,
    /// Tone curve of the PNG: neutral keeps colours and compresses highlights, agx has less contrast, srgb clips.
    #[arg(long, default_value_t = Tone::default(), value_name = "neutral|agx|srgb")]
    tone: Tone,
}

/// The exposure of a PNG.
#[derive(Clone, Copy)]
enum Exposure {
    Auto,
    Stops(f32),
}

fn exposure(text: &str) -> Result<Exposure, String> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    parse::exposure(text).map(Exposure::Stops).map_err(|error| format!("{error}, or auto"))
}

impl DisplayArgs {
    /// Adds the exposure that suits a world to the notes of its picture, if it is needed.
    pub fn measure(&self, world: &World, notes: &mut Notes) {
        if let Exposure::Auto = self.exposure {
            notes.push((METERED_NOTE.to_owned(), world.metered().unwrap_or(0.0).to_string()));
        }
    }

    /// How to show a picture with these notes.
    pub fn display(&self, notes: &Notes) -> Result<Display> {
        let exposure = match self.exposure {
            Exposure::Stops(stops) => stops,
            Exposure::Auto => {
                let note =
                    notes.iter().find(|(name, _)| name == METERED_NOTE).and_then(|(_, stops)| stops.parse().ok());
                note.context("--exposure auto: the films do not have it, render them with the same option")?
            }
        };
        Ok(Display { exposure, tone: self.tone })
    }
}
