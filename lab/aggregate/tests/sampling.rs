//! Samples follow the pdf, the pdf integrates to 1, weights are f/pdf and bounded, and all numbers are finite.

use std::f64::consts::FRAC_PI_2;
use vellus::{Fiber, Model, Scattering, Species, Window};
use vellus_aggregate::{Aggregate, Bunch, MAX_SPREAD, MAX_TAU};
use vellus_testing::sphere::{ChiSquared, integral};
use vellus_testing::{Uniform, direction, full_fiber};

fn aggregates() -> Vec<Aggregate> {
    let fibers = [
        full_fiber(),
        Fiber { g: 0.9, sigma_ms: 0.4, eta: 1.35, beta_n: 0.45, ..full_fiber() },
        Fiber::preset(Species::Deer).with_absorption([0.05, 0.4, 0.9]),
    ];
    let bunches = [0.0, 0.8, 10.0].map(|tau| Bunch::new(tau).unwrap());
    fibers.iter().zip(bunches).map(|(fiber, bunch)| Aggregate::new(fiber, bunch).unwrap()).collect()
}

const HITS: [f64; 3] = [0.35, -1.2, 1.5];

#[test]
fn pdf_integrates_to_one() {
    for aggregate in aggregates() {
        for theta_o in HITS {
            let hit = aggregate.at(direction(theta_o, 0.4), Window::far());
            let sum = integral([720, 288], |wi| hit.pdf(wi));
            // Rows are 0.25° and the narrowest lobe is 4° wide: (0.25/4)²/24 = 2e-4.
            assert!((sum - 1.0).abs() < 5e-4, "{:?} {theta_o}: {sum}", aggregate.member());
        }
    }
}

/// [`ChiSquared`], with a false-alarm rate of 0.01 for all hits together.
#[test]
fn sample_histogram_matches_pdf() {
    let mut random = Uniform(7);
    let aggregates = aggregates();
    let tests = aggregates.len() * HITS.len();
    let test = ChiSquared { cells: [16, 32], samples: 300_000, nodes: [384, 384], tests };
    for aggregate in &aggregates {
        for theta_o in HITS {
            let hit = aggregate.at(direction(theta_o, 2.2), Window::far());
            let follows = test.check(|| hit.sample(random.numbers()).unwrap().wi, |wi| hit.pdf(wi));
            assert_eq!(follows, Ok(()), "{:?} θ_o {theta_o}", aggregate.member());
        }
    }
}

/// Weights are f/pdf in the direction of the sample. They are at most the integral of the largest channel of each part.
/// Its parts would sum to at most 1 without the differences between the densities of channels, for which 5 % are
/// allowed.
#[test]
fn weights_are_f_over_pdf_and_bounded() {
    let mut random = Uniform(8);
    for aggregate in aggregates() {
        let mut largest = 0.0f32;
        for _ in 0..2000 {
            let wo = direction(random.within(-1.5, 1.5), random.within(-3.0, 3.0));
            let hit = aggregate.at(wo, Window::far());
            let s = hit.sample(random.numbers()).unwrap();
            assert!((s.wi.length() - 1.0).abs() < 1e-5 && s.pdf > 0.0, "{s:?}");
            largest = s.weight.into_iter().fold(largest, f32::max);
            // Near the poles the azimuth of the direction is rounded.
            if s.wi.x.abs() > 0.999 {
                continue;
            }
            let (f, pdf) = hit.eval_pdf(s.wi);
            assert!((pdf / s.pdf - 1.0).abs() < 3e-3 + 1e-4 / s.pdf, "{s:?} {pdf}");
            for c in 0..3 {
                let expected = s.weight[c] * s.pdf;
                assert!((f.total()[c] - expected).abs() <= 4e-3 * expected + 1e-4, "{s:?} {f:?}");
            }
        }
        println!("largest weight {largest}");
        assert!(largest < 1.05, "{largest}");
    }
}

