//! Fibres, colours, species, exits, lobes and windows survive a round trip, and invalid ones are refused.

use vellus::{Color, Fiber, FiberBuilder, Lobe, ScatterExit, Species, Window};

fn fiber(json: &str) -> Result<Fiber, String> {
    serde_json::from_str(json).map_err(|error| error.to_string())
}

#[test]
fn presets_round_trip_exactly_with_short_numbers() {
    for species in Species::ALL {
        let preset = Fiber::preset(species);
        assert_eq!(fiber(&format!("{{\"preset\": \"{species}-published\"}}")), Ok(Fiber::published(species)));
        let json = serde_json::to_string(&preset).unwrap();
        assert_eq!(fiber(&json), Ok(preset), "{json}");
        assert_eq!(toml::from_str(&toml::to_string(&preset).unwrap()), Ok(preset));
        assert_eq!(fiber(&format!("{{\"preset\": \"{species}\"}}")), Ok(preset));
    }
    let fox = serde_json::to_string(&Fiber::published(Species::RedFox).with_absorption([0.1, 0.2, 0.3])).unwrap();
    assert_eq!(
        fox,
        r#"{"kappa":0.86,"eta":1.49,"alpha":2.64,"beta_m":9.45,"beta_n":17.63,"sigma_ca":[0.1,0.2,0.3],"#.to_owned()
            + r#""sigma_ms":3.15,"sigma_ma":0.21,"g":0.79,"layers":0.68,"exit":"open"}"#
    );
}

/// Some angles in radians have no exact number of degrees in single precision. The nearest one differs by one unit in
/// the last place.
#[test]
fn angles_round_trip_within_one_unit_in_the_last_place() {
    for i in 0..10_000 {
        let given = Fiber { alpha: 0.7 * (i as f32 * 0.37).sin(), ..Fiber::hair() };
        let read: Fiber = fiber(&serde_json::to_string(&given).unwrap()).unwrap();
        assert!((read.alpha - given.alpha).abs() <= 1.2e-7 * given.alpha.abs(), "{given:?}");
        let again: Fiber = fiber(&serde_json::to_string(&read).unwrap()).unwrap();
        assert_eq!(again, read);
    }
}

#[test]
fn missing_parameters_come_from_the_preset() {
    let cat = Fiber::preset(Species::Cat);
    assert_eq!(fiber(r#"{"kappa": 0, "sigma_ma.g": 1, "preset": "cat"}"#), {
        Ok(Fiber { kappa: 0.0, sigma_ma: [cat.sigma_ma[0], 1.0, cat.sigma_ma[2]], ..cat })
    });
    let brown = Fiber::hair().with_color(Color::Melanin { eumelanin: 1.3, pheomelanin: 0.2 }).unwrap();
    assert_eq!(toml::from_str("eumelanin = 1.3\npheomelanin = 0.2"), Ok(brown));
    assert_eq!(fiber(r#"{"melanin": [1.3, 0.2]}"#), Ok(brown));
}

#[test]
fn bad_fibres_are_refused() {
    for (json, message) in [
        (r#"{"kappa": 1.0}"#, "kappa = 1 is out of range: it must be in [0, 0.99]"),
        (r#"{"beta_m": 91}"#, "beta_m = 91 is out of range: it must be in [0.1, 90] degrees"),
        (r#"{"sigma_ca": [0.1, -1, 0]}"#, "sigma_ca.g = -1 is out of range: it must be in [0, 1000] per fibre radius"),
        (r#"{"colour": 1}"#, "unknown parameter 'colour': known are kappa,"),
        (r#"{"kappa": [0.1, 0.2, 0.3]}"#, "kappa takes one number, not 3"),
        (r#"{"kappa": 0.1, "kappa": 0.2}"#, "kappa is given twice"),
        (r#"{"kappa": "wide"}"#, "kappa takes one number, not a word"),
        (r#"{"sigma_ca": 1, "eumelanin": 1}"#, "colour is given more than once, by sigma_ca and by melanin"),
        (r#"{"preset": "unicorn"}"#, "unknown preset 'unicorn'"),
        ("3", "expected a map of the parameters of a fibre"),
    ] {
        let error = fiber(json).unwrap_err();
        assert!(error.contains(message), "{json}: {error}");
    }
    // A builder checks ranges when it builds.
    let builder: FiberBuilder = serde_json::from_str(r#"{"kappa": 1.0}"#).unwrap();
    assert!(builder.build().is_err());
}

#[test]
fn colours_names_and_windows_round_trip() {
    for (color, json) in [
        (Color::Absorption([0.1, 0.2, 0.3]), r#"{"sigma_ca":[0.1,0.2,0.3]}"#),
        (Color::Reflectance([0.5; 3]), r#"{"reflectance":0.5}"#),
        (Color::Melanin { eumelanin: 1.3, pheomelanin: 0.2 }, r#"{"melanin":[1.3,0.2]}"#),
    ] {
        assert_eq!(serde_json::to_string(&color).unwrap(), json);
        assert_eq!(serde_json::from_str::<Color>(json).unwrap(), color);
    }
    for bad in [r#"{"reflectance": 2}"#, r#"{"kappa": 0.5}"#, "{}", r#"{"melanin": 1, "sigma_ca": 1}"#] {
        assert!(serde_json::from_str::<Color>(bad).is_err(), "{bad}");
    }
    assert_eq!(serde_json::to_string(&Species::RedFox).unwrap(), r#""red-fox""#);
    assert_eq!(serde_json::from_str::<Species>(r#""Red Fox""#).unwrap(), Species::RedFox);
    assert_eq!(
        serde_json::to_string(&(ScatterExit::Open, Lobe::ALL)).unwrap(),
        r#"["open",["R","TT","TRT","TTs","TRTs","rest"]]"#
    );
    assert_eq!(
        serde_json::from_str::<(ScatterExit, Lobe)>(r#"["reflecting", "TTs"]"#).unwrap(),
        (ScatterExit::Reflecting, Lobe::Tts)
    );
    let error = serde_json::from_str::<ScatterExit>(r#""closed""#).unwrap_err().to_string();
    assert!(error.contains("unknown exit 'closed': known are open, reflecting"), "{error}");
    for window in [Window::far(), Window::near(0.3), Window::range(-0.5, 0.25)] {
        assert_eq!(serde_json::from_str::<Window>(&serde_json::to_string(&window).unwrap()).unwrap(), window);
    }
    for bad in ["[0, 1.5]", "[0.5, 0.25]", "[0.5]"] {
        assert!(serde_json::from_str::<Window>(bad).is_err(), "{bad}");
    }
}
