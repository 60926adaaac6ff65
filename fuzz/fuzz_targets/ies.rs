#![no_main]
//! IES profiles of lamps. The first byte says how the light uses the profile.

use vellus_usd::{Options, read};

const STAGE: &str = "#usda 1.0
def BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
    point3f[] points = [(0,0,0), (1,0,0)] float[] widths = [1, 1] }
def SphereLight \"l\" ( prepend apiSchemas = [\"ShapingAPI\"] ) { asset inputs:shaping:ies:file = @profile.ies@
    bool inputs:shaping:ies:normalize = NORMALIZE float inputs:shaping:ies:angleScale = SCALE }";

libfuzzer_sys::fuzz_target!(init: vellus_fuzz::init(), |bytes: &[u8]| {
    let Some((first, profile)) = bytes.split_first() else { return };
    vellus_fuzz::file("profile.ies", profile);
    let scale = f64::from(first >> 1) / 32.0 - 2.0;
    let stage = STAGE.replace("NORMALIZE", ["0", "1"][usize::from(first & 1)]).replace("SCALE", &scale.to_string());
    let reading = read(&vellus_fuzz::file("lamp.usda", stage.as_bytes()), &Options::default()).expect("a scene");
    assert_eq!(reading.scene.validate(), Ok(()));
});
