//! Tone curves: how linear colours become those of a display.

use std::fmt;
use std::str::FromStr;

/// How colours that are brighter than a display are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// Colours up to 0.8 stay as they are. Brighter ones are compressed with their hue, and become white slowly: the
    /// highlights of Khronos' PBR Neutral (2024), without its correction for the reflection of a dielectric.
    #[default]
    Neutral,
    /// AgX (Sobotka 2023, in the polynomial fit of Wrensch): less contrast and saturation, for pictures with strong
    /// light.
    Agx,
    /// sRGB alone: each channel ends at 1.
    Srgb,
}

/// How a picture is shown: its exposure and its tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// Stops by which the picture is brighter.
    pub exposure: f32,
    /// The tone curve.
    pub tone: Tone,
}

impl Display {
    /// An exposure with sRGB alone.
    pub fn srgb(exposure: f32) -> Self {
        Display { exposure, tone: Tone::Srgb }
    }

    /// A linear colour as that of an sRGB display, each channel from 0 to 255. The tone curve is for objects, which
    /// cover the share `alpha` of the pixel: a background stays as it was given.
    pub fn encode(self, color: [f64; 3], alpha: f64) -> [u8; 3] {
        let scale = f64::from(self.exposure.exp2());
        // A value that is not a number becomes black.
        let color = color.map(|x| (x * scale).max(0.0));
        let shown = self.tone.map(color);
        [0, 1, 2].map(|c| {
            let x = shown[c].min(1.0) * alpha + color[c].min(1.0) * (1.0 - alpha);
            let x = x.clamp(0.0, 1.0);
            let y = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
            (255.0 * y).round() as u8
        })
    }
}

/// Where [`Tone::Neutral`] begins to compress.
const START: f64 = 0.8;
/// How fast highlights lose their colour.
const DESATURATION: f64 = 0.15;

impl Tone {
    /// The names of all curves.
    pub const NAMES: [&str; 3] = ["neutral", "agx", "srgb"];

    /// Linear light of a display for linear light of a scene. The channels are not negative.
    fn map(self, color: [f64; 3]) -> [f64; 3] {
        match self {
            Tone::Neutral => neutral(color),
            Tone::Agx => agx(color),
            Tone::Srgb => color,
        }
    }
}

fn neutral(color: [f64; 3]) -> [f64; 3] {
    let peak = color.iter().copied().fold(0.0, f64::max);
    if peak <= START || !peak.is_finite() {
        return color;
    }
    let room = 1.0 - START;
    let shown = 1.0 - room * room / (peak + room - START);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - shown) + 1.0);
    color.map(|x| x * (shown / peak) * (1.0 - white) + shown * white)
}

fn agx(color: [f64; 3]) -> [f64; 3] {
    /// Rows of the matrix before the curve, and of its inverse after it.
    const INSET: [[f64; 3]; 3] = [
        [0.842_479_062_253_094, 0.078_433_599_999_999_2, 0.079_223_745_147_764_3],
        [0.042_328_242_261_012_3, 0.878_468_636_469_772, 0.079_166_127_460_543_4],
        [0.042_375_654_905_705_1, 0.078_433_6, 0.879_142_973_793_104],
    ];
    const OUTSET: [[f64; 3]; 3] = [
        [1.196_879_005_120_17, -0.098_020_881_140_136_8, -0.099_029_744_079_720_5],
        [-0.052_896_851_757_456_2, 1.151_903_129_904_17, -0.098_961_176_844_843_3],
        [-0.052_971_635_514_443_8, -0.098_043_450_117_124_1, 1.151_073_672_641_16],
    ];
    /// Stops of the darkest and the brightest value.
    const RANGE: [f64; 2] = [-12.473_93, 4.026_069];
    let times = |m: &[[f64; 3]; 3], c: [f64; 3]| m.map(|row| row[0] * c[0] + row[1] * c[1] + row[2] * c[2]);
    let curve = |x: f64| {
        let x = ((x.max(1e-10).log2() - RANGE[0]) / (RANGE[1] - RANGE[0])).clamp(0.0, 1.0);
        [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232].into_iter().fold(0.0, |sum, factor| sum * x + factor)
    };
    times(&OUTSET, times(&INSET, color).map(curve)).map(|x| x.max(0.0).powf(2.2))
}

impl FromStr for Tone {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "neutral" => Ok(Tone::Neutral),
            "agx" => Ok(Tone::Agx),
            "srgb" => Ok(Tone::Srgb),
            _ => Err(format!("'{name}' is no tone curve: it must be {}", Tone::NAMES.join(", "))),
        }
    }
}

impl fmt::Display for Tone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Tone::NAMES[*self as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Colours below the start of the compression stay. Brighter ones rise with the light, keep the order of their
    /// channels, and stay below white.
    #[test]
    fn neutral_keeps_colours_and_compresses_highlights() {
        for color in [[0.0; 3], [0.02, 0.018, 0.017], [0.72, 0.34, 0.1], [0.8; 3]] {
            assert_eq!(Tone::Neutral.map(color), color);
        }
        let mut before = [0.0; 3];
        for stop in 0..80 {
            let light = 0.5 * 2f64.powf(0.1 * f64::from(stop));
            let shown = Tone::Neutral.map([light, 0.5 * light, 0.1 * light]);
            assert!(shown[0] > shown[1] && shown[1] > shown[2] && shown[0] < 1.0, "{shown:?}");
            assert!((0..3).all(|c| shown[c] > before[c]), "{shown:?}");
            before = shown;
        }
        // The curve has no step and no corner at its start.
        let step = |x: f64| Tone::Neutral.map([x; 3])[0];
        assert!((step(START + 1e-6) - step(START) - 1e-6).abs() < 1e-9);
    }

    /// Middle grey stays a middle grey, greys stay grey, and the range of 16.5 stops is black to white.
    #[test]
    fn agx_keeps_greys() {
        let grey = Tone::Agx.map([0.18; 3]);
        assert!((0.15..0.25).contains(&grey[0]), "{grey:?}");
        for light in [1e-4, 0.01, 0.18, 1.0, 10.0] {
            let [r, g, b] = Tone::Agx.map([light; 3]);
            assert!((r - g).abs() < 2e-3 && (g - b).abs() < 2e-3, "{light}: {r} {g} {b}");
        }
        assert!(Tone::Agx.map([0.0; 3])[0] < 1e-3 && Tone::Agx.map([100.0; 3])[0] > 0.95);
    }

    #[test]
    fn names_are_read_as_written() {
        for name in Tone::NAMES {
            assert_eq!(name.parse::<Tone>().unwrap().to_string(), name);
        }
        assert!("filmic".parse::<Tone>().unwrap_err().contains("neutral, agx, srgb"));
        assert_eq!(Display::srgb(1.0).encode([f64::NAN, 0.5, -1.0], 1.0), [0, 255, 0]);
    }

    #[test]
    fn backgrounds_stay_as_they_are_given() {
        let display = Display::default();
        assert_eq!(display.encode([1.0, 0.9, 0.0], 0.0), [255, 243, 0]);
        let [r, g, b] = display.encode([1.0, 0.9, 0.0], 1.0);
        assert!(r < 250 && g < r && b < 40, "{r} {g} {b}");
    }
}
