//! `.ply` (G. Turk, *The PLY Polygon File Format*, 1994) with strands: edges, lines, or points with a strand's number.

use super::Polylines;
use crate::error::Error;
use glam::Vec3;

/// Names of elements whose lists of vertices are strands.
const LINES: [&str; 5] = ["line", "lines", "polyline", "strand", "curve"];

/// Names of the number of the strand of a vertex.
const NUMBERS: [&str; 4] = ["strand_id", "strand", "strand_index", "hair_id"];

/// The type of a number.
#[derive(Clone, Copy, PartialEq)]
enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn named(name: &str) -> Option<Type> {
        Some(match name {
            "char" | "int8" => Type::I8,
            "uchar" | "uint8" => Type::U8,
            "short" | "int16" => Type::I16,
            "ushort" | "uint16" => Type::U16,
            "int" | "int32" => Type::I32,
            "uint" | "uint32" => Type::U32,
            "float" | "float32" => Type::F32,
            "double" | "float64" => Type::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Type::I8 | Type::U8 => 1,
            Type::I16 | Type::U16 => 2,
            Type::I32 | Type::U32 | Type::F32 => 4,
            Type::F64 => 8,
        }
    }
}

struct Property {
    name: String,
    /// The type of the number of elements of a list.
    count: Option<Type>,
    kind: Type,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

/// How the numbers are written.
#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Little,
    Big,
}

/// The content behind the header, up to where it was read.
struct Content<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl Content<'_> {
    fn number(&mut self, kind: Type) -> Result<f64, String> {
        if self.encoding == Encoding::Text {
            let rest = &self.bytes[self.at..];
            let start = rest.iter().position(|c| !c.is_ascii_whitespace()).ok_or("the file ends here")?;
            let length = rest[start..].iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len() - start);
            let word = &rest[start..start + length];
            self.at += start + length;
            let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
            return number.ok_or_else(|| format!("{:?} is no number", String::from_utf8_lossy(word)));
        }
        let size = kind.size();
        let word = self.bytes.get(self.at..self.at + size).ok_or("the file ends here")?;
        self.at += size;
        let mut all = [0u8; 8];
        all[..size].copy_from_slice(word);
        if self.encoding == Encoding::Big {
            all[..size].reverse();
        }
        let [a, b, c, d, ..] = all;
        Ok(match kind {
            Type::I8 => f64::from(a as i8),
            Type::U8 => f64::from(a),
            Type::I16 => f64::from(i16::from_le_bytes([a, b])),
            Type::U16 => f64::from(u16::from_le_bytes([a, b])),
            Type::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Type::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Type::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Type::F64 => f64::from_le_bytes(all),
        })
    }

    /// Reads a row: its numbers, and the elements of its lists.
    fn row(&mut self, properties: &[Property], numbers: &mut Vec<f64>, list: &mut Vec<f64>) -> Result<(), String> {
        numbers.clear();
        list.clear();
        for property in properties {
            let Some(count) = property.count else {
                numbers.push(self.number(property.kind)?);
                continue;
            };
            let count = self.number(count)?;
            let left = (self.bytes.len() - self.at) as f64;
            if !(count >= 0.0 && count <= left && count.fract() == 0.0) {
                return Err(format!("a list of {count} elements does not fit in the file"));
            }
            for _ in 0..count as usize {
                let element = self.number(property.kind)?;
                list.push(element);
            }
            numbers.push(0.0);
        }
        Ok(())
    }
}

/// Reads a file.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<Polylines, Error> {
    let mut content = Content { bytes, at: 0, encoding: Encoding::Text };
    let read = header(&mut content).and_then(|elements| strands(&mut content, &elements));
    read.map_err(|what| Error::File { file: name.to_owned(), offset: content.at, what })
}

