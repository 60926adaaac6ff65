//! How much of the light that the medulla scattered leaves the fibre (D17): [`crate::Exit::Reflecting`].
//!
//! Scattered light that meets the cuticle from inside is partly reflected, crosses the cortex and the medulla again,
//! and may be scattered again. V is the share of light in a [state](states) that leaves in the end. The medulla
//! passes light of state i without scattering with the probability Uᵢ. Otherwise it forgets where the light came
//! from, and by reciprocity the light leaves in state j with a probability ψⱼ ∝ wⱼ (1 − Uⱼ), where wⱼ is the share of
//! diffuse light. Scattering by g is replaced by isotropic scattering with (1 − g) σ_ms (similarity). With the
//! transmittance T of the cuticle and the transmittance c of the cortex,
//!
//! V = T c + (1 − T) c² (U V + (1 − U) G x), x = Σ ψ V.
//!
//! G is what absorption in the medulla leaves of scattered light. This is a linear equation for the number x.
//!
//! Only the first exit from the medulla remembers where the light entered. Its distribution over states is a table
//! over τ, g, and the entry.

pub(crate) mod cone;
pub(crate) mod diffuse;
pub mod states;
pub mod table;

use crate::exit::states::{REGISTERS, STATES, Vector};
use crate::exit::table::{ENTRIES, ExitTable, MAX_SIN2, ROWS};
use crate::fiber::Fiber;
use crate::simd::lanes::{Lanes, Quad};
use crate::simd::special::exp;
use wide::f32x8;

/// Coefficients of [`table::monomials`], RGB and a spare channel.
type Polynomial = [[f32; 4]; ENTRIES];

/// The exit of scattered light from one fibre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reflection {
    /// The share of scattered light that leaves, without absorption in the medulla on the first path: a polynomial in
    /// the entry.
    escape: Polynomial,
    /// The logarithm of what that absorption leaves. It falls too fast for a polynomial.
    ln_kept: Polynomial,
    /// The share of it that leaves when it first meets the cuticle.
    first: [f32; 4],
    /// The mean of that share over the channels, weighted by the squares of their light.
    common: f32,
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

/// How typical the nodes of the entry are, for the mean share of first exits: chords are long for most offsets, and
/// θ_t is small for most fibres.
const TYPICAL: f32x8 = f32x8::new([0.05, 0.2, 0.4, 0.03, 0.3, 0.0, 0.01, 0.01]);

/// The mean over diffuse light of a polynomial with these node values: h″ is uniform, and θ has the density ∝ cos² θ.
const DIFFUSE: f32x8 = f32x8::new([-0.069499, 0.343002, 0.201806, 0.105976, 0.387851, -0.059338, 0.131924, -0.041721]);

#[inline(always)]
fn sum(x: &Vector) -> f32 {
    let mut sum = x[0];
    (1..REGISTERS).for_each(|r| sum += x[r]);
    sum.reduce_add()
}

/// What all channels share.
struct Chain<'a> {
    table: &'a ExitTable,
    rows: [f32x8; ROWS],
    /// T.
    through: Vector,
    /// The length of the path from the medulla to the cuticle, in fibre radii.
    cortex: Vector,
    /// 1 − U.
    scattered: Vector,
    /// ψ, not normalised.
    again: Vector,
    /// The diffuse light that the medulla passes forward by scattering, and that the chain has as scattered: the part
    /// of each state that is unscattered with σ_ms less the part with (1 − g) σ_ms, at most 0.
    forward: Vector,
    /// The share of diffuse light that the medulla scatters.
    all_scattered: f32,
}

