//! Integrals of a Gaussian times a line over the segments of a window, in closed form and stable for
//! every slope (Yan17 Eq. 24 and Appendix).
//!
//! Along a segment, x ∈ [−1, 1], the exit azimuth moves by ±b around the middle of the segment. The middle is at the
//! distance u from the azimuth of the query. Both are in units of the lobe's standard deviation. The integrals are
//!
//! J₀ = ½ ∫ g(u − bx) dx,  J₁ = ½ ∫ 3x/b g(u − bx) dx,  g(u) = exp(−u²/2)/√2π.
//!
//! The Appendix' form of this integral divides differences of error functions by powers of b. In single precision it
//! has no correct digit below b = 0.01, and such slopes are common (R, TT, TRT of a wide lobe; TRT near its caustic).
//! For small slopes this module uses the series of e^(ubx − b²x²/2) around b = 0.

use crate::simd::special;
use wide::f32x8;

/// Below this half length, in standard deviations, the series is used.
///
/// Both forms are accurate to 5e-5 of the segment's own integral there. The first omitted terms of the series are
/// (ub)⁸/9!, 7e-5 at the largest |u| = 5.75 of any query, and b⁶/336, 7e-7. The closed form of J₁ loses a factor u/b
/// to cancellation: 5.75/0.25 · 1.5e-6.
const SERIES: f32 = 0.25;

/// The result is 0 at azimuths further than this from every node, in standard deviations. This omits 4e-8 of the light.
/// The paper's limit of 3 omits 2.7e-3. The sampler draws at most 5.3.
pub(crate) const REACH: f32 = 5.5;

const INV_SQRT_TAU: f32 = 0.398_942_3;

/// How the segments of a chain are integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Series,
    Closed,
    Both,
}

/// Seven segments between eight nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chain {
    /// The nodes' exit azimuths, in standard deviations.
    nodes: f32x8,
    /// Middle and half length of the segments. The eighth lane is unused.
    middle: f32x8,
    half: f32x8,
    /// 1/`half`, or 1 if the series is used.
    inverse: f32x8,
    /// Beyond this distance from 0 the result is 0.
    reach: f32,
    form: Form,
}

/// Shifts the lanes: lane i gets lane i + 1. The last lane stays.
#[inline(always)]
fn next(x: f32x8) -> f32x8 {
    let a = x.to_array();
    f32x8::new([a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[7]])
}

impl Chain {
    /// No segments.
    pub const NONE: Chain = Chain {
        nodes: f32x8::ZERO,
        middle: f32x8::ZERO,
        half: f32x8::ZERO,
        inverse: f32x8::ZERO,
        reach: 0.0,
        form: Form::Series,
    };

    /// Creates a chain from the exit azimuths of its nodes, in standard deviations.
    #[inline(always)]
    pub fn new(nodes: f32x8) -> Self {
        let constant = f32x8::splat;
        let after = next(nodes);
        let half = (after - nodes) * constant(0.5);
        let short = half.abs().simd_lt(constant(SERIES));
        // All lanes except the last.
        const ALL: u32 = 0x7f;
        let form = match short.to_bitmask() & ALL {
            ALL => Form::Series,
            0 => Form::Closed,
            _ => Form::Both,
        };
        Chain {
            nodes,
            middle: (after + nodes) * constant(0.5),
            half,
            inverse: f32x8::ONE / short.select(f32x8::ONE, half),
            reach: largest(nodes.abs()) + REACH,
            form,
        }
    }

    /// The largest distance of the mean from the middle for which the light is nowhere negative. It is |b|/3: the
    /// linear density is then 0 at one end. For a short segment the mean only shifts the light, and the limit is 0.15:
    /// the light is then 0 at 6.7 standard deviations, which is beyond [`REACH`].
    #[inline(always)]
    pub fn mean_limit(&self) -> f32x8 {
        (self.half.abs() * f32x8::splat(1.0 / 3.0)).fast_max(f32x8::splat(0.15))
    }

    /// Variances of the uniform spans of the segments.
    pub fn variance(&self) -> f32x8 {
        self.half * self.half * f32x8::splat(1.0 / 3.0)
    }

