//! A compressed table. Every profile is a mixture of the same few densities over the outgoing angle. Its weights are
//! products of one factor per parameter (Yan17 Eq. 17–18, with non-negative factors).
//!
//! The factors are non-negative, so a profile is never negative, and one sum over the weights normalises it. Sampling
//! is exact: it chooses a component, and then inverts it.
//!
//! A component B_r is piecewise linear in the angle δ. It is integrated with the weight cos(δ − s), for a shift s
//! that the query chooses. The azimuthal table uses no weight, the longitudinal ones use cos θᵢ.

use crate::choose as weighted;
use std::f64::consts::PI;
use wide::f32x8;

/// Linear interpolation between nodes `index` and `index + 1`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Between {
    pub index: usize,
    pub t: f32,
}

impl Between {
    /// Position `x` on nodes 0 … `nodes − 1`, clamped to that range. NaN becomes 0.
    #[inline(always)]
    pub fn new(x: f32, nodes: usize) -> Self {
        let x = if x > 0.0 { x.min((nodes - 1) as f32) } else { 0.0 };
        // Below 2³¹ by the previous line. The cast through i32 is one instruction.
        let index = (x as i32 as usize).min(nodes - 2);
        Between { index, t: x - index as f32 }
    }
}

/// `C` registers of eight components.
pub(crate) type Weights<const C: usize> = [f32x8; C];

/// One value for each node and component, in node order.
#[derive(Clone, Debug)]
pub(crate) struct Rows<const C: usize>(Vec<[f32x8; C]>);

impl<const C: usize> Rows<C> {
    /// Creates rows from `rank` ≤ 8·C values per node. The missing components are 0.
    pub fn new(values: &[f32], rank: usize) -> Self {
        Rows(
            values
                .chunks_exact(rank)
                .map(|row| {
                    std::array::from_fn(|c| {
                        f32x8::new(std::array::from_fn(|i| row.get(8 * c + i).copied().unwrap_or(0.0)))
                    })
                })
                .collect(),
        )
    }

    /// From whole registers.
    #[cfg(feature = "unstable")]
    pub fn from_rows(rows: Vec<[f32x8; C]>) -> Self {
        Rows(rows)
    }

    pub fn nodes(&self) -> usize {
        self.0.len()
    }

    /// The values of a node.
    #[inline(always)]
    pub fn row(&self, node: usize) -> &[f32x8; C] {
        &self.0[node]
    }

    /// The factors between two nodes.
    #[inline(always)]
    pub fn at(&self, x: Between) -> Weights<C> {
        let [a, b] = self.pair(x);
        let t = f32x8::splat(x.t);
        let mut out = *a;
        for c in 0..C {
            out[c] = (b[c] - a[c]).mul_add(t, a[c]);
        }
        out
    }

    #[inline(always)]
    fn pair(&self, x: Between) -> &[Weights<C>; 2] {
        match self.0[x.index..].first_chunk() {
            Some(pair) => pair,
            None => unreachable!("Between leaves room for two nodes"),
        }
    }

    /// Σ_r w_r v_r between two nodes.
    #[inline(always)]
    pub fn dot(&self, w: &Weights<C>, x: Between) -> f32 {
        let [a, b] = self.pair(x);
        let (mut low, mut high) = (f32x8::ZERO, f32x8::ZERO);
        for c in 0..C {
            low = w[c].mul_add(a[c], low);
            high = w[c].mul_add(b[c], high);
        }
        (high - low).mul_add(f32x8::splat(x.t), low).reduce_add()
    }
}

#[inline(always)]
pub(crate) fn product<const C: usize>(a: &Weights<C>, b: &Weights<C>) -> Weights<C> {
    let mut out = *a;
    for c in 0..C {
        out[c] *= b[c];
    }
    out
}

/// The factor that normalises Σ w_r z_r to 1. It is 0 if the sum is 0.
#[inline(always)]
pub(crate) fn normaliser<const C: usize>(w: &Weights<C>, z: &Weights<C>) -> f32 {
    let sum = dot(w, z);
    if sum > 0.0 { 1.0 / sum } else { 0.0 }
}

