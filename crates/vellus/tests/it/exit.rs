//! The exit of scattered light from a fibre whose cuticle reflects it (D17).

use std::f64::consts::PI;
use vellus::{Bcsdf, Fiber, Lobe, ScatterExit, Species, Window};
use vellus_reference::exact::Exact;
use vellus_testing::sphere::{ChiSquared, integral, nodes};
use vellus_testing::{Uniform, direction, full_fiber, table_data};

/// A random fibre with reflecting exits.
fn random_fiber(random: &mut Uniform) -> Fiber {
    random.fiber().with_exit(ScatterExit::Reflecting)
}

/// A fibre with reflecting exits whose parameters are often at an end of their ranges.
fn extreme_fiber(random: &mut Uniform) -> Fiber {
    let mut pick = |low: f64, high: f64, typical: f64| {
        let value = match (random.next() * 4.0) as u32 {
            0 => low,
            1 => high,
            2 => low + (typical - low) * random.next(),
            _ => low + (high - low) * random.next(),
        };
        value as f32
    };
    Fiber {
        eta: pick(1.0, 3.0, 1.6),
        kappa: pick(0.0, 0.99, 0.5),
        sigma_ca: std::array::from_fn(|_| pick(0.0, 1000.0, 1.0)),
        sigma_ms: pick(0.0, 1000.0, 2.0),
        sigma_ma: std::array::from_fn(|_| pick(0.0, 1000.0, 1.0)),
        g: pick(0.0, 0.95, 0.5),
        layers: pick(0.0, 20.0, 1.0),
        exit: ScatterExit::Reflecting,
        medulla_pigment: 0.3,
        wet: 0.0,
        aspect_ratio: 1.0,
        medulla_air: 0.0,
        ..full_fiber()
    }
}

fn window(random: &mut Uniform) -> Window {
    let h = random.within(-1.0, 1.0) as f32;
    match (random.next() * 4.0) as u32 {
        0 => Window::far(),
        1 => Window::pixel(h, random.within(0.01, 2.0) as f32),
        _ => Window::near(h),
    }
}

/// Sorts, and returns the mean, the 99th percentile and the largest.
fn statistics(x: &mut [f64]) -> [f64; 3] {
    x.sort_by(f64::total_cmp);
    [x.iter().sum::<f64>() / x.len() as f64, x[x.len() * 99 / 100], x[x.len() - 1]]
}

/// Energies of the near field against quadrature over each state and a direct solution of the chain.
///
/// The fast path interpolates the transmittances of states between nodes, and takes the mean over a state before the
/// layers. A state's error is 0.002 on average, of both signs, and 0.08 at most (`cone.rs`). The light of a query is in
/// many states, unless g is near 1. So an error of 1e-4 is expected, and rarely 0.01.
#[test]
fn energies_match_the_oracle() {
    let mut random = Uniform(31);
    let (mut totals, mut lobes) = (Vec::new(), Vec::new());
    for _ in 0..400 {
        let fiber = random_fiber(&mut random);
        let (bcsdf, oracle) = (Bcsdf::new(&fiber).unwrap(), Exact::new(&fiber, table_data()).unwrap());
        for _ in 0..4 {
            let (wo, h) = (direction(random.within(-1.5, 1.5), 0.3), random.within(-1.0, 1.0) as f32);
            let exact = oracle.path(f64::from(wo.x).asin(), h.into()).energy();
            let fast = bcsdf.at(wo, Window::near(h)).energy();
            for c in 0..3 {
                let total: f64 = exact.iter().map(|a| a[c]).sum();
                totals.push((f64::from(fast.total()[c]) - total).abs());
                lobes.extend((0..6).map(|p| (f64::from(fast.0[p][c]) - exact[p][c]).abs()));
            }
        }
    }
    let (totals, lobes) = (statistics(&mut totals), statistics(&mut lobes));
    println!("totals {totals:.6?}, lobes {lobes:.6?}");
    for [mean, most, worst] in [totals, lobes] {
        assert!(mean < 2e-4 && most < 2e-3 && worst < 0.01, "{mean} {most} {worst}");
    }
}

