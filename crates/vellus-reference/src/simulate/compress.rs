//! Compresses profiles into sums of rank-one terms by weighted hierarchical alternating least squares.
//!
//! D13: factors are non-negative, where Yan17 Sec. 4.3 uses unconstrained CP-ALS. This needs a higher rank (40 instead
//! of 16 for C^N), but no profile is negative, normalisation is one sum, and sampling is exact. All tables fit into 119
//! KB.
//!
//! Each profile is first scaled by the inverse square root of its norm. The normalisation at the query undoes it.
//! Without the scale, the sharp forward peaks of g → 0.95 would use up all components.

use crate::simulate::medulla::stream;
use ndarray::{Array2, ArrayView2, Axis, s};
use rand::Rng;
use vellus::FactorTable;
use vellus_io::Steps;

/// A table to compress: profiles over three parameters. Each row of `values` is a profile, and the third parameter
/// varies fastest.
pub struct Problem {
    /// Number of nodes of the three parameters.
    pub nodes: [usize; 3],
    /// `nodes[0]·nodes[1]·nodes[2]` profiles × outgoing angles.
    pub values: Array2<f32>,
    /// Weight of each outgoing angle, by the third parameter (`nodes[2]` × outgoing angles): the measure cos θᵢ dθᵢ,
    /// and 0 where a shifted profile has no value.
    pub weights: Array2<f32>,
}

/// The row-wise Khatri–Rao product: row (i, j) is the elementwise product of rows i and j.
fn khatri_rao(a: &Array2<f32>, b: &Array2<f32>) -> Array2<f32> {
    let (n, m, rank) = (a.nrows(), b.nrows(), a.ncols());
    Array2::from_shape_fn((n * m, rank), |(ij, r)| a[[ij / m, r]] * b[[ij % m, r]])
}

/// One pass of projected coordinate descent for min ½ fᵀG f + ½ ridge |f|² − m·f, f ≥ 0.
///
/// The ridge is 1e-9 of the largest diagonal element. It pulls unconstrained values to zero: weights of components that
/// are completely outside the angles of a profile.
fn descend(f: &mut [f32], m: &[f32], g: ArrayView2<'_, f32>) {
    let ridge = 1e-9 * g.diag().iter().fold(1e-6f32, |a, &x| a.max(x));
    for r in 0..f.len() {
        let gradient = g.row(r).iter().zip(f.iter()).map(|(g, f)| g * f).sum::<f32>() + ridge * f[r] - m[r];
        f[r] = (f[r] - gradient / (g[[r, r]] + ridge)).max(1e-9);
    }
}

fn descend_rows(f: &mut Array2<f32>, m: &Array2<f32>, gram: impl Fn(usize) -> Array2<f32>) {
    for (j, mut row) in f.axis_iter_mut(Axis(0)).enumerate() {
        let g = gram(j);
        let mut values = row.to_vec();
        for _ in 0..2 {
            descend(&mut values, &m.row(j).to_vec(), g.view());
        }
        row.iter_mut().zip(values).for_each(|(x, v)| *x = v);
    }
}

