//! Broken files give one clear message, without a panic or a huge allocation: an error if nothing is left, otherwise a
//! warning.

use crate::common::{blender, read, read_text, told};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use vellus_usd::Options;

fn error_of(body: &str) -> String {
    let error = read_text(body, &Options::default()).unwrap_err().to_string();
    assert!(!error.contains('\n'), "one line: {error}");
    error
}

/// What the operating system reports about a file that cannot be read.
#[cfg(unix)]
fn cause<T: std::fmt::Debug>(result: Result<T, vellus_usd::Error>) -> String {
    std::error::Error::source(&result.unwrap_err()).map(ToString::to_string).unwrap_or_default()
}

#[test]
fn errors_name_the_prim_the_problem_and_the_allowed_values() {
    let curves = |attributes: &str| format!("def BasisCurves \"c\" {{ {attributes} }}");
    let linear = "uniform token type = \"linear\" ";
    let points = "point3f[] points = [(0,0,0), (1,0,0)] ";
    let counts = "int[] curveVertexCounts = [2] ";
    let widths = "float[] widths = [1, 1] ";
    let whole = format!("{linear}{points}{counts}{widths}");
    let mesh = |counts: &str, indices: &str| {
        format!(
            "def Mesh \"m\" {{ point3f[] points = [(0,0,0), (1,0,0), (0,1,0)]
    int[] faceVertexCounts = {counts} int[] faceVertexIndices = {indices} }}"
        )
    };
    let table: Vec<(String, &[&str])> = vec![
        (String::new(), &["nothing to render"]),
        ("def Xform \"a\" {}".to_owned(), &["nothing to render"]),
        (curves(""), &["nothing to render: it has 1 BasisCurves (empty or left out) (/c: it has no curves)"]),
        (curves(&format!("{linear}{points}{counts}")), &["/c: it has no widths", "--width"]),
        (
            curves(&format!("{linear}{points}{widths} int[] curveVertexCounts = [10000000]")),
            &["/c: curveVertexCounts add up to 10000000, but there are 2 points"],
        ),
        (
            curves(&format!(
                "{linear}{points}{widths} int64[] curveVertexCounts = [9223372036854775807, 9223372036854775807]"
            )),
            &["/c: curveVertexCounts add up to", "2 points"],
        ),
        (
            curves(&format!("{linear}{points}{widths} int[] curveVertexCounts = [-2]")),
            &["/c: curveVertexCounts[0] is -2"],
        ),
        (
            curves(&format!("{linear}{points}{widths} int[] curveVertexCounts = [1, 1]")),
            &["/c: 2 of 2 strands are left out (strand 0, 1)", "at least 2 points"],
        ),
        (
            curves(&format!("{points}{counts}{widths}")),
            &["1 of 1 strands are left out (strand 0): a Bezier curve has 3k + 1"],
        ),
        (
            curves(&format!("uniform token basis = \"bspline\" {points}{counts}{widths}")),
            &["1 of 1 strands are left out (strand 0): a BSpline curve has at least 4"],
        ),
        (
            curves(&format!("{linear}{counts}{widths} point3f[] points = [(0,0,0), (nan,0,0)]")),
            &["/c: 1 of 1 strands are left out (strand 0)", "all coordinates are finite"],
        ),
        (
            curves(&format!("{linear}{counts}{widths} point3f[] points = [(inf,0,0), (0,0,0)]")),
            &["/c: 1 of 1 strands are left out", "all coordinates are finite"],
        ),
        (
            curves(&format!("{linear}{points}{counts} float[] widths = [1, -1]")),
            &["/c: 1 of 1 strands are left out", "widths are in [0, 2e9]"],
        ),
        (
            curves(&format!("{linear}{points}{counts} float[] widths = [1, 1, 1]")),
            &["/c: widths has 3 values, but with vertex interpolation there must be 2"],
        ),
        (curves(&format!("{linear}{points}{counts} string widths = \"wide\"")), &["/c: widths must be numbers"]),
        (
            curves(&format!("{linear}{points}{counts} float[] widths = [1, 1] ( interpolation = \"sometimes\" )")),
            &["/c: widths has the interpolation sometimes", "constant, uniform, varying, vertex"],
        ),
        (
            curves(&format!("uniform token type = \"round\" {points}{counts}{widths}")),
            &["/c: type is round", "linear or cubic"],
        ),
        (curves(&format!("uniform token basis = \"nice\" {points}{counts}{widths}")), &["/c: basis is nice"]),
        (curves(&format!("uniform token wrap = \"paper\" {points}{counts}{widths}")), &["/c: wrap is paper"]),
        (
            curves(&format!(
                "{whole} matrix4d xformOp:transform = ((1,0,0,0),(0,1,0,0),(0,0,1,0),(nan,0,0,1)) uniform token[] xformOpOrder = [\"xformOp:transform\"]"
            )),
            &["/c: xformOp:transform must be finite"],
        ),
        (
            curves(&format!(
                "{whole} float3 xformOp:scale = (1,0,1) uniform token[] xformOpOrder = [\"!invert!xformOp:scale\"]"
            )),
            &["/c: xformOp:scale cannot be inverted"],
        ),
        (mesh("[3]", "[0, 1, 7]"), &["/m: faceVertexIndices[2] is 7, but there are 3 points"]),
        (mesh("[3]", "[0, 1, -1]"), &["/m: faceVertexIndices[2] is -1"]),
        (mesh("[2147483647, 3]", "[0, 1, 2]"), &["/m: faceVertexCounts add up to 2147483650, but there are 3"]),
        (mesh("[2]", "[0, 1]"), &["/m: faceVertexCounts[0] is 2", "at least 3"]),
        ("def Xform \"a\" ( references = @gone.usda@ ) {}".to_owned(), &["gone.usda"]),
        ("( subLayers = [@gone.usda@] )".to_owned(), &["gone.usda"]),
        ("def Xform \"a\" {".repeat(5000), &["more than 500 brackets"]),
        ("def Xform \"a\" ( references = @stage.usda@</a> ) {}".to_owned(), &["cycle"]),
        ("def Xform \"a\" {".to_owned(), &["stage.usda"]),
        ("def Xform \"a}\" {}".to_owned(), &["line 2: a prim is called \"a}\"", "letters, digits and underscores"]),
        ("def Xform \"\" {}".to_owned(), &["line 2: a prim is called \"\""]),
        ("def Xform \"a\" ( references = </b}> ) {}".to_owned(), &["line 2: \"/b}\" is no path"]),
        (curves(&format!("{whole} rel material:binding = </b}}c>")), &["line 2: \"/b}c\" is no path"]),
    ];
    for (body, parts) in &table {
        let error = error_of(body);
        for part in *parts {
            assert!(error.contains(part), "{error}\ninstead of {part}\nfor {body}");
        }
    }
    read_text(&curves(&whole), &Options::default()).unwrap();

    // The same curves with a flaw that leaves them there.
    let kept: Vec<(String, &[&str])> = vec![
        (
            curves(&format!("{whole} float[] primvars:vellus:g = [1, 2, 3] (interpolation = \"uniform\")")),
            &["/c: primvars:vellus:g has 3 values, but with uniform interpolation there must be 1: it is ignored"],
        ),
        (
            curves(&format!(
                "{whole} texCoord2f[] primvars:st = [(0,0)] (interpolation = \"uniform\")
                    int[] primvars:st:indices = [7]"
            )),
            &["/c: primvars:st:indices[0] is 7, but there are 1 values: it is ignored"],
        ),
        (
            format!("{} def Camera \"k\" {{ float focalLength = 0 }}", curves(&whole)),
            &["/k: focalLength", "must be positive", "it is left out"],
        ),
        (
            format!("{} def SphereLight \"l\" {{ float inputs:radius = -1 }}", curves(&whole)),
            &["/l: inputs:radius is -1: it must be positive: it is left out"],
        ),
        (
            format!("{} def RectLight \"l\" {{ color3f inputs:color = (1, -1, 0) }}", curves(&whole)),
            &["/l: it emits", "no channel may be negative"],
        ),
        (
            format!("{} def DomeLight \"l\" {{ asset inputs:texture:file = @sky.hdr@ }}", curves(&whole)),
            &["/l: inputs:texture:file: the file sky.hdr does not exist: the light shines without it"],
        ),
        (
            format!("( upAxis = \"X\" metersPerUnit = -1 ) {}", curves(&whole)),
            &["/: upAxis must be Y or Z: Y is taken"],
        ),
        (
            format!(
                "( subLayers = [@gone.usda@] ) {} def Xform \"a\" ( references = @away.usda@ ) {{}}",
                curves(&whole)
            ),
            &["gone.usda"],
        ),
    ];
    for (body, parts) in &kept {
        let (scene, warnings) = read_text(body, &Options::default()).unwrap_or_else(|error| panic!("{error}\n{body}"));
        assert_eq!(scene.strands[0].len(), 1, "{body}");
        assert!(warnings.iter().any(|w| parts.iter().all(|part| w.to_string().contains(part))), "{warnings:?}\n{body}");
    }
    // What the user named is an error.
    let camera = format!("{} def Camera \"k\" {{ float focalLength = 0 }}", curves(&whole));
    let named = Options { camera: Some("k".to_owned()), ..Options::default() };
    assert!(read_text(&camera, &named).unwrap_err().to_string().contains("/k: focalLength"));
}

