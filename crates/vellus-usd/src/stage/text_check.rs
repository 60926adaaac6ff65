//! Checks a text layer (.usda) before it is parsed: nesting depth, names of prims, and paths.
//!
//! It also finds numbers such as `.5` and `1.`, which Pixar's library reads but the parser of `openusd` does not.

use super::names::{check_default, check_name, check_path};
use crate::error::Invalid;

/// The deepest nesting of brackets. The parser is recursive, so a larger depth could overflow the stack.
const DEEPEST_BRACKETS: u32 = 500;

/// The last two words outside strings. They determine the meaning of the next string.
#[derive(Default)]
struct Words<'a>([&'a str; 2]);

impl<'a> Words<'a> {
    fn push(&mut self, word: &'a str) {
        self.0 = [self.0[1], word];
    }

    /// Checks the next string, which may be the name of a prim (`def Type "name"`, `def "name"`).
    fn check(&self, string: &str) -> Result<(), Invalid> {
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

/// The UTF-8 byte order mark that some editors write.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The same text without a byte order mark, and with a `0` inserted at each of these offsets. Line numbers do not
/// change.
pub(super) fn normalized(bytes: Vec<u8>, zeros: &[usize]) -> Vec<u8> {
    let start = if bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
    if start == 0 && zeros.is_empty() {
        return bytes;
    }
    let mut text = Vec::with_capacity(bytes.len() + zeros.len());
    let mut from = start;
    for &zero in zeros {
        text.extend_from_slice(&bytes[from..zero]);
        text.push(b'0');
        from = zero;
    }
    text.extend_from_slice(&bytes[from..]);
    text
}

/// The length of a number, and the offset at which it needs a `0`: the parser requires a digit after the point.
fn number(text: &[u8]) -> (usize, Option<usize>) {
    let digits = |from: usize| text[from..].iter().position(|c| !c.is_ascii_digit()).unwrap_or(text.len() - from);
    let mut used = digits(0);
    let mut zero = None;
    if text.get(used) == Some(&b'.') {
        used += 1;
        let decimals = digits(used);
        zero = (decimals == 0).then_some(used);
        used += decimals;
    }
    if matches!(text.get(used), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(text.get(used + 1), Some(b'+' | b'-')));
        let exponent = text.get(used + 1 + sign..).map_or(0, |_| digits(used + 1 + sign));
        used += if exponent > 0 { 1 + sign + exponent } else { 0 };
    }
    (used, zero)
}

/// Checks a text layer. Returns the offsets at which a `0` must be inserted, so that the parser accepts all numbers.
/// The parser reports bytes that are not text.
pub(super) fn check_text(bytes: &[u8]) -> Result<Vec<usize>, Invalid> {
    let mut rest = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let mut zeros = Vec::new();
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
                words.check(&String::from_utf8_lossy(content)).map_err(|invalid| at(bytes, rest, &invalid))?;
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
                check_path(&String::from_utf8_lossy(path)).map_err(|invalid| at(bytes, rest, &invalid))?;
                used
            }
            b'(' | b'[' | b'{' => {
                depth += 1;
                if depth > DEEPEST_BRACKETS {
                    return Err(format!("it has more than {DEEPEST_BRACKETS} brackets inside each other").into());
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
            c if c.is_ascii_digit() => {
                let (used, zero) = number(rest);
                zeros.extend(zero.map(|zero| bytes.len() - rest.len() + zero));
                used
            }
            b'.' if rest.get(1).is_some_and(u8::is_ascii_digit) => {
                zeros.push(bytes.len() - rest.len());
                1
            }
            _ => 1,
        };
        rest = &rest[used..];
    }
    Ok(zeros)
}

/// The number of bytes up to the end of the next `fence` after `from`. In a string, a backslash escapes the next byte.
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

fn at(whole: &[u8], rest: &[u8], invalid: &Invalid) -> Invalid {
    let line = 1 + whole[..whole.len() - rest.len()].iter().filter(|&&b| b == b'\n').count();
    format!("line {line}: {invalid}").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_paths_are_checked() {
        let good = "#usda 1.0\n( doc = \"\"\"} // </a}> ((( \"\"\" defaultPrim = \"b\" )\n# def \"a}\" </a}>
def Xform \"b\" ( references = @./a}<.usda@</b> ) { string s = \"it's } \\\" </\" rel r = [</b>, <../c{v=x}d>] }
over \"c\" { asset a = @@@x</a}>@@@ string def = 'a}' }";
        assert_eq!(check_text(good.as_bytes()), Ok(Vec::new()));
        let bad =
            ["def Xform \"a}\" {}", "over \"\" {}", "class \"a b\" {}", "rel r = </a}>", "( defaultPrim = 'a}' )"];
        for text in bad {
            let error = check_text(format!("#usda 1.0\n\n{text}").as_bytes()).unwrap_err();
            assert!(error.0.starts_with("line 3: "), "{text}: {error}");
        }
        assert!(check_text("[".repeat(501).as_bytes()).unwrap_err().0.contains("more than 500 brackets"));
        assert_eq!(check_text(format!("# {0}\n\"{0}\"", "[".repeat(900)).as_bytes()), Ok(Vec::new()));
        // Text that is cut off does not loop forever.
        for text in ["\"", "'''", "<", "@", "@@@", "\"\\", "def \"", "#", "<\\"] {
            let _ = check_text(text.as_bytes());
        }
    }

    #[test]
    fn numbers_get_the_digits_that_the_parser_requires() {
        let read = |text: &str| {
            let zeros = check_text(text.as_bytes()).unwrap();
            String::from_utf8(normalized(text.as_bytes().to_vec(), &zeros)).unwrap()
        };
        assert_eq!(read("[.1, -.5e3, 2., (3.e-4,.7)]"), "[0.1, -0.5e3, 2.0, (3.0e-4,0.7)]");
        assert_eq!(read("\u{feff}#usda 1.0\nfloat x = .5"), "#usda 1.0\nfloat x = 0.5");
        let same =
            "#usda 1.0 .5\nfloat a1.connect = </b.c>\nasset a = @./.5/1.@ string s = \".5 1.\" float b = 1.5e-07";
        assert_eq!(read(same), same);
        for end in ["1", "1.", "1.e", "1e", "1e+", ".", ".1"] {
            read(end);
        }
    }
}
