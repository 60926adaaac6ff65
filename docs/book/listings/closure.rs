//! A surface that returns its scattering as an object, as pbrt and Mitsuba do.

use vellus::glam::Vec3;
use vellus::{Bcsdf, Fiber, FiberFrame, OwnedHit, Species, Window};

// ANCHOR: closure
/// What the renderer's surfaces return. Directions are in world space.
trait Bsdf: Send + Sync {
    /// f·cos θ_i, RGB, and the density.
    fn eval_pdf(&self, wi: Vec3) -> ([f32; 3], f32);
    /// A direction, f·cos θ_i over its density, and the density.
    fn sample(&self, u: [f32; 5]) -> Option<(Vec3, [f32; 3], f32)>;
}

/// A hit of a fibre. It borrows nothing.
struct FiberBsdf {
    frame: FiberFrame,
    hit: OwnedHit,
}

impl Bsdf for FiberBsdf {
    fn eval_pdf(&self, wi: Vec3) -> ([f32; 3], f32) {
        let (f, pdf) = self.hit.eval_pdf(self.frame.to_local(wi));
        (f.total(), pdf)
    }

    fn sample(&self, u: [f32; 5]) -> Option<(Vec3, [f32; 3], f32)> {
        let sample = self.hit.sample(u)?;
        Some((self.frame.to_world(sample.wi), sample.weight, sample.pdf))
    }
}

/// A hit at `point`, where textures made `fiber`. `wo` points back along the ray.
fn shade(fiber: &Fiber, frame: FiberFrame, point: Vec3, wo: Vec3) -> Result<Box<dyn Bsdf>, vellus::Error> {
    let window = Window::near(frame.offset(point, wo));
    let hit = Bcsdf::new(fiber)?.into_hit(frame.to_local(wo), window);
    Ok(Box::new(FiberBsdf { frame, hit }))
}
// ANCHOR_END: closure

fn main() -> Result<(), vellus::Error> {
    let fox = Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]);
    let frame = FiberFrame::new(Vec3::X, Vec3::ZERO, 0.05);
    let bsdf = shade(&fox, frame, Vec3::new(0.3, 0.03, 0.04), Vec3::new(0.0, 0.6, 0.8))?;
    println!("f cos, pdf: {:?}", bsdf.eval_pdf(Vec3::Z));
    println!("sample: {:?}", bsdf.sample([0.1, 0.2, 0.3, 0.4, 0.5]));
    Ok(())
}
