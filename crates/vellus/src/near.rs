//! The near field: a fibre hit at one offset, or eight such hits.

use crate::cylinder::azimuthal::wrap;
use crate::cylinder::frame::{Frame, Outgoing, Polar};
use crate::cylinder::longitudinal::Centres;
use crate::cylinder::path::{Path, Route, probabilities};
use crate::cylinder::section::Bent;
use crate::exit::diffuse;
use crate::exit::turn::Turns;
use crate::lobe::{Component, DIFFUSE, Lobe, Lobes, Sample};
use crate::medulla::{Azimuth, Inclination, Medulla};
use crate::prepared::{Prepared, Shared};
use crate::simd::lanes::{Lanes, Quad};
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use std::ops::Deref;
use wide::f32x8;

/// The light that the medulla scatters from one path.
#[derive(Clone, Copy, Debug)]
struct Scattered {
    azimuth: Azimuth,
    inclination: Inclination,
    /// False if the path misses the medulla.
    exists: bool,
    /// True if the path meets the medulla and no part of C^N is mirrored.
    plain: bool,
}

impl Scattered {
    /// The densities of TTˢ and TRTˢ if a part of C^N is mirrored. This is not inlined, because few paths are so close
    /// to the axis.
    #[cold]
    #[inline(never)]
    fn mirrored(&self, medulla: &Medulla, [theta_i, transmittance]: [f32; 2], phi: [f32; 2]) -> [f32; 2] {
        let [backward, forward] = medulla.leaving(&self.inclination, theta_i, transmittance);
        phi.map(|phi| {
            let m = backward + (forward - backward) * (phi.abs() * (1.0 / PI));
            m * medulla.azimuthal(&self.azimuth, phi)
        })
    }
}

/// One near-field hit of a fibre (`V` is `f32`), or eight hits (`V` is [`f32x8`]). It holds everything that depends
/// on ω_o and h, prepared once for all queries. `P` is the prepared fibre, or refers to it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near<P, V: Lanes = f32> {
    prepared: P,
    frame: Frame<V>,
    centres: Centres<V>,
    /// Φ of R, TT, TRT.
    exit: V::Quad,
    /// Φˢ of TTˢ, TRTˢ.
    scattered_exit: [V; 2],
    /// A(h) of each component, RGB and a spare.
    attenuation: [V::Quad; Component::COUNT],
    /// Probability of each component.
    probability: [V; Component::COUNT],
    scattered: V::PerLane<Scattered>,
    /// How the cuticle turns scattered light.
    turns: Option<Turns<V>>,
}

impl<'t, P: Deref<Target = Prepared<'t>>, V: Lanes> Near<P, V> {
    /// A hit of a round fibre. Callers send other fibres to [`Near::bent`]: a choice here would cost a copy of the hit.
    #[inline(always)]
    pub fn new(prepared: P, wo: [V; 3], h: V) -> Self {
        Self::along::<Path<V>>(prepared, wo, h)
    }

    /// A hit of a fibre whose section is no circle of one index.
    #[cold]
    #[inline(never)]
    pub fn bent(prepared: P, wo: [V; 3], h: V) -> Self {
        Self::along::<Bent<V>>(prepared, wo, h)
    }

