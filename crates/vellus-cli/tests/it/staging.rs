//! Camera, lights, background and body of files without them.

use crate::common::{Picture, refused, run, tfx};
use std::fmt::Write;
use std::io::Cursor;
use std::path::Path;

/// Strands of a tuft as .usda. They lean toward −x, so the front is +x. `more` is the rest of the file.
fn tuft(more: &str) -> String {
    let (mut points, mut counts) = (String::new(), String::new());
    for i in 0..400 {
        let (x, z) = (f64::from(i % 20) * 0.1, f64::from(i / 20) * 0.1);
        write!(points, "({x}, 0, {z}), ({}, 1, {z}), ", x - 0.6).unwrap();
        counts.push_str("2, ");
    }
    format!(
        "#usda 1.0
def BasisCurves \"tuft\" {{
    uniform token type = \"linear\"
    int[] curveVertexCounts = [{counts}]
    float[] widths = [0.06] (interpolation = \"constant\")
    point3f[] points = [{points}]
}}
{more}"
    )
}

/// Renders a small picture of a file with more options, and returns what the command says.
fn render(folder: &Path, file: &str, output: &str, more: &[&str]) -> String {
    run(folder, &[&["render", file, "--size", "48x32", "--spp", "16", "-o", output], more].concat())
}

/// Bytes and channels of a PNG.
fn png(path: &Path) -> (Vec<u8>, usize) {
    let mut reader = png::Decoder::new(Cursor::new(std::fs::read(path).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    (pixels, reader.info().color_type.samples())
}

/// The mean of the first three channels of a PNG.
fn brightness(path: &Path) -> f64 {
    let (pixels, channels) = png(path);
    let sum: f64 = pixels.chunks(channels).flat_map(|p| &p[..3]).map(|&x| f64::from(x)).sum();
    sum / (3 * pixels.len() / channels) as f64
}

/// One line says what was added. The picture is grey, without white or black parts, whatever the size of the groom.
#[test]
fn a_file_without_camera_and_lights_gets_a_studio() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("tuft.usda"), tuft("")).unwrap();
    let said = render(path, "tuft.usda", "a.exr", &[]);
    let line =
        "the file has no camera: it looks from 35,15 at the front, +x (--view), and no lights: the light is studio";
    assert!(said.contains(line), "{said}");
    assert!(!said.contains("hint") && !said.contains("warning"), "{said}");
    let (pixels, _) = png(&path.join("a.png"));
    let middle = pixels.iter().filter(|&&x| (20..236).contains(&x)).count();
    assert!(middle as f64 > 0.97 * pixels.len() as f64, "{middle} of {}", pixels.len());
    assert!((70.0..150.0).contains(&brightness(&path.join("a.png"))), "{}", brightness(&path.join("a.png")));
    let picture = Picture::read(&path.join("a.exr"));
    assert!(!picture.note("vellus_light_stops").is_empty());
    // The cyclorama covers the whole picture.
    let (_, alpha) = picture.channels.iter().find(|(name, _)| name == "A").unwrap();
    assert!(alpha.iter().all(|&a| a == 1.0));
    for light in ["studio", "sun", "sky"] {
        let output = format!("{light}.png");
        let said = render(path, "tuft.usda", &output, &["--light", light]);
        let mean = brightness(&path.join(&output));
        assert!((60.0..170.0).contains(&mean) && !said.contains("hint"), "{light}: {mean} {said}");
    }
}

/// Parts of the samples merge to the picture of one run: their exposure is the same.
#[test]
fn parts_of_a_staged_picture_merge() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("tuft.usda"), tuft("")).unwrap();
    let part = |samples: &str, output: &str, threads: &str| {
        let options = ["render", "tuft.usda", "--size", "24x16", "--background", "transparent"];
        run(path, &[&options[..], &["--samples", samples, "--threads", threads, "-o", output]].concat());
    };
    part("0..3", "a.exr", "1");
    part("3..8", "b.exr", "2");
    part("0..8", "whole.exr", "2");
    run(path, &["merge", "a.film", "b.film", "-o", "merged.exr"]);
    assert!(Picture::read(&path.join("merged.exr")).same(&Picture::read(&path.join("whole.exr"))));
    assert_eq!(png(&path.join("merged.png")), png(&path.join("whole.png")));
}

