//! The colours of coats: the inversion, its reach, and its extremes. `vellus-experiments/tests/it/coat.rs` compares it
//! with renderings.

use vellus::{CoatColors, Color, Fiber, FiberBuilder, ScatterExit, Species};
use vellus_testing::Uniform;

fn fibers() -> impl Iterator<Item = Fiber> {
    let mut random = Uniform(7);
    let any = std::iter::repeat_with(move || random.fiber()).take(100);
    let exits = |fiber: Fiber| [ScatterExit::Open, ScatterExit::Reflecting].map(|exit| fiber.with_exit(exit));
    any.chain(Species::ALL.map(Fiber::preset)).chain([Fiber::hair()]).flat_map(exits)
}

#[test]
fn more_pigment_is_darker_and_the_conversions_are_inverse() {
    for fiber in fibers() {
        let colors = CoatColors::new(&fiber).unwrap();
        let [low, high] = colors.range();
        assert!((0.0..0.5).contains(&low) && high == 1.0, "{low} {high} {fiber:?}");
        let mut last = [1.0, 0.0];
        for i in 0..=1000 {
            let color = 1.0 - i as f32 / 1000.0;
            let sigma = colors.absorption(color);
            assert!(sigma >= last[1] && sigma <= 1000.0, "{color}: {sigma} after {last:?}, {fiber:?}");
            let back = colors.color(sigma);
            assert!((back - color.max(low)).abs() < 2e-3, "{color} gives {back}, {fiber:?}");
            last = [color, sigma];
        }
    }
}

/// The table agrees with the colour of the fibre itself.
#[test]
fn a_request_gives_a_fibre_with_that_colour() {
    let request = [0.7, 0.3, 0.08];
    for fiber in fibers() {
        let colors = CoatColors::new(&fiber).unwrap();
        let expected = colors.nearest(request).unwrap_or(request);
        let found = fiber.with_color(Color::Reflectance(request)).unwrap().coat_color().unwrap();
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 0.01, "{found} {expected} {fiber:?}");
        }
    }
}

/// Orange is within the reach of all presets, and both parts of the fibre get pigment.
#[test]
fn every_preset_can_be_orange() {
    let orange = [0.8, 0.16, 0.03];
    for fiber in Species::ALL.into_iter().flat_map(|s| [Fiber::preset(s), Fiber::published(s)]) {
        let reach = CoatColors::new(&fiber).unwrap();
        assert_eq!(reach.nearest(orange), None, "{:?} {fiber:?}", reach.range());
        let dyed = fiber.with_color(Color::Reflectance(orange)).unwrap();
        assert!(dyed.sigma_ca[2] > dyed.sigma_ca[0] && dyed.sigma_ma[2] > dyed.sigma_ma[0]);
        let cortex = Fiber { medulla_pigment: 0.0, ..fiber }.with_color(Color::Reflectance(orange)).unwrap();
        assert!(cortex.sigma_ma == [0.0; 3] && cortex.sigma_ca[2] >= dyed.sigma_ca[2]);
    }
}

#[test]
fn a_colour_out_of_reach_gives_the_nearest_and_a_message() {
    let mut builder = FiberBuilder::new(Fiber { layers: 4.0, ..Fiber::hair() });
    builder.set("reflectance", &[0.5, 0.2, 0.001]).unwrap();
    let reach = builder.out_of_reach().unwrap().unwrap();
    let [_, low] = [reach.requested[2], reach.nearest[2]];
    assert!(low > 0.005 && reach.nearest[..2] == [0.5, 0.2], "{reach:?}");
    assert!(reach.to_string().contains("0.5, 0.2, 0.001: the nearest is 0.5, 0.2, 0.0"), "{reach}");
    assert!((builder.build().unwrap().coat_color().unwrap()[2] - low).abs() < 1e-3);
    builder.set("reflectance", &[0.5]).unwrap();
    assert_eq!(builder.out_of_reach().unwrap(), None);
}

#[test]
fn extreme_fibres_have_finite_tables() {
    for eta in [1.0, 3.0] {
        for kappa in [0.0, 0.99] {
            for (layers, sigma_ms, g) in [(0.0, 0.0, 0.0), (20.0, 1000.0, 0.95), (0.5, 1000.0, 0.0)] {
                for beta in [0.1f32, 90.0] {
                    let beta = beta.to_radians();
                    let fiber = Fiber { eta, kappa, layers, sigma_ms, g, beta_m: beta, beta_n: beta, ..Fiber::hair() };
                    let colors = CoatColors::new(&fiber).unwrap();
                    for color in [f32::NAN, -1.0, 0.0, 0.3, 1.0, 2.0] {
                        assert!((0.0..=1000.0).contains(&colors.absorption(color)), "{color} {fiber:?}");
                    }
                    assert!(fiber.coat_color().unwrap().iter().all(|c| (0.0..=1.0).contains(c)), "{fiber:?}");
                }
            }
        }
    }
}
