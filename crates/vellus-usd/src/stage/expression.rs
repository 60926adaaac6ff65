//! Expressions of paths (SdfPathExpression): which prims a collection has.

use std::borrow::Cow;

/// The largest depth of an expression with the collections that it names, and the largest number of its parts.
const DEEPEST: usize = 100;
const MOST: usize = 1000;

/// An expression of paths. References to other collections are resolved when it is parsed.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Expression {
    Pattern(Pattern),
    Not(Box<Expression>),
    Union(Vec<Expression>),
    Intersection(Vec<Expression>),
    Difference(Box<Expression>, Box<Expression>),
}

/// A pattern of a path: names with wildcards.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pattern(Vec<Part>);

#[derive(Clone, Debug, PartialEq)]
enum Part {
    /// A name with the wildcards `*`, `?` and `[...]`.
    Name(Vec<Glob>),
    /// `//`: any number of names.
    Any,
}

#[derive(Clone, Debug, PartialEq)]
enum Glob {
    Char(char),
    /// `?`
    One,
    /// `*`
    Many,
    /// `[a-c]`, or `[!a-c]` for all others.
    Class(bool, Vec<(char, char)>),
}

impl Expression {
    /// The expression that has nothing.
    pub const NOTHING: Self = Expression::Union(Vec::new());

    /// Whether the expression has the prim with this path.
    pub fn has(&self, path: &str) -> bool {
        let names: Vec<&str> = path.split('/').filter(|name| !name.is_empty()).collect();
        self.has_names(&names)
    }

    fn has_names(&self, names: &[&str]) -> bool {
        match self {
            Expression::Pattern(pattern) => pattern.has(names),
            Expression::Not(inner) => !inner.has_names(names),
            Expression::Union(parts) => parts.iter().any(|part| part.has_names(names)),
            Expression::Intersection(parts) => parts.iter().all(|part| part.has_names(names)),
            Expression::Difference(left, right) => left.has_names(names) && !right.has_names(names),
        }
    }
}

impl Pattern {
    fn has(&self, names: &[&str]) -> bool {
        wild(
            &self.0,
            names,
            |part| *part == Part::Any,
            |part, name| match part {
                Part::Name(glob) => {
                    let chars: Vec<char> = name.chars().collect();
                    wild(
                        glob,
                        &chars,
                        |glob| *glob == Glob::Many,
                        |glob, c| match glob {
                            Glob::Char(own) => own == c,
                            Glob::One => true,
                            Glob::Class(other, ranges) => {
                                *other != ranges.iter().any(|(first, last)| (*first..=*last).contains(c))
                            }
                            Glob::Many => unreachable!(),
                        },
                    )
                }
                Part::Any => unreachable!(),
            },
        )
    }
}

/// Whether a pattern matches a text: some of its parts match any number of items, the others exactly one. It takes at
/// most the product of both lengths.
fn wild<P, T>(pattern: &[P], text: &[T], is_many: impl Fn(&P) -> bool, is_match: impl Fn(&P, &T) -> bool) -> bool {
    let (mut p, mut t) = (0, 0);
    // The last part that matches many, and where its match ends so far.
    let mut last: Option<(usize, usize)> = None;
    while t < text.len() {
        if p < pattern.len() && is_many(&pattern[p]) {
            last = Some((p, t));
            p += 1;
        } else if p < pattern.len() && is_match(&pattern[p], &text[t]) {
            p += 1;
            t += 1;
        } else if let Some((many, end)) = &mut last {
            *end += 1;
            (p, t) = (*many + 1, *end);
        } else {
            return false;
        }
    }
    pattern[p..].iter().all(is_many)
}

/// What an expression depends on.
pub(super) trait Context {
    /// The expression of another collection: the path of its prim, as it is written, and its name.
    fn collection(&mut self, prim: &str, name: &str, depth: usize) -> Result<Expression, String>;

