//! Drawing once, for both file formats, with a font of our own: no system fonts needed.

use super::smooth::{Enlarged, SCALE, average};
use crate::output;
use anyhow::{Context, Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::PathBuf;

/// A picture that any back end can draw.
pub trait Draw {
    /// Width and height in pixels.
    fn size(&self) -> (u32, u32);
    /// Draws on a white area of that size.
    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static;
}

/// The lobes' colours (Tol's bright scheme, which colour-blind readers can tell apart).
pub const LOBE_COLORS: [RGBColor; 6] = [
    RGBColor(0x44, 0x77, 0xaa),
    RGBColor(0x66, 0xcc, 0xee),
    RGBColor(0x22, 0x88, 0x33),
    RGBColor(0xcc, 0xbb, 0x44),
    RGBColor(0xee, 0x66, 0x77),
    RGBColor(0xaa, 0x33, 0x77),
];

/// The lobes' names as a reader of the paper knows them.
pub const LOBE_LABELS: [&str; 6] = ["R", "TT", "TRT", "TTˢ", "TRTˢ", "rest"];

/// Text of that height.
pub fn font(size: f64) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&BLACK)
}

/// Writes a title at the top; the area below it.
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

/// What stands beside a legend's text.
pub enum Mark {
    Line(ShapeStyle),
    Circle(ShapeStyle),
    Nothing,
}

/// Writes a legend in one row at the top, clear of all curves; the area below it.
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
            Mark::Circle(style) => top.draw(&Circle::new((x + MARK - 20, y), 7, *style))?,
            Mark::Nothing => {}
        }
        top.draw_text(text, &style, (x + space, y))?;
        x += space + length + GAP;
    }
    Ok(rest)
}

/// Refuses names of files that [`save`] cannot write.
pub fn check_names(files: &[PathBuf]) -> Result<()> {
    files.iter().try_for_each(|file| output::check_extension(file, &["png", "svg"]))
}

/// Saves to `files`, or to `out/NAME.png` and `out/NAME.svg` where there are none.
pub fn save(picture: &impl Draw, files: &[PathBuf], name: &str) -> Result<Vec<PathBuf>> {
    let files = match files {
        [] => vec![format!("out/{name}.png").into(), format!("out/{name}.svg").into()],
        files => files.to_vec(),
    };
    check_names(&files)?;
    register_font("sans-serif", FontStyle::Normal, include_bytes!("../../assets/DejaVuSans-subset.ttf"))
        .map_err(|_| anyhow!("the embedded font is broken"))?;
    for file in &files {
        let bytes = if file.extension().is_some_and(|e| e == "png") { png(picture)? } else { svg(picture)? };
        output::write(Some(file), &bytes)?;
    }
    Ok(files)
}

fn png(picture: &impl Draw) -> Result<Vec<u8>> {
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
    encoder.write_header().context("PNG")?.write_image_data(&pixels).context("PNG")?;
    Ok(bytes)
}

fn svg(picture: &impl Draw) -> Result<Vec<u8>> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, picture.size()).into_drawing_area();
        area.fill(&WHITE)?;
        picture.draw(&area)?;
        area.present()?;
    }
    Ok(text.into_bytes())
}
