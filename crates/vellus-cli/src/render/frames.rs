//! The pictures of an animation, one after the other.

use super::Args;
use super::goals::End;
use super::job::{Job, fingerprint};
use super::tev::Viewer;
use crate::say::note;
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Renders them all, but for those that are there already where `--resume` is given.
pub fn run(args: &Args, stop: &AtomicBool, mut viewer: Option<Viewer>) -> Result<()> {
    let Some(frames) = args.frames else {
        Job::new(args, stop, viewer.as_mut(), 1)?.run()?;
        return Ok(());
    };
    let numbers: Vec<i32> = (frames.first..=frames.last).step_by(frames.step as usize).collect();
    for (i, &frame) in numbers.iter().enumerate() {
        let mut one = args.clone();
        one.input.set_frame(f64::from(frame));
        one.output = numbered(&args.output, frame);
        if args.resume && is_done(&one)? {
            note!("frame {frame}: {} is there", one.output.display());
            continue;
        }
        note!("frame {frame} ({} of {})", i + 1, numbers.len());
        let mut job = || Job::new(&one, stop, viewer.as_mut(), (numbers.len() - i) as u64)?.run();
        if job().with_context(|| format!("frame {frame}"))? == End::Interrupted {
            break;
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

/// Is it rendered, with these options, to its end? The PNG, written last, says so.
fn is_done(args: &Args) -> Result<bool> {
    let png = args.output.with_extension("png");
    if !args.output.exists() {
        return Ok(false);
    }
    let Ok(file) = std::fs::File::open(png) else { return Ok(false) };
    let Ok(reader) = png::Decoder::new(std::io::BufReader::new(file)).read_info() else { return Ok(false) };
    let note = |name: &str| {
        let chunk = reader.info().utf8_text.iter().find(|chunk| chunk.keyword == name)?;
        chunk.get_text().ok()
    };
    let same = note("vellus_fingerprint") == Some(format!("{:016x}", fingerprint(args)?));
    let samples = note("vellus_samples").and_then(|n| n.parse().ok()).unwrap_or(0u64);
    let ended = note("vellus_ended_by");
    let by = |end: End| ended.as_deref() == Some(end.name());
    Ok(same && (samples >= args.spp || by(End::Noise) && args.noise.is_some() || by(End::Time) && args.time.is_some()))
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
