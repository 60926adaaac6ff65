//! Far field and multi-scale mode: the average over a window of offsets, compared with quadrature of the near field.

use std::f64::consts::{PI, TAU};
use vellus::{Bcsdf, Fiber, ScatterExit, Species, Window};
use vellus_reference::exact::Exact;
use vellus_testing::numbers::documented;
use vellus_testing::{Uniform, direction, effort, full_fiber, table_data};

/// Azimuths at which profiles are compared.
const AZIMUTHS: usize = 360;

fn azimuths() -> impl Iterator<Item = f64> {
    (0..AZIMUTHS).map(|k| (k as f64 + 0.5) / AZIMUTHS as f64 * TAU - PI)
}

/// The L1 distance of two profiles over their azimuths, and the integral of the second.
#[derive(Default)]
struct L1 {
    distance: f64,
    total: f64,
}

impl L1 {
    fn add(&mut self, value: f64, exact: f64) {
        self.distance += (value - exact).abs();
        self.total += exact;
    }

    fn relative(&self) -> f64 {
        if self.total > 0.0 { self.distance / self.total } else { 0.0 }
    }
}

/// The presets and the published fibres of ten species at four inclinations, as shipped and with five segments. The sum
/// of R, TT and TRT is compared with 6,000 points in γ (20,000 in `cargo xtask full`), TTˢ and TRTˢ with 400 points
/// in asin h″. So is the energy of each lobe.
#[test]
#[ignore = "test: quadrature with 6,000 points"]
fn far_field_matches_quadrature() {
    // In `cargo xtask full`, four times the points change less than 1e-5.
    far_field(Fiber::preset, "presets");
    far_field(Fiber::published, "published");
}

/// Mean and worst errors as shipped, with five segments, and of the scattered lobes.
fn far_field(of: fn(Species) -> Fiber, fibers: &str) {
    let (mut shipped, mut five, mut scattered, mut energy) = (Vec::new(), Vec::new(), Vec::new(), 0.0);
    for species in Species::ALL {
        let fiber = of(species);
        let (bcsdf, oracle) = (Bcsdf::new(&fiber).unwrap(), Exact::new(&fiber, table_data()).unwrap());
        for degrees in [0.0f64, 30.0, 60.0, 80.0] {
            let theta_o = degrees.to_radians();
            let hit = bcsdf.at(direction(theta_o, 0.0), Window::far());
            let exact = oracle.window(theta_o, [-1.0, 1.0], effort(6_000, 20_000), 400);
            let coarse = oracle.segments(theta_o, [-1.0, 1.0], 5);
            let mut l1: [L1; 3] = Default::default();
            for phi in azimuths() {
                let (fast, slow, coarse) = (hit.azimuthal(phi as f32), exact.azimuthal(phi), coarse.azimuthal(phi));
                let sum = |p: std::ops::Range<usize>| slow[p].iter().map(|n| n[0]).sum::<f64>();
                l1[0].add((0..3).map(|p| f64::from(fast.0[p][0])).sum(), sum(0..3));
                l1[1].add(coarse.iter().map(|n| n[0]).sum(), sum(0..3));
                l1[2].add((3..5).map(|p| f64::from(fast.0[p][0])).sum(), sum(3..5));
            }
            let energies = hit.energy().0.into_iter().zip(exact.energy());
            for (p, (fast, exact)) in energies.enumerate() {
                let error = f64::from(fast[0]) / exact[0] - 1.0;
                energy = f64::max(energy, error.abs());
                // The rest lobe has at most a third of the light of these fibres.
                let bound = if p == 5 { 0.02 } else { 0.01 };
                assert!(error.abs() < bound, "{species} at {degrees}°: energy of lobe {p} off by {error}");
            }
            shipped.push(l1[0].relative());
            five.push(l1[1].relative());
            scattered.push(l1[2].relative());
        }
    }
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let worst = |x: &[f64]| x.iter().fold(0.0, |a: f64, &b| a.max(b));
    println!("{}: energy of a lobe {energy:.4}", of(Species::Cat).exit);
    for (name, errors) in [("sharp", shipped), ("five", five), ("scattered", scattered)] {
        let found = [mean(&errors), worst(&errors)];
        println!("{name:9} {found:.4?}");
        let bounds = ["mean", "worst"].map(|what| documented(&format!("far.{fibers}.{name}.{what}")));
        assert!(found[0] < bounds[0] + 5e-5 && found[1] < bounds[1] + 5e-5, "{name}: {found:?}");
    }
}

