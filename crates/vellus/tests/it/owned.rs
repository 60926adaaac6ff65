//! Hits that contain their fibre, and what threads may share.

use vellus::wide::f32x8;
use vellus::{
    Bcsdf, CoatColors, Color, Error, Fiber, FiberBuilder, FiberFrame, Hit, Lobes, NearHit, OwnedHit, Sample,
    Scattering, Tables, Window,
};
use vellus_testing::{full_fiber, queries};

/// All results as text: each number has the digits that distinguish it from all others.
macro_rules! results {
    ($hit:expr, $q:expr) => {{
        let (hit, q) = ($hit, $q);
        let (wi, u) = (q.wi.to_array().map(f32x8::splat), q.u.map(f32x8::splat));
        let single = (hit.eval(q.wi), hit.pdf(q.wi), hit.eval_pdf(q.wi), hit.sample(q.u));
        let all = (hit.energy(), hit.lobe_probabilities(), hit.azimuthal(0.7));
        format!("{single:?} {all:?} {:?} {:?}", hit.eval_pdf8(wi), hit.sample8(u))
    }};
}

#[test]
fn an_owned_hit_has_the_bits_of_one_that_borrows() {
    for fiber in [full_fiber(), full_fiber().with_exit(vellus::ScatterExit::Open), Fiber::hair()] {
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        for bcsdf in [bcsdf.clone().with_fine_windows(), bcsdf] {
            for q in queries(20) {
                for window in [Window::near(q.h), Window::cell(q.h, 0.3, q.u[4]), Window::far()] {
                    let owned = bcsdf.clone().into_hit(q.wo, window);
                    assert_eq!(results!(&owned, &q), results!(bcsdf.at(q.wo, window), &q));
                    assert_eq!(results!(owned.clone(), &q), results!(&owned, &q));
                    let model: &dyn Scattering = &owned;
                    assert_eq!(model.eval_pdf(q.wi), owned.eval_pdf(q.wi));
                }
            }
        }
    }
}

/// What the crate and the book promise.
#[test]
fn threads_share_all_types_and_an_owned_hit_lives_as_long_as_it_must() {
    fn shared<T: Send + Sync>() {}
    fn anywhere<T: Send + Sync + 'static>() {}
    anywhere::<OwnedHit>();
    anywhere::<Bcsdf<'static>>();
    anywhere::<(Fiber, FiberBuilder, FiberFrame, Color, Window, Lobes, Sample, CoatColors, Tables, Error)>();
    shared::<(Bcsdf<'_>, Hit<'_>, NearHit<'_>)>();
    // The fibre is gone before the first query.
    let hit = Bcsdf::new(&full_fiber()).map(|bcsdf| bcsdf.into_hit(vellus::glam::Vec3::Y, Window::near(0.3))).unwrap();
    let pdf = hit.pdf(vellus::glam::Vec3::Z);
    assert_eq!(std::thread::spawn(move || hit.pdf(vellus::glam::Vec3::Z)).join().unwrap(), pdf);
}