#[test]
fn backgrounds_are_colours_images_or_transparent() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("tuft.usda"), tuft("")).unwrap();
    render(path, "tuft.usda", "blue.png", &["--background", "#204080"]);
    let (pixels, channels) = png(&path.join("blue.png"));
    assert_eq!((channels, &pixels[..3]), (3, &[0x20, 0x40, 0x80][..]));
    render(path, "tuft.usda", "clear.png", &["--background", "transparent"]);
    let (pixels, channels) = png(&path.join("clear.png"));
    let middle = 4 * (16 * 48 + 24);
    assert!(channels == 4 && pixels[..4] == [0; 4] && pixels[middle + 3] > 200, "{:?}", &pixels[middle..middle + 4]);
    render(path, "tuft.usda", "image.png", &["--background", "blue.png"]);
    // The edge of the image is at the edge of the picture.
    let (pixels, _) = png(&path.join("image.png"));
    assert!(pixels[..3].iter().zip([0x20, 0x40, 0x80]).all(|(&a, b)| i32::abs(i32::from(a) - b) <= 1), "{pixels:?}");
    // A lat-long image is a light and the background.
    let said = render(path, "tuft.usda", "lit.png", &["--light", "blue.png"]);
    let (pixels, _) = png(&path.join("lit.png"));
    let sum = |c: usize| pixels.iter().skip(c).step_by(3).map(|&x| u32::from(x)).sum::<u32>();
    assert!(sum(2) > sum(1) && sum(1) > sum(0), "{:?}", [sum(0), sum(1), sum(2)]);
    assert!(said.contains("the light is blue.png"), "{said}");
}

/// A view replaces the camera and keeps the lights. Lights replace the lights and keep the camera.
#[test]
fn views_and_lights_replace_those_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let own = "def DistantLight \"sun\" { float inputs:intensity = 2 float inputs:angle = 60 }
def Camera \"camera\" { double3 xformOp:translate = (0.7, 0.5, 6)
    uniform token[] xformOpOrder = [\"xformOp:translate\"] }";
    std::fs::write(path.join("own.usda"), tuft(own)).unwrap();
    let said = render(path, "own.usda", "own.png", &[]);
    assert!(!said.contains("the file has no"), "{said}");
    for (name, more) in [("left", ["--view", "90,10"]), ("sun", ["--light", "sun"]), ("zoom", ["--view", "90,10,3"])] {
        render(path, "own.usda", &format!("{name}.png"), &more);
    }
    let pictures = ["own", "left", "sun", "zoom"].map(|name| png(&path.join(format!("{name}.png"))).0);
    for i in 0..4 {
        assert!(pictures[i + 1..].iter().all(|other| *other != pictures[i]), "{i}");
    }
    refused(path, &["render", "own.usda", "--view", "0,0", "--camera", "camera"], &["--camera and --view"]);
}

/// Lights that the camera does not see light the scene all the same.
#[test]
fn lights_of_a_file_can_be_invisible() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let light = |hidden: &str| {
        let dome = format!("def DomeLight \"sky\" {{ {hidden} }}");
        std::fs::write(path.join("lit.usda"), tuft(&dome)).unwrap();
        render(path, "lit.usda", "lit.exr", &[]);
        Picture::read(&path.join("lit.exr"))
    };
    let red = |picture: &Picture| picture.channels.iter().find(|(name, _)| name == "R").unwrap().1.clone();
    let (seen, unseen) = (red(&light("")), red(&light("int primvars:ri:attributes:visibility:camera = 0")));
    assert_eq!((seen[0], unseen[0]), (1.0, 0.0));
    let middle = 16 * 48 + 24;
    assert!(unseen[middle] > 0.05, "{}", unseen[middle]);
}

#[test]
fn a_body_is_added_and_an_obj_file_is_rendered_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("tuft.usda"), tuft("")).unwrap();
    let cube = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 0 0 2\nv 2 0 2\nv 2 1 2\nv 0 1 2\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";
    std::fs::write(path.join("cube.obj"), cube).unwrap();
    let covered = |output: &str| {
        let picture = Picture::read(&path.join(output));
        let of = |name: &str| picture.channels.iter().find(|(n, _)| n == name).unwrap().1.iter().sum::<f32>();
        (of("A"), of("fibers.A"))
    };
    render(path, "tuft.usda", "bare.exr", &["--background", "black"]);
    render(path, "tuft.usda", "body.exr", &["--background", "black", "--body", "cube.obj"]);
    let ((bare, fur), (body, hidden)) = (covered("bare.exr"), covered("body.exr"));
    assert!((bare - fur).abs() < 1.0 && body > hidden + 50.0, "{bare} {fur} {body} {hidden}");
    let said = render(path, "cube.obj", "cube.exr", &["--background", "black"]);
    let (solid, fur) = covered("cube.exr");
    assert!(solid > 200.0 && fur == 0.0 && said.contains("the light is studio"), "{solid} {fur} {said}");
    refused(path, &["render", "tuft.usda", "--body", "none.obj"], &["cannot read none.obj"]);
    refused(path, &["render", "tuft.usda", "--body", "cube.txt"], &["--body cube.txt: it must be a .obj"]);
    refused(path, &["render", "tuft.usda", "--light", "none.hdr"], &["cannot read none.hdr"]);
    refused(path, &["render", "tuft.usda", "--background", "none.png"], &["cannot read none.png"]);
}

