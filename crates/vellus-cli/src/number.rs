//! Parsers of values on the command line. Their messages name the allowed values.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use std::error::Error;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Parses a whole number in a range.
pub fn whole<T: TryFrom<u64>>(range: RangeInclusive<u64>) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let number = text.trim().parse().ok().filter(|number| range.contains(number));
        let number = number.and_then(|number| T::try_from(number).ok());
        number.ok_or_else(|| format!("it must be a whole number in [{}, {}]", range.start(), range.end()))
    }
}

/// Parses a finite number. `range` describes the allowed numbers.
pub fn finite<T: Copy + FromStr + Into<f64>>(text: &str, is_good: fn(T) -> bool, range: &str) -> Result<T, String> {
    let number = text.trim().parse().ok().filter(|&number: &T| number.into().is_finite() && is_good(number));
    number.ok_or_else(|| format!("it must be a finite number{range}"))
}

/// Parses one of several names. The help lists them.
pub fn one_of<T>(names: impl IntoIterator<Item = &'static str>) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err: Into<Box<dyn Error + Send + Sync>>> + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(|name| name.parse::<T>().map_err(Into::into))
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
        let read = |text| finite::<f32>(text, |x| x > 0.0, " above 0");
        assert_eq!((read("0.5"), read("1e3")), (Ok(0.5), Ok(1000.0)));
        // 1e39 is infinite in single precision.
        for bad in ["", "0", "-1", "nan", "inf", "-inf", "1e39", "x"] {
            assert_eq!(read(bad), Err("it must be a finite number above 0".to_owned()), "{bad}");
        }
    }
}
