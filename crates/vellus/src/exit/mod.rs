//! How much of the light that the medulla scattered leaves the fibre (D17): [`crate::ScatterExit::Reflecting`].
//!
//! Scattered light that meets the cuticle from inside is partly reflected, crosses the cortex and the medulla again,
//! and may be scattered again. V is the share of light in a [state](states) that leaves in the end. The medulla
//! passes light of state i without scattering with the probability Uᵢ. Otherwise it forgets where the light came
//! from, and by reciprocity the light leaves in state j with a probability ψⱼ ∝ wⱼ (1 − Uⱼ) √kⱼ, where wⱼ is the share
//! of diffuse light. Scattering by g is replaced by isotropic scattering with (1 − g) σ_ms (similarity). With the
//! transmittance T of the cuticle and the transmittance c of the cortex,
//!
//! V = T c + (1 − T) c² (U V + (1 − U) G x), x = Σ ψ V.
//!
//! Gᵢ is what absorption in the medulla leaves of scattered light that entered in state i. This is a linear equation
//! for the number x.
//!
//! Only the first exit from the medulla remembers where the light entered. Its distribution over states is a table
//! over τ, g, and the entry, for a medulla that does not absorb.
//!
//! Absorption favours states with short paths. If it leaves kᵢ of light that enters in state i, it leaves kᵢ of diffuse
//! light that leaves in state i, by reciprocity. A path is long because of its entry, or because of its exit. So the
//! probability to leave in state j has the factor √kⱼ. This exponent is empirical: 0 and 1 have larger errors against
//! photon tracing, of opposite sign.

pub(crate) mod cone;
pub(crate) mod diffuse;
pub(crate) mod low_rank;
pub mod states;
pub mod table;
pub(crate) mod turn;
mod wall;

#[cfg(feature = "unstable")]
use crate::exit::states::Geometry;
use crate::exit::states::{REGISTERS, STATES, Vector};
use crate::exit::table::{ENTRIES, ExitTable, MAX_SIN2, ROWS};
use crate::exit::wall::Walls;
use crate::fiber::Fiber;
use crate::simd::lanes::{Lanes, Quad};
use crate::simd::special::exp;
use wide::{f32x4, f32x8};

/// Coefficients of [`table::monomials`], RGB and a spare channel.
type Polynomial = [[f32; 4]; ENTRIES];

/// The exit of scattered light from one fibre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reflection {
    /// The share of scattered light that leaves, without absorption in the medulla on the first path: a polynomial in
    /// the entry.
    pub escape: Polynomial,
    /// The logarithm of what that absorption leaves. It falls too fast for a polynomial.
    pub ln_kept: Polynomial,
    /// The share of it that leaves when it first meets the cuticle.
    pub first: Polynomial,
    /// What is left of the direction of light that leaves later, see [`turn::stays`].
    pub stays: f32,
}

/// Coefficients of [`table::monomials`] for a value of 1 at each of [`table::NODES`] and 0 at the others.
#[rustfmt::skip]
const COEFFICIENTS: [f32x8; ENTRIES] = [
    f32x8::new([ 1.0, -3.0, -3.0,  2.0,  5.0,  2.0, -2.0, -2.0]),
    f32x8::new([ 0.0,  4.0,  0.0, -4.0, -4.0,  0.0,  4.0,  0.0]),
    f32x8::new([ 0.0, -1.0,  0.0,  2.0, -1.0,  0.0, -2.0,  2.0]),
    f32x8::new([ 0.0,  0.0,  4.0,  0.0, -4.0, -4.0,  0.0,  4.0]),
    f32x8::new([ 0.0,  0.0,  0.0,  0.0,  4.0,  0.0,  0.0, -4.0]),
    f32x8::new([ 0.0,  0.0, -1.0,  0.0, -1.0,  2.0,  2.0, -2.0]),
    f32x8::new([ 0.0,  0.0,  0.0,  0.0,  4.0,  0.0, -4.0,  0.0]),
    f32x8::new([ 0.0,  0.0,  0.0,  0.0, -3.0,  0.0,  2.0,  2.0]),
];

