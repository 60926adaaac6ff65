//! NURBS curves (UsdGeomNurbsCurves) as Bézier curves.

use crate::error::Error;
use crate::stage::{Stage, When};

/// The largest order of a curve: its degree is one less.
const MOST_ORDER: i64 = 16;

/// How many cubic pieces a piece becomes that is rational or of a higher degree.
const PARTS: usize = 8;

/// The value of a curve at a place is the sum of control points from `first` on with these weights.
#[derive(Clone, Debug)]
struct Place {
    first: usize,
    weights: Vec<f64>,
}

/// A cubic piece: its start, its end, and a third of the way along the tangents at both.
#[derive(Clone, Debug)]
struct Piece {
    ends: [Place; 2],
    handles: [Place; 2],
}

/// The curves of a prim.
#[derive(Clone, Debug)]
pub(crate) struct Nurbs {
    /// The pieces of each curve, one behind another.
    curves: Vec<Vec<Piece>>,
    /// The number of control points of all curves.
    pub total: usize,
}

impl Nurbs {
    /// Reads the curves of a prim with these numbers of control points.
    pub fn read(stage: &Stage, prim: &str, counts: &[i64], points: usize, base: When) -> Result<Self, Error> {
        let fail = |what: String| Err(Error::prim(prim, what));
        let numbers = |name: &str| Ok::<_, Error>(stage.numbers(prim, name, base)?.map_or(Vec::new(), |n| n.values));
        let orders = stage.integers(prim, "order", base)?.unwrap_or_default();
        let (knots, ranges, weights) = (numbers("knots")?, numbers("ranges")?, numbers("pointWeights")?);
        if counts.iter().any(|count| *count < 0) || counts.iter().sum::<i64>() as usize != points {
            return fail(format!("curveVertexCounts do not add up to the {points} points"));
        }
        if orders.len() != counts.len() || !(ranges.is_empty() || ranges.len() == 2 * counts.len()) {
            return fail(format!("it has {} curves, but {} orders", counts.len(), orders.len()));
        }
        if !(weights.is_empty() || weights.len() == points) {
            return fail(format!("it has {points} points, but {} pointWeights", weights.len()));
        }
        let (mut first, mut first_knot) = (0, 0);
        let mut curves = Vec::with_capacity(counts.len());
        for (i, (&count, &order)) in counts.iter().zip(&orders).enumerate() {
            if !(2..=MOST_ORDER).contains(&order) || count < order {
                return fail(format!(
                    "the order of curve {i} is {order}: it must be in [2, {MOST_ORDER}], and have as many points"
                ));
            }
            let (count, degree) = (count as usize, order as usize - 1);
            let own = knots.get(first_knot..first_knot + count + degree + 1);
            let own: Vec<f64> = own.unwrap_or_default().iter().map(|&knot| knot.into()).collect();
            let increases = own.is_sorted() && own.iter().all(|knot| knot.is_finite());
            if own.is_empty() || !increases || own[degree] >= own[count] {
                return fail(format!("curve {i} must have {} knots that increase", count + degree + 1));
            }
            let mut range = [own[degree], own[count]];
            if let Some(&[low, high]) = ranges.get(2 * i..2 * i + 2) {
                let clipped = [range[0].max(low.into()), range[1].min(high.into())];
                range = if clipped[0] < clipped[1] { clipped } else { range };
            }
            let weights = weights.get(first..first + count).unwrap_or_default();
            curves.push(Curve { knots: &own, degree, first, weights }.pieces(range));
            (first, first_knot) = (first + count, first_knot + count + degree + 1);
        }
        Ok(Nurbs { curves, total: points })
    }

    /// The numbers of points of the Bézier curves.
    pub fn counts(&self) -> Vec<i64> {
        self.curves.iter().map(|pieces| 3 * pieces.len() as i64 + 1).collect()
    }

    /// The points of the Bézier curves, from the control points.
    pub fn points<const N: usize>(&self, control: &[[f32; N]]) -> Vec<[f32; N]> {
        let mut points = Vec::new();
        for pieces in &self.curves {
            points.extend(pieces.first().map(|piece| piece.ends[0].value(control)));
            for Piece { ends, handles } in pieces {
                points.extend([&handles[0], &handles[1], &ends[1]].map(|place| place.value(control)));
            }
        }
        points
    }

    /// Values at the ends of the pieces, from those at control points.
    pub fn at_knots<const N: usize>(&self, control: &[[f32; N]]) -> Vec<[f32; N]> {
        let mut values = Vec::new();
        for pieces in &self.curves {
            values.extend(pieces.first().map(|piece| piece.ends[0].value(control)));
            values.extend(pieces.iter().map(|piece| piece.ends[1].value(control)));
        }
        values
    }
}

