//! Parsers of the options of `vellus render`.

use crate::number::finite;
use std::ops::Range;
use std::str::FromStr;
use std::time::Duration;
use vellus_render::MAX_SAMPLES;

/// A number above 0.
pub fn positive<T: Copy + FromStr + Into<f64>>(text: &str) -> Result<T, String> {
    finite(text, |x: T| x.into() > 0.0, " above 0")
}

/// A time code.
pub fn time_code(text: &str) -> Result<f64, String> {
    finite(text, |_| true, "")
}

/// A share in percent.
pub fn share(text: &str) -> Result<f32, String> {
    let percent = text.strip_suffix('%').unwrap_or(text).parse().unwrap_or(f32::NAN);
    let is_good = percent > 0.0 && percent <= 100.0;
    is_good.then_some(percent / 100.0).ok_or_else(|| "a share is above 0% and at most 100%".to_owned())
}

/// An exposure in stops.
pub fn exposure(text: &str) -> Result<f32, String> {
    finite(text, |x: f32| x.abs() <= 100.0, " in [-100, 100]")
}

/// A width in pixels.
pub fn pixels(text: &str) -> Result<f32, String> {
    let width = text.parse().ok().filter(|width| (0.0..=100.0).contains(width));
    width.ok_or_else(|| "a width is in [0, 100] pixels".to_owned())
}

/// A fixed count of numbers between separators.
fn numbers<T: FromStr, const N: usize>(text: &str, separator: &str) -> Option<[T; N]> {
    let numbers: Option<Vec<T>> = text.split(separator).map(|number| number.trim().parse().ok()).collect();
    numbers?.try_into().ok()
}

/// A size: WIDTHxHEIGHT.
pub fn size(text: &str) -> Result<[usize; 2], String> {
    let size = numbers(text, "x").filter(|size: &[usize; 2]| size.iter().all(|n| (1..=32_768).contains(n)));
    size.ok_or_else(|| "a size is WIDTHxHEIGHT, each in [1, 32768]".to_owned())
}

/// A crop: X,Y,W,H.
pub fn crop(text: &str) -> Result<[usize; 4], String> {
    let crop = numbers(text, ",").filter(|&[_, _, w, h]| w > 0 && h > 0);
    crop.ok_or_else(|| "a crop is X,Y,W,H in pixels, W and H at least 1".to_owned())
}

/// A range of samples: A..B.
pub fn range(text: &str) -> Result<Range<u64>, String> {
    let range = numbers(text, "..").filter(|&[a, b]| a < b && b <= MAX_SAMPLES);
    range.map(|[a, b]| a..b).ok_or_else(|| format!("samples are A..B with A < B, at most {MAX_SAMPLES}"))
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
    let time = (0.0..1e9).contains(&seconds).then(|| Duration::from_secs_f64(seconds));
    time.ok_or_else(|| "a time is e.g. 60s, 5m or 2h, and below 1e9 s".to_owned())
}
