//! Text for a terminal.

/// Replaces control characters, line breaks among them, and characters that change the direction of text by their
/// escapes. Messages quote files, whose control characters could change the terminal, and whose lines could be taken
/// for lines of the program.
pub fn visible(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() && c != '\t' || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}') {
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
        assert_eq!(visible("name\0 =\u{1b}[31m\t'é'"), "name\\u{0} =\\u{1b}[31m\t'é'");
        assert_eq!(visible("a\ntouch x\r\n\u{202e}txt\u{85}"), "a\\ntouch x\\r\\n\\u{202e}txt\\u{85}");
    }
}
