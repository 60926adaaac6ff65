//! Strands of hair and fur.

use crate::error::{Error, invalid};
use glam::{Vec2, Vec3, Vec4};
use vellus::Parameter;

/// The largest coordinate or radius of strands, meshes and the camera, in scene units, with either sign: 10⁹. The
/// renderer multiplies up to four lengths, and 10³⁶ is still a number in single precision.
pub const MAX_COORDINATE: f32 = 1e9;

/// Is a point within [`MAX_COORDINATE`] of zero in each direction? NaN is not.
pub(crate) fn is_within(point: Vec3) -> bool {
    point.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE)
}

/// How the points of a strand make a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// Straight segments from point to point.
    Linear,
    /// Uniform cubic B-spline; a strand of n points has n − 3 segments and begins near its second point.
    BSpline,
    /// Uniform Catmull–Rom; a strand of n points has n − 3 segments, from its second point to its last but one.
    CatmullRom,
    /// Cubic Bézier segments that share their end points: 3k + 1 points.
    Bezier,
}

impl Basis {
    /// Segments of a strand of that many points; `None` where it cannot have so many.
    pub fn segments(self, points: usize) -> Option<usize> {
        match self {
            Basis::Linear => (points >= 2).then(|| points - 1),
            Basis::BSpline | Basis::CatmullRom => (points >= 4).then(|| points - 3),
            Basis::Bezier => (points >= 4 && points % 3 == 1).then(|| (points - 1) / 3),
        }
    }
}

/// One value for all strands, or one for each strand, or for each point.
#[derive(Clone, Debug, PartialEq)]
pub enum Values<T> {
    /// The same everywhere.
    Constant(T),
    /// In the order of the strands.
    PerStrand(Vec<T>),
    /// In the order of [`Strands::points`].
    PerPoint(Vec<T>),
}

/// Many strands of one basis and one look.
#[derive(Clone, Debug, PartialEq)]
pub struct Strands {
    /// For messages.
    pub name: String,
    /// How points make curves.
    pub basis: Basis,
    /// Where the points of each strand start, and after the last strand their number.
    pub starts: Vec<u32>,
    /// Control points from root to tip, strand after strand: x, y, z and the radius (half the width), which is not negative.
    pub points: Vec<Vec4>,
    /// Where the control points are when the shutter closes, if they move: as many as there are `points`.
    pub moved: Option<Vec<Vec3>>,
    /// Texture coordinates of the roots, one a strand.
    pub root_uv: Option<Vec<Vec2>>,
    /// Index of the look in the scene.
    pub look: usize,
    /// Parameters that differ from strand to strand or along them; they replace those of the look. Angles in
    /// radians; scalars have three equal channels.
    pub varying: Vec<(Parameter, Values<[f32; 3]>)>,
}

impl Strands {
    /// Number of strands.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The points of strand `i`.
    pub fn strand(&self, i: usize) -> &[Vec4] {
        &self.points[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// Number of curve segments of all strands.
    pub fn segments(&self) -> usize {
        (0..self.len()).filter_map(|i| self.basis.segments(self.strand(i).len())).sum()
    }

    /// Checks that the numbers fit together, and that coordinates and radii are at most [`MAX_COORDINATE`].
    ///
    /// # Errors
    /// [`Error::Invalid`] names the strand and what is wrong with it.
    pub fn validate(&self) -> Result<(), Error> {
        let fail = |what: String| Err(invalid(&self.name, what));
        if self.starts.first() != Some(&0) || self.starts.last().map(|&n| n as usize) != Some(self.points.len()) {
            return fail("the strands' starts do not begin at 0 and end at the number of points".to_owned());
        }
        for (i, pair) in self.starts.windows(2).enumerate() {
            let count = pair[1].checked_sub(pair[0]);
            if count.is_none_or(|n| self.basis.segments(n as usize).is_none()) {
                let count = count.map_or("a negative number of".to_owned(), |n| n.to_string());
                return fail(format!("strand {i} has {count} points, which a {:?} curve cannot have", self.basis));
            }
            let Some(points) = self.points.get(pair[0] as usize..pair[1] as usize) else {
                return fail(format!("strand {i} ends beyond the {} points there are", self.points.len()));
            };
            for (k, point) in points.iter().enumerate() {
                if !is_within(point.truncate()) {
                    let [x, y, z, _] = point.to_array();
                    return fail(format!(
                        "strand {i}, point {k} is ({x:?}, {y:?}, {z:?}): it must be finite and within \
                         ±{MAX_COORDINATE:e}"
                    ));
                }
                if !(0.0..=MAX_COORDINATE).contains(&point.w) {
                    let width = 2.0 * point.w;
                    return fail(format!(
                        "strand {i}, point {k} has the width {width:?}: it must be in [0, {:e}]",
                        2.0 * MAX_COORDINATE
                    ));
                }
            }
        }
        if self.moved.as_ref().is_some_and(|m| m.len() != self.points.len() || !m.iter().all(|p| is_within(*p))) {
            let what = "there must be as many moved points as points, all finite and within";
            return fail(format!("{what} ±{MAX_COORDINATE:e}"));
        }
        if self.root_uv.as_ref().is_some_and(|uv| uv.len() != self.len() || uv.iter().any(|uv| !uv.is_finite())) {
            return fail("there must be one finite root uv a strand".to_owned());
        }
        for (parameter, values) in &self.varying {
            let (values, expected) = match values {
                Values::Constant(value) => (std::slice::from_ref(value), 1),
                Values::PerStrand(values) => (&values[..], self.len()),
                Values::PerPoint(values) => (&values[..], self.points.len()),
            };
            if values.len() != expected {
                return fail(format!("{} has {} values where {expected} belong", parameter.name(), values.len()));
            }
            if let Some(bad) = values.iter().find(|v| v.iter().any(|x| !x.is_finite())) {
                return fail(format!("{} has the value {bad:?}: it must be finite", parameter.name()));
            }
        }
        Ok(())
    }
}
