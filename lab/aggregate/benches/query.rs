//! Time of one query on one core: an aggregate, and the far field of its member. `cargo bench -p vellus-aggregate`.

use divan::{Bencher, black_box};
use vellus::{Bcsdf, Fiber, Model, Scattering, Species, Window};
use vellus_aggregate::{Aggregate, Bunch};
use vellus_testing::{Query, queries};

const N: usize = 1024;

fn fox() -> Fiber {
    Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8])
}

/// A model made from the red fox.
trait Made: Model {
    fn made() -> Self;
}

impl Made for Bcsdf<'static> {
    fn made() -> Self {
        Bcsdf::new(&fox()).expect("the preset is valid")
    }
}

impl Made for Aggregate {
    fn made() -> Self {
        let bunch = Bunch::new(3.0).expect("the bunch is valid");
        Aggregate::new(&fox(), bunch).expect("the preset is valid")
    }
}

fn each<M: Made>(bencher: Bencher, f: impl Fn(&M, &Query) -> f32) {
    let (model, queries) = (M::made(), queries(N));
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % N;
        f(&model, black_box(&queries[i]))
    });
}

/// Each hit has sixteen light samples.
#[divan::bench(types = [Bcsdf<'static>, Aggregate], sample_count = 100, sample_size = 1024)]
fn eval_and_pdf<M: Made>(bencher: Bencher) {
    let (model, queries) = (M::made(), queries(N));
    let hits: Vec<_> = queries.iter().take(64).map(|q| model.at(q.wo, Window::far())).collect();
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % N;
        let (f, pdf) = black_box(&hits[i / 16]).eval_pdf(black_box(&queries[i]).wi);
        f.total()[0] + pdf
    });
}

#[divan::bench(types = [Bcsdf<'static>, Aggregate], sample_count = 100, sample_size = 1024)]
fn prepare_eval_and_pdf<M: Made>(bencher: Bencher) {
    each::<M>(bencher, |model, q| {
        model.with_hit(q.wo, Window::far(), |hit| {
            let (f, pdf) = hit.eval_pdf(q.wi);
            f.total()[0] + pdf
        })
    });
}

#[divan::bench(types = [Bcsdf<'static>, Aggregate], sample_count = 100, sample_size = 1024)]
fn prepare_and_sample<M: Made>(bencher: Bencher) {
    each::<M>(bencher, |model, q| {
        model.with_hit(q.wo, Window::far(), |hit| hit.sample(q.u).map_or(0.0, |s| s.weight[0]))
    });
}

#[divan::bench(types = [Bcsdf<'static>, Aggregate], sample_count = 20, sample_size = 1)]
fn constructor<M: Made>(bencher: Bencher) {
    bencher.bench(M::made);
}

fn main() {
    divan::main();
}