/// A picture that shows nothing gets one line that names the cause.
#[test]
fn hints_name_the_cause_of_black_white_and_empty_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let hint = |more: &str, options: &[&str]| {
        std::fs::write(path.join("a.usda"), tuft(more)).unwrap();
        let said = render(path, "a.usda", "a.png", options);
        let hints: Vec<String> = said.lines().filter(|line| line.starts_with("hint: ")).map(str::to_owned).collect();
        assert!(hints.len() <= 1, "{said}");
        hints.concat()
    };
    let sun = |intensity: &str| format!("def DistantLight \"sun\" {{ float inputs:intensity = {intensity} }}");
    assert_eq!(hint("", &[]), "");
    assert!(hint(&sun("0"), &[]).contains("no light emits anything"));
    assert!(hint(&sun("0.0001"), &[]).contains("its lights are weak: try --exposure"));
    assert!(hint("", &["--exposure", "20"]).contains("its lights are strong: try --exposure"));
    let white = "def DomeLight \"sky\" { float inputs:intensity = 40 }";
    let said = hint(white, &[]);
    assert!(said.contains("nearly white") && said.contains("--"), "{said}");
    let away = "def Camera \"c\" { double3 xformOp:translate = (0, 0, -9)
        uniform token[] xformOpOrder = [\"xformOp:translate\"] }";
    assert!(hint(&(sun("2") + away), &[]).contains("the camera looks away: try --view"));
}

/// Grooms without widths are rendered with the width that `groom info` suggests.
#[test]
fn grooms_without_widths_are_rendered_with_a_suggested_width() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let thin = tuft("").replace("float[] widths = [0.06] (interpolation = \"constant\")", "");
    std::fs::write(path.join("a.usda"), thin).unwrap();
    let info = crate::common::vellus(path, &["groom", "info", "a.usda"]);
    let text = String::from_utf8_lossy(&info.stdout).into_owned();
    let width = text.split("give one with --width, ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    assert!(text.contains("bounds    (-0.600000, 0, 0) to (1.90000, 1.00000, 1.90000)"), "{text}");
    let said = render(path, "a.usda", "a.png", &[]);
    assert!(said.contains(&format!("/tuft has no widths: it is rendered with --width {width}")), "{said}");
    let said = render(path, "a.usda", "b.png", &["--width", width]);
    assert!(!said.contains("warning"), "{said}");
    assert_eq!(png(&path.join("a.png")), png(&path.join("b.png")));
    // Other commands do not guess.
    refused(path, &["groom", "convert", "a.usda", "-o", "b.usda"], &["/tuft: it has no widths", "--width"]);
}

/// Strands all over an ellipsoid that end `lean` further along z.
fn coat(count: u16, points: u8, radii: [f32; 3], length: f32, lean: f32) -> Vec<Vec<[f32; 3]>> {
    let strand = |i: u16| {
        // Points of a Fibonacci lattice.
        let (y, turn) = (1.0 - (2.0 * f32::from(i) + 1.0) / f32::from(count), f32::from(i) * 2.399_963);
        let around = (1.0 - y * y).sqrt();
        let root = [around * turn.cos(), y, around * turn.sin()];
        let point = |k: u8| {
            let t = f32::from(k) / f32::from(points - 1);
            let grown = |c: usize| root[c] * (radii[c] + length * t);
            [grown(0), grown(1), grown(2) + lean * t * t]
        };
        (0..points).map(point).collect()
    };
    (0..count).map(strand).collect()
}

/// A groom of guide strands, strands over a separate body, and an export of Blender: one short command for each.
#[test]
fn grooms_of_other_programs_are_staged_without_usd() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("bear.tfx"), tfx(&coat(20_000, 4, [42.0, 57.0, 99.0], 4.0, 3.0))).unwrap();
    std::fs::write(path.join("hair.tfx"), tfx(&coat(474, 16, [52.0, 52.0, 52.0], 8.0, -6.0))).unwrap();
    // An octahedron within the hair.
    let head = "v 55 0 0\nv -55 0 0\nv 0 55 0\nv 0 -55 0\nv 0 0 55\nv 0 0 -55\n\
        f 5 1 3\nf 1 6 3\nf 6 2 3\nf 2 5 3\nf 1 5 4\nf 6 1 4\nf 2 6 4\nf 5 2 4\n";
    std::fs::write(path.join("head.obj"), head).unwrap();
    let blender = concat!(env!("CARGO_MANIFEST_DIR"), "/../vellus-usd/tests/data/blender/fur_catmull_rom.usdc");
    let grooms = [
        ("bear.tfx", &[][..], "at the front, -z"),
        ("hair.tfx", &["--body", "head.obj"], "at the front, +z"),
        (blender, &[], "at the front, -y"),
    ];
    for (name, more, front) in grooms {
        let said = render(path, name, "a.png", more);
        let mean = brightness(&path.join("a.png"));
        assert!(said.contains(front) && !said.contains("hint"), "{name}: {said}");
        assert!((60.0..170.0).contains(&mean), "{name}: {mean}");
    }
}
