//! A compressed table: every profile is a mixture of the same few densities over the outgoing
//! angle, its weights a product of one factor a parameter (Yan17 Eq. 17–18, with non-negative factors).
//!
//! Non-negativity is what makes the tables practical: a profile is never negative, it is normalised by
//! one sum over the weights, and it is sampled exactly by choosing a component and inverting that.
//!
//! A component B_r is piecewise linear in the angle δ. It is measured with weight cos(δ − s), for
//! a shift s chosen at the query: the azimuthal table uses no weight, the longitudinal ones cos θᵢ.

use wide::f32x8;

/// Linear interpolation between nodes `index` and `index + 1`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Between {
    pub index: usize,
    pub t: f32,
}

impl Between {
    /// Position `x` on nodes 0 … `nodes − 1`, held to that range. NaN is held to 0.
    #[inline(always)]
    pub fn new(x: f32, nodes: usize) -> Self {
        let x = if x > 0.0 { x.min((nodes - 1) as f32) } else { 0.0 };
        // Below 2³¹ by the line above; the cast through i32 is one instruction.
        let index = (x as i32 as usize).min(nodes - 2);
        Between { index, t: x - index as f32 }
    }
}

/// `C` registers of eight components.
pub(crate) type Weights<const C: usize> = [f32x8; C];

/// One value a node and component, node by node.
#[derive(Clone, Debug)]
pub(crate) struct Rows<const C: usize>(Vec<[f32x8; C]>);

impl<const C: usize> Rows<C> {
    /// From `rank` ≤ 8·C values a node; the missing components are 0.
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

    pub fn nodes(&self) -> usize {
        self.0.len()
    }

    /// The factors between two nodes.
    #[inline(always)]
    pub fn at(&self, x: Between) -> Weights<C> {
        let (a, b) = (&self.0[x.index], &self.0[x.index + 1]);
        let t = f32x8::splat(x.t);
        std::array::from_fn(|c| (b[c] - a[c]).mul_add(t, a[c]))
    }

    /// Σ_r w_r v_r between two nodes.
    #[inline(always)]
    pub fn dot(&self, w: &Weights<C>, x: Between) -> f32 {
        let (a, b) = (&self.0[x.index], &self.0[x.index + 1]);
        let (mut low, mut high) = (f32x8::ZERO, f32x8::ZERO);
        for c in 0..C {
            low = w[c].mul_add(a[c], low);
            high = w[c].mul_add(b[c], high);
        }
        (high - low).mul_add(f32x8::splat(x.t), low).reduce_add()
    }
}

pub(crate) fn product<const C: usize>(a: &Weights<C>, b: &Weights<C>) -> Weights<C> {
    std::array::from_fn(|c| a[c] * b[c])
}

/// The factor that makes Σ w_r z_r = 1; 0 where that sum is.
pub(crate) fn normaliser<const C: usize>(w: &Weights<C>, z: &Weights<C>) -> f32 {
    let mut sum = f32x8::ZERO;
    for c in 0..C {
        sum = w[c].mul_add(z[c], sum);
    }
    let sum = sum.reduce_add();
    if sum > 0.0 { 1.0 / sum } else { 0.0 }
}

/// Draws a component with probability w_r z_r / Σ, and what is left of `u` as a new uniform number.
pub(crate) fn choose<const C: usize>(w: &Weights<C>, z: &Weights<C>, u: f32) -> (usize, f32) {
    let products = product(w, z);
    let total: f32 = products.iter().map(|p| p.reduce_add()).sum();
    let mut rest = u * total;
    let mut last = (0, 0.5);
    for (c, p) in products.iter().enumerate() {
        let block = p.reduce_add();
        // The last block with any weight takes what rounding left over.
        if rest >= block && products[c + 1..].iter().any(|p| p.reduce_add() > 0.0) {
            rest -= block;
            continue;
        }
        for (i, &x) in p.to_array().iter().enumerate() {
            if x > 0.0 {
                last = (8 * c + i, (rest / x).clamp(0.0, 1.0));
                if rest < x {
                    break;
                }
            }
            rest -= x;
        }
        break;
    }
    last
}

/// Piecewise-linear densities B_r(δ) on equidistant nodes, with their cumulative moments.
#[derive(Clone, Debug)]
pub(crate) struct Densities<const C: usize> {
    first: f32,
    inv_step: f32,
    step: f32,
    values: Rows<C>,
    /// ∫ B_r cos δ dδ and ∫ B_r sin δ dδ from the first node: node by node for normalising …
    moments: [Rows<C>; 2],
    /// … and component by component for sampling.
    columns: [Vec<f32>; 2],
    /// Without cos weight: plain densities, `columns[0]` their cumulative integrals.
    weighted: bool,
}

