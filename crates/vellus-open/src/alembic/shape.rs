//! Control points of Alembic's curves as those of strands: ends, loops, tangents and knots.

use glam::{Vec3, Vec4};
use vellus_alembic::{Attribute, CurveBasis, CurveType, Curves};
use vellus_scene::{Basis, Strands, Values};

/// How the points of a file become those of strands.
enum Kind {
    /// As they are.
    Plain,
    /// With a phantom point beyond each end, so that splines begin at their first and end at their last point.
    Pinned,
    /// With this many of the first points again at the end.
    Closed(usize),
    /// A point and a tangent in turn become Bézier curves.
    Hermite,
    /// B-splines with knots become Bézier curves.
    Knots(Vec<f32>),
}

/// The curves of an object as strands.
pub(super) struct Shape {
    /// The basis of the strands.
    pub basis: Basis,
    counts: Vec<u32>,
    kind: Kind,
}

impl Shape {
    /// The shape of curves, and what should be said about it.
    ///
    /// Alembic does not say whether splines reach their end points. Grooming programs mean that they do: Blender, for
    /// example, writes the same points to USD as `pinned`.
    ///
    /// # Errors
    /// Why there are no such strands.
    pub fn new(curves: &Curves) -> Result<(Self, Option<String>), String> {
        let counts = curves.counts.clone();
        let all = |order: u8| !curves.orders.is_empty() && curves.orders.iter().all(|own| *own == order);
        let straight = |what: &str| Some(format!("{what}: its strands are straight between their points"));
        let (basis, note) = match (curves.kind, curves.basis) {
            // Blender's Catmull-Rom curves. Its straight ones have no basis.
            (CurveType::Linear, CurveBasis::CatmullRom) => (CurveBasis::CatmullRom, None),
            (CurveType::Linear, _) => (CurveBasis::None, None),
            (CurveType::VariableOrder, _) if all(2) => (CurveBasis::None, None),
            (CurveType::VariableOrder, _) if all(4) => (CurveBasis::BSpline, None),
            (CurveType::VariableOrder, _) => {
                (CurveBasis::None, straight("only curves of the orders 2 and 4 are supported"))
            }
            (CurveType::Cubic, CurveBasis::None) => (CurveBasis::None, straight("its cubic curves have no basis")),
            (CurveType::Cubic, CurveBasis::Bezier) if !curves.periodic && counts.iter().any(|n| n % 3 != 1) => {
                let what = "its Bézier curves do not have 3k + 1 points: it is read as Catmull-Rom curves";
                (CurveBasis::CatmullRom, Some(what.to_owned()))
            }
            (CurveType::Cubic, basis) => (basis, None),
            (CurveType::Unknown(kind), _) => return Err(format!("its type of curves, {kind}, is not known")),
        };
        let closed = |extra: usize, open: Kind| if curves.periodic { Kind::Closed(extra) } else { open };
        let (basis, kind) = match basis {
            CurveBasis::None => (Basis::Linear, closed(1, Kind::Plain)),
            CurveBasis::Bezier => (Basis::Bezier, closed(1, Kind::Plain)),
            CurveBasis::CatmullRom => (Basis::CatmullRom, closed(3, Kind::Pinned)),
            CurveBasis::BSpline => match knots(curves) {
                Some(knots) if !curves.periodic => (Basis::Bezier, Kind::Knots(knots)),
                _ => (Basis::BSpline, closed(3, Kind::Pinned)),
            },
            CurveBasis::Hermite if curves.periodic || counts.iter().any(|n| n % 2 == 1) => {
                return Err("Hermite curves must be open, with a tangent behind each point".to_owned());
            }
            CurveBasis::Hermite => (Basis::Bezier, Kind::Hermite),
            CurveBasis::Power => return Err("curves of the power basis are not supported".to_owned()),
            CurveBasis::Unknown(basis) => return Err(format!("its basis, {basis}, is not known")),
        };
        let weights = curves.weights.as_deref().unwrap_or_default();
        let is_rational = weights.iter().any(|weight| *weight != weights[0]);
        let note = note.or(is_rational.then(|| "the weights of its points are ignored".to_owned()));
        Ok((Shape { basis, counts, kind }, note))
    }

    /// The number of strands.
    pub fn strands(&self) -> usize {
        self.counts.len()
    }

