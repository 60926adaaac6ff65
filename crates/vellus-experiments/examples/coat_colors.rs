//! Measures the colours of coats of random fibres, for the fit in `crates/vellus/src/coat`.

use rayon::prelude::*;
use std::io::Write;
use std::sync::Mutex;
use vellus::{Bcsdf, Exit, Fiber, Species};
use vellus_render::{Film, Filter, Layer, Mode, Settings, World};

struct Random(u64);
impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }
    fn between(&mut self, a: f32, b: f32) -> f32 {
        a + (b - a) * self.next()
    }
    fn log(&mut self, a: f32, b: f32) -> f32 {
        (self.between(a.ln(), b.ln())).exp()
    }
}

fn fiber(index: u64) -> Fiber {
    let mut r = Random(index.wrapping_mul(0x1234_5678_9abc_def1));
    let exit = if r.next() < 0.75 { Exit::Reflecting } else { Exit::Open };
    let kappa = if r.next() < 0.15 { 0.0 } else { r.between(0.2, 0.96) };
    let mut f = Fiber {
        eta: r.between(1.2, 1.75),
        kappa,
        alpha: r.between(0.0, 5f32.to_radians()),
        beta_m: r.log(2.0, 20.0).to_radians(),
        beta_n: r.log(1.3, 30.0).to_radians(),
        sigma_ca: [0.0; 3],
        sigma_ms: r.log(0.3, 8.0),
        sigma_ma: [0.0; 3],
        g: r.between(0.0, 0.85),
        layers: r.between(0.4, 2.5),
        exit,
        medulla_pigment: 0.3,
    };
    if r.next() < 0.25 {
        let species = Species::ALL[(r.next() * 10.0) as usize];
        f = if exit == Exit::Open { Fiber::published(species) } else { Fiber::preset(species) };
    }
    let split = [0.0, 0.3, 1.0][(r.next() * 3.0) as usize];
    let sigma = std::array::from_fn(|c| {
        let p = (c as f32 + r.next()) / 3.0;
        (0.003f32.ln() + p * (30f32 / 0.003).ln()).exp()
    });
    f.sigma_ca = sigma;
    f.sigma_ma = sigma.map(|s| s * split);
    f
}

fn main() {
    let mut args = std::env::args().skip(1);
    let out = args.next().unwrap();
    let first: u64 = args.next().unwrap().parse().unwrap();
    let count: u64 = args.next().unwrap().parse().unwrap();
    let samples: u64 = args.next().map_or(16, |x| x.parse().unwrap());
    let mut world = World::new(vellus_groom::reference_coat(Fiber::hair()).unwrap()).unwrap();
    let file = std::fs::OpenOptions::new().append(true).create(true).open(out).unwrap();
    let file = Mutex::new(file);
    for i in first..first + count {
        let start = std::time::Instant::now();
        let f = fiber(i);
        world.set_model(|_| Bcsdf::new(&f)).unwrap();
        let size = [24, 24];
        let settings =
            Settings { size, crop: None, mode: Mode::Near, filter: Filter::Box, seed: i as u32, max_depth: None };
        let mut film = Film::new(size, settings.area(), world.layout(&[Layer::Beauty]));
        world.render(&settings, &mut film, 0..samples, &()).unwrap();
        let mean = |c: usize, o: usize| {
            let all: Vec<f64> = (0..576)
                .filter(|i| (i / 24 + i % 24) % 2 == o)
                .map(|i| film.mean(i % 24, i / 24, Layer::Beauty, c))
                .collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        let c: Vec<f64> = (0..3).map(|c| 0.5 * (mean(c, 0) + mean(c, 1))).collect();
        let d: Vec<f64> = (0..3).map(|c| 0.5 * (mean(c, 0) - mean(c, 1)).abs()).collect();
        let mut file = file.lock().unwrap();
        writeln!(
            file,
            "{i},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{:.5},{:.5},{:.5},{:.5},{:.5},{:.5},{:.2}",
            f.eta,
            f.kappa,
            f.alpha,
            f.beta_m,
            f.beta_n,
            f.sigma_ms,
            f.g,
            f.layers,
            f.exit == Exit::Reflecting,
            f.sigma_ca[0],
            f.sigma_ca[1],
            f.sigma_ca[2],
            f.sigma_ma[1] / f.sigma_ca[1],
            0,
            c[0],
            c[1],
            c[2],
            d[0],
            d[1],
            d[2],
            start.elapsed().as_secs_f64()
        )
        .unwrap();
    }
    let _ = [0].par_iter();
}
