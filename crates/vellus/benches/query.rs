//! Time of one query of the model, six lobes and RGB, on one core: `cargo bench -p vellus`.
//!
//! Every iteration takes another hit and direction from a table, so that branches and caches behave as in a renderer.
//! `batch` times are for eight queries.

use divan::{Bencher, black_box};
use vellus::{Bcsdf, Fiber, Hit, Species, Window};
use vellus_testing::{Query, queries};
use wide::f32x8;

const N: usize = 1024;

fn fur() -> Bcsdf<'static> {
    let fiber = Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]);
    Bcsdf::new(&fiber).expect("the preset is valid")
}

fn hair() -> Bcsdf<'static> {
    Bcsdf::new(&Fiber::hair().with_absorption([0.2, 0.4, 0.8])).expect("hair is valid")
}

fn each(bencher: Bencher, f: impl Fn(&Query) -> f32 + Sync) {
    let queries = queries(N);
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % N;
        f(black_box(&queries[i]))
    });
}

fn each_hit(bencher: Bencher, f: impl Fn(&Hit, &Query) -> f32) {
    let bcsdf = fur();
    let queries = queries(N);
    let hits: Vec<_> = queries.iter().map(|q| bcsdf.at(q.wo, Window::near(q.h))).collect();
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % N;
        f(black_box(&hits[i % 64]), black_box(&queries[i]))
    });
}

#[divan::bench]
fn constructor(bencher: Bencher) {
    let fiber = Fiber::preset(Species::RedFox);
    bencher.bench(|| Bcsdf::new(black_box(&fiber)));
}

#[divan::bench]
fn prepare(bencher: Bencher) {
    let bcsdf = fur();
    each(bencher, |q| black_box(&bcsdf.at(q.wo, Window::near(q.h))).lobe_probabilities()[0]);
}

#[divan::bench]
fn prepare_and_eval(bencher: Bencher) {
    let bcsdf = fur();
    each(bencher, |q| bcsdf.at(q.wo, Window::near(q.h)).eval(q.wi).total()[0]);
}

#[divan::bench]
fn prepare_and_eval_hair(bencher: Bencher) {
    let bcsdf = hair();
    each(bencher, |q| bcsdf.at(q.wo, Window::near(q.h)).eval(q.wi).total()[0]);
}

#[divan::bench]
fn eval(bencher: Bencher) {
    each_hit(bencher, |hit, q| hit.eval(q.wi).total()[0]);
}

#[divan::bench]
fn eval_and_pdf(bencher: Bencher) {
    each_hit(bencher, |hit, q| {
        let (f, pdf) = hit.eval_pdf(q.wi);
        f.total()[0] + pdf
    });
}

#[divan::bench]
fn prepare_eval_and_pdf(bencher: Bencher) {
    let bcsdf = fur();
    each(bencher, |q| {
        let (f, pdf) = bcsdf.at(q.wo, Window::near(q.h)).eval_pdf(q.wi);
        f.total()[0] + pdf
    });
}

#[divan::bench]
fn sample(bencher: Bencher) {
    each_hit(bencher, |hit, q| hit.sample(q.u).map_or(0.0, |s| s.weight[0]));
}

#[divan::bench]
fn prepare_and_sample(bencher: Bencher) {
    let bcsdf = fur();
    each(bencher, |q| bcsdf.at(q.wo, Window::near(q.h)).sample(q.u).map_or(0.0, |s| s.weight[0]));
}

fn each_window(bencher: Bencher, bcsdf: &Bcsdf, window: impl Fn(&Query) -> Window, f: impl Fn(&Hit, &Query) -> f32) {
    let queries = queries(N);
    let hits: Vec<_> = queries.iter().take(64).map(|q| bcsdf.at(q.wo, window(q))).collect();
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % N;
        // Each hit has sixteen light samples.
        f(black_box(&hits[i / 16]), black_box(&queries[i]))
    });
}

fn pixel(q: &Query) -> Window {
    Window::pixel(q.h, 0.5)
}

#[divan::bench]
fn far_prepare(bencher: Bencher) {
    let bcsdf = fur();
    each(bencher, |q| black_box(&bcsdf.at(q.wo, Window::far())).lobe_probabilities()[0]);
}

#[divan::bench]
fn far_prepare_hair(bencher: Bencher) {
    let bcsdf = hair();
    each(bencher, |q| black_box(&bcsdf.at(q.wo, Window::far())).lobe_probabilities()[0]);
}

#[divan::bench]
fn far_eval(bencher: Bencher) {
    each_window(bencher, &fur(), |_| Window::far(), |hit, q| hit.eval(q.wi).total()[0]);
}

#[divan::bench]
fn far_eval_hair(bencher: Bencher) {
    each_window(bencher, &hair(), |_| Window::far(), |hit, q| hit.eval(q.wi).total()[0]);
}

#[divan::bench]
fn far_eval_and_pdf(bencher: Bencher) {
    let eval = |hit: &Hit, q: &Query| {
        let (f, pdf) = hit.eval_pdf(q.wi);
        f.total()[0] + pdf
    };
    each_window(bencher, &fur(), |_| Window::far(), eval);
}

