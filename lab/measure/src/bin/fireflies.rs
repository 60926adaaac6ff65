//! Counts fireflies in the built-in scenes: pixels brighter than 3 times the median of their neighbours.
//!
//! `cargo run --release --bin fireflies -- [SAMPLES [WIDTH [SCENE...]]]`
//!
//! It renders each picture with two seeds. A pixel that stands out with both seeds is a detail of the scene, such as a
//! highlight in an eye. One that stands out with one seed only is a firefly. The count is that of one picture.
//!
//! It then says where fireflies come from. A path's camera ray and its direct light are the same if paths end after one
//! scattering event. So the indirect light of a picture is known. A firefly is due to indirect light if it does not
//! stand out with the indirect light of the other seed. The rest are due to direct light or to what the camera ray
//! sees: for example a gap between dark hairs that one of 64 rays finds.
//!
//! It also prints the mean relative variance of the noise and the time, so that pictures can be compared at equal time.
//! The environment variable `CLAMP` limits indirect light, like `vellus render --clamp-indirect`. The last column is
//! the light that this limit removes.

use std::time::Instant;
use vellus_groom::{SCENES, scene};
use vellus_render::{Film, Layer, Settings, World};

/// A pixel stands out if it is this many times brighter than the median of its neighbours.
const FACTOR: f64 = 3.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let samples = arguments.first().map_or(Ok(64), |text| text.parse())?;
    let width = arguments.get(1).map_or(Ok(160), |text| text.parse())?;
    let named = |name: &str| arguments.len() < 3 || arguments[2..].iter().any(|given| given == name);
    let clamp_indirect = std::env::var("CLAMP").ok().map(|text| text.parse::<f32>()).transpose()?;
    println!("scene        fireflies  indirect  details  rel. variance  seconds  removed");
    for (name, _) in SCENES.iter().filter(|(name, _)| named(name)) {
        let world = World::new(scene(name, false).ok_or("the scene is missing")?)?;
        let render = |seed: u32, max_depth: Option<u32>| {
            let settings = Settings { seed, max_depth, clamp_indirect, ..Settings::new([width, width * 3 / 4]) };
            let mut film = Film::new(settings.size, settings.area(), world.layout(&[Layer::Beauty]));
            let statistics = world.render(&settings, &mut film, 0..samples, &())?;
            Ok::<_, vellus_render::Error>((luminance(&film), statistics.removed()))
        };
        let start = Instant::now();
        let [(a, removed), (b, _)] = [render(1, None)?, render(2, None)?];
        let seconds = start.elapsed().as_secs_f64() / 2.0;
        let [direct_a, direct_b] = [render(1, Some(1))?.0, render(2, Some(1))?.0];
        let [bright_a, bright_b] = [&a, &b].map(|picture| bright(picture, width));
        let details = bright_a.iter().zip(&bright_b).filter(|(a, b)| **a && **b).count();
        let mut count = [0.0; 2];
        for (picture, own, direct, other, other_direct, other_bright) in
            [(&a, &bright_a, &direct_a, &b, &direct_b, &bright_b), (&b, &bright_b, &direct_b, &a, &direct_a, &bright_a)]
        {
            for i in (0..picture.len()).filter(|&i| own[i] && !other_bright[i]) {
                let replaced = direct[i] + other[i] - other_direct[i];
                count[0] += 0.5;
                count[1] += if replaced > FACTOR * around(picture, width, i) { 0.0 } else { 0.5 };
            }
        }
        let ([all, indirect], noise) = (count, variance(&a, &b));
        println!(
            "{name:12} {all:9.1} {indirect:9.1} {details:8} {noise:14.2e} {seconds:8.1} {:7.2} %",
            100.0 * removed
        );
    }
    Ok(())
}

/// The luminance of each pixel (Rec. 709).
fn luminance(film: &Film) -> Vec<f64> {
    let pixels = (0..film.width() * film.height()).map(|i| (i % film.width(), i / film.width()));
    pixels
        .map(|(x, y)| {
            let channel = |c: usize| film.mean(x, y, Layer::Beauty, c);
            0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2)
        })
        .collect()
}

/// Whether each pixel stands out from its neighbours.
fn bright(picture: &[f64], width: usize) -> Vec<bool> {
    (0..picture.len()).map(|i| picture[i] > FACTOR * around(picture, width, i)).collect()
}

/// The median of the neighbours of a pixel.
fn around(picture: &[f64], width: usize, i: usize) -> f64 {
    let height = picture.len() / width;
    let (x, y) = (i % width, i / width);
    let near = |at: usize, n: usize| at.saturating_sub(1)..=(at + 1).min(n - 1);
    let all = near(y, height).flat_map(|v| near(x, width).map(move |u| v * width + u));
    let mut neighbours: Vec<f64> = all.filter(|&j| j != i).map(|j| picture[j]).collect();
    neighbours.sort_by(f64::total_cmp);
    let n = neighbours.len();
    0.5 * (neighbours[(n - 1) / 2] + neighbours[n / 2])
}

/// The variance of a pixel, relative to the square of the mean of both pictures plus a hundredth of the mean square.
fn variance(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let floor = 0.01 * a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / n;
    let one = |(a, b): (&f64, &f64)| 0.5 * (a - b).powi(2) / ((0.5 * (a + b)).powi(2) + floor);
    a.iter().zip(b).map(one).sum::<f64>() / n
}
