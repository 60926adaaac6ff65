//! Time of one query of each model on one core, six lobes and RGB: `cargo bench -p vellus-models`.
//!
//! Every iteration takes another hit and direction from a table. The fibre is a red fox with colour. Near fields are
//! hit at one offset, far fields over all offsets.

use divan::{Bencher, black_box};
use glam::Vec3;
use vellus::{Bcsdf, Fiber, Model, Scattering, Species, Window};
use vellus_models::{Chiang2016, DEon2011, KajiyaKay1989, Marschner2003, Yan2015, ZinkeWeber2007};
use vellus_testing::{Query, queries};

const N: usize = 1024;

/// A model that can be created from a fibre.
trait Made: Model + Sized {
    fn made(fiber: &Fiber) -> Self;
}

macro_rules! made {
    ($($model:ty),*) => {
        $(impl Made for $model {
            fn made(fiber: &Fiber) -> Self {
                <$model>::new(fiber).expect("the preset is valid")
            }
        })*
    };
}
made!(Bcsdf<'static>, Yan2015, Chiang2016, ZinkeWeber2007, DEon2011, Marschner2003, KajiyaKay1989);

/// Yan et al. 2015 with two different indices, so that all eleven lobes carry light.
struct Yan2015Split(Yan2015);

impl Model for Yan2015Split {
    type Hit<'a> = <Yan2015 as Model>::Hit<'a>;

    #[inline]
    fn at(&self, wo: Vec3, window: Window) -> Self::Hit<'_> {
        self.0.at(wo, window)
    }

    fn field(&self) -> vellus::WindowSupport {
        self.0.field()
    }

    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, vellus::Error> {
        self.0.with_fiber(fiber).map(Yan2015Split)
    }
}

impl Made for Yan2015Split {
    fn made(fiber: &Fiber) -> Self {
        Yan2015Split(Yan2015::with_eta_m(fiber, 1.3).expect("the preset is valid"))
    }
}

fn fox() -> Fiber {
    Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8])
}

fn each<M: Made>(bencher: Bencher, f: impl Fn(&M, &Query) -> f32 + Sync) {
    let (model, queries) = (M::made(&fox()), queries(N));
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % N;
        f(&model, black_box(&queries[i]))
    });
}

/// Each hit has sixteen light samples.
fn each_hit<M: Made>(bencher: Bencher, f: impl Fn(&M::Hit<'_>, &Query) -> f32) {
    let (model, queries) = (M::made(&fox()), queries(N));
    let hits: Vec<_> = queries.iter().take(64).map(|q| model.at(q.wo, Window::near(q.h))).collect();
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % N;
        f(black_box(&hits[i / 16]), black_box(&queries[i]))
    });
}

fn eval_pdf(hit: &impl Scattering, q: &Query) -> f32 {
    let (f, pdf) = hit.eval_pdf(q.wi);
    f.total()[0] + pdf
}

/// Defines benchmarks with one run for each model.
macro_rules! for_each_model {
    ($(fn $name:ident<M>($bencher:ident) $body:block)*) => {
        $(#[divan::bench(
            types = [
                Bcsdf<'static>,
                Yan2015,
                Yan2015Split,
                Chiang2016,
                ZinkeWeber2007,
                DEon2011,
                Marschner2003,
                KajiyaKay1989,
            ],
            sample_count = 100, sample_size = 1024,
        )]
        fn $name<M: Made>($bencher: Bencher) $body)*
    };
}

for_each_model! {
    fn eval_and_pdf<M>(bencher) {
        each_hit::<M>(bencher, |hit, q| eval_pdf(hit, q));
    }

    fn prepare_eval_and_pdf<M>(bencher) {
        each::<M>(bencher, |model, q| eval_pdf(&model.at(q.wo, Window::near(q.h)), q));
    }

    fn prepare_and_sample<M>(bencher) {
        each::<M>(bencher, |model, q| model.at(q.wo, Window::near(q.h)).sample(q.u).map_or(0.0, |s| s.weight[0]));
    }
}

#[divan::bench(
    types = [
        Bcsdf<'static>,
        Yan2015,
        Chiang2016,
        ZinkeWeber2007,
        DEon2011,
        Marschner2003,
        KajiyaKay1989,
    ],
    sample_count = 20, sample_size = 4,
)]
fn constructor<M: Made>(bencher: Bencher) {
    let fiber = fox();
    bencher.bench(|| M::made(black_box(&fiber)));
}

#[divan::bench(sample_count = 100, sample_size = 1024)]
fn constructor_yan2015_with_fiber(bencher: Bencher) {
    let first = Yan2015::made(&fox());
    let fiber = fox().with_absorption([0.9, 0.1, 0.3]);
    bencher.bench(|| first.with_fiber(black_box(&fiber)));
}

fn main() {
    divan::main();
}
