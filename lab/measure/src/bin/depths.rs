//! Measures how rays, time and light are divided among the scattering events of a path, and what paths through thinner
//! fur would save.
//!
//! `cargo run --release --bin depths -- [SAMPLES [WIDTH [SCENE...]]]`
//!
//! `SCENE:white` has no pigment. The picture is rendered with paths of at most k events and of any length. Differences
//! are the rays, the processor time and the light of later events. The same is done with a quarter and a sixteenth of
//! the strands, which are wider by as much. `hybrid` adds the early events of the full fur and the late events of the
//! thin fur: its time and mean colour are those of a path that changes to the thin fur after k events. The colour
//! assumes that the light that arrives there is the same.

use vellus_groom::{scene, thin};
use vellus_io::cpu_time;
use vellus_render::{Film, Layer, Settings, World};

const DEPTHS: [Option<u32>; 6] = [Some(1), Some(2), Some(3), Some(5), Some(8), None];
const SHARES: [f32; 3] = [1.0, 0.25, 0.0625];

/// Rays a sample, processor seconds, mean colour.
type Row = (f64, f64, [f64; 3]);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let samples: u64 = arguments.first().map_or(Ok(32), |text| text.parse())?;
    let width: usize = arguments.get(1).map_or(Ok(120), |text| text.parse())?;
    let names: Vec<&str> = match arguments.get(2..) {
        Some(names) if !names.is_empty() => names.iter().map(String::as_str).collect(),
        _ => vec!["hamster", "hamster:white", "polar-bear", "raccoon"],
    };
    for name in names {
        let tables: Vec<Vec<Row>> =
            SHARES.iter().map(|&share| table(name, share, samples, width)).collect::<Result<_, _>>()?;
        println!("{name}\nevents    rays   time  light | thin: rays, time, colour of the hybrid");
        let [full, thinner @ ..] = &tables[..] else { return Ok(()) };
        let (all, last) = (full[full.len() - 1], full.len() - 1);
        let brightness = |row: &Row| row.2.iter().sum::<f64>();
        for (k, depth) in DEPTHS.iter().enumerate() {
            let depth = depth.map_or("all".to_owned(), |depth| depth.to_string());
            let light = brightness(&full[k]) / brightness(&all);
            print!("{depth:>6} {:7.2} {:6.2} {light:6.3} |", full[k].0, full[k].1 / all.1);
            for few in thinner {
                let late = |of: fn(&Row) -> f64| of(&few[last]) - of(&few[k]);
                let time = (full[k].1 + late(|row| row.1)) / all.1;
                let color: [f64; 3] = std::array::from_fn(|c| (full[k].2[c] + few[last].2[c] - few[k].2[c]) / all.2[c]);
                let rays = full[k].0 + late(|row| row.0);
                print!(" {rays:6.2} {time:5.2} {:.3} {:.3} {:.3} |", color[0], color[1], color[2]);
            }
            println!();
        }
    }
    Ok(())
}

fn table(name: &str, share: f32, samples: u64, width: usize) -> Result<Vec<Row>, Box<dyn std::error::Error>> {
    let (plain, white) = name.strip_suffix(":white").map_or((name, false), |plain| (plain, true));
    let mut scene = scene(plain, false).ok_or("the scene is missing")?;
    for strands in scene.all_strands_mut().filter(|strands| strands.len() > 1000) {
        if white {
            strands.varying.clear();
        }
        *strands = thin(strands, share);
    }
    if white {
        scene.looks.iter_mut().for_each(|look| (look.fiber.sigma_ca, look.fiber.sigma_ma) = ([0.0; 3], [0.0; 3]));
    }
    let world = World::new(scene)?;
    let mut rows = Vec::new();
    for max_depth in DEPTHS {
        let settings = Settings { max_depth, ..Settings::new([width, width * 2 / 3]) };
        let mut film = Film::new(settings.size, settings.area(), world.layout(&[Layer::Beauty]));
        let start = cpu_time().ok_or("the system does not measure processor time")?;
        let statistics = world.render(&settings, &mut film, 0..samples, &())?;
        let seconds = cpu_time().map_or(0.0, |end| (end - start).as_secs_f64());
        let pixels = film.width() * film.height();
        let mean = |c: usize| {
            (0..pixels).map(|i| film.mean(i % film.width(), i / film.width(), Layer::Beauty, c)).sum::<f64>()
        };
        rows.push((statistics.rays as f64 / (pixels as u64 * samples) as f64, seconds, std::array::from_fn(mean)));
    }
    Ok(rows)
}