    #[inline(always)]
    fn along<R: Route<V>>(prepared: P, wo: [V; 3], h: V) -> Self {
        let Polar { sin, cos } = Polar::new(wo);
        let toward = Frame::new(wo, cos, V::splat(1.0) / cos.max(V::splat(1e-12))).toward();
        let route = R::trace(&prepared, [sin, cos], toward, h);
        let path = route.path();
        let zero = V::splat(0.0);
        let fiber = &prepared.in_air;
        let mut paths = [0.0; 8];
        let exists = prepared.medulla.exists();
        let tau = if exists { prepared.medulla.tau_position(path.elongation) } else { zero };
        let scattered = V::per_lane(
            #[inline(always)]
            |i| {
                if exists && path.h_inside.lane(i).abs() < fiber.kappa {
                    let pass = prepared.medulla.pass(tau.lane(i));
                    let angle = path.gamma_m.lane(i);
                    if prepared.reflection.is_none() {
                        paths[i] = prepared.medulla.mean_path_of(&pass, angle);
                    }
                    let inclination = prepared.medulla.inclination(path.theta.lane(i));
                    let azimuth = prepared.medulla.azimuth_leaving(&pass, angle, inclination.leaving);
                    Scattered { azimuth, inclination, exists: true, plain: azimuth.turned == 0.0 }
                } else {
                    Scattered { azimuth: Azimuth::NONE, inclination: Inclination::NONE, exists: false, plain: false }
                }
            },
        );
        let entry = prepared.reflection.as_ref().map(|reflection| reflection.at(path.sin2_t));
        let attenuation = route.attenuation(fiber, V::from_lanes(&paths), entry.as_ref());
        let centres = prepared.longitudinal.centres(sin, cos);
        let turns = prepared.turning.as_ref().map(|turning| turning.all(cos, h, &route));
        let shift = turns.as_ref().map_or(zero, |(_, [shift, _])| *shift);
        Near {
            prepared,
            turns: turns.map(|(turns, _)| turns),
            frame: Frame::new(wo, cos, path.inverse_cos_o),
            centres,
            exit: V::Quad::new([route.exit_azimuth(0), route.exit_azimuth(1), route.exit_azimuth(2), zero]),
            scattered_exit: [route.scattered_azimuth(1) + shift, route.scattered_azimuth(2) + shift],
            attenuation,
            probability: probabilities(&attenuation),
            scattered,
        }
    }

    /// A(h) of each lobe.
    pub fn energy(&self) -> Lobes<V> {
        self.lobes(&[V::splat(1.0); Component::COUNT])
    }

    pub fn lobe_probabilities(&self) -> [V; Lobe::COUNT] {
        let mut lobes: [V; Lobe::COUNT] = std::array::from_fn(|p| self.probability[p]);
        lobes[Lobe::Rest as usize] = lobes[Lobe::Rest as usize] + self.probability[DIFFUSE];
        lobes
    }

    /// A direction in the form that the lobes use, with the cosine and the sine of φ.
    #[inline(always)]
    fn outgoing(&self, wi: [V; 3]) -> (Outgoing<V>, [V; 2]) {
        self.frame.refracted(wi, &self.prepared.medulla.refraction)
    }

    /// The densities of the components over solid angle.
    #[inline(always)]
    fn densities(&self, (o, around): &(Outgoing<V>, [V; 2])) -> [V; Component::COUNT] {
        let m = self.prepared.longitudinal.eval(&self.centres, o.sin_i, o.cos_i);
        let n = self.prepared.azimuthal.eval(self.exit, o.phi);
        let [r, tt, trt, rest] = (m * n).array();
        let zero = V::splat(0.0);
        let mut d = [r, tt, trt, zero, zero, rest, diffuse::density(o.cos_i)];
        if self.prepared.medulla.exists() {
            let mut phi = [o.phi - self.scattered_exit[0], o.phi - self.scattered_exit[1]];
            let mut slopes = None;
            if let Some(turns) = &self.turns {
                let [one, two] = [turns.first[0].inverse(*around), turns.first[1].inverse(*around)];
                let [first, second] = V::atan2_pair([one[1], two[1]], [one[0], two[0]]);
                phi = [phi[0] + first + first, phi[1] + second + second];
                slopes = Some([turns.first[0].slope(one), turns.first[1].slope(two)]);
                d[DIFFUSE] = d[DIFFUSE] * turns.later.of_uniform(*around);
            }
            let phi = phi.map(wrap);
            let mut lanes = [[0.0f32; 8]; 2];
            let medulla = &self.prepared.medulla;
            let transmittance = medulla.transmittance(o.sin_i);
            for (i, s) in self.scattered.as_ref().iter().enumerate() {
                let (theta_i, transmittance) = (o.theta_i.lane(i), transmittance.lane(i));
                if !s.plain {
                    if s.exists {
                        let phi = phi.map(|phi| phi.lane(i));
                        [lanes[0][i], lanes[1][i]] = s.mirrored(medulla, [theta_i, transmittance], phi);
                    }
                    continue;
                }
                let [backward, forward] = medulla.leaving(&s.inclination, theta_i, transmittance);
                for p in 0..2 {
                    let phi = phi[p].lane(i);
                    let m = backward + (forward - backward) * (phi.abs() * (1.0 / PI));
                    lanes[p][i] = m * medulla.azimuthal_plain(&s.azimuth, phi);
                }
            }
            let [first, second] = Component::SCATTERED.map(|component| component as usize);
            (d[first], d[second]) = (V::from_lanes(&lanes[0]), V::from_lanes(&lanes[1]));
            if let Some(slopes) = slopes {
                (d[first], d[second]) = (d[first] * slopes[0], d[second] * slopes[1]);
            }
        }
        d
    }

