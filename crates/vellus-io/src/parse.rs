//! Parsers of values that users type. Their messages name the allowed values.

use std::ops::{Range, RangeInclusive};
use std::str::FromStr;
use std::time::Duration;

/// A parser of whole numbers in a range.
pub fn whole<T: TryFrom<u64>>(range: RangeInclusive<u64>) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let number = text.trim().parse().ok().filter(|number| range.contains(number));
        let number = number.and_then(|number| T::try_from(number).ok());
        number.ok_or_else(|| format!("it must be a whole number in [{}, {}]", range.start(), range.end()))
    }
}

/// A finite number. `range` describes the allowed numbers.
///
/// # Errors
/// A message if the text is not a number, or `is_good` refuses it.
pub fn finite<T: Copy + FromStr + Into<f64>>(text: &str, is_good: fn(T) -> bool, range: &str) -> Result<T, String> {
    let number = text.trim().parse().ok().filter(|&number: &T| number.into().is_finite() && is_good(number));
    number.ok_or_else(|| format!("it must be a finite number{range}"))
}

/// A finite number above 0.
///
/// # Errors
/// A message for any other text.
pub fn positive<T: Copy + FromStr + Into<f64>>(text: &str) -> Result<T, String> {
    finite(text, |x: T| x.into() > 0.0, " above 0")
}

/// Any finite number, such as a time code.
///
/// # Errors
/// A message for any other text.
pub fn real(text: &str) -> Result<f64, String> {
    finite(text, |_| true, "")
}

/// When a shutter opens and closes, `OPEN:CLOSE`, in frames relative to the frame. `off` and `0` are `0:0`.
///
/// # Errors
/// A message for any other text.
pub fn shutter(text: &str) -> Result<[f64; 2], String> {
    let times = if ["off", "0"].contains(&text) { Some([0.0; 2]) } else { numbers(text, ":") };
    let good = times.filter(|[open, close]: &[f64; 2]| open.is_finite() && close.is_finite() && open <= close);
    good.ok_or_else(|| "a shutter is OPEN:CLOSE in frames, OPEN at most CLOSE, e.g. -0.25:0.25, or off".to_owned())
}

/// A share in percent, such as `50%` or `50`, as a number in (0, 1].
///
/// # Errors
/// A message for any other text.
pub fn share(text: &str) -> Result<f32, String> {
    let percent = text.strip_suffix('%').unwrap_or(text).parse().unwrap_or(f32::NAN);
    let is_good = percent > 0.0 && percent <= 100.0;
    is_good.then_some(percent / 100.0).ok_or_else(|| "a share is above 0% and at most 100%".to_owned())
}

/// A multiple in percent, such as `400%` or `400`, as a number in (0, 100].
///
/// # Errors
/// A message for any other text.
pub fn multiple(text: &str) -> Result<f32, String> {
    let percent = text.strip_suffix('%').unwrap_or(text).parse().unwrap_or(f32::NAN);
    let is_good = percent > 0.0 && percent <= 10_000.0;
    is_good.then_some(percent / 100.0).ok_or_else(|| "it is above 0% and at most 10000%".to_owned())
}

/// An exposure in stops, in [-100, 100].
///
/// # Errors
/// A message for any other text.
pub fn exposure(text: &str) -> Result<f32, String> {
    finite(text, |x: f32| x.abs() <= 100.0, " in [-100, 100]")
}

/// A width in pixels, in [0, 100].
///
/// # Errors
/// A message for any other text.
pub fn pixels(text: &str) -> Result<f32, String> {
    let width = text.parse().ok().filter(|width| (0.0..=100.0).contains(width));
    width.ok_or_else(|| "a width is in [0, 100] pixels".to_owned())
}

/// A radiance above 0, at most 1e30.
///
/// # Errors
/// A message for any other text.
pub fn radiance(text: &str) -> Result<f32, String> {
    let radiance = text.parse().ok().filter(|&radiance| radiance > 0.0 && radiance <= 1e30);
    radiance.ok_or_else(|| "a radiance is above 0 and at most 1e30".to_owned())
}

