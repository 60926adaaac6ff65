//! The six lobes together: f(ω_o, ω_i)·cos θᵢ of a fibre hit at an offset h.

use crate::azimuthal::{Azimuthal, wrap};
use crate::error::Error;
use crate::fiber::Fiber;
use crate::lanes::{Lanes, Quad};
use crate::longitudinal::{Centres, Longitudinal};
use crate::medulla::{Medulla, Scattered};
use crate::path::Path;
use crate::tables::Tables;
use crate::window::Window;
use glam::Vec3;
use std::f32::consts::{PI, TAU};
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
    /// Density per solid angle of drawing `wi`, whatever lobe it came from.
    pub pdf: f32,
    /// f·cos θᵢ/pdf, RGB. No channel is ever above Σ max(A) ≤ 1.
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
    fiber: Fiber,
    longitudinal: Longitudinal,
    azimuthal: Azimuthal,
    medulla: Medulla<'t>,
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
        })
    }

    /// The fibre.
    pub fn fiber(&self) -> &Fiber {
        &self.fiber
    }

    /// Prepares all that depends on ω_o and the window.
    ///
    /// `wo` points away from the fibre, toward where the path came from, in the fibre's frame:
    /// x runs along the fibre from root to tip. It must have unit length.
    #[inline]
    pub fn at(&self, wo: Vec3, window: Window) -> Hit<'_, f32> {
        debug_assert!((wo.length_squared() - 1.0).abs() < 1e-3, "wo is not a unit vector: {wo}");
        Hit::new(self, wo.to_array(), window.h)
    }

    /// Eight hits of the near field at once: components of ω_o, and h in [−1, 1].
    #[inline]
    pub fn at8(&self, wo: [f32x8; 3], h: f32x8) -> Hit<'_, f32x8> {
        Hit::new(self, wo, h)
    }
}

/// One hit of a fibre, or eight: all that depends on ω_o and h, prepared once for all its queries.
#[derive(Clone, Copy, Debug)]
pub struct Hit<'b, V: Lanes = f32> {
    bcsdf: &'b Bcsdf<'b>,
    /// cos and sin of φ_o.
    frame: [V; 2],
    centres: Centres<V>,
    /// Φ of R, TT, TRT.
    exit: V::Quad,
    /// Φˢ of TTˢ, TRTˢ.
    scattered_exit: [V; 2],
    /// A(h), RGB and a spare.
    attenuation: [V::Quad; 6],
    /// Probability of each lobe.
    probability: [V; 6],
    scattered: V::PerLane<Scattered>,
}

/// ω_i as the lobes want it.
#[derive(Clone, Copy)]
struct Outgoing<V> {
    sin_i: V,
    cos_i: V,
    theta_i: V,
    /// φ_i − φ_o
    phi: V,
}

impl<'b, V: Lanes> Hit<'b, V> {
    #[inline(always)]
    fn new(bcsdf: &'b Bcsdf<'b>, [x, y, z]: [V; 3], h: V) -> Self {
        let (zero, one) = (V::splat(0.0), V::splat(1.0));
        let fiber = &bcsdf.fiber;
        let sin_o = x.max(-one).min(one);
        let cos_o = (y * y + z * z).sqrt();
        // Along the axis the azimuth is arbitrary.
        let tiny = V::splat(1e-12);
        let path = Path::new(fiber, sin_o, cos_o, h);
        let inverse = path.inverse_cos_o;
        let mut paths = [0.0; 8];
        let exists = bcsdf.medulla.exists();
        let tau = if exists { bcsdf.medulla.tau_position(path.elongation) } else { zero };
        let scattered = V::per_lane(
            #[inline(always)]
            |i| {
                if exists && path.h_inside.lane(i).abs() < fiber.kappa {
                    let (scattered, mean_path) =
                        bcsdf.medulla.at(tau.lane(i), path.gamma_m.lane(i), path.theta_o.lane(i));
                    paths[i] = mean_path;
                    scattered
                } else {
                    Scattered::NONE
                }
            },
        );
        let attenuation = path.attenuation(fiber, V::from_lanes(&paths));
        // By the largest channel: then no channel of a sample's weight exceeds the sum of these,
        // and that sum is at most 1.
        let mut probability = [zero; 6];
        let mut sum = V::splat(f32::MIN_POSITIVE);
        for (p, a) in probability.iter_mut().zip(&attenuation) {
            let [r, g, b, _] = a.array();
            *p = r.max(g).max(b);
            sum = sum + *p;
        }
        let inverse_sum = one / sum;
        for p in &mut probability {
            *p = *p * inverse_sum;
        }
        Hit {
            bcsdf,
            frame: [cos_o.select_lt(tiny, one, y * inverse), cos_o.select_lt(tiny, zero, z * inverse)],
            centres: bcsdf.longitudinal.centres(sin_o, cos_o),
            exit: V::Quad::new([path.exit_azimuth(0), path.exit_azimuth(1), path.exit_azimuth(2), zero]),
            scattered_exit: [path.scattered_azimuth(1), path.scattered_azimuth(2)],
            attenuation,
            probability,
            scattered,
        }
    }