/// A thin medulla with a sharp forward peak, where TTˢ and TRTˢ need the most points. Windows are across the axis, on
/// one side of it, and beyond the medulla's edge.
#[test]
fn sharp_medulla_matches_quadrature() {
    let windows = [[-1.0, 1.0], [-0.3, 0.7], [-0.9, 0.05], [-0.8, 0.9], [0.1, 0.9]];
    for (g, sigma_ms) in [(0.78, 0.8), (0.88, 0.5), (0.93, 0.4)] {
        let fiber = Fiber { g, sigma_ms, ..full_fiber() };
        let (bcsdf, oracle) = (Bcsdf::new(&fiber).unwrap(), Exact::new(&fiber, table_data()).unwrap());
        for theta_o in [0.0, -0.8] {
            for window in windows {
                let hit = bcsdf.at(direction(theta_o, 0.0), Window::range(window[0] as f32, window[1] as f32));
                let exact = oracle.window(theta_o, window, 1000, 400);
                let mut l1 = L1::default();
                for phi in azimuths() {
                    let (fast, slow) = (hit.azimuthal(phi as f32), exact.azimuthal(phi));
                    l1.add((3..5).map(|p| f64::from(fast.0[p][1])).sum(), (3..5).map(|p| slow[p][1]).sum());
                }
                let tolerance = 0.01;
                println!("g {g} θ {theta_o} {window:?}: {:.4}", l1.relative());
                assert!(l1.relative() < tolerance, "g {g} θ {theta_o} {window:?}: {}", l1.relative());
            }
        }
    }
}

/// Relative L1 error of R + TT + TRT in the far field, compared with a fine grid of azimuths, for the worst channel.
fn unscattered_error(fiber: &Fiber, theta_o: f64) -> f64 {
    let (bcsdf, oracle) = (Bcsdf::new(fiber).unwrap(), Exact::new(fiber, table_data()).unwrap());
    let n = ((TAU * 10.0 / f64::from(fiber.beta_n)) as usize).max(720);
    let exact = oracle.unscattered_grid(theta_o, [-1.0, 1.0], 40_000, n);
    let hit = bcsdf.at(direction(theta_o, 0.0), Window::far());
    let mut l1: [L1; 3] = Default::default();
    for (k, exact) in exact.iter().enumerate() {
        let fast = hit.azimuthal((TAU * k as f64 / n as f64 - PI) as f32);
        for c in 0..3 {
            l1[c].add((0..3).map(|p| f64::from(fast.0[p][c])).sum(), exact.iter().map(|lobe| lobe[c]).sum());
        }
    }
    l1.iter().map(L1::relative).fold(0.0, f64::max)
}

/// Fibres far from the presets, found by `worst_case` in `lab/`: narrow lobes, η near 1, and a medulla's edge inside
/// the fibre. The bounds are the measured errors (0.09, 2.7 and 0.6 %), rounded up. Without more segments for windows
/// of such fibres the errors are 5 to 82 %.
#[test]
fn difficult_fibers_take_more_segments() {
    let narrow = Fiber { beta_n: 0.65f32.to_radians(), kappa: 0.7, eta: 1.18, ..Fiber::hair() };
    let nearly_one = Fiber {
        eta: 1.0001,
        kappa: 0.0305,
        beta_n: 0.1f32.to_radians(),
        sigma_ca: [4.321, 0.0, 0.0],
        layers: 7.249,
        ..Fiber::hair()
    };
    let gap = Fiber {
        eta: 1.0024,
        kappa: 0.9759,
        beta_n: 0.169f32.to_radians(),
        sigma_ca: [0.0037; 3],
        sigma_ms: 74.19,
        sigma_ma: [152.86; 3],
        layers: 3.327,
        ..Fiber::hair()
    };
    for (name, fiber, degrees, bound) in
        [("narrow", narrow, 0.0f64, 0.002), ("nearly one", nearly_one, -28.49, 0.03), ("gap", gap, 36.53, 0.01)]
    {
        let error = unscattered_error(&fiber, degrees.to_radians());
        println!("{name}: {error:.4}");
        assert!(error < bound, "{name}: {error}");
    }
}