#[test]
fn weights_of_grey_fibres_are_the_energy() {
    let mut random = Uniform(9);
    for tau in [0.2, 2.0, 12.0] {
        let aggregate = Aggregate::new(&Fiber::preset(Species::Raccoon), Bunch::new(tau).unwrap()).unwrap();
        for _ in 0..500 {
            let hit = aggregate.at(direction(random.within(-1.5, 1.5), 0.3), Window::far());
            let energy = hit.energy().total()[1];
            let s = hit.sample(random.numbers()).unwrap();
            assert!(s.weight.into_iter().all(|w| (w / energy - 1.0).abs() < 1e-4), "{s:?} {energy}");
        }
    }
}

/// No result is infinite, NaN or negative, for any fibre, bunch and direction.
#[test]
fn edges_are_finite() {
    let mut random = Uniform(21);
    for k in 0..60 {
        let mut fiber = random.fiber();
        match k % 6 {
            0 => fiber.kappa = 0.0,
            1 => fiber.kappa = 0.99,
            2 => fiber.sigma_ms = 0.0,
            3 => (fiber.beta_m, fiber.beta_n) = (0.1f32.to_radians(), 0.1f32.to_radians()),
            4 => (fiber.eta, fiber.layers) = (1.0, 0.0),
            _ => (fiber.sigma_ca, fiber.sigma_ms) = ([1000.0; 3], 1000.0),
        }
        let edge = |random: &mut Uniform, of: [f64; 4]| of[(random.next() * 4.0) as usize];
        let bunch = Bunch::new(edge(&mut random, [0.0, 1e-9, 1.0, MAX_TAU])).unwrap();
        let bunch = bunch.with_spread(edge(&mut random, [0.0, 0.0, 0.1, MAX_SPREAD])).unwrap();
        let aggregate = Aggregate::new(&fiber, bunch).unwrap();
        for _ in 0..20 {
            let theta_o = edge(&mut random, [0.0, FRAC_PI_2, -FRAC_PI_2, 1.57]);
            let hit = aggregate.at(direction(theta_o, random.within(-3.0, 3.0)), Window::far());
            let sample = hit.sample(random.numbers());
            let mut numbers: Vec<f32> = hit.energy().0.into_iter().flatten().collect();
            if let Some(s) = sample {
                numbers.extend(s.weight);
                numbers.extend([s.pdf, s.wi.length()]);
            }
            let other = direction(edge(&mut random, [0.0, FRAC_PI_2, -FRAC_PI_2, -1.57]), random.within(-3.2, 3.2));
            for wi in [Some(other), sample.map(|s| s.wi)].into_iter().flatten() {
                let (f, pdf) = hit.eval_pdf(wi);
                numbers.extend(f.0.into_iter().flatten());
                numbers.push(pdf);
            }
            let bad = numbers.iter().find(|x| !x.is_finite() || **x < 0.0);
            assert!(bad.is_none(), "{fiber:?} {bunch:?} θ_o {theta_o}: {numbers:?}");
        }
    }
}

/// The same fibre in the same bunch is the same aggregate, and a fibre out of range is named.
#[test]
fn another_fiber_is_the_same_model() {
    let bunch = Bunch::new(2.0).unwrap();
    let first = Aggregate::new(&Fiber::hair(), bunch).unwrap();
    let (other, fresh) = (first.with_fiber(&full_fiber()).unwrap(), Aggregate::new(&full_fiber(), bunch).unwrap());
    let [a, b] = [&other, &fresh].map(|m| m.at(direction(0.3, 0.1), Window::far()).eval_pdf(direction(-0.3, 1.0)));
    assert_eq!(a, b);
    let bad = Aggregate::new(&Fiber { eta: 0.5, ..Fiber::hair() }, bunch).unwrap_err().to_string();
    assert!(bad.starts_with("the member fibre: eta = 0.5"), "{bad}");
}
