//! Measures what a radiance cache gains, and its error.
//!
//! `cargo run --release --bin radiance_cache -- [WIDTH [FILL [SAMPLES [REFERENCE [SCENE...]]]]]`
//!
//! `SCENE:white` has no pigment, `SCENE:black` much. `SCENE@front` has a sun behind the camera, `SCENE@back` one behind
//! the object, `SCENE@sky` a white sky. FILL is the number of samples of each pixel that fill the cache.
//!
//! Errors are mean squares over the pixels of fur, relative to the square of the converged picture plus 0.001, minus
//! the noise of the converged picture. A picture of n samples has the error variance/n + floor. The floor is the error
//! of the cache, and `known` what the picture estimates of it. `gain` is the processor time of plain path tracing to
//! the same error, over that of filling the cache and of SAMPLES cached samples. It counts the floor as error. `ideal`
//! is the ratio of variance × time, without the cache's time and error.

use std::error::Error;
use vellus_io::cpu_time;
use vellus_measure::varied;
use vellus_render::{Film, Layer, RadianceCache, Settings, World};

const SCENES: [&str; 6] = ["hamster", "hamster:white", "polar-bear", "raccoon", "cat", "hair"];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, default: u64| arguments.get(k).map_or(Ok(default), |text| text.parse());
    let (width, fill) = (number(0, 144)? as usize, number(1, 16)? as u32);
    let (samples, reference) = (number(2, 128)?, number(3, 1024)?);
    let names: Vec<&str> = match arguments.get(4..) {
        Some(names) if !names.is_empty() => names.iter().map(String::as_str).collect(),
        _ => SCENES.to_vec(),
    };
    println!(
        "scene           rays plain, cached  variance      floor    known  mean of R, G, B     ±       fill  MB  \
         gain ideal"
    );
    for name in names {
        measure(name, [width, width * 2 / 3], fill, samples, reference)?;
    }
    Ok(())
}

struct Picture {
    film: Film,
    seconds: f64,
    rays: f64,
}

fn render(
    world: &World,
    settings: &Settings,
    cache: Option<&RadianceCache>,
    samples: std::ops::Range<u64>,
) -> Result<Picture, Box<dyn Error>> {
    let mut film = Film::new(settings.size, settings.area(), world.layout(&[Layer::CacheError]));
    let start = cpu_time().ok_or("the system does not measure processor time")?;
    let count = samples.end - samples.start;
    let statistics = world.render_cached(settings, cache, &mut film, samples, &())?;
    let seconds = cpu_time().map_or(0.0, |end| (end - start).as_secs_f64());
    let rays = statistics.rays as f64 / ((film.width() * film.height()) as u64 * count) as f64;
    Ok(Picture { film, seconds, rays })
}

fn measure(name: &str, size: [usize; 2], fill: u32, samples: u64, reference: u64) -> Result<(), Box<dyn Error>> {
    let world = World::new(varied(name)?)?;
    let plain = Settings::new(size);
    let converged = render(&world, &Settings { seed: 999, ..plain }, None, 0..reference)?.film;
    let pixels = || (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let fur: Vec<(usize, usize)> = pixels().filter(|&(x, y)| converged.mean(x, y, Layer::Fibers, 0) > 0.5).collect();
    let color = |film: &Film, (x, y), c| film.mean(x, y, Layer::Beauty, c);
    let error = |film: &Film| {
        let relative = |p, c| {
            let truth = color(&converged, p, c);
            ((color(film, p, c) - truth).powi(2), truth * truth + 1e-3)
        };
        let sum: f64 = fur.iter().flat_map(|&p| (0..3).map(move |c| relative(p, c))).map(|(e, t)| e / t).sum();
        sum / (3 * fur.len()) as f64
    };
    // The error of an independent picture of n samples is variance × (1/n + 1/reference).
    let n = (samples / 4).max(1);
    let full = render(&world, &plain, None, 0..n)?;
    let variance = error(&full.film) / (1.0 / n as f64 + 1.0 / reference as f64);
    let noise = variance / reference as f64;
    let settings = Settings { radiance_cache: Some(fill), ..plain };
    let start = cpu_time().ok_or("the system does not measure processor time")?;
    let cache = world.fill_cache(&settings, full.film.layout(), &())?.ok_or("there is no cache")?;
    let filling = cpu_time().map_or(0.0, |end| (end - start).as_secs_f64());
    let few = render(&world, &settings, Some(&cache), 0..n)?;
    let many = render(&world, &settings, Some(&cache), 0..8 * n)?;
    let [a, b] = [&few, &many].map(|picture| error(&picture.film) - noise);
    let (floor, cached) = ((8.0 * b - a) / 7.0, (a - b) * n as f64 * 8.0 / 7.0);
    // What the picture knows about the error of its cache.
    let brightness = |&(x, y): &(usize, usize)| (0..3).map(|c| color(&converged, (x, y), c)).sum::<f64>() / 3.0;
    let known =
        |p: &(usize, usize)| many.film.mean(p.0, p.1, Layer::CacheError, 0).powi(2) / (brightness(p).powi(2) + 1e-3);
    let known = fur.iter().map(known).sum::<f64>() / fur.len() as f64;
    let mean = |film: &Film, c| fur.iter().map(|&p| color(film, p, c)).sum::<f64>();
    let mean: [f64; 3] = std::array::from_fn(|c| mean(&many.film, c) / mean(&converged, c));
    // The standard error of these ratios, without the noise of the cache.
    let squares = |film: &Film| fur.iter().map(|&(x, y)| film.error(x, y).powi(2)).sum::<f64>();
    let light =
        fur.iter().flat_map(|&p| (0..3).map(move |c| (p, c))).map(|(p, c)| color(&converged, p, c)).sum::<f64>();
    let unsure = 3.0 * (squares(&converged) + squares(&many.film)).sqrt() / light;
    let (per_full, per_cached) = (full.seconds / n as f64, many.seconds / (8 * n) as f64);
    let reached = cached / samples as f64 + floor;
    let gain = variance / reached * per_full / (filling + samples as f64 * per_cached);
    let ideal = variance * per_full / (cached * per_cached);
    let [red, green, blue] = mean;
    print!("{name:<18} {:5.2} {:5.2}  {variance:6.3} {cached:6.3} {floor:8.5} {known:8.5}", full.rays, many.rays);
    print!("  {red:.4} {green:.4} {blue:.4} {unsure:.4}");
    println!("  {filling:6.2} {:3.0} {gain:5.2} {ideal:5.2}", cache.bytes() as f64 * 1e-6);
    Ok(())
}