impl<const C: usize> Densities<C> {
    /// From `rank` values a node at δ = `first` + j·`step`; components are scaled to integral 1
    /// where `weighted` is false.
    pub fn new(values: &[f32], rank: usize, first: f64, step: f64, weighted: bool) -> Self {
        let nodes = values.len() / rank;
        let mut scaled = vec![0.0f32; values.len()];
        let mut columns = [vec![0.0f32; values.len()], vec![0.0f32; values.len()]];
        let mut rows = columns.clone();
        for r in 0..rank {
            let b = |j: usize| f64::from(values[j * rank + r]);
            let mut sums = [0.0f64; 2];
            let mut cumulative = vec![[0.0f64; 2]];
            for j in 0..nodes - 1 {
                let x = first + j as f64 * step;
                let (f0, slope) = (b(j), (b(j + 1) - b(j)) / step);
                if weighted {
                    // ∫ (f0 + slope (δ − x)) cos δ dδ, and with sin, over one interval.
                    let (s0, c0) = x.sin_cos();
                    let (s1, c1) = (x + step).sin_cos();
                    sums[0] += f0 * (s1 - s0) + slope * (step * s1 + c1 - c0);
                    sums[1] += f0 * (c0 - c1) + slope * (s1 - s0 - step * c1);
                } else {
                    sums[0] += 0.5 * (b(j) + b(j + 1)) * step;
                }
                cumulative.push(sums);
            }
            let scale = if weighted || sums[0] <= 0.0 { 1.0 } else { 1.0 / sums[0] };
            for j in 0..nodes {
                scaled[j * rank + r] = (b(j) * scale) as f32;
                for k in 0..2 {
                    let m = (cumulative[j][k] * scale) as f32;
                    columns[k][r * nodes + j] = m;
                    rows[k][j * rank + r] = m;
                }
            }
        }
        Densities {
            first: first as f32,
            inv_step: (1.0 / step) as f32,
            step: step as f32,
            values: Rows::new(&scaled, rank),
            moments: rows.map(|rows| Rows::new(&rows, rank)),
            columns,
            weighted,
        }
    }

    #[inline(always)]
    fn between(&self, delta: f32) -> Between {
        Between::new((delta - self.first) * self.inv_step, self.values.nodes())
    }

    /// Σ_r w_r B_r(δ).
    #[inline(always)]
    pub fn eval(&self, w: &Weights<C>, delta: f32) -> f32 {
        self.values.dot(w, self.between(delta))
    }

    /// Z_r = ∫ B_r(δ) cos(δ − s) dδ over the half circle where the cosine is positive; (sin, cos) of
    /// s. Between nodes the moments are interpolated linearly: at both ends the cosine vanishes, so
    /// what that misses is of order step² B_r/8, 1e-5 of B_r for half a degree.
    #[inline(always)]
    pub fn integrals(&self, shift: f32, (sin, cos): (f32, f32)) -> Weights<C> {
        use std::f32::consts::FRAC_PI_2;
        let (a, b) = (self.between(shift - FRAC_PI_2), self.between(shift + FRAC_PI_2));
        let (sin, cos) = (f32x8::splat(sin), f32x8::splat(cos));
        let [c, s] = &self.moments;
        let (ca, cb, sa, sb) = (c.at(a), c.at(b), s.at(a), s.at(b));
        std::array::from_fn(|k| (cos * (cb[k] - ca[k]) + sin * (sb[k] - sa[k])).fast_max(f32x8::ZERO))
    }

    /// Inverts the cumulative density of component `r` under the weight cos(δ − s): the δ below
    /// which the fraction `u` of it lies. Inside an interval the weighted density is taken as
    /// linear; its second derivative bounds the error of the density by step²/8 = 1e-5.
    pub fn invert(&self, r: usize, u: f32, shift: f32, (sin, cos): (f32, f32)) -> f32 {
        use std::f32::consts::FRAC_PI_2;
        let nodes = self.values.nodes();
        let node = |j: usize| self.first + j as f32 * self.step;
        let [c, s] = self.columns.each_ref().map(|column| &column[r * nodes..(r + 1) * nodes]);
        let last = node(nodes - 1);
        let (low, high) = if self.weighted {
            ((shift - FRAC_PI_2).max(self.first), (shift + FRAC_PI_2).min(last))
        } else {
            (self.first, last)
        };
        let cumulative_node = |j: usize| if self.weighted { cos * c[j] + sin * s[j] } else { c[j] };
        let cumulative = |x: f32| {
            let x = self.between(x);
            let (a, b) = (cumulative_node(x.index), cumulative_node(x.index + 1));
            a + x.t * (b - a)
        };
        let (start, end) = (cumulative(low), cumulative(high));
        let target = start + u * (end - start);
        // The first whole node at or beyond `low`, and the last one at or before `high`.
        let from = ((low - self.first) * self.inv_step).ceil() as usize;
        let to = (((high - self.first) * self.inv_step).floor() as usize).min(nodes - 1);
        let (mut a, mut b) = (from, to + 1);
        while a < b {
            let middle = (a + b) / 2;
            if cumulative_node(middle) <= target { a = middle + 1 } else { b = middle }
        }
        // Nodes from … a−1 lie at or below the target.
        let (x0, m0) = if a == from { (low, start) } else { (node(a - 1), cumulative_node(a - 1)) };
        let (x1, m1) = if a > to { (high, end) } else { (node(a), cumulative_node(a)) };
        let t = if m1 > m0 { ((target - m0) / (m1 - m0)).clamp(0.0, 1.0) } else { u };
        let density = |x: f32| {
            let at = self.between(x);
            let value = |j: usize| self.values.0[j][r / 8].to_array()[r % 8];
            let b = value(at.index) + at.t * (value(at.index + 1) - value(at.index));
            if self.weighted { b * (x - shift).cos().max(0.0) } else { b }
        };
        let (f0, f1) = (density(x0), density(x1));
        // Root of the quadratic cumulative, in the form that never cancels.
        let root = (f0 * f0 + t * (f1 * f1 - f0 * f0)).max(0.0).sqrt();
        let x = if f0 + root > 0.0 { t * (f0 + f1) / (f0 + root) } else { t };
        x0 + x.clamp(0.0, 1.0) * (x1 - x0)
    }
}
