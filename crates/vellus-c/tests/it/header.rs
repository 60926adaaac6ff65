//! The header in the repository, and the program of bad input. That the header is the one of the code is a test in
//! `lab/header`, because the tool that makes it takes long to compile.

use std::path::Path;

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
