//! Fibres in water (D22).

use crate::fiber::Fiber;
use crate::fiber::parameter::Parameter;

/// The refractive index of water at 20 °C for visible light.
const WATER: f32 = 1.333;

/// The smallest η in water. Without any difference of the indices there would be no cuticle.
const LEAST: f32 = 1.05;

/// The share of light that a surface with the relative index `eta` reflects at normal incidence.
fn reflected(eta: f32) -> f32 {
    ((eta - 1.0) / (eta + 1.0)).powi(2)
}

/// The layers with which a cuticle reflects `share` at normal incidence: the inverse of Yan17 Eq. 4.
fn layers(eta: f32, share: f32) -> f32 {
    let r = reflected(eta);
    let slab = 2.0 * r / (1.0 + r);
    share * (1.0 - slab) / (slab * (1.0 - share))
}

impl Fiber {
    /// The mean index n of water and air.
    fn around(&self) -> f32 {
        1.0 + (WATER - 1.0) * self.wet
    }

    /// The absorption in water over that in air, n².
    #[cfg(feature = "unstable")]
    pub(crate) fn water_absorption(&self) -> f32 {
        self.around().powi(2)
    }

    /// The fibre in air that scatters light as this one does in its water; [`Fiber::wet`] is then 0.
    ///
    /// Water surrounds a share [`Fiber::wet`] of the fibre, and air the rest; n is the mean index of both. Then:
    ///
    /// - η is divided by n, down to 1.05.
    /// - Scales of the cuticle bend refracted light by η − 1 times their slope, so water hides them: α, β_m and
    ///   β_n shrink with η − 1, and stay in their ranges.
    /// - The outside of the water reflects: the cuticle gets as many layers as reflect that share of what water does,
    ///   2 % at normal incidence, if it has fewer.
    /// - The outside of the water keeps light in. In equilibrium, light in water is n² times as dense as in air, so
    ///   the absorption grows by n². The colour of dense coats then follows the theory of wet surfaces (Lekner and
    ///   Dorf 1988).
    ///
    /// It is a model of fibres that touch in wet fur, with water between them. A film around a single fibre changes
    /// less.
    #[must_use]
    pub fn in_air(&self) -> Fiber {
        if self.wet == 0.0 {
            return *self;
        }
        let n = self.around();
        let eta = (self.eta / n).max(self.eta.min(LEAST));
        let shrink = if self.eta > 1.0 { (eta - 1.0) / (self.eta - 1.0) } else { 1.0 };
        let film = if eta > 1.0 { layers(eta, self.wet * reflected(WATER)) } else { 0.0 };
        let mut fiber = Fiber { eta, alpha: self.alpha * shrink, wet: 0.0, ..*self };
        Parameter::Layers.set_nearest(&mut fiber, [film.max(self.layers); 3]);
        Parameter::SigmaCa.set_nearest(&mut fiber, self.sigma_ca.map(|sigma| n * n * sigma));
        Parameter::SigmaMa.set_nearest(&mut fiber, self.sigma_ma.map(|sigma| n * n * sigma));
        for (roughness, x) in [(Parameter::BetaM, self.beta_m), (Parameter::BetaN, self.beta_n)] {
            roughness.set_nearest(&mut fiber, [x * shrink; 3]);
        }
        fiber
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bcsdf, Color, Species, Window};
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
        near(crate::cylinder::cuticle::fresnel(wet.eta, wet.layers, 1.0f32).reflected, reflected(WATER));
        near(wet.sigma_ca[0], dry.sigma_ca[0] * WATER * WATER);
        assert_eq!((wet.sigma_ms, wet.kappa, wet.wet, wet.reflectance), (dry.sigma_ms, dry.kappa, 0.0, None));
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

    /// Wet coats follow the theory of wet surfaces (Lekner and Dorf 1988): of light that a coat in water without an end
    /// scatters back, the outside of the water returns 0.474. Its own reflection, 0.066 over all directions, belongs to
    /// a flat surface; how much of it fibres show is not known. We allow 0.03 more.
    #[test]
    fn wet_coats_follow_the_theory_of_wet_surfaces() {
        const RETURNED: f32 = 0.474;
        const HIGHLIGHT: f32 = 0.066;
        const SLACK: f32 = 0.03;
        let furs = Species::ALL.map(|species| (species.name(), Fiber::preset(species)));
        for (name, fiber) in furs.into_iter().chain([("hair", Fiber::hair())]) {
            for asked in [0.85, 0.7, 0.5, 0.3, 0.15] {
                let color = Color::Reflectance([asked; 3]);
                let dry = fiber.with_color(color).unwrap();
                let wet = Fiber { wet: 1.0, ..dry };
                assert_eq!(wet.with_color(color).unwrap(), wet, "a reflectance is that of dry fur");
                let without_end = Fiber { sigma_ca: dry.sigma_ca, sigma_ma: dry.sigma_ma, ..wet.in_air() };
                let [dry, wet, bare] = [dry, wet, without_end].map(|fiber| fiber.coat_color().unwrap()[0]);
                let body = (1.0 - HIGHLIGHT) * bare * (1.0 - RETURNED) / (1.0 - RETURNED * bare);
                let allowed = body - SLACK..body + HIGHLIGHT + SLACK;
                assert!(wet < dry && allowed.contains(&wet), "{name} {asked}: {dry} {wet} {allowed:?}");
                let known = [("hair", 0.24), ("red-fox", 0.46)].into_iter().find(|(known, _)| *known == name);
                if let (Some((_, known)), true) = (known, asked == 0.5) {
                    assert!((wet - known).abs() < 0.005, "{name}: {wet}");
                }
            }
        }
    }
}
