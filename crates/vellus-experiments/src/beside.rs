//! Two pictures of the same view: files of the whole pictures, of their difference, and of a part that is enlarged.

use crate::context::Context;
use crate::flip::{PIXELS_PER_DEGREE, flip};
use crate::outcome::{Side, Slider};
use crate::visible::{fur, mean, shown};
use anyhow::{Result, anyhow};
use vellus_render::{Display, Film};

/// The value of a map that has the brightest colour.
const BRIGHTEST: f64 = 0.5;

/// Colours of a map at 0, ¼, ½, ¾ and 1: those of matplotlib's magma (public domain, CC0).
const MAGMA: [[f64; 3]; 5] =
    [[0.0, 0.0, 4.0], [81.0, 18.0, 124.0], [183.0, 55.0, 121.0], [252.0, 137.0, 97.0], [252.0, 253.0, 191.0]];

/// The colour of pixels without fur.
const NO_FUR: [u8; 3] = [225; 3];

/// The side of the enlarged part relative to that of the picture, and the number of places that are tried along it.
const PART: f64 = 0.28;
const PLACES: usize = 16;

/// Enlarged parts are at least this wide, in pixels.
const WIDE: usize = 320;

/// A picture of a slider: its label, and the picture that it converges to if it is compared with that one.
pub struct Input<'f> {
    pub film: &'f Film,
    pub label: String,
    pub converged: Option<&'f Film>,
}

impl<'f> Input<'f> {
    /// A picture that is compared with the other one.
    pub fn new(film: &'f Film, label: impl Into<String>) -> Self {
        Input { film, label: label.into(), converged: None }
    }

    /// A picture that is compared with the one that it converges to.
    pub fn against(self, converged: &'f Film) -> Self {
        Input { converged: Some(converged), ..self }
    }
}

