//! L.-Q. Yan, C.-W. Tseng, H. W. Jensen, R. Ramamoorthi 2015, *Physically-Accurate Fur Reflectance: Modeling,
//! Measurement and Rendering*, ACM TOG 34(6), as Yan17 Sec. 2–3 (Eq. 4–10, Fig. 3b) describes it.
//!
//! Near field. A fibre is two concentric cylinders with indices of their own, η_c and η_m: a cuticle of l layers around
//! an absorbing cortex, and a scattering medulla. A ray is refracted and reflected by both, which gives eleven lobes:
//!
//! - eight unscattered: R, TT, TRT beside the medulla; TrT, TrRrT off it; TttT, TtrtT, TttRttT through it (capitals are
//!   events at the cuticle, small letters at the medulla). M_p is a Gaussian in θᵢ over cos²θᵢ, D_p a Gaussian whose
//!   variance grows by β_n² at each event at the cuticle; the medulla's surface is taken as smooth.
//! - three scattered, of the passes of TttT, TtrtT, TttRttT. C^N and C^M as in Eq. 8–10: C^M between inclinations
//!   refracted into the medulla, and F_t, the transmission of both interfaces, at the outgoing one.
//! - What F_t holds back is reflected inside and makes the **diffuse lobe**. Yan17 gives neither its energy nor its
//!   shape; here it is all that does not get out at once, minus what the fibre absorbs of it on further rounds,
//!   uniform around and Lambertian along the fibre. With it no normalisation μ (Eq. 8) is left to choose.
//!
//! Of a [`Fiber`] it takes all parameters: η is η_c; β_m and β_n, where the paper of 2015 has one roughness; σ_m,a,
//! which it has not (absorbed along a pass, and after scattering along our ⟨L⟩). η_m is η_c unless given (in most of
//! its fits they are close: Yan17 Sec. 4.1); then the medulla refracts and reflects nothing, and TrT, TrRrT, TtrtT and one scattered
//! lobe are dark.
//!
//! So read, its total albedo at normal incidence lies between the simulated fibre's and our model's, which lets all
//! scattered light leave: 0.56 for the bobcat of Yan17 Table 4 (simulated 0.44, ours 0.64), 0.58 for the red fox (0.49,
//! 0.64), 0.77 for the cat (0.72, 0.80).
//!
//! Limits: no orders beyond the eleven (paths such as TrRttT, TtrrtT, TRRT), and the part of the Gaussians beyond ±90°,
//! are lost; the test says how much. Light leaves the medulla as if from the axis. Not reciprocal.
//!
//! What makes it fast, so that it is no straw man: paths in closed form in place of tracing (`paths.rs`); the eight
//! unscattered lobes fill one register; the profiles come from the 119 KB of `vellus`, not from 620 MB, and are
//! prepared once a hit for all three passes, which share |h″|; the transmitted share comes from a table per η_c, η_m
//! and l, which [`Model::with_fiber`] keeps where other parameters vary along the fur; nothing is allocated in a
//! query; sampling is exact but for the outgoing Fresnel factor. [`Yan2015::sampled_as_published`] samples as the paper
//! did instead: scattered lobes uniformly around and cosine-weighted along the fibre, each sample weighted by its lobe alone.

mod escape;
mod hit;
mod paths;

use crate::azimuthal::{Gaussians, GaussiansAt};
use crate::entry::Entry;
use crate::factored::{Factored, largest_channel};
use crate::longitudinal::Plane;
use escape::{Escape, Interfaces};
use glam::Vec3;
use hit::Scattered;
pub use hit::Yan2015Hit;
use paths::Paths;
use std::sync::Arc;
use vellus::parts::{Medulla, exp};
use vellus::{Error, Fiber, Field, Lobe, Model, Parameter, Tables, Window};
use wide::f32x8;

/// The eleven lobes and the diffuse one, in the order of [`Yan2015Hit::lobes`].
pub const LOBES: [&str; 12] =
    ["R", "TT", "TRT", "TrT", "TrRrT", "TttT", "TtrtT", "TttRttT", "TttTs", "TtrtTs", "TttRttTs", "diffuse"];