/// 1 − e⁻ˣ. It loses its digits below 0.01, where its series is exact to 4e-8.
#[inline(always)]
fn complement(x: f32x8) -> f32x8 {
    let one = f32x8::ONE;
    let series = x * (one - x * (f32x8::splat(0.5) - x * f32x8::splat(1.0 / 6.0)));
    x.simd_lt(f32x8::splat(0.01)).select(series, one - exp(-x)).fast_max(f32x8::splat(1e-30))
}

#[inline(always)]
fn sum(x: &Vector) -> f32 {
    let mut sum = x[0];
    (1..REGISTERS).for_each(|r| sum += x[r]);
    sum.reduce_add()
}

/// Light in a medulla of the optical radius τ forgets its state as in an isotropic medulla of τ (1 − g)^p. In a thick
/// medulla p is 1, the similarity of transport. Medullas of fibres are thin: with p = 0.7 totals of the presets agree
/// with traced ones to 0.4 % on average and 1.7 % at worst, with p = 1 to 0.7 % and 2.4 %.
const FORGETS: f32 = 0.7;

/// What all channels share.
pub(crate) struct Chain<'a> {
    table: &'a ExitTable,
    pub rows: [f32x8; ROWS],
    /// T.
    pub through: Vector,
    /// The length of the path from the medulla to the cuticle, in fibre radii.
    pub cortex: Vector,
    /// The reflectance of the medulla's wall, if it has one.
    wall: Option<Vector>,
    /// 1 − U.
    pub scattered: Vector,
    /// The share of light that the medulla scatters, over the share that it scatters isotropically.
    pub excess: Vector,
    /// See [`turn::stays`].
    stays: f32,
}

impl<'a> Chain<'a> {
    #[inline(always)]
    pub fn new(fiber: &Fiber, table: &'a ExitTable) -> Self {
        let (splat, one) = (f32x8::splat, f32x8::ONE);
        let geometry = &table.geometry;
        let tau = fiber.sigma_ms * fiber.kappa;
        let walls = Walls::new(fiber);
        let through = match &walls {
            Some(walls) => walls.through,
            None => table.cone.transmittance(fiber.kappa, fiber.eta, fiber.layers),
        };
        let forgets = tau * (1.0 - fiber.g).powf(FORGETS);
        let zero = [f32x8::ZERO; REGISTERS];
        let (mut cortex, mut scattered, mut excess) = (zero, zero, zero);
        let (mut passed, mut keeps) = (f32x8::ZERO, f32x8::ZERO);
        for r in 0..REGISTERS {
            let cos_gamma = (one - splat(fiber.kappa * fiber.kappa) * geometry.square[r]).sqrt();
            let length = cos_gamma - splat(fiber.kappa) * geometry.half_chord[r];
            cortex[r] = length.fast_max(f32x8::ZERO) * geometry.elongation[r];
            scattered[r] = complement(splat(forgets) * geometry.chord[r]);
            excess[r] = complement(splat(tau) * geometry.chord[r]) / scattered[r];
            passed += geometry.weight[r] * through[r];
            // A reflection takes light around the fibre by 2 (asin h″ − asin κh″), where cos asin h″ is half a chord.
            let cos = geometry.half_chord[r] * cos_gamma + splat(fiber.kappa) * geometry.square[r];
            keeps += geometry.weight[r] * (splat(2.0) * cos * cos - one);
        }
        let wall = walls.map(|walls| {
            cortex = walls.cortex;
            walls.back
        });
        let stays = turn::stays(tau * (1.0 - fiber.g), keeps.reduce_add(), 1.0 - passed.reduce_add());
        Chain { table, rows: table.rows(tau, fiber.g), through, cortex, wall, scattered, excess, stays }
    }

