//! Answers have the values of the library, and nonsense gets a message.

use serde_json::{Value, json};
use vellus::{Bcsdf, Color, Fiber, Lobe, Parameter, Species, Window, direction};
use vellus_testing::vectors::{Vector, Vectors};
use vellus_views::{FILES, answer};

fn ask(request: &Value) -> Value {
    serde_json::from_str(&answer(&request.to_string())).unwrap()
}

fn error(request: &str) -> String {
    let answer: Value = serde_json::from_str(&answer(request)).unwrap();
    answer["error"].as_str().unwrap_or_else(|| panic!("{request}: no error")).to_owned()
}

fn numbers(value: &Value) -> Vec<f32> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap() as f32).collect()
}

#[test]
fn the_table_has_all_parameters_and_presets() {
    let table = ask(&json!({"ask": "parameters"}));
    let keys: Vec<_> = table["parameters"].as_array().unwrap().iter().map(|row| row["key"].as_str().unwrap()).collect();
    assert_eq!(keys, Parameter::ALL.map(Parameter::name));
    for row in table["parameters"].as_array().unwrap() {
        assert_ne!(row["label"], row["key"], "a parameter has no label");
        assert!(row["range"][0].as_f64() < row["range"][1].as_f64());
    }
    for (preset, species) in table["presets"].as_array().unwrap().iter().zip(Species::ALL) {
        assert_eq!(preset["key"], species.name());
        let fiber: Fiber = serde_json::from_value(preset["fiber"].clone()).unwrap();
        assert_eq!(fiber, Fiber::preset(species));
        for parameter in Parameter::ALL.into_iter().filter(|parameter| parameter.get(&fiber).is_some()) {
            assert!(!preset["fiber"][parameter.name()].is_null(), "{parameter} is left out");
        }
    }
}

#[test]
fn colours_are_those_of_the_library() {
    let fox = Fiber::preset(Species::RedFox);
    // A page sends back what it got: the reflectance, and the absorption that it gives.
    let fiber = |answer: &Value| vellus_views::builder(&answer["fiber"]).unwrap().build().unwrap();
    let melanin = ask(&json!({"ask": "color", "fiber": {"preset": "red-fox"}, "melanin": [1.5, 0.25]}));
    assert_eq!(fiber(&melanin), fox.with_color(Color::Melanin { eumelanin: 1.5, pheomelanin: 0.25 }).unwrap());
    let orange = ask(&json!({"ask": "color", "fiber": {"preset": "red-fox"}, "reflectance": [0.5, 0.25, 0.125]}));
    let expected = fox.with_color(Color::Reflectance([0.5, 0.25, 0.125])).unwrap();
    assert_eq!(fiber(&orange), expected);
    assert_eq!(numbers(&orange["coat"]), expected.coat_color().unwrap());
    assert!(orange["note"].is_null());
    let white = ask(&json!({"ask": "color", "fiber": {"preset": "red-fox"}, "reflectance": [0.001, 0.5, 0.5]}));
    assert!(white["note"].as_str().unwrap().contains("the nearest is"));
}

#[test]
fn values_are_the_golden_vectors() {
    let Vectors { fibers, queries } = Vectors::read();
    let mut worst = 0.0f32;
    for (i, fiber) in fibers.iter().enumerate() {
        let own: Vec<_> = queries.iter().filter(|query| query.fiber == i).collect();
        let row = |q: &&Vector| [&q.window[..], &q.wo.to_array(), &q.wi.to_array()].concat();
        let rows: Vec<_> = own.iter().map(row).collect();
        let answer = ask(&json!({"ask": "values", "fiber": fiber, "queries": rows}));
        for (query, value) in own.iter().zip(answer["values"].as_array().unwrap()) {
            worst = worst.max(query.error(numbers(value).try_into().unwrap()));
        }
        assert!(numbers(&answer["pdf"]).iter().all(|pdf| *pdf >= 0.0));
    }
    println!("largest error {worst:.2} tolerances");
    assert!(worst <= 1.0, "{worst}");
    let bad = |row: [f32; 8]| {
        let answer = ask(&json!({"ask": "values", "fiber": {}, "queries": [row]}));
        answer["error"].as_str().unwrap_or_default().to_owned()
    };
    assert!(bad([0.5, 0.1, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]).contains("queries[0]: the window [0.5, 0.1]"));
    assert!(bad([0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 0.0]).contains("wo has the length 2"));
}

