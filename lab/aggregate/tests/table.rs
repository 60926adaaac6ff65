//! The table of multiple scattering beside fresh simulations.

use vellus_aggregate::simulation::{Disc, build, tabulated};
use vellus_aggregate::{Bunch, Multiple};

/// The seed and the number of photons of the table.
const SHIPPED: (u64, u64) = (2022, 1_000_000);

/// Half the sum of differences: the share of light that is elsewhere.
fn elsewhere(a: &[f64], b: &[f64]) -> f64 {
    let total: f64 = b.iter().sum();
    0.5 * a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / total
}

/// The shares of light with another number of collisions (in groups of similar size), and with another azimuth.
fn differences(a: &Multiple, b: &Multiple) -> [f64; 2] {
    let coarse = |m: &Multiple| {
        let ends = [0, 1, 2, 3, 5, 8, 12, 18, 26, 40, 60, m.counts.len()];
        ends.windows(2).map(|pair| m.counts[pair[0]..pair[1]].iter().sum()).collect::<Vec<f64>>()
    };
    // The groups of azimuths: 2, 3, 4 to 6, and 7 or more collisions.
    let ends = [0, 1, 2, 5, b.counts.len()];
    let azimuths = (0..4).map(|k| {
        let share: f64 = b.counts[ends[k]..ends[k + 1]].iter().sum();
        share * elsewhere(&a.azimuths[k], &b.azimuths[k])
    });
    [elsewhere(&coarse(a), &coarse(b)), azimuths.sum()]
}

/// A node is the simulation that made it, rounded to half floats: 2⁻¹¹ of each number.
#[test]
fn a_node_is_rebuilt_bit_for_bit() {
    let disc = Disc { tau: 0.001, g: -0.7 };
    let fresh = disc.simulate(SHIPPED.0, SHIPPED.1).0;
    let table = tabulated(disc).unwrap();
    let numbers = |m: &Multiple| m.counts.iter().chain(m.azimuths.iter().flatten()).copied().collect::<Vec<f64>>();
    for (a, b) in numbers(&table).into_iter().zip(numbers(&fresh)) {
        // Twice: the sums of rounded numbers are normalised again. Below 6e-5 half floats have fixed steps of 6e-8.
        assert!((a - b).abs() <= b * 2f64.powi(-10) + 6e-8, "{a} {b}");
    }
}

#[test]
#[ignore = "slow: simulates all 270 nodes"]
fn the_table_is_rebuilt_bit_for_bit() {
    assert!(build(SHIPPED.0, SHIPPED.1) == include_bytes!("../data/orders.vellus"));
}

fn check_between_nodes(points: &[(f64, f64)], photons: u64) {
    let mut worst = [0.0f64; 2];
    for (k, &(tau, g)) in points.iter().enumerate() {
        let disc = Disc { tau, g };
        let found = differences(&tabulated(disc).unwrap(), &disc.simulate(77 + k as u64, photons).0);
        println!("τ {tau} g {g}: {}", found.map(|x| format!("{:.2} %", 100.0 * x)).join(", "));
        worst.iter_mut().zip(found).for_each(|(worst, x)| *worst = worst.max(x));
    }
    // The documented errors of the table with the noise of both simulations, rounded up to half a per cent.
    assert!(worst[0] < 0.015 && worst[1] < 0.025, "{worst:.4?}");
}

#[test]
fn between_nodes() {
    check_between_nodes(&[(0.75, 0.0), (5.0, 0.57)], 200_000);
}

/// In the middle between nodes, where interpolation is worst.
#[test]
#[ignore = "slow: simulates 24 discs"]
fn between_all_kinds_of_nodes() {
    let taus = [0.12, 0.75, 2.5, 5.0, 9.0, 14.5];
    let cosines = [-0.6, 0.0, 0.57, 0.925];
    let points: Vec<_> = taus.into_iter().flat_map(|tau| cosines.map(|g| (tau, g))).collect();
    check_between_nodes(&points, 1_000_000);
}

/// The mean path of parallel light in a disc is its mean chord, however it scatters: light that collides does so
/// πτ/4/(1 − passes) times on average. The table keeps numbers of collisions to 128 and the sum of the others.
#[test]
fn mean_number_of_collisions_is_that_of_the_mean_chord() {
    for (tau, g) in [(0.25, 0.5), (2.0, -0.3), (4.0, 0.85)] {
        let photons = 400_000;
        let (fresh, again) = Disc { tau, g }.simulate(5, photons);
        let mean = |m: &Multiple| m.counts.iter().enumerate().map(|(k, x)| (k + 2) as f64 * x).sum::<f64>();
        let expected = std::f64::consts::FRAC_PI_4 * tau / (1.0 - Bunch::new(tau).unwrap().mean_passes());
        let found = 1.0 - again + again * mean(&fresh);
        // Numbers of collisions deviate by about their mean. 3.9 standard errors have a false-alarm rate of 1e-4.
        assert!((found / expected - 1.0).abs() < 3.9 / (photons as f64).sqrt(), "τ {tau} g {g}: {found} {expected}");
        let table = mean(&tabulated(Disc { tau, g }).unwrap());
        assert!((table / mean(&fresh) - 1.0).abs() < 0.01, "τ {tau} g {g}: {table}");
    }
}