    /// The effect of absorption in the medulla. `medulla` is σ_ma κ.
    #[inline(always)]
    fn absorption(&self, medulla: f32) -> Absorption {
        let (splat, one) = (f32x8::splat, f32x8::ONE);
        let ones = [one; REGISTERS];
        if medulla == 0.0 {
            return Absorption { chord_keeps: ones, ln: [0.0; ENTRIES], leaving: ones, inverse: one, kept: ones };
        }
        let geometry = &self.table.geometry;
        let ln_kept = table::ln_kept(&self.rows, medulla);
        let ln = coefficients(ln_kept);
        let (mut chord_keeps, mut leaving, mut kept) = (ones, ones, ones);
        for r in 0..REGISTERS {
            chord_keeps[r] = exp(geometry.chord[r] * splat(-medulla));
            let mut sum = splat(ln[0]);
            for m in 1..ENTRIES {
                sum = geometry.monomials[m][r].mul_add(splat(ln[m]), sum);
            }
            leaving[r] = exp(sum.fast_min(f32x8::ZERO) * splat(0.5));
            // The medulla passes light with the true σ_ms. What the chain does not pass as unscattered must carry the
            // rest.
            let rest = self.excess[r].mul_add(leaving[r] * leaving[r] - chord_keeps[r], chord_keeps[r]);
            kept[r] = rest.fast_max(f32x8::ZERO).fast_min(one);
        }
        let inverse = one / self.first_exits(&leaving).fast_max(splat(f32::MIN_POSITIVE));
        Absorption { chord_keeps, ln, leaving, inverse, kept }
    }

    /// At the nodes of the entry: the share of scattered light that leaves, without absorption on the first path, and
    /// the part of it that leaves at the first encounter. `cortex` is σ_ca.
    #[inline(always)]
    fn escape(&self, cortex: f32, medulla: &Absorption) -> [f32x8; 2] {
        let (splat, one) = (f32x8::splat, f32x8::ONE);
        let zero = [f32x8::ZERO; REGISTERS];
        // V = leaves + stays x.
        let (mut leaves, mut stays, mut at_once) = (zero, zero, zero);
        let (mut numerator, mut denominator) = (zero, zero);
        for r in 0..REGISTERS {
            let c = exp(self.cortex[r] * splat(-cortex));
            let (t, scattered, kept) = (self.through[r], self.scattered[r], medulla.kept[r]);
            let mut returns = (one - t) * c * c;
            // 1 − (1 − T) c² and the losses in the medulla, as sums of positive terms.
            let mut lost = t + (one - t) * (one - c * c);
            at_once[r] = t * c;
            // Light goes back and forth between the wall and the cuticle. It always keeps its state.
            if let Some(wall) = &self.wall {
                let passes = one - wall[r];
                let often = passes / (one - wall[r] * returns).fast_max(splat(1e-20));
                (at_once[r], lost) = (at_once[r] * often, lost * often);
                returns = wall[r] + passes * often * returns;
            }
            let absorbed = (one - scattered) * (one - medulla.chord_keeps[r]);
            let inverse = one / (lost + returns * (scattered + absorbed)).fast_max(splat(1e-20));
            leaves[r] = at_once[r] * inverse;
            stays[r] = returns * scattered * kept * inverse;
            let again = self.table.geometry.weight[r] * scattered * medulla.leaving[r];
            numerator[r] = again * leaves[r];
            denominator[r] = again * inverse * (lost + returns * (absorbed + scattered * (one - kept)));
        }
        let x = sum(&numerator) / sum(&denominator).max(f32::MIN_POSITIVE);
        let mut value = leaves;
        for r in 0..REGISTERS {
            value[r] = stays[r].mul_add(splat(x), leaves[r]) * medulla.leaving[r];
            at_once[r] *= medulla.leaving[r];
        }
        // The probabilities of rare states may be below 0, and the sum of all too.
        let mean = |values: &Vector| (self.first_exits(values) * medulla.inverse).fast_max(f32x8::ZERO).fast_min(one);
        let (all, first) = (mean(&value), mean(&at_once));
        [all, (first / all.fast_max(splat(f32::MIN_POSITIVE))).fast_min(one)]
    }

