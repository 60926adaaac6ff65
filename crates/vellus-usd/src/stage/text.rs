//! Checks a text layer (.usda) and rewrites it before it is parsed.
//!
//! The parser of `openusd` is recursive, and its tokens differ from those of USD. So the text that it gets has no
//! comments, no escapes in strings, and only numbers, types and names that it accepts. Both lexers then find the same
//! tokens, and the checks of this module hold for what is parsed: nesting depth, names of prims, paths, and
//! expressions.

mod tokens;

use super::arc_list::{ArcList, Item, is_arc};
use super::arcs::LayerArcs;
use super::names::{check_default, check_expression, check_name, check_path};
use crate::error::Invalid;
use std::borrow::Cow;
use std::collections::HashSet;
use std::ops::Range;
use std::rc::Rc;
use tokens::{end_of_line, number, quoted};

pub(super) use tokens::{asset, find, string};

/// The deepest nesting of brackets. The parser is recursive, so a larger depth could overflow the stack.
const DEEPEST_BRACKETS: usize = 500;

/// The largest number of words of a block, outside of strings and of blocks inside it. A property has at least two, and
/// so has a child. The parser compares each name with all others of the block: this many take 5 s.
const MOST_WORDS: usize = 1 << 17;

/// Names of types from before USD was published, which Pixar's library still reads, and their names now.
const OLD_TYPES: [(&str, &str); 32] = [
    ("Vec2i", "int2"),
    ("Vec2h", "half2"),
    ("Vec2f", "float2"),
    ("Vec2d", "double2"),
    ("Vec3i", "int3"),
    ("Vec3h", "half3"),
    ("Vec3f", "float3"),
    ("Vec3d", "double3"),
    ("Vec4i", "int4"),
    ("Vec4h", "half4"),
    ("Vec4f", "float4"),
    ("Vec4d", "double4"),
    ("PointFloat", "point3f"),
    ("Point", "point3d"),
    ("NormalFloat", "normal3f"),
    ("Normal", "normal3d"),
    ("VectorFloat", "vector3f"),
    ("Vector", "vector3d"),
    ("ColorFloat", "color3f"),
    ("Color", "color3d"),
    ("Quath", "quath"),
    ("Quatf", "quatf"),
    ("Quatd", "quatd"),
    ("Matrix2d", "matrix2d"),
    ("Matrix3d", "matrix3d"),
    ("Matrix4d", "matrix4d"),
    ("Frame", "frame4d"),
    ("Transform", "matrix4d"),
    ("PointIndex", "int"),
    ("EdgeIndex", "int"),
    ("FaceIndex", "int"),
    ("Schema", "token"),
];

/// The UTF-8 byte order mark that some editors write.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The last two words outside strings. They determine the meaning of the next string.
#[derive(Default)]
struct Words<'a>([&'a str; 2]);

impl<'a> Words<'a> {
    fn push(&mut self, word: &'a str) {
        self.0 = [self.0[1], word];
    }

    /// Checks the next string. Returns whether it is the name of a prim (`def Type "name"`, `def "name"`).
    fn check(&self, string: &str) -> Result<bool, Invalid> {
        let [first, last] = self.0;
        let specifier = |word| matches!(word, "def" | "over" | "class");
        match (first, last) {
            ("defaultPrim", "=") => check_default(string).map(|()| false),
            (_, "=") => Ok(false),
            _ if specifier(first) || specifier(last) => check_name(string).map(|()| true),
            _ => Ok(false),
        }
    }
}

/// A text with replacements.
struct Rewritten<'a> {
    text: &'a [u8],
    /// The new text up to `copied`. Empty if nothing was replaced yet.
    new: Vec<u8>,
    copied: usize,
}

impl Rewritten<'_> {
    fn replace(&mut self, range: Range<usize>, with: &[u8]) {
        self.new.extend_from_slice(&self.text[self.copied..range.start]);
        self.new.extend_from_slice(with);
        self.copied = range.end;
    }

    /// The new text, or `None` if it is the old one.
    fn finish(mut self) -> Option<Vec<u8>> {
        let len = self.text.len();
        (self.copied > 0 || !self.new.is_empty()).then(|| {
            self.replace(len..len, b"");
            self.new
        })
    }
}

