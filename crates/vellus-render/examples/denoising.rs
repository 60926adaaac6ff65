//! Measures the error of a built-in scene before and after denoising, at 16 and 64 samples.
//!
//! `VELLUS_OIDN=LIBRARY cargo run --release -p vellus-render --features denoise --example denoising -- [SCENE [WIDTH]]`
//!
//! The error is relMSE: the mean of the squared difference from a picture of 1,024 samples, divided by the square of
//! that picture plus 0.01. "Guided" has the layers albedo and normal, which are denoised first.

use vellus_groom::scene;
use vellus_render::denoise::Denoiser;
use vellus_render::{Film, Layer, Settings, World};

const REFERENCE: u64 = 1024;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let name = arguments.first().map_or("cat", String::as_str);
    let width = arguments.get(1).map_or(Ok(160), |text| text.parse())?;
    let world = World::new(scene(name, false).ok_or("no built-in scene of this name")?)?;
    let denoiser = Denoiser::load()?;
    let render = |samples: u64, seed: u32, layers: &[Layer]| {
        let settings = Settings { seed, ..Settings::new([width, width * 2 / 3]) };
        let mut film = Film::new(settings.size, settings.area(), world.layout(layers));
        world.render(&settings, &mut film, 0..samples, &()).map(|_| film)
    };
    let beauty = |film: &Film| film.rgb(Layer::Beauty).ok_or("the film has no beauty");
    let reference = beauty(&render(REFERENCE, 1, &[Layer::Beauty])?)?;
    println!("{:12} {:>7} {:>10} {:>10} {:>10}", "scene", "samples", "noisy", "unguided", "guided");
    for samples in [16, 64] {
        let film = render(samples, 2, &[Layer::Beauty, Layer::Albedo, Layer::Normal])?;
        let plain = render(samples, 2, &[Layer::Beauty])?;
        let noisy = error(&beauty(&film)?, &reference);
        let [unguided, guided] = [&plain, &film].map(|film| denoiser.clean(film));
        let [unguided, guided] = [error(&unguided?, &reference), error(&guided?, &reference)];
        println!("{name:12} {samples:7} {noisy:10.2e} {unguided:10.2e} {guided:10.2e}");
    }
    Ok(())
}

/// relMSE of a picture.
fn error(picture: &[f32], reference: &[f32]) -> f64 {
    let one = |(a, b): (&f32, &f32)| {
        let (a, b) = (f64::from(*a), f64::from(*b));
        (a - b).powi(2) / (b * b + 0.01)
    };
    picture.iter().zip(reference).map(one).sum::<f64>() / reference.len() as f64
}
