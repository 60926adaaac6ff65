//! Small inputs of every kind, made here or by the command.

use crate::trial::Stop;
use anyhow::Context;
use std::io::Cursor;
use std::path::Path;
use vellus::Tables;

/// Strands that lean further in each frame, a skin, lights, a camera, two kinds of shaders, and primvars.
pub const LEANING: &str = r#"#usda 1.0
(
    startTimeCode = 1
    endTimeCode = 4
    metersPerUnit = 0.01
    upAxis = "Y"
)
def Xform "world" {
    double3 xformOp:translate = (0, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def BasisCurves "fur" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    ) {
        uniform token type = "linear"
        int[] curveVertexCounts = [2, 3]
        float[] widths = [0.2] ( interpolation = "constant" )
        point3f[] points.timeSamples = {
            1: [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (1, 1.5, 0.2)],
            4: [(0, 0, 0), (1, 1, 0), (1, 0, 0), (2, 1, 0), (2, 1.5, 0.2)],
        }
        texCoord2f[] primvars:st = [(0.1, 0.2), (0.8, 0.4)] ( interpolation = "uniform" )
        float[] primvars:vellus:kappa = [0.5, 0.7] ( interpolation = "uniform" )
        rel material:binding = </world/coat>
    }
    def BasisCurves "whiskers" {
        uniform token type = "cubic"
        uniform token basis = "bspline"
        uniform token wrap = "nonperiodic"
        int[] curveVertexCounts = [4]
        float[] widths = [0.1, 0.08, 0.05, 0.01] ( interpolation = "vertex" )
        point3f[] points = [(0.5, 0, 0), (0.6, 0.5, 0), (0.7, 1, 0), (0.5, 1.5, 0)]
        vector3f[] velocities = [(0, 0, 0), (1, 0, 0), (1, 0, 0), (2, 0, 0)]
    }
    def Mesh "skin" {
        int[] faceVertexCounts = [4, 3]
        int[] faceVertexIndices = [0, 1, 2, 3, 0, 1, 4]
        point3f[] points = [(-1, 0, -1), (2, 0, -1), (2, 0, 1), (-1, 0, 1), (0, -1, 0)]
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0), (1, 0), (0, 1)] (
            interpolation = "faceVarying"
        )
    }
    def Material "coat" {
        token outputs:surface.connect = </world/coat/shader.outputs:out>
        def Shader "shader" {
            uniform token info:id = "VellusFur"
            token inputs:preset = "cat"
            float inputs:beta_m = 9
            color3f inputs:reflectance = (0.6, 0.4, 0.3)
            token outputs:out
        }
    }
    def SphereLight "lamp" {
        float inputs:intensity = 40
        float inputs:radius = 0.5
        double3 xformOp:translate = (3, 4, 5)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
def DomeLight "sky" {
    float inputs:intensity = 0.5
}
def Camera "camera" {
    float focalLength = 35
    double3 xformOp:translate = (1, 0.5, 6)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"#;

/// One set of straight strands, which a .hair file can hold.
pub const STRAIGHT: &str = r#"#usda 1.0
def BasisCurves "fur" {
    uniform token type = "linear"
    int[] curveVertexCounts = [2, 3]
    float[] widths = [0.2] ( interpolation = "constant" )
    point3f[] points = [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (1, 1.5, 0.2)]
}
"#;

/// [`LEANING`] with an image as sky.
pub fn lit_by(image: &str) -> String {
    let dome = format!("float inputs:intensity = 0.5\n    asset inputs:texture:file = @{image}@");
    LEANING.replacen("float inputs:intensity = 0.5", &dome, 1)
}

/// A document of MaterialX, and a stage with the networks of other programs.
pub const MATERIALX: &str = include_str!("../../vellus-usd/tests/data/hair.mtlx");
pub const NETWORKS: &str = include_str!("../../vellus-usd/tests/data/programs.usda");

/// Native instances, and a PointInstancer with two prototypes.
pub const HERD: &str = r#"#usda 1.0
class "cat" {
    def BasisCurves "fur" {
        uniform token type = "linear"
        int[] curveVertexCounts = [2]
        float[] widths = [0.2] ( interpolation = "constant" )
        point3f[] points = [(0, 0, 0), (0, 1, 0)]
    }
    def Mesh "skin" {
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    }
}
def Xform "one" ( instanceable = true inherits = </cat> ) {
    double3 xformOp:translate = (5, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def "two" ( instanceable = true inherits = </cat> ) {
}
def PointInstancer "herd" {
    rel prototypes = [</herd/cat>, </two>]
    int[] protoIndices = [0, 1, 0]
    point3f[] positions = [(0, 0, 2), (1, 2, 3), (4, 0, 0)]
    quath[] orientations = [(1, 0, 0, 0), (0.7, 0, 0.7, 0), (1, 0, 0, 0)]
    float3[] scales = [(1, 1, 1), (3, 3, 3), (1, 1, 2)]
    int64[] ids = [7, 8, 9]
    int64[] invisibleIds = [9]
    def "cat" ( inherits = </cat> ) {
        float3 xformOp:scale = (2, 2, 2)
        uniform token[] xformOpOrder = ["xformOp:scale"]
    }
}
"#;

/// The leaning strands, bound to the material Plain of a document.
pub fn bound_to(document: &str) -> String {
    let strands = LEANING.replacen("</world/coat>", "</plain>", 1);
    format!("{strands}\ndef \"plain\" ( references = @{document}@</MaterialX/Materials/Plain> ) {{ }}\n")
}

/// A tetrahedron with uv and normals.
pub const MESH: &str = "o body
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
vt 0 0
vt 1 0
vt 0 1
vn 0 0 1
f 1/1/1 3/3/1 2/2/1
f 1/1 2/2 4/3
f 1//1 4//1 3//1
f 2 3 4
";

/// Groups for `vellus groom grow --settings`.
pub const SETTINGS: &str = r#"[[group]]
name = "undercoat"
density = 40
length = 0.3
clump = 4

[[group]]
name = "guard"
density = 10
length = 0.5
width = 0.012
curl = 0.1
comb = [0.0, -1.0, 0.0]
fiber = "raccoon"
"#;

/// A fibre file.
pub const FIBER_TOML: &str =
    "preset = \"cat\"\nkappa = 0.6\neta = 1.5\nbeta_m = 9.0\nsigma_ca = [0.1, 0.2, 0.4]\ng = 0.3\n";

/// The same as JSON.
pub const FIBER_JSON: &str = "{\n  \"preset\": \"cat\",\n  \"kappa\": 0.6,\n  \"eta\": 1.5,\n  \"sigma_ca\": [0.1, 0.2, 0.4],\n  \"g\": 0.3\n}\n";

/// Queries for `vellus eval`.
pub const QUERIES: &str = "theta_o,h,theta_i,phi\n20,0.3,-15,150\n-40,-0.9,40,0\n0,0,0,180\n";

/// A profile for `vellus fit`.
pub fn profile() -> String {
    let rows = (0..5).flat_map(|t| (0..8).map(move |p| (15 * t - 30, 45 * p - 180)));
    let value = |t: i32, p: i32| 0.1 + (-f64::from(t * t) / 800.0).exp() * (1.1 + f64::from(p).to_radians().cos());
    let lines = rows.map(|(t, p)| format!("{t},{p},{:.4}\n", value(t, p)));
    format!("# theta_o = -20\ntheta,phi,value\n{}", lines.collect::<String>())
}

/// The same as a NumPy array of 5 rows and 8 columns.
pub fn npy() -> Vec<u8> {
    let mut header = "{'descr': '<f4', 'fortran_order': False, 'shape': (5, 8), }".to_owned();
    while !(10 + header.len() + 1).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend((0..40).flat_map(|i| (1.0 + (i % 8) as f32 * 0.1).to_le_bytes()));
    bytes
}

/// A PNG of 4 × 2 pixels in one grey.
pub fn png(color: png::ColorType, depth: png::BitDepth, grey: u8) -> Result<Vec<u8>, Stop> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 4, 2);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let data = vec![grey; 8 * color.samples() * if depth == png::BitDepth::Eight { 1 } else { 2 }];
    let mut writer = encoder.write_header().context("PNG")?;
    writer.write_image_data(&data).context("PNG")?;
    writer.finish().context("PNG")?;
    Ok(bytes)
}

/// A Radiance picture of 8 × 1 pixels, run-length encoded.
pub fn hdr() -> Vec<u8> {
    let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=0.5\n\n-Y 1 +X 8\n".as_slice();
    [header, &[2, 2, 0, 8, 136, 128, 136, 64, 3, 0, 0, 0, 133, 0, 136, 129]].concat()
}

/// The shipped tables.
pub fn tables() -> &'static [u8] {
    Tables::SHIPPED
}

/// A text layer as a binary one.
pub fn usdc(text: &Path, folder: &Path) -> Result<Vec<u8>, Stop> {
    let name = |path: &Path| path.to_string_lossy().into_owned();
    let binary = folder.join("binary.usdc");
    let stage = openusd::usd::Stage::builder().open(&name(text)).context("USD")?;
    stage.root_layer().export(name(&binary)).context("USD")?;
    Ok(std::fs::read(binary)?)
}

/// A package of one layer.
pub fn usdz(name: &str, layer: &[u8]) -> Result<Vec<u8>, Stop> {
    let mut package = openusd::usdz::ArchiveWriter::new(Cursor::new(Vec::new()));
    package.add_layer(name, layer).context("USDZ")?;
    Ok(package.finish().context("USDZ")?.into_inner())
}

/// A layer in which each of `levels` prims refers four times to the next: 4^levels strands.
pub fn fan_out(levels: u32) -> String {
    let mut text = "#usda 1.0\n".to_owned();
    for level in 0..levels {
        let prims = (0..4).map(|i| format!("    def \"p{i}\" ( prepend references = </l{}> ) {{}}\n", level + 1));
        let kind = if level == 0 { "def Xform" } else { "over" };
        text += &format!("{kind} \"l{level}\" {{\n{}}}\n", prims.collect::<String>());
    }
    text += &format!(
        "over \"l{levels}\" {{\n    def BasisCurves \"c\" {{\n        uniform token type = \"linear\"\n        \
         int[] curveVertexCounts = [2]\n        point3f[] points = [(0, 0, 0), (0, 1, 0)]\n        \
         float[] widths = [0.1] ( interpolation = \"constant\" )\n    }}\n}}\n"
    );
    text
}
