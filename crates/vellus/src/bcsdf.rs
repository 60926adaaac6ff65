//! The six lobes together: f(ω_o, ω_i)·cos θᵢ of a fibre hit at an offset, or averaged over a window of them.

use crate::cylinder::azimuthal::Azimuthal;
use crate::cylinder::frame::is_unit;
use crate::cylinder::longitudinal::Longitudinal;
use crate::error::Error;
use crate::far::segments;
use crate::far::window_hit::WindowHit;
use crate::fiber::Fiber;
use crate::medulla::Medulla;
use crate::medulla::tables::Tables;
use crate::near::NearHit;
use crate::simd::lanes::Lanes;
use crate::window::{self, Window};
use glam::Vec3;
use wide::f32x8;

/// The lobes, in the order in which every array of them is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lobe {
    /// Reflected by the cuticle.
    R,
    /// Transmitted straight through.
    Tt,
    /// Reflected once inside.
    Trt,
    /// Scattered by the medulla in its first pass, TTˢ.
    Tts,
    /// Scattered by the medulla in its second pass, TRTˢ.
    Trts,
    /// All higher orders (D6).
    Rest,
}

impl Lobe {
    /// All six, in order.
    pub const ALL: [Lobe; 6] = [Lobe::R, Lobe::Tt, Lobe::Trt, Lobe::Tts, Lobe::Trts, Lobe::Rest];

    /// The lobe that `u` in [0, 1) falls to, given their probabilities.
    #[inline(always)]
    pub(crate) fn choose(probability: [f32; 6], u: f32) -> Lobe {
        let mut rest = u;
        let mut chosen = Lobe::R;
        for lobe in Lobe::ALL {
            let p = probability[lobe as usize];
            // A lobe without energy is never drawn, not even where rounding leaves a remainder.
            if p > 0.0 {
                chosen = lobe;
                if rest < p {
                    break;
                }
            }
            rest -= p;
        }
        chosen
    }

    /// The key used in files: R, TT, TRT, TTs, TRTs, rest.
    pub fn key(self) -> &'static str {
        ["R", "TT", "TRT", "TTs", "TRTs", "rest"][self as usize]
    }
}

/// f·cos θᵢ of each lobe in RGB, indexed by [`Lobe`] as `usize`; `V` is `f32` or eight queries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobes<V = f32>(pub [[V; 3]; 6]);

impl<V: Lanes> Lobes<V> {
    /// The sum over the lobes.
    pub fn total(&self) -> [V; 3] {
        std::array::from_fn(|c| self.0[1..].iter().fold(self.0[0][c], |sum, lobe| sum + lobe[c]))
    }
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// ω_i, unit length, in the fibre's frame.
    pub wi: Vec3,
    /// Density per solid angle of drawing `wi`, whatever lobe and offset it came from: what
    /// multiple importance sampling needs.
    pub pdf: f32,
    /// f·cos θᵢ over the density of drawing `wi`, both of all lobes and of the whole window, RGB.
    pub weight: [f32; 3],
    /// The lobe it was drawn from.
    pub lobe: Lobe,
}

/// The reflectance model of one fibre, ready for hits.
///
/// Making one costs about as much as a query and allocates nothing, so a renderer may make one a
/// hit where parameters vary along the fur.
#[derive(Clone, Debug)]
pub struct Bcsdf<'t> {
    pub(crate) fiber: Fiber,
    pub(crate) longitudinal: Longitudinal,
    pub(crate) azimuthal: Azimuthal,
    pub(crate) medulla: Medulla<'t>,
    /// Does a window take more segments than usual?
    pub(crate) fine: bool,
}

impl Bcsdf<'static> {
    /// Prepares a fibre with the tables that ship with this crate.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where [`Fiber::validate`] finds one.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        Self::with_tables(fiber, Tables::shipped())
    }
}

impl<'t> Bcsdf<'t> {
    /// Prepares a fibre with tables of your own.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where [`Fiber::validate`] finds one.
    pub fn with_tables(fiber: &Fiber, tables: &'t Tables) -> Result<Self, Error> {
        fiber.validate()?;
        Ok(Bcsdf {
            fiber: *fiber,
            longitudinal: Longitudinal::new(fiber),
            azimuthal: Azimuthal::new(fiber),
            medulla: Medulla::new(fiber, tables),
            fine: segments::needs_more(fiber),
        })
    }

    /// The same fibre, whose windows take as many segments as those of the most difficult fibres. They are closer to
    /// quadrature, and take up to three times as long. Fits need this: which fibres are difficult is a threshold,
    /// where a model's values jump by its error (D9).
    pub fn with_fine_windows(self) -> Self {
        Bcsdf { fine: true, ..self }
    }

    /// The fibre.
    pub fn fiber(&self) -> &Fiber {
        &self.fiber
    }