/// Found by a fuzzer: with such a name, the search for the parent of a prim never ended.
#[test]
fn names_are_checked_in_binary_layers_too() {
    let folder = tempfile::tempdir().unwrap();
    let [text, file] = ["a.usda", "a.usdc"].map(|name| folder.path().join(name));
    let body = "def Xform \"Wolverine\" { def BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
        point3f[] points = [(0,0,0), (1,0,0)] float[] widths = [1, 1] custom string vellus:name = \"Wolverine\" } }";
    std::fs::write(&text, format!("#usda 1.0\n{body}")).unwrap();
    let stage = openusd::usd::Stage::builder().open(text.to_str().unwrap()).unwrap();
    stage.root_layer().export(file.to_str().unwrap()).unwrap();
    let mut bytes = std::fs::read(&file).unwrap();
    let at = bytes.windows(9).position(|name| name == b"Wolverine").unwrap();
    assert!(read(&file, &Options::default()).is_ok());
    bytes[at + 8] = b'}';
    std::fs::write(&file, bytes).unwrap();
    let error = read(&file, &Options::default()).unwrap_err().to_string();
    assert!(error.contains("Wolverin}"), "{error}");
}

/// Found by a fuzzer: the search for the prim of such a property never ended.
#[test]
fn names_of_properties_are_checked_in_binary_layers() {
    let folder = tempfile::tempdir().unwrap();
    let [text, file] = ["a.usda", "a.usdc"].map(|name| folder.path().join(name));
    let body = "def Xform \"x\" { custom token first = \"Wolverine\" custom token second = \"b\" }
        def BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
        point3f[] points = [(0,0,0), (1,0,0)] float[] widths = [1, 1] }";
    std::fs::write(&text, format!("#usda 1.0\n{body}")).unwrap();
    let stage = openusd::usd::Stage::builder().open(text.to_str().unwrap()).unwrap();
    stage.root_layer().export(file.to_str().unwrap()).unwrap();
    let mut bytes = std::fs::read(&file).unwrap();
    let tokens = openusd::usdc::CrateFile::open(std::io::Cursor::new(&bytes)).unwrap().tokens;
    let token = |name: &str| tokens.iter().position(|token| token == name).unwrap() as u32;
    // The list of the two properties gets another name.
    let list = [2, 0, token("first"), token("second")].map(u32::to_le_bytes).concat();
    let at = bytes.windows(list.len()).position(|part| part == list).unwrap();
    bytes[at + 12..at + 16].copy_from_slice(&token("Wolverine").to_le_bytes());
    let at = bytes.windows(9).position(|name| name == b"Wolverine").unwrap();
    bytes[at + 8] = b'}';
    std::fs::write(&file, bytes).unwrap();
    let (scene, warnings) = read(&file, &Options::default()).unwrap();
    let said = warnings[0].to_string();
    assert!(said.contains("/x: a property is called \"Wolverin}\": a name has only letters"), "{said}");
    assert_eq!((scene.strands.len(), warnings.len()), (1, 1));
}

