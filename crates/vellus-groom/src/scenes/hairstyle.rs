//! Hairstyles of the mannequin.

use super::coat::{FEWER, smoothstep};
use super::human::hairline;
use crate::settings::{Clump, GrowSettings};
use glam::Vec3;

/// A hairstyle: the settings of its strands at full size, and its colour.
pub(super) struct Hairstyle {
    settings: GrowSettings,
    /// The height at which hair that hangs straight ends. Without it, all strands have about the same length.
    cut: Option<f32>,
    /// Eumelanin and pheomelanin of the lightest strands, and how much more the darkest have.
    pub melanin: [[f32; 2]; 2],
    /// The height of the middle of the picture, and the vertical field of view in degrees.
    pub framing: [f32; 2],
}

impl Hairstyle {
    /// Long hair in waves.
    pub fn waves() -> Self {
        let settings = GrowSettings {
            name: "hair".to_owned(),
            count: 53_000,
            segments: 64,
            length: 38.0,
            length_variation: 0.05,
            radius: [0.0045, 0.0038],
            lift: [0.3, -0.1],
            spread: 0.09,
            gravity: 7.5,
            clump: Clump { strands: 240, strength: 0.66, power: 0.75 },
            curl_radius: 1.2,
            curl_turns: 3.2,
            stray: 0.012,
            curl_variation: 0.2,
            noise: 0.015,
            clearance: 0.35,
            ..GrowSettings::default()
        };
        Hairstyle { settings, cut: None, melanin: [[0.7, 0.12], [0.4, 0.15]], framing: [-10.0, 15.5] }
    }

    /// Black hair to the chin, straight, with even tips.
    pub fn bob() -> Self {
        let Hairstyle { settings, .. } = Hairstyle::waves();
        let settings = GrowSettings {
            segments: 32,
            length: 20.0,
            length_variation: 0.06,
            radius: [0.005, 0.004],
            spread: 0.04,
            gravity: 6.0,
            clump: Clump { strands: 120, strength: 0.3, power: 1.2 },
            curl_radius: 0.0,
            noise: 0.006,
            ..settings
        };
        Hairstyle { settings, cut: Some(-9.5), melanin: [[2.6, 0.1], [2.2, 0.1]], framing: [-5.0, 11.5] }
    }

    /// Dense dark curls that stand away from the head.
    pub fn curls() -> Self {
        let Hairstyle { settings, .. } = Hairstyle::waves();
        let settings = GrowSettings {
            segments: 48,
            seed: 6,
            length: 21.0,
            length_variation: 0.2,
            radius: [0.0042, 0.003],
            lift: [0.75, 0.4],
            spread: 0.14,
            gravity: 2.6,
            clump: Clump { strands: 130, strength: 0.9, power: 0.4 },
            curl_radius: 0.75,
            curl_turns: 6.5,
            stray: 0.03,
            curl_variation: 1.0,
            noise: 0.02,
            ..settings
        };
        Hairstyle { settings, cut: None, melanin: [[1.6, 0.3], [1.0, 0.2]], framing: [-2.0, 14.0] }
    }

    /// Factor of the length of a strand that grows at `p`.
    pub fn length(&self, p: Vec3) -> f32 {
        // Hair is shorter at the hairline. Strands from the crown first cover the way to the side of the head.
        let short = 0.6 + 0.4 * smoothstep(-0.5, 1.0, hairline(p));
        short * self.cut.map_or(1.0, |cut| (p.y - cut + 0.5 * (8.0 - p.z.abs()).max(0.0)) / self.settings.length)
    }

    /// The settings of its strands.
    pub fn settings(&self, small: bool) -> GrowSettings {
        let mut settings = self.settings.clone();
        if small {
            settings.count /= FEWER;
            settings.radius = settings.radius.map(|r| r * 8.0);
            settings.clump.strands /= 10;
        }
        settings
    }
}