/// A thin medulla with the sharpest forward peak, at grazing light, where the offset moves the peak by 90°. Unless
/// each point's light is spread over the azimuths of its offsets, the error is 24 to 30 %.
#[test]
fn grazing_light_in_a_sharp_medulla_matches_quadrature() {
    let sharp = Fiber { kappa: 0.8, eta: 1.05, sigma_ms: 0.075, g: 0.95, ..Fiber::hair() };
    let thin = Fiber { kappa: 0.9673, eta: 1.8871, sigma_ms: 0.0127, g: 0.9497, layers: 0.107, ..Fiber::hair() };
    for (fiber, degrees) in [(sharp, -89.0f64), (thin, -88.89)] {
        let theta_o = degrees.to_radians();
        let (bcsdf, oracle) = (Bcsdf::new(&fiber).unwrap(), Exact::new(&fiber, table_data()).unwrap());
        let hit = bcsdf.at(direction(theta_o, 0.0), Window::far());
        let exact = oracle.window(theta_o, [-1.0, 1.0], 0, 800);
        let mut l1 = L1::default();
        for phi in azimuths() {
            let (fast, slow) = (hit.azimuthal(phi as f32), exact.azimuthal(phi));
            l1.add((3..5).map(|p| f64::from(fast.0[p][0])).sum(), (3..5).map(|p| slow[p][0]).sum());
        }
        println!("{degrees}°: {:.4}", l1.relative());
        assert!(l1.relative() < 0.01, "{degrees}°: {}", l1.relative());
    }
}

/// The convolution on the grid equals the sum of Gaussians.
#[test]
fn grid_of_azimuths_is_the_sum_over_offsets() {
    for beta in [2.0f32, 11.0, 60.0] {
        let oracle_fiber = Fiber { beta_n: beta.to_radians(), ..full_fiber() };
        let oracle = Exact::new(&oracle_fiber, table_data()).unwrap();
        let n = ((TAU * 10.0 / f64::from(oracle_fiber.beta_n)) as usize).max(720);
        let grid = oracle.unscattered_grid(0.4, [-0.7, 1.0], 4000, n);
        let window = oracle.window(0.4, [-0.7, 1.0], 4000, 0);
        let mut l1 = L1::default();
        for k in (0..n).step_by(7) {
            let exact = window.azimuthal(TAU * k as f64 / n as f64 - PI);
            (0..3).for_each(|p| (0..3).for_each(|c| l1.add(grid[k][p][c], exact[p][c])));
        }
        // Ten steps per standard deviation: see `unscattered_grid`.
        assert!(l1.relative() < 1e-4, "β {beta}°: {}", l1.relative());
    }
}

/// The pieces of a window that the fast path divides into segments, each with its side. They are the two sides of h =
/// 0, but a symmetric window needs only one. For fibres that need more, the sides are divided at the medulla's edge.
/// Then the longest piece is divided in its middle until there are three.
fn pieces([h1, h2]: [f64; 2], edge: f64, more: bool) -> Vec<(usize, [f64; 2])> {
    let symmetric = h1 == -h2;
    let mut pieces: Vec<(usize, [f64; 2])> = [[h1.max(0.0), h2], [(-h2).max(0.0), -h1]]
        .into_iter()
        .enumerate()
        .take(if symmetric { 1 } else { 2 })
        .filter(|(_, [low, high])| high > low)
        .collect();
    while more && pieces.len() < 3 {
        let length = |[low, high]: [f64; 2]| if low < edge && edge < high { 9.0 } else { high.asin() - low.asin() };
        let lengths: Vec<f64> = pieces.iter().map(|&(_, piece)| length(piece)).collect();
        let i = (0..pieces.len()).fold(0, |best, i| if lengths[i] > lengths[best] { i } else { best });
        let (side, [low, high]) = pieces[i];
        let middle = if low < edge && edge < high { edge } else { (0.5 * (low.asin() + high.asin())).sin() };
        pieces[i] = (side, [low, middle]);
        pieces.push((side, [middle, high]));
    }
    pieces
}

