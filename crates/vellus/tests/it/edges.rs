//! Limits, symmetries and bad input.

use std::array::from_fn;
use std::f64::consts::{FRAC_PI_2, PI};
use std::panic::{AssertUnwindSafe, catch_unwind};
use vellus::glam::Vec3;
use vellus::wide::f32x8;
use vellus::{Bcsdf, Error, Fiber, Lobe, Sample, ScatterExit, Species, TableData, Tables, Window};
use vellus_testing::{Uniform, direction, full_fiber};

#[test]
fn edges_are_finite() {
    let base = full_fiber();
    let tiny = 0.1f32.to_radians();
    let wide = 90f32.to_radians();
    let edge = [
        Fiber { kappa: 0.0, ..base },
        Fiber { kappa: 0.99, ..base },
        Fiber { eta: 1.0, ..base },
        Fiber { eta: 3.0, ..base },
        Fiber { beta_m: tiny, beta_n: tiny, ..base },
        Fiber { beta_m: wide, beta_n: wide, ..base },
        Fiber { sigma_ca: [0.0; 3], sigma_ma: [0.0; 3], sigma_ms: 0.0, ..base },
        Fiber { sigma_ca: [1000.0; 3], sigma_ma: [1000.0; 3], sigma_ms: 1000.0, ..base },
        Fiber { sigma_ms: 1e-20, g: 0.95, ..base },
        Fiber { sigma_ms: 1000.0, g: 0.95, eta: 1.0, ..base.without_absorption() },
        Fiber { layers: 0.0, ..base },
        Fiber { layers: 20.0, ..base },
        Fiber { alpha: 45f32.to_radians(), ..base },
    ];
    let mut random = Uniform(6);
    for fiber in edge {
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        for theta_o in [-FRAC_PI_2, -1.57, -0.4, 0.0, 1.3, FRAC_PI_2 - 1e-5, FRAC_PI_2] {
            for h in [-1.0, -0.9999999, -0.5, -0.0, 0.0, 1e-20, 0.7, 1.0f32] {
                let hit = bcsdf.at(direction(theta_o, 0.2), Window::near(h));
                let total = hit.energy().total();
                assert!(total.iter().all(|t| (0.0..1.0 + 1e-5).contains(t)), "{fiber:?} {theta_o} {h} {total:?}");
                for theta_i in [-FRAC_PI_2, -1.2, 0.0, 0.4, 1.57, FRAC_PI_2] {
                    for phi in [-3.2, -1.0, 0.2, 2.9, 3.3415] {
                        let (f, pdf) = hit.eval_pdf(direction(theta_i, phi));
                        assert!(pdf.is_finite() && pdf >= 0.0, "{fiber:?} {theta_o} {h} {theta_i} {phi} {pdf}");
                        assert!(
                            f.0.iter().flatten().all(|x| x.is_finite() && *x >= 0.0),
                            "{fiber:?} {theta_o} {h} {f:?}"
                        );
                    }
                }
                for k in 0..40 {
                    let mut u = random.numbers();
                    // Include the ends of the unit interval.
                    if k < 4 {
                        u[k] = 0.0
                    } else if k < 8 {
                        u[k - 4] = 1.0 - f32::EPSILON / 2.0
                    }
                    let Some(s) = hit.sample(u) else { continue };
                    assert!(
                        s.pdf.is_finite() && s.pdf > 0.0 && (s.wi.length() - 1.0).abs() < 1e-4,
                        "{fiber:?} {theta_o} {h} {s:?}"
                    );
                    assert!(s.weight.iter().all(|w| (0.0..1.0 + 1e-4).contains(w)), "{fiber:?} {theta_o} {h} {s:?}");
                }
            }
        }
    }
}

/// (h, φ) → (−h, −φ) changes nothing.
#[test]
fn symmetric_in_h_and_phi() {
    let bcsdf = Bcsdf::new(&full_fiber()).unwrap();
    let mut random = Uniform(7);
    for _ in 0..2000 {
        let (theta_o, theta_i) = (random.within(-1.5, 1.5), random.within(-1.5, 1.5));
        let (h, phi) = (random.within(-1.0, 1.0) as f32, random.within(-3.1, 3.1));
        let wo = direction(theta_o, 0.0);
        let other = random.within(-1.0, 1.0) as f32;
        for (window, mirrored) in [
            (Window::near(h), Window::near(-h)),
            (Window::range(h, other), Window::range(-h, -other)),
            (Window::far(), Window::far()),
        ] {
            let a = bcsdf.at(wo, window).eval(direction(theta_i, phi));
            let b = bcsdf.at(wo, mirrored).eval(direction(theta_i, -phi));
            for (x, y) in a.0.iter().flatten().zip(b.0.iter().flatten()) {
                // Mirrored angles round alike, except for the last bit of φ: 2e-7/β_n of the value.
                assert!((x - y).abs() <= 1e-4 * x.abs() + 1e-6, "θ_o {theta_o} {window:?} φ {phi}: {a:?} {b:?}");
            }
        }
    }
}