#[test]
fn lobes_and_energies_are_those_of_the_library() {
    let bcsdf = Bcsdf::new(&Fiber::preset(Species::Human)).unwrap();
    let wo = direction(20f64.to_radians(), 0.0);
    let hit = bcsdf.at(wo, Window::near(0.25));
    let request = |ask: &str| json!({"ask": ask, "fiber": {"preset": "human"}, "theta": 20, "h": 0.25, "samples": 90});

    let polar = ask(&request("polar"));
    for lobe in Lobe::ALL {
        let values = &polar["lobes"][lobe as usize];
        assert_eq!(numbers(&values[10]), hit.azimuthal(40f32.to_radians()).0[lobe as usize]);
    }

    let energy = ask(&json!({"ask": "energy", "fiber": {"preset": "human"}, "theta": 20, "samples": 9}));
    let far = bcsdf.at(wo, Window::far()).energy();
    assert_eq!(energy["h"][5], 0.25);
    for lobe in Lobe::ALL {
        assert_eq!(numbers(&energy["lobes"][lobe as usize][5]), hit.energy().0[lobe as usize]);
        assert_eq!(numbers(&energy["mean"][lobe as usize]), far.0[lobe as usize]);
    }
    let total = numbers(&energy["total"]);
    assert_eq!(total, far.total());
    assert!(total.iter().all(|x| (0.0..=1.0).contains(x)));

    let profile = ask(&json!({
        "ask": "profile", "fiber": {"preset": "human"}, "theta": 20, "window": [-0.5, 0.5], "rows": 6, "columns": 12
    }));
    let window = bcsdf.at(wo, Window::range(-0.5, 0.5));
    let wi = direction(15f64.to_radians(), 75f64.to_radians());
    assert_eq!(numbers(&profile["values"][3 * 12 + 2]), window.eval(wi).total());
}

/// The sums of N(φ) and of the lobes along the fibre are the energies.
#[test]
fn integrals_of_the_lobes_are_their_energies() {
    for species in ["human", "red-fox", "cat"] {
        let fiber: Fiber = Fiber::named(species).unwrap();
        let wo = direction(0.3, 0.0);
        let energy = Bcsdf::new(&fiber).unwrap().at(wo, Window::near(0.4)).energy();
        for (name, width) in [("polar", std::f64::consts::TAU), ("longitudinal", std::f64::consts::PI)] {
            let samples = 720;
            let theta = 0.3f64.to_degrees();
            let answer =
                ask(&json!({"ask": name, "fiber": {"preset": species}, "theta": theta, "h": 0.4, "samples": samples}));
            for lobe in Lobe::ALL {
                let values = answer["lobes"][lobe as usize].as_array().unwrap();
                let sum: f64 = values.iter().map(|rgb| rgb[1].as_f64().unwrap()).sum();
                let [integral, expected] = [sum * width / f64::from(samples), f64::from(energy.0[lobe as usize][1])];
                // The tables of the medulla have 0.5° cells: their forward peak is summed within 1 %.
                let tolerance = 0.01 * expected + 1e-4;
                assert!((integral - expected).abs() < tolerance, "{species} {name} {lobe:?}: {integral} {expected}");
            }
        }
    }
}

#[test]
fn sections_have_the_energies_of_the_rays() {
    let request = json!({"ask": "section", "fiber": {"preset": "rabbit"}, "theta": 10, "h": -0.5, "paths": 12});
    let section = ask(&request);
    let bcsdf = Bcsdf::new(&Fiber::preset(Species::Rabbit)).unwrap();
    let energy = bcsdf.at(direction(10f64.to_radians(), 0.0), Window::near(-0.5)).energy();
    for (ray, lobe) in section["rays"].as_array().unwrap().iter().zip([Lobe::R, Lobe::Tt, Lobe::Trt]) {
        assert_eq!(ray["lobe"], lobe.key());
        assert_eq!(numbers(&ray["weight"]), energy.0[lobe as usize]);
    }
    assert!(section["scattered"].as_array().unwrap().len() > 8);
    assert_eq!(section, ask(&request), "the same seed gives the same paths");
}