impl<'a> Chain<'a> {
    #[inline(always)]
    fn new(fiber: &Fiber, table: &'a ExitTable) -> Self {
        let (splat, one) = (f32x8::splat, f32x8::ONE);
        let geometry = &table.geometry;
        let tau = fiber.sigma_ms * fiber.kappa;
        let through = table.cone.transmittance(fiber.kappa, fiber.eta, fiber.layers);
        let zero = [f32x8::ZERO; REGISTERS];
        let (mut cortex, mut scattered, mut again, mut forward) = (zero, zero, zero, zero);
        let mut all_scattered = f32x8::ZERO;
        for r in 0..REGISTERS {
            let cos_gamma = (one - splat(fiber.kappa * fiber.kappa) * geometry.square[r]).sqrt();
            let length = cos_gamma - splat(fiber.kappa) * geometry.half_chord[r];
            cortex[r] = length.fast_max(f32x8::ZERO) * geometry.elongation[r];
            let depth = splat(tau * (1.0 - fiber.g)) * geometry.chord[r];
            // 1 − e⁻ˣ loses its digits below 0.01, where its series is exact to 4e-8.
            let series = depth * (one - depth * (splat(0.5) - depth * splat(1.0 / 6.0)));
            let complement = one - exp(-depth);
            scattered[r] = depth.simd_lt(splat(0.01)).select(series, complement).fast_max(splat(1e-30));
            again[r] = geometry.weight[r] * scattered[r];
            let unscattered = exp(geometry.chord[r] * splat(-tau));
            forward[r] = geometry.weight[r] * (unscattered - (one - scattered[r]));
            all_scattered += geometry.weight[r] * (one - unscattered);
        }
        let all_scattered = all_scattered.reduce_add();
        Chain { table, rows: table.rows(tau, fiber.g), through, cortex, scattered, again, forward, all_scattered }
    }

    /// The effect of absorption in the medulla. `medulla` is σ_ma κ.
    #[inline(always)]
    fn absorption(&self, medulla: f32) -> Absorption {
        let (splat, one) = (f32x8::splat, f32x8::ONE);
        if medulla == 0.0 {
            return Absorption { chord_keeps: [one; REGISTERS], ln_kept: f32x8::ZERO, kept_first: one, kept: 1.0 };
        }
        let ln_kept = table::ln_kept(&self.rows, medulla);
        let kept_first = exp(ln_kept);
        let (mut chord_keeps, mut less) = ([one; REGISTERS], [f32x8::ZERO; REGISTERS]);
        for r in 0..REGISTERS {
            chord_keeps[r] = exp(self.table.geometry.chord[r] * splat(-medulla));
            less[r] = self.forward[r] * chord_keeps[r];
        }
        // The medulla passes diffuse light with the true σ_ms. What the chain does not pass as unscattered must carry
        // the rest.
        let scattered = (kept_first * DIFFUSE).reduce_add().clamp(0.0, 1.0) * self.all_scattered;
        let kept = ((scattered + sum(&less)) / sum(&self.again)).clamp(0.0, 1.0);
        Absorption { chord_keeps, ln_kept, kept_first, kept }
    }

    /// At the nodes of the entry: the share of scattered light that leaves, and the share that leaves at the first
    /// encounter, both without absorption on the first path. `cortex` is σ_ca.
    #[inline(always)]
    fn escape(&self, cortex: f32, medulla: &Absorption) -> [f32x8; 2] {
        let (splat, one) = (f32x8::splat, f32x8::ONE);
        let zero = [f32x8::ZERO; REGISTERS];
        let kept = medulla.kept;
        // V = leaves + stays x.
        let (mut leaves, mut stays, mut at_once) = (zero, zero, zero);
        let (mut numerator, mut denominator) = (zero, zero);
        for r in 0..REGISTERS {
            let c = exp(self.cortex[r] * splat(-cortex));
            let (t, scattered) = (self.through[r], self.scattered[r]);
            let returns = (one - t) * c * c;
            // 1 − (1 − T) c² and the losses in the medulla, as sums of positive terms.
            let lost = t + (one - t) * (one - c * c);
            let absorbed = (one - scattered) * (one - medulla.chord_keeps[r]);
            let inverse = one / (lost + returns * (scattered + absorbed)).fast_max(splat(1e-20));
            at_once[r] = t * c;
            leaves[r] = at_once[r] * inverse;
            stays[r] = returns * scattered * splat(kept) * inverse;
            numerator[r] = self.again[r] * leaves[r];
            denominator[r] = self.again[r] * inverse * (lost + returns * (absorbed + scattered * splat(1.0 - kept)));
        }
        let x = sum(&numerator) / sum(&denominator).max(f32::MIN_POSITIVE);
        let (mut value, mut first) = ([0.0f32; STATES], [0.0f32; STATES]);
        for r in 0..REGISTERS {
            let v = stays[r].mul_add(splat(x), leaves[r]);
            value[8 * r..8 * r + 8].copy_from_slice(&v.to_array());
            first[8 * r..8 * r + 8].copy_from_slice(&at_once[r].to_array());
        }
        [value, first].map(|values| self.first_exits(&values))
    }

