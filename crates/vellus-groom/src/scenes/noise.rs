//! Smooth noise for the patterns of coats.

use super::coat::smoothstep;
use glam::{IVec3, Vec3};

/// Value noise in [-1, 1] that varies over about one unit.
pub(super) fn noise(p: Vec3) -> f32 {
    let cell = p.floor();
    let t = (p - cell).to_array().map(|x| smoothstep(0.0, 1.0, x));
    let corner = |i: i32| {
        let offset = IVec3::new(i & 1, i >> 1 & 1, i >> 2);
        let weight: f32 = (0..3).map(|k| if offset[k] == 1 { t[k] } else { 1.0 - t[k] }).product();
        weight * value(cell.as_ivec3() + offset)
    };
    (0..8).map(corner).sum()
}

/// A fixed random number in [-1, 1] for each lattice point.
fn value(p: IVec3) -> f32 {
    let mixed = [0x9e37_79b1u32, 0x85eb_ca77, 0xc2b2_ae3d];
    let mut h = (0..3).fold(0u32, |h, k| h.rotate_left(11) ^ (p[k] as u32).wrapping_mul(mixed[k]));
    h = (h ^ h >> 15).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ h >> 12).wrapping_mul(0x297a_2d39);
    (h ^ h >> 15) as f32 / (u32::MAX / 2) as f32 - 1.0
}
