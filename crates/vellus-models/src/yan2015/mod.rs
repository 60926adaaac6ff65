//! L.-Q. Yan, C.-W. Tseng, H. W. Jensen, R. Ramamoorthi 2015, *Physically-Accurate Fur Reflectance: Modeling,
//! Measurement and Rendering*, ACM TOG 34(6), as Yan17 Sec. 2–3 (Eq. 4–10, Fig. 3b) describes it.
//!
//! A near-field model. A fibre is two concentric cylinders with the indices η_c and η_m: a cuticle of l layers around
//! an absorbing cortex, and a scattering medulla. Both refract and reflect a ray, which gives eleven lobes and a
//! diffuse one:
//!
//! - Eight unscattered lobes: R, TT, TRT beside the medulla; TrT, TrRrT reflected off it; TttT, TtrtT, TttRttT through
//!   it. Capital letters are events at the cuticle, small letters at the medulla. M_p is a Gaussian in θᵢ over cos²θᵢ.
//!   D_p is a Gaussian whose variance grows by β_n² at each event at the cuticle. The surface of the medulla is smooth.
//! - Three scattered lobes, from the passes of TttT, TtrtT and TttRttT. C^N and C^M follow Eq. 8–10. C^M is evaluated
//!   between inclinations inside the medulla. F_t is the transmittance of both interfaces at the outgoing inclination.
//! - The **diffuse lobe**: light that F_t does not transmit and that is reflected inside. Yan17 gives neither its
//!   energy nor its shape. Here its energy is all light that does not leave at once, minus absorption on further
//!   passes. It is uniform in azimuth and Lambertian along the fibre. With this lobe, the normalisation μ of Eq. 8 is
//!   not a free parameter.
//!
//! The model uses all parameters of a [`Fiber`]. η is η_c. β_m and β_n replace the single roughness of the 2015 paper.
//! The paper has no σ_m,a: here it absorbs along a pass, and along the mean path ⟨L⟩ after scattering. η_m is η_c by
//! default, because they are close in most published fits (Yan17 Sec. 4.1). The medulla then neither refracts nor
//! reflects, and TrT, TrRrT, TtrtT and one scattered lobe are dark.
//!
//! The total albedo at normal incidence is between that of the simulated fibre and that of `vellus`, where all
//! scattered light leaves: 0.56 for the bobcat of Yan17 Table 4 (simulation 0.44, `vellus` 0.64), 0.58 for the red fox
//! (0.49, 0.64) and 0.77 for the cat (0.72, 0.80).
//!
//! Limits: orders beyond the eleven lobes (paths such as TrRttT, TtrrtT, TRRT) and the parts of Gaussians beyond ±90°
//! are lost. A test measures the loss. Light leaves the medulla as if it came from the axis. The model is not
//! reciprocal.
//!
//! There are two versions, so that comparisons are fair. The first is optimised:
//!
//! - Paths have a closed form (`paths.rs`) instead of a trace.
//! - The eight unscattered lobes fill one register.
//! - Profiles come from the 119 KB of tables in `vellus`, not from 755 MB. They are prepared once per hit for all three
//!   passes, which share |h″|.
//! - The transmitted fraction comes from a table per η_c, η_m and l. [`Model::with_fiber`] reuses it.
//! - Queries do not allocate.
//! - Sampling is exact except for the outgoing Fresnel factor. [`Yan2015::with_original_sampling`] uses the sampling of
//!   the paper instead.
//!
//! The second, [`Yan2015::as_published`], does what was published:
//!
//! - Each path is traced from the offset through both circles (Yan17 Sec. 3; `trace.rs`).
//! - Scattered light comes from four tables of the size on the project page of 2015 (`profiles.rs`). Each number is
//!   interpolated between sixteen, for each pass.
//! - Lobes are selected by their energy, and scattered light is sampled uniformly (Yan17 Sec. 6).
//!
//! It is in single precision and shares the rest with the first, so it is at least as fast as a plain implementation:
//! the Gaussians fill one register, paths are traced once per hit and not for each direction, and the share of light
//! that leaves comes from the small tables.

mod escape;
mod hit;
mod paths;
mod profiles;
mod trace;

use crate::azimuthal::{Gaussians, GaussiansAt};
use crate::entry::Entry;
use crate::factored::{Factored, largest_channel};
use crate::longitudinal::Plane;
use escape::{Escape, Interfaces};
use glam::Vec3;
pub use hit::Yan2015Hit;
use hit::{PublishedHit, Scattered};
use paths::Paths;
pub use profiles::Profiles;
use profiles::Reading;
use std::sync::Arc;
use vellus::parts::{Medulla, exp};
use vellus::{Error, Fiber, Lobe, Model, Parameter, ScatterExit, Tables, Window, WindowSupport, grid};
use wide::f32x8;

/// Names of the eleven lobes and the diffuse lobe, in the order of [`Yan2015Hit::lobes`].
pub const LOBES: [&str; 12] =
    ["R", "TT", "TRT", "TrT", "TrRrT", "TttT", "TtrtT", "TttRttT", "TttTs", "TtrtTs", "TttRttTs", "diffuse"];

