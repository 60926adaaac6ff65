//! Draws the same picture as PNG or SVG, with a font that the library contains.

use crate::smooth::{Enlarged, SCALE, average};
use crate::{Error, Result, failure};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::PathBuf;

/// A picture that can be drawn to any file format.
pub trait Draw {
    /// Width and height in pixels.
    fn size(&self) -> (u32, u32);
    /// Draws on a white area of that size.
    ///
    /// # Errors
    /// Those of the drawing library, and of the picture's own computation.
    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static;
}

/// Colours of the six lobes: Tol's bright scheme, which colour-blind readers can distinguish.
pub const LOBE_COLORS: [RGBColor; 6] = [
    RGBColor(0x44, 0x77, 0xaa),
    RGBColor(0x66, 0xcc, 0xee),
    RGBColor(0x22, 0x88, 0x33),
    RGBColor(0xcc, 0xbb, 0x44),
    RGBColor(0xee, 0x66, 0x77),
    RGBColor(0xaa, 0x33, 0x77),
];

/// Names of the six lobes, as in the paper.
pub const LOBE_LABELS: [&str; 6] = ["R", "TT", "TRT", "TTˢ", "TRTˢ", "rest"];

/// The style of text `size` pixels high.
pub fn font(size: f64) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&BLACK)
}

/// The labels of a logarithmic axis from `low` to `high`: powers of ten. If there are few, also 2 and 5 times each.
pub fn log_labels(low: f64, high: f64) -> Vec<f64> {
    let steps: &[f64] = if high > 75.0 * low { &[1.0] } else { &[1.0, 2.0, 5.0] };
    (low.log10().floor() as i32..=high.log10().ceil() as i32)
        .flat_map(|power| steps.iter().map(move |step| step * 10f64.powi(power)))
        .filter(|y| (low..high).contains(y))
        .collect()
}

/// Writes a title at the top, and returns the area below it.
///
/// # Errors
/// Those of the drawing library.
pub fn titled<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    title: &str,
    size: f64,
) -> Result<DrawingArea<DB, Shift>>
where
    DB::ErrorType: 'static,
{
    let (top, rest) = area.split_vertically((2.0 * size) as u32);
    let centre = Pos::new(HPos::Center, VPos::Center);
    let (width, height) = top.dim_in_pixel();
    top.draw_text(title, &font(size).pos(centre), (width as i32 / 2, height as i32 / 2))?;
    Ok(rest)
}

/// The symbol beside a legend's text.
pub enum Mark {
    /// A short line.
    Line(ShapeStyle),
    /// A short line of dashes with gaps of these lengths.
    Dashes(ShapeStyle, [u32; 2]),
    /// A dot.
    Circle(ShapeStyle),
    /// No symbol.
    Nothing,
}

/// Writes a legend in one row at the top, and returns the area below it.
///
/// # Errors
/// Those of the drawing library.
pub fn legend<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    entries: &[(String, Mark)],
) -> Result<DrawingArea<DB, Shift>>
where
    DB::ErrorType: 'static,
{
    const MARK: i32 = 44;
    const GAP: i32 = 36;
    let (top, rest) = area.split_vertically(36);
    let style = font(19.0).pos(Pos::new(HPos::Left, VPos::Center));
    let mut widths = Vec::new();
    for (text, mark) in entries {
        let mark = if matches!(mark, Mark::Nothing) { 0 } else { MARK };
        widths.push((mark, top.estimate_text_size(text, &style)?.0 as i32));
    }
    let total: i32 = widths.iter().map(|(mark, text)| mark + text + GAP).sum::<i32>() - GAP;
    let (width, height) = top.dim_in_pixel();
    let (mut x, y) = ((width as i32 - total) / 2, height as i32 / 2);
    for ((text, mark), (space, length)) in entries.iter().zip(widths) {
        match mark {
            Mark::Line(style) => top.draw(&PathElement::new([(x, y), (x + MARK - 10, y)], *style))?,
            Mark::Dashes(style, [dash, gap]) => {
                for start in (x..x + MARK - 10).step_by((dash + gap) as usize) {
                    let end = (start + *dash as i32).min(x + MARK - 10);
                    top.draw(&PathElement::new([(start, y), (end, y)], *style))?;
                }
            }
            Mark::Circle(style) => top.draw(&Circle::new((x + MARK - 20, y), 7, *style))?,
            Mark::Nothing => {}
        }
        top.draw_text(text, &style, (x + space, y))?;
        x += space + length + GAP;
    }
    Ok(rest)
}

/// Checks that all names end in .png or .svg.
///
/// # Errors
/// [`Error::Extension`] for the first one that does not.
pub fn check_names(files: &[PathBuf]) -> Result<()> {
    let known = |file: &PathBuf| file.extension().is_some_and(|e| e == "png" || e == "svg");
    files.iter().find(|file| !known(file)).map_or(Ok(()), |file| Err(Error::Extension(file.clone())))
}

/// Draws a picture to files, in the formats that their names end in.
///
/// # Errors
/// [`check_names`], those of [`Draw::draw`], and [`Error::Write`].
pub fn save(picture: &impl Draw, files: &[PathBuf]) -> Result<()> {
    check_names(files)?;
    for file in files {
        let bytes =
            if file.extension().is_some_and(|e| e == "png") { png(picture)? } else { svg(picture)?.into_bytes() };
        failure::write(file, &bytes)?;
    }
    Ok(())
}

/// The font of all text.
fn register() -> Result<()> {
    register_font("sans-serif", FontStyle::Normal, include_bytes!("../assets/DejaVuSans-subset.ttf"))
        .map_err(|_| Error::Draw("the embedded font is broken".to_owned()))
}

/// A picture as the bytes of a PNG file.
///
/// # Errors
/// Those of [`Draw::draw`], and of the encoder.
pub fn png(picture: &impl Draw) -> Result<Vec<u8>> {
    register()?;
    let (width, height) = picture.size();
    let (wide, high) = (width * SCALE, height * SCALE);
    let mut pixels = vec![255u8; 3 * wide as usize * high as usize];
    {
        let area = Enlarged(BitMapBackend::with_buffer(&mut pixels, (wide, high))).into_drawing_area();
        area.fill(&WHITE)?;
        picture.draw(&area)?;
        area.present()?;
    }
    let pixels = average(&pixels, width as usize);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(&pixels)?;
    Ok(bytes)
}

/// A picture as the text of an SVG file.
///
/// # Errors
/// Those of [`Draw::draw`].
pub fn svg(picture: &impl Draw) -> Result<String> {
    register()?;
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, picture.size()).into_drawing_area();
        area.fill(&WHITE)?;
        picture.draw(&area)?;
        area.present()?;
    }
    Ok(text)
}
