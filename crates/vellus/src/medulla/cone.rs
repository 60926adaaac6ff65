//! D18: the inclination of scattered light that leaves through the cuticle at its first encounter.
//!
//! Light enters the medulla at θ_t = asin(sin θ_o/η), leaves it at θ′, and leaves the fibre at sin θᵢ = η sin θ′. Only
//! light inside the escape cone, |sin θ′| < 1/η, can leave. Its density in s = sin θᵢ and φ is ∝ C^N(φ) C^M(θ_t, θ′, φ)
//! T(s). T(s) = 1 − b s⁴ is the transmittance of the cuticle relative to that at s = 0, averaged over the offsets at
//! which light leaves. The two halves of C^M leave in the shares Z = ∫ C^M T(s) cos θ′ dθ′. With the weight w = |φ|/π
//! of the forward half, the whole density integrates to ∫ C^N ((1 − w) Z₀ + w Z₁) dφ.
//!
//! A component of C^M is linear between its nodes, and T(η sin θ′) cos θ′ is a sum of cos θ′, cos 3θ′ and cos 5θ′. So
//! six columns of cumulative integrals are enough to integrate and to invert a component under T, for any η, b and θ_t.

use crate::cylinder::cuticle::{parts, refracted_cos2};
use crate::fiber::Fiber;
use crate::medulla::grid::{CONES, MOST_ETA, SHIFTS};
use crate::medulla::mixture::{self, Between, Densities, Weights};
use crate::medulla::tables::{BACKWARD, FORWARD, Mixture};
use std::f32::consts::FRAC_PI_2;
use wide::f32x8;

/// asin(1/[`MOST_ETA`]), the half angle of the smallest cone.
const SMALLEST: f32 = 0.339_836_9;

/// ∫ B cos θ′ dθ′ and ∫ B (η sin θ′)⁴ cos θ′ dθ′ of all components, over a cone.
type Pair<const C: usize> = [Weights<C>; 2];

/// How scattered light of one fibre leaves it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    /// η and 1/η, of the medulla. A cortex of another index does not change the inclination.
    pub eta: f32,
    pub inverse_eta: f32,
    /// b of T(s) = 1 − b s⁴, in [0, 1].
    pub loss: f32,
    /// The slope of the angle by which the cuticle turns light, over its offset h″.
    pub slope: f32,
    /// The largest h″ at which light leaves, a mean over inclinations.
    pub reach: f32,
    /// What absorption in the medulla leaves of the backward half, over what it leaves of the forward half.
    pub backward_gain: f32,
    /// T cos θ′ at the edge of the cone.
    pub edge: f32,
    /// The half angle of the cone, asin(1/η), and 1 over it.
    pub half: f32,
    pub inverse_half: f32,
    /// The position of the half angle on the nodes of [`Cones`].
    pub position: Between,
}

impl Cone {
    /// The fibre must be valid.
    pub fn new(fiber: &Fiber) -> Self {
        let eta = fiber.medulla_eta();
        let inverse_eta = 1.0 / eta;
        let cos = ((1.0 - inverse_eta) * (1.0 + inverse_eta)).max(0.0).sqrt();
        let half = inverse_eta.atan2(cos);
        let Outward { loss, slope, reach } = outward(fiber);
        let x = (half - SMALLEST) * ((CONES - 1) as f32 / (FRAC_PI_2 - SMALLEST));
        Cone {
            eta,
            inverse_eta,
            loss,
            slope,
            reach,
            backward_gain: Gain::new(fiber).at(fiber),
            edge: cos * (1.0 - loss),
            half,
            inverse_half: 1.0 / half,
            position: Between::new(x, CONES),
        }
    }

    /// Z of all backward components.
    pub fn backward(&self, cones: &Cones) -> Weights<BACKWARD> {
        let Between { index, t } = self.position;
        let [low, high] = [index, index + 1].map(|i| self.combine(&cones.backward.integrals[i]));
        std::array::from_fn(|c| (high[c] - low[c]).mul_add(f32x8::splat(t), low[c]).fast_max(f32x8::ZERO))
    }