/// What they are among the six of our model: with η_m = η_c, TttT is our TT and TttRttT our TRT.
const NAMES: [Lobe; 8] = [Lobe::R, Lobe::Tt, Lobe::Trt, Lobe::Rest, Lobe::Rest, Lobe::Tt, Lobe::Rest, Lobe::Trt];
const SCATTERED: [Lobe; 3] = [Lobe::Tts, Lobe::Trts, Lobe::Trts];

/// The model of one fibre.
#[derive(Clone, Debug)]
pub struct Yan2015 {
    fiber: Fiber,
    eta_m: f32,
    shift: f32x8,
    sigma: f32x8,
    around: Gaussians,
    medulla: Medulla<'static>,
    escape: Option<Arc<Escape>>,
    /// Samples as the paper did.
    published: bool,
}

impl Yan2015 {
    /// Prepares a fibre whose medulla has the index of its cortex.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where [`Fiber::validate`] finds one.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        Self::with_eta_m(fiber, fiber.eta)
    }

    /// Prepares a fibre with an index η_m in [1, 3] of the medulla.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where [`Fiber::validate`] finds one, or for η_m.
    pub fn with_eta_m(fiber: &Fiber, eta_m: f32) -> Result<Self, Error> {
        Self::prepare(fiber, eta_m, None)
    }

    fn prepare(fiber: &Fiber, eta_m: f32, known: Option<&Arc<Escape>>) -> Result<Self, Error> {
        fiber.validate()?;
        let range = Parameter::Eta.range();
        if !range.contains(eta_m) {
            return Err(Error::OutOfRange {
                name: "eta_m".to_owned(),
                // The f64 that prints as the f32 does.
                value: eta_m.to_string().parse().unwrap_or(f64::from(eta_m)),
                range: format!("eta_m must be in {range}"),
            });
        }
        let tables = Tables::shipped();
        let medulla = Medulla::new(fiber, tables);
        let interfaces = Interfaces { eta_c: fiber.eta, eta_m, layers: fiber.layers };
        let escape = medulla.exists().then(|| match known {
            Some(escape) if escape.interfaces == interfaces => Arc::clone(escape),
            _ => Arc::new(Escape::new(interfaces, tables)),
        });
        // Of R, and of those that meet the cuticle twice and three times.
        let lanes = |of: [f32; 3]| [0, 1, 2, 1, 2, 1, 1, 2].map(|i| of[i]);
        Ok(Yan2015 {
            fiber: *fiber,
            eta_m,
            shift: f32x8::new(lanes([1.0, -0.5, -1.5].map(|k| k * fiber.alpha))),
            sigma: f32x8::new(lanes([1.0, 0.5, 1.5].map(|k| k * fiber.beta_m))),
            around: Gaussians::new(lanes([1.0f32, 2.0, 3.0].map(|k| k.sqrt() * fiber.beta_n)).map(Some)),
            medulla,
            escape,
            published: false,
        })
    }

    /// The same model, sampled as in 2015 (Yan17 Sec. 6, which says the same of both models): a lobe in proportion to its energy;
    /// the unscattered ones from their Gaussians, the scattered and the diffuse one evenly over the sphere. The weight is that
    /// of the lobe alone. For measuring what sampling is worth.
    #[must_use]
    pub fn sampled_as_published(self) -> Self {
        Yan2015 { published: true, ..self }
    }
}

impl Yan2015 {
    /// Offsets above 0 at which light begins to miss the medulla, and to be totally reflected off it.
    pub(crate) fn edges(&self, wo: Vec3) -> Vec<f32> {
        let [sin, y, z] = wo.to_array();
        // κ η′ for either index: h″ = 1 outside and inside the medulla's surface.
        let edge = |eta: f32| self.fiber.kappa * ((eta - sin) * (eta + sin)).max(0.0).sqrt() / y.hypot(z).max(1e-12);
        let mut edges = vec![edge(self.fiber.eta), edge(self.eta_m.min(self.fiber.eta))];
        edges.retain(|h| (1e-4..1.0 - 1e-4).contains(h));
        edges.sort_by(f32::total_cmp);
        // Two that nearly coincide are one.
        edges.dedup_by(|b, a| *b - *a < 1e-4);
        edges
    }

