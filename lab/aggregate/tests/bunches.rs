//! Aggregates beside bunches of fibres, photon by photon.

use vellus::{Fiber, Model, Species, Window, direction};
use vellus_aggregate::simulation::{Collision, Fibers, Places, Profile};
use vellus_aggregate::{Aggregate, Bunch};

/// Documented bounds in per cent: profile over azimuth, over inclination, energy.
type Bounds = [f64; 3];

fn hair(sigma_ca: [f32; 3]) -> Fiber {
    Fiber::hair().with_absorption(sigma_ca)
}

fn check(fibers: &Fibers, bunch: Bunch, theta_o: f64, paths: u64, bounds: Bounds) {
    let aggregate = Aggregate::new(&fibers.fiber, bunch).unwrap();
    let modelled = Profile::of(&aggregate.at(direction(theta_o.to_radians(), 0.0), Window::far()));
    let simulated = fibers.scatter(theta_o.to_radians(), 3, paths).unwrap();
    let [azimuth, inclination] = modelled.difference(&simulated.profile);
    let (a, b) = (modelled.energy(), simulated.profile.energy());
    let energy = (0..3).map(|c| (a[c] - b[c]).abs()).sum::<f64>() / b.iter().sum::<f64>();
    let errors = [azimuth, inclination, energy].map(|x| 100.0 * x);
    println!("{:?} {bunch:?} θ_o {theta_o}: {errors:.2?}", fibers.places);
    assert!(errors.iter().zip(bounds).all(|(error, bound)| *error <= bound), "{fibers:?} {errors:.2?} {bounds:?}");
}

/// The mean number of collisions does not depend on how light scatters (see `table.rs`): a check of the oracle.
#[test]
fn photons_collide_as_often_as_on_mean_chords() {
    for fiber in [hair([0.0; 3]), Fiber::preset(Species::Dog).without_absorption()] {
        for theta_o in [0.0f64, 1.0] {
            let fibers = Fibers { fiber, places: Places::Medium(2.0), collision: Collision::Far, spread: 0.0 };
            let scattered = fibers.scatter(theta_o, 5, 40_000).unwrap();
            let passes = Bunch::new(2.0).unwrap().mean_passes();
            let expected = std::f64::consts::FRAC_PI_4 * 2.0 / (1.0 - passes);
            // The deviation of the number of collisions is below its mean. 3.9 standard errors of 29,000 paths have a
            // false-alarm rate of 1e-4.
            let error = scattered.collisions / expected - 1.0;
            assert!(error.abs() < 3.9 / 29_000f64.sqrt(), "{fiber:?} {theta_o}: {error}");
            assert!((scattered.passes - passes).abs() < 3.9 * (0.25f64 / 40_000.0).sqrt(), "{}", scattered.passes);
            // Nothing is absorbed. Weights of samples in single precision.
            assert!(scattered.profile.energy().iter().all(|e| (e - 1.0).abs() < 1e-3), "{scattered:?}");
        }
    }
}

/// Thin fibres, with the documented worst errors of θ_o ≤ 60° and the noise of 30,000 photons (3 %).
#[test]
fn thin_fibres() {
    let medium = |fiber, tau| (fiber, Places::Medium(tau), Bunch::new(tau).unwrap());
    for (fiber, places, bunch) in [medium(Fiber::preset(Species::Dog), 3.0), medium(hair([0.5, 0.8, 1.2]), 3.0)] {
        let fibers = Fibers { fiber, places, collision: Collision::Far, spread: 0.0 };
        check(&fibers, bunch, 30.0, 30_000, [8.0, 10.0, 3.0]);
    }
}

/// 64 fibres that fill 6 % of the section, with their near field.
#[test]
fn real_fibres() {
    let radius = (0.06f64 / 64.0).sqrt();
    let cases = [
        (Places::Overlapping(64, 0.06), Bunch::overlapping(64, radius, 1.0).unwrap()),
        (Places::Separate(64, 0.06), Bunch::separate(64, radius, 1.0).unwrap()),
    ];
    for (places, bunch) in cases {
        for fiber in [Fiber::preset(Species::Raccoon), hair([0.02, 0.05, 0.1])] {
            let fibers = Fibers { fiber, places, collision: Collision::Near, spread: 0.0 };
            check(&fibers, bunch, 30.0, 30_000, [9.0, 11.0, 3.0]);
        }
    }
}

/// Members that point in different directions: without their spread, the error is ten times as large.
#[test]
fn spread_members() {
    let bunch = Bunch::new(0.5).unwrap().with_spread(0.2).unwrap();
    let fiber = hair([0.5, 0.8, 1.2]);
    let fibers = Fibers { fiber, places: Places::Medium(0.5), collision: Collision::Far, spread: 0.2 };
    check(&fibers, bunch, 30.0, 80_000, [8.0, 8.0, 3.0]);
}

/// All presets. The bounds are the documented worst errors over all of θ_o.
#[test]
#[ignore = "slow: 120 simulations"]
fn all_presets() {
    for species in Species::ALL {
        for tau in [0.5, 2.0, 6.0, 12.0] {
            for theta_o in [0.0, 45.0, 75.0] {
                let fiber = Fiber::preset(species);
                let fibers = Fibers { fiber, places: Places::Medium(tau), collision: Collision::Far, spread: 0.0 };
                check(&fibers, Bunch::new(tau).unwrap(), theta_o, 60_000, [9.0, 12.0, 5.0]);
            }
        }
    }
}
