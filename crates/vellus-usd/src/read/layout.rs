//! Converts the points of a BasisCurves prim to strands: bases, pinned ends, and values between points.

use crate::error::Error;
use crate::read::primvar::{Interpolation, Primvar};
use vellus_scene::{Basis, Values};

/// Basis, ends and point counts of the curves of a prim.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub basis: Basis,
    /// Whether the curve interpolates its first and last point, by a phantom point beyond each end. Only cubic
    /// B-splines and Catmull–Rom curves need it.
    pub pinned: bool,
    /// Number of points of each curve in the file.
    pub counts: Vec<usize>,
    /// Their sum.
    pub total: usize,
}

impl Layout {
    /// Checks `counts` against the number of points. Nothing is allocated before.
    pub fn new(prim: &str, basis: Basis, pinned: bool, counts: &[i64], points: usize) -> Result<Self, Error> {
        let fail = |what: String| Err(Error::prim(prim, what));
        let mut total = 0usize;
        let mut checked = Vec::with_capacity(counts.len());
        for (i, &count) in counts.iter().enumerate() {
            let Ok(count) = usize::try_from(count) else {
                return fail(format!("curveVertexCounts[{i}] is {count}: it must not be negative"));
            };
            let (fits, needs) = match basis {
                Basis::Linear => (count >= 2, "at least 2"),
                Basis::Bezier => (count >= 4 && count % 3 == 1, "3k + 1 (4, 7, 10, …)"),
                _ if pinned => (count >= 2, "at least 2"),
                _ => (count >= 4, "at least 4"),
            };
            if !fits {
                let kind = if pinned { "pinned " } else { "" };
                return fail(format!("strand {i} has {count} points: a {kind}{basis:?} curve has {needs}"));
            }
            total = total.saturating_add(count);
            checked.push(count);
        }
        if total != points {
            return fail(format!("curveVertexCounts add up to {total}, but there are {points} points"));
        }
        let layout = Layout { basis, pinned, counts: checked, total };
        // Strands use 32-bit indices.
        match total.checked_add(layout.phantoms() * layout.counts.len()) {
            Some(n) if u32::try_from(n).is_ok() => Ok(layout),
            _ => fail(format!("it has {points} points: at most 4294967295 are supported, including phantom points")),
        }
    }

    fn phantoms(&self) -> usize {
        if self.pinned { 2 } else { 0 }
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

    /// Number of knots of a strand with `count` points.
    fn knots(&self, count: usize) -> usize {
        match self.basis {
            Basis::Linear => count,
            Basis::Bezier => (count - 1) / 3 + 1,
            _ if self.pinned => count,
            _ => count - 2,
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
            Interpolation::Vertex => (self.total, "vertex"),
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
            _ => Values::PerPoint(self.points(&rows().collect::<Vec<_>>(), kind == "varying")),
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
            let is_bezier = self.basis == Basis::Bezier;
            if is_bezier && at_knots {
                for pair in strand.windows(2) {
                    points.extend([pair[0], mix(pair[0], pair[1], 1.0 / 3.0), mix(pair[0], pair[1], 2.0 / 3.0)]);
                }
                points.extend(strand.last());
            } else if self.pinned || (at_knots && !is_bezier && self.basis != Basis::Linear) {
                // As UsdGeomBasisCurves defines: the mirror image of the second point about the first.
                let beyond = |end: [f32; N], next: [f32; N]| std::array::from_fn(|c| 2.0 * end[c] - next[c]);
                let (first, last) = (strand[0], strand[strand.len() - 1]);
                points.push(beyond(first, strand[1]));
                points.extend_from_slice(strand);
                points.push(beyond(last, strand[strand.len() - 2]));
            } else {
                points.extend_from_slice(strand);
            }
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::Numbers;

    fn layout(basis: Basis, pinned: bool, counts: &[i64]) -> Layout {
        Layout::new("/a", basis, pinned, counts, counts.iter().sum::<i64>() as usize).unwrap()
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

    #[test]
    fn wrong_numbers_are_named() {
        let error = |basis, pinned, counts: &[i64], points| {
            Layout::new("/a", basis, pinned, counts, points).unwrap_err().to_string()
        };
        assert!(error(Basis::BSpline, false, &[4, 3], 7).contains("/a: strand 1 has 3 points"));
        assert!(error(Basis::Bezier, false, &[6], 6).contains("3k + 1"));
        assert!(error(Basis::Linear, false, &[-1], 0).contains("[0] is -1"));
        assert!(error(Basis::Linear, false, &[10_000_000, i64::MAX, i64::MAX], 4).contains("but there are 4 points"));
        let error = spread(&layout(Basis::Linear, false, &[2, 2]), &[1.0; 3], Interpolation::Vertex).unwrap_err();
        assert!(error.to_string().contains("widths has 3 values, but with vertex interpolation there must be 4"));
    }
}
