//! Measures the mean colour of fur with a growing radiance cache beside that of full paths.
//!
//! `cargo run --release --bin cache_bias -- WIDTH REFERENCE SEEDS SAMPLES[,SAMPLES...] SCENE...`
//!
//! Scenes are those of `radiance_cache`. REFERENCE is the number of samples of full paths. Each cached picture starts
//! with 8 samples in the cache, and is rendered with SEEDS seeds: "±" is the standard error of their mean, the first
//! one that of the full paths. `fur` are the pixels with more than half fur, `all` is all light of the picture.

use std::error::Error;
use vellus_measure::varied;
use vellus_render::{Film, Layer, Settings, World};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [width, reference, seeds, samples, scenes @ ..] = &arguments[..] else {
        return Err("WIDTH, REFERENCE, SEEDS, SAMPLES and scenes are missing".into());
    };
    let (width, reference, seeds): (usize, u64, u32) = (width.parse()?, reference.parse()?, seeds.parse()?);
    let counts = samples.split(',').map(str::parse).collect::<Result<Vec<u64>, _>>()?;
    for name in scenes {
        measure(name, [width, width * 2 / 3], reference, seeds, &counts)?;
    }
    Ok(())
}

fn measure(name: &str, size: [usize; 2], reference: u64, seeds: u32, counts: &[u64]) -> Result<(), Box<dyn Error>> {
    let world = World::new(varied(name)?)?;
    let render = |settings: &Settings, samples: u64| {
        let mut film = Film::new(size, settings.area(), world.layout(&[Layer::Beauty, Layer::Fibers]));
        world.render(settings, &mut film, 0..samples, &()).map(|_| film)
    };
    let truth = render(&Settings { seed: 999, ..Settings::new(size) }, reference)?;
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let fur: Vec<_> = pixels.filter(|&(x, y)| truth.mean(x, y, Layer::Fibers, 0) > 0.5).collect();
    let mut pictures = Vec::new();
    for &samples in counts {
        let one = |seed| render(&Settings { seed, radiance_cache: Some(8), ..Settings::new(size) }, samples);
        pictures.push((samples, (0..seeds).map(one).collect::<Result<Vec<Film>, _>>()?));
    }
    let everywhere: Vec<_> = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).collect();
    print!("{name:<20}");
    for (what, pixels) in [("fur", &fur), ("all", &everywhere)] {
        let light = |film: &Film| pixels.iter().map(|&(x, y)| film.mean(x, y, Layer::Beauty, 1)).sum::<f64>();
        let true_light = light(&truth);
        let unsure = pixels.iter().map(|&(x, y)| truth.error(x, y).powi(2)).sum::<f64>().sqrt() / true_light;
        print!("  {what} ±{unsure:.4}");
        for (samples, films) in &pictures {
            let ratios: Vec<f64> = films.iter().map(|film| light(film) / true_light).collect();
            let n = ratios.len() as f64;
            let mean = ratios.iter().sum::<f64>() / n;
            let error = (ratios.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0) / n).sqrt();
            print!("  {samples}: {mean:.4} ±{error:.4}");
        }
    }
    println!();
    Ok(())
}