    #[inline(always)]
    fn lobes(&self, densities: &[V; Component::COUNT]) -> Lobes<V> {
        let mut lobes = [[densities[0]; 3]; Lobe::COUNT];
        for (p, lobe) in lobes.iter_mut().enumerate() {
            let mut light = self.attenuation[p] * V::Quad::splat(densities[p]);
            if p == Lobe::Rest as usize {
                light = light + self.attenuation[DIFFUSE] * V::Quad::splat(densities[DIFFUSE]);
            }
            let [r, g, b, _] = light.array();
            *lobe = [r, g, b];
        }
        Lobes(lobes)
    }

    #[inline(always)]
    fn total(&self, densities: &[V; Component::COUNT]) -> [V; 3] {
        let mut sum = V::Quad::splat(V::splat(0.0));
        for (a, d) in self.attenuation.iter().zip(densities) {
            sum = sum + *a * V::Quad::splat(*d);
        }
        let [r, g, b, _] = sum.array();
        [r, g, b]
    }

    #[inline(always)]
    fn density(&self, densities: &[V; Component::COUNT]) -> V {
        let mut sum = V::splat(0.0);
        for (p, d) in self.probability.iter().zip(densities) {
            sum = sum + *p * *d;
        }
        sum
    }

    /// f·cos θᵢ of each lobe and pdf(ω_i).
    #[inline(always)]
    fn query(&self, wi: [V; 3]) -> (Lobes<V>, V) {
        let d = self.densities(&self.outgoing(wi));
        (self.lobes(&d), self.density(&d))
    }
}

/// ω_i with its density and weight: one, or eight.
struct Drawn<V: Lanes> {
    wi: [V; 3],
    pdf: V,
    weight: [V; 3],
}

impl<'t, P: Deref<Target = Prepared<'t>>, V: Lanes> Near<P, V> {
    /// The lobe that `u` in [0, 1) selects.
    #[inline(always)]
    fn choose_lobe(&self, lane: usize, u: f32) -> Lobe {
        Lobe::choose(self.lobe_probabilities().map(|p| p.lane(lane)), u)
    }

    /// Draws sin θᵢ, cos θᵢ and φ from one lobe. `u`: two uniform numbers for the longitudinal lobe, and one for the
    /// azimuth.
    #[inline(always)]
    fn draw(&self, lane: usize, lobe: Lobe, u: [f32; 3]) -> (f32, f32, f32) {
        let prepared = &*self.prepared;
        let unscattered = |p: usize| prepared.longitudinal.sample(self.centres.lane(p, lane), p, [u[0], u[1]]);
        let scattered = |p: usize| {
            let s = &self.scattered.as_ref()[lane];
            if !s.exists {
                // `sample` never selects this lobe, because it carries no energy. The result is that of R.
                return (unscattered(0), 0.0);
            }
            let Azimuth { weights, turned, mirror, .. } = &s.azimuth;
            let (inclination, relative) = prepared.medulla.sample_leaving(weights, *turned, &s.inclination, u);
            let psi = mirror * relative + self.scattered_exit[p - 1].lane(lane);
            (inclination, self.turns.as_ref().map_or(psi, |turns| turns.first[p - 1].leaving(lane, psi)))
        };
        let ((sin_i, cos_i), phi) = match lobe {
            Lobe::R | Lobe::Tt | Lobe::Trt => {
                let p = lobe as usize;
                (unscattered(p), prepared.azimuthal.sample(self.exit.array()[p].lane(lane), p, u[2]))
            }
            Lobe::Tts => scattered(1),
            Lobe::Trts => scattered(2),
            Lobe::Rest => {
                let parts = [DIFFUSE, Lobe::Rest as usize].map(|p| self.probability[p].lane(lane));
                let (is_diffuse, u2) = diffuse::choose(parts, u[2]);
                let even = TAU * u2;
                match &self.turns {
                    Some(turns) if is_diffuse => (diffuse::sample([u[0], u[1]]), turns.later.leaving(lane, even)),
                    _ if is_diffuse => (diffuse::sample([u[0], u[1]]), even),
                    _ => (unscattered(3), even),
                }
            }
        };
        (sin_i, cos_i.max(0.0), phi)
    }