    /// Prepares all that depends on ω_o and the window.
    ///
    /// `wo` points away from the fibre, toward where the path came from, in the fibre's frame:
    /// x runs along the fibre from root to tip. It must have unit length and be finite: else the results mean nothing.
    /// Builds with debug assertions panic then.
    #[inline]
    pub fn at(&self, wo: Vec3, window: Window) -> Hit<'_> {
        debug_assert!(is_unit(wo), "wo is not a unit vector: {wo}");
        match window.kind() {
            window::Kind::Near(h) => Hit(Kind::Near(NearHit::new(self, wo.to_array(), h))),
            window::Kind::Range(range) => self.over(wo, range),
        }
    }

    /// Not inlined: it would have every hit of the near field copied as well.
    #[inline(never)]
    fn over(&self, wo: Vec3, range: [f32; 2]) -> Hit<'_> {
        let mut hit = Hit(Kind::Window(WindowHit::new(self, wo.to_array(), range)));
        if let Kind::Window(window) = &mut hit.0 {
            window.prepare();
        }
        hit
    }

    /// As [`Bcsdf::at`], but the hit is handed to `f` where it lies: one with a window is 8 KB, and moving it takes a tenth of
    /// what preparing it does.
    #[inline]
    pub fn with<R>(&self, wo: Vec3, window: Window, f: impl FnOnce(&Hit<'_>) -> R) -> R {
        debug_assert!(is_unit(wo), "wo is not a unit vector: {wo}");
        let wo = wo.to_array();
        let mut hit = match window.kind() {
            window::Kind::Near(h) => Hit(Kind::Near(NearHit::new(self, wo, h))),
            window::Kind::Range(range) => Hit(Kind::Window(WindowHit::new(self, wo, range))),
        };
        if let Kind::Window(window) = &mut hit.0 {
            window.prepare();
        }
        f(&hit)
    }

    /// Eight hits of the near field at once: components of ω_o, and h in [−1, 1].
    #[inline]
    pub fn at8(&self, wo: [f32x8; 3], h: f32x8) -> NearHit<'_, f32x8> {
        NearHit::new(self, wo, h)
    }
}

/// One hit of a fibre: all that depends on ω_o and the window, prepared once for all its queries.
#[derive(Clone, Debug)]
pub struct Hit<'b>(Kind<'b>);

#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "a query allocates nothing")]
enum Kind<'b> {
    Near(NearHit<'b>),
    Window(WindowHit<'b>),
}

impl Hit<'_> {
    /// A, the energy each lobe carries, RGB, averaged over the window: the integral of f·cos θᵢ over
    /// all ω_i.
    #[doc(alias = "Table 3")]
    pub fn energy(&self) -> Lobes {
        match &self.0 {
            Kind::Near(hit) => hit.energy(),
            Kind::Window(hit) => hit.energy(),
        }
    }

    /// The probability with which sampling chooses each lobe, in the order of [`Lobe`].
    pub fn lobe_probabilities(&self) -> [f32; 6] {
        match &self.0 {
            Kind::Near(hit) => hit.lobe_probabilities(),
            Kind::Window(hit) => hit.lobe_probabilities(),
        }
    }

    /// f(ω_o, ω_i)·cos θᵢ of each lobe, RGB, averaged over the window. `wi` points away from the fibre,
    /// toward the light, and has unit length, as for [`Bcsdf::at`]. Light reaches a fibre from the whole sphere: no
    /// half of it is excluded.
    #[inline]
    pub fn eval(&self, wi: Vec3) -> Lobes {
        debug_assert!(is_unit(wi), "wi is not a unit vector: {wi}");
        match &self.0 {
            Kind::Near(hit) => hit.eval(wi),
            Kind::Window(hit) => hit.eval_pdf(wi).0,
        }
    }

    /// N(φ) of each lobe, RGB, averaged over the window: what leaves at azimuth φ = φ_i − φ_o, per radian,
    /// whatever its inclination.
    #[doc(alias = "Eq. 11")]
    pub fn azimuthal(&self, phi: f32) -> Lobes {
        match &self.0 {
            Kind::Near(hit) => hit.azimuthal_lobes(phi),
            Kind::Window(hit) => hit.azimuthal(phi),
        }
    }

    /// The density per solid angle with which [`Hit::sample`] draws `wi`.
    #[inline]
    pub fn pdf(&self, wi: Vec3) -> f32 {
        debug_assert!(is_unit(wi), "wi is not a unit vector: {wi}");
        match &self.0 {
            Kind::Near(hit) => hit.pdf(wi),
            Kind::Window(hit) => hit.eval_pdf(wi).1,
        }
    }

    /// [`Hit::eval`] and [`Hit::pdf`] together.
    #[inline]
    pub fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        debug_assert!(is_unit(wi), "wi is not a unit vector: {wi}");
        match &self.0 {
            Kind::Near(hit) => hit.eval_pdf(wi),
            Kind::Window(hit) => hit.eval_pdf(wi),
        }
    }

    /// Draws ω_i. `u`: five uniform numbers in [0, 1): the lobe, two for the longitudinal lobe, one for the azimuth,
    /// and where in the window. The near field ignores the last, so that a renderer draws five whatever the window is;
    /// [`NearHit::sample`], which has no window, takes the other four.
    ///
    /// No channel of the weight is above 1 in the near field. In a window it is nearly constant, but the scattered
    /// lobes' points are scaled to each channel's energy by itself: up to 1.5 has been found.
    #[inline]
    pub fn sample(&self, u: [f32; 5]) -> Sample {
        match &self.0 {
            Kind::Near(hit) => hit.sample([u[0], u[1], u[2], u[3]]),
            Kind::Window(hit) => hit.sample(u),
        }
    }
}