/// Σ w_r z_r.
#[inline(always)]
pub(crate) fn dot<const C: usize>(w: &Weights<C>, z: &Weights<C>) -> f32 {
    let mut sum = f32x8::ZERO;
    for c in 0..C {
        sum = w[c].mul_add(z[c], sum);
    }
    sum.reduce_add()
}

/// Draws a component with probability w_r z_r / Σ, and returns the rest of `u` as a new uniform number.
pub(crate) fn choose<const C: usize>(w: &Weights<C>, z: &Weights<C>, u: f32) -> (usize, f32) {
    let products = product(w, z);
    let mut sums = [0.0; C];
    let mut total = 0.0;
    for (sum, p) in sums.iter_mut().zip(&products) {
        *sum = p.reduce_add();
        total += *sum;
    }
    let mut rest = u * total;
    // If rounding leaves a rest, the last block and component with a weight is chosen.
    let mut block = 0;
    for (c, &sum) in sums.iter().enumerate() {
        if sum > 0.0 {
            block = c;
            if rest < sum {
                break;
            }
        }
        rest -= sum;
    }
    rest = rest.clamp(0.0, sums[block]);
    let components = products[block].to_array().into_iter().enumerate();
    match weighted::choose(components, rest) {
        Some(choice) => (8 * block + choice.item, choice.fraction().clamp(0.0, 1.0)),
        None => (8 * block, 0.5),
    }
}

/// Distance of the nodes of Z_r(s), radians: half a degree.
const SHIFT_STEP: f64 = PI / 360.0;

/// Piecewise-linear densities B_r(δ) on equidistant nodes, with their cumulative moments.
#[derive(Clone, Debug)]
pub(crate) struct Densities<const C: usize> {
    pub first: f32,
    pub inv_step: f32,
    pub step: f32,
    pub values: Rows<C>,
    /// ∫ B_r cos δ dδ and ∫ B_r sin δ dδ from the first node, component by component. Without the cosine weight:
    /// ∫ B_r dδ and ∫ B_r w dδ, see [`forward_weight`].
    pub columns: [Vec<f32>; 2],
    /// Without the cosine weight: ∫ B_r w dδ over the circle.
    forward: Weights<C>,
    /// Z_r(s) on nodes every [`SHIFT_STEP`] from one below s = 0 to one above s = 90°.
    pub integrals: Rows<C>,
    /// Whether the components are integrated with the cosine weight.
    weighted: bool,
}

impl<const C: usize> Densities<C> {
    /// Creates densities from `rank` values per node. Node j is at δ = `first` + j·`step`. If `weighted` is false,
    /// components are scaled to integral 1.
    pub fn new(values: &[f32], rank: usize, first: f64, step: f64, weighted: bool) -> Self {
        let nodes = values.len() / rank;
        let mut scaled = vec![0.0f32; values.len()];
        let mut columns = [vec![0.0f32; values.len()], vec![0.0f32; values.len()]];
        for r in 0..rank {
            let b = |j: usize| f64::from(values[j * rank + r]);
            let mut sums = [0.0f64; 2];
            let mut cumulative = vec![[0.0f64; 2]];
            for j in 0..nodes - 1 {
                let x = first + j as f64 * step;
                let (f0, slope) = (b(j), (b(j + 1) - b(j)) / step);
                if weighted {
                    // ∫ (f0 + slope (δ − x)) cos δ dδ over one interval, and the same with sin.
                    let (s0, c0) = x.sin_cos();
                    let (s1, c1) = (x + step).sin_cos();
                    sums[0] += f0 * (s1 - s0) + slope * (step * s1 + c1 - c0);
                    sums[1] += f0 * (c0 - c1) + slope * (s1 - s0 - step * c1);
                } else {
                    let [w0, w1] = [x, x + step].map(forward_weight);
                    sums[0] += 0.5 * (b(j) + b(j + 1)) * step;
                    sums[1] += (b(j) * (2.0 * w0 + w1) + b(j + 1) * (w0 + 2.0 * w1)) * (step / 6.0);
                }
                cumulative.push(sums);
            }
            let scale = if weighted || sums[0] <= 0.0 { 1.0 } else { 1.0 / sums[0] };
            for j in 0..nodes {
                scaled[j * rank + r] = (b(j) * scale) as f32;
                for k in 0..2 {
                    columns[k][r * nodes + j] = (cumulative[j][k] * scale) as f32;
                }
            }
        }
        let mut forward = [f32x8::ZERO; C];
        for r in 0..if weighted { 0 } else { rank } {
            let mut lanes = forward[r / 8].to_array();
            lanes[r % 8] = columns[1][(r + 1) * nodes - 1];
            forward[r / 8] = f32x8::new(lanes);
        }
        let mut densities = Densities {
            first: first as f32,
            inv_step: (1.0 / step) as f32,
            step: step as f32,
            values: Rows::new(&scaled, rank),
            columns,
            forward,
            integrals: Rows(Vec::new()),
            weighted,
        };
        if weighted {
            let shifts = (-1..=181).map(|k| (f64::from(k) * SHIFT_STEP) as f32);
            let row = |shift| (0..rank).map(|r| densities.integral(r, shift)).collect::<Vec<f32>>();
            let table: Vec<f32> = shifts.flat_map(row).collect();
            densities.integrals = Rows::new(&table, rank);
        }
        densities
    }