    /// The direction of a sample, with the density and weight of all lobes together.
    #[inline(always)]
    fn complete(&self, sin_i: V, cos_i: V, phi: V, (sin_phi, cos_phi): (V, V)) -> Drawn<V> {
        let wi = self.frame.direction(sin_i, cos_i, (sin_phi, cos_phi));
        let (sin, cos) = self.prepared.medulla.refraction.inside(sin_i, cos_i * cos_i);
        let [theta_i, _] = V::atan2_pair([sin, V::splat(0.0)], [cos, V::splat(1.0)]);
        let d = self.densities(&(Outgoing { sin_i, cos_i, theta_i, phi }, [cos_phi, sin_phi]));
        let pdf = self.density(&d);
        // 0/0 if the density underflows: the weight is then 0.
        let inverse = V::splat(1.0) / pdf.max(V::splat(f32::MIN_POSITIVE));
        Drawn { wi, pdf, weight: self.total(&d).map(|f| f * inverse) }
    }
}

impl<'t, P: Deref<Target = Prepared<'t>>> Near<P, f32x8> {
    #[inline]
    pub fn eval_pdf8(&self, wi: [f32x8; 3]) -> (Lobes<f32x8>, f32x8) {
        self.query(wi)
    }

    pub fn sample8(&self, u: [f32x8; 4]) -> [Option<Sample>; 8] {
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
        std::array::from_fn(|i| {
            let wi = Vec3::new(wi[0][i], wi[1][i], wi[2][i]);
            Sample::new(wi, pdf[i], weight.map(|w| w[i]), lobes[i])
        })
    }
}

