//! Converts the points of a BasisCurves prim to strands: bases, pinned ends, and values between points.

use crate::error::Error;
use crate::read::nurbs::Nurbs;
use crate::read::primvar::{Interpolation, Primvar};
use vellus_scene::{Basis, Values};

/// How the ends of a curve are treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ends {
    /// As the points are.
    Open,
    /// The curve interpolates its first and last point, by a phantom point beyond each end. Only cubic B-splines and
    /// Catmull–Rom curves need it.
    Pinned,
    /// The curve is a loop: its first points follow the last one.
    Closed,
}

/// Basis, ends and point counts of the curves of a prim.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub basis: Basis,
    /// How its ends are treated.
    pub ends: Ends,
    /// Whether the values of points belong to knots, as for Hermite curves, whose handles come from tangents.
    pub at_knots: bool,
    /// The NURBS curves that these Bézier curves are. Values belong to their control points.
    pub nurbs: Option<Nurbs>,
    /// Number of points of each curve in the file.
    pub counts: Vec<usize>,
    /// Their sum.
    pub total: usize,
}

impl Layout {
    /// Checks `counts` against the number of points. Nothing is allocated before. A curve may have fewer points than
    /// its basis needs: see [`vellus_scene::Strands::remove_broken`].
    pub fn new(prim: &str, basis: Basis, ends: Ends, counts: &[i64], points: usize) -> Result<Self, Error> {
        let fail = |what: String| Err(Error::prim(prim, what));
        let mut total = 0usize;
        let mut checked = Vec::with_capacity(counts.len());
        for (i, &count) in counts.iter().enumerate() {
            let Ok(count) = usize::try_from(count) else {
                return fail(format!("curveVertexCounts[{i}] is {count}: it must not be negative"));
            };
            total = total.saturating_add(count);
            checked.push(count);
        }
        if total != points {
            return fail(format!("curveVertexCounts add up to {total}, but there are {points} points"));
        }
        let layout = Layout { basis, ends, at_knots: false, nurbs: None, counts: checked, total };
        // Strands use 32-bit indices.
        match total.checked_add(layout.phantoms() * layout.counts.len()) {
            Some(n) if u32::try_from(n).is_ok() => Ok(layout),
            _ => fail(format!("it has {points} points: at most 4294967295 are supported, including phantom points")),
        }
    }

    /// The number of points that each curve gets besides those of the file.
    fn phantoms(&self) -> usize {
        match (self.ends, self.basis) {
            (Ends::Open, _) => 0,
            (Ends::Pinned, _) => 2,
            (Ends::Closed, Basis::Linear | Basis::Bezier) => 1,
            (Ends::Closed, _) => 3,
        }
    }

    /// The index of the first point of each strand, and the total number of points, with phantom points.
    pub fn starts(&self) -> Vec<u32> {
        let mut starts = Vec::with_capacity(self.counts.len() + 1);
        let mut start = 0u32;
        starts.push(start);
        for &count in &self.counts {
            // `new` checks that the sum fits.
            start += (count + self.phantoms()) as u32;
            starts.push(start);
        }
        starts
    }

    /// The point of the file whose value each control point has, for values that cannot be interpolated: phantom points
    /// have that of the end. `None` if points were computed from others.
    pub fn rows_of_points(&self) -> Option<Vec<usize>> {
        if self.at_knots {
            return None;
        }
        let mut rows = Vec::with_capacity(self.total + self.phantoms() * self.counts.len());
        let mut first = 0;
        for &count in &self.counts {
            let own = first..first + count;
            first += count;
            match self.ends {
                Ends::Open => rows.extend(own),
                Ends::Closed => rows.extend(own.cycle().take(if count == 0 { 0 } else { count + self.phantoms() })),
                Ends::Pinned => {
                    let ends = [own.start, own.end.max(own.start + 1) - 1];
                    rows.push(ends[0]);
                    rows.extend(own);
                    rows.push(ends[1]);
                }
            }
        }
        Some(rows)
    }

    /// Number of knots of a strand with `count` points.
    fn knots(&self, count: usize) -> usize {
        match self.basis {
            Basis::Linear => count,
            Basis::Bezier if self.ends == Ends::Closed => count / 3,
            Basis::Bezier => count.div_ceil(3),
            _ if self.ends != Ends::Open => count,
            _ => count.saturating_sub(2),
        }
    }