    #[inline(always)]
    fn scattered(&self, paths: &Paths) -> Option<(Scattered, f32)> {
        let (m, escape) = (paths.medulla?, self.escape.as_ref()?);
        let fiber = &self.fiber;
        let pass = self.medulla.pass(self.medulla.tau_position(m.elongation));
        let azimuth = self.medulla.azimuth(&pass, m.angle);
        let inclination = self.medulla.inclination(m.sin_m.asin());
        let mean_path = self.medulla.mean_path_of(&pass, m.angle);
        let [cone, through] = escape.shares(&inclination, &azimuth);
        // Out through the medulla and the cortex; and once around: in through the cortex, the medulla, and out again.
        let (cortex, medulla) = ((1.0 - fiber.kappa) * m.elongation, fiber.kappa * mean_path * m.elongation);
        let (ca, ma) = (fiber.sigma_ca, fiber.sigma_ma);
        let out = |c: usize, legs: f32| -(legs * cortex * ca[c] + medulla * ma[c]);
        let [e0, e1, e2, b0, b1, b2, ..] =
            exp(f32x8::new([out(0, 1.0), out(1, 1.0), out(2, 1.0), out(0, 2.0), out(1, 2.0), out(2, 2.0), 0.0, 0.0]))
                .to_array();
        let (leaving, round) = ([e0, e1, e2], [b0, b1, b2]);
        let energy = m.scattered.map(|lobe| [0, 1, 2].map(|c| lobe[c] * leaving[c]));
        let held = 1.0 - through;
        let diffuse = [0, 1, 2].map(|c| {
            let all = energy[0][c] + energy[1][c] + energy[2][c];
            // Of what is held back, the share `through` leaves on each further round.
            all * held * round[c] * through / (1.0 - held * round[c]).max(1e-6)
        });
        Some((Scattered { azimuth, inclination, back: m.back, energy, diffuse, through }, cone))
    }
}

impl Model for Yan2015 {
    type Hit<'a> = Yan2015Hit<'a>;

    #[inline]
    fn at(&self, wo: Vec3, window: Window) -> Yan2015Hit<'_> {
        let entry = Entry::new(wo, window, self.fiber.eta, self.fiber.layers);
        let paths = Paths::new(&self.fiber, self.eta_m, &entry);
        let theta_o = entry.polar.sin.atan2(entry.polar.cos);
        let along = Plane::new(f32x8::splat(-theta_o) - self.shift, self.sigma);
        let energy = paths.unscattered.map(|channel| (f32x8::new(channel) * along.inside()).to_array());
        let around = GaussiansAt { widths: &self.around, centre: f32x8::new(paths.exit) };
        let unscattered = Factored::new(entry.frame, energy, along, around, &NAMES);
        let direct: f32 = largest_channel(&energy).iter().sum();
        let mut probability = [direct, 0.0, 0.0, 0.0, 0.0];
        let mut diffuse_probability = 0.0;
        let scattered = self.scattered(&paths).map(|(s, cone)| {
            (0..3).for_each(|i| probability[1 + i] = s.energy[i].iter().fold(0.0, |a: f32, &b| a.max(b)));
            let sum = probability[1] + probability[2] + probability[3];
            if self.published {
                probability[4] = s.diffuse.iter().fold(0.0, |a: f32, &b| a.max(b));
                return s;
            }
            // In the cone, but reflected back: drawn as diffuse from the start.
            probability[4] = sum * (cone - s.through).max(0.0);
            diffuse_probability = probability[4] + sum * (1.0 - cone);
            s
        });
        let scale = 1.0 / probability.iter().sum::<f32>().max(f32::MIN_POSITIVE);
        Yan2015Hit {
            model: self,
            unscattered,
            scattered,
            probability: probability.map(|p| p * scale),
            diffuse_probability: diffuse_probability * scale,
        }
    }

    fn field(&self) -> Field {
        Field::Near
    }

    /// Another fibre with the same η_m/η_c, η_m held to [1, 3]. Where η and l are the same too, as they are where colour, size or roughness vary along the fur,
    /// this allocates nothing; else it takes as long as [`Yan2015::new`], a fraction of a millisecond.
    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error> {
        let same = self.fiber.eta == fiber.eta;
        let eta_m = if same { self.eta_m } else { (self.eta_m * fiber.eta / self.fiber.eta).clamp(1.0, 3.0) };
        Ok(Yan2015 { published: self.published, ..Self::prepare(fiber, eta_m, self.escape.as_ref())? })
    }
}

#[cfg(test)]
mod trace;