    /// A(h), the energy each lobe carries, RGB: the integral of f·cos θᵢ over all ω_i.
    #[doc(alias = "Table 3")]
    pub fn energy(&self) -> Lobes<V> {
        self.lobes(&[V::splat(1.0); 6])
    }

    /// The probability with which sampling chooses each lobe, in the order of [`Lobe`].
    pub fn lobe_probabilities(&self) -> [V; 6] {
        self.probability
    }

    #[inline(always)]
    fn outgoing(&self, [x, y, z]: [V; 3]) -> Outgoing<V> {
        let [c, s] = self.frame;
        let cos_i = (y * y + z * z).sqrt();
        let [phi, theta_i] = V::atan2_pair([z * c - y * s, x], [y * c + z * s, cos_i]);
        Outgoing { sin_i: x, cos_i, theta_i, phi }
    }

    /// The densities of the six lobes over solid angle.
    #[inline(always)]
    fn densities(&self, o: &Outgoing<V>) -> [V; 6] {
        let m = self.bcsdf.longitudinal.eval(&self.centres, o.sin_i, o.cos_i);
        let n = self.bcsdf.azimuthal.eval(self.exit, o.phi);
        let [r, tt, trt, rest] = (m * n).array();
        let mut d = [r, tt, trt, V::splat(0.0), V::splat(0.0), rest];
        if self.bcsdf.medulla.exists() {
            let phi = [wrap(o.phi - self.scattered_exit[0]), wrap(o.phi - self.scattered_exit[1])];
            let mut lanes = [[0.0f32; 8]; 2];
            let medulla = &self.bcsdf.medulla;
            for (i, s) in self.scattered.as_ref().iter().enumerate() {
                if !s.exists {
                    continue;
                }
                let [backward, forward] = medulla.longitudinal(s, o.theta_i.lane(i));
                for p in 0..2 {
                    let phi = phi[p].lane(i);
                    let m = backward + (forward - backward) * (phi.abs() * (1.0 / PI));
                    lanes[p][i] = m * medulla.azimuthal(s, phi);
                }
            }
            d[3] = V::from_lanes(&lanes[0]);
            d[4] = V::from_lanes(&lanes[1]);
        }
        d
    }

    #[inline(always)]
    fn lobes(&self, densities: &[V; 6]) -> Lobes<V> {
        let mut lobes = [[densities[0]; 3]; 6];
        for ((lobe, a), d) in lobes.iter_mut().zip(&self.attenuation).zip(densities) {
            let [r, g, b, _] = (*a * V::Quad::splat(*d)).array();
            *lobe = [r, g, b];
        }
        Lobes(lobes)
    }

    #[inline(always)]
    fn total(&self, densities: &[V; 6]) -> [V; 3] {
        let mut sum = V::Quad::splat(V::splat(0.0));
        for (a, d) in self.attenuation.iter().zip(densities) {
            sum = sum + *a * V::Quad::splat(*d);
        }
        let [r, g, b, _] = sum.array();
        [r, g, b]
    }

    #[inline(always)]
    fn density(&self, densities: &[V; 6]) -> V {
        let mut sum = V::splat(0.0);
        for (p, d) in self.probability.iter().zip(densities) {
            sum = sum + *p * *d;
        }
        sum
    }

    /// f·cos θᵢ of each lobe and pdf(ω_i), for the price of little more than one of them; the
    /// components of ω_i, each one number or eight.
    #[inline]
    pub fn eval_pdf_lanes(&self, wi: [V; 3]) -> (Lobes<V>, V) {
        let d = self.densities(&self.outgoing(wi));
        (self.lobes(&d), self.density(&d))
    }
}

/// ω_i, its density and weight; one of each or eight.
struct Drawn<V: Lanes> {
    wi: [V; 3],
    pdf: V,
    weight: [V; 3],
}

