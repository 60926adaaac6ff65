//! Values on curves: roots, and parameters of the fibre.

use super::{said, scene};
use crate::common::read_text;
use glam::Vec2;
use vellus::Fiber;
use vellus_scene::{Parameter, Values};
use vellus_usd::Options;

#[test]
fn roots_and_parameters_come_from_primvars() {
    let (scene, warnings) = scene(
        "def Xform \"a\" {
    float primvars:vellus:g = 0.5 (interpolation = \"constant\")
    def BasisCurves \"b\" {
        uniform token type = \"linear\"
        int[] curveVertexCounts = [2, 2]
        point3f[] points = [(0,0,0), (1,0,0), (0,1,0), (1,1,0)]
        float[] widths = [1, 1, 1, 1]
        texCoord2f[] primvars:uv = [(0.1, 0.2), (0, 0), (0.3, 0.4), (0, 0)] (interpolation = \"vertex\")
        float[] primvars:vellus:beta_m = [90, 45] (interpolation = \"uniform\")
        color3f[] primvars:vellus:sigma_ca = [(1, 2, 3), (4, 5, 6), (7, 8, 9), (1, 1, 1)] (interpolation = \"vertex\")
        float2[] primvars:vellus:melanin = [(1, 2)]
    }
}",
    );
    assert_eq!(said(&warnings), "");
    let strands = &scene.strands[0];
    assert_eq!(strands.root_uv, Some(vec![Vec2::new(0.1, 0.2), Vec2::new(0.3, 0.4)]));
    let right = std::f32::consts::FRAC_PI_2;
    assert_eq!(
        strands.varying,
        [
            (Parameter::BetaM, Values::PerStrand(vec![[right; 3], [0.5 * right; 3]])),
            (Parameter::SigmaCa, Values::PerPoint(vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0], [1.0; 3]])),
            (Parameter::G, Values::Constant([0.5; 3])),
            (Parameter::Melanin, Values::Constant([1.0, 2.0, 0.0])),
        ]
    );
    assert_eq!(scene.looks[0].fiber, Fiber::hair());
}

/// There is one warning for each primvar and material. It has the value, the range and the result.
#[test]
fn primvars_outside_their_range_and_unknown_ones_warn() {
    let curves = |name: &str, more: &str| {
        format!(
            "def BasisCurves \"{name}\" {{ uniform token type = \"linear\" int[] curveVertexCounts = [2]
            point3f[] points = [(0,0,0), (1,0,0)] float[] widths = [1, 1] {more} }}\n"
        )
    };
    let both =
        "float[] primvars:vellus:kappa = [5] float[] primvars:vellus:alpha = [45] float primvars:vellus:fluff = 1
        color3f[] primvars:vellus:sigma_ca = [(0, 1, -1)]";
    let body = [curves("a", both), curves("b", both)].concat();
    let (scene, warnings) = read_text(&body, &Options::default()).unwrap();
    let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert_eq!(said.len(), 3, "{said:?}");
    assert!(
        said[0].starts_with("/a: primvars:vellus:kappa[0] is 5: the range is [0, 0.99], so it is clamped to 0.99"),
        "{said:?}"
    );
    assert!(said[1].starts_with("/a: primvars:vellus:sigma_ca[0] is -1: the range is [0, 1000]"), "{said:?}");
    assert_eq!(said[2], "/a, /b: primvars:vellus:fluff is not a parameter of VellusFur and is ignored");
    assert_eq!(scene.strands.len(), 2);
}