/// The model is not reciprocal: h and the attenuation belong to ω_o. This is the share of the light that changes if ω_o
/// and ω_i are exchanged, over directions of equal solid angle with inclinations up to 75°.
#[test]
fn the_far_field_is_nearly_reciprocal() {
    const INCLINATIONS: usize = 40;
    const AZIMUTHS: usize = 36;
    let middle = |i: usize, count: usize| (i as f64 + 0.5) / count as f64;
    let most = 75f64.to_radians().sin();
    let theta: [f64; INCLINATIONS] = from_fn(|i| ((2.0 * middle(i, INCLINATIONS) - 1.0) * most).asin());
    let phi: [f64; AZIMUTHS] = from_fn(|k| PI * middle(k, AZIMUTHS));
    for species in Species::ALL {
        let bcsdf = Bcsdf::new(&Fiber::preset(species)).unwrap();
        // g = f·cos θᵢ·cos θ_o for each θ_o, θᵢ and φ. The far field is symmetric in φ.
        let row = |theta_o: f64| -> Vec<[f64; AZIMUTHS]> {
            let hit = bcsdf.at(direction(theta_o, 0.0), Window::far());
            let value = |theta_i, phi| f64::from(hit.eval(direction(theta_i, phi)).total()[1]) * theta_o.cos();
            theta.iter().map(|theta_i| phi.map(|phi| value(*theta_i, phi))).collect()
        };
        let g: Vec<_> = theta.into_iter().map(row).collect();
        let (mut changes, mut all) = (0.0f64, 0.0f64);
        for (o, i) in (0..INCLINATIONS).flat_map(|o| (0..INCLINATIONS).map(move |i| (o, i))) {
            for (there, back) in g[o][i].iter().zip(&g[i][o]) {
                changes += 0.5 * (there - back).abs();
                all += *there;
            }
        }
        let share = changes / all;
        println!("{species}: {:.2} %", 100.0 * share);
        assert!(share > 0.0 && share < 0.035, "{species}: {share}");
    }
}

/// At h = 0 the medulla scatters equally to both sides, and C^N has no jump where h changes its sign.
#[test]
fn scattering_is_symmetric_at_the_axis() {
    let mut random = Uniform(17);
    for _ in 0..200 {
        let fiber = Fiber { kappa: 0.8, sigma_ms: 10f64.powf(random.within(-1.0, 1.5)) as f32, ..random.fiber() };
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let wo = direction(random.within(-1.5, 1.5), 0.0);
        let (theta_i, phi) = (random.within(-1.5, 1.5), random.within(0.05, 3.1));
        for (h, other) in [(0.0, 0.0), (1e-6, 1e-6), (1e-6, -1e-6)] {
            let a = bcsdf.at(wo, Window::near(h)).eval(direction(theta_i, phi));
            // The mirrored direction at the same offset, or the same direction at the mirrored offset.
            let mirrored = if h == other { -phi } else { phi };
            let b = bcsdf.at(wo, Window::near(other)).eval(direction(theta_i, mirrored));
            for p in [Lobe::Tts as usize, Lobe::Trts as usize] {
                for (x, y) in a.0[p].into_iter().zip(b.0[p]) {
                    // A half-degree step of a table changes by at most a third: an error of 4e-6 in the azimuth gives
                    // 2e-4.
                    assert!((x - y).abs() <= 5e-4 * x.abs() + 1e-6, "{fiber:?} h {h} {other}: {a:?} {b:?}");
                }
            }
        }
    }
}