    /// Middles of the segments.
    pub fn middle(&self) -> f32x8 {
        self.middle
    }

    /// Middle and half length of one segment.
    pub fn span(&self, lane: usize) -> [f32; 2] {
        [self.middle.to_array()[lane], self.half.to_array()[lane].abs()]
    }

    /// The largest distance from 0 with a result other than 0.
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// J₀ and J₁ of the segments at azimuth `d`, in standard deviations: the factors of the energies and of the first
    /// moments about the middles.
    #[inline(always)]
    pub fn integrals(&self, d: f32) -> [f32x8; 2] {
        match self.form {
            Form::Series => self.series(d),
            Form::Closed => self.closed(d),
            Form::Both => self.exact(d),
        }
    }

    #[inline(always)]
    fn exact(&self, d: f32) -> [f32x8; 2] {
        let (series, closed) = (self.series(d), self.closed(d));
        let short = self.half.abs().simd_lt(f32x8::splat(SERIES));
        [short.select(series[0], closed[0]), short.select(series[1], closed[1])]
    }

    #[inline(always)]
    fn series(&self, d: f32) -> [f32x8; 2] {
        let constant = f32x8::splat;
        let u = constant(d) - self.middle;
        let g = special::exp(u * u * constant(-0.5)) * constant(INV_SQRT_TAU);
        let (y, z) = (u * self.half, self.half * self.half);
        let y2 = y * y;
        // Σ of ½∫ xᵏ (yx)ⁱ/i! (−zx²/2)ʲ/j! dx, by powers of z = b².
        let even = special::polynomial(y2, [1.0 / 5040.0, 1.0 / 120.0, 1.0 / 6.0, 1.0]);
        let even_z = special::polynomial(y2, [1.0 / 12960.0, 1.0 / 336.0, 1.0 / 20.0, 1.0 / 6.0]);
        let even_zz = special::polynomial(y2, [1.0 / 112.0, 1.0 / 40.0]);
        let odd = special::polynomial(y2, [1.0 / 45360.0, 1.0 / 840.0, 1.0 / 30.0, 1.0 / 3.0]);
        let odd_z = special::polynomial(y2, [1.0 / 2160.0, 1.0 / 84.0, 1.0 / 10.0]);
        let j0 = z.mul_add(z.mul_add(even_zz, -even_z), even);
        let j1 = z.mul_add(z.mul_add(constant(1.0 / 56.0), -odd_z), odd);
        [g * j0, g * u * j1 * constant(3.0)]
    }

    #[inline(always)]
    fn closed(&self, d: f32) -> [f32x8; 2] {
        let constant = f32x8::splat;
        let d = constant(d);
        let u = d - self.nodes;
        let bell = special::exp(u * u * constant(-0.5));
        // The normal distribution function is [u ≥ 0] − sign(u)·tail. Differences of tails on one side of the bell
        // keep their digits.
        let tail = (bell * special::mills(u.abs())).copysign(-u);
        let side = u.simd_lt(f32x8::ZERO).select(f32x8::ZERO, f32x8::ONE);
        let mass = (side - next(side)) + (tail - next(tail));
        let half_inverse = self.inverse * constant(0.5);
        let j0 = mass * half_inverse;
        let drop = (next(bell) - bell) * (half_inverse * constant(INV_SQRT_TAU));
        [j0, ((d - self.middle) * j0 - drop) * (self.inverse * self.inverse * constant(3.0))]
    }
}

/// Spans of exit azimuths, each replaced by a Gaussian with the same energy, mean and variance. The lobe must be so
/// wide that no half length, in standard deviations, exceeds [`Bells::LONGEST`].
///
/// A uniform span of variance V has the fourth cumulant −1.2 V², which the Hermite polynomial He₄ adds. The omitted
/// sixth cumulant is 16/63 b⁶. Together with the square of the fourth, the error is 1.6e-3 of the span's light for
/// the longest b.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bells {
    middle: f32x8,
    /// 1/√(1 + V)
    inverse: f32x8,
    /// The fourth cumulant over 24, in the bell's own standard deviations.
    kurtosis: f32x8,
    /// Beyond this distance from 0 the result is 0.
    reach: f32,
}

