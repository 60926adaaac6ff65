//! Exact sums of a pixel's samples.
//!
//! A sum is an integer in small units, so its bits do not depend on the order of addition. Any thread may add any
//! sample, and sample ranges that are rendered separately merge to the same bits. The unit and the range of a sum
//! depend on its [`Format`]. A sum that reaches the end of its range stays there, and [`is_full`] reports it.

use crate::film::Layer;

/// How the sum of a channel is stored, as words of 32 bits, least significant first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Shares, directions and coordinates: 64 bits in units of 2⁻³². Values of 1 fit 2³¹ times.
    Bounded,
    /// Light of one lobe, and distances: 96 bits in units of 2⁻⁴⁶ (1.4e-14). Values of 1e9 fit 560,000 times.
    Part,
    /// Light that may come from a light directly: 128 bits in units of 2⁻⁶⁴ (5e-20). Values of 1e9 fit 9e9 times.
    Light,
    /// Squares of the brightness: 256 bits. The brightness is the sum of three integers of [`Format::Light`], and its
    /// square is exact. The variance of equal samples is therefore 0.
    Square,
    /// The maximum of 64-bit numbers instead of a sum.
    Largest,
}

/// Bits after the binary point.
const BOUNDED_BITS: i32 = 32;
const PART_BITS: i32 = 46;
const LIGHT_BITS: i32 = 64;

/// The largest sum of [`Format::Part`].
const PART_MAX: i128 = (1 << 95) - 1;

impl Format {
    /// The format of a layer's channels.
    pub(crate) fn of(layer: Layer) -> Self {
        match layer {
            Layer::Beauty | Layer::Lights => Format::Light,
            Layer::SecondMoment => Format::Square,
            Layer::Lobes | Layer::Depth | Layer::CacheError => Format::Part,
            Layer::Strand => Format::Largest,
            Layer::Alpha
            | Layer::Fibers
            | Layer::Albedo
            | Layer::Normal
            | Layer::Tangent
            | Layer::RootUv
            | Layer::Motion
            | Layer::CryptoObject
            | Layer::CryptoLook
            | Layer::CryptoGroup => Format::Bounded,
        }
    }

    /// Words of 32 bits in a sum.
    pub(crate) fn words(self) -> usize {
        match self {
            Format::Bounded | Format::Largest => 2,
            Format::Part => 3,
            Format::Light => 4,
            Format::Square => 8,
        }
    }
}

/// `value` as a whole number of units of 2^−`bits`, rounded to nearest. Values beyond 128 bits become the largest
/// number.
#[inline]
fn fixed(value: f32, bits: i32) -> i128 {
    let raw = value.to_bits();
    let exponent = (raw >> 23 & 0xff) as i32;
    // value = mantissa · 2^(max(exponent, 1) − 150)
    let mantissa = raw & 0x7f_ffff | u32::from(exponent > 0) << 23;
    let shift = exponent.max(1) - 150 + bits;
    let magnitude = match shift {
        0..=102 => i128::from(mantissa) << shift,
        103.. if mantissa > 0 => i128::MAX,
        -25..=-1 => i128::from((mantissa + (1 << (-shift - 1))) >> -shift),
        _ => 0,
    };
    if value.is_sign_negative() { -magnitude } else { magnitude }
}

fn word(words: &[u32], k: usize) -> u128 {
    u128::from(words[k])
}

fn load64(words: &[u32]) -> u64 {
    u64::from(words[0]) | u64::from(words[1]) << 32
}

fn store64(words: &mut [u32], value: u64) {
    (words[0], words[1]) = (value as u32, (value >> 32) as u32);
}

/// Adds the values of a layer to the sums of its channels, which are adjacent.
pub(crate) fn add_values(words: &mut [u32], format: Format, values: &[f32]) {
    match format {
        Format::Bounded => {
            let (words, _) = words.as_chunks_mut::<2>();
            for (words, &value) in words.iter_mut().zip(values).filter(|(_, value)| **value != 0.0) {
                add_value(words, format, value);
            }
        }
        Format::Part => {
            let (words, _) = words.as_chunks_mut::<3>();
            for (words, &value) in words.iter_mut().zip(values).filter(|(_, value)| **value != 0.0) {
                // The units of nearly all values fit 64 bits.
                if value.abs() < 65536.0 {
                    let units = f64::from(value) * (1u64 << PART_BITS) as f64;
                    add_units(words, units.round_ties_even() as i64);
                } else {
                    add_value(words, format, value);
                }
            }
        }
        Format::Light => {
            let (words, _) = words.as_chunks_mut::<4>();
            for (words, &value) in words.iter_mut().zip(values).filter(|(_, value)| **value != 0.0) {
                add_value(words, format, value);
            }
        }
        Format::Square | Format::Largest => {}
    }
}

/// Adds units that fit 64 bits to a sum of 96 bits.
fn add_units(words: &mut [u32; 3], units: i64) {
    let [a, b, c] = *words;
    let (low, carry) = (u64::from(a) | u64::from(b) << 32).overflowing_add(units as u64);
    let high = i64::from(c as i32) + (units >> 63) + i64::from(carry);
    *words = [low as u32, (low >> 32) as u32, high as u32];
    // Beyond 96 bits, or at the lower end of the range, which is not used.
    if high != i64::from(high as i32) || (high == i64::from(i32::MIN) && low == 0) {
        store96(words, if high < 0 { -PART_MAX } else { PART_MAX });
    }
}