/// Without medulla the model equals the hair model to the bit, for any other parameters of the medulla.
#[test]
fn no_medulla_is_hair() {
    let hair = Fiber { kappa: 0.0, sigma_ms: 0.0, sigma_ma: [0.0; 3], g: 0.0, ..full_fiber() };
    let bare = Fiber { kappa: 0.0, ..full_fiber() };
    let (a, b) = (Bcsdf::new(&hair).unwrap(), Bcsdf::new(&bare).unwrap());
    let mut random = Uniform(8);
    for _ in 0..1000 {
        let wo = direction(random.within(-1.5, 1.5), random.within(-3.0, 3.0));
        let wi = direction(random.within(-1.5, 1.5), random.within(-3.0, 3.0));
        let window = Window::near(random.within(-1.0, 1.0) as f32);
        let (x, y) = (a.at(wo, window), b.at(wo, window));
        assert_eq!(x.eval_pdf(wi), y.eval_pdf(wi));
        let u = random.numbers();
        assert_eq!(x.sample(u), y.sample(u));
        assert_eq!(x.energy()[Lobe::Tts], [0.0; 3]);
    }
}

/// With a shrinking medulla the model tends to the hair model.
#[test]
fn small_medulla_tends_to_hair() {
    let hair = Bcsdf::new(&Fiber { kappa: 0.0, ..full_fiber() }).unwrap();
    let wi = direction(-0.3, 2.5);
    let wo = direction(0.4, 0.0);
    let window = Window::near(0.2);
    let f0 = hair.at(wo, window).eval(wi).total()[1];
    for kappa in [1e-2, 1e-4, 1e-6] {
        let fiber = Fiber { kappa, ..full_fiber() };
        let f = Bcsdf::new(&fiber).unwrap().at(wo, window).eval(wi).total()[1];
        // |h′| = 0.13 > κ: the path misses the medulla.
        assert!((f / f0 - 1.0).abs() < 1e-5, "κ {kappa}: {f} {f0}");
    }
    // On the axis the scattered fraction is 2κσ.
    let energy = Bcsdf::new(&Fiber { kappa: 1e-4, ..full_fiber() }).unwrap().at(wo, Window::near(0.0)).energy();
    assert!(energy.0[3][1] > 0.0 && energy.0[3][1] < 1e-3);
}

/// D11: positive tilt moves the R highlight toward the root (−x).
#[test]
fn tilt_moves_the_highlight_toward_the_root() {
    let tilted = Fiber { alpha: 5f32.to_radians(), kappa: 0.0, ..full_fiber() };
    let hit = Bcsdf::new(&tilted).unwrap();
    let hit = hit.at(direction(0.0, 0.0), Window::near(0.0));
    let r = |theta: f64| hit.eval(direction(theta, 0.0)).0[0][0];
    assert!(r(-5f64.to_radians()) > 1.5 * r(5f64.to_radians()));
}

/// A mirror reflection leaves at −2γ: the normal has the azimuth φ_o − γ_o.
#[test]
fn reflection_leaves_on_the_side_of_the_normal() {
    let bcsdf = Bcsdf::new(&full_fiber()).unwrap();
    let hit = bcsdf.at(direction(0.0, 0.0), Window::near(0.5));
    let r = |phi: f64| hit.eval(direction(0.0, phi)).0[0][0];
    assert!(r(-60f64.to_radians()) > 100.0 * r(60f64.to_radians()));
}

/// The scattered lobe of a thin medulla is Henyey–Greenstein around the refracted ray.
#[test]
fn thin_medulla_scatters_once() {
    let fiber = Fiber { sigma_ms: 1e-4, g: 0.5, eta: 1.0, kappa: 0.9, ..full_fiber() };
    let bcsdf = Bcsdf::new(&fiber).unwrap();
    let hit = bcsdf.at(direction(0.0, 0.0), Window::near(0.0));
    // In the normal plane, the ratio of forward to backward scattering is ((1+g)/(1−g))³ for the phase function. The
    // separable form M·N only has the same order of magnitude, so only the azimuthal marginal has a tight bound.
    let azimuthal = |phi: f64| {
        let n = 400;
        (0..n)
            .map(|i| {
                let theta = ((f64::from(i) + 0.5) / f64::from(n) - 0.5) * std::f64::consts::PI;
                f64::from(hit.eval(direction(theta, phi)).0[3][1]) * theta.cos()
            })
            .sum::<f64>()
            * std::f64::consts::PI
            / f64::from(n)
    };
    let marginal = |cos_phi: f64| {
        let n = 2000;
        let g = 0.5f64;
        (0..n)
            .map(|i| {
                let theta = ((f64::from(i) + 0.5) / f64::from(n) - 0.5) * std::f64::consts::PI;
                let cos = theta.cos() * cos_phi;
                theta.cos() * (1.0 - g * g) / (4.0 * std::f64::consts::PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5))
            })
            .sum::<f64>()
            * std::f64::consts::PI
            / f64::from(n)
    };
    let scale = f64::from(hit.energy().0[3][1]);
    for phi in [0.0, 0.8, 1.6, 2.4, 3.0] {
        let (ours, exact) = (azimuthal(phi) / scale, marginal(-phi.cos()));
        // The error of the compression: 3 % of a profile on average, up to twice that at one angle.
        assert!((ours / exact - 1.0).abs() < 0.06, "φ {phi}: {ours} {exact}");
    }
}

