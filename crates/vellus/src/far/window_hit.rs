//! A hit averaged over a window of offsets: the far field and the multi-scale mode (Yan17 Sec. 5).

use crate::cylinder::frame::{Frame, Outgoing, Polar};
use crate::cylinder::longitudinal::Centres;
use crate::cylinder::path::{Path, Route, inverse_eta};
use crate::cylinder::section::Bent;
use crate::exit::diffuse;
use crate::exit::turn::Turn;
use crate::far::nodes::{Nodes, PIECES, Piece, divide};
use crate::far::points::Points;
use crate::far::segments::{self, Half, Through};
use crate::lobe::{Component, DIFFUSE, Lobe, Lobes, Sample};
use crate::medulla::Inclination;
use crate::prepared::Prepared;
use crate::simd::lanes::{Lanes, Quad};
use glam::Vec3;
use std::f32::consts::TAU;
use std::ops::Deref;
use wide::{f32x4, f32x8};

/// Everything that depends on ω_o and the window.
#[derive(Clone, Debug)]
pub(crate) struct WindowState {
    wo: [f32; 3],
    range: [f32; 2],
    frame: Frame<f32>,
    centres: Centres<f32>,
    inclination: Inclination,
    /// A of the components, RGB and the largest channel, averaged over the window.
    energy: [f32x4; Component::COUNT],
    /// 1 over the sum of the largest channels, which sampling uses.
    inverse: f32,
    halves: [Option<Half>; PIECES],
    points: Points,
    /// Where light leaves that the cuticle reflected before.
    later: Turn<f32>,
}

impl WindowState {
    #[inline(always)]
    pub fn new(prepared: &Prepared, wo: [f32; 3], range: [f32; 2]) -> Self {
        let polar = Polar::new(wo);
        WindowState {
            wo,
            range,
            frame: Frame::new(wo, polar.cos, 1.0 / polar.cos.max(1e-12)),
            centres: prepared.longitudinal.centres(polar.sin, polar.cos),
            inclination: Inclination::NONE,
            energy: [f32x4::ZERO; Component::COUNT],
            inverse: 0.0,
            halves: [None; PIECES],
            points: Points::none(),
            later: Turn::none(),
        }
    }

    /// Prepares large parts in place.
    pub fn prepare(&mut self, prepared: &Prepared) {
        match prepared.section {
            None => self.prepare_along::<Path<f32x8>>(prepared),
            Some(_) => self.prepare_along::<Bent<f32x8>>(prepared),
        }
    }