impl Place {
    fn value<const N: usize>(&self, control: &[[f32; N]]) -> [f32; N] {
        let terms = self.weights.iter().zip(&control[self.first..]);
        let sum =
            terms.fold([0.0; N], |sum, (weight, point)| std::array::from_fn(|k| sum[k] + weight * f64::from(point[k])));
        sum.map(|x| x as f32)
    }
}

/// One curve.
struct Curve<'a> {
    knots: &'a [f64],
    degree: usize,
    /// Its first control point.
    first: usize,
    /// The weights of its control points, or nothing if they are equal.
    weights: &'a [f32],
}

impl Curve<'_> {
    fn pieces(&self, [low, high]: [f64; 2]) -> Vec<Piece> {
        let is_cubic = self.degree <= 3 && self.weights.iter().all(|weight| *weight == self.weights[0]);
        let parts = if is_cubic { 1 } else { PARTS };
        let mut pieces = Vec::new();
        for span in self.degree..self.knots.len() - self.degree - 1 {
            let [start, end] = [self.knots[span].max(low), self.knots[span + 1].min(high)];
            if start >= end {
                continue;
            }
            let at = |part: usize| start + (end - start) * part as f64 / parts as f64;
            for part in 0..parts {
                let [from, to] = [at(part), at(part + 1)];
                let third = (to - from) / 3.0;
                let place = |u: f64, along: f64| {
                    let [values, slopes] = self.weights_at(span, u);
                    let weights = values.iter().zip(slopes).map(|(value, slope)| value + along * slope).collect();
                    Place { first: self.first + span - self.degree, weights }
                };
                pieces.push(Piece {
                    ends: [place(from, 0.0), place(to, 0.0)],
                    handles: [place(from, third), place(to, -third)],
                });
            }
        }
        pieces
    }

    /// The weights of the control points of a span at `u`, and their derivatives.
    fn weights_at(&self, span: usize, u: f64) -> [Vec<f64>; 2] {
        let degree = self.degree;
        let (mut values, lower) = (self.basis(span, degree, u), self.basis(span, degree - 1, u));
        let first = span - degree;
        // The difference of two functions of the degree below, of which the outer ones are 0.
        let ratio = |i: usize, value: f64| {
            let width = self.knots[first + i + degree] - self.knots[first + i];
            if width > 0.0 { value / width } else { 0.0 }
        };
        let mut slopes: Vec<f64> = (0..=degree)
            .map(|i| {
                let left = if i > 0 { ratio(i, lower[i - 1]) } else { 0.0 };
                let right = if i < degree { ratio(i + 1, lower[i]) } else { 0.0 };
                degree as f64 * (left - right)
            })
            .collect();
        if !self.weights.is_empty() {
            let weights = &self.weights[first..];
            for i in 0..=degree {
                values[i] *= f64::from(weights[i]);
                slopes[i] *= f64::from(weights[i]);
            }
            let (sum, slope) = (values.iter().sum::<f64>(), slopes.iter().sum::<f64>());
            for i in 0..=degree {
                values[i] /= sum;
                slopes[i] = (slopes[i] - values[i] * slope) / sum;
            }
        }
        [values, slopes]
    }

    /// The B-splines of a degree that are not 0 in a span (Cox and de Boor).
    fn basis(&self, span: usize, degree: usize, u: f64) -> Vec<f64> {
        let mut values = vec![1.0];
        for d in 1..=degree {
            let mut next = vec![0.0; d + 1];
            for (i, value) in values.iter().enumerate() {
                let [low, high] = [self.knots[span + 1 + i - d], self.knots[span + 1 + i]];
                let share = (u - low) / (high - low);
                next[i] += (1.0 - share) * value;
                next[i + 1] += share * value;
            }
            values = next;
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of a circle is a rational curve of degree 2. A cubic piece with the tangents of a curve is
    /// within h⁴/384 of its fourth derivative, which is about 30 here: 2e-5 for h = 1/8.
    #[test]
    fn rational_curves_are_round() {
        let root = std::f32::consts::FRAC_1_SQRT_2;
        let curve = Curve { knots: &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0], degree: 2, first: 0, weights: &[1.0, root, 1.0] };
        let nurbs = Nurbs { curves: vec![curve.pieces([0.0, 1.0])], total: 3 };
        let points = nurbs.points(&[[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!((points.len(), nurbs.counts(), points[0], points[24]), (25, vec![25], [1.0, 0.0], [0.0, 1.0]));
        for piece in points[..].windows(4).step_by(3) {
            for t in [0.0f32, 0.25, 0.5, 0.75] {
                let s = 1.0 - t;
                let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
                let at = |k: usize| piece.iter().zip(weights).map(|(p, w)| p[k] * w).sum::<f32>();
                assert!((at(0).hypot(at(1)) - 1.0).abs() < 2e-5, "{:?}", [at(0), at(1)]);
            }
        }
    }
}
