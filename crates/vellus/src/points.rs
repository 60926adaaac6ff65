//! TTˢ and TRTˢ averaged over a window: four paths on each side of the axis, three of TTˢ and one of TRTˢ,
//! which has a hundredth of its light (Yan17 Eq. 25).
//!
//! The paper takes A(h) C^N as a cubic times an exponential between nodes. C^N varies too much between the
//! offsets for that to be worth more than Gauss points: at three of them the sum of both lobes is
//! right to 1 %, with nothing to cancel and nothing negative.

use crate::azimuthal::wrap;
use crate::bcsdf::Bcsdf;
use crate::frame::Polar;
use crate::medulla::Medulla;
use crate::mixture::Weights;
use crate::nodes::{Nodes, POINTS};
use crate::path::Path;
use crate::segments::{Channels, Through, attenuation, halves, sum};
use crate::tables::AZIMUTHAL;
use std::f32::consts::PI;
use wide::{f32x4, f32x8};

/// The paths of the offsets ≥ 0 in the lower lanes, of those ≤ 0, mirrored, in the upper.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points {
    /// C^N.
    weights: [Weights<AZIMUTHAL>; 2 * POINTS],
    /// Φˢ.
    exit: f32x8,
    /// 1, and −1 where φ is mirrored.
    mirror: f32x8,
    /// What each path stands for of the energy of its lobe.
    energy: Channels,
    pub exist: bool,
}

/// The lanes of TTˢ; the others are of TRTˢ.
const FIRST: f32x8 = f32x8::new([1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0]);

impl Points {
    /// None.
    pub const NONE: Points = Points {
        weights: [[f32x8::ZERO; AZIMUTHAL]; 2 * POINTS],
        exit: f32x8::ZERO,
        mirror: f32x8::ZERO,
        energy: [f32x8::ZERO; 4],
        exist: false,
    };

    /// Prepares them in place, so that they sum to the `energy` of TTˢ and TRTˢ found already.
    #[inline(always)]
    pub fn prepare(
        &mut self,
        bcsdf: &Bcsdf,
        polar: Polar<f32>,
        through: &Through,
        sides: [Option<&Nodes>; 2],
        energy: [f32x4; 2],
    ) {
        let (mut h, mut width) = ([0.0; 8], [0.0; 8]);
        for (side, nodes) in sides.into_iter().enumerate() {
            for (i, (offset, dh)) in nodes.and_then(|nodes| nodes.points).into_iter().flatten().enumerate() {
                (h[POINTS * side + i], width[POINTS * side + i]) = (offset, dh);
                self.exist = true;
            }
        }
        if !self.exist {
            return;
        }
        let path = Path::new(&bcsdf.fiber, f32x8::splat(polar.sin), f32x8::splat(polar.cos), f32x8::new(h));
        let first = FIRST.simd_gt(f32x8::ZERO);
        self.exit = first.select(path.scattered_azimuth(1), path.scattered_azimuth(2));
        self.mirror = f32x8::new([1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0]);
        let mut scale = [0.0; 8];
        let angles = path.gamma_m.to_array();
        let same = sides[0].zip(sides[1]).is_some_and(|(a, b)| std::ptr::eq(a, b));
        for i in 0..8 {
            if same && i >= POINTS {
                (self.weights[i], scale[i]) = (self.weights[i - POINTS], scale[i - POINTS]);
            } else if width[i] > 0.0 {
                let azimuth = bcsdf.medulla.azimuth(&through.pass, angles[i]);
                (self.weights[i], scale[i]) = (azimuth.weights, azimuth.scale);
            }
        }
        let a = attenuation(bcsdf, &path, Some(through));
        let width = f32x8::new(width);
        let (mut tts, mut trts) = ([f32x8::ZERO; 4], [f32x8::ZERO; 4]);
        for c in 0..4 {
            tts[c] = a[3][c] * width * FIRST;
            trts[c] = a[4][c] * width * (f32x8::ONE - FIRST);
        }
        let least = f32x4::splat(f32::MIN_POSITIVE);
        let shares = [(energy[0] / sum(tts).max(least)).to_array(), (energy[1] / sum(trts).max(least)).to_array()];
        for c in 0..4 {
            let share = tts[c] * f32x8::splat(shares[0][c]) + trts[c] * f32x8::splat(shares[1][c]);
            self.energy[c] = share * f32x8::new(scale);
        }
    }

    /// TTˢ and TRTˢ at φ, densities over solid angle; `m`: C^M of the backward and the forward half.
    #[inline(always)]
    pub fn eval(&self, medulla: &Medulla, phi: f32, m: [f32; 2]) -> [f32x4; 2] {
        let relative = wrap(f32x8::splat(phi) * self.mirror - self.exit);
        let m = (relative.abs() * f32x8::splat(1.0 / PI)).mul_add(f32x8::splat(m[1] - m[0]), f32x8::splat(m[0]));
        let weights = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| &self.weights[i]);
        let density = m * medulla.azimuthal8(weights, relative);
        let mut lanes = [f32x8::ZERO; 4];
        for c in 0..4 {
            // TRTˢ, lanes 3 and 7, apart.
            let x = (self.energy[c] * density).to_array();
            lanes[c] = f32x8::new([x[0] + x[5], x[1] + x[6], x[2], x[4], x[3], x[7], 0.0, 0.0]);
        }
        halves(lanes)
    }
}
