//! The scattering of all strands, by one model.

use crate::film::layout::Layout;
use crate::geometry::curves::CurveHit;
use crate::integrator::path::{Seen, Settings};
use crate::world::World;
use vellus::{Fiber, Model};
use vellus_scene::{Error, Look, Strands};

/// Traces samples of a world whose fibres scatter by some model: compiled for each model, and chosen once a sample.
pub(crate) trait Trace: Send + Sync {
    /// Traces a sample of a pixel; `values` are the layout's sums, of whatever content.
    fn trace(
        &self,
        world: &World,
        settings: &Settings,
        layout: &Layout,
        pixel: [usize; 2],
        index: u64,
        values: &mut [f32],
    ) -> Seen;
}

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
    pub fn at<'a>(&'a self, world: &World, hit: &CurveHit, made: &'a mut Option<M>) -> &'a M {
        let (model, same) = &self.sets[hit.set];
        if *same {
            return model;
        }
        // Every value is held to its range where it is set.
        let fiber = world.fiber(hit);
        made.insert(model.with_fiber(&fiber).unwrap_or_else(|e| unreachable!("a fibre out of range: {e}")))
    }
}

impl<M: Model + Send> Trace for Fibers<M> {
    fn trace(
        &self,
        world: &World,
        settings: &Settings,
        layout: &Layout,
        pixel: [usize; 2],
        index: u64,
        values: &mut [f32],
    ) -> Seen {
        world.trace(self, settings, layout, pixel, index, values)
    }
}
