//! The tokens of a text layer: numbers, strings and the paths of files.

use crate::error::Invalid;
use std::borrow::Cow;

/// The largest number of quotation marks in a string, or of `@` in the path of a file: the parser recurses at each.
const MOST_FENCES: usize = 100;

/// The number of bytes up to the end of a line.
pub(super) fn end_of_line(rest: &[u8]) -> usize {
    rest.iter().position(|c| matches!(c, b'\n' | b'\r')).unwrap_or(rest.len())
}

/// The number of bytes up to the end of the next `fence` after `from`.
pub(in crate::stage) fn find(text: &[u8], from: usize, fence: &[u8]) -> Option<usize> {
    text[from..].windows(fence.len()).position(|window| window == fence).map(|i| from + i + fence.len())
}

/// The length of the path of a file with its fences, and the path.
pub(in crate::stage) fn asset(rest: &[u8]) -> Result<(usize, &[u8]), Invalid> {
    let fence: &[u8] = if rest.starts_with(b"@@@") { b"@@@" } else { b"@" };
    // The parser, too, ends at the first fence.
    let used = find(rest, fence.len(), fence).ok_or("the path of a file has no end")?;
    let path = &rest[fence.len()..used - fence.len()];
    if path.iter().filter(|&&c| c == b'@').count() > MOST_FENCES {
        return Err(format!("the path of a file has more than {MOST_FENCES} @").into());
    }
    Ok((used, path))
}

/// The length of a string with its fences, and its content: borrowed if the parser reads the same.
pub(in crate::stage) fn string(rest: &[u8]) -> Result<(usize, Cow<'_, [u8]>), Invalid> {
    let quote = rest[0];
    let fence = if rest.starts_with(&[quote; 3]) { &[quote; 3][..] } else { &[quote][..] };
    let (mut at, mut special) = (fence.len(), false);
    loop {
        let next = rest[at..].iter().position(|c| *c == b'\\' || *c == quote).ok_or("a string has no end")?;
        at += next;
        if rest[at] == b'\\' {
            special = true;
            at += 2;
            if at > rest.len() {
                return Err("a string has no end".into());
            }
        } else if rest[at..].starts_with(fence) {
            break;
        } else {
            special = true;
            at += 1;
        }
    }
    let content = &rest[fence.len()..at];
    Ok((at + fence.len(), if special { unescaped(content).into() } else { content.into() }))
}

/// The characters that a string with escapes stands for.
fn unescaped(content: &[u8]) -> Vec<u8> {
    let mut text = Vec::with_capacity(content.len());
    let mut rest = content;
    while let [first, tail @ ..] = rest {
        rest = tail;
        let (b'\\', [escape, tail @ ..]) = (*first, rest) else {
            text.push(*first);
            continue;
        };
        rest = tail;
        match escape {
            b'n' => text.push(b'\n'),
            b'r' => text.push(b'\r'),
            b't' => text.push(b'\t'),
            other => text.push(*other),
        }
    }
    text
}

/// A string in the fences that the parser reads without recursion and without escapes.
pub(super) fn quoted(content: Vec<u8>) -> Vec<u8> {
    for quote in [b'\'', b'"'] {
        let fence = [quote; 3];
        let count = content.iter().filter(|&&c| c == quote).count();
        if count <= MOST_FENCES && find(&content, 0, &fence).is_none() && content.last() != Some(&quote) {
            return [&fence, content.as_slice(), &fence].concat();
        }
    }
    // A text with many quotation marks of both kinds, such as a program. No name, token or path is one.
    format!("'''{}'''", String::from_utf8_lossy(&content).replace('\'', "\u{2019}")).into()
}

/// The length of a number, and the offset at which it needs a `0`: the parser requires digits on both sides of the
/// point. The length is 0 if there is no number.
pub(super) fn number(text: &[u8]) -> (usize, Option<usize>) {
    let digits = |from: usize| text[from..].iter().take_while(|c| c.is_ascii_digit()).count();
    let sign = usize::from(matches!(text[0], b'+' | b'-'));
    let whole = digits(sign);
    let mut used = sign + whole;
    let mut zero = None;
    if text.get(used) == Some(&b'.') {
        let decimals = digits(used + 1);
        if whole + decimals == 0 {
            return (0, None);
        }
        if decimals == 0 {
            zero = Some(used + 1);
        } else if whole == 0 {
            zero = Some(used);
        }
        used += 1 + decimals;
    } else if whole == 0 {
        return (0, None);
    }
    if matches!(text.get(used), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(text.get(used + 1), Some(b'+' | b'-')));
        let exponent = text.get(used + 1 + sign..).map_or(0, |_| digits(used + 1 + sign));
        used += if exponent > 0 { 1 + sign + exponent } else { 0 };
    }
    (used, zero)
}
