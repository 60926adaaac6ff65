//! The panic hook is not called for a panic that becomes an error. This test is a program of its own, because all
//! threads share one hook.

use std::panic::{catch_unwind, set_hook};
use std::sync::atomic::{AtomicUsize, Ordering};
use vellus_usd::{Options, quiet_caught_panics, read};

static HEARD: AtomicUsize = AtomicUsize::new(0);

#[test]
fn caught_panics_are_quiet_and_others_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let [text, file] = ["a.usda", "a.usdc"].map(|name| folder.path().join(name));
    let body = "#usda 1.0\ndef BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
        point3f[] points = [(0,0,0), (1,0,0)] float[] widths = [1, 1] }";
    std::fs::write(&text, body).unwrap();
    let stage = openusd::usd::Stage::builder().open(text.to_str().unwrap()).unwrap();
    stage.root_layer().export(file.to_str().unwrap()).unwrap();
    let whole = std::fs::read(&file).unwrap();
    let heard = || {
        let before = HEARD.load(Ordering::Relaxed);
        for at in (0..whole.len()).step_by(5) {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xff;
            std::fs::write(&file, bytes).unwrap();
            let _ = read(&file, &Options::default());
        }
        HEARD.load(Ordering::Relaxed) - before
    };
    set_hook(Box::new(|_| {
        HEARD.fetch_add(1, Ordering::Relaxed);
    }));
    assert!(heard() > 0, "the decoder does not panic any more: this crate need not catch it");
    quiet_caught_panics();
    assert_eq!(heard(), 0);
    let before = HEARD.load(Ordering::Relaxed);
    assert!(catch_unwind(|| panic!("not of a reader")).is_err());
    assert_eq!(HEARD.load(Ordering::Relaxed), before + 1);
}
