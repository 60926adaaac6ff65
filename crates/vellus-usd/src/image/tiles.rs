//! Images of several files: the UDIM convention, with one file for each unit square of texture coordinates.
//!
//! Tile 1001 + u + 10 v has the square at (u, v). Like OpenUSD, at most a hundred tiles are looked for.

use super::pixels::MAX_PIXELS;
use std::ops::Range;
use vellus_scene::{Texture, Wrap};

/// What stands for the number of the tile in the path of a file.
pub(crate) const UDIM: &str = "<UDIM>";

/// The numbers that tiles can have.
pub(crate) const TILES: Range<usize> = 1001..1101;

/// The number of tiles along u.
const COLUMNS: usize = 10;

/// The colour where a tile is missing: magenta, which no skin has.
const MISSING: [f32; 3] = [1.0, 0.0, 1.0];

/// The file of a tile.
pub(crate) fn tile_name(pattern: &str, number: usize) -> String {
    pattern.replace(UDIM, &number.to_string())
}

/// The place of a tile: u and v of its lower left corner.
fn place(number: usize) -> [usize; 2] {
    let index = number - TILES.start;
    [index % COLUMNS, index / COLUMNS]
}

/// The numbers of columns and rows that hold these tiles.
fn extent(numbers: &[usize]) -> [usize; 2] {
    let most = |axis: usize| numbers.iter().map(|&number| place(number)[axis] + 1).max().unwrap_or(1);
    [most(0), most(1)]
}

/// Makes a tile smaller until all of them fit into one image. Returns whether it was too large.
pub(crate) fn shrink(tile: &mut Texture, numbers: &[usize]) -> bool {
    let [columns, rows] = extent(numbers);
    let before = tile.pixels.len();
    while tile.pixels.len() * columns * rows > MAX_PIXELS {
        halve(tile);
    }
    tile.pixels.len() < before
}

/// Halves both sides. A pixel becomes the mean of four.
fn halve(image: &mut Texture) {
    let (width, height) = (image.width.div_ceil(2), image.height.div_ceil(2));
    let pixel = |x: usize, y: usize| image.pixels.get(y.min(image.height - 1) * image.width + x.min(image.width - 1));
    let mean = |x: usize, y: usize| {
        let four = [pixel(2 * x, 2 * y), pixel(2 * x + 1, 2 * y), pixel(2 * x, 2 * y + 1), pixel(2 * x + 1, 2 * y + 1)];
        std::array::from_fn(|c| 0.25 * four.iter().map(|pixel| pixel[c]).sum::<f32>())
    };
    let pixels = (0..width * height).map(|i| mean(i % width, i / width)).collect();
    (image.width, image.height, image.pixels) = (width, height, pixels);
}

/// Joins tiles to one image. Smaller tiles are interpolated to the size of the largest one.
pub(crate) fn join(name: String, tiles: Vec<(usize, Texture)>) -> Texture {
    let numbers: Vec<usize> = tiles.iter().map(|(number, _)| *number).collect();
    let [columns, rows] = extent(&numbers);
    let largest = |side: fn(&Texture) -> usize| tiles.iter().map(|(_, tile)| side(tile)).max().unwrap_or(1);
    let (width, height) = (largest(|tile| tile.width), largest(|tile| tile.height));
    let mut pixels = vec![MISSING; columns * width * rows * height];
    for (number, tile) in tiles {
        let [u, v] = place(number);
        let tile = Texture { wrap: [Wrap::Clamp; 2], ..tile };
        let fits = (tile.width, tile.height) == (width, height);
        let grid = Texture { name: String::new(), width, height, pixels: Vec::new().into(), wrap: tile.wrap };
        for y in 0..height {
            let first = ((rows - 1 - v) * height + y) * columns * width + u * width;
            for (x, pixel) in pixels[first..first + width].iter_mut().enumerate() {
                *pixel = if fits { tile.pixels.get(y * width + x) } else { tile.at(grid.uv(x, y)) };
            }
        }
    }
    Texture {
        name,
        width: columns * width,
        height: rows * height,
        pixels: pixels.into(),
        wrap: [Wrap::Tiles(columns as u16), Wrap::Tiles(rows as u16)],
    }
}

/// The tiles of an image, with their numbers. An image that has no tiles is its only one.
pub(crate) fn split(image: &Texture) -> impl Iterator<Item = (usize, Texture)> {
    let [columns, rows] = image.tiles();
    let (width, height) = (image.width / columns, image.height / rows);
    (0..columns * rows).map(move |i| {
        let (u, v) = (i % columns, i / columns);
        let row = |y: usize| {
            let first = ((rows - 1 - v) * height + y) * image.width + u * width;
            (first..first + width).map(|i| image.pixels.get(i))
        };
        let pixels = (0..height).flat_map(row).collect();
        let tile = Texture { name: image.name.clone(), width, height, pixels, wrap: [Wrap::Clamp; 2] };
        (TILES.start + u + COLUMNS * v, tile)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn tile(width: usize, height: usize, red: f32) -> Texture {
        let pixels = vec![[red, 0.0, 0.0]; width * height].into();
        Texture { name: String::new(), width, height, pixels, wrap: [Wrap::Repeat; 2] }
    }

    #[test]
    fn tiles_lie_at_their_numbers_and_missing_ones_are_marked() {
        let tiles = vec![(1001, tile(1, 1, 1.0)), (1003, tile(2, 2, 3.0)), (1012, tile(4, 2, 12.0))];
        let image = join("a.<UDIM>.png".to_owned(), tiles);
        image.validate().unwrap();
        assert_eq!((image.width, image.height, image.tiles()), (12, 4, [3, 2]));
        let at = |u, v| image.at(Vec2::new(u, v));
        assert_eq!([at(0.01, 0.99)[0], at(2.9, 0.1)[0], at(1.5, 1.001)[0]], [1.0, 3.0, 12.0]);
        assert_eq!([at(1.5, 0.5), at(0.5, 1.5), at(2.5, 1.5)], [MISSING; 3]);
        let again: Vec<(usize, Texture)> = split(&image).collect();
        assert_eq!(again.iter().map(|(number, _)| *number).collect::<Vec<_>>(), [1001, 1002, 1003, 1011, 1012, 1013]);
        assert_eq!(join(image.name.clone(), again), image);
    }

    #[test]
    fn many_large_tiles_are_halved() {
        let mut small = tile(3, 1, 2.0);
        small.pixels = vec![[2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [6.0, 0.0, 0.0]].into();
        assert!(!shrink(&mut small, &[1001, 1100]));
        halve(&mut small);
        assert_eq!((small.width, small.height, small.pixels.get(1)), (2, 1, [6.0, 0.0, 0.0]));
        // A hundred times 2 · 10⁶ pixels are more than 2²⁷.
        let mut large = tile(2000, 1000, 0.5);
        assert!(shrink(&mut large, &[1001, 1100]));
        assert_eq!((large.width, large.height, large.pixels.get(0)), (1000, 500, [0.5, 0.0, 0.0]));
    }
}