/// Compresses a table to `rank` components in `sweeps` sweeps. It advances `steps` after each sweep. The result depends
/// on `seed` only.
pub fn compress(problem: &Problem, rank: usize, sweeps: usize, seed: u64, steps: &Steps) -> FactorTable {
    let [n0, n1, n2] = problem.nodes;
    let outgoing = problem.values.ncols();
    let third = |row: usize| problem.weights.row(row % n2);

    // The weighted and scaled data W∘X. X itself is not needed.
    let mut data = problem.values.clone();
    for (i, mut row) in data.axis_iter_mut(Axis(0)).enumerate() {
        let norm: f32 = row.iter().zip(third(i)).map(|(x, w)| w * x * x).sum();
        let scale = norm.max(1e-20).powf(-0.25);
        row.iter_mut().zip(third(i)).for_each(|(x, w)| *x *= scale * w);
    }

    // Initial values: random weights, and smoothed random profiles of the table as components.
    let mut rng = stream(seed, 0);
    let mut uniform = || (rng.next_u64() >> 40) as f32 / (1u64 << 24) as f32;
    let mut factors = [n0, n1, n2].map(|n| Array2::from_shape_simple_fn((n, rank), || 0.3 + uniform()));
    let mut b = Array2::<f32>::zeros((outgoing, rank));
    for r in 0..rank {
        let i = ((uniform() * data.nrows() as f32) as usize).min(data.nrows() - 1);
        let (profile, weight) = (data.row(i), third(i));
        for j in 0..outgoing {
            let around = j.saturating_sub(4)..(j + 5).min(outgoing);
            let (sum, total) = around.fold((0.0, 0.0), |(x, w), k| (x + profile[k], w + weight[k]));
            b[[j, r]] = if total > 0.0 { sum / total + 1e-3 } else { 0.3 };
        }
    }

    for _ in 0..sweeps {
        let gram = |f: &Array2<f32>| f.t().dot(f);
        // Outgoing angles: the Gram matrix of angle j is Σ_h W_hj G_h.
        let weights = khatri_rao(&khatri_rao(&factors[0], &factors[1]), &factors[2]);
        let m = data.t().dot(&weights);
        let g01 = gram(&factors[0]) * gram(&factors[1]);
        let outer = khatri_rao_self(&factors[2]);
        let per_angle = problem.weights.t().dot(&outer);
        descend_rows(&mut b, &m, |j| square(per_angle.row(j).to_vec(), rank) * &g01);

        // The three parameters share data·B and the weighted Gram matrices of B.
        let y = data.dot(&b);
        let per_third = problem.weights.dot(&khatri_rao_self(&b));
        let b_gram = |h: usize| square(per_third.row(h).to_vec(), rank);
        for mode in 0..3 {
            let [f0, f1, f2] = &factors;
            let mut m = Array2::<f32>::zeros((factors[mode].nrows(), rank));
            for (i, row) in y.axis_iter(Axis(0)).enumerate() {
                let at = [i / (n1 * n2), i / n2 % n1, i % n2];
                let (p, q) = match mode {
                    0 => (f1.row(at[1]), f2.row(at[2])),
                    1 => (f0.row(at[0]), f2.row(at[2])),
                    _ => (f0.row(at[0]), f1.row(at[1])),
                };
                let mut target = m.row_mut(at[mode]);
                for r in 0..rank {
                    target[r] += row[r] * p[r] * q[r];
                }
            }
            let f2_outer = khatri_rao_self(f2);
            let summed = square((&f2_outer * &per_third).sum_axis(Axis(0)).to_vec(), rank);
            let (g0, g1) = (gram(f0), gram(f1));
            match mode {
                0 => descend_rows(&mut factors[0], &m, |_| &g1 * &summed),
                1 => descend_rows(&mut factors[1], &m, |_| &g0 * &summed),
                _ => {
                    let g01 = g0 * g1;
                    descend_rows(&mut factors[2], &m, |h| b_gram(h) * &g01);
                }
            }
            for r in 0..rank {
                let norm = factors[mode].column(r).iter().map(|x| x * x).sum::<f32>().sqrt();
                factors[mode].column_mut(r).map_inplace(|x| *x /= norm);
                factors[0].column_mut(r).map_inplace(|x| *x *= norm);
            }
        }
        steps.advance(1);
    }
    // Angles without values get those of their neighbours, because interpolation may use them.
    let seen: Vec<bool> = problem.weights.axis_iter(Axis(1)).map(|w| w.iter().any(|&w| w > 0.0)).collect();
    for j in 1..outgoing {
        if !seen[j] {
            let previous = b.row(j - 1).to_owned();
            b.row_mut(j).assign(&previous);
        }
    }
    rescale(factors, b)
}

/// The outer product of each row with itself, flattened: n × rank².
fn khatri_rao_self(f: &Array2<f32>) -> Array2<f32> {
    let (n, rank) = f.dim();
    Array2::from_shape_fn((n, rank * rank), |(i, rs)| f[[i, rs / rank]] * f[[i, rs % rank]])
}

fn square(values: Vec<f32>, rank: usize) -> Array2<f32> {
    Array2::from_shape_vec((rank, rank), values).expect("rank² values")
}

/// Scales all factors to a range in which half floats are precise.
///
/// The factors over g, over h or θ, and over the outgoing angle get the maximum 1. The first factor gets the common
/// scale, and its maximum becomes 1000. Queries normalise a table, so only ratios matter.
fn rescale(mut factors: [Array2<f32>; 3], mut b: Array2<f32>) -> FactorTable {
    let rank = b.ncols();
    for r in 0..rank {
        let [f0, f1, f2] = &mut factors;
        for column in [f1.column_mut(r), f2.column_mut(r), b.slice_mut(s![.., r])] {
            let mut column = column;
            let max = column.iter().fold(1e-30f32, |a, &x| a.max(x));
            column.map_inplace(|x| *x /= max);
            f0.column_mut(r).map_inplace(|x| *x *= max);
        }
    }
    let max = factors[0].iter().fold(1e-30f32, |a, &x| a.max(x));
    factors[0].map_inplace(|x| *x *= 1000.0 / max);
    let flat = |a: Array2<f32>| a.iter().copied().collect::<Vec<f32>>();
    let [f0, f1, f2] = factors.map(flat);
    FactorTable { rank, factors: [f0, f1, f2, flat(b)] }
}
