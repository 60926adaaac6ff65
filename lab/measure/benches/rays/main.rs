//! Rays per second through fur, one thread, beside Embree on the same segments if it is installed:
//! `cargo bench -p vellus-measure --bench rays -- [STRANDS …] [linear|bspline]`.
//!
//! The scene is a furry ball of radius 1 with cubic B-splines of 20 segments. Primary rays come from a camera. Bounce
//! rays start where primary rays enter, in random directions. Times are processor times of the thread. The passes
//! alternate, and the ratio is the median of five.

mod embree;

use glam::{Vec3, Vec4Swizzles};
use rustix::time::{ClockId, clock_gettime};
use vellus_render::{Curves, Ray};
use vellus_scene::{Basis, Strands};

struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn sphere(&mut self) -> Vec3 {
        let z = 1.0 - 2.0 * self.next();
        let (sin, cos) = (std::f32::consts::TAU * self.next()).sin_cos();
        let s = (1.0 - z * z).sqrt();
        Vec3::new(s * cos, s * sin, z)
    }
}

fn ball(count: usize, basis: Basis, radius: f32) -> Strands {
    let mut random = Random(7);
    let points = if basis == Basis::Linear { 21 } else { 23 };
    let mut all = Vec::with_capacity(count * points);
    for _ in 0..count {
        let n = random.sphere();
        let swirl = Vec3::new(-n.y, n.x, 0.0);
        let comb = 0.55 * swirl + Vec3::new(0.0, 0.0, -0.55) + 0.3 * random.sphere();
        let comb = comb - n * comb.dot(n) * 0.7;
        let d = (n + 0.15 * random.sphere()).normalize();
        let length = 0.4 * (0.8 + 0.4 * random.next());
        for k in 0..points {
            let t = (k as f32 - if points == 23 { 1.0 } else { 0.0 }) / 20.0;
            let p = n + length * (d * t * (1.0 - 0.35 * t) + 0.75 * t * t * comb);
            all.push(p.extend(radius * (1.0 - 0.9 * t.clamp(0.0, 1.0))));
        }
    }
    let starts = (0..=count).map(|i| (i * points) as u32).collect();
    Strands {
        name: "ball".to_owned(),
        basis,
        starts,
        points: all,
        moved: None,
        normals: None,
        root_uv: None,
        look: 0,
        varying: vec![],
    }
}

/// Millions of rays per second of this thread's processor time, in one pass.
fn rate(rays: &[Ray], f: impl Fn(&Ray) -> bool) -> f64 {
    let start = time(ClockId::ThreadCPUTime);
    std::hint::black_box(rays.iter().filter(|ray| f(ray)).count());
    rays.len() as f64 / (time(ClockId::ThreadCPUTime) - start) * 1e-6
}

/// Processor time of this thread, seconds.
fn time(clock: ClockId) -> f64 {
    let time = clock_gettime(clock);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

fn median(mut values: [f64; 5]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[2]
}

fn main() {
    let counts: Vec<usize> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let counts = if counts.is_empty() { vec![10_000, 200_000] } else { counts };
    for count in counts {
        let radius = if count > 50_000 { 0.0013 } else { 0.004 };
        for (name, basis) in [("linear", Basis::Linear), ("bspline", Basis::BSpline)] {
            // The bases from the command line, or both.
            let others = std::env::args().any(|a| a == "linear" || a == "bspline");
            if others && std::env::args().all(|a| a != name) {
                continue;
            }
            let strands = ball(count, basis, radius);
            let (start, copy) = (time(ClockId::ProcessCPUTime), strands.clone());
            let curves = Curves::new(vec![copy]);
            let millions = curves.segments() as f64 * 1e-6;
            println!(
                "{count} × 20 {basis:?}: {:.2} s of processor time to build a million segments, {:.1} bytes a segment",
                (time(ClockId::ProcessCPUTime) - start) / millions,
                curves.bytes() as f64 * 1e-6 / millions
            );
            let mut random = Random(1);
            let eye = Vec3::new(0.0, -12.0, 0.0);
            let primary: Vec<Ray> = (0..200_000)
                .map(|i| {
                    // Rays are in the order of a camera, row by row.
                    let (x, y) = ((i % 500) as f32 / 250.0 - 1.0, (i / 500) as f32 / 200.0 - 1.0);
                    Ray::new(eye, (Vec3::new(1.4 * x, 0.0, 1.4 * y) - eye).normalize())
                })
                .collect();
            let bounce: Vec<Ray> = primary
                .iter()
                .filter_map(|ray| curves.intersect(ray))
                .map(|hit| {
                    let axis = hit.segment.at(hit.entry.u);
                    let d = random.sphere();
                    let out = d - hit.segment.tangent(hit.entry.u) * d.dot(hit.segment.tangent(hit.entry.u));
                    Ray::new(axis.xyz() + out.normalize() * axis.w * 1.001, d)
                })
                .collect();
            let yardstick = Yardstick::new(&strands);
            let sets = [("primary", &primary), ("bounce", &bounce), ("shadow", &bounce)];
            for (name, rays) in sets {
                let ours = || {
                    if name == "shadow" {
                        rate(rays, |ray| curves.occluded(ray))
                    } else {
                        rate(rays, |ray| curves.intersect(ray).is_some())
                    }
                };
                println!("  {name:8} {}", yardstick.beside(&curves, name, rays, ours));
            }
        }
    }
}

/// The other ray tracer.
struct Yardstick(Result<embree::Embree, String>);

impl Yardstick {
    fn new(strands: &Strands) -> Self {
        let start = time(ClockId::ProcessCPUTime);
        let embree = embree::Embree::new(strands);
        let millions = strands.segments() as f64 * 1e-6;
        println!("  Embree: {:.2} s of processor time a million", (time(ClockId::ProcessCPUTime) - start) / millions);
        Yardstick(embree)
    }

    /// Returns both rates, their ratio, and the share of rays with the same result.
    fn beside(&self, curves: &Curves, name: &str, rays: &[Ray], ours: impl Fn() -> f64) -> String {
        let embree = match &self.0 {
            Ok(embree) => embree,
            Err(why) => return format!("{:.3} Mrays/s (no Embree: {why})", median(std::array::from_fn(|_| ours()))),
        };
        let (intersect, occluded) = (embree.intersect(), embree.occluded());
        let theirs =
            || if name == "shadow" { rate(rays, &occluded) } else { rate(rays, |ray| intersect(ray).is_some()) };
        let passes: [[f64; 2]; 5] = std::array::from_fn(|_| [ours(), theirs()]);
        let same = |ray: &&Ray| match (curves.intersect(ray), intersect(ray)) {
            (Some(a), Some(b)) => (a.entry.t - b).abs() < 0.01,
            (None, None) => true,
            _ => false,
        };
        let agree = rays.iter().filter(same).count() as f64 / rays.len() as f64;
        format!(
            "{:.3} Mrays/s, Embree {:.3}: ratio {:.2}, {:.2} % agree",
            median(passes.map(|p| p[0])),
            median(passes.map(|p| p[1])),
            median(passes.map(|p| p[0] / p[1])),
            100.0 * agree
        )
    }
}