/// Energies of windows against quadrature. A window has 7 segments, for either exit, so the error of open exits is the
/// measure.
#[test]
fn energies_of_windows_match_the_oracle() {
    let mut random = Uniform(32);
    let mut errors = [vec![], vec![]];
    for k in 0..100 {
        let fiber = random.fiber();
        let h = random.within(-1.0, 1.0) as f32;
        let window = if k % 2 == 0 { Window::far() } else { Window::pixel(h, random.within(0.1, 1.5) as f32) };
        let wo = direction(random.within(-1.4, 1.4), 0.3);
        for (exit, errors) in ScatterExit::ALL.into_iter().zip(&mut errors) {
            let fiber = fiber.with_exit(exit);
            let oracle = Exact::new(&fiber, table_data()).unwrap();
            let exact = oracle.window(f64::from(wo.x).asin(), window.ends().map(f64::from), 2000, 100).energy();
            let fast = Bcsdf::new(&fiber).unwrap().at(wo, window).energy().total();
            for c in 0..3 {
                errors.push((f64::from(fast[c]) - exact.iter().map(|a| a[c]).sum::<f64>()).abs());
            }
        }
    }
    let [open, reflecting] = errors.each_mut().map(|x| statistics(x));
    println!("open {open:.6?}, reflecting {reflecting:.6?}");
    // The transmittances of states add at most the error of the near field.
    for k in 0..3 {
        assert!(reflecting[k] <= open[k] + [2e-4, 2e-3, 0.01][k], "{open:?} {reflecting:?}");
    }
}

/// Values over a window against quadrature: the rest lobe, which has light of two shapes.
#[test]
fn the_rest_lobe_of_windows_matches_the_oracle() {
    let mut random = Uniform(33);
    for fiber in Species::ALL.map(Fiber::published) {
        let fiber = fiber.with_exit(ScatterExit::Reflecting).with_absorption([0.05, 0.3, 1.0]);
        let (bcsdf, oracle) = (Bcsdf::new(&fiber).unwrap(), Exact::new(&fiber, table_data()).unwrap());
        for window in [Window::far(), Window::pixel(0.3, 0.5)] {
            let wo = direction(random.within(-1.2, 1.2), 0.0);
            let hit = bcsdf.at(wo, window);
            let exact = oracle.window(f64::from(wo.x).asin(), window.ends().map(f64::from), 1000, 0);
            for _ in 0..10 {
                let (theta, phi) = (random.within(-1.5, 1.5), random.within(-3.0, 3.0));
                let fast = hit.eval(direction(theta, phi)).0[5];
                for (fast, exact) in fast.into_iter().zip(exact.eval(theta, phi)[5]) {
                    // Energies are exact to 1 % or to 0.01, see above. Shapes are exact to single precision.
                    let error = (f64::from(fast) - exact).abs();
                    assert!(error <= 0.01 * exact + 0.01 * theta.cos() / (PI * PI), "{fiber:?}: {fast} {exact}");
                }
            }
        }
    }
}

/// Without absorption all light leaves. In the near field the sums are those of single precision, and a window's
/// segments are scaled to the same sums.
#[test]
fn energies_sum_to_one_without_absorption() {
    let mut random = Uniform(34);
    let mut worst = 0.0f64;
    for k in 0..20_000 {
        let fiber = if k % 2 == 0 { random_fiber(&mut random) } else { extreme_fiber(&mut random) };
        let bcsdf = Bcsdf::new(&fiber.without_absorption()).unwrap();
        let theta = random.within(-1.57, 1.57);
        let window = window(&mut random);
        let sum = bcsdf.at(direction(theta, 0.3), window).energy().total();
        for sum in sum {
            worst = worst.max((f64::from(sum) - 1.0).abs());
            assert!((sum - 1.0).abs() < 1e-3, "{fiber:?} {theta} {window:?}: {sum}");
        }
    }
    println!("worst {worst:.2e}");
}

