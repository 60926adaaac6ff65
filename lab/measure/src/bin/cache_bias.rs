//! Measures the mean colour of fur with a growing radiance cache beside that of full paths.
//!
//! `cargo run --release --bin cache_bias -- WIDTH REFERENCE SEEDS SAMPLES[,SAMPLES...] SCENE...`
//!
//! Scenes are those of `radiance_cache`. REFERENCE is the number of samples of full paths. Each cached picture starts
//! with 8 samples in the cache, and is rendered with SEEDS seeds: "±" is the standard error of their mean, the first
//! one that of the full paths.

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
    let light = |film: &Film| fur.iter().map(|&(x, y)| film.mean(x, y, Layer::Beauty, 1)).sum::<f64>();
    let all = light(&truth);
    let unsure = fur.iter().map(|&(x, y)| truth.error(x, y).powi(2)).sum::<f64>().sqrt() / all;
    print!("{name:<20} ±{unsure:.4}");
    for &samples in counts {
        let ratio = |seed| {
            let settings = Settings { seed, radiance_cache: Some(8), ..Settings::new(size) };
            render(&settings, samples).map(|film| light(&film) / all)
        };
        let ratios = (0..seeds).map(ratio).collect::<Result<Vec<f64>, _>>()?;
        let n = f64::from(seeds);
        let mean = ratios.iter().sum::<f64>() / n;
        let error = (ratios.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0) / n).sqrt();
        print!("  {samples}: {mean:.4} ±{error:.4}");
    }
    println!();
    Ok(())
}