    #[inline(always)]
    fn between(&self, delta: f32) -> Between {
        Between::new((delta - self.first) * self.inv_step, self.values.nodes())
    }

    /// The number of nodes of δ.
    pub fn nodes(&self) -> usize {
        self.values.nodes()
    }

    /// δ of a node.
    pub fn node(&self, j: usize) -> f32 {
        self.first + j as f32 * self.step
    }

    /// δ of a node in double precision.
    pub fn exact_node(&self, j: usize) -> f64 {
        f64::from(self.first) + j as f64 * f64::from(self.step)
    }

    /// Angles clamped to the range of the nodes.
    pub fn range(&self, ends: [f32; 2]) -> [f32; 2] {
        ends.map(|delta| delta.clamp(self.first, self.node(self.nodes() - 1)))
    }

    /// The first node at or above an angle in the range of the nodes.
    pub fn above(&self, delta: f32) -> usize {
        (((delta - self.first) * self.inv_step).ceil() as usize).min(self.nodes() - 1)
    }

    /// The last node at or below an angle in the range of the nodes.
    pub fn below(&self, delta: f32) -> usize {
        (((delta - self.first) * self.inv_step) as usize).min(self.nodes() - 1)
    }

    /// B_r(δ) of one component.
    pub fn component(&self, r: usize, delta: f32) -> f32 {
        let Between { index, t } = self.between(delta);
        let [a, b] = [index, index + 1].map(|j| self.value(r, j));
        a + t * (b - a)
    }

    /// B_r(δ) of all components.
    pub fn row(&self, delta: f32) -> Weights<C> {
        self.values.at(self.between(delta))
    }

    /// Σ_r w_r B_r(δ).
    #[inline(always)]
    pub fn eval(&self, w: &Weights<C>, delta: f32) -> f32 {
        self.values.dot(w, self.between(delta))
    }

    /// Σ_r w_r B_r(δ) of eight mixtures, with one δ each.
    #[inline(always)]
    pub fn eval8(&self, weights: [&Weights<C>; 8], delta: f32x8) -> f32x8 {
        let splat = f32x8::splat;
        let last = self.values.nodes() - 2;
        let x = (delta - splat(self.first)) * splat(self.inv_step);
        let x = x.fast_max(f32x8::ZERO).fast_min(splat((last + 1) as f32));
        let whole = x.fast_min(splat(last as f32)).fast_trunc_int();
        let t = (x - f32x8::from_i32x8(whole)).to_array();
        let index = whole.to_array();
        let mut sums = [f32x8::ZERO; 8];
        for i in 0..8 {
            // NaN becomes `last`. The result is then undefined, but there is no panic.
            let [a, b] = self.values.pair(Between { index: (index[i] as usize).min(last), t: t[i] });
            let (mut low, mut high) = (f32x8::ZERO, f32x8::ZERO);
            for c in 0..C {
                low = weights[i][c].mul_add(a[c], low);
                high = weights[i][c].mul_add(b[c], high);
            }
            sums[i] = (high - low).mul_add(splat(t[i]), low);
        }
        let [a, b, c, d, e, f, g, h] = f32x8::transpose(sums);
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }

    /// Z_r(s) = ∫ B_r(δ) cos(δ − s) dδ over the half circle where the cosine is positive, for s in [0°, 90°]. Cubic
    /// interpolation of a table; the error for the sharpest component (0.04 wide) is (0.5°/0.04)⁴·3/128 = 5e-5 of its
    /// height.
    #[inline(always)]
    pub fn integrals(&self, shift: f32) -> Weights<C> {
        let x = (shift * (1.0 / SHIFT_STEP) as f32).min(180.0);
        let index = (x as i32 as usize).min(179);
        let t = x - index as f32;
        // Lagrange's polynomials on the nodes −1, 0, 1, 2.
        let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
        let weights = [-t * b * c / 6.0, a * b * c / 2.0, -a * t * c / 2.0, a * t * b / 6.0].map(f32x8::splat);
        let Some(rows) = self.integrals.0[index..].first_chunk::<4>() else {
            unreachable!("index leaves room for four nodes")
        };
        let mut out = [f32x8::ZERO; C];
        for k in 0..C {
            let low = weights[0].mul_add(rows[0][k], weights[1] * rows[1][k]);
            let high = weights[2].mul_add(rows[2][k], weights[3] * rows[3][k]);
            out[k] = (low + high).fast_max(f32x8::ZERO);
        }
        out
    }

    /// Σ_r w_r Z_r(s) by linear interpolation: exact to 0.03 % for the mixtures of C^M.
    #[inline(always)]
    pub fn total(&self, w: &Weights<C>, shift: f32) -> f32 {
        self.integrals.dot(w, Between::new(shift.mul_add((1.0 / SHIFT_STEP) as f32, 1.0), self.integrals.nodes()))
    }

    /// Σ_r w_r Z_r(0).
    #[inline(always)]
    pub fn total_at_0(&self, w: &Weights<C>) -> f32 {
        dot(w, self.integrals.row(1))
    }

    /// Z_r(s) directly: whole intervals from the moments, the two end intervals in closed form.
    fn integral(&self, r: usize, shift: f32) -> f32 {
        let nodes = self.values.nodes();
        let [low, high] = self.ends(shift);
        let value = |j: usize| self.value(r, j);
        let part = |end: End| end.inner * value(end.node) + end.outer * value(end.beyond);
        let [c, s] = self.columns.each_ref().map(|column| column[r * nodes + high.node] - column[r * nodes + low.node]);
        (shift.cos() * c + shift.sin() * s + part(low) + part(high)).max(0.0)
    }

    /// B_r at a node.
    pub fn value(&self, r: usize, j: usize) -> f32 {
        self.values.0[j][r / 8].to_array()[r % 8]
    }

    /// The ends of the half circle around `shift`.
    fn ends(&self, shift: f32) -> [End; 2] {
        use std::f32::consts::FRAC_PI_2;
        let last = self.values.nodes() - 1;
        let low = ((shift - FRAC_PI_2 - self.first) * self.inv_step).clamp(0.0, last as f32);
        let high = ((shift + FRAC_PI_2 - self.first) * self.inv_step).clamp(0.0, last as f32);
        let (from, to) = (low.ceil(), high.floor());
        let end = |node: usize, beyond: usize, width: f32| {
            // From the end, where the cosine is sin 0, to the node at distance d. With linear B, ∫₀ᵈ B sin t dt =
            // B_node d²/6·2 + B_end d²/6 to order d⁴. B_end lies at the fraction d/step of the way to the next node.
            let d = width * self.step;
            let at_end = d * d / 6.0;
            End { node, beyond, width, inner: 2.0 * at_end + at_end * (1.0 - width), outer: at_end * width }
        };
        let (from_node, to_node) = (from as usize, to as usize);
        [end(from_node, from_node.saturating_sub(1), from - low), end(to_node, (to_node + 1).min(last), high - to)]
    }