    /// The mean of a number for each state over first exits, at the nodes of the entry.
    #[inline(always)]
    fn first_exits(&self, values: &Vector) -> f32x8 {
        let values: [[f32; 8]; REGISTERS] = values.map(f32x8::to_array);
        // Several sums, because each addition waits for the one before.
        let mut sums = [f32x8::ZERO; 4];
        for state in 0..STATES {
            sums[state % 4] = self.rows[state].mul_add(f32x8::splat(values[state / 8][state % 8]), sums[state % 4]);
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3])
    }
}

/// Absorption in the medulla, in one channel.
#[derive(Clone, Copy)]
struct Absorption {
    /// What it leaves of light that crosses the medulla unscattered, for each state.
    chord_keeps: Vector,
    /// The logarithm of what it leaves on the first path: a polynomial in the entry.
    ln: [f32; ENTRIES],
    /// √k, where k is what it leaves of scattered light that entered in each state. By reciprocity, this is also what
    /// it leaves of diffuse light that leaves in this state.
    leaving: Vector,
    /// 1 over the mean of √k over first exits, at the nodes of the entry.
    inverse: f32x8,
    /// What it leaves of light in each state that the chain has as scattered again.
    kept: Vector,
}

/// For each state, its share of diffuse light and the chord through the medulla; and its mean entry, as weights of the
/// nodes of the entry.
#[cfg(feature = "unstable")]
pub(crate) fn entries() -> ([[f32; 2]; STATES], [f32x8; STATES]) {
    let Geometry { weight, chord, monomials, .. } = &ExitTable::shipped().geometry;
    let at = |x: &Vector, state: usize| x[state / 8].to_array()[state % 8];
    let node = |state: usize, node: usize| -> f32 {
        let coefficients = COEFFICIENTS[node].to_array();
        (0..ENTRIES).map(|m| coefficients[m] * at(&monomials[m], state)).sum()
    };
    (
        std::array::from_fn(|state| [at(weight, state), at(chord, state)]),
        std::array::from_fn(|state| f32x8::new(std::array::from_fn(|k| node(state, k)))),
    )
}

/// The coefficients of the polynomial with these values at the nodes.
#[inline(always)]
fn coefficients(nodes: f32x8) -> [f32; ENTRIES] {
    let nodes = nodes.to_array();
    let mut sums = [f32x8::ZERO; 2];
    for node in 0..ENTRIES {
        sums[node % 2] = COEFFICIENTS[node].mul_add(f32x8::splat(nodes[node]), sums[node % 2]);
    }
    (sums[0] + sums[1]).to_array()
}

impl Reflection {
    /// The medulla must scatter.
    pub fn new(fiber: &Fiber, table: &ExitTable) -> Self {
        let chain = Chain::new(fiber, table);
        let none = [[0.0; 4]; ENTRIES];
        let mut reflection = Reflection { escape: none, ln_kept: none, first: none, stays: chain.stays };
        let mut absorption = chain.absorption(fiber.sigma_ma[0] * fiber.kappa);
        for channel in 0..3 {
            // Often channels are alike, and this is the slow part.
            let same = |sigma: &[f32; 3]| channel > 0 && sigma[channel] == sigma[channel - 1];
            if same(&fiber.sigma_ma) {
                reflection.ln_kept.iter_mut().for_each(|e| e[channel] = e[channel - 1]);
            } else {
                if channel > 0 {
                    absorption = chain.absorption(fiber.sigma_ma[channel] * fiber.kappa);
                }
                reflection.ln_kept.iter_mut().zip(absorption.ln).for_each(|(e, x)| e[channel] = x);
            }
            if same(&fiber.sigma_ca) && same(&fiber.sigma_ma) {
                reflection.escape.iter_mut().for_each(|e| e[channel] = e[channel - 1]);
                reflection.first.iter_mut().for_each(|e| e[channel] = e[channel - 1]);
                continue;
            }
            let [all, first] = chain.escape(fiber.sigma_ca[channel], &absorption);
            reflection.first.iter_mut().zip(coefficients(first)).for_each(|(e, x)| e[channel] = x);
            reflection.escape.iter_mut().zip(coefficients(all)).for_each(|(e, x)| e[channel] = x);
        }
        reflection
    }

