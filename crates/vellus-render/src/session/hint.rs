//! Why a picture is nearly black, nearly white or empty.

use crate::{Film, World};
use std::fmt;

/// A picture whose pixels are all but this share black, white or empty is reported.
const REST: f64 = 0.005;
/// Fewer samples say nothing about a picture that they find empty: if objects cover more than [`REST`] of it, so many
/// miss them with a probability of 0.995¹⁰⁰⁰ = 0.7 %.
const ENOUGH: u64 = 1000;
/// Luminances, after the exposure, that look black and white.
const BLACK: f64 = 0.001;
const WHITE: f64 = 0.98;

/// The cause of a picture that shows nothing. Its text names what to do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Hint {
    /// No object is in the picture: the camera looks away.
    Empty,
    /// The picture is black: no light emits anything.
    NoLight,
    /// The picture is black: this exposure in stops would suit it.
    Dark(f32),
    /// The picture is black although its lights emit, and no exposure helps.
    Shadow,
    /// The picture is white: this exposure in stops would suit it.
    Bright(f32),
    /// The background is white, and so are the objects in front of it.
    WhiteBackground,
}

impl Hint {
    /// The cause if a film is nearly black, nearly white or empty, for a picture with this exposure in stops.
    pub fn new(world: &World, film: &Film, exposure: f32) -> Option<Self> {
        let scale = f64::from(exposure.exp2());
        let (mut pixels, mut seen, mut dark, mut white, mut open) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (luminance, alpha) in film.luminances() {
            pixels += 1.0;
            seen += f64::from(u8::from(alpha > 0.0));
            dark += f64::from(u8::from(luminance * scale < BLACK));
            white += f64::from(u8::from(luminance * scale > WHITE));
            open += f64::from(u8::from(luminance * scale > WHITE && alpha < 0.5));
        }
        let nearly_all = |count: f64| count > (1.0 - REST) * pixels;
        if seen == 0.0 {
            // There may be objects beside a crop.
            let is_whole = [film.width(), film.height()] == film.whole();
            (is_whole && film.total_samples() >= ENOUGH).then_some(Hint::Empty)
        } else if nearly_all(dark) {
            Some(match film.metered() {
                _ if world.geometry.lights.is_black() => Hint::NoLight,
                Some(stops) if stops > exposure => Hint::Dark(stops),
                _ => Hint::Shadow,
            })
        } else if nearly_all(white) {
            Some(match film.metered() {
                Some(stops) if open < 0.5 * pixels => Hint::Bright(stops),
                _ => Hint::WhiteBackground,
            })
        } else {
            None
        }
    }
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("hint: ")?;
        match self {
            Hint::Empty => f.write_str("the picture is empty because the camera looks away: try --view 35,15"),
            Hint::NoLight => f.write_str("the picture is black because no light emits anything: try --light studio"),
            Hint::Dark(stops) => {
                write!(f, "the picture is nearly black because its lights are weak: try --exposure {stops}")
            }
            Hint::Shadow => {
                f.write_str("the picture is black because no light reaches what the camera sees: try --light studio")
            }
            Hint::Bright(stops) => {
                write!(f, "the picture is nearly white because its lights are strong: try --exposure {stops}")
            }
            Hint::WhiteBackground => {
                f.write_str("the picture is nearly white because its background is: try --background grey")
            }
        }
    }
}
