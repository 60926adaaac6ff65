//! Measures how many events of a path one thick fibre could replace.
//!
//! `cargo run --release --bin bunches -- [PATHS [SCENE...]]`
//!
//! `SCENE:white` has no pigment. Strands with near roots and tips form bunches of 4 to 4,096. Paths go through
//! the real strands. Successive events in one bunch are what one event of an aggregate would replace. So `saved` is the
//! number of events over the number of such runs: no aggregate with these members saves more, whatever it does inside.
//! Light sampling casts rays at every event, so rays go with events.

use glam::Vec4Swizzles;
use rayon::prelude::*;
use vellus::{Bcsdf, FiberFrame, Window};
use vellus_groom::scene;
use vellus_render::{Curves, Ray, Triangles};
use vellus_scene::{Scene, Strands};

const MEMBERS: [usize; 6] = [4, 16, 64, 256, 1024, 4096];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let paths: u64 = arguments.first().map_or(Ok(200_000), |text| text.parse())?;
    let names: Vec<&str> = match arguments.get(1..) {
        Some(names) if !names.is_empty() => names.iter().map(String::as_str).collect(),
        _ => vec!["hamster", "hamster:white", "polar-bear", "polar-bear:white", "raccoon", "raccoon:white"],
    };
    println!("scene            events | saved by bunches of {MEMBERS:?} | the same after the first event");
    for name in names {
        measure(name, paths)?;
    }
    Ok(())
}

/// Numbers of the bunches of each strand, for each number of members.
type Bunches = [Vec<u32>; 6];

fn bunches(strands: &Strands) -> Bunches {
    let feature = |i: usize| {
        let points = strands.strand(i);
        let (root, tip) = (points[0].xyz(), points[points.len() - 1].xyz());
        [root.x, root.y, root.z, tip.x, tip.y, tip.z]
    };
    let features: Vec<[f32; 6]> = (0..strands.len()).map(feature).collect();
    MEMBERS.map(|members| {
        let mut order: Vec<u32> = (0..strands.len() as u32).collect();
        let mut bunch = vec![0; strands.len()];
        let mut next = 0;
        split(&features, &mut order, members, &mut |part| {
            part.iter().for_each(|&i| bunch[i as usize] = next);
            next += 1;
        });
        bunch
    })
}

/// Halves the strands along the widest extent of their roots and tips until a part has at most so many members.
fn split(features: &[[f32; 6]], order: &mut [u32], members: usize, part: &mut impl FnMut(&[u32])) {
    if order.len() <= members {
        return part(order);
    }
    let extent = |k: usize| {
        let all = order.iter().map(|&i| features[i as usize][k]);
        let (low, high) = all.fold((f32::MAX, f32::MIN), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    let axis = (0..6).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| features[a as usize][axis].total_cmp(&features[b as usize][axis]));
    let (low, high) = order.split_at_mut(middle);
    split(features, low, members, part);
    split(features, high, members, part);
}

/// Numbers of events and of runs in one bunch, all and after the first event.
#[derive(Clone, Copy, Default)]
struct Counts {
    paths: u64,
    events: u64,
    runs: [u64; 6],
    late: u64,
    late_runs: [u64; 6],
}

impl Counts {
    fn join(mut self, other: Counts) -> Counts {
        self.paths += other.paths;
        self.events += other.events;
        self.late += other.late;
        for k in 0..6 {
            self.runs[k] += other.runs[k];
            self.late_runs[k] += other.late_runs[k];
        }
        self
    }
}

fn measure(name: &str, paths: u64) -> Result<(), Box<dyn std::error::Error>> {
    let (plain, white) = name.strip_suffix(":white").map_or((name, false), |plain| (plain, true));
    let scene = scene(plain, false).ok_or_else(|| format!("there is no scene {plain}"))?;
    let Scene { strands, meshes, looks, camera, .. } = scene;
    let eye = camera.ok_or("the scene has no camera")?.to_world.w_axis.truncate();
    let models = looks.iter().map(|look| {
        let mut fiber = look.fiber;
        if white {
            (fiber.sigma_ca, fiber.sigma_ma) = ([0.0; 3], [0.0; 3]);
        }
        Bcsdf::new(&fiber)
    });
    let models = models.collect::<Result<Vec<_>, _>>()?;
    let bunches: Vec<Bunches> = strands.iter().map(bunches).collect();
    let curves = Curves::new(strands);
    let triangles = Triangles::new(meshes);
    let largest = (0..curves.strands().len()).max_by_key(|&i| curves.strands()[i].len()).unwrap_or(0);
    let path = |index: u64| {
        let mut random = Random(index);
        let points = &curves.strands()[largest].points;
        let target = points[(random.next() * points.len() as f32) as usize % points.len()].xyz();
        let mut ray = Ray::new(eye, (target - eye).normalize());
        let (mut counts, mut last) = (Counts { paths: 1, ..Counts::default() }, [(usize::MAX, 0); 6]);
        let mut throughput = 1.0;
        for depth in 0.. {
            let Some(hit) = curves.intersect(&ray) else { break };
            // The skin ends a path: little light comes back from there.
            if triangles.occluded(&Ray { t_max: hit.entry.t, ..ray }) {
                break;
            }
            counts.events += 1;
            counts.late += u64::from(depth > 0);
            for k in 0..6 {
                let bunch = (hit.set, bunches[hit.set][k][hit.strand]);
                if bunch != last[k] {
                    counts.runs[k] += 1;
                    counts.late_runs[k] += u64::from(depth > 0);
                    last[k] = bunch;
                }
            }
            let axis = hit.segment.at(hit.entry.u);
            let frame = FiberFrame::new(hit.segment.tangent(hit.entry.u), axis.xyz(), axis.w);
            let h = frame.offset(ray.at(hit.entry.t), -ray.direction);
            let model = &models[curves.strands()[hit.set].look];
            let u = std::array::from_fn(|_| random.next());
            let Some(sample) = model.at(frame.to_local(-ray.direction), Window::near(h)).sample(u) else { break };
            throughput *= sample.weight.into_iter().fold(0.0, f32::max);
            // Russian roulette as in the renderer.
            if depth >= 2 {
                let survive = (2.0 * throughput).sqrt().min(1.0);
                if random.next() >= survive {
                    break;
                }
                throughput /= survive;
            }
            let direction = frame.to_world(sample.wi);
            let origin = frame.center() + frame.outward(direction) * (1.001 * frame.radius());
            ray = Ray::new(origin, direction);
        }
        counts
    };
    let counts = (0..paths).into_par_iter().map(path).reduce(Counts::default, Counts::join);
    let saved = counts.runs.map(|runs| format!("{:6.2}", counts.events as f64 / runs as f64)).concat();
    let late = counts.late_runs.map(|runs| format!("{:6.2}", counts.late as f64 / runs as f64)).concat();
    println!("{name:<16} {:6.2} | {saved} | {late}", counts.events as f64 / counts.paths as f64);
    Ok(())
}

/// SplitMix64.
struct Random(u64);

impl Random {
    /// A number in [0, 1).
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ x >> 31) >> 40) as f32 / 16_777_216.0
    }
}
