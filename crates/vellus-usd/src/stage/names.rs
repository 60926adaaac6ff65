//! Checks names of prims and paths.
//!
//! `openusd` goes from a prim to its parent by the last `/` or `}` of the path. For some invalid paths this is an
//! endless loop.

use crate::error::Invalid;

/// Checks the name of a prim. Pixar's library accepts the same names.
pub(super) fn check_name(name: &str) -> Result<(), Invalid> {
    if !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_') {
        return Ok(());
    }
    Err(format!("a prim is called {name:?}: a name has only letters, digits and underscores").into())
}

/// Checks the name of a property. A text layer has no others.
pub(super) fn check_property(name: &str) -> Result<(), Invalid> {
    if !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | ':') || !c.is_ascii()) {
        return Ok(());
    }
    Err(format!("a property is called {name:?}: a name has only letters, digits, underscores and colons").into())
}

/// Checks the default prim of a layer: a name, a path, or nothing.
pub(super) fn check_default(prim: &str) -> Result<(), Invalid> {
    let names = prim.strip_prefix('/').unwrap_or(prim);
    if names.is_empty() { Ok(()) } else { names.split('/').try_for_each(check_name) }
}

/// Checks a path. Braces, which select a variant, must come in pairs after a name. No name may be empty.
pub(super) fn check_path(path: &str) -> Result<(), Invalid> {
    let mut open = false;
    let mut previous = ' ';
    for c in path.chars() {
        let good = match c {
            '{' => !open && !matches!(previous, '/' | ' '),
            '}' => open,
            '/' if !open => previous != '/',
            _ => true,
        };
        if !good {
            return Err(format!("{path:?} is no path").into());
        }
        open = c == '{' || open && c != '}';
        previous = c;
    }
    if open { Err(format!("{path:?} is no path").into()) } else { Ok(()) }
}

/// The largest number of brackets, and of escaped characters, of a variable expression. Its parser is recursive.
const LONGEST_EXPRESSION: usize = 100;

/// Checks a string that may be a variable expression: `` `if(${A}, "x", "y")` ``. Returns its number of variables.
pub(super) fn check_expression(text: &str) -> Result<usize, Invalid> {
    if !text.starts_with('`') {
        return Ok(0);
    }
    for special in ["([{", "\\"] {
        if text.chars().filter(|&c| special.contains(c)).count() > LONGEST_EXPRESSION {
            return Err(format!("an expression has more than {LONGEST_EXPRESSION} of the characters {special}").into());
        }
    }
    Ok(text.matches('$').count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_properties_are_no_paths() {
        assert!(["a", "inputs:a_1", "größe"].iter().all(|name| check_property(name).is_ok()));
        assert!(["", "}", "a}b", "a.b", "a/b", "a b", "a[b]"].iter().all(|name| check_property(name).is_err()));
    }

    #[test]
    fn paths_have_pairs_of_braces_and_no_empty_names() {
        for good in ["", "/", "/a", "/a/b.c:d", "../x", "/a{v=x}", "/a{v=x}{w=}b/c.d", "/a.r[/b].c", "/ä_1"] {
            assert_eq!(check_path(good), Ok(()), "{good}");
        }
        for bad in ["/a}", "/a}b", "/a{v=x", "/a{v={}}", "/{v=x}", "//", "/a//b", "}"] {
            assert!(check_path(bad).is_err(), "{bad}");
        }
        assert!(["", "a", "/a/b"].iter().all(|prim| check_default(prim).is_ok()) && check_default("a/").is_err());
        assert!(check_name("tail_2").is_ok() && check_name("é").is_ok());
        assert!(["", "a}", "a/b", "a.b", "a b"].iter().all(|name| check_name(name).is_err()));
    }
}