/// The lobes of [`vellus::Lobes`] that the unscattered lobes add to. With η_m = η_c, TttT is TT and TttRttT is TRT.
const NAMES: [Lobe; 8] = [Lobe::R, Lobe::Tt, Lobe::Trt, Lobe::Rest, Lobe::Rest, Lobe::Tt, Lobe::Rest, Lobe::Trt];
/// The same for the scattered lobes.
const SCATTERED: [Lobe; 3] = [Lobe::Tts, Lobe::Trts, Lobe::Trts];

/// The model of one fibre.
#[derive(Clone, Debug)]
pub struct Yan2015 {
    fiber: Fiber,
    eta_m: f32,
    shift: f32x8,
    sigma: f32x8,
    azimuthal: Gaussians,
    medulla: Medulla<'static>,
    escape: Option<Arc<Escape>>,
    /// Whether to sample as the paper does.
    original_sampling: bool,
    /// Whether to trace paths and to use large tables, as the paper does.
    published: Option<Published>,
}

/// The large tables, and the positions in [0, 1] of a fibre on their axes of τ (of C^M) and g.
#[derive(Clone, Copy, Debug)]
struct Published {
    profiles: &'static Profiles,
    tau: f32,
    g: f32,
}

impl Published {
    fn new(profiles: &'static Profiles, fiber: &Fiber) -> Self {
        let tau = grid::tau_position(f64::from(fiber.sigma_ms * fiber.kappa)) as f32;
        Published { profiles, tau, g: grid::g_position(fiber.g.into()) as f32 }
    }
}

impl Yan2015 {
    /// The model of a fibre whose medulla has the refractive index of the cortex.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if [`Fiber::validate`] returns it.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        Self::with_eta_m(fiber, fiber.eta)
    }

    /// The model of a fibre whose medulla has the refractive index `eta_m`, in [1, 3].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if [`Fiber::validate`] returns it, or if `eta_m` is out of range.
    pub fn with_eta_m(fiber: &Fiber, eta_m: f32) -> Result<Self, Error> {
        Self::prepare(fiber, eta_m, None)
    }

    fn prepare(fiber: &Fiber, eta_m: f32, known: Option<&Arc<Escape>>) -> Result<Self, Error> {
        fiber.validate()?;
        let (given, fiber) = (fiber, &fiber.in_air());
        // Water is around the fibre, and not inside.
        let eta_m = if given.wet > 0.0 { (eta_m * fiber.eta / given.eta).max(1.0) } else { eta_m };
        let range = Parameter::Eta.range();
        if !range.contains(eta_m) {
            return Err(Error::OutOfRange {
                name: "eta_m".to_owned(),
                // Converted by its decimal text, so that the message shows the same digits.
                value: eta_m.to_string().parse().unwrap_or(f64::from(eta_m)),
                range: format!("eta_m must be in {range}"),
            });
        }
        let tables = Tables::shipped();
        // This model has its own interfaces.
        let medulla = Medulla::new(&fiber.with_exit(ScatterExit::Open), tables);
        let interfaces = Interfaces { eta_c: fiber.eta, eta_m, layers: fiber.layers };
        let escape = medulla.exists().then(|| match known {
            Some(escape) if escape.interfaces == interfaces => Arc::clone(escape),
            _ => Arc::new(Escape::new(interfaces, tables)),
        });
        // R, and the lobes with two and three events at the cuticle.
        let lanes = |of: [f32; 3]| [0, 1, 2, 1, 2, 1, 1, 2].map(|i| of[i]);
        Ok(Yan2015 {
            fiber: *fiber,
            eta_m,
            shift: f32x8::new(lanes([1.0, -0.5, -1.5].map(|k| k * fiber.alpha))),
            sigma: f32x8::new(lanes([1.0, 0.5, 1.5].map(|k| k * fiber.beta_m))),
            azimuthal: Gaussians::new(lanes([1.0f32, 2.0, 3.0].map(|k| k.sqrt() * fiber.beta_n)).map(Some)),
            medulla,
            escape,
            original_sampling: false,
            published: None,
        })
    }

    /// The same model with the sampling of the paper (Yan17 Sec. 6, for both models).
    ///
    /// It selects a lobe in proportion to its energy. Unscattered lobes are sampled from their Gaussians, the scattered
    /// lobes and the diffuse lobe uniformly over the sphere. The weight is that of the selected lobe only. Use it to
    /// measure the benefit of exact sampling.
    #[must_use]
    pub fn with_original_sampling(self) -> Self {
        Yan2015 { original_sampling: true, ..self }
    }

    /// The same model as it was published: with traced paths, these large tables and the original sampling.
    ///
    /// Values are the same but for rounding and the error of interpolation in the tables. Use it to measure how fast
    /// the model of 2015 is without our optimisations: see [the module](self). [`crate::AnyModel::far_field`] still
    /// takes azimuths from the small tables.
    #[must_use]
    pub fn as_published(self, profiles: &'static Profiles) -> Self {
        let published = Some(Published::new(profiles, &self.fiber));
        Yan2015 { published, ..self.with_original_sampling() }
    }
}

