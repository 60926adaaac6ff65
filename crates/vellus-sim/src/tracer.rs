//! Traces photons through a whole fibre, in three dimensions and f64.
//!
//! The fibre is a dielectric cylinder of radius 1 with `layers` cuticle layers, an absorbing cortex and a concentric
//! medulla that scatters (Henyey–Greenstein) and absorbs. Total internal reflection is included, at any inclination.
//! Apart from the reflectance of the cuticle, no closed form of the model is used.
//!
//! R, TT and TRT carry the same energy in the model. Scattered light does not: the model lets it leave the fibre
//! without reflection, while here most of it is totally reflected inside many times.

use crate::medulla::{SimRng, Vec3, scatter, uniform2};
use std::f64::consts::TAU;
use vellus::Fiber;
use vellus::oracle::fresnel;

/// Photons traced by one random stream; the unit of work for threads.
pub(crate) const CHUNK: u64 = 1 << 14;

/// Below this share of its initial energy a photon plays Russian roulette.
const ROULETTE: f64 = 1e-3;

/// Photons that have met the cuticle more often than this play Russian roulette each time, with this chance to go on.
const LONG: u32 = 100;
const SURVIVE: f64 = 0.9;

/// What became of the light, as a fraction of what hit the fibre's width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Reflected outside.
    R,
    /// Left at the first chance, unscattered.
    Tt,
    /// Left after one internal reflection, unscattered.
    Trt,
    /// Left later, unscattered.
    Higher,
    /// Left after scattering in the medulla at least once.
    Scattered,
    /// Trapped by total reflection and not absorbed: guided along the infinite fibre.
    Guided,
}

impl Fate {
    /// All of them, in the order of [`Energies::mean`].
    pub const ALL: [Fate; 6] = [Fate::R, Fate::Tt, Fate::Trt, Fate::Higher, Fate::Scattered, Fate::Guided];

    /// The key used in files.
    pub fn key(self) -> &'static str {
        ["R", "TT", "TRT", "higher", "scattered", "guided"][self as usize]
    }
}

/// How the cuticle's facets lie against a smooth cylinder; radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surface {
    tilt: f64,
    along: f64,
    around: f64,
}

impl Surface {
    /// A smooth cylinder.
    pub const SMOOTH: Surface = Surface { tilt: 0.0, along: 0.0, around: 0.0 };

    /// The one whose reflection has the width and shift of the lobe R.
    pub fn of(fiber: &Fiber) -> Self {
        let half = |x: f32| 0.5 * f64::from(x);
        Surface { tilt: -half(fiber.alpha), along: half(fiber.beta_m), around: half(fiber.beta_n) }
    }

    /// Draws the normal of a facet at `p`.
    pub fn facet(&self, p: [f64; 2], rng: &mut SimRng) -> [f64; 3] {
        // Two normal deviates (Box and Muller 1958).
        let (u, v) = uniform2(rng);
        let radius = (-2.0 * (1.0 - f64::from(u)).ln()).sqrt();
        let (sin, cos) = (TAU * f64::from(v)).sin_cos();
        let (sin_l, cos_l) = (self.tilt + self.along * radius * cos).sin_cos();
        let (sin_a, cos_a) = (self.around * radius * sin).sin_cos();
        [sin_l, cos_l * (cos_a * p[0] - sin_a * p[1]), cos_l * (cos_a * p[1] + sin_a * p[0])]
    }
}

/// The fibre in f64.
pub(crate) struct Tracer {
    eta: f64,
    layers: f64,
    kappa: f64,
    sigma_ca: [f64; 3],
    sigma_ma: [f64; 3],
    sigma_ms: f64,
    g: f32,
    surface: Surface,
}

