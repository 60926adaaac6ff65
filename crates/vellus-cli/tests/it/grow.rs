//! `vellus groom grow`.

use crate::common::{refused, vellus};
use std::path::Path;

fn run(folder: &Path, args: &[&str]) -> String {
    let output = vellus(folder, args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A sphere of radius 2 around (1, 0, 0) with uv: quads, and triangles at the poles.
fn sphere(name: &str) -> String {
    use std::fmt::Write;
    let (around, down) = (48, 24);
    let mut text = format!("o {name}\n");
    for j in 0..=down {
        for i in 0..=around {
            let (u, v) = (f64::from(i) / f64::from(around), f64::from(j) / f64::from(down));
            let ((sin, cos), (sine, cosine)) =
                ((v * std::f64::consts::PI).sin_cos(), (u * std::f64::consts::TAU).sin_cos());
            writeln!(text, "v {} {} {}\nvt {u} {}", 1.0 + 2.0 * sin * sine, 2.0 * cos, 2.0 * sin * cosine, 1.0 - v)
                .unwrap();
        }
    }
    for j in 0..down {
        for i in 0..around {
            let a = j * (around + 1) + i + 1;
            let [b, c, d] = [a + around + 1, a + around + 2, a + 1];
            writeln!(text, "f {a}/{a} {b}/{b} {c}/{c} {d}/{d}").unwrap();
        }
    }
    text
}

/// A PNG of one row of grey or RGB pixels.
fn image(folder: &Path, name: &str, color: png::ColorType, data: &[u8]) {
    let file = std::fs::File::create(folder.join(name)).unwrap();
    let mut encoder = png::Encoder::new(file, (data.len() / color.samples()) as u32, 1);
    encoder.set_color(color);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
}

fn read(folder: &Path, name: &str) -> vellus_scene::Scene {
    vellus_usd::read(&folder.join(name), &vellus_usd::Options::default()).unwrap().scene
}

/// Roots of all strands, in the frame of the sphere.
fn roots(strands: &vellus_scene::Strands) -> Vec<glam::Vec3> {
    let first = usize::from(strands.basis != vellus_scene::Basis::Linear);
    (0..strands.len()).map(|i| strands.strand(i)[first].truncate() - glam::Vec3::X).collect()
}

#[test]
fn a_mesh_alone_gets_a_coat_in_proportion_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("ball.obj"), sphere("ball")).unwrap();
    let said = run(path, &["groom", "grow", "ball.obj"]);
    assert!(said.contains("100000 strands") && said.contains("wrote out/groom.usda"), "{said}");
    run(path, &["groom", "grow", "ball.obj", "--count", "1000", "-o", "few.usda"]);
    let info = run(path, &["groom", "info", "few.usda"]);
    for part in ["units", "1000", "bounds", "widths", "lengths", "memory", "uv of the roots"] {
        assert!(info.contains(part), "{part}: {info}");
    }
    let scene = read(path, "out/groom.usda");
    assert_eq!((scene.meshes.len(), scene.meshes[0].name.as_str()), (1, "ball"));
    let measures = vellus_groom::measure(&scene.strands[0]).unwrap();
    // The default length is 0.035 √(16π) = 0.25, with a variation of a quarter.
    assert!((measures.lengths[1] - 0.25).abs() < 0.02, "{measures:?}");
    let (low, high) = measures.bounds;
    assert!((high - low).max_element() < 2.0 * (2.0 + 0.6), "{measures:?}");
}

/// The total number of strands is exactly the density times the area. Each octant has 1/8 of it. The standard deviation
/// of independent draws would be √(n · 1/8 · 7/8), and roots are placed more evenly. The area of the sphere of 48 × 24
/// faces is too small by less than a percent.
#[test]
fn the_number_of_strands_is_density_times_area() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("ball.obj"), sphere("ball")).unwrap();
    let grow = |name: &str, more: &[&str]| {
        run(path, &[&["groom", "grow", "ball.obj", "--segments", "3", "--strands-only", "-o", name], more].concat());
        read(path, name)
    };
    let scene = grow("a.usda", &["--density", "160", "--seed", "7"]);
    assert!(scene.meshes.is_empty());
    let strands = &scene.strands[0];
    let n = 160.0 * 16.0 * std::f64::consts::PI;
    assert!((strands.len() as f64 / n - 1.0).abs() < 0.01, "{} against {n}", strands.len());
    let n = strands.len() as f64;
    let roots = roots(strands);
    for octant in 0..8 {
        let is_in = |r: &&glam::Vec3| (0..3).all(|c| (r[c] > 0.0) == (octant >> c & 1 == 1));
        let count = roots.iter().filter(is_in).count() as f64;
        assert!((count - n / 8.0).abs() < 4.0 * (n * 7.0 / 64.0).sqrt(), "{count} in octant {octant} of {n}");
    }
    // Chords of 7.5° are inside the sphere by up to 2 (1 − cos 3.75°)², so the tolerance is half a percent.
    assert!(roots.iter().all(|r| (r.length() / 2.0 - 1.0).abs() < 5e-3));
    assert!(strands.points.iter().all(|p| p.is_finite() && p.w > 0.0));
    // The same seed gives the same fur, another seed gives other fur.
    grow("b.usda", &["--density", "160", "--seed", "7"]);
    let bytes = |name: &str| std::fs::read(path.join(name)).unwrap();
    assert_eq!(bytes("a.usda"), bytes("b.usda"));
    grow("c.usda", &["--density", "160", "--seed", "8"]);
    assert_ne!(bytes("a.usda"), bytes("c.usda"));
}