impl Yan2015 {
    /// Positive offsets at which light begins to miss the medulla, and at which total reflection off it begins.
    pub(crate) fn edges(&self, wo: Vec3) -> Vec<f32> {
        let [sin, y, z] = wo.to_array();
        // κ η′ for both indices: h″ = 1 outside and inside the surface of the medulla.
        let edge = |eta: f32| self.fiber.kappa * ((eta - sin) * (eta + sin)).max(0.0).sqrt() / y.hypot(z).max(1e-12);
        let mut edges = vec![edge(self.fiber.eta), edge(self.eta_m.min(self.fiber.eta))];
        edges.retain(|h| (1e-4..1.0 - 1e-4).contains(h));
        edges.sort_by(f32::total_cmp);
        // Merges edges that nearly coincide.
        edges.dedup_by(|b, a| *b - *a < 1e-4);
        edges
    }

    #[inline(always)]
    fn scattered(&self, paths: &Paths) -> Option<(Scattered, f32)> {
        let (m, escape) = (paths.medulla?, self.escape.as_ref()?);
        let fiber = &self.fiber;
        let (tau, theta_m) = (self.medulla.tau_position(m.elongation), m.sin_m.asin());
        let pass = self.medulla.pass(tau);
        let azimuth = self.medulla.azimuth(&pass, m.angle);
        let inclination = self.medulla.inclination(theta_m);
        let mean_path = self.medulla.mean_path_of(&pass, m.angle);
        let [cone, through] = escape.shares(&inclination, &azimuth);
        // The path out, through medulla and cortex, and one further pass: in through the cortex, through the medulla,
        // and out again.
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
            // On each further pass, the fraction `through` of the remaining light leaves.
            all * held * round[c] * through / (1.0 - held * round[c]).max(1e-6)
        });
        let published = self.published.map(|Published { profiles, tau: along, g }| PublishedHit {
            reading: Reading::new(profiles, [tau, along], [m.angle, theta_m], g),
            entering: m.scattered,
            lengths: [(1.0 - fiber.kappa) * m.elongation, fiber.kappa * m.elongation],
        });
        Some((Scattered { azimuth, inclination, back: m.back, energy, diffuse, through, published }, cone))
    }
}

impl Model for Yan2015 {
    type Hit<'a> = Yan2015Hit<'a>;

    #[inline]
    fn at(&self, wo: Vec3, window: Window) -> Yan2015Hit<'_> {
        let entry = Entry::new(wo, window, self.fiber.eta, Some(self.fiber.layers));
        let paths = match self.published {
            None => Paths::new(&self.fiber, self.eta_m, &entry),
            Some(_) => Paths::traced(&self.fiber, self.eta_m, &entry),
        };
        let theta_o = entry.polar.sin.atan2(entry.polar.cos);
        let longitudinal = Plane::new(f32x8::splat(-theta_o) - self.shift, self.sigma);
        let energy = paths.unscattered.map(|channel| (f32x8::new(channel) * longitudinal.inside()).to_array());
        let azimuthal = GaussiansAt { widths: &self.azimuthal, centre: f32x8::new(paths.exit) };
        let unscattered = Factored::new(entry.frame, energy, longitudinal, azimuthal, &NAMES);
        let direct: f32 = largest_channel(&energy).iter().sum();
        let mut probability = [direct, 0.0, 0.0, 0.0, 0.0];
        let mut diffuse_probability = 0.0;
        let scattered = self.scattered(&paths).map(|(s, cone)| {
            (0..3).for_each(|i| probability[1 + i] = s.energy[i].iter().fold(0.0, |a: f32, &b| a.max(b)));
            let sum = probability[1] + probability[2] + probability[3];
            if self.original_sampling {
                probability[4] = s.diffuse.iter().fold(0.0, |a: f32, &b| a.max(b));
                return s;
            }
            // Light inside the cone that is reflected back. It is sampled from the diffuse lobe directly.
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

    fn field(&self) -> WindowSupport {
        WindowSupport::Near
    }

    /// The model of another fibre with the same η_m/η_c, where η_m is clamped to [1, 3].
    ///
    /// If η and l are the same too, this does not allocate. Otherwise it takes as long as [`Yan2015::new`], a fraction
    /// of a millisecond.
    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error> {
        let fiber = &fiber.in_air();
        let same = self.fiber.eta == fiber.eta;
        let eta_m = if same { self.eta_m } else { (self.eta_m * fiber.eta / self.fiber.eta).clamp(1.0, 3.0) };
        let published = self.published.map(|published| Published::new(published.profiles, fiber));
        let model = Self::prepare(fiber, eta_m, self.escape.as_ref())?;
        Ok(Yan2015 { original_sampling: self.original_sampling, published, ..model })
    }
}
