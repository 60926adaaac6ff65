//! D17: the distribution of scattered light that the cuticle reflected before it left: even in azimuth, and ∝ cos² θᵢ
//! over θᵢ, as diffuse light leaves a cylinder.

use crate::simd::lanes::Lanes;
use std::f32::consts::{PI, TAU};

/// The density over sin θᵢ, 2 cos θᵢ/π.
#[inline(always)]
pub(crate) fn longitudinal<V: Lanes>(cos_i: V) -> V {
    cos_i * V::splat(2.0 / PI)
}

/// The density over solid angle, cos θᵢ/π².
#[inline(always)]
pub(crate) fn density<V: Lanes>(cos_i: V) -> V {
    cos_i * V::splat(1.0 / (PI * PI))
}

/// Draws sin θᵢ and cos θᵢ from two uniform numbers: sin θᵢ is a coordinate of a uniform point of the unit disk.
#[inline(always)]
pub(crate) fn sample(u: [f32; 2]) -> (f32, f32) {
    let sin = u[0].sqrt() * (TAU * u[1]).cos();
    (sin, ((1.0 - sin) * (1.0 + sin)).max(0.0).sqrt())
}

/// Whether the diffuse part of the rest lobe is drawn, given the probabilities of both parts, and a new uniform
/// number.
#[inline(always)]
pub(crate) fn choose([diffuse, other]: [f32; 2], u: f32) -> (bool, f32) {
    let share = diffuse / (diffuse + other).max(f32::MIN_POSITIVE);
    if u < share { (true, u / share) } else { (false, (u - share) / (1.0 - share).max(f32::MIN_POSITIVE)) }
}
