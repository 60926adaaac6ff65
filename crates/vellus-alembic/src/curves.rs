//! Curves (ICurves).

use crate::archive::{Archive, Object};
use crate::attribute::Attribute;
use crate::error::Error;
use crate::geometry::Geometry;

/// The order of curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveType {
    /// Cubic curves.
    Cubic,
    /// Straight segments.
    Linear,
    /// Each curve has an order of its own: [`Curves::orders`].
    VariableOrder,
    /// A number that the format does not define.
    Unknown(u8),
}

/// The basis of cubic curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveBasis {
    /// None: linear curves have none.
    None,
    /// Bézier segments that share their end points.
    Bezier,
    /// B-splines. With [`Curves::knots`], those; otherwise uniform.
    BSpline,
    /// Catmull–Rom splines.
    CatmullRom,
    /// A point and a tangent in turn.
    Hermite,
    /// Coefficients of polynomials.
    Power,
    /// A number that the format does not define.
    Unknown(u8),
}

/// Curves at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// Their order.
    pub kind: CurveType,
    /// Whether they are loops.
    pub periodic: bool,
    /// The basis of cubic curves.
    pub basis: CurveBasis,
    /// The number of points of each curve. Their sum is the number of positions.
    pub counts: Vec<u32>,
    /// Control points of all curves, in the space of the object.
    pub positions: Vec<[f32; 3]>,
    /// Weights of rational curves, one for each point.
    pub weights: Option<Vec<f32>>,
    /// The speed of each point, per second.
    pub velocities: Option<Vec<[f32; 3]>>,
    /// The order of each curve of a variable order: the degree plus 1.
    pub orders: Vec<u8>,
    /// Knots of all curves, one behind another.
    pub knots: Vec<f32>,
    /// Diameters.
    pub widths: Option<Attribute>,
    /// Texture coordinates.
    pub uv: Option<Attribute>,
    /// Normals.
    pub normals: Option<Attribute>,
}

impl Curves {
    /// The beginning of the names of this schema.
    pub const SCHEMA: &'static str = "AbcGeom_Curve_v";

    /// Reads curves at a time in seconds. Positions and widths are interpolated between samples with the same numbers
    /// of points.
    ///
    /// # Errors
    /// [`Error::Damaged`], or [`Error::Property`] if the numbers of points do not fit.
    pub fn read(archive: &Archive, object: &Object, time: f64) -> Result<Self, Error> {
        let geometry = Geometry::new(archive, object, ".geom", time)?;
        let steady = geometry.is_steady(&["nVertices", "curveBasisAndType"])?;
        let positions = geometry.vectors("P", steady)?.unwrap_or_default();
        let counts = geometry.counts("nVertices", positions.len(), "points")?;
        let kinds = geometry.integers("curveBasisAndType")?.unwrap_or_default();
        let number = |i: usize| kinds.get(i).copied().unwrap_or_default() as u8;
        let full = |numbers: &Vec<f32>| numbers.len() == positions.len();
        let orders = geometry.integers(".orders")?.unwrap_or_default();
        Ok(Curves {
            kind: match number(0) {
                0 => CurveType::Cubic,
                1 => CurveType::Linear,
                2 => CurveType::VariableOrder,
                other => CurveType::Unknown(other),
            },
            periodic: number(1) == 1,
            basis: match number(2) {
                0 => CurveBasis::None,
                1 => CurveBasis::Bezier,
                2 => CurveBasis::BSpline,
                3 => CurveBasis::CatmullRom,
                4 => CurveBasis::Hermite,
                5 => CurveBasis::Power,
                other => CurveBasis::Unknown(other),
            },
            weights: geometry.numbers("w", steady)?.filter(full),
            velocities: geometry.vectors(".velocities", false)?.filter(|v| v.len() == positions.len()),
            orders: orders.into_iter().map(|order| order.clamp(0, 255) as u8).collect(),
            knots: geometry.numbers(".knots", false)?.unwrap_or_default(),
            widths: geometry.attribute("width")?,
            uv: geometry.attribute("uv")?,
            normals: geometry.attribute("N")?,
            counts,
            positions,
        })
    }

    /// The time of the last sample of positions that is not later, to which velocities belong, and the number of
    /// samples. `None` without positions.
    ///
    /// # Errors
    /// [`Error::Property`] if the object has no curves.
    pub fn sampled(archive: &Archive, object: &Object, time: f64) -> Result<Option<(f64, u32)>, Error> {
        Ok(Geometry::new(archive, object, ".geom", time)?.sampled("P"))
    }
}
