//! 10,000 queries of each model give the same bits as before.
//!
//! A change of the code's structure must not change a bit. A change that alters results on purpose replaces the hashes
//! and gives the reason in CHANGELOG.md. The hashes are for processors with AVX2 and FMA. Others round differently.
#![cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]

use glam::Vec3;
use vellus::{Fiber, Lobes, Model, Scattering, Species, Window};
use vellus_io::Digest;
use vellus_models::ModelKind;

const QUERIES: usize = 10_000;

/// Queries that share a fibre.
const SHARED: usize = 50;

#[test]
fn queries_give_the_same_bits_as_before() {
    let published = ModelKind::ALL.iter().map(|kind| (kind.name(), hash(*kind, Fiber::published)));
    let mut hashes = published.collect::<Vec<_>>();
    hashes.insert(1, ("vellus, presets", hash(ModelKind::Vellus, Fiber::preset)));
    let expected = [
        ("vellus", "d10f85666f6757a3"),
        ("vellus, presets", "74faba5bcace47cb"),
        ("yan2015", "a9998063a1330342"),
        ("chiang2016", "b1a139a3d813fba6"),
        ("deon2011", "22fce59f2ac0c569"),
        ("zinke-weber2007", "139d24911c3a64dd"),
        ("marschner2003", "62b210b1bef23282"),
        ("kajiya-kay1989", "c4e95fc43ed205ea"),
    ];
    let hashes = hashes.iter().map(|(name, hash)| (*name, hash.as_str())).collect::<Vec<_>>();
    assert_eq!(hashes, expected);
}

/// The hash of all results of a model's queries about the fibres of ten species.
fn hash(kind: ModelKind, of: fn(Species) -> Fiber) -> String {
    let mut state = 17;
    // Uniform in [0, 1), by SplitMix64. The code is here, so that no library can change the numbers.
    let mut uniform = || {
        state = u64::wrapping_add(state, 0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    };
    let mut bytes = Vec::new();
    let mut push = |x: f32| bytes.extend(x.to_le_bytes());
    for i in 0..QUERIES / SHARED {
        let species = of(Species::ALL[i % Species::ALL.len()]);
        let fiber = species.with_absorption([uniform(), uniform() * 3.0, uniform() * 0.1]);
        let model = kind.model(&fiber).unwrap();
        for _ in 0..SHARED {
            let h = 2.0 * uniform() - 1.0;
            let window = match uniform() {
                u if u < 0.25 => Window::far(),
                u if u < 0.5 => Window::range(h, h + 0.4),
                _ => Window::near(h),
            };
            let hit = model.at(direction([uniform(), uniform()]), window);
            let (f, pdf) = hit.eval_pdf(direction([uniform(), uniform()]));
            lobes(&hit.energy(), &mut push);
            lobes(&f, &mut push);
            push(pdf);
            let sample = hit.sample(std::array::from_fn(|_| uniform()));
            push(sample.map_or(0.0, |sample| sample.pdf));
            if let Some(sample) = sample {
                sample.wi.to_array().into_iter().chain(sample.weight).for_each(&mut push);
            }
        }
    }
    Digest::of(&bytes).to_string()[..16].to_owned()
}

fn lobes(lobes: &Lobes, push: &mut impl FnMut(f32)) {
    lobes.0.as_flattened().iter().copied().for_each(push);
}

fn direction(u: [f32; 2]) -> Vec3 {
    let (x, phi) = (2.0 * u[0] - 1.0, std::f32::consts::TAU * u[1]);
    let cos_theta = (1.0 - x * x).sqrt();
    // The sine of the standard library differs between systems. That of `libm` does not.
    Vec3::new(x, cos_theta * libm::cosf(phi), cos_theta * libm::sinf(phi))
}