/// The map's left half is 51/255 and its right half 204/255. They repeat and blend evenly over half a pixel at their
/// borders. One half of the sphere gets a quarter as many strands as the other.
#[test]
fn maps_and_colours_are_looked_up_at_the_uv() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("ball.obj"), sphere("ball")).unwrap();
    image(path, "density.png", png::ColorType::Grayscale, &[51, 204]);
    image(path, "length.png", png::ColorType::Rgb, &[255, 255, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    image(path, "color.png", png::ColorType::Rgb, &[255, 0, 0, 20, 20, 20]);
    let args = ["groom", "grow", "ball.obj", "--segments", "3", "--density", "400", "-o", "a.usda"];
    run(path, &[&args[..], &["--density-map", "density.png", "--color", "color.png"]].concat());
    let scene = read(path, "a.usda");
    let strands = &scene.strands[0];
    // u increases from +z toward +x, so the right half is at x < 0. The mean density is a half of 400.
    let n = strands.len() as f64;
    let half = 0.5 * 400.0 * 16.0 * std::f64::consts::PI;
    assert!((n / half - 1.0).abs() < 0.015, "{n} against {half}");
    let uv = strands.root_uv.as_ref().unwrap();
    let dense = uv.iter().filter(|uv| uv.x > 0.5).count() as f64 / n;
    // With bilinear interpolation between pixel centres, the mean over the right half is 0.8 − 0.6 · 1/8 · 2 = 0.65 of
    // 1.
    assert!((dense - 0.65).abs() < 4.0 * (0.65 * 0.35 / n).sqrt() + 0.005, "{dense}");
    let [(vellus_scene::Parameter::Reflectance, value)] = scene.looks[0].textured[..] else {
        panic!("{:?}", scene.looks)
    };
    let dye = &scene.textures[value.texture];
    assert!(
        dye.pixels.get(0)[0] > 0.99 && dye.pixels.get(0)[1] < 0.01 && dye.pixels.get(1)[0] < 0.01,
        "{:?}",
        dye.pixels
    );
    assert!(scene.surfaces[0].color.texture.is_some());

    run(path, &[&args[..], &["--length-map", "length.png", "--length", "0.5"]].concat());
    let bald = read(path, "a.usda");
    // Only the first of four pixels and half of its neighbours grow fur.
    let is_bald = |uv: &glam::Vec2| uv.x > 0.3751 && uv.x < 0.8749;
    assert!(!bald.strands[0].root_uv.as_ref().unwrap().iter().any(is_bald));
    let lengths = vellus_groom::measure(&bald.strands[0]).unwrap().lengths;
    // Guard hairs are 1.4 times longer, lengths vary by a quarter, and waves add a little.
    assert!(lengths[0] > 0.0 && lengths[2] < 0.5 * 1.4 * 1.25 * 1.1, "{lengths:?}");
}

#[test]
fn settings_files_have_groups_and_options_override_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("ball.obj"), sphere("ball") + &sphere("eye").replace("f ", "#")).unwrap();
    let coat = "[[group]]\nname = \"undercoat\"\ncount = 900\nlength = 0.4\n
        [[group]]\nname = \"guard\"\ncount = 100\nlength = 0.9\nfiber = \"raccoon\"\nwidth = 0.02\nclump = 0\ncomb = [1, 0, 0]";
    std::fs::write(path.join("coat.toml"), coat).unwrap();
    let args = ["groom", "grow", "ball.obj", "--settings", "coat.toml", "-o", "a.usda"];
    run(path, &[&args[..], &["--noise", "0", "--basis", "linear"]].concat());
    let scene = read(path, "a.usda");
    let [undercoat, guard] = &scene.strands[..] else { panic!("{}", scene.strands.len()) };
    assert_eq!(
        (undercoat.name.as_str(), undercoat.len(), guard.name.as_str(), guard.len()),
        ("undercoat", 900, "guard", 100)
    );
    assert_eq!(guard.basis, vellus_scene::Basis::Linear);
    assert_eq!(scene.looks[guard.look].fiber, vellus::Fiber::preset(vellus::Species::Raccoon));
    let measures = vellus_groom::measure(guard).unwrap();
    assert!((measures.widths[1] - 0.02).abs() < 0.0031 && measures.lengths[2] <= 0.9 * 1.2501, "{measures:?}");
    // The input already has fur. Its meshes, units and fur are kept.
    let usd = std::fs::read_to_string(path.join("a.usda"))
        .unwrap()
        .replace("upAxis = \"Y\"", "metersPerUnit = 1\n    upAxis = \"Z\"")
        + "def BasisCurves \"thin\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
            point3f[] points = [(0,0,0), (1,0,0)] }";
    std::fs::write(path.join("z.usda"), usd).unwrap();
    run(
        path,
        &[
            "groom",
            "grow",
            "z.usda",
            "--count",
            "50",
            "--name",
            "more",
            "--gravity",
            "9",
            "--spread",
            "0",
            "-o",
            "b.usda",
        ],
    );
    let more = read(path, "b.usda");
    assert_eq!((more.strands.len(), more.strands[2].len()), (3, 50));
    assert_eq!(more.units, Some(vellus_scene::Units { meters_per_unit: 1.0, z_up: true }));
    let falls = |i: usize| {
        let strand = more.strands[2].strand(i);
        (strand[strand.len() - 2] - strand[1]).z
    };
    assert!((0..50).filter(|&i| falls(i) < 0.0).count() > 35, "z is up: strands hang toward −z");
    assert!(run(path, &["groom", "info", "b.usda"]).contains("metres, z up"));
}

