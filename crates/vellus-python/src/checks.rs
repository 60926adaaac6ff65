//! Ranges of arguments that are single numbers.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// The error for a number outside of its range, such as "in [0, 1]".
pub fn out_of_range(name: &str, x: impl Display, range: &str) -> PyErr {
    PyValueError::new_err(format!("{name} = {x} is out of range: it must be {range}"))
}

/// A whole number in a range. It comes as `i128`, so that Python's negative and large numbers get this error and no
/// `OverflowError` without a name.
///
/// # Errors
/// `ValueError` that names argument, value and range.
pub fn whole<T: TryFrom<i128> + PartialOrd + Display>(name: &str, x: i128, range: RangeInclusive<T>) -> PyResult<T> {
    let (low, high) = (range.start(), range.end());
    let number = T::try_from(x).ok().filter(|x| range.contains(x));
    number.ok_or_else(|| out_of_range(name, x, &format!("in [{low}, {high}]")))
}

/// A seed: any number of 64 bits.
///
/// # Errors
/// As [`whole`].
pub fn seed(x: i128) -> PyResult<u64> {
    whole("seed", x, 0..=u64::MAX)
}

/// Checks a number.
///
/// # Errors
/// `ValueError` that names argument, value and range, also for NaN.
pub fn within(name: &str, x: f64, range: RangeInclusive<f64>) -> PyResult<()> {
    let (low, high) = (range.start(), range.end());
    if range.contains(&x) { Ok(()) } else { Err(out_of_range(name, x, &format!("in [{low}, {high}]"))) }
}

/// Checks a number that must be above 0.
///
/// # Errors
/// As [`within`].
pub fn positive(name: &str, x: f64, high: f64) -> PyResult<()> {
    if x > 0.0 && x <= high { Ok(()) } else { Err(out_of_range(name, x, &format!("in (0, {high}]"))) }
}
