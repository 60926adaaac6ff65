//! The frames of an animation.

use crate::error::Error;
use std::ops::Range;
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
/// assert_eq!(Frames::file(Path::new("out/fur_######.exr"), 13), Path::new("out/fur_000013.exr"));
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

    /// The file of one frame: `fur.exr` of frame 7 is `fur.0007.exr`. If the name has a
    /// [placeholder](Frames::is_pattern), the last one becomes the number: `fur_###.exr` and `fur_%03d.exr` are
    /// `fur_007.exr`.
    pub fn file(path: &Path, frame: i32) -> PathBuf {
        let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
        let sign = if frame < 0 { "-" } else { "" };
        let number = |digits: usize| format!("{sign}{:0digits$}", frame.unsigned_abs());
        let mut name = part(path.file_name());
        path.with_file_name(match placeholder(&name) {
            Some((place, digits)) => {
                name.replace_range(place, &number(digits));
                name
            }
            None => format!("{}.{}.{}", part(path.file_stem()), number(4), part(path.extension())),
        })
    }

    /// Whether the name of a file has a placeholder for the number of a frame: two or more `#`, one for each digit, or
    /// `%d` or `%04d`, as in C.
    pub fn is_pattern(path: &Path) -> bool {
        path.file_name().is_some_and(|name| placeholder(&name.to_string_lossy()).is_some())
    }
}

/// The last placeholder of a name, and its least number of digits.
fn placeholder(name: &str) -> Option<(Range<usize>, usize)> {
    let hashes = || {
        let end = name.rfind("##")? + 2;
        let digits = end - name[..end].trim_end_matches('#').len();
        Some((end - digits..end, digits))
    };
    let format = |(start, _)| {
        let digits = name[start + 1..].split_once('d')?.0;
        let is_good = digits.len() < 3 && digits.bytes().all(|digit| digit.is_ascii_digit());
        is_good.then(|| (start..start + digits.len() + 2, digits.parse().unwrap_or(1)))
    };
    let formats = name.rmatch_indices('%').find_map(format);
    hashes().into_iter().chain(formats).max_by_key(|(place, _)| place.start)
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
    fn placeholders_become_the_number() {
        let name = |path: &str, frame| Frames::file(Path::new(path), frame).to_string_lossy().into_owned();
        for (path, frame, expected) in [
            ("out/fur.####.exr", 7, "out/fur.0007.exr"),
            ("####_##.png", 7, "####_07.png"),
            ("fur%04d.exr", 12345, "fur12345.exr"),
            ("fur_%d.exr", 7, "fur_7.exr"),
            ("é%02dé##é.exr", -7, "é%02dé-07é.exr"),
            ("##_%3d.exr", 7, "##_007.exr"),
            // These are names.
            ("take#2.exr", 7, "take#2.0007.exr"),
            ("50%.exr", 7, "50%.0007.exr"),
            ("%_d.%999d", 7, "%_d.0007.%999d"),
            ("##/fur.exr", 7, "##/fur.0007.exr"),
        ] {
            assert_eq!(name(path, frame), expected);
            let is_pattern = !expected.contains(".0007.") || path.contains("fur.##");
            assert_eq!(Frames::is_pattern(Path::new(path)), is_pattern, "{path}");
        }
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
