//! The pictures of an animation.

use super::Args;
use super::job::{self, Loaded};
use crate::interrupt::Interrupt;
use crate::say::note;
use anyhow::{Context, Result, bail};
use std::path::PathBuf;
use std::sync::Arc;
use vellus_render::Kept;
use vellus_render::session::{Frames, Goals, is_finished};
use vellus_render::tev::Viewer;

/// The file of a picture without `--frames`: a placeholder in its name becomes the number of `--frame`.
///
/// # Errors
/// If there is a placeholder, and no number for it.
pub fn single(args: &Args) -> Result<PathBuf> {
    if args.frames.is_some() || !Frames::is_pattern(&args.output) {
        return Ok(args.output.clone());
    }
    match args.input.frame {
        Some(frame) if frame == f64::from(frame as i32) => Ok(Frames::file(&args.output, frame as i32)),
        _ => bail!("-o {}: this name needs --frames, or a whole number as --frame", args.output.display()),
    }
}

/// Renders one picture, or all frames of `--frames`. With `--resume`, frames that are finished are left out.
pub fn run(args: &Args, interrupt: &Interrupt, mut viewer: Option<Viewer>) -> Result<()> {
    let Some(frames) = args.frames else {
        interrupt.set_immediate(true);
        let mut loaded = Loaded::new(&Args { output: single(args)?, ..args.clone() }, Arc::default())?;
        if args.input.frame.is_some() {
            loaded.stops = loaded.first_stops()?;
        }
        return job::run(loaded, interrupt, 1, &mut viewer);
    };
    let total = frames.count();
    let (mut stops, kept) = (None, Arc::<Kept>::default());
    for (frame, left) in frames.iter().zip((1..=total).rev()) {
        let mut one = args.clone();
        one.input.frame = Some(f64::from(frame));
        one.output = Frames::file(&args.output, frame);
        let mut render = || -> Result<()> {
            interrupt.set_immediate(true);
            let mut loaded = Loaded::new(&one, kept.clone())?;
            let goals = Goals { samples: args.spp, noise: args.noise, time: args.time };
            if args.resume && is_finished(&one.output, loaded.identity, &goals) {
                note!("frame {frame}: {} is finished", one.output.display());
                return Ok(());
            }
            note!("frame {frame} ({} of {total})", total - left + 1);
            if stops.is_none() {
                stops = loaded.first_stops()?;
            }
            loaded.stops = stops;
            job::run(loaded, interrupt, left, &mut viewer)
        };
        render().with_context(|| format!("frame {frame}"))?;
        if interrupt.is_set() && left > 1 {
            return Err(interrupt.error(format!("frames up to {frame} are finished; --resume continues")).into());
        }
    }
    Ok(())
}