impl Bells {
    /// The largest half length b of a span. Its V is b²/3.
    pub const LONGEST: f32 = 0.9;

    /// Whether spans with these variances are short enough for bells.
    #[inline(always)]
    pub fn suit(variance: f32x8) -> bool {
        largest(variance) <= Bells::LONGEST * Bells::LONGEST / 3.0
    }

    /// Creates bells from the middles and variances of the spans, in standard deviations of the lobe.
    #[inline(always)]
    pub fn new(middle: f32x8, variance: f32x8) -> Self {
        let constant = f32x8::splat;
        let inverse = f32x8::ONE / (variance + f32x8::ONE).sqrt();
        let share = variance * inverse * inverse;
        Bells {
            middle,
            inverse,
            kurtosis: share * share * constant(-1.2 / 24.0),
            // The widest bell has a standard deviation of √(1 + 0.27).
            reach: largest(middle.abs()) + 1.13 * REACH,
        }
    }

    /// Middle and half length of one span.
    pub fn span(&self, lane: usize) -> [f32; 2] {
        let inverse = self.inverse.to_array()[lane];
        [self.middle.to_array()[lane], (3.0 * (1.0 / (inverse * inverse) - 1.0)).max(0.0).sqrt()]
    }

    /// The largest distance from 0 with a result other than 0.
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// The factors of the energies and of the first moments about the middles, at azimuth `d`.
    #[inline(always)]
    pub fn integrals(&self, d: f32x8) -> [f32x8; 2] {
        let constant = f32x8::splat;
        let u = (d - self.middle) * self.inverse;
        let u2 = u * u;
        let bell = special::exp(u2 * constant(-0.5)) * (self.inverse * constant(INV_SQRT_TAU));
        let he4 = (u2 - constant(6.0)).mul_add(u2, constant(3.0));
        [bell * self.kurtosis.mul_add(he4, f32x8::ONE), bell * u * self.inverse]
    }
}