#[test]
fn bad_requests_are_refused_with_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("ball.obj"), sphere("ball")).unwrap();
    std::fs::write(path.join("two.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\no left\nf 1 2 3\no right\nf 1 2 3\n").unwrap();
    std::fs::write(path.join("flat.obj"), "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").unwrap();
    std::fs::write(path.join("bad.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    std::fs::write(path.join("nan.obj"), "v nan 0 0\n").unwrap();
    std::fs::write(path.join("none.toml"), "").unwrap();
    std::fs::write(path.join("typo.toml"), "[[group]]\nlenght = 1").unwrap();
    image(path, "map.png", png::ColorType::Grayscale, &[0, 0]);
    let refuse = |args: &[&str], parts: &[&str]| refused(path, &[&["groom", "grow"], args].concat(), parts);
    refuse(&["ball.obj", "-o", "a.ply"], &["a.ply", "end in .usda or .usdc"]);
    refuse(&["none.obj"], &["cannot read none.obj"]);
    refuse(&["none.usda"], &["none.usda"]);
    refuse(&["two.obj"], &["2 meshes", "left, right", "--on"]);
    refuse(&["two.obj", "--on", "middle"], &["no mesh 'middle'", "left, right"]);
    refuse(&["flat.obj"], &["no triangle has both an area and a density"]);
    refuse(&["bad.obj"], &["bad.obj, line 2", "no vertex 2 of the 1"]);
    refuse(&["nan.obj"], &["nan.obj, line 1", "nan is not a finite number"]);
    refuse(&["ball.obj", "--density", "-1"], &["density = -1", "above 0"]);
    refuse(&["ball.obj", "--density", "0"], &["density = 0", "above 0"]);
    refuse(&["ball.obj", "--density", "1e-9"], &["no strand at all"]);
    refuse(&["ball.obj", "--density", "1e12"], &["too many"]);
    refuse(&["ball.obj", "--count", "9", "--density", "9"], &["cannot be used with"]);
    refuse(&["ball.obj", "--length", "0"], &["length = 0", "above 0"]);
    refuse(&["ball.obj", "--length", "nan"], &["length = NaN"]);
    refuse(&["ball.obj", "--taper", "2"], &["taper = 2", "[0, 1]"]);
    refuse(&["ball.obj", "--lift", "100"], &["lift = 100", "[-90, 90] degrees"]);
    refuse(&["ball.obj", "--segments", "0"], &["--segments", "[1, 65536]"]);
    refuse(&["ball.obj", "--basis", "nice"], &["nice", "catmull-rom"]);
    refuse(&["ball.obj", "--comb", "1,2"], &["X,Y,Z"]);
    refuse(&["ball.obj", "--fiber", "yeti"], &["yeti"]);
    refuse(&["ball.obj", "--density-map", "none.png"], &["none.png"]);
    refuse(&["ball.obj", "--density-map", "map.png"], &["no triangle has both"]);
    refuse(&["two.obj", "--on", "left", "--density-map", "map.png"], &["left has no uv", "map.png"]);
    refuse(&["ball.obj", "--settings", "none.toml"], &["none.toml", "group"]);
    refuse(&["ball.obj", "--settings", "typo.toml"], &["typo.toml", "lenght", "length"]);
    assert!(!path.join("out/groom.usda").exists());
}