    /// The exit of light with this sin²θ_t.
    #[inline(always)]
    pub fn at<V: Lanes>(&self, sin2: V) -> Entry<V> {
        let y = V::Quad::splat(sin2 * V::splat(1.0 / MAX_SIN2 as f32));
        let at = |polynomial: &Polynomial| {
            let e = polynomial.map(V::Quad::constant);
            [e[5].mul_add(y, e[2]).mul_add(y, e[0]), e[7].mul_add(y, e[4]).mul_add(y, e[1]), e[6].mul_add(y, e[3])]
        };
        Entry { escape: at(&self.escape), ln_kept: at(&self.ln_kept), first: at(&self.first) }
    }
}

/// The exit of light with one inclination: quadratic polynomials in the chord of the entry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry<V: Lanes> {
    escape: [V::Quad; 3],
    ln_kept: [V::Quad; 3],
    first: [V::Quad; 3],
}

impl Entry<f32> {
    /// The same inclination in all lanes.
    #[inline(always)]
    pub fn repeated(&self) -> Entry<f32x8> {
        let all = |quads: [f32x4; 3]| quads.map(|quad| Quad::constant(quad.to_array()));
        Entry { escape: all(self.escape), ln_kept: all(self.ln_kept), first: all(self.first) }
    }
}

impl<V: Lanes> Entry<V> {
    /// The share of scattered light that leaves, and the logarithm of a further factor, for the chord √(1 − h″²) of the
    /// entry.
    #[inline(always)]
    pub fn escape(&self, chord: V) -> [V::Quad; 2] {
        let c = V::Quad::splat(chord);
        let at = |e: &[V::Quad; 3]| e[2].mul_add(c, e[1]).mul_add(c, e[0]);
        // Polynomials overshoot.
        let [zero, one] = [0.0, 1.0].map(|x| V::Quad::constant([x; 4]));
        [one - (one - at(&self.escape).max(zero)).max(zero), zero - (zero - at(&self.ln_kept)).max(zero)]
    }

    /// Divides escaping light into the part that leaves when it first meets the cuticle, and the rest.
    ///
    /// In each part, no channel has more light than the same share of the channel with the most light in all. Without
    /// this the largest channels of the components could sum to 1.08, and a sample's weight could exceed 1. This share
    /// is a mean over the channels, weighted by the squares of their light: squares favour the channel with the most
    /// light, and two channels of equal light cause no jump.
    #[inline(always)]
    pub fn divide(&self, chord: V, escape: V::Quad) -> [V::Quad; 2] {
        let c = V::Quad::splat(chord);
        let [zero, one] = [0.0, 1.0].map(|x| V::Quad::constant([x; 4]));
        let share = self.first[2].mul_add(c, self.first[1]).mul_add(c, self.first[0]).max(zero);
        let share = one - (one - share).max(zero);
        let [r, g, b, _] = escape.array();
        let squares = escape * escape;
        let [sum, all] = [share * squares, squares].map(|x| {
            let [r, g, b, _] = x.array();
            r + g + b
        });
        let most = V::Quad::splat(r.max(g).max(b));
        let limit = most * V::Quad::splat(sum / all.max(V::splat(f32::MIN_POSITIVE)));
        let first = (escape * share).max(escape - (most - limit));
        let first = limit - (limit - first).max(zero);
        [first, (escape - first).max(zero)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exit::table::{NODES, monomials};

    #[test]
    fn coefficients_are_the_inverse_of_the_monomials_at_the_nodes() {
        for (i, [c, y]) in NODES.into_iter().enumerate() {
            let basis = monomials(c, y);
            for k in 0..ENTRIES {
                let value: f64 = (0..ENTRIES).map(|m| basis[m] * f64::from(COEFFICIENTS[k].to_array()[m])).sum();
                assert!((value - f64::from(u8::from(i == k))).abs() < 1e-12, "{i} {k}: {value}");
            }
        }
    }
}
