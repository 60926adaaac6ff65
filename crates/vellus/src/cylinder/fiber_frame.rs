//! The frame of a fibre at a hit. It converts a renderer's directions and positions to those of the model.

use crate::cylinder::frame::is_unit;
use glam::{Vec2, Vec3};

/// The frame of a fibre at a hit. It converts directions between the renderer's space ("world") and the fibre's frame,
/// and computes the offset h and the width of a pixel.
///
/// # Use in a renderer
/// ```
/// use vellus::glam::Vec3;
/// use vellus::{Bcsdf, Fiber, FiberFrame, Window};
/// # fn main() -> Result<(), vellus::Error> {
/// # let bcsdf = Bcsdf::new(&Fiber::hair())?;
/// // At the hit: the fibre's axis and radius, the hit on its surface, the ray's direction.
/// let (center, radius) = (Vec3::ZERO, 0.05);
/// let (position, ray) = (Vec3::new(0.3, 0.03, 0.04), Vec3::new(0.0, -0.6, -0.8));
/// let frame = FiberFrame::new(Vec3::X, center, radius); // tangent, from root to tip
/// let hit = bcsdf.at(frame.to_local(-ray), Window::near(frame.offset(position, -ray)));
/// let light = Vec3::new(0.0, 0.0, 1.0);
/// let (f, pdf) = hit.eval_pdf(frame.to_local(light)); // f·cos θᵢ and its density
/// let next = hit.sample([0.1, 0.2, 0.3, 0.4, 0.5]).map(|sample| frame.to_world(sample.wi));
/// # assert!(pdf > 0.0 && f.total()[0] > 0.0 && next.is_some());
/// # Ok(()) }
/// ```
///
/// # Renderers that multiply by the cosine themselves
/// [`Hit::eval`](crate::Hit::eval) returns f·cos θᵢ, where θᵢ is the inclination to the fibre's normal plane. Many
/// renderers expect f alone and multiply it by |n·ω_i|, where n is the normal of their shading frame. Give those
/// f·cos θᵢ / |n·ω_i|, and 0 where |n·ω_i| is 0. pbrt-v4 does this in its `HairBxDF` with n = z: its BxDF returns
/// `fsum / AbsCosTheta(wi)`. Mitsuba 3 expects f times the cosine, so the value is used as it is. A sample's weight
/// contains the cosine and needs no change. In every case the renderer must not reject directions below the surface.
///
/// # The sign of h
/// h is the sine of the angle from the surface normal to ω_o, about the tangent. On the side of the fibre that
/// ω_o × tangent points to, h is positive.
/// - pbrt-v4 has the same sign, for x along the fibre from root to tip: azimuths are atan2(z, y), and h = 2v − 1 grows
///   toward +y where ω_o is along z.
/// - Mitsuba 3's `hair` has its y axis along the fibre, and azimuths atan2(z, x), which turn about −y. Its h has the
///   opposite sign where y points from root to tip. Azimuths change their sign with it, so the model is the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiberFrame {
    tangent: Vec3,
    across: [Vec3; 2],
    center: Vec3,
    radius: f32,
    /// The shorter semi-axis of the section over the longer one.
    aspect_ratio: f32,
}