/// Numbers that no argument may have.
const WRONG: [f32; 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];

/// The same vector eight times.
fn eight(v: Vec3) -> [f32x8; 3] {
    v.to_array().map(f32x8::splat)
}

/// A sample, if there is one, has finite numbers and a density above 0.
fn check_sample(sample: Option<Sample>) {
    if let Some(Sample { wi, pdf, weight, .. }) = sample {
        let finite = wi.is_finite() && pdf.is_finite() && weight.iter().all(|w| w.is_finite());
        assert!(finite && pdf > 0.0, "{sample:?}");
    }
}

/// Uniform numbers are not checked. Bad ones give no sample, or one whose numbers are finite.
#[test]
fn bad_uniform_numbers_give_no_bad_samples() {
    let mut random = Uniform(9);
    for fiber in [full_fiber(), full_fiber().with_exit(ScatterExit::Open), Fiber::hair()] {
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        for window in [Window::near(0.3), Window::near(-1.0), Window::pixel(0.4, 0.5), Window::far()] {
            let hit = bcsdf.at(direction(0.4, 0.2), window);
            for (k, wrong) in (0..5).flat_map(|k| WRONG.into_iter().chain([-1.0, 1.0, 2.0]).map(move |x| (k, x))) {
                let all: [[f32; 5]; 8] = from_fn(|_| {
                    let mut u = random.numbers();
                    u[k] = wrong;
                    u
                });
                all.into_iter().for_each(|u| check_sample(hit.sample(u)));
                let columns = from_fn(|c| f32x8::new(from_fn(|i| all[i][c])));
                hit.sample8(columns).into_iter().for_each(check_sample);
            }
        }
    }
}

/// Offsets out of range are clamped. NaN stays NaN: it does not become the silhouette at −1, which reflects all light.
#[test]
fn eight_offsets_are_clamped_as_single_ones_and_nan_stays() {
    let bcsdf = Bcsdf::new(&full_fiber()).unwrap();
    // Where R leaves from the silhouette.
    let (wo, wi) = (direction(0.4, 0.2), direction(-0.45, 0.2 + PI));
    let h = [f32::NAN, -1.0, 0.3, -7.0, 7.0, f32::INFINITY, f32::NEG_INFINITY, 0.0];
    let hits = bcsdf.at8(eight(wo), f32x8::new(h));
    let (values, densities) = hits.eval_pdf8(eight(wi));
    let lane = |x: f32x8, i: usize| x.to_array()[i];
    for i in 1..8 {
        let (value, pdf) = bcsdf.at(wo, Window::near(h[i])).eval_pdf(wi);
        let both = value.0.as_flattened().iter().zip(values.0.as_flattened());
        for (x, y) in both.chain([(&pdf, &densities)]) {
            let y = lane(*y, i);
            assert!((x - y).abs() <= 1e-4 * x.abs() + 1e-6, "h {}: {x} {y}", h[i]);
        }
    }
    let r = |i: usize| lane(values[Lobe::R][0], i);
    assert!(r(1) > 0.1, "{}", r(1));
    assert!(r(0).is_nan() || r(0) < 1e-10, "{}", r(0));
    // Nor does a lane with NaN change its neighbours, or give a bad sample.
    hits.sample8([0.1, 0.2, 0.3, 0.4].map(f32x8::splat)).into_iter().for_each(check_sample);
}