    /// Z of all forward components for the inclination `shift` = |θ_t|.
    #[inline(always)]
    pub fn forward(&self, cones: &Cones, shift: f32) -> Weights<FORWARD> {
        let Between { index, t } = self.position;
        let along = Between::new(shift * self.inverse_half * (SHIFTS - 1) as f32, SHIFTS);
        let start = index * SHIFTS + along.index;
        let integrals = &cones.forward.integrals;
        let ([a, b], [c, d]) =
            match (integrals[start..].first_chunk::<2>(), integrals[start + SHIFTS..].first_chunk::<2>()) {
                (Some(low), Some(high)) => (low, high),
                _ => unreachable!("Between leaves room for two nodes"),
            };
        let corners = [a, b, c, d];
        let shares = [(1.0 - t) * (1.0 - along.t), (1.0 - t) * along.t, t * (1.0 - along.t), t * along.t];
        let mut sum = [f32x8::ZERO; FORWARD];
        for ([whole, lost], share) in corners.into_iter().zip(shares) {
            let (plus, minus) = (f32x8::splat(share), f32x8::splat(-self.loss * share));
            (0..FORWARD).for_each(|c| sum[c] = whole[c].mul_add(plus, lost[c].mul_add(minus, sum[c])));
        }
        sum.map(|z| z.fast_max(f32x8::ZERO))
    }

    #[inline(always)]
    fn combine<const C: usize>(&self, [whole, lost]: &Pair<C>) -> Weights<C> {
        std::array::from_fn(|c| lost[c].mul_add(f32x8::splat(-self.loss), whole[c]))
    }
}

/// D21: what [`Cone::backward_gain`] needs beside the absorption. Light that goes on has longer paths than light that
/// turns back, unless scattering is strongly forward. C^M is that of a medulla without absorption.
///
/// Its logarithm is a fit to photons in medullas with τ from 0.25 to 50, g up to 0.8 and σ_ma κ up to 1.5: the share of
/// the forward half is then right. At σ_ma κ = 0.2 the error is 0.05 where the logarithm itself is 0.19, and at 0.8 it
/// is 0.12 of 0.42 (root mean squares). All channels share one value.
pub(crate) struct Gain {
    /// How much longer the paths of the forward half are, without absorption, and per absorption.
    pub constant: f32,
    pub slope: f32,
    /// How the difference shrinks with absorption, and the optical radius of isotropic scattering.
    pub shrinks: f32,
    pub isotropic: f32,
}

impl Gain {
    pub fn new(fiber: &Fiber) -> Self {
        let tau = fiber.sigma_ms * fiber.kappa;
        let isotropic = tau * (1.0 - fiber.g);
        let constant = 0.61 + 4.49 * isotropic / (isotropic + 7.06) - 1.46 * fiber.g;
        Gain { constant, slope: 0.263, shrinks: 0.608, isotropic }
    }

    fn at(&self, fiber: &Fiber) -> f32 {
        let [r, g, b] = fiber.sigma_ma.map(|sigma| (sigma * fiber.kappa).min(2.0));
        let a = (r + g + b) * (1.0 / 3.0);
        (a * (self.constant + self.slope * a) / (1.0 + self.shrinks * a * self.isotropic)).exp()
    }
}

/// Means over light that leaves the medulla and then the fibre.
struct Outward {
    /// b of T(s) = 1 − b s⁴: the least-squares fit, over s in [0, 1], to the transmittance averaged over the offsets at
    /// which light leaves.
    loss: f32,
    /// The slope of the angle by which the cuticle turns light, over the offset h″ at which it leaves the medulla.
    slope: f32,
    /// The largest h″ at which light leaves.
    reach: f32,
}