#[test]
fn furnace_is_white() {
    for fiber in [full_fiber(), Fiber { kappa: 0.97, eta: 1.2, ..full_fiber() }, Fiber::published(Species::RedFox)] {
        let bcsdf = Bcsdf::new(&fiber.with_exit(ScatterExit::Reflecting).without_absorption()).unwrap();
        for theta_o in [0.0, -1.2] {
            for window in [Window::near(0.1), Window::near(-0.62), Window::far(), Window::pixel(0.5, 0.8)] {
                let hit = bcsdf.at(direction(theta_o, 1.1), window);
                let total = integral(nodes(&fiber), |wi| hit.eval(wi).total()[1]);
                assert!((total - 1.0).abs() < 1e-3, "{fiber:?} {theta_o} {window:?}: {total}");
            }
        }
    }
}

/// Any valid fibre, offset and inclination: no channel gains light, and nothing is negative or NaN.
#[test]
fn no_fibre_gains_light() {
    let mut random = Uniform(35);
    let mut most = 0.0f32;
    for k in 0..20_000 {
        let fiber = if k % 4 == 0 { random_fiber(&mut random) } else { extreme_fiber(&mut random) };
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let (theta, window) = (random.within(-1.5705, 1.5705), window(&mut random));
        let hit = bcsdf.at(direction(theta, 0.3), window);
        let energy = hit.energy();
        most = energy.total().into_iter().fold(most, f32::max);
        // Windows have the bound of tests/it/window.rs.
        let whole = |e: &f32| (0.0..1.0 + 1e-4).contains(e);
        assert!(energy.0.iter().flatten().chain(&energy.total()).all(whole), "{fiber:?} {theta} {window:?} {energy:?}");
        let (f, pdf) = hit.eval_pdf(direction(random.within(-1.57, 1.57), random.within(-3.2, 3.2)));
        assert!(f.0.iter().flatten().chain([&pdf]).all(|x| x.is_finite() && *x >= 0.0), "{fiber:?} {window:?} {f:?}");
        if let Some(s) = hit.sample(random.numbers()) {
            let near = window.ends()[0] == window.ends()[1];
            let bound = if near { 1.0 + 1e-4 } else { 1.5 };
            let valid = s.pdf.is_finite() && s.weight.iter().all(|w| (0.0..bound).contains(w));
            assert!(valid, "{fiber:?} {theta} {window:?} {s:?}");
        }
    }
    println!("at most {most}");
}

/// How much light the channels 1 and 2 have above channel 0. `fiber` gets more absorption in the cortex in channel 1,
/// and in the medulla in channel 2.
fn rise(mut fiber: Fiber, window: Window, random: &mut Uniform) -> f64 {
    let factor = 1.0 + random.next() as f32;
    let [ca, ma] = [fiber.sigma_ca[0].min(400.0), fiber.sigma_ma[0].min(400.0)];
    fiber.sigma_ca = [ca, ca * factor + 0.01, ca];
    fiber.sigma_ma = [ma, ma, ma * factor + 0.01];
    let wo = direction(random.within(-1.5, 1.5), 0.3);
    let [before, cortex, medulla] = Bcsdf::new(&fiber).unwrap().at(wo, window).energy().total();
    let rise = f64::from((cortex - before).max(medulla - before)).max(0.0);
    if rise > 2e-4 {
        println!("{rise:.5} {before} {cortex} {medulla} {wo} {window:?} {fiber:?}");
    }
    rise
}

/// More absorption never gives more light. Polynomials over the entry and single precision allow a small rise.
#[test]
fn absorption_never_gives_light() {
    let mut random = Uniform(36);
    for (exit, name) in ScatterExit::ALL.into_iter().zip(["open", "reflecting"]) {
        let mut rises = [vec![], vec![]];
        for k in 0..20_000 {
            let fiber = if k % 4 == 0 { extreme_fiber(&mut random) } else { random_fiber(&mut random) }.with_exit(exit);
            let near = Window::near(random.within(-1.0, 1.0) as f32);
            rises[0].push(rise(fiber, near, &mut random));
            let wide = if k % 2 == 0 { Window::far() } else { window(&mut random) };
            rises[1].push(rise(fiber, wide, &mut random));
        }
        let [near, windows] = rises.each_mut().map(|x| statistics(x));
        println!("{name}: mean, 99 %, worst: near {near:.6?}, windows {windows:.6?}");
        assert!(near[2] < 2e-4 && windows[2] < 2e-4, "{near:?} {windows:?}");
    }
}