    /// The number of points in the file.
    pub fn total(&self) -> usize {
        self.counts.iter().map(|count| *count as usize).sum()
    }

    /// The row of each strand of an attribute with this many rows: one for all, one for each strand, or one for each
    /// point, of which the root counts. `None` if it is none of these.
    pub fn rows_of_roots(&self, rows: usize) -> Option<Vec<usize>> {
        match rows {
            1 => Some(vec![0; self.strands()]),
            _ if rows == self.strands() => Some((0..rows).collect()),
            _ if rows == self.total() => {
                let first = |next: &mut usize, count: &u32| {
                    let first = *next;
                    *next += *count as usize;
                    // A strand without points is left out: its row is not used.
                    Some(first.min(rows - 1))
                };
                Some(self.counts.iter().scan(0, first).collect())
            }
            _ => None,
        }
    }

    /// The point of the file whose value each control point has, for values that cannot be interpolated: phantom points
    /// have that of the end. `None` if points were computed from others.
    pub fn rows_of_points(&self) -> Option<Vec<usize>> {
        let mut rows = Vec::with_capacity(self.total());
        let mut first = 0;
        for count in &self.counts {
            let count = *count as usize;
            let own = first..first + count;
            first += count;
            match self.kind {
                Kind::Plain => rows.extend(own),
                Kind::Closed(extra) => rows.extend(own.cycle().take(if count == 0 { 0 } else { count + extra })),
                // As `extend`: a strand of fewer points has no phantom points.
                Kind::Pinned if count >= 2 => {
                    rows.push(own.start);
                    rows.extend(own.clone());
                    rows.push(own.end - 1);
                }
                Kind::Pinned => rows.extend(own),
                Kind::Hermite | Kind::Knots(_) => return None,
            }
        }
        Some(rows)
    }

    /// Control points of the strands, and the index of the first one of each. `None` if there are too many.
    pub fn points(&self, positions: &[[f32; 3]]) -> Option<(Vec<u32>, Vec<[f32; 3]>)> {
        // No shape has more than three points for each one, or three more for a strand.
        if positions.len() + self.counts.len() > u32::MAX as usize / 4 {
            return None;
        }
        let mut starts = vec![0];
        let mut points = Vec::with_capacity(positions.len() + 3 * self.counts.len());
        self.each(positions, |strand, knots| {
            match self.kind {
                Kind::Hermite => {
                    let of = |i: usize, share: f32| mix(strand[2 * i], strand[2 * i + 1], share);
                    for i in 0..strand.len() / 2 {
                        // A handle is a third of a tangent away.
                        points.extend((i > 0).then(|| of(i, -1.0 / 3.0)));
                        points.push(strand[2 * i]);
                        points.extend((2 * i + 2 < strand.len()).then(|| of(i, 1.0 / 3.0)));
                    }
                }
                _ => self.extend(strand, knots, &mut points),
            }
            starts.push(points.len() as u32);
        });
        Some((starts, points))
    }

    /// An attribute for all strands, for each one, or for each of their points: its number of rows says which. `None`
    /// if it is neither, or has fewer than N numbers a row.
    pub fn spread<const N: usize>(&self, attribute: &Attribute) -> Option<Values<[f32; N]>> {
        let rows = attribute.rows();
        let total = self.total();
        let row = |row: usize| std::array::from_fn(|lane| attribute.number(row, lane).map_or(f32::NAN, |x| x as f32));
        let is_hermite = matches!(self.kind, Kind::Hermite);
        if attribute.lanes < N || attribute.text(0).is_some() {
            return None;
        }
        match rows {
            1 => Some(Values::Constant(row(0))),
            _ if rows == self.counts.len() => Some(Values::PerStrand((0..rows).map(row).collect())),
            _ if rows == total => {
                let step = if is_hermite { 2 } else { 1 };
                Some(Values::PerPoint(self.values(&(0..rows).step_by(step).map(row).collect::<Vec<_>>())))
            }
            _ if is_hermite && 2 * rows == total => {
                Some(Values::PerPoint(self.values(&(0..rows).map(row).collect::<Vec<_>>())))
            }
            _ => None,
        }
    }

