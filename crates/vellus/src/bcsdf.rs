//! The whole model: f(ω_o, ω_i)·cos θᵢ of a fibre at one offset, or averaged over a window of offsets.

use crate::cylinder::frame::is_unit;
use crate::error::Error;
use crate::far::window_hit::{WindowHit, WindowState};
use crate::fiber::Fiber;
use crate::lobe::{Lobe, Lobes, Sample};
use crate::medulla::tables::Tables;
use crate::near::{Near, NearHit};
use crate::prepared::{Owned, Prepared, Shared};
use crate::window::{self, Window};
use glam::Vec3;
use std::ops::Deref;
use wide::f32x8;

/// The reflectance model of one fibre.
///
/// [`Bcsdf::new`] takes as long as a few queries and allocates nothing. If the parameters vary along the fur, a
/// renderer may create a model for each hit. For a colour that is given as a reflectance, keep a
/// [`CoatColors`](crate::CoatColors): [`Fiber::with_color`] takes much longer than the model.
#[derive(Clone, Debug)]
pub struct Bcsdf<'t>(Prepared<'t>);

impl Bcsdf<'static> {
    /// Prepares a fibre with the tables that this crate contains.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a parameter is outside its range; see [`Fiber::validate`].
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        Self::with_tables(fiber, Tables::shipped())
    }

    /// As [`Bcsdf::at`], but the hit contains the fibre, and does not borrow it. It is for renderers whose surfaces
    /// return an object. For a fibre that has more hits, `bcsdf.clone().into_hit(wo, window)` copies 1 KB.
    pub fn into_hit(self, wo: Vec3, window: Window) -> OwnedHit {
        debug_assert!(is_unit(wo), "wo is not a unit vector: {wo}");
        let (prepared, wo) = (Owned(self.0), wo.to_array());
        OwnedHit(match window.kind() {
            window::Kind::Near(h) if prepared.section.is_some() => Kind::Near(Near::bent(prepared, wo, h)),
            window::Kind::Near(h) => Kind::Near(Near::new(prepared, wo, h)),
            window::Kind::Range(range) => {
                let mut state = Box::new(WindowState::new(&prepared, wo, range));
                state.prepare(&prepared);
                Kind::Window(prepared, state)
            }
        })
    }
}

impl<'t> Bcsdf<'t> {
    /// Prepares a fibre with other tables.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a parameter is outside its range; see [`Fiber::validate`].
    pub fn with_tables(fiber: &Fiber, tables: &'t Tables) -> Result<Self, Error> {
        fiber.validate()?;
        Ok(Bcsdf(Prepared::new(fiber, tables)))
    }

    /// The same fibre, but each window uses as many segments as the windows of the most difficult fibres. Its results
    /// are then more accurate, and take up to three times as long.
    ///
    /// Fits need this. Otherwise the model changes the number of segments at a threshold of the parameters, where its
    /// values jump by the error of the segments (D9).
    #[must_use]
    pub fn with_fine_windows(self) -> Self {
        Bcsdf(Prepared { fine: true, ..self.0 })
    }

    /// The fibre's parameters.
    pub fn fiber(&self) -> &Fiber {
        &self.0.fiber
    }