/// A fixed count of numbers between separators. `None` for any other text.
pub fn numbers<T: FromStr, const N: usize>(text: &str, separator: &str) -> Option<[T; N]> {
    let numbers: Option<Vec<T>> = text.split(separator).map(|number| number.trim().parse().ok()).collect();
    numbers?.try_into().ok()
}

/// The size of a picture: `WIDTHxHEIGHT`.
///
/// # Errors
/// A message for any other text.
pub fn size(text: &str) -> Result<[usize; 2], String> {
    let size = numbers(text, "x").filter(|size: &[usize; 2]| size.iter().all(|n| (1..=32_768).contains(n)));
    size.ok_or_else(|| "a size is WIDTHxHEIGHT, each in [1, 32768]".to_owned())
}

/// A part of a picture: `X,Y,W,H`.
///
/// # Errors
/// A message for any other text.
pub fn crop(text: &str) -> Result<[usize; 4], String> {
    let crop = numbers(text, ",").filter(|&[_, _, w, h]| w > 0 && h > 0);
    crop.ok_or_else(|| "a crop is X,Y,W,H in pixels, W and H at least 1".to_owned())
}

/// A parser of ranges of samples, `A..B`, with B at most `max`.
pub fn samples(max: u64) -> impl Fn(&str) -> Result<Range<u64>, String> + Clone {
    move |text| {
        let range = numbers(text, "..").filter(|&[a, b]| a < b && b <= max);
        range.map(|[a, b]| a..b).ok_or_else(|| format!("samples are A..B with A < B, at most {max}"))
    }
}

/// A time, such as `60s`, `5m` or `2h`.
///
/// # Errors
/// A message for any other text.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_in_their_range() {
        let read = whole::<u32>(1..=4_294_967_296);
        assert_eq!((read("1"), read("4294967295")), (Ok(1), Ok(u32::MAX)));
        for bad in ["", "0", "-1", "1.5", "1e3", "nan", "4294967296", "99999999999999999999"] {
            assert_eq!(read(bad), Err("it must be a whole number in [1, 4294967296]".to_owned()), "{bad}");
        }
    }

    #[test]
    fn numbers_are_finite_and_in_their_range() {
        assert_eq!((positive::<f32>("0.5"), positive::<f32>("1e3")), (Ok(0.5), Ok(1000.0)));
        // 1e39 is infinite in single precision.
        for bad in ["", "0", "-1", "nan", "inf", "-inf", "1e39", "x"] {
            assert_eq!(positive::<f32>(bad), Err("it must be a finite number above 0".to_owned()), "{bad}");
        }
    }

    #[test]
    fn sizes_ranges_and_times_are_read() {
        assert_eq!((size("32x16"), crop("1,2,3,4")), (Ok([32, 16]), Ok([1, 2, 3, 4])));
        assert_eq!((samples(9)("2..9"), duration("2m")), (Ok(2..9), Ok(Duration::from_secs(120))));
        assert!(size("0x9").is_err() && crop("0,0,0,1").is_err() && samples(9)("2..10").is_err());
        assert!(duration("2y").is_err() && share("0%").is_err() && pixels("101").is_err());
        assert_eq!(
            (shutter("-0.25:0.5"), shutter("off"), shutter("0")),
            (Ok([-0.25, 0.5]), Ok([0.0; 2]), Ok([0.0; 2]))
        );
        assert!(["", "1", "0.5:0", "0:inf", "NaN:1", "0:1:2", "on"].iter().all(|text| shutter(text).is_err()));
        assert_eq!(radiance("0.5"), Ok(0.5));
        assert!(["0", "-1", "inf", "NaN", "2e30", "x"].iter().all(|text| radiance(text).is_err()));
    }
}