    /// Values at control points of strands, from those at points of the file, or of Hermite curves without tangents.
    fn values<const N: usize>(&self, values: &[[f32; N]]) -> Vec<[f32; N]> {
        let mut all = Vec::with_capacity(values.len() + 3 * self.counts.len());
        match self.kind {
            Kind::Hermite => {
                let mut rest = values;
                for count in &self.counts {
                    let (strand, after) = rest.split_at(*count as usize / 2);
                    rest = after;
                    for pair in strand.windows(2) {
                        let between = |share| std::array::from_fn(|i| pair[0][i] + share * (pair[1][i] - pair[0][i]));
                        all.extend([pair[0], between(1.0 / 3.0), between(2.0 / 3.0)]);
                    }
                    all.extend(strand.last());
                }
            }
            _ => self.each(values, |strand, knots| self.extend(strand, knots, &mut all)),
        }
        all
    }

    /// The part of the file's points, and of its knots, for each strand.
    fn each<const N: usize>(&self, values: &[[f32; N]], mut of: impl FnMut(&[[f32; N]], &[f32])) {
        let mut rest = values;
        let mut knots = if let Kind::Knots(knots) = &self.kind { &knots[..] } else { &[] };
        for count in &self.counts {
            let (strand, after) = rest.split_at(*count as usize);
            let (own, others) = knots.split_at(if knots.is_empty() { 0 } else { strand.len() + 4 });
            (rest, knots) = (after, others);
            of(strand, own);
        }
    }

    fn extend<const N: usize>(&self, strand: &[[f32; N]], knots: &[f32], all: &mut Vec<[f32; N]>) {
        match (&self.kind, strand) {
            // As UsdGeomBasisCurves defines: the mirror image of the second point about the first.
            (Kind::Pinned, [first, second, ..]) => {
                let beyond = |end: &[f32; N], next: &[f32; N]| std::array::from_fn(|i| 2.0 * end[i] - next[i]);
                all.push(beyond(first, second));
                all.extend_from_slice(strand);
                all.push(beyond(&strand[strand.len() - 1], &strand[strand.len() - 2]));
            }
            (Kind::Closed(extra), [_, ..]) => all.extend(strand.iter().cycle().take(strand.len() + extra)),
            (Kind::Knots(_), _) => bezier(strand, knots, all),
            _ => all.extend_from_slice(strand),
        }
    }
}

/// Strands with the control points that a file has.
pub(super) struct Authored {
    pub strands: Strands,
    /// The index that each point had; empty if points were computed from others.
    pub rows: Vec<usize>,
}

/// Strands without phantom points at the ends of splines, which readers add. Splines whose ends are no mirror images
/// become Bézier curves, which are the same curves.
pub(super) fn authored(strands: &Strands) -> Authored {
    if !matches!(strands.basis, Basis::BSpline | Basis::CatmullRom) {
        return Authored { strands: strands.clone(), rows: (0..strands.points.len()).collect() };
    }
    let is_mirrored = |beyond: Vec4, end: Vec4, next: Vec4| {
        // The reader computes it in the space of the object, so that it may be off by a rounding error.
        let expected = 2.0 * end.truncate() - next.truncate();
        let size = beyond.truncate().abs().max_element().max(next.truncate().abs().max_element());
        (beyond.truncate() - expected).abs().max_element() <= 4.0 * f32::EPSILON * size
    };
    let is_pinned = (0..strands.len()).all(|i| {
        let points = strands.strand(i);
        let last = points.len() - 1;
        is_mirrored(points[0], points[1], points[2]) && is_mirrored(points[last], points[last - 1], points[last - 2])
    });
    let mut found =
        Strands { starts: vec![0], points: Vec::new(), moved: None, varying: Vec::new(), ..strands.clone() };
    // For each strand, what becomes of values at its points.
    let all: Vec<Vec4> = strands.points.clone();
    let with = |values: &[Vec4], out: &mut Vec<Vec4>, starts: Option<&mut Vec<u32>>| {
        let mut ends = Vec::new();
        for pair in strands.starts.windows(2) {
            let own = &values[pair[0] as usize..pair[1] as usize];
            match is_pinned {
                true => out.extend_from_slice(&own[1..own.len() - 1]),
                false => as_bezier(strands.basis, own, out),
            }
            ends.push(out.len() as u32);
        }
        if let Some(starts) = starts {
            starts.extend(ends);
        }
    };
    with(&all, &mut found.points, Some(&mut found.starts));
    found.moved = strands.moved.as_ref().map(|moved| {
        let moved: Vec<Vec4> = moved.iter().map(|p| p.extend(0.0)).collect();
        let mut out = Vec::with_capacity(found.points.len());
        with(&moved, &mut out, None);
        out.into_iter().map(|p| p.truncate()).collect()
    });
    let vectors = |rows: Vec<Vec4>| {
        let mut out = Vec::with_capacity(found.points.len());
        with(&rows, &mut out, None);
        out.into_iter().map(|p| p.truncate())
    };
    let normals = strands.normals.as_ref().map(|all| vectors(all.iter().map(|n| n.extend(0.0)).collect()).collect());
    let varying = strands.varying.iter().map(|(parameter, values)| match values {
        Values::PerPoint(rows) => {
            let rows = rows.iter().map(|row| Vec3::from(*row).extend(0.0)).collect();
            (*parameter, Values::PerPoint(vectors(rows).map(|p| p.to_array()).collect()))
        }
        other => (*parameter, other.clone()),
    });
    let varying = varying.collect();
    (found.normals, found.varying) = (normals, varying);
    if !is_pinned {
        found.basis = Basis::Bezier;
        return Authored { strands: found, rows: Vec::new() };
    }
    let inner = strands.starts.windows(2).flat_map(|pair| pair[0] as usize + 1..pair[1] as usize - 1);
    Authored { strands: found, rows: inner.collect() }
}