/// Light leaves the medulla like a diffuse surface, so its offsets are uniform in [−κ, κ]. At the inclination θᵢ light
/// leaves if its offset is below 1/η′, and with the transmittance 1 − F(cos θᵢ √(1 − h²)) for an offset of h/η′. The
/// cuticle turns it by asin h − asin (h/η′).
///
/// In a medulla with air, offsets and inclinations are those inside it, and its wall turns light by asin (h κ⁻¹/η′) −
/// asin (h κ⁻¹/η_m′) more.
///
/// Gauss points: four of s and two of t, where h = h₁ t(2 − t) is dense near the largest offset h₁, where F rises
/// to 1.
fn outward(fiber: &Fiber) -> Outward {
    let splat = f32x8::splat;
    // s² of the points of s, and their weights.
    const S2: [f32; 4] = [0.004_820_781, 0.108_906_254, 0.448_887_3, 0.865_957_1];
    const SHARES: [f32; 4] = [0.173_927_43, 0.326_072_57, 0.326_072_57, 0.173_927_43];
    const T: [f32; 2] = [0.211_324_87, 0.788_675_1];
    let eight = |values: [f32; 4]| f32x8::new([0, 1, 2, 3, 0, 1, 2, 3].map(|i: usize| values[i]));
    let t = f32x8::new([T[0], T[0], T[0], T[0], T[1], T[1], T[1], T[1]]);
    let s2 = eight(S2);
    let cos2 = f32x8::ONE - s2;
    // 1/η′, the largest offset at which light leaves, and h₁.
    let eta = fiber.medulla_eta();
    let largest = (cos2 / (splat(eta * eta) - s2)).sqrt();
    let most = (splat(fiber.kappa) / largest).fast_min(f32x8::ONE);
    let h = most * t * (splat(2.0) - t);
    let cos2 = cos2 * (f32x8::ONE - h * h);
    let [back, through] = parts(fiber.eta, fiber.layers, cos2.sqrt(), refracted_cos2(fiber.eta, cos2).sqrt());
    let mut passed = through / (back + through) * largest * most * (f32x8::ONE - t);
    let inside = h * largest;
    let inverse_kappa = splat(1.0 / fiber.kappa.max(f32::MIN_POSITIVE));
    let offset = inside * inverse_kappa;
    let mut turned = h.asin() - inside.asin();
    if fiber.medulla_air > 0.0 {
        let in_cortex = ((f32x8::ONE - s2) / (splat(fiber.eta * fiber.eta) - s2)).sqrt() * h;
        turned = h.asin() - in_cortex.asin() + (in_cortex * inverse_kappa).asin() - offset.fast_min(f32x8::ONE).asin();
        let cos2 = (f32x8::ONE - s2 * splat(1.0 / (eta * eta))) * (f32x8::ONE - offset * offset);
        let cos2 = cos2.fast_max(f32x8::ZERO);
        let [back, through] = parts(fiber.eta / eta, 0.5, cos2.sqrt(), refracted_cos2(fiber.eta / eta, cos2).sqrt());
        passed *= through / (back + through);
    }
    // The coefficients of the fit c₀ − c₁ s⁴ from the moments with 1 and s⁴, up to a common factor.
    let moment = |weights: f32x8| (passed * weights).reduce_add();
    let (zeroth, fourth) = (moment(eight(SHARES)), moment(eight(SHARES) * s2 * s2));
    let (constant, line) = (zeroth * (1.0 / 9.0) - fourth * 0.2, zeroth * 0.2 - fourth);
    let loss = if constant > 0.0 { (line / constant).clamp(0.0, 1.0) } else { 0.0 };
    // The slope is the least-squares fit of a line through 0. cos θ′ makes the measure that of θ′.
    let inverse_eta = 1.0 / eta;
    let cos_inside = (f32x8::ONE - s2 * splat(inverse_eta * inverse_eta)).sqrt();
    let weight = eight(SHARES) * cos_inside * offset;
    let slope = moment(weight * turned) / moment(weight * offset).max(f32::MIN_POSITIVE);
    let furthest = most * largest * inverse_kappa;
    let sum = |x: f32x8| (x * eight(SHARES) * cos_inside).reduce_add();
    let reach = sum(furthest * furthest) / sum(furthest).max(f32::MIN_POSITIVE);
    Outward { loss, slope: if fiber.medulla_air > 0.0 { slope } else { slope.max(0.0) }, reach }
}

/// Integrals of the components over cones, for both halves of C^M.
#[derive(Clone, Debug)]
pub(crate) struct Cones {
    pub backward: Half<BACKWARD>,
    pub forward: Half<FORWARD>,
}

impl Cones {
    pub fn new(backward: &Mixture<BACKWARD>, forward: &Mixture<FORWARD>) -> Self {
        Cones { backward: Half::new(&backward.densities, 1), forward: Half::new(&forward.densities, SHIFTS) }
    }
}

/// One half of C^M.
#[derive(Clone, Debug)]
pub(crate) struct Half<const C: usize> {
    /// sin δ and cos δ of the nodes.
    pub turns: Vec<[f32; 2]>,
    /// ∫ B cos kδ dδ and ∫ B sin kδ dδ, k = 1, 3, 5, from the first node, component by component.
    pub columns: Vec<[f32; 6]>,
    /// Over cones and shifts, shifts fastest.
    pub integrals: Vec<Pair<C>>,
}

/// A cone around the angle δ = `shift`, and the weight of θ′ = δ − `shift` inside it.
#[derive(Clone, Copy)]
struct View {
    sin: f32,
    cos: f32,
    /// b η⁴.
    quartic: f32,
    /// The factors of the six columns.
    factors: [f32; 6],
}

