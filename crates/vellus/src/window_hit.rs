//! A hit averaged over a window of offsets: the far field and the multi-scale mode (Yan17 Sec. 5).

use crate::bcsdf::{Bcsdf, Lobes, Sample};
use crate::frame::{Frame, Outgoing, Polar};
use crate::longitudinal::Centres;
use crate::medulla::Inclination;
use crate::near::NearHit;
use crate::nodes::Nodes;
use crate::path::inverse_eta;
use crate::points::Points;
use crate::segments::{Half, Through, gather};
use glam::Vec3;
use std::f32::consts::TAU;
use wide::{f32x4, f32x8};

/// All that depends on ω_o and the window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WindowHit<'b> {
    bcsdf: &'b Bcsdf<'b>,
    wo: [f32; 3],
    range: [f32; 2],
    frame: Frame<f32>,
    centres: Centres<f32>,
    inclination: Inclination,
    /// A of the six lobes, RGB and probability, averaged over the window.
    energy: [f32x4; 6],
    /// Which half stands for the offsets ≥ 0, and which for those ≤ 0, mirrored: (h, φ) → (−h, −φ).
    sides: [Option<u8>; 2],
    halves: [Half; 2],
    points: Points,
}

impl<'b> WindowHit<'b> {
    #[inline(always)]
    pub fn new(bcsdf: &'b Bcsdf<'b>, wo: [f32; 3], range: [f32; 2]) -> Self {
        let polar = Polar::new(wo);
        WindowHit {
            bcsdf,
            wo,
            range,
            frame: Frame::new(wo, polar.cos, 1.0 / polar.cos.max(1e-12)),
            centres: bcsdf.longitudinal.centres(polar.sin, polar.cos),
            inclination: if bcsdf.medulla.exists() {
                bcsdf.medulla.inclination(polar.sin.atan2(polar.cos))
            } else {
                Inclination::NONE
            },
            energy: [f32x4::ZERO; 6],
            sides: [None; 2],
            halves: [Half::NONE; 2],
            points: Points::NONE,
        }
    }

    /// Prepares the halves where they lie.
    pub fn prepare(&mut self) {
        let bcsdf = self.bcsdf;
        let fiber = &bcsdf.fiber;
        let polar = Polar::new(self.wo);
        let medulla = (fiber.kappa > 0.0).then(|| fiber.kappa / inverse_eta(fiber.eta, polar.cos));
        let through = bcsdf.medulla.exists().then(|| {
            let sin_t = polar.sin / fiber.eta;
            let elongation = 1.0 / ((1.0 - sin_t) * (1.0 + sin_t)).max(1e-12).sqrt();
            let pass = bcsdf.medulla.pass(bcsdf.medulla.tau_position(elongation));
            Through { pass, mean_paths: bcsdf.medulla.mean_paths(&pass) }
        });
        let through = through.as_ref();
        let [low, high] = self.range;
        let symmetric = low == -high;
        let divide = |low: f32, high: f32| (high > low).then(|| Nodes::new(low, high, medulla));
        let nodes = [divide(low.max(0.0), high), if symmetric { None } else { divide((-high).max(0.0), -low) }];
        let sides = [nodes[0].as_ref(), if symmetric { nodes[0].as_ref() } else { nodes[1].as_ref() }];
        let width: f32 = sides.into_iter().flatten().map(Nodes::width).sum();
        let scale = 1.0 / width.max(f32::MIN_POSITIVE);
        for (side, nodes) in nodes.iter().enumerate() {
            if let Some(nodes) = nodes {
                self.sides[side] = Some(side as u8);
                let energy = self.halves[side].prepare(bcsdf, polar, through, nodes, scale);
                (0..6).for_each(|p| self.energy[p] += energy[p]);
            }
        }
        if symmetric {
            self.sides[1] = self.sides[0];
            self.energy = self.energy.map(|e| e + e);
        }
        if let Some(through) = through {
            self.points.prepare(bcsdf, polar, through, sides, [self.energy[3], self.energy[4]]);
        }
    }

    pub fn energy(&self) -> Lobes {
        Lobes(self.energy.map(rgb))
    }

    pub fn lobe_probabilities(&self) -> [f32; 6] {
        self.energy.map(|e| e.to_array()[3])
    }

    /// f·cos θᵢ of the six lobes, RGB, and the density with which they are sampled.
    #[inline(always)]
    fn lobes(&self, o: &Outgoing<f32>) -> [f32x4; 6] {
        let bcsdf = self.bcsdf;
        let m = bcsdf.longitudinal.eval(&self.centres, o.sin_i, o.cos_i).to_array();
        let medulla = &bcsdf.medulla;
        let c_m = if medulla.exists() { medulla.longitudinal(&self.inclination, o.theta_i) } else { [0.0; 2] };
        self.around(o.phi, m, c_m)
    }

    pub fn azimuthal(&self, phi: f32) -> Lobes {
        Lobes(self.around(phi, [1.0; 4], [1.0; 2]).map(rgb))
    }

    /// The six lobes at azimuth φ, given their longitudinal parts.
    #[inline(always)]
    fn around(&self, phi: f32, m: [f32; 4], c_m: [f32; 2]) -> [f32x4; 6] {
        let bcsdf = self.bcsdf;
        let mut n = [[f32x8::ZERO; 4]; 4];
        for (side, phi) in self.sides.into_iter().zip([phi, -phi]) {
            if let Some(side) = side {
                self.halves[usize::from(side & 1)].add(phi, &bcsdf.azimuthal.inverse_sigma, &mut n);
            }
        }
        let [r, tt, trt] = gather(&n);
        let [tts, trts] = self.points.eval(&bcsdf.medulla, phi, c_m);
        let times = |n: f32x4, m: f32| n * f32x4::splat(m);
        [times(r, m[0]), times(tt, m[1]), times(trt, m[2]), tts, trts, times(self.energy[5], m[3] / TAU)]
    }

    #[inline]
    pub fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        let lobes = self.lobes(&self.frame.outgoing(wi.to_array()));
        (Lobes(lobes.map(rgb)), density(&lobes))
    }

    /// `u`: as for [`crate::Hit::sample`].
    pub fn sample(&self, u: [f32; 5]) -> Sample {
        let [low, high] = self.range;
        let h = low + (high - low) * u[4];
        let (sample, outgoing) = NearHit::new(self.bcsdf, self.wo, h).draw_outgoing([u[0], u[1], u[2], u[3]]);
        Sample { pdf: density(&self.lobes(&outgoing)), ..sample }
    }
}

#[inline(always)]
fn rgb(channels: f32x4) -> [f32; 3] {
    let [r, g, b, _] = channels.to_array();
    [r, g, b]
}

#[inline(always)]
fn density(lobes: &[f32x4; 6]) -> f32 {
    lobes.iter().fold(0.0, |sum, lobe| sum + lobe.to_array()[3])
}