/// Adds the Bézier points of a spline.
fn as_bezier(basis: Basis, points: &[Vec4], out: &mut Vec<Vec4>) {
    for (i, four) in points.windows(4).enumerate() {
        let [a, b, c, d] = [four[0], four[1], four[2], four[3]];
        let segment = match basis {
            Basis::CatmullRom => [b, b + (c - a) / 6.0, c - (d - b) / 6.0, c],
            _ => [(a + 4.0 * b + c) / 6.0, (2.0 * b + c) / 3.0, (b + 2.0 * c) / 3.0, (b + 4.0 * c + d) / 6.0],
        };
        out.extend(&segment[usize::from(i > 0)..]);
    }
}

fn mix(point: [f32; 3], tangent: [f32; 3], share: f32) -> [f32; 3] {
    std::array::from_fn(|i| point[i] + share * tangent[i])
}

/// The knots of cubic B-splines, if there are n + 4 that increase for each curve of n points.
fn knots(curves: &Curves) -> Option<Vec<f32>> {
    let needed: usize = curves.counts.iter().map(|count| *count as usize + 4).sum();
    let mut rest = &curves.knots[..];
    let is_good = rest.len() == needed
        && !rest.is_empty()
        && curves.counts.iter().all(|count| {
            let (own, after) = rest.split_at(*count as usize + 4);
            rest = after;
            own.is_sorted() && own.iter().all(|knot| knot.is_finite())
        });
    is_good.then(|| curves.knots.clone())
}

