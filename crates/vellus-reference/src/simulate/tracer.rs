//! Traces photons through a whole fibre, in three dimensions and f64.
//!
//! The fibre is a dielectric cylinder, whose section is a circle of radius 1 or an ellipse of the same area, with
//! `layers` cuticle layers, an absorbing cortex and a concentric medulla of the same shape that scatters
//! (Henyey–Greenstein) and absorbs. Total internal reflection is included, at any inclination. Apart from the
//! reflectance of the cuticle, no closed form of the model is used.
//!
//! R, TT and TRT carry the same energy in the model. Scattered light does not: the model lets it leave the fibre
//! without reflection, while here most of it is totally reflected inside many times.

use crate::exact::fresnel;
use crate::simulate::medulla::{SimRng, Vec3, scatter, uniform2};
use std::f64::consts::{FRAC_PI_2, TAU};
use vellus::{Error, Fiber};

/// Photons of one random stream. This is the unit of work of a thread.
pub(crate) const CHUNK: u64 = 1 << 14;

/// A photon with less than this fraction of its initial energy is subject to Russian roulette.
const ROULETTE: f64 = 1e-3;

/// A photon that hit the cuticle more often than this is subject to Russian roulette at each hit.
const LONG: u32 = 100;
/// Probability to survive that roulette.
const SURVIVE: f64 = 0.9;

/// What happened to light that hit the fibre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Reflected outside.
    R,
    /// Left at the first interface, unscattered.
    Tt,
    /// Left after one internal reflection, unscattered.
    Trt,
    /// Left later, unscattered.
    Higher,
    /// Left after scattering in the medulla at least once.
    Scattered,
    /// Trapped by total internal reflection and not absorbed: guided along the infinite fibre.
    Guided,
}

impl Fate {
    /// All fates, in the order of [`Energies::mean`](crate::simulate::energies::Energies::mean).
    pub const ALL: [Fate; 6] = [Fate::R, Fate::Tt, Fate::Trt, Fate::Higher, Fate::Scattered, Fate::Guided];

    /// The name in files.
    pub fn key(self) -> &'static str {
        ["R", "TT", "TRT", "higher", "scattered", "guided"][self as usize]
    }
}

/// Orientation of the cuticle's facets against a smooth cylinder, in radians.
///
/// Facets are tilted by −α/2 along the fibre, with normal deviates of β_m/2 along and β_n/2 around it. Light that they
/// reflect is then deflected by α, β_m and β_n, as in the lobe R of the model. The effect on TT and TRT is traced. It
/// differs from Yan17 Table 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surface {
    tilt: f64,
    along: f64,
    around: f64,
}

impl Surface {
    /// A smooth cylinder.
    pub const SMOOTH: Surface = Surface { tilt: 0.0, along: 0.0, around: 0.0 };

    /// The surface whose reflection has the shift and widths of the lobe R.
    pub fn of(fiber: &Fiber) -> Self {
        let fiber = &fiber.in_air();
        let half = |x: f32| 0.5 * f64::from(x);
        Surface { tilt: -half(fiber.alpha), along: half(fiber.beta_m), around: half(fiber.beta_n) }
    }