    /// Inverts the cumulative density of component `r` under the weight cos(δ − s): returns the δ with the fraction
    /// `u` of the density below it. Within an interval the weighted density is taken as linear; its second derivative
    /// bounds the error of the density by step²/8 = 1e-5.
    pub fn invert(&self, r: usize, u: f32, shift: f32) -> f32 {
        let (sin, cos) = shift.sin_cos();
        let nodes = self.values.nodes();
        let node = |j: usize| self.first + j as f32 * self.step;
        let [c, s] = self.columns.each_ref().map(|column| &column[r * nodes..(r + 1) * nodes]);
        let value = |j: usize| self.value(r, j);
        let [low, high] = if self.weighted {
            self.ends(shift)
        } else {
            let whole = |node: usize| End { node, beyond: node, width: 0.0, inner: 0.0, outer: 0.0 };
            [whole(0), whole(nodes - 1)]
        };
        let cumulative = |j: usize| {
            if self.weighted { cos * c[j] + sin * s[j] } else { c[j] }
        };
        let part = |end: End| end.inner * value(end.node) + end.outer * value(end.beyond);
        let (start, end) = (cumulative(low.node) - part(low), cumulative(high.node) + part(high));
        let density = |j: usize| {
            let weight = if self.weighted { (node(j) - shift).cos().max(0.0) } else { 1.0 };
            value(j) * weight
        };
        // The density is 0 at the ends, because the cosine is.
        let start = (node(low.node) - low.width * self.step, start, 0.0);
        let end = (node(high.node) + high.width * self.step, end, 0.0);
        invert([low.node, high.node], [start, end], u, |j| (node(j), cumulative(j), density(j)), cumulative)
    }

    /// The share of each component in the forward half, under [`forward_weight`].
    #[inline(always)]
    pub fn forward(&self) -> &Weights<C> {
        &self.forward
    }

    /// The share of each component in the backward half.
    pub fn backward(&self) -> Weights<C> {
        self.forward.map(|forward| f32x8::ONE - forward)
    }

    /// Inverts the cumulative density of component `r` under the weight of one half of the circle: [`forward_weight`],
    /// or the rest.
    pub fn invert_half(&self, r: usize, u: f32, forward: bool) -> f32 {
        let nodes = self.values.nodes();
        let [whole, ahead] = self.columns.each_ref().map(|column| &column[r * nodes..(r + 1) * nodes]);
        let part = |whole: f32, ahead: f32| if forward { ahead } else { whole - ahead };
        let cumulative = |j: usize| part(whole[j], ahead[j]);
        let at = |j: usize| {
            let delta = self.node(j);
            (delta, cumulative(j), self.value(r, j) * part(1.0, forward_weight(f64::from(delta)) as f32))
        };
        let last = nodes - 1;
        invert([0, last], [at(0), at(last)], u, at, cumulative)
    }
}

/// |φ|/π for an azimuth in [0, 2π] from straight back: the weight of the forward half of C^M. π is a node of C^N.
fn forward_weight(phi: f64) -> f64 {
    (1.0 - (phi / PI - 1.0).abs()).max(0.0)
}

/// A place on a cumulative integral: the position, the integral up to it, and the density.
type Place = (f32, f32, f32);

/// Inverts a cumulative integral: returns the position with the fraction `u` of the integral below it. `nodes` are the
/// first and the last node in the range, and `ends` the ends of the range, at these nodes or beyond them. Within an
/// interval the density is taken as linear.
#[inline(always)]
pub(crate) fn invert(
    [from, to]: [usize; 2],
    [start, stop]: [Place; 2],
    u: f32,
    at: impl Fn(usize) -> Place,
    cumulative: impl Fn(usize) -> f32,
) -> f32 {
    let target = start.1 + u * (stop.1 - start.1);
    // Finds the last node at or below the target by bisection. It has no branches, because the processor could not
    // predict them.
    let (mut a, mut size) = (from, to + 1 - from);
    while size > 1 {
        let half = size / 2;
        a = if cumulative(a + half) <= target { a + half } else { a };
        size -= half;
    }
    let ((x0, m0, f0), (x1, m1, f1)) = if target < cumulative(a) {
        (start, at(a))
    } else if a == to {
        (at(a), stop)
    } else {
        (at(a), at(a + 1))
    };
    let t = if m1 > m0 { ((target - m0) / (m1 - m0)).clamp(0.0, 1.0) } else { u };
    // Root of the quadratic cumulative, in the form without cancellation.
    let root = (f0 * f0 + t * (f1 * f1 - f0 * f0)).max(0.0).sqrt();
    let x = if f0 + root > 0.0 { t * (f0 + f1) / (f0 + root) } else { t };
    x0 + x.clamp(0.0, 1.0) * (x1 - x0)
}