#[test]
fn missing_files_and_other_kinds_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let error = read(&folder.path().join("none.usda"), &Options::default()).unwrap_err().to_string();
    assert!(error.contains("none.usda"), "{error}");
    for name in ["text.usdc", "text.usdz", "text.usda", "text.obj", "text.usd"] {
        let file = folder.path().join(name);
        std::fs::write(&file, "this is no stage").unwrap();
        let error = read(&file, &Options::default()).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
    assert!(read(folder.path(), &Options::default()).is_err());
}

/// Layers as deep as the limit, on the small stack of a test's thread.
#[test]
fn deep_layers_are_read() {
    let body = "def Xform \"a\" {".repeat(490)
        + "def BasisCurves \"c\" { uniform token type = \"linear\"
    int[] curveVertexCounts = [2] point3f[] points = [(0,0,0), (1,0,0)] float[] widths = [1, 1] }"
        + &"}".repeat(490);
    assert_eq!(read_text(&body, &Options::default()).unwrap().0.strands.len(), 1);
}

/// Reads a file that was cut off or changed. Reading must end, with any result.
fn survives(file: &Path, bytes: &[u8], what: &str) {
    std::fs::write(file, bytes).unwrap();
    let result =
        catch_unwind(AssertUnwindSafe(|| read(file, &Options { default_width: Some(0.1), ..Options::default() })));
    assert!(result.is_ok(), "a panic with {what}");
}

