//! Time of the C functions beside the same queries in Rust, on one core: `cargo bench -p vellus-c`.
//!
//! Both run in turn. A row has the median times of a query and the median of the ratios. The C functions are called
//! through pointers that the compiler does not know, as a program in C calls a library.

#![allow(unsafe_code, reason = "calls of the C interface")]

use std::hint::black_box;
use std::ptr::null_mut;
use std::time::Instant;
use vellus::wide::f32x8;
use vellus::{Bcsdf, Fiber, Species, Window};
use vellus_c::*;
use vellus_testing::{Query, queries};

const COUNT: usize = 4096;
const REPEATS: usize = 101;

/// Nanoseconds for each query.
fn time(work: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e9 / COUNT as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn compare(name: &str, rust: &mut dyn FnMut(), c: &mut dyn FnMut()) {
    let mut times = [Vec::new(), Vec::new(), Vec::new()];
    for repeat in 0..REPEATS {
        // The first of a pair may find other caches than the second.
        let (a, b) = if repeat % 2 == 0 {
            let a = time(rust);
            (a, time(c))
        } else {
            let b = time(c);
            (time(rust), b)
        };
        times[0].push(a);
        times[1].push(b);
        times[2].push(b / a);
    }
    let [a, b, ratio] = times.map(median);
    println!("| {name} | {a:.0} | {b:.0} | {ratio:.3} |");
}

/// Each of many queries.
fn each(q: &[Query], mut f: impl FnMut(&Query)) {
    q.iter().for_each(|q| f(black_box(q)));
}

fn main() {
    let q = queries(COUNT);
    let fiber = Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]);
    let bcsdf = Bcsdf::new(&fiber).expect("the preset is valid");
    let mut handle = null_mut();
    let json = c"{\"preset\": \"red-fox\", \"sigma_ca\": [0.2, 0.4, 0.8]}";
    // SAFETY: the text ends with a zero byte.
    assert_eq!(unsafe { vellus_fiber_from_json(json.as_ptr(), &mut handle) }, VellusStatus::Ok);
    let handle = handle.cast_const();

    println!("| red fox, {COUNT} queries | Rust, ns | C, ns | C / Rust |\n|---|---|---|---|");
    let near = |q: &Query| VellusWindow { low: q.h, high: q.h };
    let cell = |q: &Query| {
        let [low, high] = Window::cell(q.h, 0.5, q.u[4]).ends();
        VellusWindow { low, high }
    };
    single(&q, &bcsdf, handle, "near", &near);
    single(&q, &bcsdf, handle, "cell of 0.5", &cell);
    prepared(&q, &bcsdf, handle);
    arrays(&q, &bcsdf, handle);
    // SAFETY: it was made above, and is not used any more.
    unsafe { vellus_fiber_free(handle.cast_mut()) };
}

/// One query with its own hit.
fn single(q: &[Query], bcsdf: &Bcsdf, handle: *const VellusFiber, name: &str, window: &dyn Fn(&Query) -> VellusWindow) {
    let range = |q: &Query| {
        let VellusWindow { low, high } = window(q);
        Window::range(low, high)
    };
    let (mut rgb, mut pdf) = ([0.0f32; 3], 0.0f32);
    let eval_pdf = black_box(vellus_fiber_eval_pdf as unsafe extern "C" fn(_, _, _, _, _, _) -> _);
    compare(
        &format!("prepare and eval_pdf, {name}"),
        &mut || {
            each(q, |q| {
                let result = bcsdf.with_hit(q.wo, range(q), |hit| hit.eval_pdf(q.wi));
                black_box((result.0.total(), result.1));
            });
        },
        &mut || {
            each(q, |q| {
                let (wo, wi): (&[f32; 3], &[f32; 3]) = (q.wo.as_ref(), q.wi.as_ref());
                // SAFETY: all arrays have the documented sizes.
                unsafe { eval_pdf(handle, wo.as_ptr(), window(q), wi.as_ptr(), rgb.as_mut_ptr(), &raw mut pdf) };
                black_box((&rgb, pdf));
            });
        },
    );
    let mut drawn = VellusSample { wi: [0.0; 3], pdf: 0.0, weight: [0.0; 3], lobe: 0 };
    let sample = black_box(vellus_fiber_sample as unsafe extern "C" fn(_, _, _, _, _) -> _);
    compare(
        &format!("prepare and sample, {name}"),
        &mut || {
            each(q, |q| {
                black_box(bcsdf.with_hit(q.wo, range(q), |hit| hit.sample(q.u)));
            });
        },
        &mut || {
            each(q, |q| {
                let wo: &[f32; 3] = q.wo.as_ref();
                // SAFETY: all arrays have the documented sizes.
                unsafe { sample(handle, wo.as_ptr(), window(q), q.u.as_ptr(), &raw mut drawn) };
                black_box(&drawn);
            });
        },
    );
}

