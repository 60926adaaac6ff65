//! The interface of all models of a fibre's scattering, so that one renderer can use any of them.

use crate::bcsdf::{Bcsdf, Hit, OwnedHit};
use crate::error::Error;
use crate::fiber::Fiber;
use crate::lobe::{Lobes, Sample};
use crate::window::Window;
use glam::Vec3;

/// The windows that a model supports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowSupport {
    /// One offset at a time. In a wider window, the model only uses the offset in the middle.
    Near,
    /// Only the average over the whole width. The window is ignored.
    Far,
    /// Any window.
    Any,
}

/// A model of the scattering of one fibre.
///
/// Dispatch is static: a renderer that is generic over `Model` is compiled for each model.
pub trait Model: Sync {
    /// One hit of the fibre.
    type Hit<'a>: Scattering
    where
        Self: 'a;

    /// Prepares everything that depends on ω_o and the window; see [`Bcsdf::at`].
    fn at(&self, wo: Vec3, window: Window) -> Self::Hit<'_>;

    /// As [`Model::at`], but passes the hit to `f`. This is faster if hits are large.
    #[inline]
    fn with_hit<R>(&self, wo: Vec3, window: Window, f: impl FnOnce(&Self::Hit<'_>) -> R) -> R {
        f(&self.at(wo, window))
    }

    /// The windows that the model supports.
    fn field(&self) -> WindowSupport;

    /// The same model of another fibre. A renderer calls this at each hit if parameters vary along the fur.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a parameter is outside its range; see [`Fiber::validate`].
    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error>
    where
        Self: Sized;
}

/// One hit of a fibre, with the conventions of [the crate](crate): f·cos θᵢ, and densities per solid angle.
pub trait Scattering {
    /// The share of the light that each lobe carries, RGB: the integral of f·cos θᵢ over all ω_i.
    fn energy(&self) -> Lobes;

    /// f(ω_o, ω_i)·cos θᵢ of each lobe, RGB. `wi` is a unit vector.
    fn eval(&self, wi: Vec3) -> Lobes {
        self.eval_pdf(wi).0
    }

    /// The density per solid angle with which [`Scattering::sample`] draws `wi`.
    fn pdf(&self, wi: Vec3) -> f32 {
        self.eval_pdf(wi).1
    }

    /// [`Scattering::eval`] and [`Scattering::pdf`] together.
    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32);

    /// Draws ω_i from five uniform numbers in [0, 1), or nothing if the density underflows to 0 or a result is not
    /// finite.
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

    fn field(&self) -> WindowSupport {
        WindowSupport::Any
    }

    #[inline]
    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error> {
        Self::with_tables(fiber, self.tables())
    }
}

macro_rules! scattering {
    ($hit:ty) => {
        impl Scattering for $hit {
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
    };
}

scattering!(Hit<'_>);
scattering!(OwnedHit);
