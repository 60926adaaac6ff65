//! Damage to bytes, and changes to texts and binary formats that keep most of the structure.

use crate::dice::Dice;
use std::ops::Range;

/// 32-bit words that readers handle wrongly: small, large, almost negative, and floats at the limits.
const WORDS: [u32; 16] = [
    0,
    1,
    2,
    0xff,
    0xffff,
    0x0001_0000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
    0x7f80_0000,
    0xff80_0000,
    0x7fc0_0000,
    0x7f7f_ffff,
    0x0000_0001,
    0xbf80_0000,
];

/// Text in place of a number.
const NUMBERS: [&str; 24] = [
    "nan",
    "inf",
    "-inf",
    "-1",
    "0",
    "-0",
    "1e38",
    "1e39",
    "-1e308",
    "1e400",
    "1e-46",
    ".5",
    "5.",
    "+3",
    "0x10",
    "2147483648",
    "4294967296",
    "18446744073709551616",
    "99999999999999999999999999999999",
    "1e20",
    "None",
    "\"text\"",
    "[1, 2]",
    "",
];

/// Pieces that parsers count, nest or look up.
const PIECES: [&str; 22] = [
    "[",
    "]",
    "{",
    "}",
    "(",
    ")",
    "\"",
    "'",
    "\"\"\"",
    "@",
    "@a.usda@",
    "</a>",
    "</>",
    "#",
    ",",
    ";",
    "=",
    "\0",
    "\u{feff}",
    "\u{202e}é🐈",
    "\\",
    "..",
];

/// Flips a few random bits, or some hundreds.
pub fn flip_bits(bytes: &mut [u8], dice: &mut Dice) {
    if bytes.is_empty() {
        return;
    }
    let count = *dice.pick(&[1, 1, 2, 5, 20, 200]);
    for _ in 0..count {
        let i = dice.number(0..bytes.len());
        bytes[i] ^= 1 << dice.number(0..8);
    }
}

/// Damage like that of a bad disk or an interrupted copy.
pub fn damage(bytes: &mut Vec<u8>, dice: &mut Dice) -> &'static str {
    let length = bytes.len();
    if length < 16 {
        bytes.push(dice.byte());
        return "appended bytes";
    }
    match dice.number(0..7) {
        0 | 1 => {
            flip_bits(bytes, dice);
            "flipped bits"
        }
        2 => {
            let keep = if dice.chance(0.3) { length - 1 - dice.number(0..8) } else { dice.number(0..length) };
            bytes.truncate(keep);
            "truncated"
        }
        3 => {
            let more = dice.number(1..100);
            bytes.extend((0..more).map(|_| dice.byte()));
            "appended bytes"
        }
        4 => {
            let range = span(length, dice);
            bytes[range].fill(0);
            "zeroed block"
        }
        5 => {
            let range = span(length, dice);
            bytes.drain(range);
            "lost block"
        }
        _ => {
            word(bytes, dice);
            "changed word"
        }
    }
}

/// Changes a binary file. A reader must detect or tolerate it.
pub fn binary(bytes: &mut Vec<u8>, dice: &mut Dice) {
    for _ in 0..*dice.pick(&[1, 1, 2, 3, 8]) {
        match dice.number(0..6) {
            0 => _ = damage(bytes, dice),
            1 if bytes.len() >= 16 => {
                let range = span(bytes.len(), dice);
                let copy = bytes[range].to_vec();
                let at = dice.number(0..bytes.len());
                bytes.splice(at..at, copy);
            }
            _ => word(bytes, dice),
        }
    }
}

/// Changes a text. A parser must detect or tolerate it.
pub fn text(text: &str, dice: &mut Dice) -> Vec<u8> {
    let mut text = text.to_owned();
    for _ in 0..*dice.pick(&[1, 1, 2, 3, 8]) {
        change_text(&mut text, dice);
    }
    let mut bytes = text.into_bytes();
    if dice.chance(0.1) {
        flip_bits(&mut bytes, dice);
    }
    bytes
}

