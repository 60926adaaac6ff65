//! Energies of the lobes, and the white furnace.

use std::f64::consts::{PI, TAU};
use vellus::{Bcsdf, Fiber, Hit, ScatterExit, Species, Window};
use vellus_reference::as_printed::AsPrinted;
use vellus_reference::exact::Exact;
use vellus_testing::sphere::nodes;
use vellus_testing::{direction, effort, full_fiber, table_data};

/// A grid of all parameters, without absorption, with one exit after the other.
fn lossless_grid() -> impl Iterator<Item = (Fiber, f64, f64)> {
    let mut cases = Vec::new();
    for kappa in [0.0, 0.15, 0.5, 0.8, 0.98] {
        for eta in [1.05, 1.2, 1.55, 2.0] {
            for sigma_ms in [0.0, 0.01, 1.0, 5.0, 20.0] {
                for layers in [0.3, 0.5, 1.0, 3.0] {
                    for theta_o in [0.0, -20.0, 45.0, 70.0, 85.0] {
                        for h in [-1.0, -0.999, -0.8, 0.0, 0.05, 0.95, 0.9999] {
                            let exit = ScatterExit::ALL[cases.len() % 2];
                            let fiber =
                                Fiber { kappa, eta, sigma_ms, layers, exit, ..full_fiber().without_absorption() };
                            cases.push((fiber, f64::to_radians(theta_o), h));
                        }
                    }
                }
            }
        }
    }
    cases.into_iter()
}

fn sum(energy: &[[f64; 3]; 6], c: usize) -> f64 {
    energy.iter().map(|a| a[c]).sum()
}

/// A third of the grid has each value with each value of every other parameter: 3 divides none of their numbers.
#[test]
fn lobes_sum_to_one_without_absorption() {
    for (fiber, theta_o, h) in lossless_grid().step_by(effort(3, 1)) {
        let exact = Exact::new(&fiber, table_data()).unwrap().at(theta_o, h).energy();
        for c in 0..3 {
            assert!((sum(&exact, c) - 1.0).abs() < 1e-6, "{fiber:?} {theta_o} {h}: {}", sum(&exact, c));
        }
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let fast = bcsdf.at(direction(theta_o, 0.3), Window::near(h as f32)).energy().total();
        // Single precision: six terms of at most eight roundings each, 6·8·6e-8 = 3e-6, and exp.
        assert!((fast[1] - 1.0).abs() < 5e-6, "{fiber:?} {theta_o} {h}: {fast:?}");
    }
}

/// D6: the published model loses the light beyond R, TT, TRT, TTˢ, TRTˢ: (1 − F) F² T².
#[test]
fn the_published_lobes_lack_the_higher_orders() {
    let fiber = Fiber { layers: 3.0, sigma_ms: 0.2, exit: ScatterExit::Open, ..full_fiber().without_absorption() };
    let (theta, h) = (0.0, 0.9);
    let published: f64 = AsPrinted::new(&fiber, table_data()).unwrap().energy(theta, h).iter().map(|a| a[0]).sum();
    let rest = Exact::new(&fiber, table_data()).unwrap().at(theta, h).energy()[5][0];
    // At θ = 0 the two models agree in everything else.
    assert!(rest > 0.02 && (published + rest - 1.0).abs() < 1e-9, "{published} {rest}");
}

/// D4: with F of Table 3 instead of 1 − F, TTˢ would lose most of its light.
#[test]
fn tts_enters_through_the_cuticle_not_by_reflection() {
    let fiber = Fiber { sigma_ms: 20.0, exit: ScatterExit::Open, ..full_fiber().without_absorption() };
    let energy = Exact::new(&fiber, table_data()).unwrap().at(0.0, 0.0).energy();
    let f = energy[0][0];
    assert!(f < 0.1 && (energy[3][0] - (1.0 - f)).abs() < 1e-3, "F {f}, TTs {}", energy[3][0]);
}

/// Integral of f·cos θᵢ over the sphere, by the midpoint rule in θᵢ and φ.
fn integrate(hit: &Hit, [n_theta, n_phi]: [u32; 2]) -> [f64; 3] {
    let mut total = [0.0; 3];
    for i in 0..n_theta {
        let theta = ((f64::from(i) + 0.5) / f64::from(n_theta) - 0.5) * PI;
        let mut ring = [0.0f64; 3];
        for j in 0..n_phi {
            let phi = (f64::from(j) + 0.5) / f64::from(n_phi) * TAU;
            let f = hit.eval(direction(theta, phi)).total();
            (0..3).for_each(|c| ring[c] += f64::from(f[c]));
        }
        let weight = theta.cos() * PI / f64::from(n_theta) * TAU / f64::from(n_phi);
        (0..3).for_each(|c| total[c] += ring[c] * weight);
    }
    total
}

/// The fibres of ten species with both exits, at five inclinations, two of them grazing, in four windows.
#[test]
fn furnace_is_white() {
    for (species, fiber) in Species::ALL.iter().flat_map(|s| [(s, Fiber::preset(*s)), (s, Fiber::published(*s))]) {
        let fiber = fiber.without_absorption();
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        for theta_o in [0.0f64, -30.0, 60.0, 80.0, 85.0] {
            for window in [Window::near(0.1), Window::near(-0.62), Window::far(), Window::pixel(0.5, 0.8)] {
                let hit = bcsdf.at(direction(theta_o.to_radians(), 1.1), window);
                let total = integrate(&hit, nodes(&fiber))[1];
                assert!((total - 1.0).abs() < 1e-3, "{species} {} at {theta_o}°, {window:?}: {total}", fiber.exit);
            }
        }
    }
}

/// With absorption, too, the integral of each lobe is its A.
#[test]
fn integral_of_eval_is_the_energy() {
    for exit in ScatterExit::ALL {
        let bcsdf = Bcsdf::new(&full_fiber().with_exit(exit)).unwrap();
        for (theta_o, h) in [(0.3f64, 0.25f32), (-1.1, -0.7), (0.9, 0.98)] {
            let hit = bcsdf.at(direction(theta_o, -2.0), Window::near(h));
            let (integral, energy) = (integrate(&hit, nodes(&full_fiber())), hit.energy().total());
            for c in 0..3 {
                let error = integral[c] / f64::from(energy[c]) - 1.0;
                assert!(error.abs() < 1e-3, "{exit} θ {theta_o} h {h} channel {c}: {error}");
            }
        }
    }
}
