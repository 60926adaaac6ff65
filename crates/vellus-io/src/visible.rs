//! Text for a terminal.

/// Replaces control characters by their escapes. Messages quote files, whose control characters could change the
/// terminal.
pub fn visible(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() && !matches!(c, '\n' | '\t') {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped() {
        assert_eq!(visible("name\0 =\u{1b}[31m\t'é'\n"), "name\\u{0} =\\u{1b}[31m\t'é'\n");
    }
}
