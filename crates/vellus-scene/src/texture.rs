//! Images for colours and lights.

use crate::error::{Error, invalid};
use glam::Vec2;

/// A linear RGB image that repeats in both directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// For messages, usually its file.
    pub name: String,
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row after row, the top one first: v = 1 is its upper edge.
    pub pixels: Vec<[f32; 3]>,
}

impl Texture {
    /// The value at `uv`, bilinear between pixel centres.
    pub fn at(&self, uv: Vec2) -> [f32; 3] {
        let x = uv.x.rem_euclid(1.0) * self.width as f32 - 0.5;
        let y = (1.0 - uv.y.rem_euclid(1.0)) * self.height as f32 - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let (s, t) = (x - x0, y - y0);
        let pixel = |dx: i64, dy: i64| {
            let column = (x0 as i64 + dx).rem_euclid(self.width as i64) as usize;
            let row = (y0 as i64 + dy).rem_euclid(self.height as i64) as usize;
            self.pixels[row * self.width + column]
        };
        let corners = [pixel(0, 0), pixel(1, 0), pixel(0, 1), pixel(1, 1)];
        let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
        std::array::from_fn(|c| (0..4).map(|k| weights[k] * corners[k][c]).sum())
    }

    /// Checks its size and that every pixel is finite and not negative.
    ///
    /// # Errors
    /// [`Error::Invalid`] says what is wrong.
    pub fn validate(&self) -> Result<(), Error> {
        if self.width == 0 || self.height == 0 || self.width.checked_mul(self.height) != Some(self.pixels.len()) {
            return Err(invalid(&self.name, "its size does not fit its pixels"));
        }
        match self.pixels.iter().position(|p| p.iter().any(|x| !(x.is_finite() && *x >= 0.0))) {
            Some(i) => {
                let (x, y) = (i % self.width, i / self.width);
                Err(invalid(&self.name, format!("pixel ({x}, {y}) is {:?}: not finite, or negative", self.pixels[i])))
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_repeat_and_have_their_top_at_v_1() {
        let texture = Texture {
            name: "test".to_owned(),
            width: 2,
            height: 2,
            pixels: vec![[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [4.0, 0.0, 0.0]],
        };
        let at = |u, v| texture.at(Vec2::new(u, v))[0];
        assert_eq!([at(0.25, 0.75), at(0.75, 0.75), at(0.25, 0.25), at(1.75, -0.75)], [1.0, 2.0, 3.0, 4.0]);
        assert!((at(0.5, 0.5) - 2.5).abs() < 1e-6 && (at(0.0, 0.75) - 1.5).abs() < 1e-6);
    }
}