/// More scattering never leaves more light unscattered, and does not change R. Without absorption, the scattered light
/// is the rest, so there is never less of it. With absorption it can rise or fall: light that the medulla scatters back
/// early has a short path through pigment, and light that it scatters often has a long one.
#[test]
fn scattering_never_gives_unscattered_light() {
    const UNSCATTERED: [usize; 3] = [Lobe::R as usize, Lobe::Tt as usize, Lobe::Trt as usize];
    let mut random = Uniform(39);
    let mut worst = 0.0f32;
    for k in 0..20_000 {
        let fiber = if k % 4 == 0 { extreme_fiber(&mut random) } else { random_fiber(&mut random) };
        let fiber = if k % 3 == 0 { fiber.without_absorption() } else { fiber };
        let fiber = fiber.with_exit(ScatterExit::ALL[k % 2]);
        let more = Fiber { sigma_ms: fiber.sigma_ms * (1.0 + random.next() as f32) + 0.01, ..fiber };
        let more = Fiber { sigma_ms: more.sigma_ms.min(1000.0), ..more };
        let (wo, window) = (direction(random.within(-1.5, 1.5), 0.3), window(&mut random));
        let [before, after] = [&fiber, &more].map(|fiber| Bcsdf::new(fiber).unwrap().at(wo, window).energy().0);
        for c in 0..3 {
            // Where the wall of a medulla with air is brighter than the way through it, TT changes its path. Both may
            // absorb another share.
            let changes = fiber.medulla_air > 0.0 && k % 3 != 0;
            for p in UNSCATTERED.into_iter().filter(|p| !changes || *p == 0) {
                worst = worst.max(after[p][c] - before[p][c]);
            }
            if k % 3 == 0 {
                let scattered = |energy: &[[f32; 3]; 6]| 1.0 - UNSCATTERED.map(|p| energy[p][c]).iter().sum::<f32>();
                worst = worst.max(scattered(&before) - scattered(&after));
            }
        }
        assert!(worst < 1e-5, "{worst} {wo} {window:?} {fiber:?}");
    }
    println!("worst {worst:.1e}");
}

/// Without a medulla, without scattering or without a step of the index, the cuticle does not reflect scattered light.
#[test]
fn limits_are_those_of_open_exits() {
    let mut random = Uniform(37);
    for _ in 0..300 {
        let fiber = random_fiber(&mut random);
        let (wo, window) = (direction(random.within(-1.5, 1.5), 0.3), window(&mut random));
        let energy = |fiber: Fiber| Bcsdf::new(&fiber).unwrap().at(wo, window).energy();
        let none = [Fiber { kappa: 0.0, ..fiber }, Fiber { sigma_ms: 0.0, ..fiber }];
        for fiber in none {
            assert_eq!(energy(fiber).0, energy(fiber.with_exit(ScatterExit::Open)).0, "{fiber:?}");
        }
        let few = [Fiber { kappa: 1e-4, ..fiber }, Fiber { sigma_ms: 1e-4, ..fiber }];
        for fiber in few {
            for (a, b) in energy(fiber).total().into_iter().zip(energy(fiber.with_exit(ScatterExit::Open)).total()) {
                // The medulla scatters at most 2 σ_ms κ/cos θ_t of the light, and cos θ_t ≥ 0.2 for η ≥ 1.02.
                let scattered = 10.0 * fiber.sigma_ms * fiber.kappa;
                assert!((a - b).abs() <= scattered + 1e-5, "{fiber:?} {a} {b}");
            }
        }
        // No reflection: nothing leaves late. The rest lobe contains no scattered light.
        let clear = energy(Fiber { eta: 1.0, ..fiber })[Lobe::Rest];
        assert!(clear.iter().all(|x| *x < 1e-5), "{fiber:?} {clear:?}");
        let nearly = energy(Fiber { eta: 1.0005, ..fiber }.without_absorption());
        let open = energy(Fiber { eta: 1.0005, exit: ScatterExit::Open, ..fiber }.without_absorption());
        let late = nearly.0[5][0] - open.0[5][0];
        // Total reflection begins at cos θ′ cos γ = √(1 − 1/η²) = 0.03.
        assert!(late < 0.05, "{fiber:?} {late}");
    }
}

