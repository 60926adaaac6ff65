//! Leaves out the properties of a text layer that the parser of `openusd` cannot read.
//!
//! A layer is repaired after its parser has failed, and the stage is opened again.

use super::text::{asset, find, string};
use super::{Failure, guarded};
use openusd::usda;
use std::collections::HashMap;
use std::ops::Range;

/// The most properties of a layer that are left out because of their values. Each needs the parser once or twice.
const MOST_LOSSES: usize = 64;

/// The most bytes that the parser reads to repair a layer: 256 MB.
const MOST_BYTES: usize = 256 << 20;

/// The types of attributes with values that the parser reads, without their roles.
const TYPES: [&str; 36] = [
    "bool",
    "uchar",
    "int",
    "int2",
    "int3",
    "int4",
    "uint",
    "int64",
    "uint64",
    "half",
    "half2",
    "half3",
    "half4",
    "float",
    "float2",
    "float3",
    "float4",
    "double",
    "double2",
    "double3",
    "double4",
    "matrix2d",
    "matrix3d",
    "matrix4d",
    "frame4d",
    "quatd",
    "quatf",
    "quath",
    "string",
    "token",
    "asset",
    "timecode",
    "dictionary",
    "color4h",
    "color4f",
    "color4d",
];

/// The beginnings of types with three or two numbers.
const ROLES: [&str; 5] = ["point3", "normal3", "vector3", "color3", "texCoord"];

/// What was left out of layers: the prim, and the property with the reason.
pub(super) type Losses = Vec<(String, String)>;

/// Layers without the properties that cannot be read, by their paths.
#[derive(Clone, Default)]
pub(crate) struct Repairs(pub(super) HashMap<String, (String, Losses)>);

/// A property in a text.
struct Statement {
    range: Range<usize>,
    /// Index of the path of its prim.
    prim: usize,
}

/// The text of a layer without the properties that cannot be read, or `None` if this does not help. Messages have the
/// name of the layer.
pub(super) fn repaired(mut text: String, layer: &str) -> Option<(String, Losses)> {
    let loss = |text: &str, statement: &Statement, prims: &[String], why: &str| {
        let line = 1 + text[..statement.range.start].matches('\n').count();
        let (prim, name) = named(text, statement, prims);
        (prim, format!("{name} cannot be read ({layer}, line {line}): {why}"))
    };
    let (mut statements, prims) = statements(&text);
    let mut losses = Losses::new();
    statements.retain(|statement| {
        let Some(kind) = unknown_type(&text[statement.range.clone()]) else { return true };
        let why = format!("its type {kind} is not known");
        losses.push(loss(&text, statement, &prims, &why));
        blank(&mut text, statement.range.clone());
        false
    });
    let (mut by_value, mut read) = (0, 0);
    let mut error = error_at(&text);
    while let Some((at, why)) = error {
        let last = statements.partition_point(|statement| statement.range.start <= at).checked_sub(1)?;
        // The parser may have read the first token behind a value that ends too early.
        error = None;
        for i in [Some(last), last.checked_sub(1)].into_iter().flatten() {
            read += 2 * text.len();
            if by_value >= MOST_LOSSES || read > MOST_BYTES {
                return None;
            }
            let mut without = text.clone();
            blank(&mut without, statements[i].range.clone());
            let next = error_at(&without);
            if next.as_ref().is_none_or(|(next, _)| *next > at.max(statements[i].range.end)) {
                losses.push(loss(&text, &statements[i], &prims, &why));
                statements.remove(i);
                text = without;
                by_value += 1;
                error = next;
                break;
            }
            error = Some((usize::MAX, why.clone()));
        }
        if error.as_ref().is_some_and(|(at, _)| *at == usize::MAX) {
            return None;
        }
    }
    Some((text, losses))
}

/// The prim and the name of a property.
fn named(text: &str, statement: &Statement, prims: &[String]) -> (String, String) {
    let declared = text[statement.range.clone()].split(['=', '(', '\n']).next().unwrap_or_default();
    let name = declared.split_whitespace().next_back().unwrap_or_default();
    let name = vellus_io::excerpt(name.as_bytes(), 80);
    let prim = if prims[statement.prim].is_empty() { "/" } else { &prims[statement.prim] };
    (prim.to_owned(), name)
}

/// The type of an attribute with a value, if the parser does not know it.
fn unknown_type(statement: &str) -> Option<&str> {
    let (declared, _) = statement.split_once('=')?;
    let mut words = declared.split_whitespace();
    let mut word = words.next()?;
    while matches!(word, "custom" | "uniform" | "varying" | "config" | "prepend" | "append" | "add" | "delete") {
        word = words.next()?;
    }
    let (kind, _) = word.split_once('[').unwrap_or((word, ""));
    let is_known = TYPES.contains(&kind) || ROLES.iter().any(|role| kind.starts_with(role));
    // A connection has no value.
    let name = words.next().filter(|name| !name.ends_with(".connect"))?;
    let is_name = name.starts_with(|c: char| c.is_alphabetic() || c == '_');
    let is_word = kind.chars().all(|c| c.is_alphanumeric() || c == '_');
    (!is_known && is_name && is_word && !matches!(kind, "rel" | "reorder")).then_some(kind)
}

fn blank(text: &mut String, range: Range<usize>) {
    let spaces: String = text[range.clone()].bytes().map(|c| if c == b'\n' { '\n' } else { ' ' }).collect();
    text.replace_range(range, &spaces);
}