    /// Assigns the values of a primvar to strands or points. A single value counts as constant. `name` is used in
    /// messages.
    pub fn spread<const N: usize>(
        &self,
        prim: &str,
        name: &str,
        primvar: &Primvar,
        convert: impl Fn(&[f32]) -> [f32; N],
    ) -> Result<Values<[f32; N]>, Error> {
        let given = primvar.values.len();
        let rows = || (0..given).map(|i| convert(primvar.values.row(i)));
        let (expected, kind) = match primvar.interpolation {
            Interpolation::Constant => (1, "constant"),
            Interpolation::Uniform => (self.counts.len(), "uniform"),
            Interpolation::Vertex if !self.at_knots => (self.total, "vertex"),
            _ if self.nurbs.is_some() => (self.nurbs.as_ref().map_or(0, |nurbs| nurbs.total), "vertex"),
            _ => (self.counts.iter().map(|&n| self.knots(n)).sum(), "varying"),
        };
        let (expected, kind) = if given == 1 && expected != 1 { (1, "constant") } else { (expected, kind) };
        if given != expected {
            let what = format!("{name} has {given} values, but with {kind} interpolation there must be {expected}");
            return Err(Error::prim(prim, what));
        }
        Ok(match kind {
            "constant" => Values::Constant(convert(primvar.values.row(0))),
            "uniform" => Values::PerStrand(rows().collect()),
            _ => {
                let rows: Vec<[f32; N]> = rows().collect();
                Values::PerPoint(match &self.nurbs {
                    Some(nurbs) => self.points(&nurbs.at_knots(&rows), true),
                    None => self.points(&rows, kind == "varying"),
                })
            }
        })
    }

