//! Kinds of fibres side by side: `cargo bench -p vellus --bench kinds`.

use divan::{Bencher, black_box};
use vellus::{Bcsdf, Fiber, ScatterExit, Species, Window};
use vellus_testing::queries;

const N: usize = 1024;

/// The exits of scattered light, and the sections other than a circle of one index.
const KINDS: [&str; 4] = ["open", "reflecting", "flat", "air"];

fn kind(fiber: Fiber, kind: &str) -> Fiber {
    match kind {
        "open" => fiber.with_exit(ScatterExit::Open),
        "flat" => Fiber { aspect_ratio: 0.667, ..fiber },
        "air" => Fiber { medulla_air: 1.0, ..fiber },
        _ => fiber,
    }
}

fn fur(name: &str) -> Fiber {
    kind(Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]), name)
}

/// Three colours: the whole time for a fibre at a textured hit.
#[divan::bench(args = KINDS)]
fn constructor(bencher: Bencher, name: &str) {
    let fiber = fur(name);
    bencher.bench_local(|| Bcsdf::new(black_box(&fiber)));
}

#[divan::bench(args = KINDS)]
fn constructor_grey(bencher: Bencher, name: &str) {
    let fiber = kind(Fiber::preset(Species::RedFox), name);
    bencher.bench_local(|| Bcsdf::new(black_box(&fiber)));
}

/// Prepares a hit in a window for each query.
fn prepare_each(bencher: Bencher, name: &str, window: fn(f32) -> Window) {
    let bcsdf = Bcsdf::new(&fur(name)).expect("the fibre is valid");
    let queries = queries(N);
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % N;
        let q = black_box(&queries[i]);
        bcsdf.with_hit(q.wo, window(q.h), |hit| black_box(hit).lobe_probabilities()[0])
    });
}

#[divan::bench(args = KINDS)]
fn prepare(bencher: Bencher, name: &str) {
    prepare_each(bencher, name, Window::near);
}

#[divan::bench(args = KINDS)]
fn far_prepare(bencher: Bencher, name: &str) {
    prepare_each(bencher, name, |_| Window::far());
}

/// Hits in a window, 64 of them, with sixteen queries each.
fn each(bencher: Bencher, name: &str, window: fn(f32) -> Window, f: fn(&vellus::Hit, &vellus_testing::Query) -> f32) {
    let bcsdf = Bcsdf::new(&fur(name)).expect("the fibre is valid");
    let queries = queries(N);
    let hits: Vec<_> = queries.iter().take(64).map(|q| bcsdf.at(q.wo, window(q.h))).collect();
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % N;
        f(black_box(&hits[i / 16]), black_box(&queries[i]))
    });
}

#[divan::bench(args = KINDS)]
fn eval(bencher: Bencher, name: &str) {
    each(bencher, name, Window::near, |hit, q| hit.eval(q.wi).total()[0]);
}

#[divan::bench(args = KINDS)]
fn sample(bencher: Bencher, name: &str) {
    each(bencher, name, Window::near, |hit, q| hit.sample(q.u).map_or(0.0, |s| s.weight[0]));
}

#[divan::bench(args = KINDS)]
fn far_eval(bencher: Bencher, name: &str) {
    each(bencher, name, |_| Window::far(), |hit, q| hit.eval(q.wi).total()[0]);
}

fn main() {
    divan::main();
}
