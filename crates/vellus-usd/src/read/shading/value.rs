//! The value of a shader input: a constant, or an image.

use vellus_scene::Texture;

/// The value of a shader input. A number has three equal channels.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// The same value everywhere.
    Constant([f64; 3]),
    /// The pixels of an image.
    Image(Texture),
}

impl Value {
    /// A constant number.
    pub fn number(x: f64) -> Self {
        Value::Constant([x; 3])
    }

    /// Applies a function to the constant or to each pixel. The result of a pixel is interpolated, not its input.
    pub fn map(self, f: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        match self {
            Value::Constant(value) => Value::Constant(f(value)),
            Value::Image(mut texture) => {
                texture.pixels.map(|pixel| f(pixel.map(f64::from)).map(|x| x as f32));
                Value::Image(texture)
            }
        }
    }

    /// Applies a function to each channel.
    pub fn map_each(self, f: impl Fn(f64) -> f64) -> Self {
        self.with_each(Value::number(0.0), |x, _| f(x))
    }

    /// As [`Value::with`], with a function of each channel. An image of bytes stays one if the other value is constant.
    pub fn with_each(self, other: Value, f: impl Fn(f64, f64) -> f64) -> Self {
        match (self, other) {
            (Value::Image(mut a), Value::Constant(b)) => {
                a.pixels.map_each(|c, x| f(x.into(), b[c]) as f32);
                Value::Image(a)
            }
            (Value::Constant(a), Value::Image(mut b)) => {
                b.pixels.map_each(|c, x| f(a[c], x.into()) as f32);
                Value::Image(b)
            }
            (a, b) => a.with(b, |a, b| std::array::from_fn(|i| f(a[i], b[i]))),
        }
    }

    /// Applies a function to two values. Of two images, the one with more tiles or pixels gives the size and the wrap
    /// modes of the result, and the other one is interpolated.
    pub fn with(self, other: Value, f: impl Fn([f64; 3], [f64; 3]) -> [f64; 3]) -> Self {
        match (self, other) {
            (a, Value::Constant(b)) => a.map(|a| f(a, b)),
            (Value::Constant(a), b) => b.map(|b| f(a, b)),
            (Value::Image(a), Value::Image(b)) if size(&a) >= size(&b) => Value::Image(combined(a, &b, f)),
            (Value::Image(a), Value::Image(b)) => Value::Image(combined(b, &a, |b, a| f(a, b))),
        }
    }
}

/// The numbers of tiles and pixels.
fn size(image: &Texture) -> (usize, usize) {
    (image.tiles().iter().product(), image.pixels.len())
}

/// Applies a function to each pixel of an image and the value of another image at the same place.
fn combined(mut a: Texture, b: &Texture, f: impl Fn([f64; 3], [f64; 3]) -> [f64; 3]) -> Texture {
    let same = (a.width, a.height, a.tiles()) == (b.width, b.height, b.tiles());
    let pixel = |i: usize| {
        let other = if same { b.pixels.get(i) } else { b.at(a.uv(i % a.width, i / a.width)) };
        f(a.pixels.get(i).map(f64::from), other.map(f64::from)).map(|x| x as f32)
    };
    a.pixels = (0..a.pixels.len()).map(pixel).collect();
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus_scene::{Pixels, Wrap};

    fn image(width: usize, reds: &[f32]) -> Value {
        let pixels: Pixels = reds.iter().map(|&red| [red, 0.0, 0.0]).collect();
        let height = pixels.len() / width;
        Value::Image(Texture { name: String::new(), width, height, pixels, wrap: [Wrap::Clamp; 2] })
    }

    #[test]
    fn two_images_combine_at_the_pixels_of_the_larger_one() {
        let difference = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], 0.0, 0.0];
        let (large, small) = (image(2, &[0.25, 0.5, 1.0, 2.0]), image(1, &[0.125]));
        assert_eq!(large.clone().with(small.clone(), difference), image(2, &[0.125, 0.375, 0.875, 1.875]));
        assert_eq!(small.with(large, difference), image(2, &[-0.125, -0.375, -0.875, -1.875]));
        assert_eq!(image(1, &[3.0]).with(Value::number(1.0), difference), image(1, &[2.0]));
        assert_eq!(Value::number(3.0).with(image(1, &[1.0]), difference), image(1, &[2.0]));
    }
}