#[divan::bench]
fn far_sample(bencher: Bencher) {
    each_window(bencher, &fur(), |_| Window::far(), |hit, q| hit.sample(q.u).map_or(0.0, |s| s.weight[0]));
}

#[divan::bench]
fn pixel_prepare(bencher: Bencher) {
    let bcsdf = fur();
    each(bencher, |q| black_box(&bcsdf.at(q.wo, pixel(q))).lobe_probabilities()[0]);
}

#[divan::bench]
fn pixel_eval(bencher: Bencher) {
    each_window(bencher, &fur(), pixel, |hit, q| hit.eval(q.wi).total()[0]);
}

/// The window that the renderer uses (D16).
fn cell(q: &Query) -> Window {
    Window::cell(q.h, 0.5, q.u[4])
}

#[divan::bench]
fn cell_prepare(bencher: Bencher) {
    let bcsdf = fur();
    each(bencher, |q| bcsdf.with_hit(q.wo, cell(q), |hit| black_box(hit).lobe_probabilities()[0]));
}

#[divan::bench]
fn cell_prepare_and_eval(bencher: Bencher) {
    let bcsdf = fur();
    each(bencher, |q| bcsdf.with_hit(q.wo, cell(q), |hit| hit.eval(q.wi).total()[0]));
}

#[divan::bench]
fn cell_eval(bencher: Bencher) {
    each_window(bencher, &fur(), cell, |hit, q| hit.eval(q.wi).total()[0]);
}

#[divan::bench]
fn far_with_hit(bencher: Bencher) {
    let bcsdf = fur();
    each(bencher, |q| bcsdf.with_hit(q.wo, Window::far(), |hit| black_box(hit).lobe_probabilities()[0]));
}

#[divan::bench]
fn near_eval(bencher: Bencher) {
    each_window(bencher, &fur(), |q| Window::near(q.h), |hit, q| hit.eval(q.wi).total()[0]);
}

#[divan::bench]
fn near_eval_hair(bencher: Bencher) {
    each_window(bencher, &hair(), |q| Window::near(q.h), |hit, q| hit.eval(q.wi).total()[0]);
}

/// ω_o, h, ω_i and uniform numbers of eight queries.
type Batch = ([f32x8; 3], f32x8, [f32x8; 3], [f32x8; 4]);

fn batches() -> Vec<Batch> {
    let queries = queries(N);
    let lanes = |i: usize, f: &dyn Fn(&Query) -> f32| f32x8::new(std::array::from_fn(|j| f(&queries[8 * i + j])));
    (0..N / 8)
        .map(|i| {
            let wo = [0, 1, 2].map(|k| lanes(i, &|q| q.wo[k]));
            let wi = [0, 1, 2].map(|k| lanes(i, &|q| q.wi[k]));
            (wo, lanes(i, &|q| q.h), wi, [0, 1, 2, 3].map(|k| lanes(i, &|q| q.u[k])))
        })
        .collect()
}

fn each_batch(bencher: Bencher, bcsdf: &Bcsdf, f: impl Fn(&Bcsdf, &Batch) -> f32) {
    let batches = batches();
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % batches.len();
        f(bcsdf, black_box(&batches[i]))
    });
}

fn batch_eval(bcsdf: &Bcsdf, (wo, h, wi, _): &Batch) -> f32 {
    let (f, pdf) = bcsdf.at8(*wo, *h).eval_pdf8(*wi);
    (f.total()[0] + pdf).to_array()[0]
}

#[divan::bench]
fn batch_prepare_eval_and_pdf(bencher: Bencher) {
    each_batch(bencher, &fur(), batch_eval);
}

#[divan::bench]
fn batch_prepare_eval_and_pdf_hair(bencher: Bencher) {
    each_batch(bencher, &hair(), batch_eval);
}

fn batch_sample(bcsdf: &Bcsdf, (wo, h, _, u): &Batch) -> f32 {
    bcsdf.at8(*wo, *h).sample8(*u).iter().flatten().map(|s| s.weight[0]).sum()
}

#[divan::bench]
fn batch_prepare_and_sample(bencher: Bencher) {
    each_batch(bencher, &fur(), batch_sample);
}

#[divan::bench]
fn batch_prepare_and_sample_hair(bencher: Bencher) {
    each_batch(bencher, &hair(), batch_sample);
}

#[divan::bench]
fn batch_eval_and_pdf(bencher: Bencher) {
    let bcsdf = fur();
    let batches = batches();
    let hits: Vec<_> = batches.iter().take(8).map(|(wo, h, ..)| bcsdf.at8(*wo, *h)).collect();
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % batches.len();
        let (f, pdf) = black_box(&hits[i % 8]).eval_pdf8(black_box(batches[i].2));
        (f.total()[0] + pdf).to_array()[0]
    });
}

fn main() {
    // Each sample runs all queries. Fewer queries would measure cold caches and branch predictors.
    divan::Divan::from_args().sample_size(N as u32).sample_count(200).main();
}
