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
