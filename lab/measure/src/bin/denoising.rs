//! Measures the error of built-in scenes before and after denoising, at 16 and 64 samples.
//!
//! `cargo run --release --bin denoising -- [WIDTH [SCENE…]]`
//!
//! The error is relMSE on the fur, where fibres cover more than half of the pixel: the mean of the squared difference
//! from a picture of 1,024 samples, divided by the square of that picture plus 0.01. "Guided" has the layers albedo and
//! normal, which are denoised first. Without scenes: cat, raccoon, hair, polar-bear and hamster.

use vellus_groom::scene;
use vellus_render::denoise::Denoiser;
use vellus_render::{Denoised, Film, Layer, Settings, World};

const REFERENCE: u64 = 1024;
const SCENES: [&str; 5] = ["cat", "raccoon", "hair", "polar-bear", "hamster"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let width = arguments.first().map_or(Ok(160), |text| text.parse())?;
    let named: Vec<&str> = arguments.iter().skip(1).map(String::as_str).collect();
    let denoiser = Denoiser::load()?;
    println!("{:12} {:>7} {:>10} {:>10} {:>10}", "scene", "samples", "noisy", "unguided", "guided");
    for name in if named.is_empty() { &SCENES[..] } else { &named } {
        measure(name, width, &denoiser)?;
    }
    Ok(())
}

/// Prints the rows of a scene.
fn measure(name: &str, width: usize, denoiser: &Denoiser) -> Result<(), Box<dyn std::error::Error>> {
    let world = World::new(scene(name, false).ok_or("no built-in scene of this name")?)?;
    let render = |samples: u64, seed: u32, layers: &[Layer]| {
        let settings = Settings { seed, ..Settings::new([width, width * 2 / 3]) };
        let mut film = Film::new(settings.size, settings.area(), world.layout(layers));
        world.render(&settings, &mut film, 0..samples, &()).map(|_| film)
    };
    let beauty = |film: &Film| film.rgb(Layer::Beauty).ok_or("the film has no beauty");
    let converged = render(REFERENCE, 1, &[Layer::Beauty, Layer::Fibers])?;
    let pixels = (0..converged.height()).flat_map(|y| (0..converged.width()).map(move |x| (x, y)));
    let fur: Vec<bool> = pixels.map(|(x, y)| converged.mean(x, y, Layer::Fibers, 0) > 0.5).collect();
    let reference = beauty(&converged)?;
    for samples in [16, 64] {
        let film = render(samples, 2, &[Layer::Beauty, Layer::Albedo, Layer::Normal])?;
        let plain = render(samples, 2, &[Layer::Beauty])?;
        let clean = |film: &Film| Denoised::new(denoiser, film, &[]).map(|denoised| denoised.beauty);
        let pictures = [beauty(&film)?, clean(&plain)?, clean(&film)?];
        let [noisy, unguided, guided] = pictures.map(|picture| error(&picture, &reference, &fur));
        println!("{name:12} {samples:7} {noisy:10.2e} {unguided:10.2e} {guided:10.2e}");
    }
    Ok(())
}

/// relMSE of a picture, over the pixels of the fur.
fn error(picture: &[f32], reference: &[f32], fur: &[bool]) -> f64 {
    let one = |(a, b): (&f32, &f32)| {
        let (a, b) = (f64::from(*a), f64::from(*b));
        (a - b).powi(2) / (b * b + 0.01)
    };
    let values = picture.iter().zip(reference).enumerate().filter(|(i, _)| fur[i / 3]).map(|(_, pair)| one(pair));
    values.sum::<f64>() / (3 * fur.iter().filter(|fur| **fur).count()) as f64
}
