//! Special functions in single precision, eight at a time. Each has a stated error bound, which the tests check with
//! 50-digit values.

use std::ops::{Add, Div, Mul, Neg, Sub};
use wide::{f32x4, f32x8, u32x4, u32x8};

/// A register of four or eight numbers.
pub trait Register:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The same number in each lane.
    fn splat(x: f32) -> Self;
    /// self·factor + term.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// The larger of two numbers, neither of which is NaN.
    fn max(self, other: Self) -> Self;
    /// The smaller of two numbers, neither of which is NaN.
    fn min(self, other: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// The magnitude of `self` with the given sign.
    fn copysign(self, sign: Self) -> Self;
    /// `x` if `self < limit`, else `y`.
    fn select_lt(self, limit: Self, x: Self, y: Self) -> Self;
    /// Whether any lane of `self` is below that of `limit`.
    fn any_lt(self, limit: Self) -> bool;
    /// 2ⁿ for n in the low bits of the mantissa.
    fn power_of_two(self) -> Self;
}

macro_rules! register {
    ($float:ty, $bits:ty) => {
        impl Register for $float {
            #[inline(always)]
            fn splat(x: f32) -> Self {
                <$float>::splat(x)
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                <$float>::mul_add(self, factor, term)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                self.fast_max(other)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                self.fast_min(other)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$float>::abs(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$float>::sqrt(self)
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                <$float>::copysign(self, sign)
            }
            #[inline(always)]
            fn select_lt(self, limit: Self, x: Self, y: Self) -> Self {
                self.simd_lt(limit).select(x, y)
            }
            #[inline(always)]
            fn any_lt(self, limit: Self) -> bool {
                self.simd_lt(limit).any()
            }
            #[inline(always)]
            fn power_of_two(self) -> Self {
                <$float>::from_bits((self.to_bits() << 23u32) + <$bits>::splat(0x3f80_0000))
            }
        }
    };
}
register!(f32x4, u32x4);
register!(f32x8, u32x8);

/// A polynomial, with coefficients from the highest power down, by Estrin's scheme. Its latency is half of Horner's,
/// and a query is one long chain of dependent operations.
#[inline(always)]
pub fn polynomial<R: Register, const N: usize>(x: R, coefficients: [f32; N]) -> R {
    const { assert!(N >= 2 && N <= 8) }
    let c = |power: usize| R::splat(coefficients[N - 1 - power]);
    let pair = |power: usize| {
        if power + 1 < N { c(power + 1).mul_add(x, c(power)) } else { c(power) }
    };
    let x2 = x * x;
    let quad = |power: usize| {
        if power + 2 < N { pair(power + 2).mul_add(x2, pair(power)) } else { pair(power) }
    };
    if N > 4 { quad(4).mul_add(x2 * x2, quad(0)) } else { quad(0) }
}

/// eˣ for x ≤ 88, with a relative error ≤ 2e-7 plus |x|·6e-8 from rounding the argument. Below −64 the result is e⁻⁶⁴ ≈
/// 1.6e-28. Products of such tails with weights and other tails are then not subnormal. Subnormal numbers would make a
/// query slower by a third.
#[inline(always)]
pub fn exp<R: Register>(x: R) -> R {
    const LOG2_E: f32 = std::f32::consts::LOG2_E;
    // 1.5·2²³: adding it rounds to an integer and puts that integer into the low mantissa bits.
    const ROUND: f32 = 12_582_912.0;
    // ln 2 in two parts, the first with few enough bits that n·LN2_HI is exact.
    const LN2_HI: f32 = 0.693_359_4;
    const LN2_LO: f32 = -2.121_944_4e-4;
    let x = x.max(R::splat(-64.0));
    let k = x * R::splat(LOG2_E) + R::splat(ROUND);
    let n = k - R::splat(ROUND);
    let r = x - n * R::splat(LN2_HI) - n * R::splat(LN2_LO);
    // Taylor to degree 7 on |r| ≤ ln2/2: truncation (ln2/2)⁸/8! = 5e-9.
    let p = polynomial(r, [1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0]);
    p * k.power_of_two()
}

/// e⁻ˣ I₀(x) for x ≥ 0, with a relative error ≤ 1.2e-6: 3e-7 from the fits, 5e-7 from exp(−5), and rounding. The fits
/// are our own, nearly minimax, by Chebyshev interpolation: of I₀(√z) up to x = 5, and of √x e⁻ˣ I₀(x) in 1/x beyond.
///
/// The frequently copied asymptotic series of log I₀ with 1/(8x) inside the ½ has an error of 0.6 %; see the test.
#[inline(always)]
pub fn bessel_i0e<R: Register>(x: R) -> R {
    let split = R::splat(5.0);
    let t = R::splat(1.0) / x.max(split);
    let p = polynomial(
        t,
        [-1.965_749_6, 1.585_369_3, -0.265_941_5, 0.057_056_73, 0.026_962_09, 0.049_882_96, 0.398_942_23],
    );
    let large = p * t.sqrt();
    if !x.any_lt(split) {
        return large;
    }
    let near = x.min(split);
    let p = polynomial(
        near * near,
        [3.405_94e-12, 4.329_608_6e-10, 6.852_862e-8, 6.774_596_4e-6, 4.340_663_6e-4, 0.015_624_912, 0.25, 1.0],
    );
    x.select_lt(split, p * exp(-near), large)
}

/// (1 − Φ(u))·e^(u²/2) for u ≥ 0, where Φ is the normal distribution function. This is Mills' ratio divided by √2π. The
/// relative error is ≤ 6e-7: 2.3e-7 from the fit (our own, minimax in t = 1/(1 + 3u/8)), and rounding.
#[inline(always)]
pub fn mills<R: Register>(u: R) -> R {
    let t = R::splat(1.0) / u.mul_add(R::splat(0.375), R::splat(1.0));
    let p = polynomial(
        t,
        [
            -3.291_058e-2,
            1.368_777_3e-1,
            -1.865_168_8e-1,
            5.062_779_8e-2,
            1.563_078_6e-2,
            8.863_718e-2,
            1.284_459e-1,
            1.496_045_6e-1,
        ],
    )
    .mul_add(t, R::splat(1.496_034e-1));
    p * t
}

/// atan2(y, x) in (−π, π], absolute error ≤ 3e-7. atan2(0, 0) is 0.
///
/// The polynomial is that of Cephes' atanf (Moshier), on |t| ≤ tan(π/8).
#[inline(always)]
pub fn atan2<R: Register>(y: R, x: R) -> R {
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    let zero = R::splat(0.0);
    let (ax, ay) = (x.abs(), y.abs());
    let hi = ax.max(ay);
    let lo = ax.min(ay);
    // Beyond tan(π/8) the angle is π/4 + atan((lo − hi)/(lo + hi)). Both cases share one division.
    let knee = hi * R::splat(0.414_213_57);
    let numerator = knee.select_lt(lo, lo - hi, lo);
    let denominator = knee.select_lt(lo, lo + hi, hi).max(R::splat(f32::MIN_POSITIVE));
    let t = numerator / denominator;
    let z = t * t;
    let p = polynomial(z, [8.053_744_5e-2, -1.387_768_6e-1, 1.997_771e-1, -3.333_295e-1]);
    let mut angle = (p * z).mul_add(t, t) + knee.select_lt(lo, R::splat(FRAC_PI_4), zero);
    angle = ax.select_lt(ay, R::splat(FRAC_PI_2) - angle, angle);
    angle = x.select_lt(zero, R::splat(PI) - angle, angle);
    angle.copysign(y)
}

/// sin x and cos x for x in [0, π/2], with an absolute error ≤ 1.5e-7. The odd and even polynomials are our own fits,
/// with errors of 5e-9 and 4e-10. The term added to x is at most 0.57 and has three roundings of 6e-8 each. The sum
/// adds half a rounding.
#[inline(always)]
pub fn sin_cos_quarter<R: Register>(x: R) -> (R, R) {
    let z = x * x;
    let odd = polynomial(z, [2.608_932_5e-6, -1.981_111_3e-4, 8.333_088e-3, -1.666_666e-1]);
    let even = polynomial(z, [-2.619_381_4e-7, 2.476_930_4e-5, -1.388_856_9e-3, 4.166_665_6e-2]);
    ((odd * z).mul_add(x, x), (even * z).mul_add(z, z.mul_add(R::splat(-0.5), R::splat(1.0))))
}

/// The standard normal quantile Φ⁻¹(u) for 0 ≤ u < 1, absolute error ≤ 3e-6 for |Φ⁻¹| ≤ 5. u is clamped to [6e-8, 1 −
/// 6e-8], which is ±5.3.
///
/// Φ⁻¹(u) = √2 erf⁻¹(2u − 1), with Giles' single-precision polynomials
/// (M. Giles 2010, Approximating the erfinv function, GPU Computing Gems).
pub fn normal_quantile(u: f32) -> f32 {
    const CENTRE: [f32; 9] = [
        2.810_226_4e-8,
        3.432_739_4e-7,
        -3.523_387_7e-6,
        -4.391_506_5e-6,
        2.185_808_7e-4,
        -1.253_725e-3,
        -4.177_681_6e-3,
        2.466_407_3e-1,
        1.501_409_4,
    ];
    const TAIL: [f32; 9] = [
        -2.002_142_6e-4,
        1.009_505_6e-4,
        1.349_343_2e-3,
        -3.673_428_5e-3,
        5.739_507_7e-3,
        -7.622_461_3e-3,
        9.438_870_5e-3,
        1.001_674,
        2.832_976_8,
    ];
    const EDGE: f32 = 6e-8;
    let u = u.clamp(EDGE, 1.0 - EDGE);
    let x = 2.0 * u - 1.0;
    // 1 − x² = 4u(1 − u) without cancellation at either end.
    let w = -(4.0 * u * (1.0 - u)).ln();
    let (t, coefficients) = if w < 5.0 { (w - 2.5, CENTRE) } else { (w.sqrt() - 3.0, TAIL) };
    let p = coefficients.iter().fold(0.0, |sum, c| sum * t + c);
    std::f32::consts::SQRT_2 * p * x
}

#[cfg(test)]
mod tests {
    //! Expected values: mpmath with 50 digits, rounded to double.
    use super::*;

    const I0E: [(f64, f64); 14] = [
        (0.0, 1.0),
        (0.001, 0.9990007495835156),
        (0.1, 0.9071009257823011),
        (1.0, 0.46575960759364043),
        (3.0, 0.2430003541618254),
        (4.999, 0.18356038432689242),
        (5.0, 0.18354081260932836),
        (5.001, 0.18352124723440244),
        (10.0, 0.1278333371634286),
        (29.99, 0.07315824574297991),
        (30.01, 0.07313365342356991),
        (100.0, 0.03994437929909668),
        (3125.0, 0.00713678197586958),
        (328281.0, 0.0006962855098856036),
    ];
    const QUANTILES: [(f32, f64); 9] = [
        (1e-7, -5.199337580020491),
        (1e-5, -4.264890799563287),
        (0.001, -3.090232292061434),
        (0.02, -2.0537489198646206),
        (0.3, -0.5244004784222137),
        (0.5, 0.0),
        (0.75, 0.6744897501960817),
        (0.99, 2.326348231863753),
        (0.99999, 4.264587771860222),
    ];
    const MILLS: [(f32, f64); 12] = [
        (0.0, 0.5),
        (0.001, 0.4996013075677553),
        (0.1, 0.46247878476198),
        (0.5, 0.34961883472039806),
        (1.0, 0.2615782918651234),
        (2.0, 0.1681020012231706),
        (3.5, 0.10634515363370545),
        (5.5, 0.07034269402512788),
        (8.0, 0.049122546212424935),
        (20.0, 0.01989761564832703),
        (100.0, 0.00398902398135681),
        (3600.0, 0.00011081729156079346),
    ];
    const EXP: [(f32, f64); 10] = [
        (0.0, 1.0),
        (-1e-06, 0.9999990000005026),
        (-0.01, 0.9900498339704614),
        (-0.3, 0.7408182118504766),
        (-1.0, 0.36787944117144233),
        (-5.0, 0.006737946999085467),
        (-20.0, 2.061153622438558e-09),
        (-60.0, 8.75651076269652e-27),
        (2.5, 12.182493960703473),
        (40.0, 2.3538526683702e+17),
    ];

    fn first(f: impl Fn(f32x8) -> f32x8, x: f32) -> f64 {
        f64::from(f(f32x8::splat(x)).to_array()[0])
    }

    #[test]
    fn exp_matches_high_precision() {
        for (x, expected) in EXP {
            let error = first(exp, x) / expected - 1.0;
            assert!(error.abs() < 2e-7 + 6e-8 * f64::from(x.abs()), "{x}: {error}");
        }
        assert!((1.5e-28..1.7e-28).contains(&first(exp, -1e30)));
    }

    #[test]
    fn bessel_matches_high_precision() {
        for (x, expected) in I0E {
            let error = first(bessel_i0e, x as f32) / expected - 1.0;
            assert!(error.abs() < 1.2e-6, "{x}: {error}");
        }
    }

    /// The common form of the asymptotic series of log I₀ has 1/(8x) inside the ½.
    #[test]
    fn the_copied_log_i0_is_wrong_and_ours_is_not() {
        let x = 12.0f64;
        let exact = I0E[8].1;
        let copied = |x: f64| (0.5 * (-(std::f64::consts::TAU).ln() + (1.0 / x).ln() + 1.0 / (8.0 * x))).exp();
        assert!((copied(10.0) / exact - 1.0).abs() > 5e-3);
        assert!((first(bessel_i0e, x as f32) / vellus_reference::exact::bessel_i0e(x) - 1.0).abs() < 1.2e-6);
    }

    #[test]
    fn mills_matches_high_precision() {
        for (u, expected) in MILLS {
            let error = first(mills, u) / expected - 1.0;
            assert!(error.abs() < 6e-7, "{u}: {error}");
        }
    }

    #[test]
    fn quarter_matches_the_standard_library() {
        for k in 0..=10_000 {
            let x = k as f32 / 10_000.0 * std::f32::consts::FRAC_PI_2;
            let (sin, cos) = sin_cos_quarter(f32x8::splat(x));
            let (exact_sin, exact_cos) = f64::from(x).sin_cos();
            let error = |ours: f32x8, exact: f64| (f64::from(ours.to_array()[0]) - exact).abs();
            assert!(error(sin, exact_sin) < 1.5e-7 && error(cos, exact_cos) < 1.5e-7, "{x}");
        }
    }

    #[test]
    fn atan2_matches_the_standard_library() {
        for i in 0..3600 {
            let a = (f64::from(i) - 1799.5) / 1800.0 * std::f64::consts::PI;
            for radius in [1e-6, 1.0, 300.0] {
                let (y, x) = ((a.sin() * radius) as f32, (a.cos() * radius) as f32);
                let ours = f64::from(atan2(f32x8::splat(y), f32x8::splat(x)).to_array()[0]);
                assert!((ours - f64::from(y).atan2(f64::from(x))).abs() < 3e-7, "{y} {x}");
            }
        }
        assert_eq!(first(|y| atan2(y, f32x8::ZERO), 0.0), 0.0);
    }

    #[test]
    fn normal_quantile_matches_high_precision() {
        for (u, expected) in QUANTILES {
            let value = f64::from(normal_quantile(u));
            // Near 1, u itself has an error of 6e-8. The slope of the quantile, 1/pdf, multiplies this error.
            let slope = (0.5 * expected * expected).exp() * std::f64::consts::TAU.sqrt();
            let tolerance = 3e-6 + 1.2e-7 * f64::from(u) * slope;
            assert!((value - expected).abs() < tolerance, "{u}: {value} {expected}");
        }
        assert!(normal_quantile(0.0).is_finite() && normal_quantile(1.0).is_finite());
    }
}
