//! The paper's far field. Its segments are compared with quadrature and with ours, and its window with the mean of its
//! near field.

use std::f64::consts::{PI, TAU};
use vellus::{Fiber, ScatterExit, Species};
use vellus_reference::as_printed::AsPrinted;
use vellus_reference::exact::Exact;
use vellus_testing::{Uniform, effort, full_fiber, table_data};

/// N(φ) at this many azimuths, first channel, of R + TT + TRT and of TTˢ + TRTˢ.
fn profiles<const N: usize>(azimuths: usize, lobes: impl Fn(f64) -> [[f64; 3]; N]) -> [Vec<f64>; 2] {
    let all: Vec<[f64; 2]> = (0..azimuths)
        .map(|k| lobes((k as f64 + 0.5) / azimuths as f64 * TAU - PI))
        .map(|n| [n[0][0] + n[1][0] + n[2][0], n[3][0] + n[4][0]])
        .collect();
    [0, 1].map(|i| all.iter().map(|n| n[i]).collect())
}

/// The relative L1 distance.
fn l1(value: &[f64], exact: &[f64]) -> f64 {
    value.iter().zip(exact).map(|(a, b)| (a - b).abs()).sum::<f64>() / exact.iter().sum::<f64>()
}

/// The smallest, mean and largest value.
fn spread(x: &[f64]) -> [f64; 3] {
    let [least, sum, most] = x.iter().fold([f64::MAX, 0.0, 0.0], |[a, b, c], &x| [x.min(a), b + x, x.max(c)]);
    [least, sum / x.len() as f64, most]
}