impl FiberFrame {
    /// `tangent`: a unit vector along the fibre, from root to tip. `center`: the point of the axis next to the hit.
    /// `radius`: that of the fibre there, in the same unit, above 0.
    ///
    /// The two axes across the fibre are arbitrary, and are the same for the same tangent (Duff et al. 2017, *Building
    /// an Orthonormal Basis, Revisited*).
    #[inline]
    pub fn new(tangent: Vec3, center: Vec3, radius: f32) -> Self {
        debug_assert!(is_unit(tangent), "the tangent is not a unit vector: {tangent}");
        let n = tangent;
        let sign = 1f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        let across =
            [Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y)];
        FiberFrame { tangent, across, center, radius, aspect_ratio: 1.0 }
    }

    /// The frame of a fibre whose section is an ellipse: [`Fiber::aspect_ratio`](crate::Fiber::aspect_ratio).
    ///
    /// `radius` is the longer semi-axis. `longer` is its direction, of any length above 0; its part along the tangent
    /// does not count. A direction along the tangent gives an arbitrary one. `aspect_ratio` is in (0, 1].
    #[inline]
    pub fn flat(tangent: Vec3, longer: Vec3, center: Vec3, radius: f32, aspect_ratio: f32) -> Self {
        let round = Self::new(tangent, center, radius);
        let y = round.outward(longer);
        FiberFrame { across: [y, tangent.cross(y)], aspect_ratio, ..round }
    }

    /// The unit vector along the fibre, from root to tip: the x axis of the fibre's frame.
    #[inline]
    pub fn tangent(&self) -> Vec3 {
        self.tangent
    }

    /// The point of the axis.
    #[inline]
    pub fn center(&self) -> Vec3 {
        self.center
    }

    /// The radius of the fibre, or the longer semi-axis of its section.
    #[inline]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// A world direction in the fibre's frame, as [`Bcsdf::at`](crate::Bcsdf::at) takes it.
    #[inline]
    pub fn to_local(&self, w: Vec3) -> Vec3 {
        Vec3::new(w.dot(self.tangent), w.dot(self.across[0]), w.dot(self.across[1]))
    }

    /// A direction of the fibre's frame in world space.
    #[inline]
    pub fn to_world(&self, w: Vec3) -> Vec3 {
        self.tangent * w.x + self.across[0] * w.y + self.across[1] * w.z
    }

    /// The component of a world direction perpendicular to the fibre, with unit length. If the direction is along the
    /// fibre, an arbitrary perpendicular vector.
    #[inline]
    pub fn outward(&self, w: Vec3) -> Vec3 {
        self.across_or(w, self.across[0])
    }

    #[inline(always)]
    fn across_or(&self, w: Vec3, otherwise: Vec3) -> Vec3 {
        (w - self.tangent * w.dot(self.tangent)).normalize_or(otherwise)
    }

    /// h in [−1, 1]: the sine of the angle from the surface normal at `position` to `wo`, about the tangent.
    /// `position` is the hit on the surface and `wo` a unit vector toward where the path came from, both in world
    /// space.
    ///
    /// This is for round curves, and for meshes of them. It only uses the side of the axis that `position` is on, so
    /// the hit may lie a little beside the cylinder. For flat curves there is [`FiberFrame::offset_flat`].
    #[inline]
    pub fn offset(&self, position: Vec3, wo: Vec3) -> f32 {
        if self.aspect_ratio < 1.0 {
            // Divided by its axes, the section is a circle, and offsets relative to its width stay.
            let unit = |w: Vec3| (self.in_section(w) / Vec2::new(1.0, self.aspect_ratio)).normalize_or(Vec2::X);
            return unit(position - self.center).perp_dot(unit(wo)).clamp(-1.0, 1.0);
        }
        let n = self.outward(position - self.center);
        let wo = self.across_or(wo, n);
        self.tangent.dot(n.cross(wo)).clamp(-1.0, 1.0)
    }

    /// h in [−1, 1] of a hit on a flat curve that faces the camera, as wide as the fibre: the distance of `position`
    /// from the axis, across ω_o and the tangent, over the radius. It is the offset at which the same ray hits the
    /// round fibre. Arguments as for [`FiberFrame::offset`], which gives ±1 for a point of such a curve.
    ///
    /// Any point of the ray will do, also the hit on a round curve. The result is then as exact as the radius.
    #[inline]
    pub fn offset_flat(&self, position: Vec3, wo: Vec3) -> f32 {
        let aside = wo.cross(self.tangent).normalize_or_zero();
        ((position - self.center).dot(aside) / self.half_width(wo).max(1e-30)).clamp(-1.0, 1.0)
    }

    /// Half of the fibre's width, seen from the direction `wo`: the radius, unless the section is an ellipse.
    #[inline]
    pub fn half_width(&self, wo: Vec3) -> f32 {
        if self.aspect_ratio < 1.0 {
            let toward = self.in_section(wo).normalize_or(Vec2::Y);
            return self.radius * Vec2::new(toward.y, self.aspect_ratio * toward.x).length();
        }
        self.radius
    }

    /// The point of the surface on the side of the axis that `direction` points to, `times` as far from the axis.
    #[inline]
    pub fn beside(&self, direction: Vec3, times: f32) -> Vec3 {
        let out = self.outward(direction);
        let reach = match self.aspect_ratio < 1.0 {
            true => self.radius / (self.in_section(out) / Vec2::new(1.0, self.aspect_ratio)).length(),
            false => self.radius,
        };
        self.center + out * (times * reach)
    }

    /// The components across the fibre.
    #[inline]
    fn in_section(&self, w: Vec3) -> Vec2 {
        Vec2::new(w.dot(self.across[0]), w.dot(self.across[1]))
    }

    /// The width of a pixel in fibre radii, for [`Window::pixel`](crate::Window::pixel) and
    /// [`Window::cell`](crate::Window::cell). `footprint` is the diameter of the pixel at the hit, in world units, seen
    /// perpendicular to the camera's look-at direction (Yan17 Eq. 27).
    ///
    /// The result is at most 4: such a window covers the whole fibre wherever it is hit. For an ellipse, divide the
    /// footprint by [`FiberFrame::half_width`] instead.
    #[doc(alias = "Eq. 27")]
    #[inline]
    pub fn pixel_width(&self, footprint: f32) -> f32 {
        (footprint / self.radius.max(1e-30)).min(4.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    fn frame() -> FiberFrame {
        FiberFrame::new(Vec3::new(0.48, -0.6, 0.64), Vec3::new(1.0, 2.0, -3.0), 0.25)
    }

    #[test]
    fn directions_there_and_back_are_the_same() {
        let w = Vec3::new(0.36, 0.48, 0.8);
        assert!((frame().to_world(frame().to_local(w)) - w).length() < 3e-7);
        assert!((frame().to_local(frame().tangent()) - Vec3::X).length() < 3e-7);
    }

    /// The convention of the crate: the normal at the hit has the azimuth φ_o − asin h in the fibre's frame.
    #[test]
    fn offset_has_the_sign_of_the_crate() {
        let frame = frame();
        let wo = Vec3::new(-0.8, 0.0, 0.6);
        let local = frame.to_local(wo);
        for h in [-0.9f32, -0.3, 0.0, 0.5, 0.99] {
            let azimuth = local.z.atan2(local.y) - h.asin();
            let normal = frame.to_world(Vec3::new(0.0, azimuth.cos(), azimuth.sin()));
            let position = frame.center() + frame.radius() * (normal + 3.0 * frame.tangent());
            // h = sin γ of a γ with an error of a few 1e-7 in single precision.
            assert!((frame.offset(position, wo) - h).abs() < 2e-6, "{h}");
            // On the positive side is ω_o × tangent.
            assert!(h * normal.dot(wo.cross(frame.tangent())) >= -1e-6);
        }
    }

    /// A ray meets a ribbon that faces it at the offset at which it hits the round fibre.
    #[test]
    fn a_ribbon_has_the_offset_of_the_round_fibre() {
        let frame = frame();
        for wo in [Vec3::new(-0.8, 0.0, 0.6), Vec3::new(0.6, -0.8, 0.0), Vec3::new(0.36, 0.48, 0.8)] {
            let facing = frame.outward(wo);
            let local = frame.to_local(wo);
            for h in [-0.95f32, -0.5, 0.0, 0.1, 0.7] {
                let azimuth = local.z.atan2(local.y) - h.asin();
                let normal = frame.to_world(Vec3::new(0.0, azimuth.cos(), azimuth.sin()));
                let round = frame.center() + frame.radius() * (normal + 2.0 * frame.tangent());
                // The ray continues to the plane through the axis that faces it.
                let flat = round - wo * ((round - frame.center()).dot(facing) / wo.dot(facing));
                // The coordinates round at 2e-7, and up to three times as much where the ray is oblique.
                for position in [round, flat] {
                    let found = frame.offset_flat(position, wo);
                    assert!((found - h).abs() < 1e-5, "{wo} {h}: {found}");
                }
                assert!((frame.offset(round, wo) - h).abs() < 1e-5);
                assert!(h == 0.0 || (frame.offset(flat, wo).abs() - 1.0).abs() < 1e-3, "{}", frame.offset(flat, wo));
            }
        }
    }

    #[test]
    fn degenerate_hits_have_an_offset_too() {
        let frame = frame();
        for k in 0..8 {
            let (s, c) = (TAU * k as f32 / 8.0).sin_cos();
            let wo = frame.to_world(Vec3::new(0.0, c, s));
            let surface = frame.center() + frame.radius() * wo;
            assert!(frame.offset(frame.center(), wo).abs() <= 1.0);
            assert!(frame.offset(surface, frame.tangent()).abs() <= 1.0);
            assert_eq!(frame.offset_flat(frame.center(), wo), 0.0);
            assert!(frame.offset_flat(surface, frame.tangent()).abs() <= 1.0);
        }
        let thin = FiberFrame::new(Vec3::X, Vec3::ZERO, 0.0);
        assert_eq!((thin.pixel_width(1.0), thin.offset_flat(Vec3::Y, Vec3::Z)), (4.0, 1.0));
    }
}
