//! Splines: values at the times of the shutter.

use super::said;
use crate::common::read_text;
use vellus_usd::Options;

/// Knots with two values, with each kind of piece, and with tangents that do not fit.
const KNOTS: &str = "1: 2; pre (0, 0); post curve (1, 0.5), 5: 4 & 6; pre (2, 1); post linear, 8: 3; post held,
    10: 1; post curve (2.9076293909079394, 2), 14: 5; pre (4.846075651513232, -3); post curve (0, 0),";

const HERMITE: &str = "1: 2; pre (0); post curve (0.5), 5: 4 & 6; pre (1); post linear, 8: 3; post held,
    10: 1; post curve (2), 14: 5; pre (-3); post curve (0),";

const TIMES: [f64; 13] = [-7.3, 0.5, 1.0, 1.3, 4.75, 5.0, 6.1, 8.0, 10.0, 11.3, 14.0, 14.5, 40.0];

const N: f64 = f64::NAN;

/// Values of usd-core 26.11; NaN if there is none.
const EXPECTED: [(&str, [f64; 13]); 13] = [
    ("bezier, K", [2., 2., 2., 2.123168, 3.757958, 6., 4.9, 3., 1., 11.292131, 5., 5., 5.]),
    ("hermite, H", [2., 2., 2., 2.139594, 3.765137, 6., 4.9, 3., 1., 4.033063, 5., 5., 5.]),
    ("bezier, loop: (5, 10, 2, 3, 0.5), K", [3., 5., 4.5, 4.2, 2.5, 6., 4.9, 3., 6.5, 5.2, 3.5, 3.5, 8.]),
    (
        "pre: linear, post: loop repeat, loop: (5, 10, 1, 1, 0.5), K",
        [3.5, 5., 4.5, 4.2, 2.5, 6., 4.9, 3., 6.5, 5.2, 3.5, 3.5, 9.5],
    ),
    ("pre: linear, 3: 1 & 7; pre (1, 2); post curve (1, -2),", [1., 1., 1., 1., 7., 7., 7., 7., 7., 7., 7., 7., 7.]),
    (
        "0: 0; post curve (9, 1), 4: 1; pre (9, -1),",
        [0., 0.529634, 1.139842, 1.569021, 1., 1., 1., 1., 1., 1., 1., 1., 1.],
    ),
    ("pre: linear, post: linear, K", [-2.15, 1.75, 2., 2.123168, 3.757958, 6., 4.9, 3., 1., 11.292131, 5., 3.5, -73.]),
    (
        "pre: loop oscillate, post: loop oscillate, K",
        [3., 2.181679, 2., 2.123168, 3.757958, 6., 4.9, 3., 1., 11.292131, 5., 6.493508, 5.],
    ),
    (
        "pre: loop repeat, post: loop repeat, K",
        [2.3, 3.493508, 2., 2.123168, 3.757958, 6., 4.9, 3., 1., 11.292131, 5., 5.181679, 11.],
    ),
    (
        "pre: loop reset, post: loop reset, K",
        [5.3, 6.493508, 2., 2.123168, 3.757958, 6., 4.9, 3., 1., 11.292131, 2., 2.181679, 2.],
    ),
    ("pre: none, post: none, K", [N, N, 2., 2.123168, 3.757958, 6., 4.9, 3., 1., 11.292131, N, N, N]),
    (
        "pre: sloped(0.25), post: sloped(-0.75), K",
        [-0.075, 1.875, 2., 2.123168, 3.757958, 6., 4.9, 3., 1., 11.292131, 5., 4.625, -14.5],
    ),
    ("1: 2; pre (0, 0); post none, 4: 3; post curve (0, 0),", [2., 2., N, N, 3., 3., 3., 3., 3., 3., 3., 3., 3.]),
];

const CURVE: &str = "uniform token type = \"linear\" int[] curveVertexCounts = [2] float[] widths = [1, 1]
    point3f[] points = [(0,0,0), (0,1,0)]";

/// The values that OpenUSD gives, to the digits of the table.
#[test]
fn splines_have_the_values_of_openusd() {
    let moved = |(i, (spline, _)): (usize, &(&str, [f64; 13]))| {
        let spline = spline.replace('K', KNOTS).replace('H', HERMITE);
        format!(
            "def BasisCurves \"c{i}\" {{ {CURVE} uniform token[] xformOpOrder = [\"xformOp:translateX\"]
            double xformOp:translateX.spline = {{ {spline} }} }}\n"
        )
    };
    let body: String = EXPECTED.iter().enumerate().map(moved).collect();
    for (k, time) in TIMES.into_iter().enumerate() {
        let (scene, warnings) = read_text(&body, &Options { frame: Some(time), ..Options::default() }).unwrap();
        assert_eq!(said(&warnings), "");
        for (strands, (spline, expected)) in scene.strands.iter().zip(&EXPECTED) {
            let found = f64::from(strands.points[0].x);
            // An operation without a value has no effect.
            let expected = if expected[k].is_nan() { 0.0 } else { expected[k] };
            assert!((found - expected).abs() < 2e-6, "{spline} at {time}: {found} instead of {expected}");
        }
    }
}

/// A spline moves a prim while the shutter is open, also in a layer with an offset. Time samples are stronger than a
/// spline in the same layer, and a spline is stronger than the default value.
#[test]
fn splines_are_read_at_the_times_of_the_shutter() {
    let folder = tempfile::tempdir().unwrap();
    let layer = |more: &str| {
        format!(
            "#usda 1.0\ndef BasisCurves \"c\" {{ {CURVE} uniform token[] xformOpOrder = [\"xformOp:translateX\"]
            double xformOp:translateX = 9\n {more}
            double xformOp:translateX.spline = {{ 0: 0; post linear, 10: 100 }} }}"
        )
    };
    let read = |more: &str| {
        std::fs::write(folder.path().join("part.usda"), layer(more)).unwrap();
        let stage = "#usda 1.0\ndef \"a\" ( references = @./part.usda@</c> (offset = 20; scale = 2) ) {}
            def Camera \"eye\" { double shutter:close = 1 }";
        let file = folder.path().join("stage.usda");
        std::fs::write(&file, stage).unwrap();
        let (scene, _) = crate::common::read(&file, &Options { frame: Some(24.0), ..Options::default() }).unwrap();
        let strands = &scene.strands[0];
        (strands.points[0].x, strands.moved.as_ref().map(|moved| moved[0].x))
    };
    assert_eq!(read(""), (20.0, Some(25.0)));
    assert_eq!(read("double xformOp:translateX.timeSamples = { 0: 1, 2: 7 }"), (7.0, None));
}

/// A kind of spline that is not known costs the value of its attribute.
#[test]
fn broken_splines_are_named() {
    let body = format!(
        "def BasisCurves \"c\" {{ {CURVE} }}\ndef Xform \"x\" {{ uniform token[] xformOpOrder = [\"xformOp:scale\"]
        double xformOp:scale.spline = {{ 0: 1; post sideways }} }}"
    );
    let (_, warnings) = read_text(&body, &Options::default()).unwrap();
    assert!(said(&warnings).contains("/x: its spline is not valid"), "{}", said(&warnings));
}
