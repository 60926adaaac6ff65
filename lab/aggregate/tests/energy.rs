//! Energy: white furnace, integrals of eval, and limits.

use vellus::{Bcsdf, Fiber, Model, Scattering, Species, Window};
use vellus_aggregate::{Aggregate, Bunch, MAX_TAU};
use vellus_testing::{Uniform, direction, full_fiber};

const TAUS: [f64; 6] = [0.0, 0.1, 0.7, 3.0, 9.0, MAX_TAU];

/// The members' energies, the numbers of tables and the sum over lobes are in single precision: about 1e-6 each.
const ROUNDING: f32 = 3e-6;

fn aggregate(fiber: &Fiber, tau: f64) -> Aggregate {
    Aggregate::new(fiber, Bunch::new(tau).unwrap()).unwrap()
}

/// ∫ f·cos θᵢ over the sphere, by the midpoint rule.
fn integrate(hit: &impl Scattering) -> [f64; 3] {
    let (rows, columns) = (1440, 288);
    let mut total = [0.0; 3];
    for i in 0..rows {
        let theta = ((f64::from(i) + 0.5) / f64::from(rows) - 0.5) * std::f64::consts::PI;
        for j in 0..columns {
            let f =
                hit.eval(direction(theta, (f64::from(j) + 0.5) / f64::from(columns) * std::f64::consts::TAU)).total();
            (0..3).for_each(|c| total[c] += f64::from(f[c]) * theta.cos());
        }
    }
    total.map(|x| x * std::f64::consts::PI / f64::from(rows) * std::f64::consts::TAU / f64::from(columns))
}

/// What passes and what is scattered is all light, for any fibre, bunch and inclination.
#[test]
fn furnace_is_white() {
    let mut random = Uniform(11);
    let mut fibers: Vec<Fiber> = Species::ALL.map(Fiber::preset).to_vec();
    fibers.extend((0..6).map(|_| random.fiber()));
    fibers.push(Fiber::hair());
    let mut worst = 0.0f32;
    for (k, fiber) in fibers.iter().enumerate() {
        let aggregate = aggregate(&fiber.without_absorption(), TAUS[k % TAUS.len()]);
        let passes = aggregate.bunch().mean_passes() as f32;
        for theta_o in [-1.57, -0.8, 0.0, 0.3, 1.2, 1.5, std::f64::consts::FRAC_PI_2] {
            for energy in aggregate.at(direction(theta_o, 0.4), Window::far()).energy().total() {
                worst = worst.max((passes + (1.0 - passes) * energy - 1.0).abs());
            }
        }
    }
    println!("worst: {worst:e}");
    assert!(worst < ROUNDING, "{worst}");
}

/// Lobes are at least 2.9° wide and rows 0.125°. Tables are linear between nodes on which rows and columns end.
#[test]
fn integral_of_eval_is_the_energy() {
    let fibers = [full_fiber(), Fiber::preset(Species::Dog), Fiber { beta_m: 0.1, ..Fiber::preset(Species::Cat) }];
    for (fiber, tau) in fibers.iter().flat_map(|fiber| [0.3, 5.0].map(|tau| (fiber, tau))) {
        let aggregate = aggregate(fiber, tau);
        for theta_o in [-0.9, 0.2, 1.3] {
            let hit = aggregate.at(direction(theta_o, -2.0), Window::far());
            let (integral, energy) = (integrate(&hit), hit.energy().total());
            for c in 0..3 {
                let error = integral[c] / f64::from(energy[c]) - 1.0;
                // Rows: h² f″/24 for the narrowest lobe, (0.125/2.9)²/24 = 8e-5. Single precision of `eval`: 1e-5.
                assert!(error.abs() < 1e-4, "{fiber:?} τ {tau} θ_o {theta_o} channel {c}: {error}");
            }
        }
    }
}

/// A bunch in which no light collides twice scatters as its member. The tables of inclination and azimuth are linear
/// between nodes 5° and 1.9° apart: the documented L1 error is 0.5 %.
#[test]
fn thin_bunch_scatters_as_its_member() {
    for fiber in [full_fiber(), Fiber::preset(Species::Dog), Fiber::preset(Species::Rabbit), Fiber::hair()] {
        let (aggregate, member) = (aggregate(&fiber, 0.0), Bcsdf::new(&fiber).unwrap());
        for theta_o in [-0.72, 0.05, 1.0] {
            let wo = direction(theta_o, 0.0);
            let (a, b) = (aggregate.at(wo, Window::far()), member.at(wo, Window::far()));
            let (mut difference, mut sum) = (0.0, 0.0);
            for (i, j) in (0..180).flat_map(|i| (0..90).map(move |j| (i, j))) {
                let (theta, phi) = ((f64::from(i) - 89.5).to_radians(), (f64::from(j) * 2.0 + 1.0).to_radians());
                let wi = direction(theta, phi);
                let [a, b] = [a.eval(wi), b.eval(wi)].map(|f| f64::from(f.total()[1]));
                difference += (a - b).abs() * theta.cos();
                sum += b * theta.cos();
            }
            let (energy, other) = (a.energy().total()[1], b.energy().total()[1]);
            println!("{theta_o}: {:.4} {:.4}", difference / sum, energy / other - 1.0);
            assert!(difference / sum < 0.005, "{fiber:?} {theta_o}: {}", difference / sum);
            assert!((energy / other - 1.0).abs() < 0.001, "{fiber:?} {theta_o}: {energy} {other}");
        }
    }
}

/// More fibres absorb more light.
#[test]
fn dense_bunches_are_darker() {
    let energies = TAUS.map(|tau| {
        aggregate(&Fiber::preset(Species::RedFox), tau).at(direction(0.4, 0.0), Window::far()).energy().total()[0]
    });
    assert!(energies.windows(2).all(|pair| pair[1] < pair[0]), "{energies:?}");
}
