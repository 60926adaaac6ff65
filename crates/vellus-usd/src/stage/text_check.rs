//! Checks of a layer of text (.usda) before it is parsed: how deep it is, and what prims are called.

use super::names::{check_default, check_name, check_path};

/// Far more than a scene has, far less than a stack holds: the parser calls itself for whatever is in brackets.
const DEEPEST_BRACKETS: u32 = 500;

/// The last two words outside strings, which say what a string after them is.
#[derive(Default)]
struct Words<'a>([&'a str; 2]);

impl<'a> Words<'a> {
    fn push(&mut self, word: &'a str) {
        self.0 = [self.0[1], word];
    }

    /// What a string that comes now is checked by: it may be the name of a prim (`def Type "name"`, `def "name"`).
    fn check(&self, string: &str) -> Result<(), String> {
        let [first, last] = self.0;
        let specifier = |word| matches!(word, "def" | "over" | "class");
        match (first, last) {
            ("defaultPrim", "=") => check_default(string),
            (_, "=") => Ok(()),
            _ if specifier(first) || specifier(last) => check_name(string),
            _ => Ok(()),
        }
    }
}

/// Checks a layer of text. What is no text at all is left to the parser.
pub(super) fn check_text(bytes: &[u8]) -> Result<(), String> {
    let mut rest = bytes;
    let mut depth = 0u32;
    let mut words = Words::default();
    while let Some(&first) = rest.first() {
        let used = match first {
            b'#' => until(rest, 1, b"\n"),
            b'"' | b'\'' => {
                let fence = [first; 3];
                let fence = if rest.starts_with(&fence) { &fence[..] } else { &fence[..1] };
                let used = until(rest, fence.len(), fence);
                let content = rest.get(fence.len()..used.saturating_sub(fence.len())).unwrap_or_default();
                words.check(&String::from_utf8_lossy(content)).map_err(|what| at(bytes, rest, &what))?;
                words.push("");
                used
            }
            b'@' => {
                let fence: &[u8] = if rest.starts_with(b"@@@") { b"@@@" } else { b"@" };
                until(rest, fence.len(), fence)
            }
            b'<' => {
                let used = until(rest, 1, b">");
                let path = rest.get(1..used - 1).unwrap_or_default();
                check_path(&String::from_utf8_lossy(path)).map_err(|what| at(bytes, rest, &what))?;
                used
            }
            b'(' | b'[' | b'{' => {
                depth += 1;
                if depth > DEEPEST_BRACKETS {
                    return Err(format!("it has more than {DEEPEST_BRACKETS} brackets in one another"));
                }
                words.push("");
                1
            }
            b')' | b']' | b'}' => {
                depth = depth.saturating_sub(1);
                1
            }
            b'=' => {
                words.push("=");
                1
            }
            c if c.is_ascii_alphabetic() || c == b'_' => {
                let is_in = |c: &u8| c.is_ascii_alphanumeric() || *c == b'_' || *c == b':';
                let used = rest.iter().position(|c| !is_in(c)).unwrap_or(rest.len());
                words.push(std::str::from_utf8(&rest[..used]).unwrap_or_default());
                used
            }
            _ => 1,
        };
        rest = &rest[used..];
    }
    Ok(())
}

/// How much there is from the start to the end of the next `fence` after `from`; a backslash hides what follows it.
fn until(text: &[u8], from: usize, fence: &[u8]) -> usize {
    let mut i = from;
    while i < text.len() {
        if text[i..].starts_with(fence) {
            return i + fence.len();
        }
        i += if text[i] == b'\\' && matches!(fence[0], b'"' | b'\'') { 2 } else { 1 };
    }
    text.len()
}

fn at(whole: &[u8], rest: &[u8], what: &str) -> String {
    let line = 1 + whole[..whole.len() - rest.len()].iter().filter(|&&b| b == b'\n').count();
    format!("line {line}: {what}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_paths_are_checked_where_they_are_names_and_paths() {
        let good = "#usda 1.0\n( doc = \"\"\"} // </a}> ((( \"\"\" defaultPrim = \"b\" )\n# def \"a}\" </a}>
def Xform \"b\" ( references = @./a}<.usda@</b> ) { string s = \"it's } \\\" </\" rel r = [</b>, <../c{v=x}d>] }
over \"c\" { asset a = @@@x</a}>@@@ string def = 'a}' }";
        assert_eq!(check_text(good.as_bytes()), Ok(()));
        let bad =
            ["def Xform \"a}\" {}", "over \"\" {}", "class \"a b\" {}", "rel r = </a}>", "( defaultPrim = 'a}' )"];
        for text in bad {
            let error = check_text(format!("#usda 1.0\n\n{text}").as_bytes()).unwrap_err();
            assert!(error.starts_with("line 3: "), "{text}: {error}");
        }
        assert!(check_text("[".repeat(501).as_bytes()).unwrap_err().contains("more than 500 brackets"));
        assert_eq!(check_text(format!("# {0}\n\"{0}\"", "[".repeat(900)).as_bytes()), Ok(()));
        // Whatever is cut off ends.
        for text in ["\"", "'''", "<", "@", "@@@", "\"\\", "def \"", "#", "<\\"] {
            let _ = check_text(text.as_bytes());
        }
    }
}
