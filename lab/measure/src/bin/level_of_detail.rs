//! Measures what level of detail saves, and its bias.
//!
//! `cargo run --release --bin level_of_detail -- [WIDTH [SAMPLES [BIAS,... [SCENE...]]]]`
//!
//! `SCENE:white` has no pigment, `SCENE:black` much. `SCENE@front` has a sun behind the camera, `SCENE@back` one behind
//! the object, `SCENE@sky` a white sky. BIAS is that of `--lod`: 0 is `auto`.
//!
//! `share` is that of the segments that are left, `build` the processor time of simplification and hierarchies. `mean`
//! is the mean colour of fur over that with all strands, `±` its standard error. `bias` is the relative squared error
//! of the converged picture over pixels of fur: the squared difference over the squared colour plus 0.001, without the
//! noise of both pictures. `gain` is variance × processor time with all strands over that with fewer.

use std::error::Error;
use vellus_io::cpu_time;
use vellus_measure::varied;
use vellus_render::{Film, Layer, Lod, Settings, World, simplify};

const SCENES: [&str; 6] = ["hamster", "polar-bear", "raccoon", "cat", "hair", "hamsters"];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, default: u64| arguments.get(k).map_or(Ok(default), |text| text.parse());
    let (width, samples) = (number(0, 144)? as usize, number(1, 256)?);
    let levels = arguments.get(2).map_or("auto,1,2", String::as_str);
    let levels: Vec<Lod> = levels.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let names: Vec<&str> = match arguments.get(3..) {
        Some(names) if !names.is_empty() => names.iter().map(String::as_str).collect(),
        _ => SCENES.to_vec(),
    };
    println!("scene                 lod  share     MB  build  rays  mean of R, G, B     ±       bias  variance  gain");
    for name in names {
        measure(name, [width, width * 2 / 3], samples, &levels)?;
    }
    Ok(())
}

struct Picture {
    /// A quarter of the samples, and all.
    films: [Film; 2],
    rays: f64,
    seconds: f64,
}

fn render(world: &World, size: [usize; 2], seed: u32, samples: u64) -> Result<Picture, Box<dyn Error>> {
    let settings = Settings { seed, ..Settings::new(size) };
    let mut film = Film::new(size, settings.area(), world.layout(&[Layer::Beauty, Layer::Fibers]));
    let start = cpu_time().ok_or("the system does not measure processor time")?;
    let mut statistics = world.render(&settings, &mut film, 0..samples / 4, &())?;
    let few = film.clone();
    statistics += world.render(&settings, &mut film, samples / 4..samples, &())?;
    let seconds = cpu_time().map_or(0.0, |end| (end - start).as_secs_f64());
    let rays = statistics.rays as f64 / (size[0] * size[1]) as f64 / samples as f64;
    Ok(Picture { films: [few, film], rays, seconds })
}

fn measure(name: &str, size: [usize; 2], samples: u64, levels: &[Lod]) -> Result<(), Box<dyn Error>> {
    let scene = varied(name)?;
    let build = |lod: Lod| -> Result<(World, f64), Box<dyn Error>> {
        let mut scene = scene.clone();
        let start = cpu_time().ok_or("the system does not measure processor time")?;
        simplify(&mut scene, size, lod);
        let world = World::new(scene)?;
        Ok((world, cpu_time().map_or(0.0, |end| (end - start).as_secs_f64())))
    };
    let (world, seconds) = build(Lod::Off)?;
    let segments = world.segments() as f64;
    let [first, second] = [render(&world, size, 1, samples)?, render(&world, size, 2, samples)?];
    let converged = &first.films[1];
    let every = || (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let fur: Vec<(usize, usize)> = every().filter(|&(x, y)| converged.mean(x, y, Layer::Fibers, 0) > 0.5).collect();
    let color = |film: &Film, (x, y), c| film.mean(x, y, Layer::Beauty, c);
    let error = |film: &Film| {
        let relative = |p, c| {
            let truth = color(converged, p, c);
            (color(film, p, c) - truth).powi(2) / (truth * truth + 1e-3)
        };
        fur.iter().flat_map(|&p| (0..3).map(move |c| relative(p, c))).sum::<f64>() / (3 * fur.len()) as f64
    };
    let light = |film: &Film, c| fur.iter().map(|&p| color(film, p, c)).sum::<f64>();
    let squares = |film: &Film| fur.iter().map(|&(x, y)| film.error(x, y).powi(2)).sum::<f64>();
    // The error of an independent picture of n samples is variance × (1/n + 1/samples).
    let noise = 0.5 * error(&second.films[1]);
    let variance = noise * samples as f64;
    let row = |lod: Lod, (world, seconds): &(World, f64), picture: &Picture| {
        let [a, b] = [0, 1].map(|k| error(&picture.films[k]) - noise);
        let film = &picture.films[1];
        // The noise of four times as many samples is a quarter.
        let (bias, own) = ((4.0 * b - a) / 3.0, (a - b) * samples as f64 / 3.0);
        let [red, green, blue] = [0, 1, 2].map(|c| light(film, c) / light(converged, c));
        let all: f64 = (0..3).map(|c| light(converged, c)).sum();
        let unsure = 3.0 * (squares(converged) + squares(film)).sqrt() / all;
        let gain = variance * second.seconds / (own * picture.seconds);
        let (share, size) = (world.segments() as f64 / segments, world.bytes() as f64 * 1e-6);
        let level = lod.to_string();
        print!("{name:<18} {level:>6} {share:6.3} {size:6.0} {seconds:6.2} {:5.2}", picture.rays);
        println!("  {red:.4} {green:.4} {blue:.4} {unsure:.4} {bias:8.5} {own:9.3} {gain:5.2}");
    };
    row(Lod::Off, &(world, seconds), &second);
    for &lod in levels {
        let built = build(lod)?;
        let picture = render(&built.0, size, 3, samples)?;
        row(lod, &built, &picture);
    }
    Ok(())
}
