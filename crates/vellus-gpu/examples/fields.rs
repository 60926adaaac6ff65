//! The time of queries in the near field, in the near field with a colour of their own (`vellus_coat_pigment`), and in
//! the far field on this machine's GPU, interleaved: medians.
//!
//! `cargo run --release -p vellus-gpu --example fields -- [QUERIES] [ROUNDS]`

use bytemuck::cast_slice;
use std::time::Instant;
use vellus::{Bcsdf, Fiber, Species};
use vellus_gpu::{Answer, Device, Field, Queries, Query, shader_color, shader_fiber, shader_tables};
use vellus_testing::Uniform;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Seconds of queries with a colour of their own. Their shader is compiled before.
fn colored(device: &Device, fiber: &Bcsdf<'_>, queries: &[Query]) -> Result<f64, Box<dyn std::error::Error>> {
    let pigment = "vellus_coat_pigment(VELLUS_FIBER_ROWS, query.u.xyz)";
    let hit = format!("vellus_hit_colored(&hit, query.fiber, VELLUS_FIBER_ROWS, {pigment},");
    let shader = Field::Near.shader().replace("vellus_hit(&hit, query.fiber,", &hit);
    let (tables, mut records) = (shader_tables(), shader_fiber(fiber).to_vec());
    records.extend(shader_color(fiber));
    let run = |queries: &[Query]| -> Result<f64, Box<dyn std::error::Error>> {
        let inputs = [cast_slice(&tables), cast_slice(&records), cast_slice(queries)];
        let start = Instant::now();
        let groups = queries.len().div_ceil(64) as u32;
        device.compute::<Answer>(&shader, Field::Near.entry(), &inputs, queries.len(), groups)?;
        Ok(start.elapsed().as_secs_f64())
    };
    // A driver keeps what it compiled the first time.
    run(&queries[..1])?;
    let compiled = run(&queries[..1])?;
    Ok(run(queries)? - compiled)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<usize>());
    let count = arguments.next().transpose()?.unwrap_or(1 << 20);
    let rounds = arguments.next().transpose()?.unwrap_or(9).max(1);
    let device = Device::open()?;
    println!("{}: {count} queries, {rounds} rounds", device.name());
    println!("preset        near ns   colored/near   far/near");
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
        let mut times = [const { Vec::new() }; 3];
        for _ in 0..rounds {
            for (field, times) in fields.iter().zip(&mut times) {
                let start = Instant::now();
                field.run(&queries)?;
                times.push(start.elapsed().as_secs_f64() / count as f64 * 1e9);
            }
            times[2].push(colored(&device, &fiber[0], &queries)? / count as f64 * 1e9);
        }
        let [near, far, colored] = times.map(median);
        println!("{:<12} {near:>8.1} {:>14.2} {:>10.2}", species.to_string(), colored / near, far / near);
    }
    Ok(())
}
