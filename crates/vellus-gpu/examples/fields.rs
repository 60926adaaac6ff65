//! The time of queries in the near and in the far field on this machine's GPU, in turns: medians.
//!
//! `cargo run --release -p vellus-gpu --example fields -- [QUERIES] [ROUNDS]`

use std::time::Instant;
use vellus::{Bcsdf, Fiber, Species};
use vellus_gpu::{Device, Queries, Query};
use vellus_testing::Uniform;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<usize>());
    let count = arguments.next().transpose()?.unwrap_or(1 << 20);
    let rounds = arguments.next().transpose()?.unwrap_or(9).max(1);
    let device = Device::open()?;
    println!("{}: {count} queries, {rounds} rounds", device.name());
    println!("preset        near ns   far ns   far/near");
    let mut random = Uniform(1);
    let mut direction = || vellus::direction(random.within(-1.5, 1.5), random.within(-3.1, 3.1)).to_array();
    let directions: Vec<[[f32; 3]; 2]> = (0..count).map(|_| [direction(), direction()]).collect();
    let mut random = Uniform(2);
    let queries: Vec<Query> = directions
        .iter()
        .map(|[wo, wi]| Query { wo: *wo, wi: *wi, h: random.within(-1.0, 1.0) as f32, fiber: 0, u: random.numbers() })
        .collect();
    for species in [Species::Raccoon, Species::Cat, Species::Human] {
        let fiber = [Bcsdf::new(&Fiber::preset(species))?];
        let fields = [Queries::new(&device, &fiber)?, Queries::far_field(&device, &fiber)?];
        let mut times = [const { Vec::new() }; 2];
        for _ in 0..rounds {
            for (field, times) in fields.iter().zip(&mut times) {
                let start = Instant::now();
                field.run(&queries)?;
                times.push(start.elapsed().as_secs_f64() / count as f64 * 1e9);
            }
        }
        let [near, far] = times.map(median);
        println!("{:<12} {near:>8.1} {far:>8.1} {:>10.2}", species.to_string(), far / near);
    }
    Ok(())
}