    /// The path on the stage of an absolute path in the expression's layer. `None` if the stage does not have it.
    fn mapped(&self, path: &str) -> Option<String>;

    /// The path of the prim with the collection. Relative paths start there.
    fn anchor(&self) -> &str;
}

/// Reads an expression.
pub(super) fn parse(text: &str, context: &mut dyn Context, depth: usize) -> Result<Expression, String> {
    let mut parser = Parser { chars: text.chars().collect(), at: 0, context, parts: 0 };
    parser.space();
    if parser.peek().is_none() {
        return Ok(Expression::NOTHING);
    }
    let expression = parser.difference(depth)?;
    match parser.peek() {
        None => Ok(expression),
        Some(c) => Err(format!("'{c}' at character {} is not expected", parser.at + 1)),
    }
}

struct Parser<'a> {
    chars: Vec<char>,
    at: usize,
    context: &'a mut dyn Context,
    parts: usize,
}

/// The operators bind in this order: `~`, then `+` and spaces, then `&`, then `-`.
impl Parser<'_> {
    fn peek(&self) -> Option<char> {
        self.chars.get(self.at).copied()
    }

    fn take(&mut self, c: char) -> bool {
        let found = self.peek() == Some(c);
        self.at += usize::from(found);
        found
    }

    fn space(&mut self) {
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += 1;
        }
    }

    fn difference(&mut self, depth: usize) -> Result<Expression, String> {
        let mut left = self.intersection(depth)?;
        while self.take('-') {
            let right = self.intersection(depth)?;
            left = Expression::Difference(Box::new(left), Box::new(right));
        }
        Ok(left)
    }

    fn intersection(&mut self, depth: usize) -> Result<Expression, String> {
        let mut parts = vec![self.union(depth)?];
        while self.take('&') {
            parts.push(self.union(depth)?);
        }
        Ok(if parts.len() == 1 { parts.remove(0) } else { Expression::Intersection(parts) })
    }

    fn union(&mut self, depth: usize) -> Result<Expression, String> {
        let mut parts = Vec::new();
        loop {
            self.space();
            parts.push(self.unary(depth)?);
            self.space();
            if !self.take('+') && self.peek().is_none_or(|c| "-&)".contains(c)) {
                break;
            }
        }
        Ok(if parts.len() == 1 { parts.remove(0) } else { Expression::Union(parts) })
    }

    fn unary(&mut self, depth: usize) -> Result<Expression, String> {
        self.parts += 1;
        if depth >= DEEPEST {
            return Err(format!("it is deeper than {DEEPEST} levels"));
        }
        if self.parts >= MOST {
            return Err(format!("it has more than {MOST} parts"));
        }
        if self.take('~') {
            self.space();
            return Ok(Expression::Not(Box::new(self.unary(depth + 1)?)));
        }
        if self.take('(') {
            let inner = self.difference(depth + 1)?;
            return if self.take(')') { Ok(inner) } else { Err("a bracket is not closed".into()) };
        }
        if self.take('%') {
            return self.reference(depth);
        }
        self.pattern()
    }

    /// `%/path:name`
    fn reference(&mut self, depth: usize) -> Result<Expression, String> {
        let text = self.word(|c| c.is_alphanumeric() || "_/.:".contains(c));
        if text == "_" {
            return Err("it refers to the weaker expression, which is not supported".into());
        }
        let Some((prim, name)) = text.split_once(':') else { return Err(format!("'%{text}' is no collection")) };
        self.context.collection(prim, name, depth + 1)
    }

    fn word(&mut self, is_part: impl Fn(char) -> bool) -> String {
        let start = self.at;
        while self.peek().is_some_and(&is_part) {
            self.at += 1;
        }
        self.chars[start..self.at].iter().collect()
    }

    fn pattern(&mut self) -> Result<Expression, String> {
        let start = self.at;
        let text = self.glob()?;
        if self.peek() == Some('{') {
            return Err("it has a predicate in {}, which is not supported".into());
        }
        if text.is_empty() {
            return Err(format!("a path is expected at character {}", start + 1));
        }
        let Some((prim, rest)) = self.start(&text) else { return Ok(Expression::NOTHING) };
        let literal = |name: &str| Part::Name(name.chars().map(Glob::Char).collect());
        let mut parts: Vec<Part> = prim.split('/').filter(|name| !name.is_empty()).map(literal).collect();
        let mut rest = &rest[..];
        while let Some(after) = rest.strip_prefix('/') {
            let name = after.split('/').next().unwrap_or_default();
            rest = &after[name.len()..];
            match name {
                // The end of `//`.
                "" if rest.is_empty() => {}
                "" => parts.push(Part::Any),
                // Properties are no prims.
                name if name.contains('.') => return Ok(Expression::NOTHING),
                name => parts.push(Part::Name(globs(name))),
            }
        }
        Ok(Expression::Pattern(Pattern(parts)))
    }

    /// The text of a pattern. A class of characters may have any characters.
    fn glob(&mut self) -> Result<String, String> {
        let (start, mut is_class) = (self.at, false);
        while let Some(c) = self.peek() {
            if !is_class && (c.is_whitespace() || "+-&~(){}%".contains(c)) {
                break;
            }
            is_class = if is_class { c != ']' } else { c == '[' };
            self.at += 1;
        }
        if is_class { Err("']' is missing".into()) } else { Ok(self.chars[start..self.at].iter().collect()) }
    }

    /// The prim on the stage where a pattern starts, and its rest with a slash before each name. `None` if the stage
    /// does not have it.
    fn start<'t>(&self, text: &'t str) -> Option<(String, Cow<'t, str>)> {
        if text.starts_with("//") {
            return Some(("/".to_owned(), text.into()));
        }
        if text.starts_with('/') {
            // Only the names before the first wildcard are the path of a prim.
            let wild = text.find(['*', '?', '[']).map(|at| text[..at].rfind('/').unwrap_or(0));
            let end = wild.unwrap_or(text.len()).min(text.find("//").unwrap_or(text.len()));
            let prim = if end == 0 { "/" } else { &text[..end] };
            return Some((self.context.mapped(prim)?, text[end..].into()));
        }
        let mut prim = self.context.anchor();
        let text = format!("/{text}");
        let step = |rest: &str, step: &str| match rest.strip_prefix(step) {
            Some(after) if after.is_empty() || after.starts_with('/') => Some(after.to_owned()),
            _ => None,
        };
        let mut rest = step(&text, "/.").unwrap_or(text);
        while let Some(after) = step(&rest, "/..") {
            (prim, _) = prim.rsplit_once('/').filter(|_| prim != "/")?;
            rest = after;
        }
        Some((prim.to_owned(), rest.into()))
    }
}

