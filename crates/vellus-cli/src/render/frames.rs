//! The pictures of an animation, one after the other.

use super::Args;
use super::goals::End;
use super::identity::IDENTITY_NOTE;
use super::job::{Job, Loaded};
use super::tev::Viewer;
use crate::interrupt::Interrupt;
use crate::say::note;
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};
use vellus_io::Digest;
use vellus_render::check_picture;

/// Renders them all, but for those that are finished already where `--resume` is given.
pub fn run(args: &Args, interrupt: &Interrupt, mut viewer: Option<Viewer>) -> Result<()> {
    let Some(frames) = args.frames else {
        interrupt.set_immediate(true);
        return Job::new(args, Loaded::new(args)?, interrupt, viewer.as_mut(), 1)?.run();
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
            if args.resume && is_finished(&one, loaded.identity) {
                note!("frame {frame}: {} is finished", one.output.display());
                return Ok(());
            }
            note!("frame {frame} ({} of {total})", i + 1);
            Job::new(&one, loaded, interrupt, viewer.as_mut(), total - i)?.run()
        };
        render().with_context(|| format!("frame {frame}"))?;
        if interrupt.is_set() && i + 1 < total {
            return Err(interrupt.error(format!("frames up to {frame} are finished; --resume continues")).into());
        }
    }
    Ok(())
}

/// `fur.exr` of frame 7 is `fur.0007.exr`.
pub fn numbered(path: &Path, frame: i32) -> PathBuf {
    let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let sign = if frame < 0 { "-" } else { "" };
    let number = frame.unsigned_abs();
    path.with_file_name(format!("{}.{sign}{number:04}.{}", part(path.file_stem()), part(path.extension())))
}

/// Are its files undamaged, of this picture, and rendered to the end of one of these goals? The PNG is written last.
fn is_finished(args: &Args, identity: Digest) -> bool {
    let png = args.output.with_extension("png");
    let notes = |path: &Path| check_picture(&vellus_io::read(path).ok()?).ok();
    let (Some(png), Some(output)) = (notes(&png), notes(&args.output)) else { return false };
    let note = |notes: &[(String, String)], name: &str| {
        notes.iter().find(|(key, _)| key == name).map(|(_, value)| value.clone()).unwrap_or_default()
    };
    let same = [&png, &output].iter().all(|notes| note(notes, IDENTITY_NOTE) == identity.to_string());
    let samples = |notes| note(notes, "vellus_samples").parse().unwrap_or(0u64);
    let ended = note(&png, "vellus_ended_by");
    let by = |end: End| ended == end.name();
    let reached =
        samples(&png) >= args.spp || by(End::Noise) && args.noise.is_some() || by(End::Time) && args.time.is_some();
    same && samples(&png) == samples(&output) && reached
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_before_the_extension() {
        let name = |path: &str, frame| numbered(Path::new(path), frame).to_string_lossy().into_owned();
        assert_eq!(name("out/fur.exr", 7), "out/fur.0007.exr");
        assert_eq!(name("fur.v2.png", 12345), "fur.v2.12345.png");
        assert_eq!(name("fur.exr", -3), "fur.-0003.exr");
    }
}