fn header(content: &mut Content) -> Result<Vec<Element>, String> {
    let mut elements: Vec<Element> = Vec::new();
    let mut encoding = None;
    loop {
        let rest = &content.bytes[content.at..];
        let length = rest.iter().position(|c| *c == b'\n').ok_or("the header has no end_header")?;
        let line = std::str::from_utf8(&rest[..length]).map_err(|_| "the header is no text")?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let unknown = || format!("{line:?} is not understood");
        match words[..] {
            ["format", kind, _] => {
                encoding = Some(match kind {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(unknown()),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| unknown())?;
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref kinds @ .., name] => {
                let (count, kind) = match kinds {
                    [kind] => (None, *kind),
                    ["list", count, kind] => (Some(Type::named(count).ok_or_else(unknown)?), *kind),
                    _ => return Err(unknown()),
                };
                let kind = Type::named(kind).ok_or_else(unknown)?;
                let property = Property { name: name.to_owned(), count, kind };
                elements.last_mut().ok_or_else(unknown)?.properties.push(property);
            }
            ["end_header"] => {
                content.at += length + 1;
                content.encoding = encoding.ok_or("the header has no format")?;
                return Ok(elements);
            }
            ["ply"] | ["comment" | "obj_info", ..] | [] => {}
            _ => return Err(unknown()),
        }
        content.at += length + 1;
    }
}

/// What connects points to strands.
enum Links {
    /// The next point of each one.
    Edges(Vec<u32>),
    /// Points in the order of the strands, and the first of each strand.
    Lines(Vec<u32>, Vec<u32>),
    /// The strand of each point.
    Numbers(Vec<f64>),
}

fn strands(content: &mut Content, elements: &[Element]) -> Result<Polylines, String> {
    let (mut points, mut colors, mut links) = (Vec::new(), Vec::new(), None);
    let (mut numbers, mut list) = (Vec::new(), Vec::new());
    let mut has_faces = false;
    for element in elements {
        // A row has at least one byte for each number, and text needs a space.
        let least = element.properties.len().max(1);
        if element.count > (content.bytes.len() - content.at) / least {
            return Err(format!("{} {} do not fit in the file", element.count, element.name));
        }
        let column = |names: &[&str]| {
            element.properties.iter().position(|p| p.count.is_none() && names.contains(&p.name.as_str()))
        };
        match element.name.as_str() {
            "vertex" => {
                let place = ["x", "y", "z"].map(|name| column(&[name]));
                let [Some(x), Some(y), Some(z)] = place else {
                    return Err("its vertices have no x, y and z".to_owned());
                };
                let rgb = [["red", "r"], ["green", "g"], ["blue", "b"]].map(|names| column(&names));
                let number = column(&NUMBERS);
                let mut of = Vec::new();
                for _ in 0..element.count {
                    content.row(&element.properties, &mut numbers, &mut list)?;
                    points.push(Vec3::new(numbers[x] as f32, numbers[y] as f32, numbers[z] as f32));
                    if let [Some(r), Some(g), Some(b)] = rgb {
                        let is_whole = !matches!(element.properties[r].kind, Type::F32 | Type::F64);
                        colors.push([r, g, b].map(|c| if is_whole { linear(numbers[c]) } else { numbers[c] as f32 }));
                    }
                    of.extend(number.map(|number| numbers[number]));
                }
                links = links.or((!of.is_empty()).then_some(Links::Numbers(of)));
            }
            "edge" => {
                let [Some(from), Some(to)] = [column(&["vertex1"]), column(&["vertex2"])] else {
                    return Err("its edges have no vertex1 and vertex2".to_owned());
                };
                let mut next = vec![u32::MAX; points.len()];
                let mut has_before = vec![false; points.len()];
                for _ in 0..element.count {
                    content.row(&element.properties, &mut numbers, &mut list)?;
                    let [a, b] = [index(numbers[from], points.len())?, index(numbers[to], points.len())?];
                    if next[a] != u32::MAX || has_before[b] {
                        return Err(format!("the strands branch at vertex {}", if has_before[b] { b } else { a }));
                    }
                    (next[a], has_before[b]) = (b as u32, true);
                }
                links = Some(Links::Edges(next));
            }
            name if LINES.contains(&name) && element.properties.iter().any(|p| p.count.is_some()) => {
                let (mut order, mut starts) = (Vec::new(), vec![0]);
                for _ in 0..element.count {
                    content.row(&element.properties, &mut numbers, &mut list)?;
                    for vertex in &list {
                        order.push(index(*vertex, points.len())? as u32);
                    }
                    starts.push(order.len() as u32);
                }
                links = Some(Links::Lines(order, starts));
            }
            name => {
                has_faces |= name == "face" && element.count > 0;
                for _ in 0..element.count {
                    content.row(&element.properties, &mut numbers, &mut list)?;
                }
            }
        }
    }
    let (order, starts) = match links {
        Some(Links::Lines(order, starts)) => (order, starts),
        Some(Links::Edges(next)) => chains(&next)?,
        Some(Links::Numbers(of)) => {
            let changes = (1..of.len()).filter(|i| of[*i] != of[*i - 1]).map(|i| i as u32);
            let starts = [0].into_iter().chain(changes).chain([of.len() as u32]).collect();
            ((0..of.len() as u32).collect(), starts)
        }
        None if has_faces => {
            return Err("it has polygons and no strands: convert it to .obj, to grow fur on it".to_owned());
        }
        None => {
            let what = "it has points, and does not say which points are a strand: it needs edges (vertex1, vertex2), \
                        lines, or a strand_id";
            return Err(what.to_owned());
        }
    };
    let in_order = |index: &u32| points[*index as usize];
    Ok(Polylines {
        points: order.iter().map(in_order).collect(),
        colors: (!colors.is_empty()).then(|| order.iter().map(|index| colors[*index as usize]).collect()),
        starts,
        root_uv: None,
    })
}

/// The points of all chains, from those that no other one precedes.
fn chains(next: &[u32]) -> Result<(Vec<u32>, Vec<u32>), String> {
    let mut has_before = vec![false; next.len()];
    next.iter().filter(|next| **next != u32::MAX).for_each(|next| has_before[*next as usize] = true);
    let (mut order, mut starts) = (Vec::new(), vec![0]);
    let mut linked = 0;
    for first in 0..next.len() {
        // A point alone is no strand.
        if has_before[first] || next[first] == u32::MAX {
            linked += usize::from(has_before[first]);
            continue;
        }
        linked += 1;
        let mut point = first as u32;
        while point != u32::MAX {
            order.push(point);
            point = next[point as usize];
        }
        starts.push(order.len() as u32);
    }
    if order.len() == linked { Ok((order, starts)) } else { Err("some of its edges are a loop".to_owned()) }
}

fn index(number: f64, count: usize) -> Result<usize, String> {
    if number >= 0.0 && number < count as f64 && number.fract() == 0.0 {
        Ok(number as usize)
    } else {
        Err(format!("there is no vertex {number}: there are {count}"))
    }
}

/// A byte of sRGB in linear light (IEC 61966-2-1).
fn linear(byte: f64) -> f32 {
    let x = byte / 255.0;
    (if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
}
