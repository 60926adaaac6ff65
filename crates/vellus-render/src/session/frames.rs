//! The frames of an animation.

use crate::error::Error;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The largest number of frames of an animation.
const MAX_FRAMES: u64 = 1_000_000;

/// A range of frames: both ends are included. At most a million.
///
/// ```
/// use std::path::Path;
/// use vellus_render::session::Frames;
///
/// let frames: Frames = "1-48x12".parse()?;
/// assert_eq!(frames.iter().collect::<Vec<_>>(), [1, 13, 25, 37]);
/// assert_eq!(Frames::file(Path::new("out/fur.exr"), 13), Path::new("out/fur.0013.exr"));
/// # Ok::<(), vellus_render::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    first: i32,
    last: i32,
    step: u32,
}

impl Frames {
    /// The first frame.
    pub fn first(&self) -> i32 {
        self.first
    }

    /// The number of frames.
    pub fn count(&self) -> u64 {
        u64::from(self.last.abs_diff(self.first)) / u64::from(self.step) + 1
    }

    /// The frames, in order.
    pub fn iter(&self) -> impl Iterator<Item = i32> {
        (i64::from(self.first)..=i64::from(self.last)).step_by(self.step as usize).map(|frame| frame as i32)
    }

    /// The file of one frame: `fur.exr` of frame 7 is `fur.0007.exr`.
    pub fn file(path: &Path, frame: i32) -> PathBuf {
        let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
        let sign = if frame < 0 { "-" } else { "" };
        let number = frame.unsigned_abs();
        path.with_file_name(format!("{}.{sign}{number:04}.{}", part(path.file_stem()), part(path.extension())))
    }
}

impl FromStr for Frames {
    type Err = Error;

    /// Reads `A-B`, or `A-BxS` for every S-th frame.
    fn from_str(text: &str) -> Result<Self, Error> {
        let parse = || {
            let (range, step) = text.split_once('x').unwrap_or((text, "1"));
            // The first sign may be that of a number.
            let dash = range.get(1..)?.find('-')? + 1;
            let (first, last) = (range[..dash].parse().ok()?, range[dash + 1..].parse().ok()?);
            Some(Frames { first, last, step: step.parse().ok()? })
        };
        let what = match parse() {
            Some(frames) if frames.first <= frames.last && frames.step > 0 => match frames.count() {
                ..=MAX_FRAMES => return Ok(frames),
                count => format!("these are {count} frames: at most {MAX_FRAMES} are rendered by one command"),
            },
            _ => "frames are A-B, or A-BxS for every S-th, whole numbers with A at most B, e.g. 1-48".to_owned(),
        };
        Err(Error::Settings(what))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_before_the_extension() {
        let name = |path: &str, frame| Frames::file(Path::new(path), frame).to_string_lossy().into_owned();
        assert_eq!(name("out/fur.exr", 7), "out/fur.0007.exr");
        assert_eq!(name("fur.v2.png", 12345), "fur.v2.12345.png");
        assert_eq!(name("fur.exr", -3), "fur.-0003.exr");
    }

    #[test]
    fn frames_are_read_as_written() {
        let read = |text: &str| text.parse().map(|f: Frames| (f.first, f.last, f.step)).ok();
        assert_eq!(read("1-48"), Some((1, 48, 1)));
        assert_eq!(read("-5--2"), Some((-5, -2, 1)));
        assert_eq!(read("-5-10x5"), Some((-5, 10, 5)));
        let all = |text: &str| text.parse().map(|f: Frames| f.iter().collect::<Vec<_>>()).unwrap();
        assert_eq!(all("-5-10x6"), [-5, 1, 7]);
        assert_eq!(all("3-3"), [3]);
        for bad in ["", "-", "5", "9-1", "1-4x0", "1-b", "1..4", "é-2"] {
            assert_eq!(read(bad), None, "{bad}");
        }
        assert_eq!(read("1-1000000"), Some((1, 1_000_000, 1)));
        assert_eq!(read("-2147483648-2147483647x4295"), Some((i32::MIN, i32::MAX, 4295)));
        let all = "-2147483648-2147483647x4295".parse::<Frames>().unwrap();
        assert_eq!(all.iter().count() as u64, all.count());
        for many in ["0-1000000", "-2147483648-2147483647"] {
            assert!(many.parse::<Frames>().unwrap_err().to_string().contains("at most 1000000"), "{many}");
        }
    }
}