impl View {
    /// sin⁴θ′ cos θ′ = (2 cos θ′ − 3 cos 3θ′ + cos 5θ′)/16.
    fn new(shift: f32, eta: f32, loss: f32) -> Self {
        let quartic = loss * (eta * eta) * (eta * eta);
        let part = quartic / 16.0;
        let (sin, cos) = shift.sin_cos();
        // Sines and cosines of multiples by addition of twice the angle.
        let (sin2, cos2) = (2.0 * sin * cos, (cos - sin) * (cos + sin));
        let turn = |(s, c): (f32, f32)| (s * cos2 + c * sin2, c * cos2 - s * sin2);
        let (sin3, cos3) = turn((sin, cos));
        let (sin5, cos5) = turn((sin3, cos3));
        let [a, b, c] = [1.0 - 2.0 * part, 3.0 * part, -part];
        View { sin, cos, quartic, factors: [a * cos, a * sin, b * cos3, b * sin3, c * cos5, c * sin5] }
    }

    /// T cos θ′ at the angle δ with this sine and cosine.
    #[inline(always)]
    fn weight(&self, [sin, cos]: [f32; 2]) -> f32 {
        let square = (sin * self.cos - cos * self.sin).powi(2);
        ((cos * self.cos + sin * self.sin) * (1.0 - self.quartic * square * square)).max(0.0)
    }

    #[inline(always)]
    fn sum(&self, column: &[f32; 6]) -> f32 {
        let [a, b, c, d, e, f] = std::array::from_fn(|k| self.factors[k] * column[k]);
        (a + b) + (c + d) + (e + f)
    }
}

impl<const C: usize> Half<C> {
    fn new(densities: &Densities<C>, shifts: usize) -> Self {
        let nodes = densities.nodes();
        let columns: Vec<[f32; 6]> = (0..8 * C).flat_map(|r| columns(densities, r)).collect();
        let turns = (0..nodes).map(|j| densities.exact_node(j).sin_cos()).map(|(s, c)| [s as f32, c as f32]).collect();
        let mut half = Half { turns, columns, integrals: Vec::with_capacity(CONES * shifts) };
        // The same columns for eight components at a time.
        let rows: Vec<[Weights<C>; 6]> = (0..nodes)
            .map(|j| {
                std::array::from_fn(|k| {
                    std::array::from_fn(|c| {
                        f32x8::new(std::array::from_fn(|i| half.columns[(8 * c + i) * nodes + j][k]))
                    })
                })
            })
            .collect();
        for cone in 0..CONES {
            let angle = SMALLEST + (FRAC_PI_2 - SMALLEST) * cone as f32 / (CONES - 1) as f32;
            let eta = if cone == 0 { MOST_ETA } else { 1.0 / angle.sin() };
            for k in 0..shifts {
                let shift = angle * k as f32 / (shifts.max(2) - 1) as f32;
                let pair = half.over_cone(densities, &rows, [shift, angle, eta]);
                half.integrals.push(pair);
            }
        }
        half
    }

    /// The integrals of all components over the cone of a half angle, around a shift. `rows`: the columns.
    fn over_cone(&self, densities: &Densities<C>, rows: &[[Weights<C>; 6]], [shift, half, eta]: [f32; 3]) -> Pair<C> {
        // T = 1, and T = 1 − s⁴: the second integral is their difference.
        let views = [0.0, 1.0].map(|loss| View::new(shift, eta, loss));
        let [low, high] = densities.range([shift - half, shift + half]);
        let ends = [(low, densities.above(low), -1.0), (high, densities.below(high), 1.0)];
        let mut pair = [[f32x8::ZERO; C]; 2];
        for (view, sums) in views.iter().zip(&mut pair) {
            for (delta, node, sign) in ends {
                let (inner, outer) = (densities.row(densities.node(node)), densities.row(delta));
                let part = 0.5 * (delta - densities.node(node));
                let (sin, cos) = delta.sin_cos();
                let factors = [view.weight(self.turns[node]) * part, view.weight([sin, cos]) * part];
                for c in 0..C {
                    let mut sum = inner[c] * f32x8::splat(factors[0]) + outer[c] * f32x8::splat(factors[1]);
                    for (column, factor) in rows[node].iter().zip(view.factors) {
                        sum = column[c].mul_add(f32x8::splat(factor), sum);
                    }
                    sums[c] = sum.mul_add(f32x8::splat(sign), sums[c]);
                }
            }
        }
        let [whole, passed] = pair;
        [whole, std::array::from_fn(|c| (whole[c] - passed[c]).fast_max(f32x8::ZERO))]
    }