/// Compares the fast path with the same segments in f64. No parameter is 0, and colour and window vary.
#[test]
fn fast_segments_match_their_oracle() {
    for (beta, fiber) in
        [1.0f32, 4.0, 7.0, 11.0, 25.0].map(|beta| (beta, Fiber { beta_n: beta.to_radians(), ..full_fiber() }))
    {
        let (bcsdf, oracle) = (Bcsdf::new(&fiber).unwrap(), Exact::new(&fiber, table_data()).unwrap());
        for theta_o in [-0.9, 0.3, 1.3] {
            for window in [[-1.0, 1.0], [-0.3, 0.7], [0.2, 0.5], [-0.99, -0.6]] {
                let hit = bcsdf.at(direction(theta_o, 0.4), Window::range(window[0] as f32, window[1] as f32));
                // Below 0.02 rad the lobes are narrower than the azimuths of a segment.
                let eta = f64::from(fiber.eta);
                let eta_prime = (eta * eta - f64::sin(theta_o).powi(2)).sqrt() / f64::cos(theta_o);
                let pieces = pieces(window, f64::from(fiber.kappa) * eta_prime, fiber.beta_n < 0.02);
                let total: f64 = pieces.iter().map(|(_, [low, high])| high - low).sum();
                // The average of each piece is weighted by its width. Pieces of the left side are mirrored, h → −h
                // and φ → −φ.
                let mut parts = Vec::new();
                for (side, [low, high]) in pieces {
                    let share = (high - low) / total;
                    if window[0] == -window[1] {
                        parts.push((0.5 * share, oracle.segments(theta_o, [low, high], 7)));
                        parts.push((0.5 * share, oracle.segments(theta_o, [-high, -low], 7)));
                    } else {
                        let piece = if side == 0 { [low, high] } else { [-high, -low] };
                        parts.push((share, oracle.segments(theta_o, piece, 7)));
                    }
                }
                let mut l1 = L1::default();
                for phi in azimuths() {
                    let fast = hit.azimuthal(phi as f32);
                    let mut slow = [[0.0; 3]; 3];
                    for (share, segments) in &parts {
                        let part = segments.azimuthal(phi);
                        (0..3).for_each(|p| (0..3).for_each(|c| slow[p][c] += share * part[p][c]));
                    }
                    for p in 0..3 {
                        (0..3).for_each(|c| l1.add(fast.0[p][c].into(), slow[p][c]));
                    }
                }
                // Bells have an error of 1.6e-3, and up to 1.7e-2 for a tilted segment. The rounding of Φ gives 1e-6/β.
                let tolerance = 4e-3;
                assert!(l1.relative() < tolerance, "β {beta}° θ {theta_o} {window:?}: {}", l1.relative());
            }
        }
    }
}

/// A window without width equals the near field, and one from −1 to 1 the far field.
#[test]
fn window_has_both_limits() {
    let mut random = Uniform(11);
    for _ in 0..300 {
        let fiber = random.fiber();
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let wo = direction(random.within(-1.4, 1.4), random.within(-3.0, 3.0));
        // Not close to the silhouette, where 1e-4 of the offset is many degrees.
        let h = random.within(-0.99, 0.99) as f32;
        let near = bcsdf.at(wo, Window::near(h));
        for width in [0.0, 1e-6, 1e-5] {
            let hit = bcsdf.at(wo, Window::pixel(h, width));
            for _ in 0..20 {
                let wi = near.sample(random.numbers()).unwrap().wi;
                let ((a, p), (b, q)) = (near.eval_pdf(wi), hit.eval_pdf(wi));
                // The bound is 1e-3, plus single precision of both sides, see tests/it/exact.rs.
                for (x, y) in a.total().into_iter().zip(b.total()).chain([(p, q)]) {
                    assert!((x - y).abs() <= 3e-3 * x + 1e-4, "{fiber:?} h {h} width {width}: {x} {y}");
                }
            }
        }
        let (all, far) = (bcsdf.at(wo, Window::pixel(h, 4.0)), bcsdf.at(wo, Window::far()));
        let wi = direction(random.within(-1.5, 1.5), random.within(-3.0, 3.0));
        assert_eq!(all.eval_pdf(wi), far.eval_pdf(wi));
    }
}

