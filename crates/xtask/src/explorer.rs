//! The fibre explorer: one HTML file with the web modules of `vellus-views` and the model as WebAssembly.
//!
//! The file loads nothing, so it works from a disk and from any static server. `target/wasm` keeps the standard library
//! that `-Z build-std` compiles, which takes minutes.

use crate::run::{output, run, succeeds};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

const TARGET: &str = "wasm32-unknown-unknown";

/// The modules, in the order of their imports.
const MODULES: [&str; 3] = ["fiber-panel.js", "fiber-views.js", "explorer.js"];

/// Where Debian's `rustc-web` and `cargo-web` are.
const DEBIAN: &str = "/usr/bin";

/// The file of the page.
const PAGE: &str = "index.html";

/// Builds the page in `target/explorer`, and copies it into the book if that is there. Prints the file and its size.
pub fn build(root: &Path) -> Result<(), String> {
    let wasm = compile(root)?;
    let wasm = std::fs::read(&wasm).map_err(|e| format!("{}: {e}", wasm.display()))?;
    let page = page(&root.join("crates/vellus-views/web"), &wasm)?;
    let folder = root.join("target/explorer");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let file = folder.join(PAGE);
    std::fs::write(&file, &page).map_err(|e| format!("{}: {e}", file.display()))?;
    println!("target/explorer/{PAGE}: {} bytes; the model has {} before compression", page.len(), wasm.len());
    if root.join("target/book").is_dir() {
        copy_into_book(root)?;
        println!("target/book/explorer/{PAGE}: the same");
    }
    Ok(())
}

/// Copies the page into the book, if both have been built. mdBook empties the book's folder first.
pub fn copy_into_book(root: &Path) -> Result<(), String> {
    let page = root.join("target/explorer").join(PAGE);
    if !page.exists() {
        return Ok(());
    }
    let folder = root.join("target/book/explorer");
    let copied = std::fs::create_dir_all(&folder).and_then(|()| std::fs::copy(&page, folder.join(PAGE)));
    copied.map(|_| ()).map_err(|e| format!("{}: {e}", folder.display()))
}

/// Why the page cannot be built here, if no compiler for WebAssembly exists. Rustup adds its target if it can.
pub fn missing(root: &Path) -> Option<String> {
    let debian = ["rustc", "cargo", "../lib/rustlib/src/rust/library"].map(|name| Path::new(DEBIAN).join(name));
    let has_debian = debian.iter().all(|path| path.exists()) && succeeds(Command::new("wasm-ld").arg("--version"));
    (!has_target(root) && !has_debian).then(|| {
        format!(
            "no compiler for {TARGET}: run `rustup target add {TARGET}`, \
             or `apt install rustc-web cargo-web rust-web-src lld`"
        )
    })
}

/// Whether the compiler has the standard library of the target, possibly after rustup has added it.
fn has_target(root: &Path) -> bool {
    let library = ["--print", "target-libdir", "--target", TARGET];
    let found = output(Command::new("rustc").args(library).current_dir(root));
    found.is_ok_and(|library| Path::new(library.trim()).is_dir())
        || succeeds(Command::new("rustup").args(["target", "add", TARGET]).current_dir(root))
}

/// Compiles the module: with rustup's target, or with Debian's compiler and its source of the standard library.
pub fn compile(root: &Path) -> Result<PathBuf, String> {
    if let Some(reason) = missing(root) {
        return Err(reason);
    }
    let folder = root.join("target/wasm");
    let mut cargo = Command::new("cargo");
    let mut more = Vec::new();
    if !has_target(root) {
        cargo = Command::new(Path::new(DEBIAN).join("cargo"));
        // This process may run under another cargo, which names its own compiler.
        cargo.env("RUSTC", Path::new(DEBIAN).join("rustc")).env_remove("RUSTUP_TOOLCHAIN").env_remove("CARGO");
        cargo.env("RUSTC_BOOTSTRAP", "1").env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", "wasm-ld");
        more = vec!["-Z", "build-std=std,panic_abort"];
    }
    cargo.env("RUSTFLAGS", "-C target-feature=+simd128").current_dir(root);
    // Answers are JSON. The workspace does not optimize serde_json.
    cargo.args(["rustc", "--release", "--target", TARGET, "--package", "vellus-views", "--crate-type", "cdylib"]);
    cargo.args(["--config", "profile.release.package.serde_json.opt-level=2", "--target-dir"]).arg(&folder).args(more);
    run(cargo.args(["--", "-C", "strip=symbols"]))?;
    Ok(folder.join(TARGET).join("release/vellus_views.wasm"))
}

/// The page with its style, modules and WebAssembly inside.
fn page(web: &Path, wasm: &[u8]) -> Result<String, String> {
    let read = |name: &str| std::fs::read_to_string(web.join(name)).map_err(|e| format!("{name}: {e}"));
    let mut script = String::new();
    for name in MODULES {
        script.push_str(&plain_script(&read(name)?));
    }
    let style = format!("<style>\n{}</style>", read("style.css")?);
    let packed = gzip(wasm).map_err(|e| format!("compressing the model: {e}"))?;
    let data = format!("<script type=\"text/plain\" id=\"vellus-wasm\">{}</script>", base64(&packed));
    let script = format!("{data}\n<script type=\"module\">\n{script}</script>");
    let mut page = read("explorer.html")?;
    for (link, text) in [
        ("<link rel=\"stylesheet\" href=\"style.css\">", style),
        ("<script type=\"module\" src=\"explorer.js\"></script>", script),
    ] {
        if page.matches(link).count() != 1 {
            return Err(format!("explorer.html has {link} {} times, not once", page.matches(link).count()));
        }
        page = page.replace(link, &text);
    }
    Ok(page)
}

/// A module without imports and exports: all are in one script.
fn plain_script(module: &str) -> String {
    let lines = module.lines().filter(|line| !line.starts_with("import "));
    lines.map(|line| format!("{}\n", line.strip_prefix("export ").unwrap_or(line))).collect()
}

/// Compressed bytes (RFC 1952), which browsers unpack. That halves the page.
fn gzip(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// Base64 with padding (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let all = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let letter = LETTERS[(all >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= three.len() { letter as char } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_has_four_letters_for_three_bytes_and_is_padded() {
        for (bytes, text) in [("", ""), ("a", "YQ=="), ("ab", "YWI="), ("abc", "YWJj"), ("abca", "YWJjYQ==")] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn the_page_contains_all_modules_and_loads_nothing() {
        let web = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vellus-views/web");
        let page = page(&web, b"\0asm").unwrap();
        // H4sI are the first three bytes of every compressed file.
        let module = page.contains("id=\"vellus-wasm\">H4sI");
        assert!(module && page.contains("\nasync function createFiberPanel"), "a part is missing");
        for loaded in ["\nimport ", "\nexport ", "src=\"", "href=\"style"] {
            assert!(!page.contains(loaded), "{loaded:?} is left");
        }
        // A second declaration of a name would be an error of the whole script.
        let mut names = declared(&page);
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count, "{names:?}");
    }

    /// The names that a script declares at its top level.
    fn declared(page: &str) -> Vec<&str> {
        let starts = ["const ", "let ", "function ", "async function "];
        let rest = page.lines().filter_map(|line| starts.iter().find_map(|start| line.strip_prefix(start)));
        rest.filter_map(|rest| rest.split([' ', '(', '=']).next()).collect()
    }
}
