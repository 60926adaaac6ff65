//! Parsers of the options of `vellus render`.

use crate::number::finite;
use std::ops::Range;
use std::time::Duration;
use vellus_render::{Layer, MAX_SAMPLES};

/// A noise: a number above 0.
pub fn noise(text: &str) -> Result<f64, String> {
    finite(text, |x| x > 0.0, " above 0")
}

/// An exposure in stops, in [-100, 100].
pub fn exposure(text: &str) -> Result<f32, String> {
    finite(text, |x: f32| x.abs() <= 100.0, " in [-100, 100]")
}

/// A size: WIDTHxHEIGHT.
pub fn size(text: &str) -> Result<[usize; 2], String> {
    let parse = || {
        let (w, h) = text.split_once('x')?;
        Some([w.parse().ok()?, h.parse().ok()?])
    };
    match parse() {
        Some(size) if size.iter().all(|n| (1..=32_768).contains(n)) => Ok(size),
        _ => Err("a size is WIDTHxHEIGHT, each in [1, 32768]".to_owned()),
    }
}

/// A crop: X,Y,W,H.
pub fn crop(text: &str) -> Result<[usize; 4], String> {
    let numbers: Vec<usize> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, w, h] if w > 0 && h > 0 && text.split(',').count() == 4 => Ok([x, y, w, h]),
        _ => Err("a crop is X,Y,W,H in pixels, W and H at least 1".to_owned()),
    }
}

/// A width in pixels, in [0, 100].
pub fn pixels(text: &str) -> Result<f32, String> {
    let width = text.parse().unwrap_or(f32::NAN);
    if (0.0..=100.0).contains(&width) { Ok(width) } else { Err("a width is in [0, 100] pixels".to_owned()) }
}

/// A range of samples: A..B.
pub fn range(text: &str) -> Result<Range<u64>, String> {
    let parse = || {
        let (a, b) = text.split_once("..")?;
        Some(a.parse().ok()?..b.parse().ok()?)
    };
    match parse() {
        Some(range) if range.start < range.end && range.end <= MAX_SAMPLES => Ok(range),
        _ => Err(format!("samples are A..B with A < B, at most {MAX_SAMPLES}")),
    }
}

/// A range of frames, both ends included, and the step between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frames {
    pub first: i32,
    pub last: i32,
    pub step: u32,
}

/// The largest number of frames of one command.
const MAX_FRAMES: u64 = 1_000_000;

impl Frames {
    /// The number of frames.
    pub fn count(&self) -> u64 {
        u64::from(self.last.abs_diff(self.first)) / u64::from(self.step) + 1
    }

    /// The number of frame `i`, counted from 0.
    pub fn number(&self, i: u64) -> i32 {
        (i64::from(self.first) + (i * u64::from(self.step)) as i64) as i32
    }
}

/// A range of frames: A-B or A-BxS.
pub fn frames(text: &str) -> Result<Frames, String> {
    let parse = || {
        let (range, step) = text.split_once('x').unwrap_or((text, "1"));
        // The first sign may be that of a number.
        let dash = range.get(1..)?.find('-')? + 1;
        Some(Frames {
            first: range[..dash].parse().ok()?,
            last: range[dash + 1..].parse().ok()?,
            step: step.parse().ok()?,
        })
    };
    match parse() {
        Some(frames) if frames.first <= frames.last && frames.step > 0 => match frames.count() {
            ..=MAX_FRAMES => Ok(frames),
            count => Err(format!("these are {count} frames: at most {MAX_FRAMES} are rendered by one command")),
        },
        _ => Err("frames are A-B, or A-BxS for every S-th, whole numbers with A at most B, e.g. 1-48".to_owned()),
    }
}

/// A time: 60s, 5m, 2h.
pub fn duration(text: &str) -> Result<Duration, String> {
    let split = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let unit = match &text[split..] {
        "s" | "" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => f64::NAN,
    };
    let seconds = text[..split].parse().unwrap_or(f64::NAN) * unit;
    if (0.0..1e9).contains(&seconds) {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err("a time is e.g. 60s, 5m or 2h, and below 1e9 s".to_owned())
    }
}

/// The layers that are rendered and written.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers(pub Vec<Layer>);

/// Names of layers, separated by commas, or `all`.
pub fn layers(text: &str) -> Result<Layers, String> {
    if text == "all" {
        return Ok(Layers(Layer::ALL.to_vec()));
    }
    let layer = |name: &str| name.trim().parse().map_err(|e: vellus_render::Error| format!("{e}, all"));
    text.split(',').map(layer).collect::<Result<_, _>>().map(Layers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_read_as_written() {
        let read = |text| frames(text).map(|f| (f.first, f.last, f.step)).ok();
        assert_eq!(read("1-48"), Some((1, 48, 1)));
        assert_eq!(read("-5--2"), Some((-5, -2, 1)));
        assert_eq!(read("-5-10x5"), Some((-5, 10, 5)));
        let all = |text| frames(text).map(|f| (0..f.count()).map(|i| f.number(i)).collect::<Vec<_>>());
        assert_eq!(all("-5-10x6"), Ok(vec![-5, 1, 7]));
        assert_eq!(all("3-3"), Ok(vec![3]));
        for bad in ["", "-", "5", "9-1", "1-4x0", "1-b", "1..4", "é-2"] {
            assert_eq!(read(bad), None, "{bad}");
        }
        assert_eq!(read("1-1000000"), Some((1, 1_000_000, 1)));
        assert_eq!(read("-2147483648-2147483647x4295"), Some((i32::MIN, i32::MAX, 4295)));
        for many in ["0-1000000", "-2147483648-2147483647"] {
            assert!(frames(many).unwrap_err().contains("at most 1000000"), "{many}");
        }
    }

    #[test]
    fn every_layer_has_its_name() {
        assert_eq!(layers("depth,id"), Ok(Layers(vec![Layer::Depth, Layer::Strand])));
        assert_eq!(layers("uv, lights"), Ok(Layers(vec![Layer::RootUv, Layer::Lights])));
        assert_eq!(layers(&Layer::ALL.map(Layer::name).join(",")), layers("all"));
        assert!(layers("beauty,depht").unwrap_err().contains("'depht'"));
    }
}