/// What the cuticle does to light that meets it.
struct Meeting {
    /// Share reflected.
    f: f64,
    reflected: [f64; 3],
    /// Meaningless under total reflection.
    refracted: [f64; 3],
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Tracer {
    pub(crate) fn new(fiber: &Fiber, surface: Surface) -> Self {
        Tracer {
            eta: fiber.eta.into(),
            layers: fiber.layers.into(),
            kappa: fiber.kappa.into(),
            sigma_ca: fiber.sigma_ca.map(f64::from),
            sigma_ma: fiber.sigma_ma.map(f64::from),
            sigma_ms: fiber.sigma_ms.into(),
            g: fiber.g,
            surface,
        }
    }

    /// Reflectance of the cuticle from outside, at the cosine of incidence there.
    fn reflectance(&self, cos_outside: f64) -> f64 {
        fresnel(self.eta, self.layers, cos_outside)
    }

    /// Light travelling along `d` meets a facet of the cuticle with normal `n`.
    fn meet(&self, d: [f64; 3], n: [f64; 3], entering: bool) -> Meeting {
        let along = dot(d, n);
        let (cos, ratio, side) = if entering { (-along, 1.0 / self.eta, 1.0) } else { (along, self.eta, -1.0) };
        let cos = cos.clamp(0.0, 1.0);
        let sin2 = ratio * ratio * (1.0 - cos * cos);
        let cos_t = (1.0 - sin2).max(0.0).sqrt();
        let f = if sin2 >= 1.0 { 1.0 } else { self.reflectance(if entering { cos } else { cos_t }) };
        Meeting {
            f,
            reflected: [0, 1, 2].map(|k| d[k] - 2.0 * along * n[k]),
            refracted: [0, 1, 2].map(|k| ratio * d[k] + side * (ratio * cos - cos_t) * n[k]),
        }
    }

    /// Light meets the cuticle at `p`, where the smooth normal is `p` itself. A rough facet is drawn again where light would meet
    /// its back, or leave it to the wrong side of the smooth surface: the fibre is convex, and nothing is met twice.
    fn cuticle(&self, p: [f64; 2], d: [f64; 3], entering: bool, rng: &mut SimRng) -> Meeting {
        let smooth = [0.0, p[0], p[1]];
        if self.surface == Surface::SMOOTH {
            return self.meet(d, smooth, entering);
        }
        let side = if entering { 1.0 } else { -1.0 };
        for _ in 0..64 {
            let n = self.surface.facet(p, rng);
            if -side * dot(d, n) <= 0.0 {
                continue;
            }
            let meeting = self.meet(d, n, entering);
            let through = meeting.f >= 1.0 || side * dot(meeting.refracted, smooth) < 0.0;
            if side * dot(meeting.reflected, smooth) > 0.0 && through {
                return meeting;
            }
        }
        self.meet(d, smooth, entering)
    }

    /// Traces one photon; `record` is told what leaves, in which direction, with what energy.
    pub(crate) fn photon(
        &self,
        theta_o: f64,
        h: f64,
        rng: &mut SimRng,
        record: &mut impl FnMut(Fate, [f64; 3], [f64; 3]),
    ) {
        // Arrives travelling along azimuth π; normal at azimuth −γ.
        let mut p = [(1.0 - h * h).max(0.0).sqrt(), -h];
        let arriving = [-theta_o.sin(), -theta_o.cos(), 0.0];
        // The first decision is split, not gambled: R exactly, and the rest goes on inside.
        let entry = self.cuticle(p, arriving, true, rng);
        record(Fate::R, entry.reflected, [entry.f; 3]);
        let start = 1.0 - entry.f;
        if start <= 0.0 {
            return;
        }
        let (mut energy, mut d) = ([start; 3], entry.refracted);
        let mut scattered = false;
        let mut pass = 1;
        loop {
            // To the cuticle, scattering in the medulla on the way.
            let missed = loop {
                match self.travel(&mut p, &mut d, &mut energy, rng) {
                    Event::Scattered => scattered = true,
                    Event::Cuticle { missed } => break missed,
                }
            };
            let exit = self.cuticle(p, d, false, rng);
            // Split at each interface: what leaves is recorded, what stays goes on.
            let fate = match (scattered, pass) {
                (true, _) => Fate::Scattered,
                (false, 1) => Fate::Tt,
                (false, 2) => Fate::Trt,
                (false, _) => Fate::Higher,
            };
            if exit.f < 1.0 {
                record(fate, exit.refracted, energy.map(|e| e * (1.0 - exit.f)));
            }
            energy = energy.map(|e| e * exit.f);
            // Totally reflected by a smooth cuticle on a path that misses the medulla: so it will be for ever. What
            // the cortex does not absorb is guided along the fibre.
            if exit.f >= 1.0 && missed && self.surface == Surface::SMOOTH {
                record(Fate::Guided, d, [0, 1, 2].map(|c| if self.sigma_ca[c] == 0.0 { energy[c] } else { 0.0 }));
                return;
            }
            let left = energy[0].max(energy[1]).max(energy[2]);
            if left <= 0.0 {
                return;
            }
            if left < ROULETTE * start {
                let survive = left / (ROULETTE * start);
                if f64::from(uniform2(rng).0) >= survive {
                    return;
                }
                energy = energy.map(|e| e / survive);
            }
            // A rough cuticle lets all light out in the end, but nothing says when.
            if pass > LONG {
                if f64::from(uniform2(rng).0) >= SURVIVE {
                    return;
                }
                energy = energy.map(|e| e / SURVIVE);
            }
            d = exit.reflected;
            pass += 1;
        }
    }

    /// Goes on to the next scattering or to the cuticle, absorbing on the way.
    fn travel(&self, p: &mut [f64; 2], d: &mut [f64; 3], energy: &mut [f64; 3], rng: &mut SimRng) -> Event {
        let a = (d[1] * d[1] + d[2] * d[2]).max(1e-30);
        let b = p[0] * d[1] + p[1] * d[2];
        let r2 = p[0] * p[0] + p[1] * p[1];
        let out = (-b + (b * b - a * (r2 - 1.0).min(0.0)).sqrt()) / a;
        let discriminant = b * b - a * (r2 - self.kappa * self.kappa);
        let mut attenuate = |cortex: f64, medulla: f64| {
            for c in 0..3 {
                energy[c] *= (-cortex * self.sigma_ca[c] - medulla * self.sigma_ma[c]).exp();
            }
        };
        let (enter, leave) = if self.kappa > 0.0 && discriminant > 0.0 {
            let root = discriminant.sqrt();
            (((-b - root) / a).max(0.0), ((-b + root) / a).max(0.0))
        } else {
            (0.0, 0.0)
        };
        let inside = leave - enter;
        if inside > 0.0 && self.sigma_ms > 0.0 {
            let free = -f64::ln(1.0 - f64::from(uniform2(rng).0)) / self.sigma_ms;
            if free < inside {
                attenuate(enter, free);
                let t = enter + free;
                *p = [p[0] + t * d[1], p[1] + t * d[2]];
                let turned: Vec3 = scatter(d.map(|x| x as f32), self.g, rng);
                *d = turned.map(f64::from);
                // Single precision leaves the length off by 1e-7.
                let norm = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                *d = d.map(|x| x / norm);
                return Event::Scattered;
            }
        }
        attenuate(out - inside, inside);
        let missed = inside <= 0.0;
        let q = [p[0] + out * d[1], p[1] + out * d[2]];
        let radius = q[0].hypot(q[1]);
        *p = q.map(|x| x / radius);
        Event::Cuticle { missed }
    }
}

enum Event {
    Scattered,
    /// Reached the cuticle, having missed the medulla altogether or not.
    Cuticle {
        missed: bool,
    },
}
