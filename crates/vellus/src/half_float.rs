//! Half floats (IEEE 754 binary16), in which the tables are stored.

/// The value of a half float, exactly. A NaN stays a NaN.
pub(crate) fn to_f32(bytes: [u8; 2]) -> f32 {
    let bits = u32::from(u16::from_le_bytes(bytes));
    let (sign, magnitude) = ((bits & 0x8000) << 16, bits & 0x7fff);
    let magnitude = match magnitude >> 10 {
        // Multiples of the smallest half float, 2⁻²⁴.
        0 => (magnitude as f32 * SMALLEST).to_bits(),
        31 => f32::INFINITY.to_bits() | magnitude << 13,
        // The bias of the exponent is 15 in half floats, and 127 in single precision.
        _ => (magnitude << 13) + ((127 - 15) << 23),
    };
    f32::from_bits(sign | magnitude)
}

/// The half float next to a number. Halfway between two, it is the one whose last bit is 0.
#[cfg(any(test, feature = "unstable"))]
pub(crate) fn from_f32(x: f32) -> [u8; 2] {
    let sign = (x.to_bits() >> 16) as u16 & 0x8000;
    let magnitude = match x.abs() {
        // Below the smallest normal number. Rounding may reach it.
        x if x < 1024.0 * SMALLEST => (x / SMALLEST).round_ties_even() as u16,
        x if x < 65520.0 => {
            let bits = x.to_bits() - ((127 - 15) << 23);
            let odd = bits >> 13 & 1;
            ((bits + 0xfff + odd) >> 13) as u16
        }
        x if x.is_nan() => 0x7e00,
        _ => 0x7c00,
    };
    (sign | magnitude).to_le_bytes()
}

/// 2⁻²⁴.
const SMALLEST: f32 = 5.960_464_5e-8;

#[cfg(test)]
mod tests {
    use super::*;
    use half::f16;

    #[test]
    fn all_half_floats_are_those_of_the_crate_half() {
        for bits in 0..=u16::MAX {
            let (ours, theirs) = (to_f32(bits.to_le_bytes()), f16::from_bits(bits).to_f32());
            assert!(ours.to_bits() == theirs.to_bits() || ours.is_nan() && theirs.is_nan(), "{bits:#x}");
        }
    }

    /// All half floats, the numbers halfway between them, and the neighbours of these in single precision.
    #[test]
    fn numbers_round_as_those_of_the_crate_half() {
        for bits in 0..=u16::MAX {
            let [low, high] = [bits, bits.wrapping_add(1)].map(|bits| f16::from_bits(bits).to_f32());
            for x in [low, low.midpoint(high)].into_iter().flat_map(|x| [x.next_down(), x, x.next_up()]) {
                let (ours, theirs) = (f16::from_le_bytes(from_f32(x)), f16::from_f32(x));
                assert!(ours.to_bits() == theirs.to_bits() || ours.is_nan() && theirs.is_nan(), "{x:e}");
            }
        }
        for x in [65519.996, 65520.0, 1e30, f32::MAX, f32::INFINITY, f32::NAN, f32::MIN_POSITIVE, 1e-45] {
            let (ours, theirs) = (f16::from_le_bytes(from_f32(x)), f16::from_f32(x));
            assert!(ours.to_bits() == theirs.to_bits() || ours.is_nan() && theirs.is_nan(), "{x:e}");
        }
    }
}
