//! The far field of a whole fibre with a rough cuticle.

use vellus::{Fiber, Species};
use vellus_reference::simulate::profile::{Cells, profile};

/// Cells of `step` degrees over the whole sphere.
fn sphere(step: f64) -> Cells {
    let middles = |low: f64, high: f64| {
        (0..((high - low) / step) as usize).map(|i| (low + (i as f64 + 0.5) * step).to_radians()).collect()
    };
    Cells { theta: middles(-90.0, 90.0), phi: middles(-180.0, 180.0), size: [step.to_radians(); 2] }
}

/// Energy in each cell.
fn energies(cells: &Cells, values: &[[f64; 3]]) -> Vec<f64> {
    let solid_angle =
        |theta: f64| cells.size[1] * ((theta + 0.5 * cells.size[0]).sin() - (theta - 0.5 * cells.size[0]).sin());
    values.iter().enumerate().map(|(i, v)| v[0] * solid_angle(cells.theta[i / cells.phi.len()])).collect()
}

#[test]
fn rough_fibres_lose_no_light() {
    for species in [Species::Human, Species::Springbok] {
        let fiber = Fiber::published(species).without_absorption();
        let cells = sphere(5.0);
        let values = profile(&fiber, 0.5, &cells, 60_000, 7, &()).unwrap();
        let total: f64 = energies(&cells, &values).iter().sum();
        // Roulette is the only noise: it affects photons inside after 100 hits, with a factor of 1/0.9 for each further
        // hit. If all photons were affected, this were √(0.1/60000) per hit. A few in a hundred are.
        assert!((total - 1.0).abs() < 2e-3, "{species}: {total}");
    }
}

/// If a fibre absorbs all light that enters, only the highlight remains. In the plane of incidence it has the shift and
/// width of the lobe R: θᵢ = −θ_o − α, β_m.
#[test]
fn a_highlight_has_the_shift_and_width_of_r() {
    let fiber = Fiber { kappa: 0.0, ..Fiber::published(Species::Deer) }.with_absorption([1000.0; 3]);
    let cells = sphere(1.0);
    let photons = 400_000;
    let values = profile(&fiber, -30f64.to_radians(), &cells, photons, 3, &()).unwrap();
    let energies = energies(&cells, &values);
    let columns = cells.phi.len();
    let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
    for (i, e) in energies.iter().enumerate() {
        if cells.phi[i % columns].abs() < 15f64.to_radians() {
            let theta = cells.theta[i / columns].to_degrees();
            sum += e;
            first += e * theta;
            second += e * theta * theta;
        }
    }
    let mean = first / sum;
    let deviation = (second / sum - mean * mean).sqrt();
    let (alpha, beta) = (f64::from(fiber.alpha).to_degrees(), f64::from(fiber.beta_m).to_degrees());
    // About 15,000 photons leave there: the standard error of the mean is 0.06°, that of the width 0.04°. Facets that
    // face the light get more of it (2 % for each degree of tilt), and reflectance depends on the angle: 0.3° more.
    assert!((mean - (30.0 - alpha)).abs() < 0.5, "{mean}");
    assert!((deviation - beta).abs() < 0.4, "{deviation}");
}

/// The profile is symmetric in φ, and the same for any number of threads.
#[test]
fn profiles_are_symmetric_and_repeatable() {
    let fiber = Fiber::published(Species::Mouse);
    let cells = sphere(10.0);
    let run = || profile(&fiber, 0.3, &cells, 40_000, 5, &()).unwrap();
    let values = run();
    let columns = cells.phi.len();
    for (i, v) in values.iter().enumerate() {
        let mirrored = values[i / columns * columns + (columns - 1 - i % columns)];
        assert!((v[0] - mirrored[0]).abs() <= 1e-12 * v[0].abs(), "{i}");
    }
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert!(one.install(run) == values);
}