#[test]
fn errors_name_the_field_and_its_range() {
    for (request, expected) in [
        ("", "no JSON"),
        ("[1]", "an object"),
        ("{}", "ask is missing"),
        (r#"{"ask": "colour"}"#, "known are parameters, check"),
        (r#"{"ask": "check", "fiber": {"kappa": 2}}"#, "kappa = 2 is out of range: it must be in [0, 0.99]"),
        (r#"{"ask": "check", "fiber": {"size": 2}}"#, "unknown parameter 'size'"),
        (r#"{"ask": "check", "fiber": 3}"#, "fiber"),
        (r#"{"ask": "color", "fiber": {}}"#, "give one of melanin, reflectance, hair_reflectance"),
        (r#"{"ask": "color", "melanin": "brown"}"#, "melanin"),
        (r#"{"ask": "polar", "theta": 90}"#, "theta = 90: it must be a number in [-89, 89]"),
        (r#"{"ask": "polar", "h": 1.5}"#, "h = 1.5"),
        (r#"{"ask": "polar", "h": 0, "window": [0, 1]}"#, "not both"),
        (r#"{"ask": "polar", "window": [1, 0]}"#, "window"),
        (r#"{"ask": "polar", "samples": 1e9}"#, "samples"),
        (r#"{"ask": "energy", "samples": 2.5}"#, "whole number"),
        (r#"{"ask": "profile", "rows": -1}"#, "rows"),
    ] {
        let found = error(request);
        assert!(found.contains(expected), "{request}: {found}");
    }
}

/// SplitMix64.
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Requests with extreme values, and damaged requests: each answer is JSON with finite numbers.
#[test]
fn nonsense_never_panics() {
    let asks = ["parameters", "check", "color", "section", "polar", "longitudinal", "profile", "energy"];
    let values =
        ["0", "1", "-1", "1e-30", "1e30", "89", "-89", "0.99", "1000", "0.1", "[0,1]", "[1,1,1]", "null", "\"\""];
    let fields = ["theta", "h", "window", "samples", "rows", "columns", "paths", "seed", "melanin", "reflectance"];
    let mut state = 1;
    for _ in 0..600 {
        let mut pick = |list: &[&'static str]| list[random(&mut state) as usize % list.len()];
        let mut request = format!(r#"{{"ask": "{}", "samples": 16, "rows": 6, "columns": 6"#, pick(&asks));
        for _ in 0..2 {
            request += &format!(r#", "{}": {}"#, pick(&fields), pick(&values));
        }
        request += r#", "fiber": {"beta_n": 10"#;
        for _ in 0..3 {
            request += &format!(r#", "{}": {}"#, pick(&Parameter::ALL.map(Parameter::name)), pick(&values));
        }
        request += "}}";
        if random(&mut state).is_multiple_of(4) {
            let at = random(&mut state) as usize % request.len();
            if request.is_char_boundary(at) {
                request.truncate(at);
            }
        }
        let answer = answer(&request);
        assert!(serde_json::from_str::<Value>(&answer).is_ok(), "{request}");
        // serde_json writes null for a number that is not finite. These two fields may be null.
        let plain = answer.replace("\"note\":null", "").replace("\"default\":null", "");
        assert!(plain.starts_with("{\"error\"") || !plain.contains("null"), "{request}: {plain}");
    }
}

#[test]
fn the_web_modules_are_small_and_load_nothing_from_elsewhere() {
    let size: usize = FILES.iter().map(|(_, text)| text.len()).sum();
    assert!(size < 80_000, "{size} bytes");
    for (name, text) in FILES {
        for line in text.lines().filter(|line| line.contains("http")) {
            assert!(line.contains("http://www.w3.org/2000/svg"), "{name}: {line}");
        }
    }
}