/// Offsets and weights of `n` Gauss–Legendre points on [−1, 1].
fn gauss(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let (mut x, mut slope) = ((PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos(), 0.0);
            for _ in 0..10 {
                let (mut before, mut p) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    (before, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k);
                }
                slope = n as f64 * (x * p - before) / (x * x - 1.0);
                x -= p / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// D9: the far field of the ten presets, with the paper's segments and with ours. For the scattered lobes, also with
/// the same number of Gauss points in asin h″. When our segments were designed, the errors of the paper's segments at
/// θ_o = 0.2 rad were 10 to 62 % with five on each side, and 5 to 35 % with eight.
#[test]
#[ignore = "test: quadrature with 4,000 points"]
fn published_segments_are_coarser_than_ours() {
    const NAMES: [&str; 8] =
        ["paper 5", "paper 8", "ours 5", "ours 8", "paper scattered 4", "paper scattered 8", "Gauss 4", "Gauss 8"];
    let mut table: [[Vec<f64>; 8]; 2] = Default::default();
    for theta_o in [0.2, 0.0, 30f64.to_radians(), 60f64.to_radians(), 80f64.to_radians()] {
        for species in Species::ALL {
            let fiber = Fiber::published(species);
            let oracle = Exact::new(&fiber, table_data()).unwrap();
            let window = oracle.window(theta_o, [-1.0, 1.0], effort(4_000, 10_000), 400);
            let [unscattered, scattered] = profiles(360, |phi| window.azimuthal(phi));
            let paper = [[5, 4], [8, 8]].map(|[n, m]| {
                let segments = oracle.printed_segments(theta_o, [-1.0, 1.0], n, m);
                profiles(360, |phi| segments.azimuthal(phi))
            });
            let ours = [5, 8].map(|n| {
                let segments = oracle.segments(theta_o, [-1.0, 1.0], n);
                let [profile, _] = profiles(360, |phi| {
                    let [r, tt, trt] = segments.azimuthal(phi);
                    [r, tt, trt, [0.0; 3], [0.0; 3]]
                });
                profile
            });
            let points = [4, 8].map(|n| gauss_points(&fiber, &oracle, theta_o, n));
            let errors = [
                l1(&paper[0][0], &unscattered),
                l1(&paper[1][0], &unscattered),
                l1(&ours[0], &unscattered),
                l1(&ours[1], &unscattered),
                l1(&paper[0][1], &scattered),
                l1(&paper[1][1], &scattered),
                l1(&points[0], &scattered),
                l1(&points[1], &scattered),
            ];
            println!("{theta_o:.3} {species} {}", errors.map(|e| format!("{e:.4}")).join(" "));
            let set = usize::from(theta_o != 0.2);
            table[set].iter_mut().zip(errors).for_each(|(all, e)| all.push(e));
        }
    }
    for (set, at) in table.iter().zip(["θ_o 0.2 rad", "θ_o 0°, 30°, 60°, 80°"]) {
        for (errors, name) in set.iter().zip(NAMES) {
            println!("{at:22} {name:18} least, mean, worst {:.4?}", spread(errors));
        }
    }
    let [paper5, paper8, ..] = &table[0];
    let within = |x: &[f64], least: f64, most: f64| x.iter().all(|e| (least..most).contains(e));
    // The errors that were measured then, rounded to percent.
    assert!(within(paper5, 0.095, 0.625) && within(paper8, 0.045, 0.355));
    for [paper5, paper8, ours5, ours8, paper_s4, paper_s8, gauss4, gauss8] in &table {
        for k in 0..paper5.len() {
            assert!(5.0 * ours5[k] < paper5[k] && 10.0 * ours8[k] < paper8[k]);
            // Errors are at least five times smaller, or below 0.1 %. For the mouse, the error of the paper's eight
            // segments is only 0.3 %.
            assert!(5.0 * gauss4[k] < paper_s4[k] && 5.0 * gauss8[k] < paper_s8[k].max(0.005));
        }
        // The mean error is at least ten times smaller, and the largest error twenty times.
        let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
        let worst = |errors: &[f64]| errors.iter().fold(0.0f64, |a, &b| a.max(b));
        for (paper, gauss) in [(paper_s4, gauss4), (paper_s8, gauss8)] {
            assert!(10.0 * mean(gauss) < mean(paper) && 20.0 * worst(gauss) < worst(paper));
        }
    }
}

/// N(φ) of TTˢ + TRTˢ in the far field from `n` Gauss points in asin h″ on each side of 0.
fn gauss_points(fiber: &Fiber, oracle: &Exact, theta_o: f64, n: usize) -> Vec<f64> {
    let [eta, kappa] = [fiber.eta, fiber.kappa].map(f64::from);
    // The edge of the medulla, unless it is beyond the silhouette.
    let edge = kappa * (eta * eta - theta_o.sin().powi(2)).sqrt() / theta_o.cos();
    let last = (1.0 / edge).min(1.0).asin();
    let hits: Vec<_> = gauss(n)
        .into_iter()
        .flat_map(|(x, w)| [1.0, -1.0].map(|side| (side * 0.5 * (1.0 + x) * last, 0.25 * w * last)))
        .map(|(psi, w)| (oracle.at(theta_o, edge * psi.sin()), w * edge * psi.cos()))
        .collect();
    let [_, scattered] = profiles(360, |phi| {
        hits.iter().fold([[0.0; 3]; 6], |sum, (hit, w)| {
            let n = hit.azimuthal(phi);
            std::array::from_fn(|p| std::array::from_fn(|c| sum[p][c] + w * n[p][c]))
        })
    });
    scattered
}

/// With many segments, the linear interpolation between nodes no longer matters. The error of the unscattered lobes
/// falls as 1/n, because γ has a vertical tangent at the silhouette: with 400 segments it is an eightieth of the 62 %
/// with five.
#[test]
fn published_segments_converge() {
    for species in Species::ALL {
        let fiber = Fiber { sigma_ca: [0.3; 3], ..Fiber::published(species) };
        let oracle = Exact::new(&fiber, table_data()).unwrap();
        for (theta_o, range) in [(0.5, [-1.0, 1.0]), (-0.9, [-0.2, 0.85])] {
            let exact = oracle.window(theta_o, range, 10_000, 400);
            let segments = oracle.printed_segments(theta_o, range, 400, 100);
            let [exact, value] =
                [profiles(72, |phi| exact.azimuthal(phi)), profiles(72, |phi| segments.azimuthal(phi))];
            let errors = [0, 1].map(|i| l1(&value[i], &exact[i]));
            println!("{species} {range:?}: {errors:.4?}");
            // The scattered lobes also converge as 1/n, with a square root at the medulla's edge: 4 % · 4/100. TTˢ of
            // 400 midpoints has 1e-4.
            assert!(errors[0] < 0.01 && errors[1] < 0.005, "{species} {range:?}: {errors:?}");
        }
    }
}

/// Compares the published model over a window, with many segments, with the mean of its near field over the window.
#[test]
#[ignore = "test: windows by quadrature"]
fn published_windows_are_the_mean_of_the_near_field() {
    for (theta_o, [h1, h2]) in [(0.4, [-1.0, 1.0]), (-0.9, [-0.3, 0.7]), (0.1, [0.5, 0.9])] {
        let published = AsPrinted::new(&full_fiber().with_exit(ScatterExit::Open), table_data()).unwrap();
        let window = published.window(theta_o, [h1, h2], 400, 100);
        let [first, last] = [h1, h2].map(f64::asin);
        let n = 400;
        let offsets: Vec<_> = (0..n)
            .map(|k| first + (last - first) * (k as f64 + 0.5) / n as f64)
            .map(|gamma| (gamma.sin(), gamma.cos() * (last - first) / (n as f64 * (h2 - h1))))
            .collect();
        for tilt in [-0.15, 0.0, 0.1] {
            let theta_i = tilt - theta_o;
            let (mut distance, mut total) = ([0.0; 5], [0.0; 5]);
            for phi in [-3.0, -2.1, -0.9, 0.2, 1.4, 2.6] {
                let mut exact = [[0.0; 3]; 5];
                for &(h, w) in &offsets {
                    let f = published.eval(theta_o, h, theta_i, phi);
                    (0..5).for_each(|p| (0..3).for_each(|c| exact[p][c] += w * f[p][c]));
                }
                let value = window.eval(theta_i, phi);
                for p in 0..5 {
                    for c in 0..3 {
                        distance[p] += (value[p][c] - exact[p][c]).abs();
                        total[p] += exact[p][c];
                    }
                }
            }
            let errors: [f64; 5] = std::array::from_fn(|p| distance[p] / total[p]);
            println!("θ_o {theta_o} {tilt}: {errors:.5?}");
            assert!(errors.iter().all(|&e| e < 0.01), "θ_o {theta_o} window {h1} to {h2}: {errors:?}");
        }
    }
}

/// A very narrow window equals the near field, for the model and for the published model.
#[test]
fn narrow_published_windows_are_the_near_field() {
    let mut random = Uniform(21);
    for _ in 0..100 {
        let fiber = Fiber { medulla_air: 0.0, ..random.fiber() }.with_exit(ScatterExit::Open);
        let (theta_o, h) = (random.within(-1.3, 1.3), random.within(-0.99, 0.99));
        let narrow = [h - 1e-7, h + 1e-7];
        let (oracle, published) =
            (Exact::new(&fiber, table_data()).unwrap(), AsPrinted::new(&fiber, table_data()).unwrap());
        let (segments, near) = (oracle.printed_segments(theta_o, narrow, 5, 4), oracle.at(theta_o, h));
        let window = published.window(theta_o, narrow, 5, 4);
        for _ in 0..5 {
            let (theta_i, phi) = (random.within(-1.4, 1.4), random.within(-3.1, 3.1));
            let pairs = [
                (segments.azimuthal(phi), std::array::from_fn(|p| near.azimuthal(phi)[p])),
                (window.eval(theta_i, phi), published.eval(theta_o, h, theta_i, phi)),
            ];
            for (value, exact) in pairs {
                for (a, b) in value.as_flattened().iter().zip(exact.as_flattened()) {
                    // dγ/dh ≤ 7.1 and dΦ/dh ≤ 43, so azimuths differ by 4e-6. This is 5e-4 of the narrowest lobe
                    // (0.5°), and has an effect of second order where lobes have light. s_m has a square root at the
                    // medulla's edge, and a linear table has kinks.
                    assert!((a - b).abs() <= 1e-4 * b + 1e-9, "{fiber:?} θ_o {theta_o} h {h} φ {phi}: {a} {b}");
                }
            }
        }
    }
}
