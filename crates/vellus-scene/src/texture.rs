//! Images for colours and lights.

use crate::error::{Error, invalid};
use crate::pixels::Pixels;
use glam::Vec2;

/// The wrap mode: how an image continues beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// The pixel at the edge continues.
    Clamp,
    /// The image repeats, and every other copy is mirrored.
    Mirror,
    /// Black.
    Black,
    /// The image consists of this many tiles along this axis, and each is one unit long (UDIM). A tile is interpolated
    /// on its own. Beyond the tiles, the pixel at the edge continues.
    Tiles(u16),
}

impl Wrap {
    /// An equivalent coordinate near the image. Far away, single precision does not resolve pixels.
    fn near(self, x: f32) -> f32 {
        match self {
            Wrap::Repeat => x.rem_euclid(1.0),
            Wrap::Mirror => x.rem_euclid(2.0),
            Wrap::Clamp | Wrap::Black => x.clamp(-1.0, 2.0),
            Wrap::Tiles(_) => x,
        }
    }

    /// The number of tiles.
    fn tiles(self) -> usize {
        if let Wrap::Tiles(count) = self { count.into() } else { 1 }
    }

    /// The position among `count` pixels of an image of tiles, in pixels from the centre of the first. It is between
    /// the centres of the pixels of one tile.
    fn in_tile(self, x: f32, count: usize) -> f32 {
        let tiles = self.tiles();
        let tile = x.floor().clamp(0.0, (tiles - 1) as f32);
        let size = (count / tiles) as f32;
        tile * size + ((x - tile) * size - 0.5).clamp(0.0, size - 1.0)
    }

    /// The index of the pixel at position `i` of an infinite row whose image has `count` pixels; `None` is black.
    fn pixel(self, i: i64, count: usize) -> Option<usize> {
        let n = count as i64;
        let inside = match self {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Clamp | Wrap::Tiles(_) => i.clamp(0, n - 1),
            Wrap::Mirror => {
                let i = i.rem_euclid(2 * n);
                i.min(2 * n - 1 - i)
            }
            Wrap::Black => i,
        };
        usize::try_from(inside).ok().filter(|i| *i < count)
    }
}

/// A linear RGB image.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name for messages, usually that of its file.
    pub name: String,
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Linear RGB, row by row from the top. v = 1 is the top edge.
    pub pixels: Pixels,
    /// Wrap modes along u and v.
    pub wrap: [Wrap; 2],
}

impl Texture {
    /// The value at `uv`, with bilinear interpolation between pixel centres.
    pub fn at(&self, uv: Vec2) -> [f32; 3] {
        let [across, down] = self.wrap;
        let (x, y) = if let [Wrap::Tiles(_), Wrap::Tiles(_)] = self.wrap {
            (across.in_tile(uv.x, self.width), (self.height - 1) as f32 - down.in_tile(uv.y, self.height))
        } else {
            let x = across.near(uv.x) * self.width as f32 - 0.5;
            let y = (1.0 - down.near(uv.y)) * self.height as f32 - 0.5;
            (x, y)
        };
        let (x0, y0) = (x.floor(), y.floor());
        let (s, t) = (x - x0, y - y0);
        let pixel = |dx: i64, dy: i64| {
            let column = across.pixel(x0 as i64 + dx, self.width);
            let row = down.pixel(y0 as i64 + dy, self.height);
            row.zip(column).map_or([0.0; 3], |(row, column)| self.pixels.get(row * self.width + column))
        };
        let corners = [pixel(0, 0), pixel(1, 0), pixel(0, 1), pixel(1, 1)];
        let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
        std::array::from_fn(|c| (0..4).map(|k| weights[k] * corners[k][c]).sum())
    }

    /// The number of tiles along u and v; 1 if the image has none.
    pub fn tiles(&self) -> [usize; 2] {
        self.wrap.map(Wrap::tiles)
    }

    /// Whether the image can be that of a whole sky: it is twice as wide as high, within a tenth, or has one pixel.
    pub fn is_latlong(&self) -> bool {
        let ratio = self.width as f64 / self.height as f64;
        (1.8..=2.2).contains(&ratio) || self.pixels.len() == 1
    }

    /// The texture coordinates of the centre of a pixel.
    pub fn uv(&self, column: usize, row: usize) -> Vec2 {
        let [across, down] = self.tiles().map(|tiles| tiles as f32);
        let (x, y) = (column as f32 + 0.5, row as f32 + 0.5);
        Vec2::new(x / self.width as f32 * across, (1.0 - y / self.height as f32) * down)
    }

