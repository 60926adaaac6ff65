//! What every model of a fibre's scattering offers, so that one renderer, picture or test takes any of them.

use crate::bcsdf::{Bcsdf, Hit};
use crate::error::Error;
use crate::fiber::Fiber;
use crate::lobe::{Lobes, Sample};
use crate::window::Window;
use glam::Vec3;

/// Which windows a model knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// One offset at a time: of a wider window, only the offset in its middle is seen.
    Near,
    /// The average over the whole width, whatever the window is.
    Far,
    /// Any window.
    Any,
}

/// A model of the scattering of one fibre, ready for hits.
///
/// Static dispatch throughout: a renderer generic over `Model` is compiled for each as if it knew no other.
pub trait Model: Sync {
    /// One hit of it.
    type Hit<'a>: Scattering
    where
        Self: 'a;

    /// Prepares all that depends on ω_o and the window; see [`Bcsdf::at`].
    fn at(&self, wo: Vec3, window: Window) -> Self::Hit<'_>;

    /// As [`Model::at`], but the hit is handed to `f`: faster where hits are too large to be moved.
    #[inline]
    fn with_hit<R>(&self, wo: Vec3, window: Window, f: impl FnOnce(&Self::Hit<'_>) -> R) -> R {
        f(&self.at(wo, window))
    }

    /// The windows it knows.
    fn field(&self) -> Field;

    /// The same model of another fibre: what a renderer asks for at each hit where parameters vary along the fur.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where [`Fiber::validate`] finds one.
    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error>
    where
        Self: Sized;
}

/// One hit of a fibre. The conventions are those of [the crate](crate): f·cos θᵢ, densities per solid angle.
pub trait Scattering {
    /// The energy each lobe carries, RGB: the integral of f·cos θᵢ over all ω_i.
    fn energy(&self) -> Lobes;

    /// f(ω_o, ω_i)·cos θᵢ of each lobe, RGB.
    fn eval(&self, wi: Vec3) -> Lobes {
        self.eval_pdf(wi).0
    }

    /// The density per solid angle with which [`Scattering::sample`] draws `wi`.
    fn pdf(&self, wi: Vec3) -> f32 {
        self.eval_pdf(wi).1
    }

    /// Both together.
    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32);

    /// Draws ω_i from five uniform numbers in [0, 1).
    fn sample(&self, u: [f32; 5]) -> Option<Sample>;
}

impl Model for Bcsdf<'_> {
    type Hit<'a>
        = Hit<'a>
    where
        Self: 'a;

    #[inline]
    fn at(&self, wo: Vec3, window: Window) -> Hit<'_> {
        self.at(wo, window)
    }

    #[inline]
    fn with_hit<R>(&self, wo: Vec3, window: Window, f: impl FnOnce(&Hit<'_>) -> R) -> R {
        self.with_hit(wo, window, f)
    }

    fn field(&self) -> Field {
        Field::Any
    }

    #[inline]
    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error> {
        Self::with_tables(fiber, self.tables())
    }
}

impl Scattering for Hit<'_> {
    #[inline]
    fn energy(&self) -> Lobes {
        self.energy()
    }

    #[inline]
    fn eval(&self, wi: Vec3) -> Lobes {
        self.eval(wi)
    }

    #[inline]
    fn pdf(&self, wi: Vec3) -> f32 {
        self.pdf(wi)
    }

    #[inline]
    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        self.eval_pdf(wi)
    }

    #[inline]
    fn sample(&self, u: [f32; 5]) -> Option<Sample> {
        self.sample(u)
    }
}
