//! The header in the repository is the one that cbindgen makes of the code.

use std::path::Path;

/// To write the header anew: `VELLUS_WRITE_HEADER=1 cargo test -p vellus-c header`.
#[test]
fn the_header_belongs_to_the_code() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for module in ["status", "window", "memory", "parameters", "query", "fiber", "hit", "array"] {
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

/// The names of all functions of the header, with the number of their pointers.
fn functions(header: &str) -> Vec<(String, usize)> {
    let code: String = header.lines().filter(|line| !line.starts_with("//")).flat_map(|line| [line, " "]).collect();
    let declarations = code.split(';').filter_map(|part| {
        let (before, arguments) = part.trim_end().strip_suffix(')')?.split_once('(')?;
        let name = before.rsplit([' ', '*']).next()?;
        name.starts_with("vellus_")
            .then(|| (name.to_owned(), arguments.split(',').filter(|argument| argument.contains('*')).count()))
    });
    declarations.collect()
}

/// The program of bad input calls every function, with a null pointer for each of its pointers.
#[test]
fn bad_input_has_every_function_and_pointer() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let functions = functions(&std::fs::read_to_string(folder.join("include/vellus.h")).unwrap());
    assert!(functions.len() > 30, "{functions:?}");
    let program = std::fs::read_to_string(folder.join("tests/bad_input.c")).unwrap();
    for (name, pointers) in functions {
        // Those that free take null.
        let call = if name.ends_with("_free") { format!("{name}(NULL)") } else { format!("{name}(") };
        assert!(program.contains(&call), "{name}");
        let nulls = program.matches(&format!("NULL_POINTER({name}(")).count();
        assert!(name.ends_with("_free") || nulls >= pointers, "{name}: {nulls} null pointers of {pointers}");
    }
}