    /// Checks that the size matches the number of pixels, that tiles divide it, and that every pixel is finite and not
    /// negative.
    ///
    /// # Errors
    /// [`Error::Invalid`] for the first problem.
    pub fn validate(&self) -> Result<(), Error> {
        if self.width == 0 || self.height == 0 || self.width.checked_mul(self.height) != Some(self.pixels.len()) {
            return Err(invalid(&self.name, "its width and height do not match its number of pixels"));
        }
        if let Pixels::Bytes { bytes, stride, channels, .. } = &self.pixels
            && (*stride == 0 || !bytes.len().is_multiple_of(*stride) || channels.iter().any(|c| c >= stride))
        {
            return Err(invalid(&self.name, "its channels must be bytes of each pixel"));
        }
        let is_tiled = self.wrap.map(|wrap| matches!(wrap, Wrap::Tiles(_)));
        let [across, down] = self.tiles();
        let fit = across > 0 && down > 0 && self.width.is_multiple_of(across) && self.height.is_multiple_of(down);
        if is_tiled[0] != is_tiled[1] || !fit {
            return Err(invalid(&self.name, "its tiles must be along both axes, and all have the same size"));
        }
        match self.pixels.position(|x| !(x.is_finite() && x >= 0.0)) {
            Some(i) => {
                let (x, y) = (i % self.width, i / self.width);
                Err(invalid(
                    &self.name,
                    format!("pixel ({x}, {y}) is {:?}: it is negative or not finite", self.pixels.get(i)),
                ))
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
            pixels: vec![[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [4.0, 0.0, 0.0]].into(),
            wrap: [Wrap::Repeat; 2],
        };
        let at = |u, v| texture.at(Vec2::new(u, v))[0];
        assert_eq!([at(0.25, 0.75), at(0.75, 0.75), at(0.25, 0.25), at(1.75, -0.75)], [1.0, 2.0, 3.0, 4.0]);
        assert!((at(0.5, 0.5) - 2.5).abs() < 1e-6 && (at(0.0, 0.75) - 1.5).abs() < 1e-6);
    }

    /// Pixels 1 to 4 in a row, and in a column from the bottom, at their centres and beyond.
    #[test]
    fn wrap_modes_continue_the_image() {
        let rows = [
            (Wrap::Repeat, [2.0, 3.0, 4.0, 1.0, 2.0, 3.0, 4.0, 1.0, 2.0, 3.0, 4.0, 1.0]),
            (Wrap::Clamp, [1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0]),
            (Wrap::Mirror, [3.0, 2.0, 1.0, 1.0, 2.0, 3.0, 4.0, 4.0, 3.0, 2.0, 1.0, 1.0]),
            (Wrap::Black, [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ];
        for (wrap, expected) in rows {
            let texture = |width, values: [f32; 4]| Texture {
                name: "test".to_owned(),
                width,
                height: 4 / width,
                pixels: values.map(|x| [x; 3]).to_vec().into(),
                wrap: if width == 4 { [wrap, Wrap::Clamp] } else { [Wrap::Clamp, wrap] },
            };
            let (row, column) = (texture(4, [1.0, 2.0, 3.0, 4.0]), texture(1, [4.0, 3.0, 2.0, 1.0]));
            for (i, value) in expected.into_iter().enumerate() {
                let at = (i as f32 - 2.5) / 4.0;
                assert_eq!(row.at(Vec2::new(at, 0.5)), [value; 3], "{wrap:?} {i}");
                assert_eq!(column.at(Vec2::new(0.5, at)), [value; 3], "{wrap:?} {i}");
            }
            // Far coordinates are finite too.
            assert!(row.at(Vec2::new(-1e30, 1e30))[0].is_finite());
        }
        let edge =
            Texture { name: String::new(), width: 1, height: 1, pixels: vec![[8.0; 3]].into(), wrap: [Wrap::Black; 2] };
        // At a corner, one of four pixels is in the image.
        assert_eq!(edge.at(Vec2::ONE), [2.0; 3]);
    }

    /// Two columns and two rows of tiles of 2 × 1 pixels. The top row has the tiles of v from 1 to 2.
    #[test]
    fn tiles_have_a_unit_each_and_do_not_mix() {
        let values = [5.0, 6.0, 7.0, 8.0, 1.0, 2.0, 3.0, 4.0];
        let texture = Texture {
            name: "skin".to_owned(),
            width: 4,
            height: 2,
            pixels: values.map(|x: f32| [x; 3]).to_vec().into(),
            wrap: [Wrap::Tiles(2); 2],
        };
        texture.validate().unwrap();
        let at = |u, v| texture.at(Vec2::new(u, v))[0];
        // Centres of pixels, between them, and both sides of an edge.
        assert_eq!([at(0.25, 0.5), at(0.75, 0.1), at(1.25, 0.9), at(1.75, 0.5)], [1.0, 2.0, 3.0, 4.0]);
        assert_eq!([at(0.25, 1.5), at(0.5, 1.5), at(1.5, 1.5), at(1.75, 1.99)], [5.0, 5.5, 7.5, 8.0]);
        assert_eq!([at(0.999, 0.5), at(1.001, 0.5), at(0.25, 0.999), at(0.25, 1.001)], [2.0, 3.0, 1.0, 5.0]);
        assert_eq!([at(-9.0, -9.0), at(2.0, 2.0), at(1e30, 0.5)], [1.0, 8.0, 4.0]);
        for (i, value) in values.into_iter().enumerate() {
            assert_eq!(texture.at(texture.uv(i % 4, i / 4)), [value; 3], "{i}");
        }
        for wrap in [[Wrap::Tiles(3), Wrap::Tiles(1)], [Wrap::Tiles(0); 2], [Wrap::Tiles(1), Wrap::Clamp]] {
            assert!(Texture { wrap, ..texture.clone() }.validate().unwrap_err().to_string().contains("tiles"));
        }
    }
}
