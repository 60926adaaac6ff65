//! The far field of near-field models: the average over the width of the fibre, in many directions at once.
//!
//! f(θ, φ) = ½ ∫ f(h, θ, φ) dh is computed by quadrature over the offset. Every model here has the form Σ_k M_k(θᵢ)
//! N_k(φ; h). Only N_k depends on the offset, so the average is computed once for each φ, for any number of θᵢ.
//!
//! The integrand is not smooth at the offset where rays start to miss the medulla, and where total reflection off it
//! starts. For each such edge b, the substitution h = b sin t makes all terms smooth, and Gauss–Legendre quadrature
//! converges quickly. The number of points depends on the widths of the lobes and on how fast the exit azimuths change.

use crate::azimuthal::Azimuthal;
use crate::factored::{Factored, largest_channel};
use crate::gauss::rule;
use crate::longitudinal::Longitudinal;
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;
use vellus::parts::Outgoing;
use wide::f32x8;

/// A list of directions. Equal inclinations and equal azimuths are stored once, so a grid of directions is small.
#[derive(Clone, Debug, Default)]
pub struct Directions {
    thetas: Vec<f64>,
    phis: Vec<f32>,
    /// For each direction, its indices in `thetas` and `phis`.
    places: Vec<[usize; 2]>,
    vectors: Vec<Vec3>,
}

impl Directions {
    /// From pairs of θ in [−90, 90] and φ, in degrees.
    pub fn new(angles: &[[f64; 2]]) -> Self {
        let axis = |k: usize| {
            let mut values: Vec<f64> = angles.iter().map(|a| a[k]).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values
        };
        let (thetas, phis) = (axis(0), axis(1));
        let find = |axis: &[f64], x: f64| axis.partition_point(|y| y.total_cmp(&x).is_lt());
        let places = angles.iter().map(|&[theta, phi]| [find(&thetas, theta), find(&phis, phi)]).collect();
        Directions {
            thetas: thetas.into_iter().map(f64::to_radians).collect(),
            phis: phis.into_iter().map(|x| x.to_radians() as f32).collect(),
            places,
            vectors: angles.iter().map(|&[theta, phi]| direction(theta, phi)).collect(),
        }
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there are no directions.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Unit vectors of the directions, with x from root to tip.
    pub fn vectors(&self) -> &[Vec3] {
        &self.vectors
    }
}

/// The unit vector with inclination `theta` and azimuth `phi`, in degrees. x runs from root to tip, and φ = 0 is +y.
pub fn direction(theta: f64, phi: f64) -> Vec3 {
    vellus::direction(theta.to_radians(), phi.to_radians())
}

/// The factors in φ of the terms of a far field, RGB: eight unscattered lobes, and up to three others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AzimuthalSums {
    pub lanes: [f32x8; 3],
    pub others: [[f32; 3]; 3],
}

/// The factors in θᵢ of the same terms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LongitudinalFactors {
    pub lanes: f32x8,
    pub others: [f32; 3],
}

/// A hit at one offset whose terms are products of a factor in θᵢ and a factor in φ. Only the latter depends on the
/// offset.
pub(crate) trait Separable {
    /// Adds the factors of the eight unscattered lobes at each φ, times `weight`.
    fn add_lanes(&self, phis: &[f32], weight: f32, sums: &mut [AzimuthalSums]);
    /// Adds the factors of the other terms, which are wide, times `weight`.
    fn add_others(&self, phis: &[f32], weight: f32, sums: &mut [AzimuthalSums]);
    /// The factors in θᵢ.
    fn longitudinal(&self, o: &Outgoing<f32>) -> LongitudinalFactors;
    /// Exit azimuths of the eight unscattered lobes, as [`Azimuthal::exits`] defines. NaN for lobes with negligible
    /// energy.
    fn exits(&self) -> [f32; 8];
}