    /// Converts values at the points or knots of the file to values at control points.
    ///
    /// Values that are linear between knots stay linear. The control point nearest to a knot of a cubic curve gets the
    /// value of the knot. Bézier handles get the value at a third of the way.
    pub fn points<const N: usize>(&self, values: &[[f32; N]], at_knots: bool) -> Vec<[f32; N]> {
        let mix = |a: [f32; N], b: [f32; N], t: f32| std::array::from_fn(|c| a[c] + t * (b[c] - a[c]));
        let mut points = Vec::with_capacity(self.total + self.phantoms() * self.counts.len());
        let mut rest = values;
        for &count in &self.counts {
            let (strand, after) = rest.split_at(if at_knots { self.knots(count) } else { count });
            rest = after;
            let end = points.len() + count + self.phantoms();
            let is_closed = self.ends == Ends::Closed;
            let knots = self.basis != Basis::Linear && at_knots;
            if self.basis == Basis::Bezier && knots {
                let first = strand.first().filter(|_| is_closed);
                let ends = strand.windows(2).map(|pair| [pair[0], pair[1]]);
                for [a, b] in ends.chain(strand.last().zip(first).map(|(a, b)| [*a, *b])) {
                    points.extend([a, mix(a, b, 1.0 / 3.0), mix(a, b, 2.0 / 3.0)]);
                }
                points.extend(first.or(strand.last()));
            } else if is_closed {
                // The first knot of a spline is at its second point.
                let turned = if knots { strand.len().saturating_sub(1) } else { 0 };
                points.extend(strand.iter().cycle().skip(turned).take(if strand.is_empty() {
                    0
                } else {
                    end - points.len()
                }));
            } else if strand.len() >= 2 && (self.ends == Ends::Pinned || knots) {
                // As UsdGeomBasisCurves defines: the mirror image of the second point about the first.
                let beyond = |end: [f32; N], next: [f32; N]| std::array::from_fn(|c| 2.0 * end[c] - next[c]);
                let (first, last) = (strand[0], strand[strand.len() - 1]);
                points.push(beyond(first, strand[1]));
                points.extend_from_slice(strand);
                points.push(beyond(last, strand[strand.len() - 2]));
            } else {
                points.extend_from_slice(strand);
            }
            // Only curves with too few points lack values.
            points.resize(end, [f32::NAN; N]);
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::Numbers;

    fn layout(basis: Basis, pinned: bool, counts: &[i64]) -> Layout {
        let ends = if pinned { Ends::Pinned } else { Ends::Open };
        Layout::new("/a", basis, ends, counts, counts.iter().sum::<i64>() as usize).unwrap()
    }

    fn spread(layout: &Layout, values: &[f32], interpolation: Interpolation) -> Result<Values<[f32; 1]>, Error> {
        let values = Numbers { values: values.to_vec(), lanes: 1 };
        layout.spread("/a", "widths", &Primvar { values, interpolation, space: None }, |row| [row[0]])
    }

    /// Values that are linear over the knots stay linear, in every basis.
    #[test]
    fn linear_courses_stay_linear() {
        use Interpolation::Varying;
        let expect = |layout: Layout, knots: &[f32], points: &[f32]| {
            let expected = Values::PerPoint(points.iter().map(|&x| [x]).collect());
            assert_eq!(spread(&layout, knots, Varying).unwrap(), expected);
            assert_eq!(layout.starts().last().copied(), Some(points.len() as u32));
        };
        expect(layout(Basis::Linear, false, &[2, 3]), &[1.0, 2.0, 5.0, 6.0, 7.0], &[1.0, 2.0, 5.0, 6.0, 7.0]);
        expect(layout(Basis::CatmullRom, false, &[5]), &[2.0, 3.0, 4.0], &[1.0, 2.0, 3.0, 4.0, 5.0]);
        expect(layout(Basis::BSpline, true, &[2]), &[2.0, 3.0], &[1.0, 2.0, 3.0, 4.0]);
        expect(layout(Basis::Bezier, false, &[7]), &[0.0, 3.0, 6.0], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    }

    /// Loops of splines have as many segments as points, and values at knots stay with their points.
    #[test]
    fn closed_curves_repeat_their_first_points() {
        let closed = |basis, count: i64| Layout::new("/a", basis, Ends::Closed, &[count], count as usize).unwrap();
        let all = |layout: &Layout, values: &[f32], at_knots| {
            let values: Vec<[f32; 1]> = values.iter().map(|&x| [x]).collect();
            layout.points(&values, at_knots).into_flattened()
        };
        assert_eq!(all(&closed(Basis::Linear, 3), &[1.0, 2.0, 3.0], false), [1.0, 2.0, 3.0, 1.0]);
        assert_eq!(all(&closed(Basis::BSpline, 4), &[1.0, 2.0, 3.0, 4.0], false), [1.0, 2.0, 3.0, 4.0, 1.0, 2.0, 3.0]);
        assert_eq!(
            all(&closed(Basis::CatmullRom, 4), &[2.0, 3.0, 4.0, 1.0], true),
            [1.0, 2.0, 3.0, 4.0, 1.0, 2.0, 3.0]
        );
        assert_eq!(all(&closed(Basis::Bezier, 6), &[0.0, 3.0], true), [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0]);
        assert_eq!(closed(Basis::BSpline, 4).starts(), [0, 7]);
    }

    /// Curves with too few points get as many values as they should have, and nothing panics.
    #[test]
    fn short_curves_have_their_place() {
        use Interpolation::{Varying, Vertex};
        for basis in [Basis::Linear, Basis::BSpline, Basis::CatmullRom, Basis::Bezier] {
            for pinned in [false, !matches!(basis, Basis::Linear | Basis::Bezier)] {
                let counts: Vec<i64> = (0..12).collect();
                let layout = layout(basis, pinned, &counts);
                let total = *layout.starts().last().unwrap() as usize;
                for interpolation in [Varying, Vertex] {
                    let knots = layout.counts.iter().map(|&n| layout.knots(n)).sum();
                    let given = if interpolation == Varying { knots } else { layout.total };
                    let Values::PerPoint(values) = spread(&layout, &vec![1.0; given], interpolation).unwrap() else {
                        panic!("{basis:?}");
                    };
                    assert_eq!(values.len(), total, "{basis:?} {pinned} {interpolation:?}");
                }
            }
        }
    }

    #[test]
    fn wrong_numbers_are_named() {
        let error = |counts: &[i64], points| {
            Layout::new("/a", Basis::Linear, Ends::Open, counts, points).unwrap_err().to_string()
        };
        assert!(error(&[-1], 0).contains("[0] is -1"));
        assert!(error(&[10_000_000, i64::MAX, i64::MAX], 4).contains("but there are 4 points"));
        let error = spread(&layout(Basis::Linear, false, &[2, 2]), &[1.0; 3], Interpolation::Vertex).unwrap_err();
        assert!(error.to_string().contains("widths has 3 values, but with vertex interpolation there must be 4"));
    }
}
