//! The fibres that --fiber and --set give to strands, and the warnings when they change nothing.

use crate::common::{Limited, command, run, vellus};
use std::path::Path;
use vellus::{Fiber, Species};

/// A curve. `material` binds a material or is empty.
fn scene(material: &str) -> String {
    format!(
        "#usda 1.0
def BasisCurves \"curl\" (prepend apiSchemas = [\"MaterialBindingAPI\"]) {{
    uniform token type = \"linear\"
    int[] curveVertexCounts = [2]
    float[] widths = [0.1] (interpolation = \"constant\")
    point3f[] points = [(0, 0, 0), (1, 0, 0)]
    {material}
}}
def Material \"Pelt\" {{
    token outputs:surface.connect = </Pelt/Fur.outputs:surface>
    def Shader \"Fur\" {{
        uniform token info:id = \"VellusFur\"
        token inputs:preset = \"cat\"
        token outputs:surface
    }}
}}
"
    )
}

/// Whether two fibres are equal up to the last bits of angles, which files store in degrees.
fn same(a: Fiber, b: Fiber) -> bool {
    let angles = |f: Fiber| [f.alpha, f.beta_m, f.beta_n];
    let rest = |f: Fiber| Fiber { alpha: 0.0, beta_m: 0.0, beta_n: 0.0, ..f };
    rest(a) == rest(b) && angles(a).iter().zip(angles(b)).all(|(a, b)| (a - b).abs() < 1e-6)
}

fn is_preset(fiber: Fiber, species: Species) -> bool {
    same(fiber, Fiber::preset(species))
}

/// The fibre of the only look of a scene.
fn fiber(path: &Path) -> Fiber {
    let reading = vellus_usd::read(path, &vellus_usd::Options::default()).unwrap();
    let [look] = &reading.scene.looks[..] else { panic!("{:?}", reading.scene.looks) };
    look.fiber
}

#[test]
fn a_warning_says_that_materials_of_the_file_take_precedence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("bound.usda"), scene("rel material:binding = </Pelt>")).unwrap();
    std::fs::write(path.join("free.usda"), scene("")).unwrap();
    let convert = |file: &str, more: &[&str]| {
        let said = run(path, &[&["groom", "convert", file, "-o", "out.usda"], more].concat());
        (said, fiber(&path.join("out.usda")))
    };
    for given in [&["--fiber", "dog"][..], &["--set", "kappa=0.1"], &["--fiber", "red-fox"]] {
        let (said, fiber) = convert("bound.usda", given);
        assert!(said.contains("bound.usda: --fiber and --set are ignored") && said.contains("Pelt"), "{said}");
        assert!(said.contains("--override") && is_preset(fiber, Species::Cat), "{said} {fiber:?}");
    }
    // With --override, a fibre replaces that of the file, and a parameter alone keeps the others.
    let (said, fiber) = convert("bound.usda", &["--override", "--fiber", "dog"]);
    assert!(said.is_empty() && is_preset(fiber, Species::Dog), "{said} {fiber:?}");
    let (_, fiber) = convert("bound.usda", &["--override", "--set", "kappa=0.1"]);
    assert!(same(fiber, Fiber { kappa: 0.1, ..Fiber::preset(Species::Cat) }), "{fiber:?}");
    for (file, given, species) in [
        ("bound.usda", &[][..], Species::Cat),
        ("free.usda", &["--fiber", "dog"], Species::Dog),
        ("free.usda", &[], Species::RedFox),
    ] {
        let (said, fiber) = convert(file, given);
        assert!(said.is_empty() && is_preset(fiber, species), "{file}: {said} {fiber:?}");
    }
}

#[test]
fn grown_fur_has_the_fibre_that_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("leaf.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(path.join("cat.toml"), "[[group]]\nfiber = \"cat\"\ncount = 9").unwrap();
    let grow = |more: &[&str]| {
        run(path, &[&["groom", "grow", "leaf.obj", "-o", "out.usda"], more].concat());
        fiber(&path.join("out.usda"))
    };
    // The default fibre of other commands can be named like any other.
    assert!(is_preset(grow(&["--count", "9", "--fiber", "red-fox"]), Species::RedFox));
    assert!(is_preset(grow(&["--count", "9", "--fiber", "dog"]), Species::Dog));
    let brown = grow(&["--count", "9"]);
    assert_eq!(brown.kappa, Fiber::preset(Species::Dog).kappa);
    assert!(brown.sigma_ca[0] < brown.sigma_ca[1] && brown.sigma_ca[1] < brown.sigma_ca[2], "{brown:?}");
    // Overrides change only the parameters that they name, and the absorption that gives the same brown.
    let thin = grow(&["--count", "9", "--set", "beta_m=3"]);
    let Fiber { beta_m, sigma_ca, sigma_ma, .. } = brown;
    assert!(same(Fiber { beta_m, sigma_ca, sigma_ma, ..thin }, brown));
    assert!((thin.beta_m - 3f32.to_radians()).abs() < 1e-6 && (thin.sigma_ca[2] / sigma_ca[2] - 1.0).abs() < 0.1);
    assert_eq!(grow(&["--count", "9", "--set", "sigma_ca=0.25"]).sigma_ca, [0.25; 3]);
    // Options have priority over the settings file.
    assert!(is_preset(grow(&["--settings", "cat.toml"]), Species::Cat));
    assert!(is_preset(grow(&["--settings", "cat.toml", "--fiber", "red-fox"]), Species::RedFox));
}

#[test]
fn help_states_the_default_fibre_of_each_command() {
    let folder = tempfile::tempdir().unwrap();
    for (command, default) in [
        (&["eval"][..], "[default: red-fox]"),
        (&["plot", "lobes"], "[default: red-fox]"),
        (&["render"], "It replaces the fibres of a built-in scene"),
        (&["groom", "grow"], "[default: a brown dog]"),
    ] {
        let help = vellus(folder.path(), &[command, &["--help"]].concat()).stdout;
        let help = String::from_utf8(help).unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
        let fiber = help.split("--fiber <NAME|FILE> ").nth(1).unwrap();
        let fiber = fiber.split(" --").next().unwrap();
        assert!(fiber.contains(default), "{command:?}: {fiber}");
    }
}

/// File names are bytes. Messages print them as text. Only USD requires names that are text.
#[cfg(target_os = "linux")]
#[test]
fn names_of_files_need_not_be_utf8() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let [hair, toml] = [&b"h\xffir.hair"[..], b"f\xffr.toml"].map(OsStr::from_bytes);
    std::fs::write(path.join("free.usda"), scene("")).unwrap();
    run(path, &["groom", "convert", "free.usda", "-o", "hair.hair"]);
    std::fs::rename(path.join("hair.hair"), path.join(hair)).unwrap();
    std::fs::write(path.join(toml), "preset = \"dog\"\n").unwrap();
    let with_both = |args: &[&str]| command(path, args).arg(hair).arg("--fiber").arg(toml).run().unwrap();
    for args in [
        &["groom", "convert", "-o", "out.usda"][..],
        &["render", "--size", "8x8", "--spp", "1", "--float", "-o", "out.exr"],
    ] {
        let output = with_both(args);
        assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
    assert!(is_preset(fiber(&path.join("out.usda")), Species::Dog));
    let (picture, name) = (std::fs::read(path.join("out.exr")).unwrap(), "h\u{fffd}ir.hair".as_bytes());
    assert!(picture.windows(name.len()).any(|window| window == name));
}