    #[inline(never)]
    fn prepare_along<R: Route<f32x8>>(&mut self, prepared: &Prepared) {
        let fiber = &prepared.in_air;
        let polar = Polar::new(self.wo);
        let [cos_phi, sin_phi] = self.frame.toward();
        // The second side is mirrored.
        let toward = [[cos_phi, sin_phi], [cos_phi, -sin_phi]];
        let edge = |side: usize| match &prepared.section {
            Some(section) => section.edge(fiber, [polar.sin, polar.cos], toward[side]),
            None => Some(fiber.kappa / inverse_eta(fiber.eta, polar.cos)),
        };
        let edges = [0, 1].map(|side| if fiber.kappa > 0.0 { edge(side) } else { None });
        let through = prepared.medulla.exists().then(|| {
            let (sin, cos) = prepared.medulla.refraction.inside(polar.sin, polar.cos * polar.cos);
            self.inclination = prepared.medulla.inclination(sin.atan2(cos));
            let sin_t = polar.sin / fiber.medulla_eta();
            let elongation = 1.0 / ((1.0 - sin_t) * (1.0 + sin_t)).max(1e-12).sqrt();
            let pass = prepared.medulla.pass(prepared.medulla.tau_position(elongation));
            let mean_paths = prepared.medulla.mean_paths(&pass);
            let entry = prepared.reflection.as_ref().map(|reflection| reflection.at(sin_t * sin_t).repeated());
            Through { pass, mean_paths, entry, leaving: self.inclination.leaving }
        });
        let [low, high] = self.range;
        let symmetric = low == -high && !prepared.is_flat();
        let signs: [&[f32]; 2] = [if symmetric { &[1.0, -1.0] } else { &[1.0] }, &[-1.0]];
        // The offsets ≥ 0, and the offsets ≤ 0, which are mirrored.
        let sides = [[low.max(0.0), high], if symmetric { [0.0; 2] } else { [(-high).max(0.0), -low] }];
        let (mut pieces, mut whole) = ([None; PIECES], [None; 2]);
        let ranges = sides.into_iter().enumerate().filter(|(_, [low, high])| high > low);
        for (piece, (side, range)) in pieces.iter_mut().zip(ranges) {
            let nodes = Nodes::new(range[0], range[1], edges[side]);
            whole[side] = nodes.medulla;
            *piece = Some(Piece { side, range, nodes });
        }
        if prepared.fine {
            divide(&mut pieces, edges);
        }
        let width: f32 = pieces.iter().flatten().map(|piece| piece.nodes.width()).sum();
        let times = if symmetric { 2.0 } else { 1.0 };
        let scale = 1.0 / (times * width).max(f32::MIN_POSITIVE);
        let mut late = [0.0; 2];
        for (Piece { side, nodes, .. }, half) in pieces.iter().flatten().zip(&mut self.halves) {
            let half = half.insert(Half::NONE);
            let arriving = (polar, toward[*side]);
            let (energy, [along, across]) =
                half.prepare::<R>(prepared, arriving, through.as_ref(), nodes, signs[*side], scale);
            late = [late[0] + along, late[1] + signs[*side].iter().sum::<f32>() * across];
            (0..Component::COUNT).for_each(|p| self.energy[p] += energy[p]);
        }
        if symmetric {
            self.energy = self.energy.map(|e| e + e);
            late[0] *= 2.0;
        }
        let light = self.energy[DIFFUSE].to_array()[3].max(f32::MIN_POSITIVE);
        self.later = Turn { a: late.map(|x| -x / light) };
        if let Some(through) = &through {
            let both = [whole[0], whole[usize::from(!symmetric)]];
            let [first, second] = Component::SCATTERED.map(|component| component as usize);
            let scattered = [self.energy[first], self.energy[second]];
            [self.energy[first], self.energy[second]] =
                self.points.prepare::<R>(prepared, (polar, toward), through, both, scattered);
        }
        self.inverse = 1.0 / sum(&self.lobe_energies()).to_array()[3].max(f32::MIN_POSITIVE);
    }

    /// A of the six lobes.
    #[inline(always)]
    fn lobe_energies(&self) -> [f32x4; Lobe::COUNT] {
        let mut lobes = [f32x4::ZERO; Lobe::COUNT];
        (0..Lobe::COUNT).for_each(|p| lobes[p] = self.energy[p]);
        lobes[Lobe::Rest as usize] += self.energy[DIFFUSE];
        lobes
    }
}

/// A hit that is prepared, with its fibre: what queries need, wherever it is stored.
#[derive(Clone, Copy)]
pub(crate) struct WindowHit<'a> {
    prepared: &'a Prepared<'a>,
    state: &'a WindowState,
}

impl Deref for WindowHit<'_> {
    type Target = WindowState;

    #[inline(always)]
    fn deref(&self) -> &WindowState {
        self.state
    }
}

impl<'a> WindowHit<'a> {
    #[inline(always)]
    pub fn new(prepared: &'a Prepared<'a>, state: &'a WindowState) -> Self {
        WindowHit { prepared, state }
    }

    pub fn energy(self) -> Lobes {
        Lobes(self.lobe_energies().map(rgb))
    }

    pub fn lobe_probabilities(self) -> [f32; Lobe::COUNT] {
        self.lobe_energies().map(|e| e.to_array()[3] * self.inverse)
    }

    /// A direction in the form that the lobes use, with the cosine and the sine of φ.
    #[inline(always)]
    fn outgoing<V: Lanes>(self, frame: &Frame<V>, wi: [V; 3]) -> (Outgoing<V>, [V; 2]) {
        frame.refracted(wi, &self.prepared.medulla.refraction)
    }

    /// The density in sin θᵢ of light that leaves, of the backward and the forward half.
    #[inline(always)]
    fn scattered(self, theta_i: f32, transmittance: f32) -> [f32; 2] {
        self.prepared.medulla.leaving(&self.inclination, theta_i, transmittance)
    }

