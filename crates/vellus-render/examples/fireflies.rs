//! Counts fireflies in the built-in scenes: pixels brighter than 3 times the median of their neighbours.
//!
//! `cargo run --release -p vellus-render --example fireflies -- [SAMPLES [WIDTH [SCENE...]]]`
//!
//! It renders each picture with two seeds. A pixel that stands out with both seeds is a detail of the scene, such as a
//! highlight in an eye. One that stands out with one seed only is a firefly. It also prints the mean relative variance
//! of the noise and the time, so that pictures can be compared at equal time.

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
    println!("{:12} {:>9} {:>8} {:>13} {:>9}", "scene", "fireflies", "details", "rel. variance", "seconds");
    for (name, _) in SCENES.iter().filter(|(name, _)| named(name)) {
        let world = World::new(scene(name, false).ok_or("the scene is missing")?)?;
        let start = Instant::now();
        let films = [1, 2].map(|seed| {
            let settings = Settings { seed, ..Settings::new([width, width * 3 / 4]) };
            let mut film = Film::new(settings.size, settings.area(), world.layout(&[Layer::Beauty]));
            world.render(&settings, &mut film, 0..samples, &()).map(|_| film)
        });
        let seconds = start.elapsed().as_secs_f64() / 2.0;
        let [a, b] = films;
        let [a, b] = [luminance(&a?), luminance(&b?)];
        let [first, second] = [&a, &b].map(|picture| bright(picture, width));
        let both = first.iter().zip(&second).filter(|(a, b)| **a && **b).count();
        let any = first.iter().chain(&second).filter(|bright| **bright).count();
        let fireflies = (any as f64 - 2.0 * both as f64) / 2.0;
        println!("{name:12} {fireflies:9.1} {both:8} {:13.2e} {seconds:9.1}", variance(&a, &b));
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
    let height = picture.len() / width;
    let stands_out = |i: usize| {
        let (x, y) = (i % width, i / width);
        let near = |at: usize, n: usize| at.saturating_sub(1)..=(at + 1).min(n - 1);
        let all = near(y, height).flat_map(|v| near(x, width).map(move |u| v * width + u));
        let mut neighbours: Vec<f64> = all.filter(|&j| j != i).map(|j| picture[j]).collect();
        neighbours.sort_by(f64::total_cmp);
        let n = neighbours.len();
        picture[i] > FACTOR * 0.5 * (neighbours[(n - 1) / 2] + neighbours[n / 2])
    };
    (0..picture.len()).map(stands_out).collect()
}

/// The variance of a pixel, relative to the square of the mean of both pictures plus a hundredth of the mean square.
fn variance(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let floor = 0.01 * a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / n;
    let one = |(a, b): (&f64, &f64)| 0.5 * (a - b).powi(2) / ((0.5 * (a + b)).powi(2) + floor);
    a.iter().zip(b).map(one).sum::<f64>() / n
}
