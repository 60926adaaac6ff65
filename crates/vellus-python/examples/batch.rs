//! The queries of the Python package in Rust alone: reference values for its tests, and the other side of its
//! benchmark.
//!
//! `batch values` writes JSON with arguments and results. `batch bench COUNT` reads lines from standard input, and
//! answers each with the seconds that COUNT near-field queries took.

use rayon::prelude::*;
use serde_json::{Value, json};
use std::io::BufRead;
use std::time::Instant;
use vellus::glam::Vec3;
use vellus::wide::f32x8;
use vellus::{Bcsdf, Fiber, Lobes, Sample, Tables, Window, packed};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Uniform numbers in [0, 1): a Weyl sequence, which needs no library.
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed >> 40) as f32 / (1u64 << 24) as f32
    }

    fn direction(&mut self) -> [f32; 3] {
        let (x, phi) = (2.0 * self.next() - 1.0, std::f32::consts::TAU * self.next());
        let r = (1.0 - x * x).max(0.0).sqrt();
        Vec3::new(x, r * phi.cos(), r * phi.sin()).normalize().to_array()
    }
}

/// One number of eight queries.
fn eight(x: impl Fn(usize) -> f32) -> f32x8 {
    f32x8::new(std::array::from_fn(x))
}

fn vectors(all: &[[f32; 3]]) -> [f32x8; 3] {
    [0, 1, 2].map(|c| eight(|i| all[i.min(all.len() - 1)][c]))
}

fn lane(lobes: &Lobes<f32x8>, i: usize) -> [[f32; 3]; 6] {
    lobes.0.map(|lobe| lobe.map(|c| c.to_array()[i]))
}

fn drawn(sample: Option<Sample>) -> Value {
    sample.map_or(Value::Null, |s| json!([s.wi.to_array(), s.pdf, s.weight, s.lobe as usize]))
}

/// The number of rows, and the sum of the bits of all numbers, each times its place from 1 on, modulo 2⁶⁴.
fn checksum(rows: &[[f32; 4]]) -> [u64; 2] {
    let bits = rows.as_flattened().iter().map(|x| u64::from(x.to_bits()));
    [rows.len() as u64, bits.zip(1..).fold(0, |sum, (x, place)| x.wrapping_mul(place).wrapping_add(sum))]
}

/// Queries of one fibre: eight in the near field, eight with windows, eight with one window.
fn values(name: &str) -> Result<Value> {
    let bcsdf = Bcsdf::new(&Fiber::named(name)?)?;
    let mut uniform = Uniform(name.len() as u64);
    let directions = |uniform: &mut Uniform| -> Vec<[f32; 3]> { (0..8).map(|_| uniform.direction()).collect() };
    let (wi, wo) = (directions(&mut uniform), directions(&mut uniform));
    let h: Vec<f32> = (0..8).map(|_| 2.0 * uniform.next() - 1.0).collect();
    let u: Vec<[f32; 5]> = (0..8).map(|_| std::array::from_fn(|_| uniform.next())).collect();
    let windows: Vec<[f32; 2]> = h.iter().map(|h| Window::pixel(*h, 0.3).ends()).collect();

    let hits = bcsdf.at8(vectors(&wo), eight(|i| h[i]));
    let (f, pdf) = hits.eval_pdf8(vectors(&wi));
    let energy = hits.energy();
    let samples = hits.sample8([0, 1, 2, 3].map(|c| eight(|i| u[i][c])));
    let near = json!({
        "eval": (0..8).map(|i| lane(&f, i)).collect::<Vec<_>>(),
        "pdf": pdf.to_array(),
        "energy": (0..8).map(|i| lane(&energy, i)).collect::<Vec<_>>(),
        "sample": samples.into_iter().map(drawn).collect::<Vec<_>>(),
    });
    let vector = |v: &[f32; 3]| Vec3::from_array(*v);
    let each: Vec<Value> = (0..8)
        .map(|i| {
            let hit = bcsdf.at(vector(&wo[i]), Window::range(windows[i][0], windows[i][1]));
            let (f, pdf) = hit.eval_pdf(vector(&wi[i]));
            json!({"eval": f.0, "pdf": pdf, "energy": hit.energy().0, "sample": drawn(hit.sample(u[i]))})
        })
        .collect();
    let (f, pdf) = bcsdf.at(vector(&wo[0]), Window::far()).eval_pdf8(vectors(&wi));
    let far = json!({"eval": (0..8).map(|i| lane(&f, i)).collect::<Vec<_>>(), "pdf": pdf.to_array()});
    let shaders = json!({
        "tables": checksum(&packed::tables(Tables::shipped()).rows),
        "record": checksum(&packed::fiber(&bcsdf)),
        "color": checksum(&packed::color(&bcsdf)),
        "far": checksum(&packed::far(&bcsdf).rows),
    });
    let mut case =
        json!({"wi": wi, "wo": wo, "h": h, "u": u, "windows": windows, "near": near, "window": each, "far": far});
    case["shaders"] = shaders;
    Ok(case)
}

/// Near-field queries on all cores, in groups of eight.
fn batch(bcsdf: &Bcsdf, wi: &[[f32; 3]], wo: &[[f32; 3]], h: &[f32]) -> Vec<[f32; 3]> {
    const CHUNK: usize = 512;
    let mut results = vec![[0.0; 3]; h.len()];
    let arguments = wi.par_chunks(CHUNK).zip(wo.par_chunks(CHUNK)).zip(h.par_chunks(CHUNK));
    results.par_chunks_mut(CHUNK).zip(arguments).for_each(|(results, ((wi, wo), h))| {
        let groups = wi.chunks(8).zip(wo.chunks(8)).zip(h.chunks(8));
        for (results, ((wi, wo), h)) in results.chunks_mut(8).zip(groups) {
            let hits = bcsdf.at8(vectors(wo), eight(|i| h[i.min(h.len() - 1)]));
            let f = hits.eval_pdf8(vectors(wi)).0.total().map(f32x8::to_array);
            results.iter_mut().enumerate().for_each(|(i, result)| *result = [0, 1, 2].map(|c| f[c][i]));
        }
    });
    results
}

fn bench(count: usize) -> Result<()> {
    let bcsdf = Bcsdf::new(&Fiber::named("red-fox")?)?;
    let mut uniform = Uniform(1);
    let (mut wi, mut wo, mut h) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..count {
        wi.push(uniform.direction());
        wo.push(uniform.direction());
        h.push(2.0 * uniform.next() - 1.0);
    }
    for line in std::io::stdin().lock().lines() {
        line?;
        let start = Instant::now();
        let results = batch(&bcsdf, &wi, &wo, &h);
        let seconds = start.elapsed().as_secs_f64();
        println!("{seconds} {}", results.iter().flatten().map(|x| f64::from(*x)).sum::<f64>());
    }
    Ok(())
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["values"] => {
            let names = ["red-fox", "cat-published", "human", "deer"];
            let all = names.map(|name| values(name).map(|v| (name.to_owned(), v)));
            let all = all.into_iter().collect::<Result<serde_json::Map<String, Value>>>()?;
            println!("{}", Value::Object(all));
            Ok(())
        }
        ["bench", count] => bench(count.parse()?),
        _ => Err("usage: batch values | bench COUNT".into()),
    }
}