fn fibers() -> [Fiber; 3] {
    [
        full_fiber(),
        Fiber { g: 0.93, sigma_ms: 0.3, layers: 6.0, sigma_ca: [2.5, 0.3, 0.05], ..full_fiber() },
        Fiber::published(Species::RedFox).with_absorption([0.05, 0.4, 0.9]),
    ]
    .map(|fiber| fiber.with_exit(ScatterExit::Reflecting))
}

#[test]
fn pdf_integrates_to_one() {
    for fiber in fibers() {
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        for window in [Window::near(-0.45), Window::far(), Window::pixel(-0.3, 0.9)] {
            let hit = bcsdf.at(direction(0.7, 0.4), window);
            let sum = integral(nodes(&fiber), |wi| hit.pdf(wi));
            assert!((sum - 1.0).abs() < 1e-3, "{fiber:?} {window:?}: {sum}");
        }
    }
}

#[test]
fn histograms_of_samples_match_the_pdf() {
    let hits = [(0.35, Window::near(0.3)), (-1.2, Window::near(-0.8)), (0.35, Window::far())];
    let mut random = Uniform(38);
    let tests = fibers().len() * hits.len();
    for fiber in fibers() {
        let test = ChiSquared { cells: [20, 40], samples: 200_000, nodes: nodes(&fiber), tests };
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        for (theta_o, window) in hits {
            let hit = bcsdf.at(direction(theta_o, 2.2), window);
            let follows = test.check(|| hit.sample(random.numbers()).unwrap().wi, |wi| hit.pdf(wi));
            assert_eq!(follows, Ok(()), "{fiber:?} θ_o {theta_o} {window:?}");
        }
    }
}

/// The rest lobe has two parts, diffuse light and light that the medulla did not scatter. Of this fibre they have
/// different colours. The mean of sin² θᵢ tells how often each is drawn: it differs by a tenth between them, and the
/// error of the mean is a thousandth, so that a share that is wrong by a tenth is ten standard errors.
#[test]
fn both_parts_of_the_rest_lobe_are_drawn_by_the_brightest_channel() {
    let fiber = fibers()[1];
    let bcsdf = Bcsdf::new(&fiber).unwrap();
    let mut random = Uniform(39);
    for window in [Window::near(0.2), Window::far()] {
        let hit = bcsdf.at(direction(0.35, 0.0), window);
        // Blue is the brightest channel at every offset.
        let (energy, probabilities) = (hit.energy().0[5][2], hit.lobe_probabilities());
        let expected = integral(nodes(&fiber), |wi| hit.eval(wi).0[5][2] * wi.x * wi.x) / f64::from(energy);
        let count = 50_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..count {
            let mut u = random.numbers();
            u[0] = (1.0 - probabilities[5]) + 0.999 * probabilities[5] * u[0];
            let sample = hit.sample(u).unwrap();
            assert_eq!(sample.lobe, Lobe::Rest);
            let square = f64::from(sample.wi.x * sample.wi.x);
            (sum, squares) = (sum + square, squares + square * square);
        }
        let mean = sum / f64::from(count);
        let error = ((squares / f64::from(count) - mean * mean) / f64::from(count)).sqrt();
        // A false alarm has the probability 1e-5.
        assert!((mean - expected).abs() < 4.5 * error, "{window:?}: {mean} ± {error}, {expected}");
    }
}
