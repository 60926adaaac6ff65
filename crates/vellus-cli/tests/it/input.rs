//! Messages about files that the command reads.

use crate::common::{refused, run, tfx, vellus};

#[test]
fn strands_without_widths_are_measured_and_rendered_with_a_suggested_width() {
    let folder = tempfile::tempdir().unwrap();
    let guides = [0.0, 1.0].map(|y| vec![[0.0, y, 0.0], [3.0, y, 0.0]]);
    std::fs::write(folder.path().join("guides.tfx"), tfx(&guides)).unwrap();
    let output = vellus(folder.path(), &["groom", "info", "guides.tfx"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.contains("(0, 0, 0) to (3.00000, 1.00000, 0)"), "{text}");
    // Six times the width of a hair for this size: two guide strands cover little.
    assert!(text.contains("--width, 0.006 for example"), "{text}");
    let said = run(folder.path(), &["render", "guides.tfx", "-o", "a.png", "--size", "9x6", "--spp", "1"]);
    assert!(said.contains("warning: guides.tfx has no widths: it is rendered with --width 0.006"), "{said}");
    refused(
        folder.path(),
        &["groom", "convert", "guides.tfx", "-o", "a.usda"],
        &["guides.tfx has no widths", "--width"],
    );
    refused(folder.path(), &["groom", "info", "guides.tfx", "--width", "1e30"], &["the width", "[0, 2e9]"]);
}

/// A .hair file of three points with a thickness in its header.
fn thick_hair() -> Vec<u8> {
    let mut bytes = vec![0; 128];
    bytes[..4].copy_from_slice(b"HAIR");
    for (at, word) in [(4, 1u32), (8, 3), (12, 2), (16, 2), (20, 0.1f32.to_bits()), (24, 0.5f32.to_bits())] {
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
    }
    bytes.extend((0..9u16).flat_map(|i| f32::from(i).to_le_bytes()));
    bytes
}

#[test]
fn the_width_in_the_header_of_a_hair_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("thick.hair"), thick_hair()).unwrap();
    let info = |more: &[&str]| {
        let output = vellus(folder.path(), &[&["groom", "info", "thick.hair"], more].concat());
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (text, said) = info(&[]);
    for part in [
        "0.100000 to 0.100000 (default of the file)",
        "(-0.0500000, 0.950000, 1.95000) to (6.05000, 7.05000, 8.05000)",
        "transparency 0.5, default colour 0 0 0",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(said.contains("thick.hair: the width is 0.1, the default of the file (--width replaces it)"), "{said}");
    assert!(said.contains("warning: thick.hair: transparency is not supported"), "{said}");
    let said = run(folder.path(), &["render", "thick.hair", "-o", "a.png", "--size", "9x6", "--spp", "1"]);
    assert!(said.contains("the width is 0.1, the default of the file"), "{said}");
    let (text, said) = info(&["--width", "0.5"]);
    assert!(text.contains("0.500000 to 0.500000\n") && !said.contains("the width is"), "{text}{said}");
}

#[test]
fn what_a_hair_file_cannot_hold_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let said = run(folder.path(), &["groom", "convert", "hair-lock", "--small", "-o", "lock.hair"]);
    assert!(said.contains("warning: lock.hair does not have the fibre hair, "), "{said}");
}

/// An animation has a range of frames and a rate, in files of both formats.
#[test]
fn animations_are_described() {
    let folder = tempfile::tempdir().unwrap();
    let strands = "(
    startTimeCode = 3
    endTimeCode = 12.5
    timeCodesPerSecond = 30
)
def BasisCurves \"fox\" {
    uniform token type = \"linear\"
    int[] curveVertexCounts = [2]
    point3f[] points = [(0, 0, 0), (0, 1, 0)]
    float[] widths = [0.1] ( interpolation = \"constant\" )
}
";
    std::fs::write(folder.path().join("a.usda"), format!("#usda 1.0\n{strands}")).unwrap();
    let said = |path| {
        let output = vellus(folder.path(), &["groom", "info", path]);
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(said("a.usda").starts_with("time      frames 3 to 12.5, 30 a second\nunits"), "{}", said("a.usda"));
    // What does not move has no frames.
    run(folder.path(), &["groom", "convert", "a.usda", "-o", "a.abc"]);
    assert!(said("a.abc").starts_with("units"), "{}", said("a.abc"));
}

/// Devices have no end.
#[cfg(unix)]
#[test]
fn devices_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.hair", "a.tfx", "a.usda"] {
        std::os::unix::fs::symlink("/dev/zero", folder.path().join(name)).unwrap();
        refused(folder.path(), &["groom", "info", name], &[name, "it is a device"]);
    }
    std::os::unix::fs::symlink("/dev/urandom", folder.path().join("a.obj")).unwrap();
    refused(folder.path(), &["groom", "grow", "a.obj", "-o", "b.usda"], &["a.obj", "it is a device"]);
    refused(folder.path(), &["table", "info", "/dev/zero"], &["/dev/zero", "it is a device"]);
    refused(folder.path(), &["eval", "--queries", "/dev/zero"], &["/dev/zero", "it is a device"]);
}
