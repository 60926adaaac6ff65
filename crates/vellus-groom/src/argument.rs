//! Parsers of command-line options.

use std::ops::RangeInclusive;

/// Parses a whole number in a range.
pub(crate) fn whole(range: RangeInclusive<usize>) -> impl Fn(&str) -> Result<usize, String> + Clone {
    move |text| {
        let number = text.trim().parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("it must be a whole number in [{}, {}]", range.start(), range.end()))
    }
}

/// Parses a direction: X,Y,Z.
pub(crate) fn vector(text: &str) -> Result<[f32; 3], String> {
    let numbers: Vec<f32> = text.split(',').filter_map(|x| x.trim().parse().ok()).collect();
    <[f32; 3]>::try_from(numbers).map_err(|_| "a direction is X,Y,Z".to_owned())
}
