//! Whether reported errors and intervals are right, for random fibres and gantries.

use vellus::{Fiber, Parameter};
use vellus_fit::parameters::Kind;
use vellus_fit::{Fit, Forward, Options, Profile, State, Synthetic, fit, simulate};
use vellus_testing::{Uniform, effort};

/// A fibre from the usual ranges of fits, uniform in the variables of fits. Its medulla is free of air, as in fits.
fn random_fiber(rng: &mut Uniform, rgb: bool) -> Fiber {
    let mut fiber = Fiber::hair().with_exit(vellus::ScatterExit::Reflecting);
    for p in Forward::default().parameters(if rgb { 3 } else { 1 }) {
        let Kind::Fiber(parameter, channel) = p.kind else { continue };
        if parameter == Parameter::MedullaAir {
            continue;
        }
        let [low, high] = p.usual.map(|x| p.curve.variable(x));
        let x = p.curve.value(low + (high - low) * rng.next());
        let mut value = parameter.get(&fiber).unwrap();
        value[channel..].fill(if parameter.is_angle() { x.to_radians() } else { x } as f32);
        parameter.set(&mut fiber, value).unwrap();
    }
    fiber
}

/// A gantry that sees the highlights: θ_o in ±45°, 1 to 5 % of noise, gaps, an unknown scale.
fn random_gantry(rng: &mut Uniform, rgb: bool, seed: u64) -> Synthetic {
    let theta_o = (90.0 * rng.next() - 45.0).round();
    Synthetic {
        theta_o,
        theta: [-theta_o - 24.0, -theta_o + 24.0],
        step: [4.0, 4.0],
        noise: 0.01 + 0.04 * rng.next(),
        gaps: 0.2 * rng.next(),
        scale: 37.0,
        channels: if rgb { 3 } else { 1 },
        seed,
        ..Synthetic::default()
    }
}

/// The errors of determined parameters in standard errors, and how many intervals of all parameters contain the truth.
fn compare(result: &Fit, profile: &Profile, wanted: impl Fn(&str) -> bool) -> (Vec<(String, f64)>, [usize; 2]) {
    let (mut scores, mut covered) = (Vec::new(), [0, 0]);
    for e in result.estimates.iter().filter(|e| wanted(&e.name)) {
        let Some([low, high]) = e.interval else { continue };
        let truth = profile.simulated.iter().find(|(name, _)| *name == e.name).unwrap().1;
        covered[0] += usize::from((low..=high).contains(&truth));
        covered[1] += 1;
        if e.determined && e.state == State::Fitted {
            scores.push((e.name.clone(), (e.value - truth) / e.error.unwrap()));
        }
    }
    (scores, covered)
}

/// Reports the root mean square of errors in standard errors, and the shares beyond 2 and 3. Checks the coverage of
/// intervals, which is 90 to 98 %. The bounds have 3.29 standard errors more, for the numbers of one fit are correlated
/// in groups of about three. Returns the mean square.
fn check(what: &str, scores: &[(String, f64)], [inside, all]: [usize; 2]) -> f64 {
    let n = scores.len() as f64;
    let share = |bound: f64| scores.iter().filter(|(_, z)| z.abs() > bound).count() as f64 / n;
    let square = scores.iter().map(|(_, z)| z * z).sum::<f64>() / n;
    let covered = inside as f64 / all as f64;
    println!(
        "{what}: {n} parameters, rms {:.2}, beyond 2: {:.1} %, beyond 3: {:.2} %, covered {:.1} % of {all}",
        square.sqrt(),
        100.0 * share(2.0),
        100.0 * share(3.0),
        100.0 * covered
    );
    let slack = 3.29 * (3.0 * 0.95 * 0.05 / all as f64).sqrt();
    assert!((0.9 - slack..=0.98 + slack).contains(&covered), "{what}: {covered} of {all} intervals are right");
    square
}

/// Exact profiles of the model: the integral of the near field, which no fast far field equals.
#[test]
fn errors_and_intervals_are_right_for_random_fibers() {
    let (mut all, mut inside) = (Vec::new(), [0, 0]);
    for seed in 0..effort(6, 100) {
        let mut rng = Uniform(seed);
        let rgb = seed % 3 == 2;
        let fiber = random_fiber(&mut rng, rgb);
        let profile = simulate::from_model(Forward::default(), &fiber.into(), &random_gantry(&mut rng, rgb, seed));
        let profile = profile.unwrap();
        let options = Options { starts: 24, ..Options::default() };
        let result = fit(std::slice::from_ref(&profile), Forward::default(), &options, &()).unwrap();
        let (scores, covered) = compare(&result, &profile, |_| true);
        (0..2).for_each(|k| inside[k] += covered[k]);
        all.extend(scores.into_iter().map(|(name, z)| (format!("seed {seed}: {name}"), z)));
    }
    let square = check("model", &all, inside);
    // A root mean square of 0.8 to 1.2, and the same slack.
    let slack = 3.29 * (6.0 / all.len() as f64).sqrt();
    assert!((0.64 - slack..=1.44 + slack).contains(&square), "the mean square of {} errors is {square}", all.len());
}

/// Traced fibres with a rough cuticle. The cell of the detector is known. The widths of the highlights and the layers
/// are not compared, because facets do not widen the lobes as Table 2 of the paper says. For the same reason the fits
/// of most fibres determine nothing. The root mean square of the few determined errors is 2.3, so only intervals are
/// checked.
#[test]
#[ignore = "full: 160 million photons and 40 fits"]
fn errors_and_intervals_are_right_for_random_traced_fibers() {
    let (mut all, mut inside) = (Vec::new(), [0, 0]);
    for seed in 0..effort(4, 40) {
        let mut rng = Uniform(1000 + seed);
        let fiber = random_fiber(&mut rng, false);
        let gantry = Synthetic { step: [4.0, 5.0], noise: 0.02, gaps: 0.1, ..random_gantry(&mut rng, false, seed) };
        let profile = simulate::from_reference(&fiber, &gantry, 4_000_000, &()).unwrap();
        let options = Options { starts: 24, ..Options::default() };
        let result = fit(std::slice::from_ref(&profile), Forward::default(), &options, &()).unwrap();
        let modelled = |name: &str| ["kappa", "eta", "sigma_ca", "sigma_ms", "sigma_ma", "g"].contains(&name);
        let (scores, covered) = compare(&result, &profile, modelled);
        (0..2).for_each(|k| inside[k] += covered[k]);
        println!("{seed}: NRMSE {:.4} widened {:.2} {:?}", result.nrmse, result.widened, scores);
        all.extend(scores.into_iter().map(|(name, z)| (format!("seed {seed}: {name}"), z)));
    }
    check("traced", &all, inside);
}