fn load96(words: &[u32]) -> i128 {
    let bits = word(words, 0) | word(words, 1) << 32 | word(words, 2) << 64;
    // The sign is bit 95.
    (bits << 32) as i128 >> 32
}

fn store96(words: &mut [u32], value: i128) {
    let value = value.clamp(-PART_MAX, PART_MAX);
    (words[0], words[1], words[2]) = (value as u32, (value >> 32) as u32, (value >> 64) as u32);
}

fn load128(words: &[u32]) -> i128 {
    i128::from(load64(&words[2..])) << 64 | i128::from(load64(words))
}

fn store128(words: &mut [u32], value: i128) {
    store64(words, value as u64);
    store64(&mut words[2..], (value >> 64) as u64);
}

/// Adds a value to the sum of its channel.
pub(crate) fn add_value(words: &mut [u32], format: Format, value: f32) {
    match format {
        Format::Bounded => {
            let units = f64::from(value) * (1u64 << BOUNDED_BITS) as f64;
            store64(words, (load64(words) as i64).saturating_add(units.round_ties_even() as i64) as u64);
        }
        Format::Part => store96(words, load96(words).saturating_add(fixed(value, PART_BITS))),
        Format::Light => store128(words, load128(words).saturating_add(fixed(value, LIGHT_BITS))),
        Format::Square | Format::Largest => unreachable!("these are not sums of values"),
    }
}

/// Adds the square of the brightness of a sample.
pub(crate) fn add_square(words: &mut [u32], rgb: &[f32]) {
    let sum = rgb.iter().fold(0i128, |sum, &x| sum.saturating_add(fixed(x, LIGHT_BITS)));
    if sum != 0 {
        add256(words, &square(sum.unsigned_abs()));
    }
}

/// x², least significant words first.
fn square(x: u128) -> [u32; 8] {
    let half = u128::from(u64::MAX);
    let (low, high) = (x & half, x >> 64);
    let (a, b, c) = (low * low, low * high, high * high);
    // x² = a + 2b·2⁶⁴ + c·2¹²⁸
    let middle = (a >> 64) + ((b << 1) & half);
    let top = c + (b >> 63) + (middle >> 64);
    let bottom = (a & half) | middle << 64;
    std::array::from_fn(|k| if k < 4 { (bottom >> (32 * k)) as u32 } else { (top >> (32 * (k - 4))) as u32 })
}

fn add256(words: &mut [u32], others: &[u32]) {
    let mut carry = false;
    for (words, others) in words.chunks_exact_mut(2).zip(others.chunks_exact(2)) {
        let (sum, first) = load64(words).overflowing_add(load64(others));
        let (sum, second) = sum.overflowing_add(u64::from(carry));
        store64(words, sum);
        carry = first || second;
    }
    if carry {
        words.fill(u32::MAX);
    }
}

/// Stores a number if it is the largest.
pub(crate) fn add_largest(words: &mut [u32], number: u64) {
    store64(words, load64(words).max(number));
}

/// Adds the sum of other samples.
pub(crate) fn combine(words: &mut [u32], format: Format, others: &[u32]) {
    match format {
        Format::Bounded => store64(words, (load64(words) as i64).saturating_add(load64(others) as i64) as u64),
        Format::Part => store96(words, load96(words).saturating_add(load96(others))),
        Format::Light => store128(words, load128(words).saturating_add(load128(others))),
        Format::Square => add256(words, others),
        Format::Largest => add_largest(words, load64(others)),
    }
}

/// The sum as a floating-point number. For squares, the brightness is the mean of the three channels.
pub(crate) fn value(words: &[u32], format: Format) -> f64 {
    match format {
        Format::Bounded => load64(words) as i64 as f64 * 0.5f64.powi(BOUNDED_BITS),
        Format::Part => load96(words) as f64 * 0.5f64.powi(PART_BITS),
        Format::Light => load128(words) as f64 * 0.5f64.powi(LIGHT_BITS),
        Format::Square => {
            let sum = words.iter().rev().fold(0.0, |sum, &word| sum * 2f64.powi(32) + f64::from(word));
            sum * 0.5f64.powi(2 * LIGHT_BITS) / 9.0
        }
        Format::Largest => load64(words) as f64,
    }
}

/// The largest number that was added.
pub(crate) fn largest(words: &[u32]) -> u64 {
    load64(words)
}