/// Where the parser fails, and why.
fn error_at(text: &str) -> Option<(usize, String)> {
    let mut parser = usda::parser::Parser::new(text);
    guarded(|| parser.parse().map_err(|error| Failure(error.root_cause().to_string()))).err()?;
    let place = guarded(|| Ok(parser.last_error_highlight())).ok().flatten()?;
    let line: usize = text.split_inclusive('\n').take(place.line - 1).map(str::len).sum();
    let column = text[line..].char_indices().nth(place.column - 1).map_or(text.len() - line, |(at, _)| at);
    Some((line + column, "its value is not one of its type".to_owned()))
}

/// A bracket that is open.
enum Open {
    /// The body of a prim, a variant or the layer: the index of its path, and where its current statement begins.
    Body(usize, Option<usize>),
    Other,
}

/// The properties of a text without comments and escapes, and the paths of the prims that have them.
fn statements(text: &str) -> (Vec<Statement>, Vec<String>) {
    let bytes = text.as_bytes();
    let (mut all, mut prims) = (Vec::new(), vec![String::new()]);
    let mut open = vec![Open::Body(0, None)];
    // The name of the prim whose body comes next.
    let mut name: Option<String> = None;
    let (mut at, mut last) = (0, b'\n');
    while let Some(&first) = bytes.get(at) {
        let rest = &bytes[at..];
        if let Some(Open::Body(prim, start)) = open.last_mut() {
            let begun = start.map(|start| &text[start..at]);
            let is_prim = |text: &str| ["def", "over", "class", "variantSet"].iter().any(|word| text.starts_with(word));
            match first {
                b'\n' | b';' | b'}' => {
                    if let Some(range) = start.take().map(|start| start..at)
                        && !is_prim(&text[range.clone()])
                    {
                        all.push(Statement { range, prim: *prim });
                    }
                }
                b'{' if last != b'=' || begun.is_some_and(is_prim) => {
                    let path = name.take().map(|name| format!("{}/{name}", prims[*prim]));
                    let inner = path.map_or(*prim, |path| {
                        prims.push(path);
                        prims.len() - 1
                    });
                    *start = None;
                    open.push(Open::Body(inner, None));
                    (at, last) = (at + 1, b'\n');
                    continue;
                }
                b'"' | b'\'' if begun.is_some_and(|begun| is_prim(begun) && !begun.starts_with("variantSet")) => {
                    let Ok((_, content)) = string(rest) else { break };
                    name = Some(String::from_utf8_lossy(&content).into_owned());
                }
                c if !c.is_ascii_whitespace() && !matches!(c, b'(' | b'{') => {
                    start.get_or_insert(at);
                }
                _ => {}
            }
        }
        at += match first {
            b'"' | b'\'' => string(rest).map_or(rest.len(), |(used, _)| used),
            b'@' => asset(rest).map_or(rest.len(), |(used, _)| used),
            b'<' => find(rest, 1, b">").unwrap_or(rest.len()),
            b'(' | b'[' | b'{' => {
                open.push(Open::Other);
                1
            }
            b')' | b']' | b'}' => {
                if open.len() > 1 {
                    open.pop();
                }
                1
            }
            _ => 1,
        };
        if !first.is_ascii_whitespace() {
            last = first;
        }
    }
    all.sort_unstable_by_key(|statement: &Statement| statement.range.start);
    (all, prims)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_of_an_unknown_kind_costs_its_property() {
        let text = "#usda 1.0\n(\n    upAxis = \"Y\"\n)\n\ndef Xform \"a\" (\n    kind = \"group\"\n)\n{\n\
            \x20   matrix[] primvars:m = []\n    float x = \"three\"\n    custom opaque o\n    double3 p = <q>\n\
            \x20   float ok = 4\n    def Sphere \"b\"\n    {\n        tensor t = { a = [(1)] } ( doc = 'x\ny' )\n\
            \x20       double radius = 3\n    }\n    variantSet \"v\" = {\n        \"one\" {\n            shade s = 1\n\
            \x20           double c = 1\n        }\n    }\n}\n";
        let (new, losses) = repaired(text.to_owned(), "a.usda").unwrap();
        let said: Vec<String> = losses.iter().map(|(prim, what)| format!("{prim}: {what}")).collect();
        for (prim, name) in [("/a", "primvars:m"), ("/a", "x"), ("/a", "p"), ("/a/b", "t"), ("/a", "s")] {
            let beginning = format!("{prim}: {name} cannot be read (a.usda, line ");
            assert!(said.iter().any(|line| line.starts_with(&beginning)), "{beginning} {said:?}");
        }
        assert_eq!(said.len(), 5, "{said:?}");
        for kept in ["custom opaque o", "float ok = 4", "double radius = 3", "double c = 1"] {
            assert!(new.contains(kept), "{kept} {new}");
        }
        assert_eq!(new.lines().count(), text.lines().count());
    }

    #[test]
    fn other_faults_are_not_repaired() {
        for text in
            ["#usda 1.0\ndef Xform \"a\" {", "#usda 1.0\n)", "#usda 1.0\ndef Xform a { float x = 1\n }", "\u{1}"]
        {
            assert!(repaired(text.to_owned(), "").is_none(), "{text}");
        }
    }
}