/// Writes the pictures with names that begin with `name`. Shows where they differ most: from each other, or each from
/// its converged picture.
pub fn slider(
    context: &Context<'_>,
    name: &str,
    caption: String,
    shots: [Input<'_>; 2],
    exposure: f32,
) -> Result<Slider> {
    let [left, right] = &shots;
    let (width, height) = (left.film.width(), left.film.height());
    let weights = fur(&[left.film, right.film]);
    let between = |a: &Film, b: &Film| flip(&shown(&[a], exposure), &shown(&[b], exposure), PIXELS_PER_DEGREE);
    let mut maps: Vec<(String, Vec<f64>)> = Vec::new();
    for (shot, side) in shots.iter().zip(["left", "right"]) {
        if let Some(converged) = shot.converged {
            let map = between(shot.film, converged);
            maps.push((format!("FLIP, {side} picture against its converged one: {:.3}", mean(&map, &weights)), map));
        }
    }
    if maps.is_empty() {
        let map = between(left.film, right.film);
        maps.push((format!("FLIP between the two, noise included: {:.3}", mean(&map, &weights)), map));
    }
    let total: Vec<f64> =
        (0..width * height).map(|i| weights[i] * maps.iter().map(|(_, map)| map[i]).sum::<f64>()).collect();
    let zoom = part(&total, [width, height]);
    let side = |file: &str, label: &str, rgb: &[u8]| -> Result<Side> {
        let (file, zoomed) = (format!("{name}-{file}.png"), format!("{name}-{file}-zoom.png"));
        context.write(&file, &png([width, height], rgb)?)?;
        let (size, rgb) = enlarged(rgb, width, zoom);
        context.write(&zoomed, &png(size, &rgb)?)?;
        Ok(Side { file, zoom: zoomed, label: label.to_owned() })
    };
    let sides = [
        side("left", &left.label, &left.film.to_srgb(Display::srgb(exposure)))?,
        side("right", &right.label, &right.film.to_srgb(Display::srgb(exposure)))?,
    ];
    let maps = maps.iter().enumerate().map(|(k, (label, map))| {
        let pixel = |i: usize| if weights[i] < 0.02 { NO_FUR } else { color(map[i] / BRIGHTEST) };
        let rgb: Vec<u8> = (0..width * height).flat_map(pixel).collect();
        side(&format!("flip-{k}"), label, &rgb)
    });
    let maps = maps.collect::<Result<_>>()?;
    Ok(Slider { caption, size: [width, height], sides, maps, zoom })
}

/// The colour of a value from 0 to 1.
fn color(value: f64) -> [u8; 3] {
    let place = value.clamp(0.0, 1.0) * (MAGMA.len() - 1) as f64;
    let first = (place as usize).min(MAGMA.len() - 2);
    let t = place - first as f64;
    [0, 1, 2].map(|c| ((1.0 - t) * MAGMA[first][c] + t * MAGMA[first + 1][c]).round() as u8)
}

/// The part of a picture with the largest sum: left, top, width, height.
fn part(values: &[f64], [width, height]: [usize; 2]) -> [usize; 4] {
    let side = |length: usize| ((PART * length as f64).round() as usize).clamp(1.min(length), length);
    let (wide, high) = (side(width), side(height));
    let sum = |left: usize, top: usize| -> f64 {
        (top..top + high).map(|y| values[y * width + left..y * width + left + wide].iter().sum::<f64>()).sum()
    };
    let place = |k: usize, free: usize| (k * free + PLACES / 2) / PLACES;
    let places = (0..=PLACES).flat_map(|j| (0..=PLACES).map(move |i| (i, j)));
    let best = places
        .map(|(i, j)| (place(i, width - wide), place(j, height - high)))
        .map(|(left, top)| (sum(left, top), left, top))
        .fold((-1.0, 0, 0), |best, found| if found.0 > best.0 { found } else { best });
    [best.1, best.2, wide, high]
}

/// A part of an RGB picture, with each pixel repeated.
fn enlarged(rgb: &[u8], width: usize, [left, top, wide, high]: [usize; 4]) -> ([usize; 2], Vec<u8>) {
    let scale = WIDE.div_ceil(wide.max(1)).max(1);
    let size = [wide * scale, high * scale];
    let at = |x: usize, y: usize| 3 * ((top + y / scale) * width + left + x / scale);
    let rows = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    (size, rows.flat_map(|(x, y)| rgb[at(x, y)..at(x, y) + 3].iter().copied()).collect())
}

/// A PNG of 8-bit RGB.
fn png([width, height]: [usize; 2], rgb: &[u8]) -> Result<Vec<u8>> {
    let encode = || -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(rgb)?;
        writer.finish()?;
        Ok(bytes)
    };
    encode().map_err(|e| anyhow!("cannot encode PNG: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_part_is_where_the_difference_is() {
        let mut values = vec![0.0; 40 * 30];
        values[22 * 40 + 31] = 1.0;
        let [left, top, wide, high] = part(&values, [40, 30]);
        assert!((left..left + wide).contains(&31) && (top..top + high).contains(&22));
        assert!(left + wide <= 40 && top + high <= 30);
        assert_eq!(part(&[1.0], [1, 1]), [0, 0, 1, 1]);
    }

    #[test]
    fn pixels_are_repeated() {
        let rgb: Vec<u8> = (0..4 * 2 * 3).collect();
        let (size, large) = enlarged(&rgb, 4, [2, 1, 2, 1]);
        assert_eq!((size, large.len()), ([320, 160], 320 * 160 * 3));
        assert_eq!((&large[..3], &large[large.len() - 3..]), (&rgb[18..21], &rgb[21..]));
    }

    #[test]
    fn colors_become_brighter() {
        let light = |v: f64| color(v).iter().map(|c| u32::from(*c)).sum::<u32>();
        assert!((0..10).all(|k| light(0.1 * f64::from(k)) < light(0.1 * f64::from(k + 1))));
        assert_eq!((color(-1.0), color(2.0)), ([0, 0, 4], [252, 253, 191]));
    }
}
