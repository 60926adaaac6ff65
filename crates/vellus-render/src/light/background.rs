//! What the camera sees behind all objects.

use glam::Vec2;
use vellus_scene::{Texture, Tint};

/// A colour or a picture behind all objects. Only camera rays see it.
#[derive(Clone, Copy, Debug)]
pub struct Background {
    /// The colour, or the factor of the picture.
    pub tint: Tint,
    /// Index of its light group.
    pub group: usize,
}

impl Background {
    /// The radiance at a place of the picture that is rendered: u from left to right and v from bottom to top. The
    /// image of the background covers the picture of `size`, and its longer side is cut off equally at both ends.
    pub fn at(&self, textures: &[Texture], size: [usize; 2], place: Vec2) -> [f32; 3] {
        let Some(texture) = self.tint.texture.map(|index| &textures[index]) else { return self.tint.color };
        let ratio = (size[0] * texture.height) as f32 / (size[1] * texture.width) as f32;
        // A picture that is wider than the image shows the whole width of the image.
        let shown = if ratio > 1.0 { Vec2::new(1.0, 1.0 / ratio) } else { Vec2::new(ratio, 1.0) };
        let texel = texture.at((place - 0.5) * shown + 0.5);
        [0, 1, 2].map(|c| self.tint.color[c] * texel[c])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus_scene::Wrap;

    #[test]
    fn an_image_covers_the_picture() {
        // Four pixels in a row: a picture of 2 by 1 shows the middle half of an image of 4 by 1.
        let pixels = [1.0, 2.0, 3.0, 4.0].map(|x| [x; 3]).to_vec().into();
        let image = Texture { name: String::new(), width: 4, height: 1, pixels, wrap: [Wrap::Clamp; 2] };
        let background = Background { tint: Tint { color: [2.0, 1.0, 0.0], texture: Some(0) }, group: 0 };
        let at = |size, u| background.at(std::slice::from_ref(&image), size, Vec2::new(u, 0.5));
        assert_eq!([at([4, 1], 0.125), at([4, 1], 0.875)], [[2.0, 1.0, 0.0], [8.0, 4.0, 0.0]]);
        assert_eq!([at([2, 1], 0.25), at([2, 1], 0.75)], [[4.0, 2.0, 0.0], [6.0, 3.0, 0.0]]);
        assert_eq!(at([8, 1], 0.125), [2.0, 1.0, 0.0]);
    }
}
