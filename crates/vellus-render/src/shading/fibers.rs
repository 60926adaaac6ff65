//! The scattering of all strands, by one model.

use crate::geometry::curves::CurveHit;
use crate::integrator::geometry::Geometry;
use vellus::{Fiber, Model};
use vellus_scene::{Error, Look, Strands};

/// How the strands of a world scatter.
pub(crate) struct Fibers<M> {
    /// Of each set of strands, the model of its look, and whether that is the model everywhere.
    sets: Vec<(M, bool)>,
}

impl<M: Model> Fibers<M> {
    pub fn new(
        strands: &[Strands],
        looks: &[Look],
        make: impl Fn(&Fiber) -> Result<M, vellus::Error>,
    ) -> Result<Self, Error> {
        let set = |strands: &Strands| {
            let look = &looks[strands.look];
            let model = make(&look.fiber).map_err(|what| Error::Fiber { place: look.name.clone(), what })?;
            Ok((model, look.textured.is_empty() && strands.varying.is_empty()))
        };
        Ok(Fibers { sets: strands.iter().map(set).collect::<Result<_, _>>()? })
    }

    /// The scattering of a fibre where a ray enters it; `made` keeps one that had to be made.
    pub fn at<'a>(&'a self, geometry: &Geometry, hit: &CurveHit, made: &'a mut Option<M>) -> &'a M {
        let (model, same) = &self.sets[hit.set];
        if *same {
            return model;
        }
        // Every value is held to its range where it is set.
        let fiber = geometry.fiber(hit);
        made.insert(model.with_fiber(&fiber).unwrap_or_else(|e| unreachable!("a fibre out of range: {e}")))
    }
}
