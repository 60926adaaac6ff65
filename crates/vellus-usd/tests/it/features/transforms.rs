//! Transforms of prims: order, pivots, resets and scales that are not uniform.

use super::{FOUR, said, scene};

#[test]
fn transforms_multiply_down_to_the_points_and_widths() {
    let (scene, warnings) = scene(&format!(
        "def Xform \"a\" {{
    double3 xformOp:translate = (10, 0, 0)
    float xformOp:rotateZ = 90
    float3 xformOp:scale = (2, 2, 2)
    uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateZ\", \"xformOp:scale\"]
    def BasisCurves \"b\" {{
        {FOUR}
        uniform token type = \"linear\"
        double3 xformOp:translate:pivot = (0, 5, 0)
        quatf xformOp:orient = (0.70710678, 0, 0, 0.70710678)
        uniform token[] xformOpOrder = [\"xformOp:translate:pivot\", \"xformOp:orient\", \"!invert!xformOp:translate:pivot\"]
    }}
    def BasisCurves \"c\" {{
        {FOUR}
        uniform token type = \"linear\"
        matrix4d xformOp:transform = ((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,7,1))
        uniform token[] xformOpOrder = [\"!resetXformStack!\", \"xformOp:transform\"]
    }}
}}"
    ));
    assert_eq!(said(&warnings), "");
    let ends = |i: usize| (scene.strands[i].points[0], scene.strands[i].points[3]);
    // The inner rotation about (0,5,0) moves (0,0,0) to (5,5,0). The outer transform scales it to (10,10,0), rotates it
    // to (−10,10,0) and moves it to (0,10,0).
    let (root, tip) = ends(0);
    assert!(
        root.abs_diff_eq(glam::vec4(0.0, 10.0, 0.0, 0.2), 1e-5)
            && tip.abs_diff_eq(glam::vec4(-6.0, 10.0, 0.0, 0.2), 1e-5)
    );
    assert_eq!(ends(1), (glam::vec4(0.0, 0.0, 7.0, 0.1), glam::vec4(3.0, 0.0, 7.0, 0.1)));
}

#[test]
fn stretched_strands_get_the_mean_scale_and_a_warning() {
    let (scene, warnings) = scene(&format!(
        "def BasisCurves \"b\" {{
    {FOUR}
    uniform token basis = \"bspline\"
    float3 xformOp:scale = (1, 2, 4)
    uniform token[] xformOpOrder = [\"xformOp:scale\"]
}}"
    ));
    assert!((scene.strands[0].points[0].w - 0.2).abs() < 1e-6);
    assert!(said(&warnings).contains("/b: its scale is not uniform"));
}

#[test]
fn a_multiple_of_a_matrix_is_the_same_transform() {
    let at = |matrix: &str| {
        let order = "uniform token[] xformOpOrder = [\"xformOp:transform\"]";
        scene(&format!("def BasisCurves \"c\" {{ {FOUR} matrix4d xformOp:transform = {matrix} {order} }}"))
    };
    let (one, _) = at("((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,7,1))");
    let (two, warnings) = at("((2,0,0,0), (0,2,0,0), (0,0,2,0), (0,0,14,2))");
    assert_eq!((two.strands[0].points.clone(), said(&warnings)), (one.strands[0].points.clone(), String::new()));
}