/// The parts of a name. Its brackets are closed.
fn globs(name: &str) -> Vec<Glob> {
    let mut globs = Vec::new();
    let mut chars = name.chars();
    while let Some(c) = chars.next() {
        globs.push(match c {
            '?' => Glob::One,
            '*' => Glob::Many,
            '[' => {
                let class: Vec<char> = chars.by_ref().take_while(|c| *c != ']').collect();
                let is_other = class.first() == Some(&'!');
                let (mut ranges, mut rest) = (Vec::new(), &class[usize::from(is_other)..]);
                while let [first, after @ ..] = rest {
                    let (last, after) =
                        if let ['-', last, after @ ..] = after { (last, after) } else { (first, after) };
                    ranges.push((*first, *last));
                    rest = after;
                }
                Glob::Class(is_other, ranges)
            }
            c => Glob::Char(c),
        });
    }
    globs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A layer whose prim `/M` is `/W/N` on the stage. The collection `x` has `/W/N/K`.
    struct Test;

    impl Context for Test {
        fn collection(&mut self, prim: &str, name: &str, depth: usize) -> Result<Expression, String> {
            match (prim, name) {
                ("" | "/M", "x") => parse("K", self, depth),
                ("", "circle") => parse("%:circle", self, depth),
                _ => Err("no such collection".into()),
            }
        }

        fn mapped(&self, path: &str) -> Option<String> {
            let rest = path.strip_prefix("/M").filter(|rest| rest.is_empty() || rest.starts_with('/'))?;
            Some(format!("/W/N{rest}"))
        }

        fn anchor(&self) -> &str {
            "/W/N"
        }
    }

    const PRIMS: [&str; 10] =
        ["/", "/W", "/W/N", "/W/N/S1", "/W/N/S2", "/W/N/Sx", "/W/N/K", "/W/N/K/S1", "/W/N/K/é", "/T"];

    /// The prims are those that OpenUSD 26.11 finds.
    #[test]
    fn expressions_have_the_prims_of_openusd() {
        for (text, expected) in [
            ("", ""),
            ("S1", "/W/N/S1"),
            (".", "/W/N"),
            ("..", "/W"),
            ("../../../..", ""),
            ("../*/S1", "/W/N/S1"),
            (".//S1", "/W/N/S1 /W/N/K/S1"),
            ("//S1", "/W/N/S1 /W/N/K/S1"),
            ("K//", "/W/N/K /W/N/K/S1 /W/N/K/é"),
            ("K//*", "/W/N/K/S1 /W/N/K/é"),
            ("/M/S?", "/W/N/S1 /W/N/S2 /W/N/Sx"),
            ("/M/S[0-9]", "/W/N/S1 /W/N/S2"),
            ("S[!1]", "/W/N/S2 /W/N/Sx"),
            ("S[x1]", "/W/N/S1 /W/N/Sx"),
            ("//N/*//é", "/W/N/K/é"),
            ("//T", "/T"),
            ("/T", ""),
            ("/*/S1", ""),
            ("//é", "/W/N/K/é"),
            ("S1.attribute", ""),
            ("S1 S2", "/W/N/S1 /W/N/S2"),
            ("S1+S2", "/W/N/S1 /W/N/S2"),
            ("~//S* - //K//", "/ /W /W/N /T"),
            // `+` binds tighter than `&`, and `&` tighter than `-`.
            ("S* & S1 S2", "/W/N/S1 /W/N/S2"),
            ("S* - S1 + S2", "/W/N/Sx"),
            ("S* - S1 & S2", "/W/N/S1 /W/N/S2 /W/N/Sx"),
            ("S* - S1 - S2", "/W/N/Sx"),
            ("S* & (S1 + K) - K", "/W/N/S1"),
            ("%:x + S1", "/W/N/S1 /W/N/K"),
            ("%/M:x", "/W/N/K"),
        ] {
            let expression = parse(text, &mut Test, 0).unwrap();
            let found: Vec<&str> = PRIMS.into_iter().filter(|prim| expression.has(prim)).collect();
            assert_eq!(found.join(" "), expected, "{text}");
        }
    }

    #[test]
    fn broken_expressions_are_errors() {
        let (deep, long) = ("(".repeat(100_000), "S ".repeat(100_000));
        for (text, part) in [
            ("S1 -", "a path is expected at character 5"),
            ("(S1", "a bracket is not closed"),
            ("S1)", "')' at character 3"),
            ("S[1", "']' is missing"),
            ("%_ + S1", "the weaker expression"),
            ("%x", "'%x' is no collection"),
            ("%:y", "no such collection"),
            ("%:circle", "deeper than 100 levels"),
            ("//{isa:Mesh}", "a predicate"),
            (&deep, "deeper than 100 levels"),
            (&long, "more than 1000 parts"),
        ] {
            let error = parse(text, &mut Test, 0).unwrap_err();
            assert!(error.contains(part), "{text:.20}: {error}");
        }
    }
}