    /// Everything that was prepared.
    #[cfg(feature = "unstable")]
    pub(crate) fn prepared(&self) -> &Prepared<'t> {
        &self.0
    }

    /// The tables of the medulla.
    pub(crate) fn tables(&self) -> &'t Tables {
        self.0.medulla.tables()
    }

    /// Prepares everything that depends on ω_o and the window.
    ///
    /// `wo` points away from the fibre, toward where the path came from, in the fibre's frame: x runs along the fibre
    /// from root to tip. It must be a unit vector. Otherwise the results mean nothing, and builds with debug assertions
    /// panic if its squared length differs from 1 by 1e-3 or more.
    ///
    /// The near field allocates nothing. A wider window allocates 9.4 KB once; [`Bcsdf::with_hit`] avoids that.
    #[inline]
    pub fn at(&self, wo: Vec3, window: Window) -> Hit<'_> {
        debug_assert!(is_unit(wo), "wo is not a unit vector: {wo}");
        match window.kind() {
            window::Kind::Near(h) if self.0.section.is_some() => self.bent(wo, h),
            window::Kind::Near(h) => Hit(Kind::Near(Near::new(&self.0, wo.to_array(), h))),
            window::Kind::Range(range) => self.over(wo, range),
        }
    }

    /// A near field of a fibre that is not round, or whose medulla contains air.
    #[cold]
    #[inline(never)]
    fn bent(&self, wo: Vec3, h: f32) -> Hit<'_> {
        Hit(Kind::Near(Near::bent(&self.0, wo.to_array(), h)))
    }

    /// Not inlined, so that the near field stays small.
    #[inline(never)]
    fn over(&self, wo: Vec3, range: [f32; 2]) -> Hit<'_> {
        let mut state = Box::new(WindowState::new(&self.0, wo.to_array(), range));
        state.prepare(&self.0);
        Hit(Kind::Window(&self.0, Stored::Boxed(state)))
    }

    /// As [`Bcsdf::at`], but passes the hit to `f` and allocates nothing: the 9.4 KB of a window stay on the stack.
    #[inline]
    pub fn with_hit<R>(&self, wo: Vec3, window: Window, f: impl FnOnce(&Hit<'_>) -> R) -> R {
        debug_assert!(is_unit(wo), "wo is not a unit vector: {wo}");
        let wo = wo.to_array();
        let mut stored;
        let hit = match window.kind() {
            window::Kind::Near(h) if self.0.section.is_some() => self.bent(Vec3::from_array(wo), h),
            window::Kind::Near(h) => Hit(Kind::Near(Near::new(&self.0, wo, h))),
            window::Kind::Range(range) => {
                stored = WindowState::new(&self.0, wo, range);
                stored.prepare(&self.0);
                Hit(Kind::Window(&self.0, Stored::Borrowed(&stored)))
            }
        };
        f(&hit)
    }

    /// Prepares eight near-field hits. `wo`: the x, y and z of eight unit vectors, as for [`Bcsdf::at`]; `h`: their
    /// offsets, each clamped to [−1, 1]. NaN stays NaN: the results of its lane mean nothing, and those of the others
    /// do not depend on it.
    #[inline]
    pub fn at8(&self, wo: [f32x8; 3], h: f32x8) -> NearHit<'_> {
        debug_assert!(are_unit(wo), "a wo is not a unit vector: {wo:?}");
        // Unlike `max` and `min`, this keeps NaN, as the clamp of a window does.
        let h = h.clamp(f32x8::splat(-1.0), f32x8::splat(1.0));
        if self.0.section.is_some() {
            return self.bent8(wo, h);
        }
        NearHit(Near::new(&self.0, wo, h))
    }

    #[cold]
    #[inline(never)]
    fn bent8(&self, wo: [f32x8; 3], h: f32x8) -> NearHit<'_> {
        NearHit(Near::bent(&self.0, wo, h))
    }
}

/// Whether all eight vectors have unit length, by [`is_unit`].
fn are_unit(w: [f32x8; 3]) -> bool {
    let [x, y, z] = w.map(f32x8::to_array);
    (0..8).all(|i| is_unit(Vec3::new(x[i], y[i], z[i])))
}

/// One hit of a fibre: everything that depends on ω_o and the window, prepared once for all its queries.
///
/// A hit in the near field is stored in place. One with a wider window points to 9.4 KB, which it owns if it came from
/// [`Bcsdf::at`].
#[derive(Clone, Debug)]
pub struct Hit<'b>(Kind<Shared<'b>, Stored<'b>>);

/// A [`Hit`] that contains its fibre: see [`Bcsdf::into_hit`]. It has the same results, to the last bit.
///
/// It is 1.7 KB in place. With a window it also owns 8 KB on the heap.
#[derive(Clone, Debug)]
pub struct OwnedHit(Kind<Owned, Box<WindowState>>);

/// `P` is the prepared fibre, or refers to it. `S` owns the state of a window, or refers to it.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "the near field must not allocate")]
enum Kind<P, S> {
    Near(Near<P>),
    Window(P, S),
}

/// A window, on the heap or on the stack of [`Bcsdf::with_hit`].
#[derive(Clone, Debug)]
enum Stored<'b> {
    Boxed(Box<WindowState>),
    Borrowed(&'b WindowState),
}

impl Deref for Stored<'_> {
    type Target = WindowState;

    #[inline(always)]
    fn deref(&self) -> &WindowState {
        match self {
            Stored::Boxed(state) => state,
            Stored::Borrowed(state) => state,
        }
    }
}