/// One end of the half circle. `node` is the last node inside. The fields also hold the next node, the distance from
/// the last node to the end in steps, and the factors of both nodes' values in the integral up to the end.
#[derive(Clone, Copy)]
struct End {
    node: usize,
    beyond: usize,
    width: f32,
    inner: f32,
    outer: f32,
}

#[cfg(test)]
mod tests {
    use crate::medulla::tables::{FORWARD, Tables};

    /// Compares Z_r of the forward table with the midpoint rule, for every shift and component.
    #[test]
    fn integrals_match_quadrature() {
        let densities = &Tables::shipped().forward.densities;
        for degrees in [0.0f64, 0.3, 17.2, 60.0, 62.97, 84.9, 89.99] {
            let shift = degrees.to_radians();
            let fast = densities.integrals(shift as f32);
            for r in 0..8 * FORWARD {
                let mut unit = [wide::f32x8::ZERO; FORWARD];
                let mut lanes = [0.0; 8];
                lanes[r % 8] = 1.0;
                unit[r / 8] = wide::f32x8::new(lanes);
                let n = 20_000;
                let step = std::f64::consts::PI / f64::from(n);
                let exact: f64 = (0..n)
                    .map(|i| {
                        let t = (f64::from(i) + 0.5) * step - std::f64::consts::FRAC_PI_2;
                        f64::from(densities.eval(&unit, (t + shift) as f32)) * t.cos() * step
                    })
                    .sum();
                let ours = f64::from(fast[r / 8].to_array()[r % 8]);
                // The interpolation error, 5e-5 of the height, which is 1.
                assert!((ours - exact).abs() < 6e-5, "{degrees}° component {r}: {ours} {exact}");
            }
        }
    }

    /// dδ/du · B_r(δ) cos(δ − s)/Z_r(s) = 1 for every component with a weight, tested by finite differences.
    #[test]
    fn pdf_is_jacobian_of_sample() {
        let densities = &Tables::shipped().forward.densities;
        for degrees in [0.0f32, 31.3, 77.7] {
            let shift = degrees.to_radians();
            for r in 0..8 * FORWARD {
                let total = densities.integral(r, shift);
                if total < 1e-3 {
                    continue;
                }
                let (mut worst, mut count) = (0.0f32, 0);
                for k in 1..40 {
                    let u = k as f32 / 40.0;
                    // Wide enough for single precision, and narrow enough to resolve the density.
                    let step = 2e-3;
                    let (a, b) = (densities.invert(r, u - step, shift), densities.invert(r, u + step, shift));
                    // The difference measures the mean of the density over [a, b].
                    let n = ((b - a) / 5e-4).ceil().max(16.0) as usize;
                    let mut unit = [wide::f32x8::ZERO; FORWARD];
                    let mut lanes = [0.0; 8];
                    lanes[r % 8] = 1.0;
                    unit[r / 8] = wide::f32x8::new(lanes);
                    let mean: f32 = (0..n)
                        .map(|i| a + (b - a) * (i as f32 + 0.5) / n as f32)
                        .map(|x| densities.eval(&unit, x) * (x - shift).cos() / n as f32)
                        .sum();
                    worst = worst.max((mean * (b - a) / (2.0 * step * total) - 1.0).abs());
                    count += 1;
                }
                // Angles near π have a resolution of 2.4e-7. Their difference is at least 2·step·Z, because densities
                // are at most 1. This is an error of 2.4e-7/(4e-3·1e-3) for the smallest Z of the test. 0.5 % is for
                // all other errors.
                let tolerance = 5e-3 + 2.5e-7 / (2.0 * 2e-3 * total);
                assert!(worst < tolerance, "{degrees}° component {r}, Z {total}: {worst} of {count}");
            }
        }
    }
}
