//! Fibres in water.

use crate::fiber::Fiber;
use crate::fiber::parameter::Parameter;

/// The refractive index of water at 20 °C for visible light.
const WATER: f32 = 1.333;

impl Fiber {
    /// The fibre in air that scatters light as this one does in its water; [`Fiber::wet`] is then 0.
    ///
    /// Water surrounds a share [`Fiber::wet`] of the fibre, and air the rest. The mean index of both divides η, but η
    /// stays at least 1. Scales of the cuticle bend refracted light by η − 1 times their slope, so water hides them:
    /// α, β_m and β_n shrink with η − 1, and stay in their ranges.
    ///
    /// It is a model of fibres that touch in wet fur, with water between them. A film around a single fibre changes
    /// less. A fibre with η below 1.33 that is all wet has the index of water.
    #[must_use]
    pub fn in_air(&self) -> Fiber {
        if self.wet == 0.0 {
            return *self;
        }
        let eta = (self.eta / (1.0 + (WATER - 1.0) * self.wet)).max(1.0);
        let shrink = if self.eta > 1.0 { (eta - 1.0) / (self.eta - 1.0) } else { 1.0 };
        let mut fiber = Fiber { eta, alpha: self.alpha * shrink, wet: 0.0, ..*self };
        for (roughness, x) in [(Parameter::BetaM, self.beta_m), (Parameter::BetaN, self.beta_n)] {
            roughness.set_nearest(&mut fiber, [x * shrink; 3]);
        }
        fiber
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bcsdf, Species, Window};
    use glam::Vec3;

    #[test]
    fn water_divides_the_index_and_hides_the_scales() {
        let dry = Fiber::preset(Species::RedFox);
        assert_eq!(dry.in_air(), dry);
        let wet = Fiber { wet: 1.0, ..dry }.in_air();
        let shrink = (dry.eta / WATER - 1.0) / (dry.eta - 1.0);
        let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-6, "{a}, not {b}");
        near(wet.eta, dry.eta / WATER);
        near(wet.alpha, dry.alpha * shrink);
        near(wet.beta_m, dry.beta_m * shrink);
        assert_eq!((wet.sigma_ca, wet.kappa, wet.wet), (dry.sigma_ca, dry.kappa, 0.0));
        // All fibres and amounts of water give a fibre, and more water a smaller index.
        for species in Species::ALL {
            let mut eta = f32::INFINITY;
            for i in 0..=20 {
                let fiber = Fiber { wet: i as f32 / 20.0, ..Fiber::published(species) }.in_air();
                assert!(fiber.validate().is_ok() && fiber.eta <= eta, "{fiber:?}");
                eta = fiber.eta;
            }
        }
    }

    #[test]
    fn a_wet_fibre_is_the_one_in_air_with_its_parameters() {
        let (wo, wi) = (Vec3::new(0.3, 0.5, 0.2).normalize(), Vec3::new(-0.1, 0.4, -0.6).normalize());
        for species in [Species::Raccoon, Species::Bobcat] {
            let fiber = Fiber { wet: 0.7, ..Fiber::preset(species) };
            let [wet, air] = [fiber, fiber.in_air()].map(|fiber| Bcsdf::new(&fiber).unwrap());
            for window in [Window::near(0.4), Window::far()] {
                assert_eq!(wet.at(wo, window).eval(wi), air.at(wo, window).eval(wi));
            }
            assert_eq!((wet.fiber(), air.fiber()), (&fiber, &fiber.in_air()));
        }
    }

    /// Light goes on straighter in water, so a coat is darker with the same pigment, but its reflectance means the dry
    /// coat.
    #[test]
    fn wet_coats_are_darker() {
        for species in Species::ALL {
            let dry = Fiber::preset(species).with_color(crate::Color::Reflectance([0.6, 0.3, 0.1])).unwrap();
            let wet = Fiber { wet: 1.0, ..dry };
            let again = wet.with_color(crate::Color::Reflectance([0.6, 0.3, 0.1])).unwrap();
            assert_eq!(again, wet);
            let [dry, wet] = [dry, wet].map(|fiber| fiber.coat_color().unwrap());
            assert!((0..3).all(|c| wet[c] < dry[c]), "{species}: {wet:?} {dry:?}");
        }
    }
}