/// The samples of one attribute, whose times are read.
struct Samples {
    /// The depth of brackets inside its braces.
    depth: usize,
    /// Time, and where the sample begins.
    times: Vec<(f64, usize)>,
    /// Whether the next number is a time.
    expects_time: bool,
    /// Whether a sample is one real number. The parser takes one without a point for an integer, whatever its type is.
    is_real: bool,
}

/// Where samples are that must be sorted: their times, their places, and where the last one ends.
type Unsorted = (Vec<(f64, usize)>, usize);

/// A text layer for the parser of `openusd`.
pub(super) struct Text {
    pub bytes: Vec<u8>,
    pub content: Content,
}

/// What composition must know about a layer.
#[derive(Clone, Debug, Default)]
pub(super) struct Content {
    pub arcs: Rc<LayerArcs>,
    /// How often the values of expression variables refer to other variables.
    pub variables: usize,
    /// Whether an attribute has a spline.
    pub splines: bool,
    /// Attributes of a binary layer with a spline, which cannot be read.
    pub unread: Vec<String>,
}

/// What a text layer contains.
#[derive(Default)]
struct Found {
    unsorted: Vec<Unsorted>,
    arcs: LayerArcs,
    variables: usize,
    splines: bool,
}

/// Checks a text layer, and returns the text for the parser of `openusd`: with the same lines as far as strings have no
/// escaped line breaks, with the samples of each attribute in the order of their times, and with the last of several
/// samples for one time.
pub(super) fn normalized(bytes: Vec<u8>) -> Result<Text, Invalid> {
    let (new, Found { unsorted, arcs, variables, splines }) = rewritten(&bytes)?;
    let mut bytes = new.unwrap_or(bytes);
    if !unsorted.is_empty() {
        // The places of the samples in the new text.
        bytes = sorted(&bytes, &rewritten(&bytes)?.1.unsorted);
    }
    let content = Content { arcs: Rc::new(arcs), variables, splines, unread: Vec::new() };
    Ok(Text { bytes, content })
}

fn rewritten(bytes: &[u8]) -> Result<(Option<Vec<u8>>, Found), Invalid> {
    let mut new = Rewritten { text: bytes, new: Vec::new(), copied: 0 };
    let mut found = Found::default();
    scan(bytes, &mut new, &mut found)?;
    Ok((new.finish(), found))
}

/// The text with the samples of these attributes in order.
fn sorted(text: &[u8], blocks: &[Unsorted]) -> Vec<u8> {
    let mut new = Vec::with_capacity(text.len());
    let mut copied = 0;
    for (times, end) in blocks {
        let ends = times.iter().skip(1).map(|(_, start)| *start).chain([*end]);
        let mut samples: Vec<(f64, &[u8])> =
            times.iter().zip(ends).map(|((time, start), end)| (*time, &text[*start..end])).collect();
        // The sort is stable, so the last of equal times stays the last.
        samples.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        new.extend_from_slice(&text[copied..times[0].1]);
        for (i, (time, sample)) in samples.iter().enumerate() {
            if samples.get(i + 1).is_none_or(|(next, _)| next != time) {
                new.extend_from_slice(sample.trim_ascii_end());
                // The last sample may have no comma.
                new.extend_from_slice(if sample.trim_ascii_end().ends_with(b",") { b" " } else { b", " });
            }
        }
        copied = *end;
    }
    new.extend_from_slice(&text[copied..]);
    new
}

