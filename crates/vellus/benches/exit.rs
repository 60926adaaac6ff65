//! Both exits of scattered light side by side: `cargo bench -p vellus --bench exit`.

use divan::{Bencher, black_box};
use vellus::{Bcsdf, Fiber, ScatterExit, Species, Window};
use vellus_testing::queries;

const N: usize = 1024;

fn fur(exit: ScatterExit) -> Fiber {
    Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]).with_exit(exit)
}

/// Three colours: the whole time for a fibre at a textured hit.
#[divan::bench(args = ScatterExit::ALL)]
fn constructor(bencher: Bencher, exit: ScatterExit) {
    let fiber = fur(exit);
    bencher.bench_local(|| Bcsdf::new(black_box(&fiber)));
}

#[divan::bench(args = ScatterExit::ALL)]
fn constructor_grey(bencher: Bencher, exit: ScatterExit) {
    let fiber = Fiber::preset(Species::RedFox).with_exit(exit);
    bencher.bench_local(|| Bcsdf::new(black_box(&fiber)));
}

/// Prepares a hit in a window for each query.
fn prepare_each(bencher: Bencher, exit: ScatterExit, window: fn(f32) -> Window) {
    let bcsdf = Bcsdf::new(&fur(exit)).expect("the fibre is valid");
    let queries = queries(N);
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % N;
        let q = black_box(&queries[i]);
        bcsdf.with_hit(q.wo, window(q.h), |hit| black_box(hit).lobe_probabilities()[0])
    });
}

#[divan::bench(args = ScatterExit::ALL)]
fn prepare(bencher: Bencher, exit: ScatterExit) {
    prepare_each(bencher, exit, Window::near);
}

#[divan::bench(args = ScatterExit::ALL)]
fn far_prepare(bencher: Bencher, exit: ScatterExit) {
    prepare_each(bencher, exit, |_| Window::far());
}

/// Hits in a window, 64 of them, with sixteen queries each.
fn each(
    bencher: Bencher,
    exit: ScatterExit,
    window: fn(f32) -> Window,
    f: fn(&vellus::Hit, &vellus_testing::Query) -> f32,
) {
    let bcsdf = Bcsdf::new(&fur(exit)).expect("the fibre is valid");
    let queries = queries(N);
    let hits: Vec<_> = queries.iter().take(64).map(|q| bcsdf.at(q.wo, window(q.h))).collect();
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % N;
        f(black_box(&hits[i / 16]), black_box(&queries[i]))
    });
}

#[divan::bench(args = ScatterExit::ALL)]
fn eval(bencher: Bencher, exit: ScatterExit) {
    each(bencher, exit, Window::near, |hit, q| hit.eval(q.wi).total()[0]);
}

#[divan::bench(args = ScatterExit::ALL)]
fn sample(bencher: Bencher, exit: ScatterExit) {
    each(bencher, exit, Window::near, |hit, q| hit.sample(q.u).map_or(0.0, |s| s.weight[0]));
}

#[divan::bench(args = ScatterExit::ALL)]
fn far_eval(bencher: Bencher, exit: ScatterExit) {
    each(bencher, exit, |_| Window::far(), |hit, q| hit.eval(q.wi).total()[0]);
}

fn main() {
    divan::main();
}