/// Adds the Bézier points of a cubic B-spline: values of its polar form (L. Ramshaw, *Blossoming*, 1987).
fn bezier<const N: usize>(strand: &[[f32; N]], knots: &[f32], all: &mut Vec<[f32; N]>) {
    let mut is_first = true;
    for span in 3..strand.len() {
        let (from, to) = (f64::from(knots[span]), f64::from(knots[span + 1]));
        if from >= to {
            continue;
        }
        let polar = |arguments: [f64; 3]| {
            let mut points: [[f64; N]; 4] = std::array::from_fn(|i| strand[span - 3 + i].map(f64::from));
            for (level, u) in arguments.into_iter().enumerate() {
                for i in (level + 1..4).rev() {
                    let (low, high) = (f64::from(knots[span - 3 + i]), f64::from(knots[span + i - level]));
                    let share = (u - low) / (high - low);
                    let before = points[i - 1];
                    points[i] = std::array::from_fn(|k| before[k] + share * (points[i][k] - before[k]));
                }
            }
            points[3].map(|x| x as f32)
        };
        all.extend(is_first.then(|| polar([from; 3])));
        all.extend([[from, from, to], [from, to, to], [to; 3]].map(polar));
        is_first = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curves(kind: CurveType, basis: CurveBasis, counts: &[u32]) -> Curves {
        let total = counts.iter().sum::<u32>();
        Curves {
            kind,
            periodic: false,
            basis,
            counts: counts.to_vec(),
            positions: (0..total).map(|i| [i as f32, (i * i) as f32, 0.0]).collect(),
            weights: None,
            velocities: None,
            orders: Vec::new(),
            knots: Vec::new(),
            widths: None,
            uv: None,
            normals: None,
        }
    }

    fn points(curves: &Curves) -> (Basis, Vec<u32>, Vec<[f32; 3]>) {
        let shape = Shape::new(curves).unwrap().0;
        let (starts, points) = shape.points(&curves.positions).unwrap();
        (shape.basis, starts, points)
    }

    #[test]
    fn splines_begin_and_end_at_their_points() {
        let (basis, starts, pinned) = points(&curves(CurveType::Cubic, CurveBasis::CatmullRom, &[3, 2]));
        assert_eq!((basis, starts), (Basis::CatmullRom, vec![0, 5, 9]));
        assert_eq!((pinned[0], pinned[1], pinned[4]), ([-1.0, -1.0, 0.0], [0.0; 3], [3.0, 7.0, 0.0]));
        let closed = Curves { periodic: true, ..curves(CurveType::Cubic, CurveBasis::BSpline, &[4]) };
        let (basis, starts, closed) = points(&closed);
        assert_eq!((basis, starts, closed[4], closed[6]), (Basis::BSpline, vec![0, 7], closed[0], closed[2]));
    }

    /// Points of clamped uniform knots: the curve x(t) = t of degree 1 stays, and its ends are those of the points.
    #[test]
    fn knots_become_bezier_curves() {
        let all = Curves {
            knots: vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 2.0],
            ..curves(CurveType::Cubic, CurveBasis::BSpline, &[5])
        };
        let (basis, starts, points) = points(&all);
        assert_eq!((basis, starts), (Basis::Bezier, vec![0, 7]));
        assert_eq!((points[0], points[1], points[6]), (all.positions[0], all.positions[1], all.positions[4]));
        // The knot in the middle: (P1 + 2 P2 + P3) / 4.
        assert_eq!(points[3], [2.0, (1.0 + 8.0 + 9.0) / 4.0, 0.0]);
        let [before, after] = [2, 4].map(|i| points[i]);
        assert!((0..3).all(|k| (before[k] + after[k] - 2.0 * points[3][k]).abs() < 1e-5));
    }

    /// A parabola from its points and tangents.
    #[test]
    fn tangents_become_handles() {
        let hermite = Curves {
            positions: vec![[0.0; 3], [3.0, 0.0, 0.0], [3.0, 9.0, 0.0], [3.0, 18.0, 0.0]],
            ..curves(CurveType::Cubic, CurveBasis::Hermite, &[4])
        };
        let (basis, _, points) = points(&hermite);
        assert_eq!(basis, Basis::Bezier);
        assert_eq!(points, [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 3.0, 0.0], [3.0, 9.0, 0.0]]);
    }

    #[test]
    fn curves_that_do_not_fit_their_basis_are_named() {
        let note = |kind, basis, counts: &[u32]| match Shape::new(&curves(kind, basis, counts)) {
            Ok((shape, note)) => format!("{:?} {}", shape.basis, note.unwrap_or_default()),
            Err(what) => what,
        };
        assert_eq!(note(CurveType::Cubic, CurveBasis::Bezier, &[4]), "Bezier ");
        assert_eq!(note(CurveType::Linear, CurveBasis::Bezier, &[4]), "Linear ");
        assert_eq!(note(CurveType::Linear, CurveBasis::CatmullRom, &[4]), "CatmullRom ");
        assert!(note(CurveType::Cubic, CurveBasis::Bezier, &[5]).starts_with("CatmullRom its Bézier curves do not"));
        assert!(note(CurveType::Cubic, CurveBasis::None, &[5]).starts_with("Linear its cubic curves have no basis"));
        assert!(note(CurveType::VariableOrder, CurveBasis::BSpline, &[5]).starts_with("Linear only curves of"));
        assert!(note(CurveType::Cubic, CurveBasis::Hermite, &[3]).starts_with("Hermite curves must"));
        assert!(note(CurveType::Cubic, CurveBasis::Power, &[4]).contains("not supported"));
    }
}