const ROUNDS: usize = 100;

#[test]
fn reading_cut_off_and_damaged_files_ends() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["fur_catmull_rom.usda", "fur_catmull_rom.usdc", "particles.usda"] {
        let bytes = std::fs::read(blender(name)).unwrap();
        let file = folder.path().join(name);
        for i in 0..ROUNDS {
            survives(&file, &bytes[..i * bytes.len() / ROUNDS], &format!("{name} cut off at {i}/{ROUNDS}"));
            // The tables of a binary file are at its end, and the offsets of the tables at its start.
            let mut garbled = bytes.clone();
            let from_end = i % 2 == 0;
            for k in 0..3 {
                let at = (i * 7919 + k * 104_729) % 1500.min(bytes.len());
                let at = if from_end { bytes.len() - 1 - at } else { at };
                garbled[at] = (i * 31 + k * 17) as u8;
            }
            survives(&file, &garbled, &format!("{name} garbled, round {i}"));
        }
    }
}

/// The same for the seeds of the fuzzer: a stage with a texture as text, binary and package, and the texture.
#[test]
fn reading_damaged_stages_and_textures_ends() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut image = Vec::new();
    let mut encoder = png::Encoder::new(&mut image, 2, 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[100; 12]).unwrap();
    std::fs::write(at("a.png"), &image).unwrap();
    let text = "#usda 1.0
def BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2, 3] float[] widths = [.5]
    point3f[] points = [(0,0,0), (1,0,0), (0,0,1.), (1,0,1), (2,0,1)] 
    float[] primvars:vellus:kappa = [0.5, 9] ( interpolation = \"uniform\" )
    float3 xformOp:scale = (1, 2, 1) uniform token[] xformOpOrder = [\"xformOp:scale\"] }
def RectLight \"l\" { asset inputs:texture:file = @a.png@ }
def CylinderLight \"t\" { float inputs:radius = 0.5 }
def Camera \"k\" { float fStop = 2 float focusDistance = 3 }
def Xform \"x\" ( references = </c> ) {}";
    std::fs::write(at("whole.usda"), text).unwrap();
    std::fs::write(at("plain.usda"), text.replace("[.5]", "[0.5]").replace("1.)", "1)")).unwrap();
    let stage = openusd::usd::Stage::builder().open(at("plain.usda").to_str().unwrap()).unwrap();
    stage.root_layer().export(at("whole.usdc").to_str().unwrap()).unwrap();
    let mut package = openusd::usdz::ArchiveWriter::new(std::io::Cursor::new(Vec::new()));
    package.add_layer("whole.usda", text.as_bytes()).unwrap();
    package.add_layer("a.png", &image).unwrap();
    std::fs::write(at("whole.usdz"), package.finish().unwrap().into_inner()).unwrap();
    for name in ["whole.usda", "whole.usdc", "whole.usdz", "a.png"] {
        let whole = std::fs::read(at(name)).unwrap();
        let top = at(if name == "a.png" { "whole.usda" } else { name });
        let options = Options::default();
        assert_eq!(read(&top, &options).unwrap().0.lights.len(), 2, "{name}");
        for at_byte in (0..whole.len()).step_by(whole.len().div_ceil(ROUNDS)) {
            let mut garbled = whole.clone();
            garbled[at_byte] ^= 0xff;
            for bytes in [&whole[..at_byte], &garbled] {
                std::fs::write(at(name), bytes).unwrap();
                let result = catch_unwind(AssertUnwindSafe(|| read(&top, &options)));
                let scene = result.unwrap_or_else(|_| panic!("a panic: {name}, byte {at_byte}"));
                assert!(scene.is_err() || scene.is_ok_and(|(scene, _)| scene.validate() == Ok(())), "{name} {at_byte}");
            }
        }
        std::fs::write(at(name), &whole).unwrap();
    }
}

/// Parse errors state the line, the column and the layer.
#[test]
fn parse_errors_name_their_place() {
    let error = error_of("def Xform \"a\" {\n    def Xform = 3\n}");
    assert!(error.contains("stage.usda: line 3, column 15: ") && error.contains("found '= 3'"), "{error}");
    let error = error_of(&format!("def Xform \"a\" {{\n    def Xform \u{1}{}\n}}", "z".repeat(500)));
    assert!(error.contains("line 3, column 15: this is no word, number, string or path"), "{error}");
    assert!(error.len() < 250 && !error.contains('\u{1}'), "{error}");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("top.usda"), "#usda 1.0\n( subLayers = [@good.usda@, @bad.usda@] )\n").unwrap();
    std::fs::write(folder.path().join("good.usda"), "#usda 1.0\n").unwrap();
    std::fs::write(folder.path().join("bad.usda"), "#usda 1.0\n\ndef Xform {}").unwrap();
    let error = read(&folder.path().join("top.usda"), &Options::default()).unwrap_err().to_string();
    assert!(error.contains("bad.usda: line 3, column 11: "), "{error}");
}

/// Pixar's library reads a byte order mark, and numbers without a digit before or after the point. So do we.
#[test]
fn byte_order_marks_and_short_numbers_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.usda");
    let text =
        "\u{feff}#usda 1.0\ndef BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
        point3f[] points = [(.5,-.25,1.), (1,+.5,2.e0)] float[] widths = [.5, 1.] }";
    std::fs::write(&file, text).unwrap();
    let (scene, _) = read(&file, &Options::default()).unwrap();
    let points: Vec<[f32; 4]> = scene.strands[0].points.iter().map(|p| p.to_array()).collect();
    assert_eq!(points, [[0.5, -0.25, 1.0, 0.25], [1.0, 0.5, 2.0, 0.5]]);
}