    /// Inverts the cumulative density of component `r` under T cos θ′ for light at the inclination `shift`: returns
    /// the δ with the fraction `u` of the density below it. Within an interval the weighted density is taken as linear.
    pub fn invert(&self, densities: &Densities<C>, cone: &Cone, r: usize, u: f32, shift: f32) -> f32 {
        let view = View::new(shift, cone.eta, cone.loss);
        let nodes = densities.nodes();
        let columns = &self.columns[r * nodes..(r + 1) * nodes];
        let cumulative = |j: usize| view.sum(&columns[j]);
        let at = |j: usize| (densities.node(j), cumulative(j), densities.value(r, j) * view.weight(self.turns[j]));
        // The ends, with the cumulative density there, and the nodes next to them inside.
        let [low, high] = densities.range([shift - cone.half, shift + cone.half]);
        let [from, to] = [densities.above(low), densities.below(high)];
        let end = |delta: f32, (node, sum, inner): (f32, f32, f32)| {
            let outer = densities.component(r, delta) * cone.edge;
            (delta, sum + 0.5 * (inner + outer) * (delta - node), outer)
        };
        let (start, stop) = (end(low, at(from)), end(high, at(to)));
        mixture::invert([from, to], [start, stop], u, at, cumulative)
    }
}

/// The cumulative integrals of one component at its nodes.
fn columns<const C: usize>(densities: &Densities<C>, r: usize) -> Vec<[f32; 6]> {
    let mut sums = [0.0f64; 6];
    let mut column = vec![[0.0; 6]];
    for j in 0..densities.nodes() - 1 {
        let [x0, x1] = [j, j + 1].map(|j| densities.exact_node(j));
        let [f0, f1] = [j, j + 1].map(|j| f64::from(densities.value(r, j)));
        let slope = (f1 - f0) / (x1 - x0);
        for i in 0..3 {
            // ∫ f cos kδ and ∫ f sin kδ over the interval, by parts.
            let k = (2 * i + 1) as f64;
            let ((s0, c0), (s1, c1)) = ((k * x0).sin_cos(), (k * x1).sin_cos());
            sums[2 * i] += (f1 * s1 - f0 * s0) / k + slope * (c1 - c0) / (k * k);
            sums[2 * i + 1] += (f0 * c0 - f1 * c1) / k + slope * (s1 - s0) / (k * k);
        }
        column.push(sums.map(|x| x as f32));
    }
    column
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fiber::exit::ScatterExit;
    use crate::medulla::tables::Tables;

    /// Z of every component against the midpoint rule over the cone, for indices and shifts between the nodes.
    #[test]
    fn integrals_match_quadrature() {
        let tables = Tables::shipped();
        let (mut worst, mut largest) = (0.0f32, 0.0f32);
        for (eta, kappa, layers) in
            [(1.0, 0.5, 0.5), (1.07, 0.9, 2.0), (1.31, 0.4, 1.8), (1.69, 0.88, 0.47), (3.0, 0.6, 1.0)]
        {
            let fiber = Fiber { eta, kappa, layers, exit: ScatterExit::Reflecting, ..Fiber::hair() };
            let cone = Cone::new(&fiber);
            for part in [0.0, 0.13, 0.5, 0.77, 0.96, 0.999] {
                let shift = part * cone.half;
                let fast = cone.forward(tables.cones(), shift);
                let mut exact = [0.0f32; 8 * FORWARD];
                let n = 4000;
                for k in 0..n {
                    let theta = ((k as f32 + 0.5) / n as f32 * 2.0 - 1.0) * cone.half;
                    let s2 = (eta * theta.sin()).powi(2);
                    let weight = theta.cos() * (1.0 - cone.loss * s2 * s2).max(0.0) * 2.0 * cone.half / n as f32;
                    for (r, sum) in exact.iter_mut().enumerate() {
                        *sum += tables.forward.densities.component(r, theta + shift) * weight;
                    }
                }
                for (r, z) in exact.into_iter().enumerate() {
                    worst = worst.max((fast[r / 8].to_array()[r % 8] - z).abs());
                    largest = largest.max(z);
                }
            }
        }
        println!("worst {worst} of {largest}");
        // The error of the interpolation. The components have heights up to 1.
        assert!(worst < 5e-4, "{worst} of {largest}");
    }

    #[test]
    fn the_index_of_air_loses_nothing() {
        for (eta, expected) in [(1.0, 0.0..1e-6), (1.55, 0.7..1.0)] {
            let loss = outward(&Fiber { eta, kappa: 0.8, ..Fiber::hair() }).loss;
            assert!(expected.contains(&loss), "{eta}: {loss}");
        }
    }
}
