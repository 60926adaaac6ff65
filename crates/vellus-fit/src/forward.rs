//! The forward model: what a fibre of given parameters would be measured as.

use glam::Vec3;
use vellus::{Bcsdf, Error, Fiber, Window};

/// f·cos θᵢ averaged over the fibre's width, RGB, in the directions `wi` for a fixed ω_o.
///
/// All that a fit asks of a model; [`far_field`] is one.
pub type Forward = dyn Fn(&Fiber, Vec3, &[Vec3], &mut [[f32; 3]]) -> Result<(), Error> + Sync;

/// The far field as it is rendered (Yan17 Sec. 5.1).
///
/// # Errors
/// [`Error::OutOfRange`] where [`Fiber::validate`] finds one.
pub fn far_field(fiber: &Fiber, wo: Vec3, wi: &[Vec3], out: &mut [[f32; 3]]) -> Result<(), Error> {
    let bcsdf = Bcsdf::new(fiber)?;
    let hit = bcsdf.at(wo, Window::far());
    for (out, wi) in out.iter_mut().zip(wi) {
        *out = hit.eval(*wi).total();
    }
    Ok(())
}

/// Unit vector at θ and φ in degrees.
pub(crate) fn direction(theta: f64, phi: f64) -> Vec3 {
    let ((st, ct), (sp, cp)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    Vec3::new(st as f32, (ct * cp) as f32, (ct * sp) as f32)
}
