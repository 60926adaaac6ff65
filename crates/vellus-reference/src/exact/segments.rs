//! R, TT, TRT over a window, with the segments of the fast path, but for any number of segments. This checks the fast
//! path, and shows how the error depends on the number of segments.

use super::formulas::wrap;
use super::{Exact, ExactPath};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// One segment of one lobe.
#[derive(Clone, Debug)]
struct Segment {
    lobe: usize,
    /// Azimuth of the middle, signed half length.
    middle: f64,
    half: f64,
    /// Energy and its first moment about the middle, RGB.
    energy: [f64; 3],
    moment: [f64; 3],
}

/// R, TT, TRT over a window of offsets, by segments (D9).
#[derive(Clone, Debug)]
pub struct ExactSegments {
    sigma: [f64; 3],
    segments: Vec<Segment>,
}

/// ψ(t) over t ∈ [0, 1].
fn angle(t: f64) -> f64 {
    0.5 * FRAC_PI_2 * t * (3.0 - t)
}

/// dψ/dt.
fn slope(t: f64) -> f64 {
    FRAC_PI_2 * (1.5 - t)
}

/// The inverse of [`angle`].
fn position(angle: f64) -> f64 {
    1.5 - (2.25 - 2.0 * angle / FRAC_PI_2).max(0.0).sqrt()
}

impl Exact<'_> {
    /// Divides the offsets from `h1` to `h2` > `h1` within [−1, 1] into `n` segments on each side of h = 0 that the
    /// window covers. `theta_o` is in radians.
    pub fn segments(&self, theta_o: f64, [h1, h2]: [f64; 2], n: usize) -> ExactSegments {
        let mut segments = Vec::new();
        for (low, high, mirror) in [(h1.max(0.0), h2, 1.0), ((-h2).max(0.0), -h1, -1.0)] {
            if high > low {
                self.half(theta_o, [low, high], mirror, n, h2 - h1, &mut segments);
            }
        }
        ExactSegments { sigma: [0, 1, 2].map(|p| self.sigma(p)), segments }
    }

    fn half(
        &self,
        theta_o: f64,
        [low, high]: [f64; 2],
        mirror: f64,
        n: usize,
        width: f64,
        segments: &mut Vec<Segment>,
    ) {
        let edge = self.kappa * self.eta_prime(theta_o);
        let split = if self.kappa > 0.0 && edge > low && edge < high.min(1.0) { Some(edge) } else { None };
        let range = |a: f64, b: f64, r: f64| [a, b].map(|h| position((h / r).min(1.0).asin()));
        let t = |h: f64| position(h.asin());
        // (range of t, r, segments) on each side of the medulla's edge.
        let sides = match split {
            Some(edge) => {
                let share = (t(edge) - t(low)) / (t(high) - t(low));
                let count = ((share * n as f64).round() as usize).clamp(2.min(n.max(2) - 1), n.max(2) - 1);
                vec![(range(low, edge, edge), edge, count), (range(edge, high, 1.0), 1.0, n.max(2) - count)]
            }
            None if self.kappa > 0.0 && edge < 1.0 && high <= edge => vec![(range(low, high, edge), edge, n)],
            None => vec![(range(low, high, 1.0), 1.0, n)],
        };
        for ([first, last], r, count) in sides {
            let step = (last - first) / count as f64;
            for i in 0..count {
                let start = first + step * i as f64;
                let offset = |t: f64| (r * angle(t).sin()).min(1.0);
                let ends = [start, start + step].map(|t| self.path(theta_o, offset(t)));
                let points: Vec<(ExactPath, f64)> = [0.5 - 0.75f64.sqrt() / 3.0, 0.5 + 0.75f64.sqrt() / 3.0]
                    .into_iter()
                    .map(|x| start + x * step)
                    .map(|t| (self.path(theta_o, offset(t)), 0.5 * step * slope(t) * r * angle(t).cos() / width))
                    .collect();
                for lobe in 0..3 {
                    let [a, b] = [ends[0].exit(lobe), ends[1].exit(lobe)];
                    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
                    let limit = half.abs().max(0.45 * self.sigma(lobe)) / 3.0;
                    let mut segment = Segment {
                        lobe,
                        middle: mirror * middle,
                        half: mirror * half,
                        energy: [0.0; 3],
                        moment: [0.0; 3],
                    };
                    for c in 0..3 {
                        let mut moment = 0.0;
                        for (path, w) in &points {
                            segment.energy[c] += w * path.attenuation[lobe][c];
                            moment += w * path.attenuation[lobe][c] * (path.exit(lobe) - middle);
                        }
                        let limit = limit * segment.energy[c];
                        segment.moment[c] = mirror * moment.clamp(-limit, limit);
                    }
                    segments.push(segment);
                }
            }
        }
    }
}

impl ExactSegments {
    /// N(φ) of R, TT, TRT at the azimuth φ = φ_i − φ_o (radians), RGB, per radian.
    pub fn azimuthal(&self, phi: f64) -> [[f64; 3]; 3] {
        let mut n = [[0.0; 3]; 3];
        for s in &self.segments {
            let sigma = self.sigma[s.lobe];
            let d = wrap(phi - s.middle);
            let turns = ((8.0 * sigma + s.half.abs() + PI) / TAU) as i32;
            for turn in -turns..=turns {
                let [j0, j1] = moments((d + TAU * f64::from(turn)) / sigma, s.half / sigma);
                for c in 0..3 {
                    n[s.lobe][c] += s.energy[c] / sigma * j0 + 3.0 * s.moment[c] / (sigma * sigma) * j1;
                }
            }
        }
        n
    }
}

/// ½ ∫ g(u − bx) dx and ½ ∫ x/b g(u − bx) dx over [−1, 1], where g is the standard normal density. The result is a
/// closed form, or for short segments an expansion to b⁴.
fn moments(u: f64, b: f64) -> [f64; 2] {
    let g = |u: f64| (-0.5 * u * u).exp() / TAU.sqrt();
    if b.abs() < 0.02 {
        // Hermite polynomials: g(u − bx) = g(u) Σ Heₖ(u) (bx)ᵏ/k!.
        let (u2, b2) = (u * u, b * b);
        let (he2, he3, he4) = (u2 - 1.0, u * (u2 - 3.0), u2 * u2 - 6.0 * u2 + 3.0);
        return [g(u) * (1.0 + b2 * he2 / 6.0 + b2 * b2 * he4 / 120.0), g(u) * (u / 3.0 + b2 * he3 / 30.0)];
    }
    let normal = |u: f64| 0.5 * libm::erfc(-u * std::f64::consts::FRAC_1_SQRT_2);
    let j0 = (normal(u + b) - normal(u - b)) / (2.0 * b);
    [j0, (u * j0 - (g(u - b) - g(u + b)) / (2.0 * b)) / (b * b)]
}