/// If each hit stands for a cell, the mean energy of hits over the whole width equals that of the far field, for any
/// width of the cells. If each hit stands for a window around it (Yan17 Eq. 27), the means differ. If the window is as
/// wide as the fibre, human hair loses 16 % of R and gains 20 % of TTˢ.
#[test]
fn cells_average_to_the_far_field() {
    let bcsdf = Bcsdf::new(&Fiber::published(Species::Human).with_absorption([0.3, 0.8, 2.0])).unwrap();
    let wo = direction(0.3, 0.0);
    // Each lobe separately, because R is brightest at the edges and the others in the middle.
    let energy = |window: Window| bcsdf.at(wo, window).energy().0.map(|lobe| f64::from(lobe[1]));
    let far = energy(Window::far());
    let (hits, shifts) = (400, 9);
    for width in [0.05, 0.31, 1.0, 1.7, 1.999, 2.0, 4.0f32] {
        let (mut cells, mut around) = ([0.0; 6], [0.0; 6]);
        for i in 0..hits {
            let h = 2.0 * (i as f32 + 0.5) / hits as f32 - 1.0;
            for j in 0..shifts {
                let cell = Window::cell(h, width, (j as f32 + 0.37) / shifts as f32);
                let [low, high] = cell.ends();
                assert!(low - 1e-6 <= h && h <= high + 1e-6 && high - low <= width + 1e-6, "{h} {width}: {cell:?}");
                let (a, b) = (energy(cell), energy(Window::pixel(h, width)));
                let n = f64::from(hits * shifts);
                (0..6).for_each(|p| (cells[p], around[p]) = (cells[p] + a[p] / n, around[p] + b[p] / n));
            }
        }
        println!("width {width}: cells {cells:.4?}, around {around:.4?}, far {far:.4?}");
        for p in 0..6 {
            // With 400 hits, the share of a cell has an error of up to 1/400 of the width at either end. Energies are
            // means over 7 segments.
            assert!((cells[p] - far[p]).abs() < 0.01 * far[p] + 1e-4, "lobe {p}, width {width}: {cells:?} {far:?}");
        }
        if width == 1.0 {
            assert!((around[0] / far[0] - 1.0).abs() > 0.1, "R of windows around hits: {around:?} {far:?}");
        }
    }
    assert_eq!(Window::cell(0.3, 0.0, 0.5), Window::near(0.3));
}

/// Far from all light of a window, only rounding errors remain. They must not become a weight. Without a bound for each
/// span, this weight is 5e18.
#[test]
fn a_sample_far_out_in_a_tail_has_a_bounded_weight() {
    let fiber = Fiber {
        eta: 3.0,
        kappa: 0.45247272,
        alpha: -0.45221087,
        beta_m: 0.008726662,
        beta_n: 0.30258468,
        sigma_ca: [0.0, 1000.0, 0.0],
        sigma_ms: 0.0,
        sigma_ma: [0.0, 2.196484, 2.101408],
        g: 0.28365356,
        layers: 0.5829595,
        exit: vellus::ScatterExit::Open,
        medulla_pigment: 0.3,
        wet: 0.0,
        aspect_ratio: 1.0,
        medulla_air: 0.0,
        reflectance: None,
    };
    let bcsdf = Bcsdf::new(&fiber).unwrap();
    let wo = glam::Vec3::new(0.49523565, 0.111536756, 0.86156905);
    let hit = bcsdf.at(wo, Window::range(-1.0, -0.29856557));
    let (f, pdf) = hit.eval_pdf(glam::Vec3::new(-0.6726947, -0.68112254, 0.289057));
    // The pdf contains the largest channel of each span. A channel exceeds it only by the probabilities of the lobes.
    assert!(f.total().iter().all(|f| *f <= 1.5 * pdf), "{f:?} {pdf}");
}