#[inline(always)]
fn largest(x: f32x8) -> f32 {
    x.to_array().into_iter().fold(0.0, |a, b| if b > a { b } else { a })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ½ ∫ xᵏ g(u − bx) dx and ½ ∫ |x|ᵏ g, by 5-point Gauss–Legendre panels at most a fifth of either scale long.
    fn quadrature(u: f64, b: f64) -> [f64; 3] {
        const X: [f64; 5] =
            [-0.906_179_845_938_664, -0.538_469_310_105_683_1, 0.0, 0.538_469_310_105_683_1, 0.906_179_845_938_664];
        const W: [f64; 5] = [
            0.236_926_885_056_189_1,
            0.478_628_670_499_366_5,
            0.568_888_888_888_888_9,
            0.478_628_670_499_366_5,
            0.236_926_885_056_189_1,
        ];
        let panels = 10 * (1.0 + b.abs()).ceil() as usize;
        let mut sums = [0.0; 3];
        for i in 0..panels {
            for (x, w) in X.iter().zip(W) {
                let x = (2.0 * i as f64 + 1.0 + x) / panels as f64 - 1.0;
                let f = 0.5 * w / panels as f64 * (-0.5 * (u - b * x).powi(2)).exp() / std::f64::consts::TAU.sqrt();
                sums[0] += f;
                sums[1] += x * f;
                sums[2] += x.abs() * f;
            }
        }
        sums
    }

    /// Slopes from 1e-8 to 1e3 with both signs, in the range of queries. Errors are relative to the integral of
    /// |integrand|.
    #[test]
    fn closed_forms_match_quadrature() {
        let mut worst = [0.0f64; 2];
        for sign in [1.0, -1.0] {
            for step in 0..=110 {
                let b = sign * 10f64.powf(-8.0 + 0.1 * f64::from(step)) as f32;
                // Segment 0 of the chain, which is around 0, and the last segment, shifted to 0.
                let mut nodes = [-b, b, 3.0 * b, 5.0 * b, 7.0 * b, 9.0 * b, 11.0 * b, 13.0 * b];
                for lane in [0, 6] {
                    if lane == 6 {
                        nodes = nodes.map(|x| x - 12.0 * b);
                    }
                    let chain = Chain::new(f32x8::new(nodes));
                    let (middle, half) = (chain.middle.to_array()[lane], chain.half.to_array()[lane]);
                    for k in -115..=115 {
                        // Azimuths up to the reach beyond either end.
                        let d = middle + (0.05 * k as f32) * (1.0 + half.abs() / REACH);
                        let distance = (d - middle).abs() - half.abs();
                        if distance > REACH {
                            continue;
                        }
                        let [j0, j1] = chain.exact(d).map(|j| f64::from(j.to_array()[lane]));
                        let [e0, e1, magnitude] = quadrature(f64::from(d) - f64::from(middle), half.into());
                        worst[0] = worst[0].max((j0 - e0).abs() / e0);
                        assert!((j0 - e0).abs() <= 1e-4 * e0, "J0 b {half} d {d}: {j0} {e0}");
                        let j1 = j1 * f64::from(half) / 3.0;
                        worst[1] = worst[1].max((j1 - e1).abs() / magnitude);
                        assert!((j1 - e1).abs() <= 1e-4 * magnitude, "J1 b {half} d {d}: {j1} {e1}");
                    }
                }
            }
        }
        println!("largest relative errors of J0, J1: {worst:?}");
    }

    /// Bells compared with the exact integrals of the longest spans that they replace, with the largest tilt.
    #[test]
    fn bells_are_close_to_the_spans() {
        let b = Bells::LONGEST;
        let bells = Bells::new(f32x8::ZERO, f32x8::splat(b * b / 3.0));
        for tilt in [-1.0, 0.0, 1.0] {
            let (mut error, mut total) = (0.0, 0.0);
            for k in -600..=600 {
                let d = 0.01 * k as f32;
                let [j0, j1] = bells.integrals(f32x8::splat(d)).map(|j| f64::from(j.to_array()[0]));
                let [e0, e1, _] = quadrature(d.into(), b.into());
                // The first moment of the density (1 + tx)/2 over ±b is tb/3.
                error += (j0 - e0 + tilt * (j1 * f64::from(b) / 3.0 - e1)).abs();
                total += e0 + tilt * e1;
            }
            // The sixth cumulant, 16/63 b⁶ = 0.135, over 720 v³ times the mean of |He₆| = 10.4: 9.6e-4. Half the
            // square of the fourth over 24, 6.6e-6, times that of |He₈|, 93: 6e-4. With tilt, the third cumulant, 0.4
            // b³/3, over 6 v^1.5 times the mean of |He₃|, 1.5: 1.7e-2.
            assert!(error / total < 1.6e-3 + 1.7e-2 * f64::abs(tilt), "tilt {tilt}: {}", error / total);
        }
    }

    /// D14: why the Appendix is not used, even with its misprints corrected (erf for exp, no √π in the second term).
    /// Its ∫ x² e^(−ax² + bx + c) dx for a segment of half length 0.01 has an error of 4 % in single precision.
    #[test]
    fn the_appendix_cancels() {
        let (u, s) = (0.7f32, 0.01f32);
        let (a, b, c) = (0.5 * s * s, u * s, -0.5 * u * u);
        let pi = std::f32::consts::PI;
        let antiderivative = |x: f32| {
            pi.sqrt()
                * (b * b / (4.0 * a) + c).exp()
                * libm::erff((2.0 * a * x - b) / (2.0 * a.sqrt()))
                * (2.0 * a + b * b)
                / (8.0 * a.powf(2.5))
                - (-a * x * x + b * x + c).exp() * (2.0 * a * x + b) / (4.0 * a * a)
        };
        let printed = f64::from(antiderivative(1.0) - antiderivative(-1.0));
        let n = 2000;
        let exact: f64 = (0..n)
            .map(|i| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0)
            .map(|x| x * x * (-0.5 * (f64::from(u) - f64::from(s) * x).powi(2)).exp() * 2.0 / f64::from(n))
            .sum();
        assert!((printed / exact - 1.0).abs() > 0.02, "{printed} {exact}");
    }
}