impl<'t, P: Deref<Target = Prepared<'t>>> Near<P, f32> {
    /// The same hit in all eight lanes.
    pub fn repeated(&self) -> Near<&Prepared<'t>, f32x8> {
        let splat = f32x8::splat;
        let [scattered] = self.scattered;
        Near {
            prepared: &*self.prepared,
            frame: self.frame.repeated(),
            centres: self.centres.repeated(),
            exit: Quad::new(self.exit.to_array().map(splat)),
            scattered_exit: self.scattered_exit.map(splat),
            attenuation: self.attenuation.map(|a| Quad::new(a.to_array().map(splat))),
            probability: self.probability.map(splat),
            scattered: [scattered; 8],
            turns: self.turns.as_ref().map(Turns::repeated),
        }
    }

    #[inline]
    pub fn eval(&self, wi: Vec3) -> Lobes {
        self.lobes(&self.densities(&self.outgoing(wi.to_array())))
    }

    /// N(φ) of each lobe, RGB.
    pub fn azimuthal_lobes(&self, phi: f32) -> Lobes {
        let [r, tt, trt, rest] = self.prepared.azimuthal.eval(self.exit, phi).to_array();
        let [s] = &self.scattered;
        let [tts, trts] = [0, 1].map(|q| {
            let (phi, slope) = self.inside(q, phi);
            let [backward, forward] = s.inclination.leaving;
            let leaving = backward + (forward - backward) * (phi.abs() * (1.0 / PI));
            if s.exists { slope * leaving * self.prepared.medulla.azimuthal(&s.azimuth, phi) } else { 0.0 }
        });
        let later = self.turns.as_ref().map_or(1.0, |turns| turns.later.of_uniform([phi.cos(), phi.sin()]));
        self.lobes(&[r, tt, trt, tts, trts, rest, later / TAU])
    }

    /// The azimuth from straight back of light of TTˢ (`q` = 0) or TRTˢ (`q` = 1) that leaves at φ, in [−π, π], and how
    /// much it changes with φ.
    fn inside(&self, q: usize, phi: f32) -> (f32, f32) {
        let relative = phi - self.scattered_exit[q];
        match &self.turns {
            Some(turns) => {
                let inverse = turns.first[q].inverse([phi.cos(), phi.sin()]);
                (wrap(relative + 2.0 * inverse[1].atan2(inverse[0])), turns.first[q].slope(inverse))
            }
            None => (wrap(relative), 1.0),
        }
    }

    /// The mean of cos φ over each lobe.
    pub fn mean_cosines(&self) -> [f32; Lobe::COUNT] {
        let sigma = self.prepared.azimuthal.sigma;
        let exit = self.exit.to_array();
        let specular = |p: usize| exit[p].cos() * (-0.5 * sigma[p] * sigma[p]).exp();
        let [s] = &self.scattered;
        let scattered = |q: usize| {
            if !s.exists {
                return 0.0;
            }
            // The light that a medulla scatters has no narrow peaks, except forward.
            const POINTS: u8 = 32;
            let mut sums = [0.0; 2];
            for i in 0..POINTS {
                let phi = TAU * (f32::from(i) + 0.5) / f32::from(POINTS) - PI;
                let (inside, slope) = self.inside(q, phi);
                let density = slope * self.prepared.medulla.azimuthal(&s.azimuth, inside);
                sums = [sums[0] + density, sums[1] + density * phi.cos()];
            }
            sums[1] / sums[0].max(f32::MIN_POSITIVE)
        };
        let [later, even] = [DIFFUSE, Lobe::Rest as usize].map(|p| self.probability[p]);
        let stays = self.turns.as_ref().map_or(0.0, |turns| -turns.later.a[0]);
        let residual = stays * later / (later + even).max(f32::MIN_POSITIVE);
        [specular(0), specular(1), specular(2), scattered(0), scattered(1), residual]
    }

    #[inline]
    pub fn pdf(&self, wi: Vec3) -> f32 {
        self.density(&self.densities(&self.outgoing(wi.to_array())))
    }

    #[inline]
    pub fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        self.query(wi.to_array())
    }

    /// `u`: the first four numbers of [`Hit::sample`](crate::Hit::sample).
    #[inline]
    pub fn sample(&self, u: [f32; 4]) -> Option<Sample> {
        let lobe = self.choose_lobe(0, u[0]);
        let (sin_i, cos_i, phi) = self.draw(0, lobe, [u[1], u[2], u[3]]);
        let Drawn { wi, pdf, weight } = self.complete(sin_i, cos_i, phi, phi.sin_cos());
        Sample::new(Vec3::from_array(wi), pdf, weight, lobe)
    }
}

/// Eight near-field hits of a fibre, from [`Bcsdf::at8`](crate::Bcsdf::at8).
#[derive(Clone, Copy, Debug)]
pub struct NearHit<'b>(pub(crate) Near<Shared<'b>, f32x8>);

impl NearHit<'_> {
    /// A(h), the share of the light that each lobe carries, RGB, in [0, 1]: the integral of f·cos θᵢ over all ω_i.
    #[doc(alias = "Table 3")]
    pub fn energy(&self) -> Lobes<f32x8> {
        self.0.energy()
    }

    /// The probability with which sampling chooses each lobe, in the order of [`Lobe`].
    pub fn lobe_probabilities(&self) -> [f32x8; Lobe::COUNT] {
        self.0.lobe_probabilities()
    }

    /// f·cos θᵢ of each lobe and the density per solid angle, for eight hits with one direction each. `wi`: the x, y
    /// and z of eight unit vectors.
    #[inline]
    pub fn eval_pdf8(&self, wi: [f32x8; 3]) -> (Lobes<f32x8>, f32x8) {
        self.0.eval_pdf8(wi)
    }

    /// Draws a direction for each of the eight hits, like [`Hit::sample`](crate::Hit::sample). `u`: the four uniform
    /// numbers of eight samples. No channel of the weight is above Σ max(A) ≤ 1.
    pub fn sample8(&self, u: [f32x8; 4]) -> [Option<Sample>; 8] {
        self.0.sample8(u)
    }
}
