//! Transforms (IXform).

use crate::archive::{Archive, Object};
use crate::attribute::floor;
use crate::error::{Error, wrong};
use crate::geometry::Geometry;

/// What an operation of a transform does, with its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Op {
    /// Scales each axis.
    Scale([f64; 3]),
    /// Moves.
    Translate([f64; 3]),
    /// Rotates about an axis, by degrees.
    Rotate([f64; 3], f64),
    /// Any matrix: rows, whose last one is the translation.
    Matrix([[f64; 4]; 4]),
}

/// A transform at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Xform {
    /// Whether the transforms of the parents apply too.
    pub inherits: bool,
    /// The operations. The last one applies first to a point.
    pub ops: Vec<Op>,
}

/// The numbers of values of the operations, by the number in the file: scale, translate, rotate about an axis, matrix,
/// rotate about x, y and z.
const VALUES: [usize; 7] = [3, 3, 4, 16, 1, 1, 1];

impl Xform {
    /// The beginning of the names of this schema.
    pub const SCHEMA: &'static str = "AbcGeom_Xform_v";

    /// Reads a transform at a time in seconds. The values of the operations are interpolated between samples.
    ///
    /// # Errors
    /// [`Error::Damaged`], or [`Error::Property`] if the operations are unknown.
    pub fn read(archive: &Archive, object: &Object, time: f64) -> Result<Self, Error> {
        let geometry = Geometry::new(archive, object, ".xform", time)?;
        let inherits = geometry.integers(".inherits")?.and_then(|all| all.first().copied()) != Some(0);
        let kinds = match geometry.series(".ops") {
            Some(series) => floor(archive, series, f64::NEG_INFINITY)?.to_i64(),
            None => Vec::new(),
        };
        let values = match geometry.series(".vals") {
            Some(series) => {
                let between = archive.times(series).between(time, series.samples);
                let mut values = archive.sample(series, between.floor)?.to_f64();
                let next = archive.sample(series, between.ceil)?.to_f64();
                values.iter_mut().zip(next).for_each(|(value, next)| *value += between.share * (next - *value));
                values
            }
            None => Vec::new(),
        };
        let mut rest = &values[..];
        let mut ops = Vec::with_capacity(kinds.len());
        for kind in kinds {
            // The lower bits say what other programs call the operation.
            let kind = (kind as u8 >> 4) as usize;
            let count = *VALUES.get(kind).ok_or_else(|| wrong(".ops", format!("has the unknown operation {kind}")))?;
            // A transform without values is the identity.
            let Some((own, after)) = rest.split_at_checked(count) else {
                if values.is_empty() {
                    break;
                }
                return Err(wrong(".vals", format!("has {} numbers, which are too few", values.len())));
            };
            rest = after;
            let three = || std::array::from_fn(|i| own[i]);
            ops.push(match kind {
                0 => Op::Scale(three()),
                1 => Op::Translate(three()),
                2 => Op::Rotate(three(), own[3]),
                3 => Op::Matrix(std::array::from_fn(|row| std::array::from_fn(|column| own[4 * row + column]))),
                _ => Op::Rotate(std::array::from_fn(|axis| f64::from(u8::from(axis == kind - 4))), own[0]),
            });
        }
        Ok(Xform { inherits, ops })
    }

    /// The matrix of all operations: rows, whose last one is the translation. A point is a row on its left.
    pub fn matrix(&self) -> [[f64; 4]; 4] {
        self.ops.iter().fold(IDENTITY, |matrix, op| product(&op.matrix(), &matrix))
    }
}

const IDENTITY: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

fn product(a: &[[f64; 4]; 4], b: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

impl Op {
    /// The matrix of the operation: rows, whose last one is the translation.
    pub fn matrix(&self) -> [[f64; 4]; 4] {
        let mut matrix = IDENTITY;
        match *self {
            Op::Scale(factors) => (0..3).for_each(|i| matrix[i][i] = factors[i]),
            Op::Translate(by) => matrix[3][..3].copy_from_slice(&by),
            Op::Matrix(all) => matrix = all,
            Op::Rotate(axis, degrees) => {
                let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
                if length > 0.0 {
                    let [x, y, z] = axis.map(|x| x / length);
                    let (sin, cos) = degrees.to_radians().sin_cos();
                    // Rodrigues' formula: cos · 1 + (1 − cos) · axis axisᵀ + sin · [axis]×, transposed for rows.
                    let cross = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]];
                    let axis = [x, y, z];
                    for i in 0..3 {
                        for j in 0..3 {
                            let one = if i == j { cos } else { 0.0 };
                            matrix[i][j] = one + (1.0 - cos) * axis[i] * axis[j] + sin * cross[i][j];
                        }
                    }
                }
            }
        }
        matrix
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apply(xform: &Xform, point: [f64; 3]) -> [f64; 3] {
        let matrix = xform.matrix();
        std::array::from_fn(|j| (0..3).map(|i| point[i] * matrix[i][j]).sum::<f64>() + matrix[3][j])
    }

    /// Translate, rotate, scale: a point is scaled, then turned, then moved.
    #[test]
    fn the_last_operation_applies_first() {
        let rotate = Op::Rotate([0.0, 0.0, 2.0], 90.0);
        let all =
            Xform { inherits: true, ops: vec![Op::Translate([10.0, 0.0, 0.0]), rotate, Op::Scale([2.0, 3.0, 4.0])] };
        let moved = apply(&all, [1.0, 0.0, 1.0]);
        let error = moved.iter().zip([10.0, 2.0, 4.0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-12, "{moved:?}");
        let matrix = Xform { inherits: true, ops: vec![Op::Matrix(all.matrix())] };
        assert_eq!(matrix.matrix(), all.matrix());
    }
}