    /// The mean of a number for each state over first exits, at the nodes of the entry.
    #[inline(always)]
    fn first_exits(&self, values: &[f32; STATES]) -> f32x8 {
        // Several sums, because each addition waits for the one before.
        let mut sums = [f32x8::ZERO; 4];
        for state in 0..STATES {
            sums[state % 4] = self.rows[state].mul_add(f32x8::splat(values[state]), sums[state % 4]);
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3])
    }
}

/// Absorption in the medulla, in one channel.
#[derive(Clone, Copy)]
struct Absorption {
    /// What it leaves of light that crosses the medulla unscattered, for each state.
    chord_keeps: Vector,
    /// What it leaves on the first path, by the entry, and the logarithm of it.
    kept_first: f32x8,
    ln_kept: f32x8,
    /// What it leaves of light that the chain has as scattered again.
    kept: f32,
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
        let mut reflection = Reflection { escape: none, ln_kept: none, first: [0.0; 4], common: 0.0 };
        let mut totals = [0.0f32; 3];
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
                let ln_kept = coefficients(absorption.ln_kept);
                reflection.ln_kept.iter_mut().zip(ln_kept).for_each(|(e, x)| e[channel] = x);
            }
            if same(&fiber.sigma_ca) && same(&fiber.sigma_ma) {
                reflection.escape.iter_mut().for_each(|e| e[channel] = e[channel - 1]);
                reflection.first[channel] = reflection.first[channel - 1];
                totals[channel] = totals[channel - 1];
                continue;
            }
            let [all, first] = chain.escape(fiber.sigma_ca[channel], &absorption);
            let weight = absorption.kept_first * TYPICAL;
            let [total, at_first] = [all, first].map(|x| (x * weight).reduce_add());
            // The probabilities of rare states are polynomials, which may be below 0.
            reflection.first[channel] = (at_first / total.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            totals[channel] = total;
            reflection.escape.iter_mut().zip(coefficients(all)).for_each(|(e, x)| e[channel] = x);
        }
        // Squares favour the channel with the most light, and two channels of equal light cause no jump.
        let sum = |weight: &dyn Fn(usize) -> f32| (0..3).map(|c| weight(c) * totals[c] * totals[c]).sum::<f32>();
        reflection.common = sum(&|c| reflection.first[c]) / sum(&|_| 1.0).max(f32::MIN_POSITIVE);
        reflection
    }

    /// The share of scattered light that leaves, and the logarithm of a further factor, for the chord √(1 − h″²) and
    /// sin²θ_t of its entry.
    #[inline(always)]
    pub fn escape<V: Lanes>(&self, chord: V, sin2: V) -> [V::Quad; 2] {
        let c = V::Quad::splat(chord);
        let y = V::Quad::splat(sin2 * V::splat(1.0 / MAX_SIN2 as f32));
        let at = |polynomial: &Polynomial| {
            let e = polynomial.map(V::Quad::constant);
            let straight = e[0] + c * (e[1] + c * e[3]);
            straight + y * (e[2] + c * (e[4] + c * e[6]) + y * (e[5] + c * e[7]))
        };
        // Polynomials overshoot.
        let [zero, one] = [0.0, 1.0].map(|x| V::Quad::constant([x; 4]));
        [one - (one - at(&self.escape).max(zero)).max(zero), zero - (zero - at(&self.ln_kept)).max(zero)]
    }

    /// Divides escaping light into the part that leaves when it first meets the cuticle, and the rest.
    ///
    /// In each part, no channel has more light than the same share of the channel with the most light in all. Without
    /// this the largest channels of the components could sum to 1.08, and a sample's weight could exceed 1.
    #[inline(always)]
    pub fn divide<V: Lanes>(&self, escape: V::Quad) -> [V::Quad; 2] {
        let [r, g, b, _] = escape.array();
        let most = V::Quad::splat(r.max(g).max(b));
        let [share, zero] = [[self.common; 4], [0.0; 4]].map(V::Quad::constant);
        let limit = most * share;
        let first = (escape * V::Quad::constant(self.first)).max(escape - (most - limit));
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