/// The queries of a hit, the same whether it borrows or contains its fibre.
macro_rules! queries {
    ($hit:ty) => {
        impl $hit {
            /// A, the share of the light that each lobe carries, RGB, in [0, 1], averaged over the window. It is the
            /// integral of f·cos θᵢ over all ω_i.
            #[doc(alias = "Table 3")]
            pub fn energy(&self) -> Lobes {
                match &self.0 {
                    Kind::Near(hit) => hit.energy(),
                    Kind::Window(prepared, state) => WindowHit::new(prepared, state).energy(),
                }
            }

            /// The probability with which sampling chooses each lobe, in the order of [`Lobe`](crate::Lobe).
            pub fn lobe_probabilities(&self) -> [f32; Lobe::COUNT] {
                match &self.0 {
                    Kind::Near(hit) => hit.lobe_probabilities(),
                    Kind::Window(prepared, state) => WindowHit::new(prepared, state).lobe_probabilities(),
                }
            }

            /// f(ω_o, ω_i)·cos θᵢ of each lobe, RGB, averaged over the window.
            ///
            /// `wi` points away from the fibre, toward the light. It must be a unit vector, as for [`Bcsdf::at`]. Light
            /// reaches a fibre from the whole sphere, so no hemisphere is excluded.
            #[doc(alias = "Eq. 12")]
            #[inline]
            pub fn eval(&self, wi: Vec3) -> Lobes {
                debug_assert!(is_unit(wi), "wi is not a unit vector: {wi}");
                match &self.0 {
                    Kind::Near(hit) => hit.eval(wi),
                    Kind::Window(prepared, state) => WindowHit::new(prepared, state).eval_pdf(wi).0,
                }
            }

            /// N(φ) of each lobe, RGB, per radian, averaged over the window: the light that leaves at the azimuth φ =
            /// φ_i − φ_o (radians) at any inclination.
            #[doc(alias = "Eq. 11")]
            pub fn azimuthal(&self, phi: f32) -> Lobes {
                match &self.0 {
                    Kind::Near(hit) => hit.azimuthal_lobes(phi),
                    Kind::Window(prepared, state) => WindowHit::new(prepared, state).azimuthal(phi),
                }
            }

            /// The density per solid angle with which [`Hit::sample`] draws `wi`, a unit vector.
            #[inline]
            pub fn pdf(&self, wi: Vec3) -> f32 {
                debug_assert!(is_unit(wi), "wi is not a unit vector: {wi}");
                match &self.0 {
                    Kind::Near(hit) => hit.pdf(wi),
                    Kind::Window(prepared, state) => WindowHit::new(prepared, state).eval_pdf(wi).1,
                }
            }

            /// [`Hit::eval`] and [`Hit::pdf`] together, at little more than the cost of one.
            #[inline]
            pub fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
                debug_assert!(is_unit(wi), "wi is not a unit vector: {wi}");
                match &self.0 {
                    Kind::Near(hit) => hit.eval_pdf(wi),
                    Kind::Window(prepared, state) => WindowHit::new(prepared, state).eval_pdf(wi),
                }
            }

            /// [`Hit::eval_pdf`] of eight directions. `wi`: the x, y and z of eight unit vectors.
            pub fn eval_pdf8(&self, wi: [f32x8; 3]) -> (Lobes<f32x8>, f32x8) {
                debug_assert!(are_unit(wi), "a wi is not a unit vector: {wi:?}");
                match &self.0 {
                    Kind::Near(hit) => hit.repeated().eval_pdf8(wi),
                    Kind::Window(prepared, state) => WindowHit::new(prepared, state).eval_pdf8(wi),
                }
            }

            /// Draws ω_i. `None` if the density of the drawn direction underflows to 0, or if a result is not finite.
            /// Only numbers that are not valid cause the latter.
            ///
            /// `u`: five uniform numbers in [0, 1): one for the lobe, two for the longitudinal lobe, one for the
            /// azimuth, and one for the offset in the window. The near field ignores the last, so that a renderer draws
            /// five for any window; [`NearHit::sample8`] takes the other four.
            ///
            /// In the near field no channel of the weight is above 1. In a window the weight is nearly constant, but
            /// weights up to 1.5 were found. The reason is that the points of the scattered lobes are scaled to the
            /// energy of each channel separately.
            #[doc(alias = "Sec. 6")]
            #[inline]
            pub fn sample(&self, u: [f32; 5]) -> Option<Sample> {
                match &self.0 {
                    Kind::Near(hit) => hit.sample([u[0], u[1], u[2], u[3]]),
                    Kind::Window(prepared, state) => WindowHit::new(prepared, state).sample(u),
                }
            }

            /// [`Hit::sample`] eight times. `u`: the five uniform numbers of eight samples.
            pub fn sample8(&self, u: [f32x8; 5]) -> [Option<Sample>; 8] {
                match &self.0 {
                    Kind::Near(hit) => hit.repeated().sample8([u[0], u[1], u[2], u[3]]),
                    Kind::Window(prepared, state) => WindowHit::new(prepared, state).sample8(u),
                }
            }
        }
    };
}

queries!(Hit<'_>);
queries!(OwnedHit);

#[cfg(test)]
mod tests {
    use super::*;

    /// Renderers keep hits in arrays. A near-field hit must not be as large as a window.
    #[test]
    fn a_near_hit_is_small_and_a_window_is_stored_elsewhere() {
        let [hit, owned, near] = [size_of::<Hit>(), size_of::<OwnedHit>(), size_of::<Near<Shared>>()];
        let [fiber, window] = [size_of::<Owned>(), size_of::<WindowState>()];
        println!("Hit: {hit} bytes, OwnedHit: {owned}, a fibre: {fiber}, a window: {window}");
        assert!(hit <= near + 32 && hit <= 704, "{hit} {near}");
        assert!(owned <= hit + fiber + 32, "{owned} {hit} {fiber}");
        assert!(window > 10 * hit);
    }
}