impl<V: Lanes> Hit<'_, V> {
    /// The lobe that `u` in [0, 1) falls to.
    #[inline(always)]
    fn choose_lobe(&self, lane: usize, u: f32) -> Lobe {
        let mut rest = u;
        let mut chosen = Lobe::R;
        for lobe in Lobe::ALL {
            let p = self.probability[lobe as usize].lane(lane);
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

    /// Draws sin θᵢ, cos θᵢ and φ from one lobe. `u`: two uniform numbers for the longitudinal lobe, one
    /// for the azimuth.
    #[inline(always)]
    fn draw(&self, lane: usize, lobe: Lobe, u: [f32; 3]) -> (f32, f32, f32) {
        let model = self.bcsdf;
        let unscattered = |p: usize| model.longitudinal.sample(self.centres.lane(p, lane), p, [u[0], u[1]]);
        let scattered = |p: usize| {
            let s = &self.scattered.as_ref()[lane];
            if !s.exists {
                // Not drawn by `sample`: the lobe carries no energy. R stands in.
                return (unscattered(0), 0.0);
            }
            let relative = model.medulla.sample_azimuth(s, u[2]);
            let theta = model.medulla.sample_inclination(s, wrap(relative), [u[0], u[1]]);
            (theta.sin_cos(), relative + self.scattered_exit[p - 1].lane(lane))
        };
        let ((sin_i, cos_i), phi) = match lobe {
            Lobe::R | Lobe::Tt | Lobe::Trt => {
                let p = lobe as usize;
                (unscattered(p), model.azimuthal.sample(self.exit.array()[p].lane(lane), p, u[2]))
            }
            Lobe::Tts => scattered(1),
            Lobe::Trts => scattered(2),
            Lobe::Rest => (unscattered(3), TAU * u[2]),
        };
        (sin_i, cos_i.max(0.0), phi)
    }

    /// Completes what was drawn: direction, and pdf and weight of all lobes together.
    #[inline(always)]
    fn complete(&self, sin_i: V, cos_i: V, phi: V, (sin_phi, cos_phi): (V, V)) -> Drawn<V> {
        let [c, s] = self.frame;
        let wi = [sin_i, cos_i * (cos_phi * c - sin_phi * s), cos_i * (sin_phi * c + cos_phi * s)];
        let [theta_i, _] = V::atan2_pair([sin_i, V::splat(0.0)], [cos_i, V::splat(1.0)]);
        let d = self.densities(&Outgoing { sin_i, cos_i, theta_i, phi });
        let pdf = self.density(&d);
        // 0/0 where the density underflows: the weight is then 0.
        let inverse = V::splat(1.0) / pdf.max(V::splat(f32::MIN_POSITIVE));
        Drawn { wi, pdf, weight: self.total(&d).map(|f| f * inverse) }
    }
}

impl Hit<'_, f32x8> {
    /// Draws eight directions. `u`: as for [`Hit::sample`] of one hit, eight of each.
    pub fn sample8(&self, u: [f32x8; 4]) -> [Sample; 8] {
        let u = u.map(f32x8::to_array);
        let (mut sin_i, mut cos_i, mut phi) = ([0.0; 8], [0.0; 8], [0.0; 8]);
        let (mut sin_phi, mut cos_phi) = ([0.0; 8], [0.0; 8]);
        let mut lobes = [Lobe::R; 8];
        for i in 0..8 {
            lobes[i] = self.choose_lobe(i, u[0][i]);
            (sin_i[i], cos_i[i], phi[i]) = self.draw(i, lobes[i], [u[1][i], u[2][i], u[3][i]]);
            (sin_phi[i], cos_phi[i]) = phi[i].sin_cos();
        }
        let pack = f32x8::new;
        let drawn = self.complete(pack(sin_i), pack(cos_i), pack(phi), (pack(sin_phi), pack(cos_phi)));
        let (wi, pdf, weight) =
            (drawn.wi.map(f32x8::to_array), drawn.pdf.to_array(), drawn.weight.map(f32x8::to_array));
        std::array::from_fn(|i| Sample {
            wi: Vec3::new(wi[0][i], wi[1][i], wi[2][i]),
            pdf: pdf[i],
            weight: weight.map(|w| w[i]),
            lobe: lobes[i],
        })
    }
}

impl Hit<'_, f32> {
    /// f(ω_o, ω_i)·cos θᵢ of each lobe, RGB. `wi` points away from the fibre, toward the light, and
    /// has unit length. Light reaches a fibre from the whole sphere: no half of it is excluded.
    #[inline]
    pub fn eval(&self, wi: Vec3) -> Lobes {
        self.lobes(&self.densities(&self.outgoing(wi.to_array())))
    }

    /// The density per solid angle with which [`Hit::sample`] draws `wi`.
    #[inline]
    pub fn pdf(&self, wi: Vec3) -> f32 {
        self.density(&self.densities(&self.outgoing(wi.to_array())))
    }

    /// [`Hit::eval`] and [`Hit::pdf`] together.
    #[inline]
    pub fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        self.eval_pdf_lanes(wi.to_array())
    }

    /// Draws ω_i. `u`: four uniform numbers in [0, 1): the lobe, two for the longitudinal lobe, one
    /// for the azimuth.
    #[inline]
    pub fn sample(&self, u: [f32; 4]) -> Sample {
        self.sample_lobe(self.choose_lobe(0, u[0]), [u[1], u[2], u[3]])
    }

    /// Draws ω_i from one lobe; pdf and weight are still those of all of them. `u`: two uniform
    /// numbers for the longitudinal lobe and one for the azimuth.
    pub fn sample_lobe(&self, lobe: Lobe, u: [f32; 3]) -> Sample {
        let (sin_i, cos_i, phi) = self.draw(0, lobe, u);
        let Drawn { wi, pdf, weight } = self.complete(sin_i, cos_i, phi, phi.sin_cos());
        Sample { wi: Vec3::from_array(wi), pdf, weight, lobe }
    }
}
