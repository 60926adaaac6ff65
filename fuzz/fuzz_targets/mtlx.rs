#![no_main]
//! MaterialX documents: as a fibre, and as the materials of a stage.

use std::path::Path;

/// The materials of all curves and meshes.
const STAGE: &str = r#"#usda 1.0
def "MaterialX" ( references = @fuzz.mtlx@</MaterialX> ) {}
def BasisCurves "hair" { rel material:binding = </MaterialX/Materials/fur> int[] curveVertexCounts = [4]
    point3f[] points = [(0,0,0), (1,0,0), (2,0,0), (3,1,0)] }
def Cube "skin" { rel material:binding = </MaterialX/Materials/skin> }"#;

libfuzzer_sys::fuzz_target!(init: vellus_fuzz::init(), |bytes: &[u8]| {
    let document = vellus_fuzz::file("fuzz.mtlx", bytes);
    for name in [None, Some("fur")] {
        let _ = vellus_usd::read_material(Path::new(&document), name, &vellus_usd::Options::default().network_base);
    }
    vellus_fuzz::stage("stage.usda", STAGE.as_bytes());
});
