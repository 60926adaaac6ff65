//! The header of the C interface is the one that cbindgen makes of the code.

use std::path::Path;

/// To write the header again: `VELLUS_WRITE_HEADER=1 cargo test -p vellus-header` in `lab/`.
#[test]
fn the_header_belongs_to_the_code() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/vellus-c");
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for module in ["status", "window", "frame", "memory", "parameters", "query", "fiber", "hit", "array", "shader"] {
        builder = builder.with_src(folder.join(format!("src/{module}.rs")));
    }
    let mut text = Vec::new();
    builder.generate().unwrap().write(&mut text);
    let text = String::from_utf8(text).unwrap();
    let path = folder.join("include/vellus.h");
    if std::env::var_os("VELLUS_WRITE_HEADER").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    assert!(stored == text, "include/vellus.h is old: run this test with VELLUS_WRITE_HEADER=1");
}
