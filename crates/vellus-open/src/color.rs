//! Colours as people write them.

/// Colours of coats that CSS has no name for, linear RGB. They are choices of ours, as an artist would mix them from
/// pictures of animals, and no measurements.
const COATS: [(&str, [f32; 3]); 15] = [
    ("arctic", [0.88, 0.88, 0.88]),
    ("auburn", [0.16, 0.045, 0.02]),
    ("blond", [0.52, 0.36, 0.17]),
    ("buff", [0.55, 0.40, 0.23]),
    ("chestnut", [0.20, 0.075, 0.03]),
    ("cream", [0.80, 0.68, 0.48]),
    ("fawn", [0.45, 0.30, 0.17]),
    ("fox", [0.48, 0.16, 0.04]),
    ("ginger", [0.72, 0.34, 0.10]),
    ("hazel", [0.26, 0.15, 0.07]),
    ("mouse", [0.16, 0.13, 0.10]),
    ("panther", [0.02, 0.018, 0.017]),
    ("sable", [0.05, 0.028, 0.018]),
    ("sand", [0.52, 0.37, 0.22]),
    ("slate", [0.13, 0.13, 0.14]),
];

/// Linear RGB of a colour: three linear numbers `R,G,B`, `#rrggbb` or any other opaque colour of CSS in sRGB, or the
/// name of a coat. Names may be in capitals.
///
/// ```
/// use vellus_open::color;
///
/// assert_eq!(color("0.8, 0.16,0.03"), Ok([0.8, 0.16, 0.03]));
/// assert_eq!(color("#ff0000"), Ok([1.0, 0.0, 0.0]));
/// assert_eq!(color("Ginger"), Ok([0.72, 0.34, 0.1]));
/// assert!(color("blurple").is_err());
/// ```
///
/// # Errors
/// What was expected.
pub fn color(text: &str) -> Result<[f32; 3], String> {
    let text = text.trim();
    let numbers: Vec<Option<f32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    if let [Some(r), Some(g), Some(b)] = numbers[..]
        && [r, g, b].iter().all(|c| c.is_finite())
    {
        return Ok([r, g, b]);
    }
    if let Some((_, coat)) = COATS.iter().find(|(name, _)| name.eq_ignore_ascii_case(text)) {
        return Ok(*coat);
    }
    let known = || {
        let coats: Vec<&str> = COATS.iter().map(|(name, _)| *name).collect();
        format!(
            "'{text}' is no colour: write R,G,B (linear), #rrggbb, a name of CSS such as orange, or one of {}",
            coats.join(", ")
        )
    };
    let css = csscolorparser::parse(text).ok().filter(|css| css.a == 1.0).ok_or_else(known)?;
    Ok([css.r, css.g, css.b].map(linear))
}

/// A [`color`] that a surface can have: each channel is in [0, 1].
///
/// # Errors
/// What was expected.
pub fn reflectance(text: &str) -> Result<[f32; 3], String> {
    let color = color(text)?;
    let is_good = color.iter().all(|c| (0.0..=1.0).contains(c));
    is_good.then_some(color).ok_or_else(|| format!("'{text}': each channel must be in [0, 1]"))
}

/// An sRGB value in [0, 1] as linear light.
fn linear(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { libm::powf((x + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_have_several_spellings() {
        let orange = color("orange").unwrap();
        assert!(orange[0] == 1.0 && (orange[1] - 0.3763).abs() < 1e-3 && orange[2] == 0.0, "{orange:?}");
        assert_eq!((color("#FFA500"), color("ORANGE")), (Ok(orange), Ok(orange)));
        assert_eq!(color("#000"), Ok([0.0; 3]));
        for bad in ["", "1,2", "nan,0,0", "#12345", "#ff000080", "kapa", "transparent"] {
            let error = color(bad).unwrap_err();
            assert!(error.contains("ginger") && error.contains("#rrggbb"), "{error}");
        }
    }
}
