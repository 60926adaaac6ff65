//! Anti-aliasing: a back end that draws at twice the size. Its pixels are then averaged.

use plotters::prelude::*;
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind};

/// The enlargement in each direction.
pub const SCALE: u32 = 2;

/// Draws everything `SCALE` times larger on the inner back end.
pub struct Enlarged<'a>(pub BitMapBackend<'a>);

/// A style with the line widths enlarged.
struct Style {
    color: BackendColor,
    width: u32,
}

impl BackendStyle for Style {
    fn color(&self) -> BackendColor {
        self.color
    }
    fn stroke_width(&self) -> u32 {
        self.width
    }
}

fn style<S: BackendStyle>(style: &S) -> Style {
    Style { color: style.color(), width: style.stroke_width() * SCALE }
}

fn point((x, y): BackendCoord) -> BackendCoord {
    (x * SCALE as i32, y * SCALE as i32)
}

type Outcome<'a> = Result<(), DrawingErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>>;

impl<'a> DrawingBackend for Enlarged<'a> {
    type ErrorType = <BitMapBackend<'a> as DrawingBackend>::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        let (width, height) = self.0.get_size();
        (width / SCALE, height / SCALE)
    }

    fn ensure_prepared(&mut self) -> Outcome<'a> {
        self.0.ensure_prepared()
    }

    fn present(&mut self) -> Outcome<'a> {
        self.0.present()
    }

    fn draw_pixel(&mut self, at: BackendCoord, color: BackendColor) -> Outcome<'a> {
        let (x, y) = point(at);
        for dy in 0..SCALE as i32 {
            for dx in 0..SCALE as i32 {
                self.0.draw_pixel((x + dx, y + dy), color)?;
            }
        }
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, s: &S) -> Outcome<'a> {
        self.0.draw_line(point(from), point(to), &style(s))
    }

    fn draw_rect<S: BackendStyle>(&mut self, a: BackendCoord, b: BackendCoord, s: &S, fill: bool) -> Outcome<'a> {
        // A filled rectangle covers its last pixel completely.
        let b = if fill { (point(b).0 + SCALE as i32 - 1, point(b).1 + SCALE as i32 - 1) } else { point(b) };
        self.0.draw_rect(point(a), b, &style(s), fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, s: &S) -> Outcome<'a> {
        self.0.draw_path(path.into_iter().map(point), &style(s))
    }

    fn draw_circle<S: BackendStyle>(&mut self, centre: BackendCoord, radius: u32, s: &S, fill: bool) -> Outcome<'a> {
        self.0.draw_circle(point(centre), radius * SCALE, &style(s), fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, s: &S) -> Outcome<'a> {
        self.0.fill_polygon(path.into_iter().map(point), &style(s))
    }

    fn draw_text<T: BackendTextStyle>(&mut self, text: &str, s: &T, at: BackendCoord) -> Outcome<'a> {
        let BackendColor { alpha, rgb: (r, g, b) } = s.color();
        let color = RGBColor(r, g, b).mix(alpha);
        let large = TextStyle::from((s.family(), s.size() * f64::from(SCALE)).into_font())
            .color(&color)
            .pos(s.anchor())
            .transform(s.transform());
        self.0.draw_text(text, &large, point(at))
    }
}

/// Averages blocks of `SCALE` × `SCALE` RGB pixels; `width` is that of the result.
pub fn average(pixels: &[u8], width: usize) -> Vec<u8> {
    let scale = SCALE as usize;
    let row = 3 * width * scale;
    pixels
        .chunks_exact(row * scale)
        .flat_map(|rows| {
            (0..3 * width).map(move |i| {
                let (x, c) = (i / 3, i % 3);
                let block =
                    (0..scale * scale).map(|k| u32::from(rows[(k / scale) * row + 3 * (x * scale + k % scale) + c]));
                ((block.sum::<u32>() + SCALE * SCALE / 2) / (SCALE * SCALE)) as u8
            })
        })
        .collect()
}
