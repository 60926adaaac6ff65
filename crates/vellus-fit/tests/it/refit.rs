//! The presets for the reflecting exit.

use vellus::{Bcsdf, Fiber, Parameter, ScatterExit, Species};
use vellus_fit::refit;
use vellus_models::energies;

fn albedo(fiber: &Fiber, theta: f64) -> f64 {
    let model = Bcsdf::new(fiber).unwrap();
    energies(&model, theta, None).iter().map(|lobe| lobe[0]).sum()
}

#[test]
fn fitted_presets_scatter_as_much_light_as_the_published_ones() {
    for species in Species::ALL {
        let [published, fitted] = [Fiber::published(species), Fiber::preset(species)];
        for theta in [0.0, 30.0, 60.0] {
            let ratio = albedo(&fitted, theta) / albedo(&published, theta);
            assert!((ratio - 1.0).abs() < 0.1, "{species}, {theta} degrees: {ratio}");
        }
        for parameter in [Parameter::Eta, Parameter::Alpha, Parameter::BetaM, Parameter::BetaN, Parameter::Layers] {
            assert_eq!(parameter.get(&fitted), parameter.get(&published), "{species}");
        }
    }
}

#[test]
#[ignore = "full: ten fits of 2000 directions, which change only when the model does"]
fn fitted_presets_are_what_the_procedure_gives() {
    for species in Species::ALL {
        let result = refit(&Fiber::published(species), ScatterExit::Reflecting, &()).unwrap();
        let [found, table] = [result.fiber, Fiber::preset(species)];
        for (name, found, table) in [
            ("kappa", found.kappa, table.kappa),
            ("sigma_ca", found.sigma_ca[0], table.sigma_ca[0]),
            ("sigma_ms", found.sigma_ms, table.sigma_ms),
            ("sigma_ma", found.sigma_ma[0], table.sigma_ma[0]),
            ("g", found.g, table.g),
        ] {
            assert!((found - table).abs() < 0.005 + 0.01 * table, "{species}: {name} = {found}, not {table}");
        }
        assert!(result.nrmse < 0.04, "{species}: {}", result.nrmse);
    }
}