impl<L: Longitudinal, A: Azimuthal> Separable for Factored<L, A> {
    #[inline]
    fn add_lanes(&self, phis: &[f32], weight: f32, sums: &mut [AzimuthalSums]) {
        let energy = self.energies().map(|channel| f32x8::new(channel) * f32x8::splat(weight));
        for (phi, sum) in phis.iter().zip(sums) {
            let azimuthal = self.azimuthal.eval(*phi);
            (0..3).for_each(|c| sum.lanes[c] = azimuthal.mul_add(energy[c], sum.lanes[c]));
        }
    }

    fn add_others(&self, _: &[f32], _: f32, _: &mut [AzimuthalSums]) {}

    fn longitudinal(&self, o: &Outgoing<f32>) -> LongitudinalFactors {
        LongitudinalFactors { lanes: self.longitudinal.eval(o), others: [0.0; 3] }
    }

    fn exits(&self) -> [f32; 8] {
        let (energy, exits) = (largest_channel(self.energies()), self.azimuthal.exits());
        let least = 1e-6 * energy.iter().sum::<f32>();
        std::array::from_fn(|i| if energy[i] > least { exits[i] } else { f32::NAN })
    }
}

/// Number of points in [−1, 1] at which a panel is probed to find the size of its quadrature rule.
const LOOKS: usize = 24;

/// The average over h in all directions. `at` creates the hit at an offset. `edges` are ascending offsets in (0, 1) at
/// which the integrand is not smooth. It is not smooth at −`edges` either.
pub(crate) fn average<H: Separable>(
    at: impl Fn(f32) -> H,
    edges: &[f32],
    directions: &Directions,
    out: &mut [[f32; 3]],
) {
    let zero = AzimuthalSums { lanes: [f32x8::ZERO; 3], others: [[0.0; 3]; 3] };
    let mut sums = vec![zero; directions.phis.len()];
    let mut low = 0.0f32;
    for &high in edges.iter().chain(&[1.0]) {
        let first = (low / high).asin();
        let (middle, half) = (0.5 * (FRAC_PI_2 + first), 0.5 * (FRAC_PI_2 - first));
        let offset = |x: f32| high * (middle + half * x).sin();
        // The spacing of the points is π√(1 − x²)/n.
        let looks: [(f32, [f32; 8]); LOOKS] = std::array::from_fn(|k| {
            let x = (2.0 * k as f32 + 1.0) / LOOKS as f32 - 1.0;
            (x, at(offset(x)).exits())
        });
        let needed = looks.windows(2).fold(0.0f32, |most, pair| {
            let ((a, from), (b, to)) = (pair[0], pair[1]);
            let x = 0.5 * (a + b);
            // `max` ignores NaN.
            let fastest = (0..8).fold(0.0f32, |m, i| m.max((to[i] - from[i]).abs()));
            most.max(std::f32::consts::PI * (1.0 - x * x).sqrt() * fastest / (b - a))
        });
        let mut each = |needed: f32, add: &dyn Fn(H, f32, &mut [AzimuthalSums])| {
            for &[x, share] in rule(needed) {
                let t = middle + half * x;
                let h = high * t.sin();
                let weight = 0.5 * share * half * high * t.cos();
                [h, -h].into_iter().for_each(|h| add(at(h), weight, &mut sums));
            }
        };
        each(needed, &|hit, weight, sums| hit.add_lanes(&directions.phis, weight, sums));
        each(0.0, &|hit, weight, sums| hit.add_others(&directions.phis, weight, sums));
        low = high;
    }
    let axis = at(0.0);
    let longitudinal: Vec<LongitudinalFactors> = directions
        .thetas
        .iter()
        .map(|&theta| {
            let (sin_i, cos_i) = theta.sin_cos();
            let [sin_i, cos_i, theta_i] = [sin_i, cos_i.max(0.0), theta].map(|x| x as f32);
            axis.longitudinal(&Outgoing { sin_i, cos_i, theta_i, phi: 0.0 })
        })
        .collect();
    for (out, &[i, j]) in out.iter_mut().zip(&directions.places) {
        let (m, n) = (&longitudinal[i], &sums[j]);
        *out = std::array::from_fn(|c| {
            (m.lanes * n.lanes[c]).reduce_add() + (0..3).map(|k| m.others[k] * n.others[k][c]).sum::<f32>()
        });
    }
}
