//! Small symmetric matrices, of about a dozen rows.

use std::ops::{Index, IndexMut};

/// A square matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    rows: usize,
    values: Vec<f64>,
}

impl Matrix {
    /// A matrix of zeros.
    pub fn zero(rows: usize) -> Self {
        Matrix { rows, values: vec![0.0; rows * rows] }
    }

    /// The number of rows, which is the number of columns.
    pub fn rows(&self) -> usize {
        self.rows
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;
    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.values[i * self.rows + j]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.values[i * self.rows + j]
    }
}

/// Solves A x = b by Cholesky's decomposition; `None` if A is not positive definite.
pub fn solve(a: &Matrix, b: &[f64]) -> Option<Vec<f64>> {
    let n = a.rows;
    let mut l = Matrix::zero(n);
    for i in 0..n {
        for j in 0..=i {
            let sum = a[(i, j)] - (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum::<f64>();
            if i == j {
                // In a singular matrix only rounding error remains here: it is not a pivot.
                if sum.is_nan() || sum <= 1e-14 * a[(i, i)] {
                    return None;
                }
                l[(i, i)] = sum.sqrt();
            } else {
                l[(i, j)] = sum / l[(j, j)];
            }
        }
    }
    let mut x = b.to_vec();
    for i in 0..n {
        x[i] = (x[i] - (0..i).map(|k| l[(i, k)] * x[k]).sum::<f64>()) / l[(i, i)];
    }
    for i in (0..n).rev() {
        x[i] = (x[i] - (i + 1..n).map(|k| l[(k, i)] * x[k]).sum::<f64>()) / l[(i, i)];
    }
    Some(x)
}

/// Eigenvalues of a symmetric matrix in descending order, and their unit eigenvectors as rows, by Jacobi's rotations
/// (Golub and Van Loan 2013, Sec. 8.5). The method is accurate to the last digits and fast at this size.
pub fn eigen(matrix: &Matrix) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = matrix.rows;
    let mut a = matrix.clone();
    let mut v = Matrix::zero(n);
    (0..n).for_each(|i| v[(i, i)] = 1.0);
    // Convergence is quadratic: ten sweeps are more than such a matrix needs.
    for _ in 0..30 {
        let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|ij| a[ij] * a[ij]).sum();
        let whole: f64 = (0..n).map(|i| a[(i, i)] * a[(i, i)]).sum();
        if off <= 1e-30 * whole {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                if a[(p, q)] == 0.0 {
                    continue;
                }
                let tau = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
                let t = tau.signum() / (tau.abs() + tau.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                let s = t * c;
                for k in 0..n {
                    let (x, y) = (a[(k, p)], a[(k, q)]);
                    (a[(k, p)], a[(k, q)]) = (c * x - s * y, s * x + c * y);
                }
                for k in 0..n {
                    let (x, y) = (a[(p, k)], a[(q, k)]);
                    (a[(p, k)], a[(q, k)]) = (c * x - s * y, s * x + c * y);
                    let (x, y) = (v[(p, k)], v[(q, k)]);
                    (v[(p, k)], v[(q, k)]) = (c * x - s * y, s * x + c * y);
                }
            }
        }
    }
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| a[(j, j)].total_cmp(&a[(i, i)]));
    let vectors = order.iter().map(|&i| (0..n).map(|k| v[(i, k)]).collect()).collect();
    (order.iter().map(|&i| a[(i, i)]).collect(), vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hilbert's matrix of 6 rows (condition 1.5e7) with a small diagonal added: symmetric, positive definite.
    fn matrix() -> Matrix {
        let mut a = Matrix::zero(6);
        for i in 0..6 {
            for j in 0..6 {
                a[(i, j)] = 1.0 / (i + j + 1) as f64 + if i == j { 1e-3 } else { 0.0 };
            }
        }
        a
    }

    #[test]
    fn solutions_solve() {
        let (a, b) = (matrix(), [1.0, -2.0, 3.0, 0.5, 0.0, 7.0]);
        let x = solve(&a, &b).unwrap();
        for i in 0..6 {
            let sum: f64 = (0..6).map(|j| a[(i, j)] * x[j]).sum();
            // The condition is 1.6e3; |x| is about 1e3.
            assert!((sum - b[i]).abs() < 1e-9, "{sum} {}", b[i]);
        }
        let mut singular = Matrix::zero(2);
        (0..4).for_each(|k| singular[(k / 2, k % 2)] = 1.0);
        assert_eq!(solve(&singular, &[1.0, 1.0]), None);
    }

    #[test]
    fn eigenvectors_rebuild_the_matrix() {
        let a = matrix();
        let (values, vectors) = eigen(&a);
        assert!(values.windows(2).all(|w| w[0] >= w[1]) && values[5] > 0.0);
        for i in 0..6 {
            for j in 0..6 {
                let sum: f64 = (0..6).map(|k| values[k] * vectors[k][i] * vectors[k][j]).sum();
                let dot: f64 = (0..6).map(|k| vectors[i][k] * vectors[j][k]).sum();
                assert!((sum - a[(i, j)]).abs() < 1e-14 && (dot - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }
}
