//! Matrices of low rank, stored as the product of two thin ones.

/// Rows of `columns` numbers from their coordinates, `rank` for each row, in a basis of `rank` rows.
pub(crate) fn expand(coordinates: &[f32], basis: &[f32], columns: usize) -> Vec<f32> {
    let rank = basis.len() / columns;
    let mut values = vec![0.0; coordinates.len() / rank * columns];
    for (row, of_row) in values.chunks_exact_mut(columns).zip(coordinates.chunks_exact(rank)) {
        for (b, c) in basis.chunks_exact(columns).zip(of_row) {
            row.iter_mut().zip(b).for_each(|(x, b)| *x += c * b);
        }
    }
    values
}

/// Coordinates and orthonormal basis of the closest matrix of this rank in the least-squares sense, by subspace
/// iteration.
#[cfg(any(test, feature = "unstable"))]
pub(crate) fn compress(values: &[f32], rank: usize, columns: usize) -> [Vec<f32>; 2] {
    let rows: Vec<Vec<f64>> =
        values.chunks_exact(columns).map(|row| row.iter().map(|x| f64::from(*x)).collect()).collect();
    // Rows that are spread over the matrix are the start.
    let mut basis: Vec<Vec<f64>> = (0..rank).map(|k| rows[k * rows.len() / rank].clone()).collect();
    orthonormalise(&mut basis);
    // Singular values fall by a third or more over the last ten, so what is beyond the rank leaves the basis.
    for _ in 0..200 {
        for b in &mut basis {
            let mut sum = vec![0.0; columns];
            for row in &rows {
                let along = dot(row, b);
                sum.iter_mut().zip(row).for_each(|(s, x)| *s += along * x);
            }
            *b = sum;
        }
        orthonormalise(&mut basis);
    }
    let coordinates = rows.iter().flat_map(|row| basis.iter().map(|b| dot(row, b) as f32)).collect();
    [coordinates, basis.iter().flatten().map(|x| *x as f32).collect()]
}

#[cfg(any(test, feature = "unstable"))]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Gram and Schmidt's method, twice, because the first pass loses digits where rows are close to each other.
#[cfg(any(test, feature = "unstable"))]
fn orthonormalise(basis: &mut [Vec<f64>]) {
    for k in 0..basis.len() {
        let (before, rest) = basis.split_at_mut(k);
        let b = &mut rest[0];
        for _ in 0..2 {
            for other in &*before {
                let along = dot(b, other);
                b.iter_mut().zip(other).for_each(|(x, y)| *x -= along * y);
            }
            let length = dot(b, b).sqrt().max(f64::MIN_POSITIVE);
            b.iter_mut().for_each(|x| *x /= length);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix of rank 3 comes back, and a further singular value is the error of rank 2.
    #[test]
    fn the_closest_matrix_is_found() {
        let column = |k: usize, i: usize| ((k + 1) as f64 * (i as f64 + 0.5) * std::f64::consts::PI / 12.0).cos();
        let sizes = [4.0, 2.0, 0.5];
        let at = |i: usize, j: usize| (0..3).map(|k| sizes[k] * column(k, i) * column(k, j)).sum::<f64>() as f32;
        let values: Vec<f32> = (0..12 * 12).map(|n| at(n / 12, n % 12)).collect();
        let error = |rank: usize| {
            let [coordinates, basis] = compress(&values, rank, 12);
            let differences = expand(&coordinates, &basis, 12).into_iter().zip(&values);
            differences.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
        };
        assert!(error(3) < 1e-5);
        // The cosines have the squared length 6.
        assert!((error(2) - 6.0 * 0.5).abs() < 1e-4, "{}", error(2));
    }
}
