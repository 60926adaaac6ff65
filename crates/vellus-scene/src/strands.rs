//! Strands of hair and fur.

use crate::error::{Error, invalid};
use glam::{Vec2, Vec3, Vec4};
use vellus::Parameter;

/// The largest absolute coordinate or radius of strands, meshes and the camera, in scene units: 10⁹. The renderer
/// multiplies up to four lengths, and 10³⁶ is finite in single precision.
pub const MAX_COORDINATE: f32 = 1e9;

/// Whether all coordinates of a point are within ±[`MAX_COORDINATE`]. NaN is not.
pub(crate) fn is_within(point: Vec3) -> bool {
    point.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE)
}

/// The basis of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// Straight segments between points.
    Linear,
    /// Uniform cubic B-spline. A strand of n points has n − 3 segments and begins near its second point.
    BSpline,
    /// Uniform Catmull–Rom spline. A strand of n points has n − 3 segments, from the second to the second-to-last
    /// point.
    CatmullRom,
    /// Cubic Bézier segments that share their end points. A strand of k segments has 3k + 1 points.
    Bezier,
}

impl Basis {
    /// Number of segments of a strand with `points` points. `None` if the basis does not allow this number.
    pub fn segments(self, points: usize) -> Option<usize> {
        match self {
            Basis::Linear => (points >= 2).then(|| points - 1),
            Basis::BSpline | Basis::CatmullRom => (points >= 4).then(|| points - 3),
            Basis::Bezier => (points >= 4 && points % 3 == 1).then(|| (points - 1) / 3),
        }
    }
}

/// One value for all strands, for each strand, or for each point.
#[derive(Clone, Debug, PartialEq)]
pub enum Values<T> {
    /// One value for all strands.
    Constant(T),
    /// One value for each strand.
    PerStrand(Vec<T>),
    /// One value for each of [`Strands::points`].
    PerPoint(Vec<T>),
}

/// Strands with the same basis and the same look.
#[derive(Clone, Debug, PartialEq)]
pub struct Strands {
    /// Name for messages.
    pub name: String,
    /// The basis of the curves.
    pub basis: Basis,
    /// The index of the first point of each strand, followed by the number of points. The first element is 0.
    pub starts: Vec<u32>,
    /// Control points of all strands, from root to tip: x, y, z and the radius, which must not be negative.
    pub points: Vec<Vec4>,
    /// The control points when the shutter closes, as many as `points`. `None` if they do not move.
    pub moved: Option<Vec<Vec3>>,
    /// The direction of the shorter axis of the section at each point, for fibres that are not round
    /// ([`vellus::Fiber::aspect_ratio`]): the normal of a ribbon. The part along the tangent does not count. `None`:
    /// each strand has a direction of its own.
    pub normals: Option<Vec<Vec3>>,
    /// Texture coordinates of the roots, one for each strand.
    pub root_uv: Option<Vec<Vec2>>,
    /// Index of the look in the scene.
    pub look: usize,
    /// Parameters that vary between or along strands. They replace those of the look. Angles are in radians. Scalars
    /// have three equal channels.
    pub varying: Vec<(Parameter, Values<[f32; 3]>)>,
}

impl Strands {
    /// Number of strands.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there are no strands.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The points of strand `i`.
    pub fn strand(&self, i: usize) -> &[Vec4] {
        &self.points[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// Total number of curve segments.
    pub fn segments(&self) -> usize {
        (0..self.len()).filter_map(|i| self.basis.segments(self.strand(i).len())).sum()
    }

    /// One value for each point.
    pub fn at_points<T: Copy>(&self, values: &Values<T>) -> Vec<T> {
        let of_strand = |i: usize| self.starts[i]..self.starts[i + 1];
        match values {
            Values::Constant(value) => vec![*value; self.points.len()],
            Values::PerStrand(values) => (0..self.len()).flat_map(|i| of_strand(i).map(move |_| values[i])).collect(),
            Values::PerPoint(values) => values.clone(),
        }
    }

    /// Checks that array lengths are consistent, and that coordinates and radii are at most [`MAX_COORDINATE`].
    ///
    /// # Errors
    /// [`Error::Invalid`] for the first problem. The message names the strand.
    pub fn validate(&self) -> Result<(), Error> {
        let fail = |what: String| Err(invalid(&self.name, what));
        if self.starts.first() != Some(&0) || self.starts.last().map(|&n| n as usize) != Some(self.points.len()) {
            return fail("the starts of the strands must begin with 0 and end with the number of points".to_owned());
        }
        for (i, pair) in self.starts.windows(2).enumerate() {
            let count = pair[1].checked_sub(pair[0]);
            if count.is_none_or(|n| self.basis.segments(n as usize).is_none()) {
                let count = count.map_or("a negative number of".to_owned(), |n| n.to_string());
                return fail(format!("strand {i} has {count} points, which a {:?} curve cannot have", self.basis));
            }
            let Some(points) = self.points.get(pair[0] as usize..pair[1] as usize) else {
                return fail(format!(
                    "strand {i} ends at point {}, but there are {} points",
                    pair[1],
                    self.points.len()
                ));
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
        if self.normals.as_ref().is_some_and(|n| n.len() != self.points.len() || !n.iter().all(|n| n.is_finite())) {
            return fail("there must be one finite normal for each point".to_owned());
        }
        if self.root_uv.as_ref().is_some_and(|uv| uv.len() != self.len() || uv.iter().any(|uv| !uv.is_finite())) {
            return fail("there must be one finite root uv for each strand".to_owned());
        }
        for (parameter, values) in &self.varying {
            let (values, expected) = match values {
                Values::Constant(value) => (std::slice::from_ref(value), 1),
                Values::PerStrand(values) => (&values[..], self.len()),
                Values::PerPoint(values) => (&values[..], self.points.len()),
            };
            if values.len() != expected {
                return fail(format!("{} has {} values: there must be {expected}", parameter.name(), values.len()));
            }
            if let Some(bad) = values.iter().find(|v| v.iter().any(|x| !x.is_finite())) {
                return fail(format!("{} has the value {bad:?}: it must be finite", parameter.name()));
            }
        }
        Ok(())
    }
}
