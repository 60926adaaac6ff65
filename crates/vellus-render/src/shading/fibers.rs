//! The reflectance model of each set of strands.

use crate::geometry::curves::CurveHit;
use crate::integrator::geometry::Geometry;
use vellus::{Fiber, Model};
use vellus_scene::{Error, Look, Strands};

/// The models of all strands of a scene.
pub(crate) struct Fibers<M> {
    /// For each set of strands, the model of its look, and whether it is the same everywhere on the strands.
    sets: Vec<(M, bool)>,
}

impl<M: Model> Fibers<M> {
    pub fn new<'s>(
        strands: impl Iterator<Item = &'s Strands>,
        looks: &[Look],
        make: impl Fn(&Fiber) -> Result<M, vellus::Error>,
    ) -> Result<Self, Error> {
        let set = |strands: &Strands| {
            let look = &looks[strands.look];
            let model = make(&look.fiber).map_err(|what| Error::Fiber { place: look.name.clone(), what })?;
            Ok((model, look.textured.is_empty() && strands.varying.is_empty()))
        };
        Ok(Fibers { sets: strands.map(set).collect::<Result<_, _>>()? })
    }

    /// The same models of the looks and strands of a changed geometry, which has as many sets of strands.
    pub fn rebuilt(&self, geometry: &Geometry) -> Result<Self, Error> {
        let set = |(strands, (model, _)): (&Strands, &(M, bool))| {
            let look = &geometry.looks[strands.look];
            let model =
                model.with_fiber(&look.fiber).map_err(|what| Error::Fiber { place: look.name.clone(), what })?;
            Ok((model, look.textured.is_empty() && strands.varying.is_empty()))
        };
        Ok(Fibers { sets: geometry.all_strands().zip(&self.sets).map(set).collect::<Result<_, _>>()? })
    }

    /// The model of a fibre at a hit. `made` stores the model if parameters vary along the strands.
    pub fn at<'a>(&'a self, geometry: &Geometry, hit: &CurveHit, made: &'a mut Option<M>) -> &'a M {
        let (model, same) = &self.sets[hit.set];
        if *same {
            return model;
        }
        // `Geometry::fiber` clamps every value to its range.
        let fiber = geometry.fiber(hit);
        made.insert(model.with_fiber(&fiber).unwrap_or_else(|e| unreachable!("a fibre out of range: {e}")))
    }
}
