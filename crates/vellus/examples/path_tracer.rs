//! A complete path tracer of a ball of hair: `cargo run --release -p vellus --example path_tracer` writes
//! `hair_ball.ppm`.
//!
//! Straight cylinders stand on a black sphere. One distant light and a dim sky light them. The model comes from
//! `vellus`; everything else is here.

use std::f32::consts::TAU;
use std::io::Write;
use vellus::glam::Vec3;
use vellus::{Bcsdf, Color, Error, Fiber, FiberFrame, Window};

const STRANDS: usize = 1500;
const RADIUS: f32 = 0.008;
const SKY: f32 = 0.25;

/// A strand from root to tip.
struct Strand {
    root: Vec3,
    axis: Vec3,
    length: f32,
}

/// A small random number generator (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    fn direction(&mut self) -> Vec3 {
        let (x, (sin, cos)) = (2.0 * self.next() - 1.0, (TAU * self.next()).sin_cos());
        let r = (1.0 - x * x).sqrt();
        Vec3::new(x, r * cos, r * sin)
    }
}

fn hair_ball() -> Vec<Strand> {
    let mut random = Random(1);
    let strand = |_| {
        let root = 0.6 * random.direction();
        let axis = (root + 0.15 * random.direction() + 0.1 * Vec3::NEG_Y).normalize();
        Strand { root, axis, length: 0.3 + 0.1 * random.next() }
    };
    (0..STRANDS).map(strand).collect()
}

/// The nearest intersection with a strand: its distance and index. An index of `STRANDS` is the black sphere.
fn intersect(strands: &[Strand], origin: Vec3, ray: Vec3) -> Option<(f32, usize)> {
    let quadratic = |a: f32, b: f32, c: f32| {
        let root = b * b - a * c;
        (root > 0.0 && a > 1e-9).then(|| (-b - root.sqrt()) / a).filter(|t| *t > 1e-4)
    };
    let ball = quadratic(1.0, origin.dot(ray), origin.length_squared() - 0.36).map(|t| (t, STRANDS));
    // Most rays miss the ball and its hair.
    let closest = origin - ray * origin.dot(ray);
    if closest.length_squared() > 1.1 {
        return None;
    }
    let hits = strands.iter().enumerate().filter_map(|(i, strand)| {
        let (from, along) = (origin - strand.root, ray.dot(strand.axis));
        let across = from - strand.axis * from.dot(strand.axis);
        let ray_across = ray - strand.axis * along;
        let t =
            quadratic(ray_across.length_squared(), across.dot(ray_across), across.length_squared() - RADIUS * RADIUS)?;
        (0.0..strand.length).contains(&(from.dot(strand.axis) + t * along)).then_some((t, i))
    });
    hits.chain(ball).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Radiance along a ray: next-event estimation of the distant light, and BCSDF sampling for the rest.
fn radiance(strands: &[Strand], bcsdf: &Bcsdf, mut origin: Vec3, mut ray: Vec3, random: &mut Random) -> Vec3 {
    let light = Vec3::new(-0.5, 0.7, 0.6).normalize();
    let (mut sum, mut throughput) = (Vec3::ZERO, Vec3::ONE);
    for _ in 0..24 {
        let Some((t, index)) = intersect(strands, origin, ray) else { return sum + SKY * throughput };
        let Some(strand) = strands.get(index) else { return sum };
        let position = origin + t * ray;
        let center = strand.root + strand.axis * (position - strand.root).dot(strand.axis);
        let frame = FiberFrame::new(strand.axis, center, RADIUS);
        let hit = bcsdf.at(frame.to_local(-ray), Window::near(frame.offset(position, -ray)));
        // The model includes the path through the fibre, so rays leave from the side that they point to.
        let leave = |direction: Vec3| center + 1.01 * RADIUS * frame.outward(direction);
        if intersect(strands, leave(light), light).is_none() {
            sum += 5.0 * throughput * Vec3::from(hit.eval(frame.to_local(light)).total());
        }
        let Some(sample) = hit.sample(std::array::from_fn(|_| random.next())) else { return sum };
        throughput *= Vec3::from(sample.weight);
        ray = frame.to_world(sample.wi);
        origin = leave(ray);
    }
    sum
}

/// The picture's rows from the top, RGB in sRGB.
fn render(size: usize, samples: usize) -> Result<Vec<u8>, Error> {
    let fiber = Fiber::hair().with_color(Color::Melanin { eumelanin: 0.6, pheomelanin: 0.4 })?;
    let (bcsdf, strands) = (Bcsdf::new(&fiber)?, hair_ball());
    let mut random = Random(2);
    let mut pixels = Vec::new();
    for k in 0..size * size {
        let mut sum = Vec3::ZERO;
        for _ in 0..samples {
            let at = |i: usize, u: f32| 0.64 * ((i as f32 + u) / size as f32 - 0.5);
            let ray = Vec3::new(at(k % size, random.next()), -at(k / size, random.next()), -1.0).normalize();
            sum += radiance(&strands, &bcsdf, Vec3::new(0.0, 0.0, 4.0), ray, &mut random);
        }
        pixels.extend((sum / samples as f32).to_array().map(|x| (255.0 * x.clamp(0.0, 1.0).powf(1.0 / 2.2)) as u8));
    }
    Ok(pixels)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let size = 160;
    let mut file = std::fs::File::create("hair_ball.ppm")?;
    writeln!(file, "P6 {size} {size} 255")?;
    Ok(file.write_all(&render(size, 16)?)?)
}

#[test]
fn hair_is_brown_before_a_grey_sky() {
    let (size, pixels) = (24, render(24, 4).unwrap());
    let sum = |c: usize| -> u32 { (0..size * size).map(|k| u32::from(pixels[3 * k + c])).sum() };
    let sky = (255.0 * SKY.powf(1.0 / 2.2)) as u8;
    assert!(pixels[..3] == [sky; 3] && sum(0) > sum(1) && sum(1) > sum(2), "{:?}", &pixels[..3]);
}
