//! The pictures of an animation.

use super::Args;
use super::job::{Job, Live, Loaded};
use crate::interrupt::Interrupt;
use crate::say::note;
use anyhow::{Context, Result};
use vellus_io::Digest;
use vellus_render::session::{Goals, is_finished, numbered};

/// Renders one picture, or all frames of `--frames`. With `--resume`, frames that are finished are left out.
pub fn run(args: &Args, interrupt: &Interrupt, mut viewer: Option<Live>) -> Result<()> {
    let Some(frames) = args.frames else {
        interrupt.set_immediate(true);
        return Job::new(args, Loaded::new(args)?, interrupt, 1)?.run(viewer.as_mut());
    };
    let total = frames.count();
    for i in 0..total {
        let frame = frames.number(i);
        let mut one = args.clone();
        one.input.set_frame(f64::from(frame));
        one.output = numbered(&args.output, frame);
        let mut render = || -> Result<()> {
            interrupt.set_immediate(true);
            let loaded = Loaded::new(&one)?;
            if args.resume && one.is_finished(loaded.identity) {
                note!("frame {frame}: {} is finished", one.output.display());
                return Ok(());
            }
            note!("frame {frame} ({} of {total})", i + 1);
            Job::new(&one, loaded, interrupt, total - i)?.run(viewer.as_mut())
        };
        render().with_context(|| format!("frame {frame}"))?;
        if interrupt.is_set() && i + 1 < total {
            return Err(interrupt.error(format!("frames up to {frame} are finished; --resume continues")).into());
        }
    }
    Ok(())
}

impl Args {
    /// Are the files of this picture complete?
    fn is_finished(&self, identity: Digest) -> bool {
        is_finished(&self.output, identity, &Goals { samples: self.spp, noise: self.noise, time: self.time })
    }
}