fn change_text(text: &mut String, dice: &mut Dice) {
    let lines: Vec<&str> = text.lines().collect();
    if lines.is_empty() {
        text.push_str(dice.pick::<&str>(&PIECES));
        return;
    }
    match dice.number(0..10) {
        0..=3 => {
            let numbers = tokens(text, |c| c.is_ascii_digit() || matches!(c, '.' | '-'));
            if !numbers.is_empty() {
                let range = dice.pick(&numbers).clone();
                text.replace_range(range, dice.pick::<&str>(&NUMBERS));
            }
        }
        4 => {
            let words = tokens(text, |c| c.is_ascii_alphanumeric() || matches!(c, '_' | ':'));
            if !words.is_empty() {
                let word = text[dice.pick(&words).clone()].to_owned();
                text.replace_range(dice.pick(&words).clone(), &word);
            }
        }
        5 => {
            let mut kept = lines;
            kept.remove(dice.number(0..kept.len()));
            *text = kept.join("\n");
        }
        6 => {
            let range = span(lines.len(), dice);
            let mut longer = lines.clone();
            let copy = lines[range].repeat(*dice.pick(&[1, 1, 2, 50]));
            let at = dice.number(0..lines.len());
            longer.splice(at..at, copy);
            *text = longer.join("\n");
        }
        7 => {
            let mut mixed = lines;
            let (a, b) = (dice.number(0..mixed.len()), dice.number(0..mixed.len()));
            mixed.swap(a, b);
            *text = mixed.join("\n");
        }
        8 => {
            let piece = dice.pick(&PIECES).repeat(*dice.pick(&[1, 1, 1, 3, 300, 100_000]));
            text.insert_str(boundary(text, dice), &piece);
        }
        _ => {
            let end = boundary(text, dice);
            text.truncate(end);
        }
    }
}

/// The start of a random character.
fn boundary(text: &str, dice: &mut Dice) -> usize {
    let mut at = dice.number(0..text.len() + 1);
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// Runs of characters of one kind.
fn tokens(text: &str, is: impl Fn(char) -> bool) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut start = None;
    for (i, c) in text.char_indices().chain([(text.len(), '\0')]) {
        match (is(c), start) {
            (true, None) => start = Some(i),
            (false, Some(from)) => {
                runs.push(from..i);
                start = None;
            }
            _ => {}
        }
    }
    runs
}

/// Overwrites 4 or 8 bytes, mostly at aligned positions, and more often near the beginning, where headers are.
fn word(bytes: &mut [u8], dice: &mut Dice) {
    if bytes.len() < 8 {
        return;
    }
    let most = if dice.chance(0.5) { bytes.len().min(256) } else { bytes.len() };
    let mut at = dice.number(0..most - 7);
    if dice.chance(0.8) {
        at -= at % 4;
    }
    bytes[at..at + 4].copy_from_slice(&dice.pick(&WORDS).to_le_bytes());
    if dice.chance(0.3) {
        let high: u32 = if dice.chance(0.5) { 0 } else { *dice.pick(&WORDS) };
        bytes[at + 4..at + 8].copy_from_slice(&high.to_le_bytes());
    }
}

/// A non-empty range, more often a short one.
fn span(length: usize, dice: &mut Dice) -> Range<usize> {
    let most = (length as f64).powf(dice.unit()) as usize;
    let start = dice.number(0..length);
    start..(start + most.max(1)).min(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_depend_only_on_the_seed() {
        let changed = |seed| {
            let mut bytes = b"some bytes that are long enough".to_vec();
            binary(&mut bytes, &mut Dice::new(seed, "test", 3));
            (bytes, text("a = 1\nb = 2.5\n", &mut Dice::new(seed, "test", 4)))
        };
        assert_eq!(changed(1), changed(1));
        assert!((2..12).any(|seed| changed(seed) != changed(1)));
    }

    #[test]
    fn any_bytes_and_any_text_can_be_changed() {
        for case in 0..2000 {
            let mut dice = Dice::new(1, "test", case);
            let length = dice.number(0..40);
            let mut bytes = vec![7; length];
            for _ in 0..20 {
                binary(&mut bytes, &mut dice);
            }
            let mut words = "x é 1 { \n} 🐈 -2.5".repeat(length % 3);
            for _ in 0..5 {
                words = String::from_utf8_lossy(&text(&words, &mut dice)).into_owned();
                if words.len() > 10_000 {
                    words.clear();
                }
            }
        }
    }
}