/// For any fibre and window, nothing is negative, NaN or brighter than white, and the error is bounded.
fn check_any_fibre_and_window(count: i32) {
    let mut random = Uniform(12);
    let mut errors = Vec::new();
    for k in 0..count {
        let fiber = random.fiber();
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let theta_o = random.within(-1.55, 1.55);
        // Widths from 1e-6 to 2. Every other window is the far field.
        let narrow = 1e-6 * 2e6f64.powf(random.next());
        let width = if k % 2 == 0 { 4.0 } else { narrow };
        let middle = random.within(-1.0, 1.0);
        let window = Window::pixel(middle as f32, width as f32);
        let hit = bcsdf.at(direction(theta_o, 0.3), window);
        let bound = 1.0 + 1e-4;
        assert!(hit.energy().total().iter().all(|e| (0.0..bound).contains(e)), "{fiber:?} {theta_o} {window:?}");
        for _ in 0..20 {
            let wi = direction(random.within(-1.57, 1.57), random.within(-3.2, 3.2));
            let (f, pdf) = hit.eval_pdf(wi);
            assert!(
                f.0.iter().flatten().chain([&pdf]).all(|x| x.is_finite() && *x >= 0.0),
                "{fiber:?} {theta_o} {window:?} {wi}: {f:?} {pdf}"
            );
        }
        let s = hit.sample(random.numbers()).unwrap();
        assert!(s.pdf.is_finite() && s.pdf > 0.0 && s.weight.iter().all(|w| (0.0..bound).contains(w)), "{s:?}");
        // Quadrature for a hundredth of the cases.
        if (k % 100 == 0 || k % 100 == 51) && width > 1e-3 {
            let oracle = Exact::new(&fiber, table_data()).unwrap();
            let [h1, h2] = window.ends().map(f64::from);
            let exact = oracle.window(theta_o, [h1, h2], 4000, 200);
            let mut l1 = L1::default();
            for phi in azimuths() {
                let (fast, slow) = (hit.azimuthal(phi as f32), exact.azimuthal(phi));
                (0..6).for_each(|p| l1.add(fast.0[p][1].into(), slow[p][1]));
            }
            errors.push(l1.relative());
        }
    }
    errors.sort_by(f64::total_cmp);
    println!("median {:.4}, worst {:.4} of {}", errors[errors.len() / 2], errors[errors.len() - 1], errors.len());
    assert!(errors[errors.len() - 1] < 0.05 && errors[errors.len() / 2] < 0.005);
}

#[test]
fn some_fibres_and_windows_are_finite() {
    check_any_fibre_and_window(400);
}

#[test]
#[ignore = "test: 60 windows by quadrature"]
fn any_fibre_and_window_is_finite() {
    check_any_fibre_and_window(effort(3_000, 10_000));
}

/// No channel exceeds the density by much in any direction, or the weight of a rare sample of another lobe would be
/// large. The largest channels of the lobes sum to at most 1, and the error of the points of TTˢ and TRTˢ may add to
/// that. The fibre of a dark red is one for which the points had 2.7 times the error in red that they had in blue.
#[test]
fn density_is_at_least_each_channel() {
    let red = Fiber {
        eta: 1.0000311,
        kappa: 0.42547318,
        alpha: -0.03595188,
        beta_m: 0.055799674,
        beta_n: 1.0702012,
        sigma_ca: [0.0, 1.0571562, 0.75892216],
        sigma_ms: 1.6727464,
        sigma_ma: [1000.0, 6.044026e-5, 1000.0],
        g: 0.0,
        layers: 11.74841,
        exit: ScatterExit::Reflecting,
        medulla_pigment: 0.3,
        wet: 0.0,
        aspect_ratio: 1.0,
        medulla_air: 0.0,
        reflectance: None,
    };
    let mut random = Uniform(8);
    let mut worst = 0.0_f32;
    for k in 0..400 {
        let fiber = if k == 0 { red } else { random.fiber() };
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        // The worst inclination of the first fibre, and random ones of the others.
        let theta_o = if k == 0 { -1.5394 } else { random.within(-1.55, 1.55) };
        let hit = bcsdf.at(direction(theta_o, random.within(-3.0, 3.0)), Window::far());
        for _ in 0..if k == 0 { 20_000 } else { 200 } {
            let wi = direction(random.within(-1.57, 1.57), random.within(-PI, PI));
            let (f, pdf) = hit.eval_pdf(wi);
            // Single precision resolves no smaller densities.
            if pdf > 1e-30 {
                worst = f.total().into_iter().fold(worst, |worst, f| worst.max(f / pdf));
            }
        }
    }
    assert!(worst < 1.5, "{worst}");
}