/// Sizes that would overflow later are refused when they are read.
#[test]
fn sizes_are_bounded() {
    let curves = |points: &str, more: &str| {
        format!(
            "def BasisCurves \"c\" {{ uniform token type = \"linear\" int[] curveVertexCounts = [2]
            point3f[] points = [(0,0,0), {points}] float[] widths = [1, 1] {more} }}"
        )
    };
    let scale =
        |scale: &str| format!("float3 xformOp:scale = {scale} uniform token[] xformOpOrder = [\"xformOp:scale\"]");
    let table = [
        (curves("(1e20,0,0)", ""), "/c: 1 of 1 strands are left out (strand 0)"),
        (curves("(1,0,0)", &scale("(1e12, 1e12, 1e12)")), "/c: 1 of 1 strands are left out (strand 0)"),
        (curves("(1,0,0)", &scale("(0, 0, 0)")), "/c: its transform flattens the strands"),
        (curves("(1,0,0)", "").replace("[1, 1]", "[1, 1e30]"), "/c: 1 of 1 strands are left out (strand 0)"),
        (
            format!("{} def Camera \"k\" {{ float fStop = 1e-30 float focusDistance = 1 }}", curves("(1,0,0)", "")),
            "/k: the lens' radius is",
        ),
        (
            format!("{} def Camera \"k\" {{ float focalLength = 1e-10 }}", curves("(1,0,0)", "")),
            "/k: the film's width over the focal length",
        ),
    ];
    for (body, message) in table {
        let error = told(read_text(&body, &Options::default()));
        assert!(error.contains(message), "{error}");
    }
    let wide = Options { default_width: Some(1e30), ..Options::default() };
    assert!(read_text("", &wide).unwrap_err().to_string().contains("must be in [0, 2e9]"));
}

#[test]
fn errors_of_unset_handles_explain_the_export() {
    let error = error_of(
        "def BasisCurves \"c\" { int[] curveVertexCounts = [4] float[] widths = [1]
        point3f[] points = [(0,0,0), (nan,0,0), (1,0,0), (2,0,0)] }",
    );
    assert!(error.contains("strand 0") && error.contains("re-export the curves as Catmull-Rom"), "{error}");
}

/// A package with an invalid directory is refused before it is read.
#[test]
fn zeros_are_not_a_package() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.usdz");
    // Larger than the limit. The file is sparse and takes no space on the disk.
    std::fs::File::create(&path).unwrap().set_len(32 << 30).unwrap();
    let error = read(&path, &Options::default()).unwrap_err().to_string();
    assert!(error.contains("no zip archive"), "{error}");
    std::fs::rename(&path, folder.path().join("a.usda")).unwrap();
    let error = read(&folder.path().join("a.usda"), &Options::default()).unwrap_err().to_string();
    assert!(error.contains("at most 17179869184 are read"), "{error}");
}

#[cfg(unix)]
#[test]
fn devices_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for device in ["/dev/zero", "/dev/urandom"] {
        for name in ["a.usda", "a.usdc", "a.usdz", "a.usd"] {
            let path = folder.path().join(name);
            std::fs::remove_file(&path).ok();
            std::os::unix::fs::symlink(device, &path).unwrap();
            let top = folder.path().join("top.usda");
            std::fs::write(&top, format!("#usda 1.0\n( subLayers = [@{name}@] )")).unwrap();
            let error = cause(read(&path, &Options::default()));
            assert!(error.contains("it is a device"), "{error}");
            // A layer is opened under the target of its link, whose name does not show the format.
            assert!(read(&top, &Options::default()).is_err());
        }
    }
}

/// Stages are read more than once. A second opening of a pipe would wait forever.
#[cfg(target_os = "linux")]
#[test]
fn pipes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (pipe, _writer) = std::io::pipe().unwrap();
    for extension in ["usda", "usdc", "usdz"] {
        let path = folder.path().join(format!("a.{extension}"));
        let target = format!("/proc/self/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&pipe));
        std::os::unix::fs::symlink(target, &path).unwrap();
        let error = cause(vellus_usd::read(&path, &Options::default()));
        assert!(error.contains("a regular file is expected"), "{error}");
    }
}
