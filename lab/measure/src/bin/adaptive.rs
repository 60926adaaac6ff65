//! Measures what adaptive sampling could gain in the built-in scenes.
//!
//! `cargo run --release --bin adaptive -- [SAMPLES [WIDTH [SCENE...]]]`
//!
//! It renders each tile alone, and measures its processor time. The variance of a sample is known from all samples. A
//! pilot of the first 16 samples gives the estimate on which the renderer decides.
//!
//! The columns are the time of uniform sampling over that of adaptive sampling, for the same noise: the root mean
//! square of the pixels' standard errors. Above 1, adaptive sampling gains.
//!
//! - `goal`: each tile ends when it reaches the noise of the whole picture.
//! - `oracle`: samples of a tile in proportion to its standard deviation over the root of its time, which is best.
//! - `no time`: in proportion to the pilot's standard deviation of the tile and its eight neighbours, at least a
//!   quarter of the mean number of samples. The samples of the pilot count.
//! - `pilot`: the same over the root of 0.2 + the coverage by fibres, which is what the renderer does with `--noise`.
//! - `worst`: time to bring each tile, not the mean, to one noise.

use vellus_groom::{SCENES, scene};
use vellus_io::cpu_time;
use vellus_render::{Film, Layer, Settings, World};

const PILOT: u64 = 16;
/// The sides of tiles, in pixels.
const SIDES: [usize; 2] = [8, 16];

/// Variance of a sample, mean over the pixels of a tile, from the pilot and from all samples; processor seconds a
/// sample; coverage by fibres; pixels.
#[derive(Clone, Copy)]
struct Tile {
    pilot: f64,
    variance: f64,
    time: f64,
    cover: f64,
    pixels: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let samples: u64 = arguments.first().map_or(Ok(256), |text| text.parse())?;
    let width: usize = arguments.get(1).map_or(Ok(192), |text| text.parse())?;
    let named = |name: &str| arguments.len() < 3 || arguments[2..].iter().any(|given| given == name);
    println!("scene        tile    goal  oracle no time   pilot   worst");
    for (name, _) in SCENES.iter().filter(|(name, _)| named(name)) {
        let world = World::new(scene(name, false).ok_or("the scene is missing")?)?;
        for side in SIDES {
            let size = [width / side * side, width * 2 / 3 / side * side];
            let counts = size.map(|n| n / side);
            let tiles: Result<Vec<Tile>, _> = (0..counts[0] * counts[1])
                .map(|i| tile(&world, size, [i % counts[0] * side, i / counts[0] * side, side, side], samples))
                .collect();
            report(name, side, &tiles?, counts);
        }
    }
    Ok(())
}

fn tile(world: &World, size: [usize; 2], crop: [usize; 4], samples: u64) -> Result<Tile, Box<dyn std::error::Error>> {
    let start = cpu_time().ok_or("the system does not measure processor time")?;
    let settings = Settings { crop: Some(crop), ..Settings::new(size) };
    let mut film = Film::new(settings.size, settings.area(), world.layout(&[Layer::Beauty]));
    let variance = |film: &Film| {
        let pixels = (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
        let sum: f64 = pixels.map(|(x, y)| film.error(x, y).powi(2)).sum();
        sum / (film.width() * film.height()) as f64 * film.samples() as f64
    };
    world.render(&settings, &mut film, 0..PILOT, &())?;
    let pilot = variance(&film);
    world.render(&settings, &mut film, PILOT..samples, &())?;
    let pixels = (crop[2] * crop[3]) as f64;
    let time = cpu_time().map_or(0.0, |end| (end - start).as_secs_f64()) / (samples as f64 * pixels);
    let covered = |i| film.mean(i % crop[2], i / crop[2], Layer::Fibers, 0);
    let cover = (0..crop[2] * crop[3]).map(covered).sum::<f64>() / pixels;
    Ok(Tile { pilot, variance: variance(&film), time, cover, pixels })
}

fn report(name: &str, side: usize, tiles: &[Tile], counts: [usize; 2]) {
    let all: f64 = tiles.iter().map(|tile| tile.pixels).sum();
    let mean = |value: &dyn Fn(usize) -> f64| (0..tiles.len()).map(|i| tiles[i].pixels * value(i)).sum::<f64>() / all;
    // The mean variance of a picture times its time: the smaller, the better. It does not depend on the number of
    // samples, `n` times a constant.
    let price = |n: &dyn Fn(usize) -> f64| mean(&|i| tiles[i].variance / n(i)) * mean(&|i| tiles[i].time * n(i));
    let uniform = price(&|_| 1.0);
    let least = 1e-3 * mean(&|i| tiles[i].variance).sqrt();
    let goal = uniform / price(&|i| tiles[i].variance.max(least * least));
    let oracle = uniform / price(&|i| tiles[i].variance.sqrt().max(least) / tiles[i].time.sqrt());
    let smooth: Vec<f64> = (0..tiles.len())
        .map(|i| {
            let [x, y] = [i % counts[0], i / counts[0]];
            let near = |c: usize, k: usize| c.saturating_sub(1)..(c + 2).min(counts[k]);
            let around: Vec<f64> =
                near(y, 1).flat_map(|v| near(x, 0).map(move |u| v * counts[0] + u)).map(|j| tiles[j].pilot).collect();
            let around = around.iter().sum::<f64>() / around.len() as f64;
            tiles[i].pilot.max(around).sqrt()
        })
        .collect();
    let gain = |need: &dyn Fn(usize) -> f64| {
        let usual = mean(need);
        uniform / price(&|i| need(i).max(0.25 * usual))
    };
    let (no_time, pilot) = (gain(&|i| smooth[i]), gain(&|i| smooth[i] / (0.2 + tiles[i].cover).sqrt()));
    let worst = tiles.iter().map(|tile| tile.variance).fold(0.0, f64::max);
    let worst = mean(&|i| tiles[i].time) * worst / mean(&|i| tiles[i].time * tiles[i].variance.max(0.1 * worst));
    println!("{name:12} {side:4} {goal:7.2} {oracle:7.2} {no_time:7.2} {pilot:7.2} {worst:7.2}");
}