/// Reads all tokens. Replaces those that the parser reads differently, and finds samples that are not in order.
fn scan(bytes: &[u8], new: &mut Rewritten, found: &mut Found) -> Result<(), Invalid> {
    let mut at = 0;
    if bytes.starts_with(BYTE_ORDER_MARK) {
        at = BYTE_ORDER_MARK.len();
        new.replace(0..at, b"");
    }
    if bytes[at..].starts_with(b"#usda ") {
        at += b"#usda ".len();
        let version = bytes[at..].iter().take_while(|c| c.is_ascii_digit() || **c == b'.').count();
        // Later versions have more types and more syntax. What the parser does not know of it, it reports itself.
        if bytes[at..at + version].starts_with(b"1.") && !bytes[at..at + version].starts_with(b"1.0") {
            new.replace(at..at + version, b"1.0");
        }
        at += version;
    }
    let mut depth = 0;
    let mut words = Words::default();
    // The last word that stood where an attribute has its type.
    let mut declared = "";
    // Where the last word is.
    let mut last_word = 0..0;
    let mut samples: Option<Samples> = None;
    // Each bracket that is open, and the number of words in it.
    let mut open = vec![(b'{', 0)];
    // The names of prims, by the depth of their definitions, for the blocks that are open.
    let mut siblings: Vec<(usize, HashSet<String>)> = Vec::new();
    // The prims that are open, and the depths of their definitions.
    let mut prims: Vec<(usize, String)> = Vec::new();
    let mut arcs: Option<ArcList> = None;
    // The depth inside the brackets of the variables of expressions.
    let mut values_of_variables: Option<usize> = None;
    // The depth inside the brackets of a spline.
    let mut spline: Option<usize> = None;
    while let Some(&first) = bytes.get(at) {
        let rest = &bytes[at..];
        let fail = |invalid: Invalid| {
            let line = 1 + bytes[..at].iter().filter(|&&b| b == b'\n').count();
            Invalid(format!("line {line}: {invalid}"))
        };
        let used = match first {
            b'#' => comment(new, at, rest, end_of_line(rest)),
            b'/' if rest.starts_with(b"//") => comment(new, at, rest, end_of_line(rest)),
            b'/' if rest.starts_with(b"/*") => {
                let used = find(rest, 2, b"*/").ok_or_else(|| fail("a comment has no end".into()))?;
                comment(new, at, rest, used)
            }
            b'"' | b'\'' => {
                let (used, content) = string(rest).map_err(fail)?;
                let text = String::from_utf8_lossy(&content);
                if words.check(&text).map_err(fail)? {
                    if siblings.last().is_none_or(|(of, _)| *of < depth) {
                        siblings.push((depth, HashSet::new()));
                    }
                    if siblings.last_mut().is_some_and(|(_, names)| !names.insert(text.clone().into_owned())) {
                        return Err(fail(format!("two prims with the same parent are called {text}").into()));
                    }
                    while prims.pop_if(|(of, _)| *of >= depth).is_some() {}
                    prims.push((depth, text.clone().into_owned()));
                } else if words.0 == ["defaultPrim", "="] {
                    found.arcs.default_prim = Some(text.clone().into_owned());
                }
                let variables = check_expression(&text).map_err(fail)?;
                if values_of_variables.is_some() {
                    found.variables += variables;
                }
                // A string may stand for a file.
                if declared == "asset" && words.0[1] == "=" && open.last().is_some_and(|(bracket, _)| *bracket == b'{')
                {
                    let is_plain = !content.contains(&b'@') && !content.contains(&b'\n');
                    new.replace(
                        at..at + used,
                        &if is_plain { [b"@", &content[..], b"@"].concat() } else { b"@@".to_vec() },
                    );
                } else if let Cow::Owned(content) = content {
                    new.replace(at..at + used, &quoted(content));
                }
                words.push("");
                used
            }
            b'@' => {
                let (used, path) = asset(rest).map_err(fail)?;
                let path = String::from_utf8_lossy(path);
                check_expression(&path).map_err(fail)?;
                if let Some(list) = &mut arcs {
                    list.add(&mut found.arcs, &prims, Item::Layer(&path)).map_err(fail)?;
                }
                // The parser reads samples without brackets as words: a string stands for the same file.
                if samples.as_ref().is_some_and(|samples| samples.depth == depth && !samples.expects_time) {
                    new.replace(at..at + used, &quoted(path.as_bytes().to_vec()));
                }
                words.push("");
                used
            }
            b'<' => {
                let used = find(rest, 1, b">").ok_or_else(|| fail("a path has no end".into()))?;
                let path = String::from_utf8_lossy(&rest[1..used - 1]);
                check_path(&path).map_err(fail)?;
                if let Some(list) = &mut arcs {
                    list.add(&mut found.arcs, &prims, Item::Prim(&path)).map_err(fail)?;
                }
                // A path as the value of a token or string, which OpenUSD reads as this text.
                let is_word = matches!(declared, "token" | "string")
                    && words.0[1] == "="
                    && words.0[0] != "connect"
                    && matches!(open.last(), Some((b'{', _)));
                if is_word {
                    new.replace(at..at + used, &quoted(path.as_bytes().to_vec()));
                } else if let Some((prim, property)) = path.rsplit_once('.').filter(|(_, name)| !name.contains('/'))
                    && let Cow::Owned(name) = ascii(property)
                {
                    new.replace(at..at + used, format!("<{prim}.{name}>").as_bytes());
                }
                used
            }
            b'(' | b'[' | b'{' => {
                depth += 1;
                open.push((first, 0));
                if depth > DEEPEST_BRACKETS {
                    return Err(fail(format!("more than {DEEPEST_BRACKETS} brackets inside each other").into()));
                }
                if first == b'{' && words.0 == ["timeSamples", "="] {
                    if samples.is_some() {
                        return Err(fail("time samples have no time samples".into()));
                    }
                    let is_real = matches!(declared, "half" | "float" | "double");
                    samples = Some(Samples { depth, times: Vec::new(), expects_time: true, is_real });
                }
                if first == b'{' && words.0 == ["spline", "="] {
                    (spline, found.splines) = (Some(depth), true);
                }
                // The parser reads two numbers for each tangent: those of Hermite curves have no width.
                if first == b'(' && spline == Some(depth - 1) && words.0[1] != "sloped" {
                    let content = rest.iter().position(|c| *c == b')').map_or(&rest[..0], |end| &rest[..end]);
                    if !content.contains(&b',') {
                        new.replace(at + 1..at + 1, b"0, ");
                    }
                }
                if first == b'{' && words.0 == ["expressionVariables", "="] {
                    values_of_variables = Some(depth);
                }
                words.push("");
                1
            }
            b')' | b']' | b'}' => {
                depth = depth.saturating_sub(1);
                if let Some(Samples { times, .. }) = samples.take_if(|samples| depth < samples.depth)
                    && !times.is_sorted_by(|(a, _), (b, _)| a < b)
                {
                    found.unsorted.push((times, at));
                }
                open.truncate(depth + 1);
                while siblings.pop_if(|(of, _)| *of > depth).is_some() {}
                while first == b'}' && prims.pop_if(|(of, _)| *of >= depth).is_some() {}
                arcs.take_if(|list| depth < list.depth);
                values_of_variables.take_if(|dictionary| depth < *dictionary);
                spline.take_if(|block| depth < *block);
                1
            }
            b',' => {
                if let Some(samples) = samples.as_mut().filter(|samples| samples.depth == depth) {
                    samples.expects_time = true;
                }
                if let Some(list) = &mut arcs {
                    list.after_layer = false;
                }
                1
            }
            b'=' => {
                let field = words.0[1];
                if is_arc(field) && matches!(open.last(), Some((b'(', _))) {
                    arcs = Some(ArcList { field, depth, count: 0, after_layer: false });
                }
                words.push("=");
                1
            }
            c if c.is_ascii_alphabetic() || c == b'_' || !c.is_ascii() => {
                let is_in = |c: &u8| c.is_ascii_alphanumeric() || *c == b'_' || *c == b':' || !c.is_ascii();
                let mut used = rest.iter().position(|c| !is_in(c)).unwrap_or(rest.len());
                let word = std::str::from_utf8(&rest[..used]).unwrap_or_default();
                if let Cow::Owned(name) = ascii(word) {
                    new.replace(at..at + used, name.as_bytes());
                }
                // The parser does not tell this from what is not there.
                if word == "none" && spline == Some(depth) && bytes[..at].trim_ascii_end().ends_with(b":") {
                    new.replace(at..at + used, b"blocked");
                }
                // The parser reads one word.
                if word == "loop" && spline == Some(depth) {
                    let next = rest[used..].trim_ascii_start();
                    for (name, joined) in [("repeat", "Repeat"), ("reset", "Reset"), ("oscillate", "Oscillate")] {
                        if next.starts_with(name.as_bytes()) {
                            let end = rest.len() - next.len() + name.len();
                            new.replace(at + used..at + end, joined.as_bytes());
                            used = end;
                        }
                    }
                }
                // The parser reads this list only if it is no list of edits.
                if word == "inactiveIds" && matches!(words.0[1], "prepend" | "append" | "add") {
                    new.replace(last_word, b"");
                }
                last_word = at..at + used;
                if word == "rel" {
                    declared = "";
                }
                if let Some(is_array) = before_name(&rest[used..]) {
                    declared = if is_array { "" } else { word };
                    // Types that the parser does not know. What it reads instead has the same values.
                    match (word, is_array) {
                        ("pathExpression", _) => new.replace(at..at + used, b"string"),
                        ("uint" | "uint64", true) => new.replace(at..at + used, b"int64"),
                        _ => {
                            // Some exporters write vectors in lower case, which are no types in any version.
                            let is_old =
                                |old: &str| old == word || old.starts_with("Vec") && old.eq_ignore_ascii_case(word);
                            if let Some((_, now)) = OLD_TYPES.iter().find(|(old, _)| is_old(old)) {
                                new.replace(at..at + used, now.as_bytes());
                            }
                        }
                    }
                }
                let is_time = samples.as_ref().is_some_and(|samples| samples.depth == depth && samples.expects_time);
                if is_time && matches!(word.trim_end_matches(':'), "nan" | "inf") {
                    return Err(fail("a time is no finite number".into()));
                }
                arcs.take_if(|list| depth == list.depth);
                if let Some((b'{', count)) = open.last_mut() {
                    *count += 1;
                    if *count > MOST_WORDS {
                        let what = format!("a block has more than {MOST_WORDS} words: too many properties or children");
                        return Err(fail(what.into()));
                    }
                }
                words.push(word);
                used
            }
            c if c.is_ascii_digit() || matches!(c, b'+' | b'-' | b'.') => {
                let (used, zero) = number(rest);
                if used > 0 {
                    if let Some(zero) = zero {
                        new.replace(at + zero..at + zero, b"0");
                    }
                    // The parser takes a value of its own before a knot for 0 if there is none.
                    if spline == Some(depth)
                        && bytes[..at].trim_ascii_end().ends_with(b":")
                        && !rest[used..].trim_ascii_start().starts_with(b"&")
                        && let Some(value) = std::str::from_utf8(&rest[..used]).ok().and_then(|x| x.parse::<f64>().ok())
                    {
                        new.replace(at + used..at + used, format!(" & {value:?}").as_bytes());
                    }
                    let samples = samples.as_mut().filter(|samples| samples.depth == depth);
                    let is_value = samples.as_ref().is_some_and(|samples| samples.is_real && !samples.expects_time);
                    if is_value && !rest[..used].iter().any(|c| matches!(c, b'.' | b'e' | b'E')) {
                        new.replace(at + used..at + used, b".0");
                    }
                    if let Some(samples) = samples.filter(|samples| samples.expects_time) {
                        let time = std::str::from_utf8(&rest[..used]).ok().and_then(|text| text.parse::<f64>().ok());
                        let time = time.filter(|time| time.is_finite());
                        // The sum turns -0 into 0, which is the same time.
                        let time = time.ok_or_else(|| fail("a time is no finite number".into()))? + 0.0;
                        samples.times.push((time, at));
                        samples.expects_time = false;
                    }
                }
                used.max(1)
            }
            _ => 1,
        };
        at += used;
    }
    Ok(())
}

