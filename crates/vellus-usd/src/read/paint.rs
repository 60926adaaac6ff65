//! Colours that vary over a mesh without a material, as an image: each triangle has four pixels of its own.

use glam::Vec2;
use vellus_scene::{Texture, Wrap};

/// The image, and its coordinates at the corners of each triangle. Between the centres of four pixels, an image is
/// bilinear; with the fourth colour b + c − a, it is linear over the triangle abc.
pub(crate) fn paint(name: &str, colors: &[[[f32; 3]; 3]]) -> (Texture, Vec<[Vec2; 3]>) {
    let across = (colors.len() as f64).sqrt().ceil() as usize;
    let [width, height] = [2 * across, 2 * colors.len().div_ceil(across)];
    let mut pixels = vec![[0.0; 3]; width * height];
    let mut uv = Vec::with_capacity(colors.len());
    for (i, triangle) in colors.iter().enumerate() {
        let [x, y] = [2 * (i % across), 2 * (i / across)];
        let fourth = |first: usize| {
            let [a, b, c] = [0, 1, 2].map(|k| triangle[(first + k) % 3]);
            std::array::from_fn::<f32, 3, _>(|k| b[k] + c[k] - a[k])
        };
        // No pixel may be negative. With one of the corners as the first, the fourth is so least.
        let negative = |first: &usize| fourth(*first).iter().map(|x| x.min(0.0).abs()).sum::<f32>();
        let first = (0..3).min_by(|a, b| negative(a).total_cmp(&negative(b))).unwrap_or(0);
        let place = |[right, down]: [usize; 2]| [x + right, y + down];
        let places = [[0, 0], [1, 0], [0, 1]].map(place);
        for (k, [x, y]) in places.into_iter().enumerate() {
            pixels[y * width + x] = triangle[(first + k) % 3];
        }
        let [x, y] = place([1, 1]);
        pixels[y * width + x] = fourth(first).map(|x| x.max(0.0));
        let at =
            |[x, y]: [usize; 2]| Vec2::new((x as f32 + 0.5) / width as f32, 1.0 - (y as f32 + 0.5) / height as f32);
        let corners = places.map(at);
        uv.push([0, 1, 2].map(|corner| corners[(corner + 3 - first) % 3]));
    }
    let texture = Texture { name: name.to_owned(), width, height, pixels: pixels.into(), wrap: [Wrap::Clamp; 2] };
    (texture, uv)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The colour is linear, to the rounding of coordinates in an image of 14 pixels.
    #[test]
    fn colours_are_linear_over_each_triangle() {
        let noise = |i: usize| ((i as f32 * 12.9898).sin() * 43758.547).rem_euclid(1.0);
        // The fourth colour of these is never negative.
        let colors: Vec<[[f32; 3]; 3]> =
            (0..47).map(|i| [0, 1, 2].map(|k| [0, 1, 2].map(|c| 0.4 + 0.4 * noise(9 * i + 3 * k + c)))).collect();
        let (image, uv) = paint("mesh", &colors);
        image.validate().unwrap();
        assert_eq!((image.width, image.height), (14, 14));
        for (triangle, [a, b, c]) in colors.iter().zip(uv) {
            for weights in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.2, 0.3, 0.5], [0.0, 0.5, 0.5]] {
                let found = image.at(a * weights[0] + b * weights[1] + c * weights[2]);
                for channel in 0..3 {
                    let expected: f32 = (0..3).map(|k| weights[k] * triangle[k][channel]).sum();
                    assert!((found[channel] - expected).abs() < 1e-5, "{found:?} {expected}");
                }
            }
        }
    }

    /// One black corner between two white ones, and two black ones.
    #[test]
    fn saturated_colours_are_exact_where_one_order_allows_it() {
        let (black, white) = ([0.0; 3], [1.0; 3]);
        for triangle in [[white, black, white], [black, black, white], [white; 3]] {
            let (image, uv) = paint("mesh", &[triangle]);
            let middle = image.at((uv[0][0] + uv[0][1] + uv[0][2]) / 3.0)[0];
            let expected = (triangle[0][0] + triangle[1][0] + triangle[2][0]) / 3.0;
            assert!((middle - expected).abs() < 1e-5, "{triangle:?} {middle}");
        }
    }
}
