//! The far field of any model: the average over the fibre's whole width, in many directions at once.
//!
//! Near-field models are averaged by quadrature over the offset, f(θ, φ) = ½ ∫ f(h, θ, φ) dh. What depends on the inclination does
//! not depend on the offset: every model here is Σ_k M_k(θᵢ) N_k(φ; h), so that only N_k is averaged, and once for
//! each φ, whatever number of θᵢ it is asked for with. Between the offsets at which a medulla begins or reflects totally, h = b sin t
//! for each such edge b makes every term smooth, and Gauss's rule converges as fast as the lobes are wide: offsets are as dense as
//! their exit azimuths need.

use crate::azimuthal::Around;
use crate::factored::{Factored, largest_channel};
use crate::gauss::rule;
use crate::longitudinal::Along;
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;
use vellus::parts::Outgoing;
use wide::f32x8;

/// Directions of which each inclination and each azimuth is kept once: on a grid, far fewer than directions.
#[derive(Clone, Debug, Default)]
pub struct Directions {
    thetas: Vec<f64>,
    phis: Vec<f32>,
    /// Where in both each direction is.
    places: Vec<[usize; 2]>,
    vectors: Vec<Vec3>,
}

impl Directions {
    /// From θ in [−90, 90] and φ of each, degrees.
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
            vectors: angles.iter().map(|&[theta, phi]| unit(theta, phi)).collect(),
        }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// None at all.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// As unit vectors, x from root to tip.
    pub fn vectors(&self) -> &[Vec3] {
        &self.vectors
    }
}

/// Unit vector at θ and φ in degrees.
pub(crate) fn unit(theta: f64, phi: f64) -> Vec3 {
    vellus::direction(theta.to_radians(), phi.to_radians())
}

/// What the terms of a far field have of φ, RGB: the eight unscattered lobes, and up to three others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AroundSums {
    pub lanes: [f32x8; 3],
    pub others: [[f32; 3]; 3],
}

/// What the same terms have of θᵢ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AlongFactors {
    pub lanes: f32x8,
    pub others: [f32; 3],
}

/// A hit at one offset whose terms are products of a factor in θᵢ, the same at any offset, and one in φ.
pub(crate) trait Separable {
    /// Adds `weight` times what the eight unscattered lobes have of each φ.
    fn add_lanes(&self, phis: &[f32], weight: f32, sums: &mut [AroundSums]);
    /// The same of the other terms, which are wide.
    fn add_others(&self, phis: &[f32], weight: f32, sums: &mut [AroundSums]);
    /// What they have of θᵢ.
    fn along(&self, o: &Outgoing<f32>) -> AlongFactors;
    /// Exit azimuths of the eight unscattered lobes over the distance at which copies of such a lobe add up to a constant; NaN for
    /// those that hardly carry light.
    fn exits(&self) -> [f32; 8];
}

impl<L: Along, A: Around> Separable for Factored<L, A> {
    #[inline]
    fn add_lanes(&self, phis: &[f32], weight: f32, sums: &mut [AroundSums]) {
        let energy = self.energies().map(|channel| f32x8::new(channel) * f32x8::splat(weight));
        for (phi, sum) in phis.iter().zip(sums) {
            let around = self.around.eval(*phi);
            (0..3).for_each(|c| sum.lanes[c] = around.mul_add(energy[c], sum.lanes[c]));
        }
    }

    fn add_others(&self, _: &[f32], _: f32, _: &mut [AroundSums]) {}

    fn along(&self, o: &Outgoing<f32>) -> AlongFactors {
        AlongFactors { lanes: self.along.eval(o), others: [0.0; 3] }
    }

    fn exits(&self) -> [f32; 8] {
        let (energy, exits) = (largest_channel(self.energies()), self.around.exits());
        let least = 1e-6 * energy.iter().sum::<f32>();
        std::array::from_fn(|i| if energy[i] > least { exits[i] } else { f32::NAN })
    }
}

/// Places in [−1, 1] at which a panel is looked over before it is known how dense its offsets must be.
const LOOKS: usize = 24;

/// The average of hits `at` offsets over h, with edges at ±`edges`, increasing, inside (0, 1).
pub(crate) fn average<H: Separable>(
    at: impl Fn(f32) -> H,
    edges: &[f32],
    directions: &Directions,
    out: &mut [[f32; 3]],
) {
    let zero = AroundSums { lanes: [f32x8::ZERO; 3], others: [[0.0; 3]; 3] };
    let mut sums = vec![zero; directions.phis.len()];
    let mut low = 0.0f32;
    for &high in edges.iter().chain(&[1.0]) {
        let first = (low / high).asin();
        let (middle, half) = (0.5 * (FRAC_PI_2 + first), 0.5 * (FRAC_PI_2 - first));
        let offset = |x: f32| high * (middle + half * x).sin();
        // Gauss's points are π√(1 − x²)/n apart.
        let looks: [(f32, [f32; 8]); LOOKS] = std::array::from_fn(|k| {
            let x = (2.0 * k as f32 + 1.0) / LOOKS as f32 - 1.0;
            (x, at(offset(x)).exits())
        });
        let needed = looks.windows(2).fold(0.0f32, |most, pair| {
            let ((a, from), (b, to)) = (pair[0], pair[1]);
            let x = 0.5 * (a + b);
            // `max` passes over NaN.
            let fastest = (0..8).fold(0.0f32, |m, i| m.max((to[i] - from[i]).abs()));
            most.max(std::f32::consts::PI * (1.0 - x * x).sqrt() * fastest / (b - a))
        });
        let mut each = |needed: f32, add: &dyn Fn(H, f32, &mut [AroundSums])| {
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
    let along: Vec<AlongFactors> = directions
        .thetas
        .iter()
        .map(|&theta| {
            let (sin_i, cos_i) = theta.sin_cos();
            let [sin_i, cos_i, theta_i] = [sin_i, cos_i.max(0.0), theta].map(|x| x as f32);
            axis.along(&Outgoing { sin_i, cos_i, theta_i, phi: 0.0 })
        })
        .collect();
    for (out, &[i, j]) in out.iter_mut().zip(&directions.places) {
        let (m, n) = (&along[i], &sums[j]);
        *out = std::array::from_fn(|c| {
            (m.lanes * n.lanes[c]).reduce_add() + (0..3).map(|k| m.others[k] * n.others[k][c]).sum::<f32>()
        });
    }
}