/// Whether a sum is at the end of its range. It may then be too small.
pub(crate) fn is_full(words: &[u32], format: Format) -> bool {
    match format {
        Format::Bounded => matches!(load64(words) as i64, i64::MIN | i64::MAX),
        Format::Part => load96(words).abs() == PART_MAX,
        Format::Light => matches!(load128(words), i128::MIN | i128::MAX),
        Format::Square => words.iter().all(|&word| word == u32::MAX),
        Format::Largest => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUMS: [Format; 3] = [Format::Bounded, Format::Part, Format::Light];

    fn sum(format: Format, values: &[f32]) -> Vec<u32> {
        let mut words = vec![0; format.words()];
        values.iter().for_each(|&v| add_value(&mut words, format, v));
        words
    }

    #[test]
    fn sums_are_right_to_half_a_unit_a_value() {
        let values: Vec<f32> = (0..1000).map(|i| (i as f32 * 1.7).sin() * 3f32.powi(i % 21 - 10)).collect();
        let exact: f64 = values.iter().map(|&v| f64::from(v)).sum();
        for (format, bits) in SUMS.into_iter().zip([BOUNDED_BITS, PART_BITS, LIGHT_BITS]) {
            let found = value(&sum(format, &values), format);
            // An error of half a unit for each of 1000 values, and of f64 rounding for sums below 1e8.
            let bound = 500.0 * 0.5f64.powi(bits) + 1e8 * 1e-15;
            assert!((found - exact).abs() <= bound, "{format:?}: {found} {exact}");
        }
    }

    #[test]
    fn order_and_division_do_not_matter() {
        let values: Vec<f32> = (0..300).map(|i| (i as f32).cos() * 7f32.powi(i % 17 - 8)).collect();
        let backward: Vec<f32> = values.iter().rev().copied().collect();
        for format in SUMS {
            let whole = sum(format, &values);
            assert_eq!(whole, sum(format, &backward));
            let mut parts = sum(format, &values[..77]);
            combine(&mut parts, format, &sum(format, &values[77..]));
            assert_eq!(parts, whole);
        }
    }

    #[test]
    fn light_from_moonless_nights_to_suns_keeps_its_digits() {
        for format in [Format::Part, Format::Light] {
            for exponent in -9..=9 {
                let x = 1.234_567 * 10f32.powi(exponent);
                let found = value(&sum(format, &[x; 100]), format) / 100.0;
                // Half a unit of 2⁻⁴⁶ is 7e-6 of 1e-9.
                assert!((found / f64::from(x) - 1.0).abs() < 1e-5, "{format:?} {x}: {found}");
            }
        }
    }

    #[test]
    fn layers_are_added_like_single_values() {
        let values: Vec<f32> = (0..400).map(|i| (i as f32 * 0.7).sin() * 3f32.powi(i % 31 - 15)).collect();
        for format in SUMS {
            let n = format.words();
            let (mut layer, mut single) = (vec![0; 40 * n], vec![0; 40 * n]);
            for values in values.chunks(40) {
                add_values(&mut layer, format, values);
                single.chunks_mut(n).zip(values).for_each(|(words, &value)| add_value(words, format, value));
            }
            for (a, b) in layer.chunks(n).zip(single.chunks(n)) {
                // Halves of a unit may be rounded to either side.
                let tolerance = 10.0 * 0.5f64.powi(PART_BITS);
                assert!((value(a, format) - value(b, format)).abs() <= tolerance, "{format:?}");
            }
        }
        // Sums at the end of their range, and beyond.
        for (start, units) in [(PART_MAX - 3, 2), (PART_MAX - 3, 9), (3 - PART_MAX, -9), (-PART_MAX, -1), (5, -9)] {
            let mut words = [0; 3];
            store96(&mut words, start);
            add_units(&mut words, units);
            assert_eq!(load96(&words), (start + i128::from(units)).clamp(-PART_MAX, PART_MAX), "{start} {units}");
        }
    }

    #[test]
    fn squares_are_exact() {
        for rgb in [[1e-9f32, 2e-9, 3e-9], [0.1, 0.2, 0.3], [3e9, 1e-9, 5.0], [1e12, 1e12, 1e12]] {
            let mut words = vec![0; 8];
            (0..3).for_each(|_| add_square(&mut words, &rgb));
            let mean = rgb.iter().map(|&x| fixed(x, LIGHT_BITS) as f64 * 0.5f64.powi(LIGHT_BITS)).sum::<f64>() / 3.0;
            let found = value(&words, Format::Square);
            assert!((found / (3.0 * mean * mean) - 1.0).abs() < 1e-14, "{rgb:?}: {found}");
        }
        assert_eq!(square(u128::MAX)[..4], [1, 0, 0, 0]);
        assert_eq!(square(u128::MAX)[4..], [u32::MAX - 1, u32::MAX, u32::MAX, u32::MAX]);
    }

    #[test]
    fn full_sums_stay_full_and_report_it() {
        for format in SUMS {
            let mut words = sum(format, &[f32::MAX, 1.0, f32::MAX]);
            assert!(is_full(&words, format), "{format:?}");
            let copy = words.clone();
            combine(&mut words, format, &copy);
            assert!(is_full(&words, format) && words == copy, "{format:?}");
            assert!(!is_full(&sum(format, &[1e6, -3.0]), format));
        }
        let mut words = vec![u32::MAX; 8];
        words[0] -= 1;
        assert!(!is_full(&words, Format::Square));
        add_square(&mut words, &[1.0; 3]);
        assert!(is_full(&words, Format::Square));
    }
}