    /// f·cos θᵢ of the six lobes, RGB, and the largest channel. Sampling is proportional to the largest channel.
    #[inline(always)]
    fn lobes(self, (o, [cos, sin]): &(Outgoing<f32>, [f32; 2])) -> [f32x4; Lobe::COUNT] {
        let prepared = self.prepared;
        let m = prepared.longitudinal.eval(&self.centres, o.sin_i, o.cos_i).to_array();
        let medulla = &prepared.medulla;
        let c_m = if medulla.exists() { self.scattered(o.theta_i, medulla.transmittance(o.sin_i)) } else { [0.0; 2] };
        self.around([o.phi, *cos, *sin], m, c_m, diffuse::longitudinal(o.cos_i))
    }

    pub fn azimuthal(self, phi: f32) -> Lobes {
        Lobes(self.around([phi, phi.cos(), phi.sin()], [1.0; 4], self.inclination.leaving, 1.0).map(rgb))
    }

    /// a of the transformation that turns light that leaves late.
    #[cfg(feature = "unstable")]
    pub fn later(self) -> [f32; 2] {
        self.later.a
    }

    /// A of the components, RGB and the largest channel.
    #[cfg(feature = "unstable")]
    pub fn component_energies(self) -> [f32x4; Component::COUNT] {
        self.energy
    }

    /// The factors of the azimuth φ, RGB and the largest channel: R, TT, TRT, and the backward and the forward half of
    /// light that the medulla scattered, then the part of TTˢ in both halves. Those of a half contain the share of its
    /// light that leaves the fibre.
    #[cfg(feature = "unstable")]
    pub fn factors(self, phi: f32) -> [f32x4; 7] {
        let [back, ahead] = self.inclination.leaving;
        let phi = [phi, phi.cos(), phi.sin()];
        let [r, tt, trt, tts_back, trts_back, _] = self.around(phi, [1.0; 4], [back, 0.0], 0.0);
        let [_, _, _, tts_ahead, trts_ahead, _] = self.around(phi, [1.0; 4], [0.0, ahead], 0.0);
        [r, tt, trt, tts_back + trts_back, tts_ahead + trts_ahead, tts_back, tts_ahead]
    }

    /// The six lobes at azimuth φ, with its cosine and its sine, given their longitudinal parts.
    #[inline(always)]
    fn around(self, [phi, cos, sin]: [f32; 3], m: [f32; 4], c_m: [f32; 2], m_diffuse: f32) -> [f32x4; Lobe::COUNT] {
        let prepared = self.prepared;
        let mut n = [f32x4::ZERO; 3];
        for half in self.halves.iter().map_while(Option::as_ref) {
            let light = half.eval(phi, &prepared.azimuthal.inverse_sigma);
            (0..3).for_each(|p| n[p] += light[p]);
        }
        let [r, tt, trt] = n;
        let [tts, trts] = self.points.eval(&prepared.medulla, [phi, cos, sin], c_m);
        let later = self.later.of_uniform([cos, sin]);
        let times = |n: f32x4, m: f32| n * f32x4::splat(m);
        let rest = times(self.energy[Component::Rest as usize], m[3] / TAU)
            + times(self.energy[DIFFUSE], later * m_diffuse / TAU);
        [times(r, m[0]), times(tt, m[1]), times(trt, m[2]), tts, trts, rest]
    }

    #[inline]
    pub fn eval_pdf(self, wi: Vec3) -> (Lobes, f32) {
        let lobes = self.lobes(&self.outgoing(&self.frame, wi.to_array()));
        (Lobes(lobes.map(rgb)), sum(&lobes).to_array()[3] * self.inverse)
    }

    /// f·cos θᵢ of each lobe and the density of eight directions.
    pub fn eval_pdf8(self, wi: [f32x8; 3]) -> (Lobes<f32x8>, f32x8) {
        let lobes = self.lobes8(&self.outgoing(&self.frame.repeated(), wi));
        let pdf = lobes.iter().fold(f32x8::ZERO, |sum, lobe| sum + lobe[3]);
        (Lobes(lobes.map(|[r, g, b, _]| [r, g, b])), pdf * f32x8::splat(self.inverse))
    }

