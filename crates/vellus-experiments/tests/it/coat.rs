//! Requested colours against renderings of coats.

use vellus::{CoatColors, Color, Fiber, Species};
use vellus_experiments::coat::{Axis, Coat, Sheet, delta_e2000, random_color, random_fiber};

/// Fibres that the fit has not seen, each with a random colour within its reach. The whole list has 200 fibres:
/// `cargo run --release --bin coat_colors -- check FILE` in `lab/`.
#[test]
#[ignore = "test: 20 coats"]
fn coats_have_the_requested_colours() {
    let mut coat = Coat::new().unwrap();
    let mut sum = 0.0;
    for number in 0..20 {
        let fiber = random_fiber(200_000 + number);
        let colors = CoatColors::new(&fiber).unwrap();
        let in_reach = |seed: &[f32; 3]| colors.nearest(*seed).is_none();
        let color = (0..1000).map(|seed| random_color(1_000_000 + 1000 * number + seed)).find(in_reach).unwrap();
        let measured = coat.measure(&fiber.with_color(Color::Reflectance(color)).unwrap(), 16, 1).unwrap();
        let error = delta_e2000(color.map(f64::from), measured.color);
        assert!(error <= 8.0, "{error} for {color:?}: {measured:?}, {fiber:?}");
        sum += error;
    }
    assert!(sum / 20.0 <= 3.0, "{}", sum / 20.0);
}

/// The example of the documentation: the fox is orange. The inversion for hair makes it grey.
#[test]
fn a_fox_can_be_orange() {
    let orange = [0.8, 0.16, 0.03];
    let mut coat = Coat::new().unwrap();
    let fox = Fiber::preset(Species::RedFox);
    let mut error = |color| {
        let measured = coat.measure(&fox.with_color(color).unwrap(), 2, 1).unwrap();
        delta_e2000(orange.map(f64::from), measured.color)
    };
    assert!(error(Color::Reflectance(orange)) < 4.0);
    assert!(error(Color::HairReflectance(orange)) > 20.0);
}

#[test]
fn a_sheet_has_a_picture_for_each_pair_of_values() {
    let axis = |text: &str| text.parse::<Axis>().unwrap();
    let sheet = Sheet {
        fiber: None,
        set: vec!["eta=1.5".to_owned()],
        rows: axis("fiber=cat/dog"),
        columns: axis("reflectance=0.5/0.6,0.3,0.001/0.1"),
        size: 3,
        samples: 1,
        output: "sheet.png".into(),
    };
    let mut warnings = Vec::new();
    let contact = sheet.render(&(), |warning| warnings.push(warning.to_owned())).unwrap();
    assert_eq!((contact.labels[0].len(), contact.labels[1].len(), contact.pictures.len()), (2, 3, 6));
    assert!(contact.pictures.iter().all(|picture| picture.len() == 9));
    assert!(warnings.iter().all(|w| w.contains("reflectance=0.6,0.3,0.001: no pigment")), "{warnings:?}");
    for bad in ["kappa", "kappa=", "kappa=0.1//0.2"] {
        assert!(bad.parse::<Axis>().unwrap_err().contains("kappa=0.2/0.5/0.8"), "{bad}");
    }
    let wrong = Sheet { columns: axis("kappa=2"), ..sheet.clone() };
    assert!(format!("{:#}", wrong.render(&(), |_| ()).unwrap_err()).contains("kappa = 2 is out of range"));
    assert!(Sheet { size: 0, ..sheet }.render(&(), |_| ()).unwrap_err().to_string().contains("[1, 1024]"));
}