/// Builds with debug assertions panic at a direction without unit length, at NaN in a window, and at a width below 0.
/// In other builds such a call returns, and what it returns means nothing. No sample has a number that is not finite.
#[test]
fn numbers_that_are_not_valid_are_found_or_do_no_harm() {
    fn tried<R>(call: impl FnOnce() -> R) -> Option<R> {
        let result = catch_unwind(AssertUnwindSafe(call)).ok();
        assert_eq!(result.is_none(), cfg!(debug_assertions));
        result
    }
    let bcsdf = Bcsdf::new(&full_fiber()).unwrap();
    let good = direction(0.4, 0.2);
    let u = [0.1, 0.2, 0.3, 0.4, 0.5];
    for (axis, wrong) in WRONG.into_iter().enumerate() {
        let mut bad = good.to_array();
        bad[axis] = wrong;
        let bad = Vec3::from_array(bad);
        for window in [Window::near(0.3), Window::pixel(0.4, 0.5), Window::far()] {
            check_sample(tried(|| bcsdf.at(bad, window).sample(u)).flatten());
            tried(|| bcsdf.with_hit(bad, window, |hit| hit.eval_pdf(good)));
            let hit = bcsdf.at(good, window);
            tried(|| hit.eval(bad));
            tried(|| hit.pdf(bad));
            tried(|| hit.eval_pdf(bad));
            tried(|| hit.eval_pdf8(eight(bad)));
            // An azimuth is not checked, and neither are the directions of eight hits.
            hit.azimuthal(wrong);
        }
        bcsdf.at8(eight(good), f32x8::splat(0.3)).eval_pdf8(eight(bad));
        let samples =
            tried(|| bcsdf.at8(eight(bad), f32x8::splat(0.3)).sample8([u[0], u[1], u[2], u[3]].map(f32x8::splat)));
        samples.into_iter().flatten().for_each(check_sample);
    }
    let windows: [fn() -> Window; 9] = [
        || Window::near(f32::NAN),
        || Window::range(f32::NAN, 0.5),
        || Window::range(0.5, f32::NAN),
        || Window::pixel(f32::NAN, 0.5),
        || Window::pixel(0.3, f32::NAN),
        || Window::pixel(0.3, -1.0),
        || Window::cell(f32::NAN, 0.5, 0.3),
        || Window::cell(0.3, f32::NAN, 0.3),
        || Window::cell(0.3, 0.5, f32::NAN),
    ];
    for window in windows.into_iter().filter_map(tried) {
        let hit = bcsdf.at(good, window);
        hit.eval_pdf(good);
        check_sample(hit.sample(u));
    }
    // Infinite offsets and widths are valid.
    assert_eq!(Window::near(f32::INFINITY), Window::near(1.0));
    assert_eq!(Window::pixel(0.3, f32::INFINITY), Window::far());
    assert_eq!(Window::cell(0.3, f32::INFINITY, 0.5), Window::far());
}

#[test]
fn bad_parameters_are_named_with_value_and_range() {
    let bad: [(&str, Fiber); 8] = [
        ("kappa = 1", Fiber { kappa: 1.0, ..full_fiber() }),
        ("eta = 0.9", Fiber { eta: 0.9, ..full_fiber() }),
        ("sigma_ca.g = -0.1", Fiber { sigma_ca: [0.1, -0.1, 0.1], ..full_fiber() }),
        ("sigma_ms = NaN", Fiber { sigma_ms: f32::NAN, ..full_fiber() }),
        ("sigma_ma.b = inf", Fiber { sigma_ma: [0.0, 0.0, f32::INFINITY], ..full_fiber() }),
        ("g = 1", Fiber { g: 1.0, ..full_fiber() }),
        ("beta_m = 0", Fiber { beta_m: 0.0, ..full_fiber() }),
        ("layers = -1", Fiber { layers: -1.0, ..full_fiber() }),
    ];
    for (message, fiber) in bad {
        let e = Bcsdf::new(&fiber).unwrap_err();
        assert!(matches!(e, Error::OutOfRange { .. }) && e.to_string().starts_with(message), "{e}");
        assert!(e.to_string().contains('['), "the range is missing: {e}");
    }
}

#[test]
fn broken_tables_are_refused() {
    let good = Tables::SHIPPED;
    assert!(good.len() <= 150_000, "the tables have {} bytes", good.len());
    let data = TableData::from_bytes(good).unwrap();
    assert_eq!(data.to_bytes().unwrap(), good);
    let refused = |bytes: &[u8], why: &str| {
        let e = TableData::from_bytes(bytes).unwrap_err().to_string();
        assert!(e.contains(why), "{e}");
    };
    refused(b"", "VELLUSM1");
    refused(&good[..40], "header");
    refused(&good[..good.len() - 1], "bytes follow the header");
    let mut damaged = good.to_vec();
    damaged[1000] ^= 1;
    refused(&damaged, "checksum");
    let mut lie = good.to_vec();
    lie[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    refused(&lie, "[1, 4096]");
    let mut negative = data;
    negative.azimuthal.factors[3][7] = -1.0;
    assert!(negative.to_bytes().unwrap_err().to_string().contains("-1"));
}