/// Queries of a hit that is prepared already.
fn prepared(q: &[Query], bcsdf: &Bcsdf, handle: *const VellusFiber) {
    let wo: &[f32; 3] = q[0].wo.as_ref();
    let rust = bcsdf.at(q[0].wo, Window::near(q[0].h));
    let mut hit = null_mut();
    // SAFETY: `wo` has three numbers.
    let status = unsafe { vellus_hit_new(handle, wo.as_ptr(), VellusWindow { low: q[0].h, high: q[0].h }, &mut hit) };
    assert_eq!(status, VellusStatus::Ok);
    let (mut rgb, mut pdf) = ([0.0f32; 3], 0.0f32);
    let eval_pdf = black_box(vellus_hit_eval_pdf as unsafe extern "C" fn(_, _, _, _) -> _);
    compare(
        "eval_pdf of a prepared near hit",
        &mut || {
            each(q, |q| {
                let result = rust.eval_pdf(q.wi);
                black_box((result.0.total(), result.1));
            });
        },
        &mut || {
            each(q, |q| {
                let wi: &[f32; 3] = q.wi.as_ref();
                // SAFETY: all arrays have the documented sizes.
                unsafe { eval_pdf(hit.cast_const(), wi.as_ptr(), rgb.as_mut_ptr(), &raw mut pdf) };
                black_box((&rgb, pdf));
            });
        },
    );
    // SAFETY: it was made above.
    unsafe { vellus_hit_free(hit) };
}

/// Arrays of near-field queries, beside the batch of Rust, whose input already lies in registers of eight.
fn arrays(q: &[Query], bcsdf: &Bcsdf, handle: *const VellusFiber) {
    let eight = |i: usize, f: &dyn Fn(&Query) -> f32| f32x8::new(std::array::from_fn(|lane| f(&q[i + lane])));
    let batches: Vec<_> = (0..COUNT)
        .step_by(8)
        .map(|i| {
            let wo = [0, 1, 2].map(|k| eight(i, &|q| q.wo[k]));
            let wi = [0, 1, 2].map(|k| eight(i, &|q| q.wi[k]));
            (wo, eight(i, &|q| q.h), wi, [0, 1, 2, 3].map(|k| eight(i, &|q| q.u[k])))
        })
        .collect();
    let stride = size_of::<Query>();
    let queries = VellusQueries {
        count: COUNT,
        wo: VellusInput { data: &q[0].wo.x, stride },
        h: VellusInput { data: &q[0].h, stride },
        window: VellusInput { data: std::ptr::null(), stride: 0 },
        wi: VellusInput { data: &q[0].wi.x, stride },
        u: VellusInput { data: &q[0].u[0], stride },
    };
    let (mut rgb, mut pdf, mut wi) = ([[0.0f32; 3]; COUNT], [0.0f32; COUNT], [[0.0f32; 3]; COUNT]);
    let none = VellusOutput { data: null_mut(), stride: 0 };
    let pdf_output = VellusOutput { data: pdf.as_mut_ptr(), stride: 4 };
    let rgb_output = VellusOutput { data: rgb.as_mut_ptr().cast(), stride: 12 };
    let values = VellusValues { rgb: rgb_output, pdf: pdf_output, lobes: none };
    let eval = black_box(vellus_fiber_eval_array as unsafe extern "C" fn(_, _, _) -> _);
    compare(
        "array: prepare and eval_pdf, near",
        &mut || {
            for (wo, h, wi, _) in black_box(&batches) {
                let (lobes, pdf) = bcsdf.at8(*wo, *h).eval_pdf8(*wi);
                black_box((lobes.total(), pdf));
            }
        },
        &mut || {
            // SAFETY: the strides are those of the arrays.
            assert_eq!(unsafe { eval(handle, &raw const queries, &raw const values) }, VellusStatus::Ok);
        },
    );
    let samples = VellusSamples {
        wi: VellusOutput { data: wi.as_mut_ptr().cast(), stride: 12 },
        pdf: pdf_output,
        weight: rgb_output,
        lobe: VellusOutputLobes { data: null_mut(), stride: 0 },
    };
    let sample = black_box(vellus_fiber_sample_array as unsafe extern "C" fn(_, _, _) -> _);
    compare(
        "array: prepare and sample, near",
        &mut || {
            for (wo, h, _, u) in black_box(&batches) {
                black_box(bcsdf.at8(*wo, *h).sample8(*u));
            }
        },
        &mut || {
            // SAFETY: the strides are those of the arrays.
            assert_eq!(unsafe { sample(handle, &raw const queries, &raw const samples) }, VellusStatus::Ok);
        },
    );
}