/// Whether the text after a word goes on with `[]`, if a name follows: then the word is a type, or a word before one.
fn before_name(rest: &[u8]) -> Option<bool> {
    let blank = |from: usize| from + rest[from..].iter().take_while(|c| matches!(c, b' ' | b'\t')).count();
    let after = blank(0);
    let is_array = rest[after..].starts_with(b"[]");
    let name = blank(if is_array { after + 2 } else { after });
    let begins = |c: &u8| c.is_ascii_alphabetic() || *c == b'_' || !c.is_ascii();
    (name > 0 && rest.get(name).is_some_and(begins)).then_some(is_array)
}

/// The name of a property in the characters that the parser accepts.
pub(super) fn ascii(name: &str) -> Cow<'_, str> {
    if name.is_ascii() {
        return name.into();
    }
    let spelled = |c: char| if c.is_ascii() { c.to_string() } else { format!("_u{:x}_", u32::from(c)) };
    name.chars().map(spelled).collect::<String>().into()
}

/// Replaces a comment by a space and its line breaks.
fn comment(new: &mut Rewritten, at: usize, rest: &[u8], used: usize) -> usize {
    let lines = rest[..used].iter().filter(|&&c| c == b'\n').count();
    new.replace(at..at + used, &[b" ".as_slice(), &b"\n".repeat(lines)].concat());
    used
}

#[cfg(test)]
mod tests;