    /// Samples the normal of a facet at `p`.
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

/// The error for a number out of range.
pub(crate) fn out_of_range(name: &str, value: f64, range: &str) -> Error {
    Error::OutOfRange { name: name.to_owned(), value, range: range.to_owned() }
}

/// Checks a fibre, and the inclination of its light in radians.
pub(crate) fn check(fiber: &Fiber, theta_o: f64) -> Result<(), Error> {
    fiber.validate()?;
    if theta_o.is_nan() || theta_o.abs() >= FRAC_PI_2 {
        return Err(out_of_range("theta_o", theta_o.to_degrees(), "theta_o must be in (-90, 90) degrees"));
    }
    Ok(())
}

/// A fibre in f64.
pub(crate) struct Tracer {
    eta: f64,
    layers: f64,
    kappa: f64,
    /// The index of the medulla. Its wall is smooth.
    eta_m: f64,
    sigma_ca: [f64; 3],
    sigma_ma: [f64; 3],
    sigma_ms: f64,
    g: f32,
    surface: Surface,
    /// The semi-axes of the section, along y and z. That of the medulla has the same ratio.
    axes: [f64; 2],
    /// The azimuth of ω_o from the longer axis.
    phi_o: f64,
}

/// Reflection and refraction at the cuticle.
struct Meeting {
    /// Fraction that is reflected.
    f: f64,
    /// Direction of reflected light.
    reflected: [f64; 3],
    /// Direction of refracted light. It has no meaning under total reflection.
    refracted: [f64; 3],
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Tracer {
    pub(crate) fn new(fiber: &Fiber, surface: Surface) -> Self {
        let fiber = &fiber.in_air();
        Tracer {
            eta: fiber.eta.into(),
            layers: fiber.layers.into(),
            kappa: fiber.kappa.into(),
            eta_m: if fiber.medulla_air > 0.0 { fiber.medulla_eta().into() } else { fiber.eta.into() },
            sigma_ca: fiber.sigma_ca.map(f64::from),
            sigma_ma: fiber.sigma_ma.map(f64::from),
            sigma_ms: fiber.sigma_ms.into(),
            g: fiber.g,
            surface,
            axes: {
                let root = f64::from(fiber.aspect_ratio).sqrt();
                [1.0 / root, root]
            },
            phi_o: 0.0,
        }
    }

    /// The same fibre, with light from the azimuth `phi_o` from the longer axis of the section, in radians.
    pub(crate) fn turned(self, phi_o: f64) -> Self {
        Tracer { phi_o, ..self }
    }

    /// A vector across the fibre over the semi-axes: the ellipse becomes the unit circle.
    fn over_axes(&self, v: [f64; 2]) -> [f64; 2] {
        [v[0] / self.axes[0], v[1] / self.axes[1]]
    }

    /// Reflectance of the cuticle, by the cosine of the angle of incidence outside.
    fn reflectance(&self, cos_outside: f64) -> f64 {
        fresnel(self.eta, self.layers, cos_outside)
    }

    /// Reflection and refraction of light with direction `d` at a facet with normal `n`.
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

    /// Light with direction `d` hits the cuticle at `p`.
    ///
    /// A rough facet is sampled again if light would hit its back, or leave to the wrong side of the smooth surface.
    /// The fibre is convex, so light does not hit two facets in sequence.
    fn cuticle(&self, p: [f64; 2], d: [f64; 3], entering: bool, rng: &mut SimRng) -> Meeting {
        let n = self.over_axes(self.over_axes(p));
        let length = n[0].hypot(n[1]);
        let p = n.map(|x| x / length);
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

    /// Traces one photon. `record` gets all light that leaves: its fate, direction and energy (RGB).
    pub(crate) fn photon(
        &self,
        theta_o: f64,
        h: f64,
        rng: &mut SimRng,
        record: &mut impl FnMut(Fate, [f64; 3], [f64; 3]),
    ) {
        self.encounters(theta_o, h, rng, &mut |fate, _, direction, energy| record(fate, direction, energy));
    }

    /// As [`Tracer::photon`]. `record` also gets how often the light met the cuticle after it was first scattered,
    /// with the encounter at which it leaves: 1 or more for [`Fate::Scattered`], 0 for light that was not scattered.
    pub(crate) fn encounters(
        &self,
        theta_o: f64,
        h: f64,
        rng: &mut SimRng,
        record: &mut impl FnMut(Fate, u32, [f64; 3], [f64; 3]),
    ) {
        // On the unit circle, the photon travels along azimuth ψ + π, and the normal at the hit has the azimuth ψ − γ.
        let (sin_o, cos_o) = self.phi_o.sin_cos();
        let toward = self.over_axes([cos_o, sin_o]);
        let psi = toward[1].atan2(toward[0]) - h.asin();
        let mut p = [self.axes[0] * psi.cos(), self.axes[1] * psi.sin()];
        let arriving = [-theta_o.sin(), -theta_o.cos() * cos_o, -theta_o.cos() * sin_o];
        // Directions are recorded relative to ω_o.
        let record = &mut |fate: Fate, encounter: u32, [x, y, z]: [f64; 3], energy: [f64; 3]| {
            record(fate, encounter, [x, y * cos_o + z * sin_o, z * cos_o - y * sin_o], energy);
        };
        // The first hit splits the energy: R is exact, and the rest enters the fibre.
        let entry = self.cuticle(p, arriving, true, rng);
        record(Fate::R, 0, entry.reflected, [entry.f; 3]);
        let start = 1.0 - entry.f;
        if start <= 0.0 {
            return;
        }
        let (mut energy, mut d) = ([start; 3], entry.refracted);
        let mut scattered = false;
        let mut encounter = 0;
        let mut pass = 1;
        loop {
            // Travels to the cuticle, with scattering in the medulla.
            let mut region = Region::Cortex;
            let missed = loop {
                match self.travel(&mut p, &mut d, &mut energy, &mut region, rng) {
                    Event::Scattered => scattered = true,
                    Event::Wall => {}
                    Event::Cuticle { missed } => break missed,
                }
            };
            let exit = self.cuticle(p, d, false, rng);
            encounter += u32::from(scattered);
            // Each hit splits the energy: one part leaves and is recorded, the other stays inside.
            let fate = match (scattered, pass) {
                (true, _) => Fate::Scattered,
                (false, 1) => Fate::Tt,
                (false, 2) => Fate::Trt,
                (false, _) => Fate::Higher,
            };
            if exit.f < 1.0 {
                record(fate, encounter, exit.refracted, energy.map(|e| e * (1.0 - exit.f)));
            }
            energy = energy.map(|e| e * exit.f);
            // After total reflection by a smooth circle, a path that misses the medulla repeats forever. The fibre
            // guides what the cortex does not absorb.
            if exit.f >= 1.0 && missed && self.surface == Surface::SMOOTH && self.axes == [1.0; 2] {
                record(
                    Fate::Guided,
                    encounter,
                    d,
                    [0, 1, 2].map(|c| if self.sigma_ca[c] == 0.0 { energy[c] } else { 0.0 }),
                );
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
            // A rough cuticle releases all light in the end, but after an unbounded number of hits.
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

    /// Light meets the wall of the medulla at `p`: it is reflected, or refracted into the other region.
    fn wall(&self, p: [f64; 2], d: &mut [f64; 3], region: &mut Region, rng: &mut SimRng) {
        let n = self.over_axes(self.over_axes(p));
        let length = n[0].hypot(n[1]);
        let inward = *region == Region::Medulla;
        let sign = if inward { -1.0 } else { 1.0 } / length;
        let n = [0.0, sign * n[0], sign * n[1]];
        let ratio = if inward { self.eta_m / self.eta } else { self.eta / self.eta_m };
        let cos = -dot(*d, n);
        let square = 1.0 - ratio * ratio * (1.0 - cos * cos);
        let along = square.max(0.0).sqrt();
        let [a, b] = [(ratio * cos, along), (cos, ratio * along)].map(|(x, y)| ((x - y) / (x + y)).powi(2));
        if square <= 0.0 || f64::from(uniform2(rng).0) < 0.5 * (a + b) {
            *d = [0, 1, 2].map(|k| d[k] + 2.0 * cos * n[k]);
            *region = if inward { Region::Medulla } else { Region::AfterMedulla };
            return;
        }
        *d = [0, 1, 2].map(|k| ratio * d[k] + (ratio * cos - along) * n[k]);
        *region = if inward { Region::AfterMedulla } else { Region::Medulla };
    }

    /// Moves the photon to the next scattering event, to the wall of a medulla of its own index, or to the cuticle,
    /// with absorption.
    fn travel(
        &self,
        p: &mut [f64; 2],
        d: &mut [f64; 3],
        energy: &mut [f64; 3],
        region: &mut Region,
        rng: &mut SimRng,
    ) -> Event {
        let ([px, py], [dx, dy]) = (self.over_axes(*p), self.over_axes([d[1], d[2]]));
        let a = (dx * dx + dy * dy).max(1e-30);
        let b = px * dx + py * dy;
        let r2 = px * px + py * py;
        let out = (-b + (b * b - a * (r2 - 1.0).min(0.0)).sqrt()) / a;
        let discriminant = b * b - a * (r2 - self.kappa * self.kappa);
        let mut attenuate = |cortex: f64, medulla: f64| {
            for c in 0..3 {
                energy[c] *= (-cortex * self.sigma_ca[c] - medulla * self.sigma_ma[c]).exp();
            }
        };
        let (enter, leave) = if self.kappa > 0.0 && discriminant > 0.0 && *region != Region::AfterMedulla {
            let root = discriminant.sqrt();
            (((-b - root) / a).max(0.0), ((-b + root) / a).max(0.0))
        } else {
            (0.0, 0.0)
        };
        let has_wall = self.eta_m != self.eta;
        if has_wall && *region == Region::Cortex && leave > 0.0 {
            attenuate(enter, 0.0);
            *p = [p[0] + enter * d[1], p[1] + enter * d[2]];
            self.wall(*p, d, region, rng);
            return Event::Wall;
        }
        let inside = leave - enter;
        if inside > 0.0 && self.sigma_ms > 0.0 {
            let free = -f64::ln(1.0 - f64::from(uniform2(rng).0)) / self.sigma_ms;
            if free < inside {
                attenuate(enter, free);
                let t = enter + free;
                *p = [p[0] + t * d[1], p[1] + t * d[2]];
                let turned: Vec3 = scatter(d.map(|x| x as f32), self.g, rng);
                *d = turned.map(f64::from);
                // `scatter` is in single precision: the length is off by 1e-7.
                let norm = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                *d = d.map(|x| x / norm);
                return Event::Scattered;
            }
        }
        if has_wall && *region == Region::Medulla {
            attenuate(0.0, leave);
            *p = [p[0] + leave * d[1], p[1] + leave * d[2]];
            self.wall(*p, d, region, rng);
            return Event::Wall;
        }
        attenuate(out - inside, inside);
        let missed = inside <= 0.0 && *region == Region::Cortex;
        let q = [p[0] + out * d[1], p[1] + out * d[2]];
        let [x, y] = self.over_axes(q);
        let radius = x.hypot(y);
        *p = q.map(|x| x / radius);
        Event::Cuticle { missed }
    }
}

/// Where a photon is. Without a wall, the cortex includes the medulla.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Region {
    Cortex,
    Medulla,
    /// On the way from the medulla to the cuticle. The section is convex.
    AfterMedulla,
}

enum Event {
    Scattered,
    /// Met the wall of the medulla.
    Wall,
    /// Reached the cuticle.
    Cuticle {
        /// Whether the path missed the medulla.
        missed: bool,
    },
}