    /// [`WindowHit::lobes`] of eight directions.
    fn lobes8(self, (o, around): &(Outgoing<f32x8>, [f32x8; 2])) -> [[f32x8; 4]; Lobe::COUNT] {
        let medulla = &self.prepared.medulla;
        let m =
            self.prepared.longitudinal.eval(&self.centres.repeated(), o.sin_i, o.cos_i).array().map(f32x8::to_array);
        let transmittance = medulla.transmittance(o.sin_i).to_array();
        let (theta_i, phi, cos_i) = (o.theta_i.to_array(), o.phi.to_array(), o.cos_i.to_array());
        let [cos, sin] = around.map(f32x8::to_array);
        let mut lobes = [[[0.0; 8]; 4]; Lobe::COUNT];
        for i in 0..8 {
            let c_m = if medulla.exists() { self.scattered(theta_i[i], transmittance[i]) } else { [0.0; 2] };
            let one = self.around([phi[i], cos[i], sin[i]], m.map(|m| m[i]), c_m, diffuse::longitudinal(cos_i[i]));
            let one = one.map(f32x4::to_array);
            for p in 0..6 {
                (0..4).for_each(|c| lobes[p][c][i] = one[p][c]);
            }
        }
        lobes.map(|lobe| lobe.map(f32x8::new))
    }

    /// Draws a lobe, and sin θᵢ, cos θᵢ and φ from it. `u`: as for [`crate::Hit::sample`].
    #[inline(always)]
    fn draw(self, u: [f32; 5]) -> (Lobe, f32, f32, f32) {
        let prepared = self.prepared;
        let lobe = Lobe::choose(self.lobe_probabilities(), u[0]);
        let unscattered = |p: usize| prepared.longitudinal.sample(self.centres.lane(p, 0), p, [u[1], u[2]]);
        let scattered = |q: usize| self.points.draw(&prepared.medulla, &self.inclination, q, [u[4], u[1], u[2], u[3]]);
        let ((sin_i, cos_i), phi) = match lobe {
            Lobe::R | Lobe::Tt | Lobe::Trt => {
                let p = lobe as usize;
                (unscattered(p), segments::draw(&self.halves, p, prepared.azimuthal.sigma[p], [u[4], u[3]]))
            }
            Lobe::Tts => scattered(0),
            Lobe::Trts => scattered(1),
            Lobe::Rest => {
                let parts = [DIFFUSE, Lobe::Rest as usize].map(|p| self.energy[p].to_array()[3]);
                let (is_diffuse, u3) = diffuse::choose(parts, u[3]);
                let even = TAU * u3;
                match is_diffuse {
                    true => (diffuse::sample([u[1], u[2]]), self.later.leaving(0, even)),
                    false => (unscattered(3), even),
                }
            }
        };
        (lobe, sin_i, cos_i.max(0.0), phi)
    }

    /// `u`: as for [`crate::Hit::sample`].
    pub fn sample(self, u: [f32; 5]) -> Option<Sample> {
        let (lobe, sin_i, cos_i, phi) = self.draw(u);
        let (sin_phi, cos_phi) = phi.sin_cos();
        let wi = Vec3::from_array(self.frame.direction(sin_i, cos_i, (sin_phi, cos_phi)));
        let (sin, cos) = self.prepared.medulla.refraction.inside(sin_i, cos_i * cos_i);
        let lobes = self.lobes(&(Outgoing { sin_i, cos_i, theta_i: sin.atan2(cos), phi }, [cos_phi, sin_phi]));
        let total = sum(&lobes);
        let pdf = total.to_array()[3] * self.inverse;
        // 0/0 if the density underflows: the weight is then 0.
        Sample::new(wi, pdf, rgb(total * f32x4::splat(1.0 / pdf.max(f32::MIN_POSITIVE))), lobe)
    }

    /// Eight samples. `u`: eight of each number.
    pub fn sample8(self, u: [f32x8; 5]) -> [Option<Sample>; 8] {
        let u = u.map(f32x8::to_array);
        std::array::from_fn(|i| self.sample(u.map(|u| u[i])))
    }
}

#[inline(always)]
fn rgb(channels: f32x4) -> [f32; 3] {
    let [r, g, b, _] = channels.to_array();
    [r, g, b]
}

#[inline(always)]
fn sum(lobes: &[f32x4; Lobe::COUNT]) -> f32x4 {
    (lobes[0] + lobes[1]) + (lobes[2] + lobes[3]) + (lobes[4] + lobes[5])
}
