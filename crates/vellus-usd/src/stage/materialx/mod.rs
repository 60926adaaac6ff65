//! Turns a MaterialX document into a text layer of USD: each material becomes a prim under `/MaterialX/Materials`, as
//! OpenUSD's plugin for MaterialX does it. The nodes that a material uses are its children. A node that the document
//! defines by a graph is replaced by a copy of the graph's nodes.

mod names;

use crate::error::Invalid;
use crate::write::encoder::{Encoder, Role};
use crate::write::names::quoted;
use crate::write::text::Text;
use names::Names;
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::{HashMap, HashSet};
use std::io;
use vellus_io::excerpt;

/// The largest number of XML nodes of a document.
const MAX_NODES: u32 = 1 << 20;

/// The deepest nesting of elements. MaterialX needs five.
const MAX_DEPTH: usize = 64;

/// The largest number of attributes of an element. The parser compares each with all others.
const MAX_ATTRIBUTES: usize = 256;

/// The largest number of declarations of XML namespaces, which the parser copies to the elements inside.
const MAX_NAMESPACES: usize = 64;

/// The largest number of nodes and inputs of all materials. Materials that share a node have a copy each.
const MAX_COPIES: usize = 1 << 18;

/// The deepest nesting of nodes that the document defines itself. A definition that uses itself has no end.
const MAX_NESTED: usize = 64;

/// The prim that contains all materials.
pub(crate) const MATERIALS: &str = "/MaterialX/Materials";

/// Types of MaterialX, and those of USD with the number of numbers.
const TYPES: [(&str, &str, usize); 10] = [
    ("float", "float", 1),
    ("integer", "int", 1),
    ("color3", "color3f", 3),
    ("color4", "color4f", 4),
    ("vector2", "float2", 2),
    ("vector3", "float3", 3),
    ("vector4", "float4", 4),
    ("boolean", "bool", 0),
    ("string", "string", 0),
    ("filename", "asset", 0),
];

/// Types of values that no node for fibres or images has. A document may define others (`typedef`).
const OTHER_TYPES: [&str; 21] = [
    "matrix33",
    "matrix44",
    "integerarray",
    "floatarray",
    "color3array",
    "color4array",
    "vector2array",
    "vector3array",
    "vector4array",
    "stringarray",
    "geomname",
    "geomnamearray",
    "booleanarray",
    "material",
    "surfaceshader",
    "displacementshader",
    "volumeshader",
    "lightshader",
    "BSDF",
    "EDF",
    "VDF",
];

/// Nodes whose definition is named after the node alone. Others have the type of their output as a suffix.
const UNTYPED: [&str; 6] = [
    "chiang_hair_bsdf",
    "chiang_hair_roughness",
    "chiang_hair_absorption_from_color",
    "deon_hair_absorption_from_melanin",
    "surface",
    "vellus_fiber_bsdf",
];

/// The text layer of a document.
///
/// # Errors
/// A message with the line if the document is no MaterialX, or has a value or connection that is not valid.
pub(super) fn to_usda(bytes: &[u8]) -> Result<String, Invalid> {
    let text = std::str::from_utf8(bytes).map_err(|error| format!("it is not UTF-8 (byte {})", error.valid_up_to()))?;
    check_size(text)?;
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| format!("broken XML: {error}"))?;
    let root = document.root_element();
    if !root.has_tag_name("materialx") {
        return Err("it is no MaterialX document: its first element must be materialx".into());
    }
    let mut out = Text::new(b"#usda 1.0\n".to_vec());
    let written = write_materials(&mut out, root)?;
    if !written {
        return Err("the document has no surfacematerial".into());
    }
    String::from_utf8(out.finish()).map_err(|error| error.to_string().into())
}

/// Checks what would cost the parser, or the search in its tree, too much time.
fn check_size(text: &str) -> Result<(), Invalid> {
    if text.matches("xmlns").count() > MAX_NAMESPACES {
        return Err(format!("it declares more than {MAX_NAMESPACES} XML namespaces").into());
    }
    let (mut depth, mut rest) = (0usize, text);
    while let Some(start) = rest.find('<') {
        rest = &rest[start..];
        let outside = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("</", ">")];
        if let Some((begin, end)) = outside.into_iter().find(|(begin, _)| rest.starts_with(begin)) {
            if begin == "</" {
                depth = depth.saturating_sub(1);
            }
            let Some(end) = rest[begin.len()..].find(end) else { break };
            rest = &rest[begin.len() + end..];
            continue;
        }
        // The values of attributes may contain `>` and `/`.
        let (mut quote, mut attributes, mut last) = (None, 0, b'<');
        let end = rest.bytes().position(|c| {
            match (quote, c) {
                (None, b'"' | b'\'') => (quote, attributes) = (Some(c), attributes + 1),
                (None, b'>') => return true,
                (Some(open), _) if c == open => quote = None,
                _ => {}
            }
            last = c;
            false
        });
        let line = || text[..text.len() - rest.len()].matches('\n').count() + 1;
        if attributes > MAX_ATTRIBUTES {
            return Err(format!("line {}: an element has more than {MAX_ATTRIBUTES} attributes", line()).into());
        }
        let Some(end) = end else { break };
        if last != b'/' {
            depth += 1;
            if depth > MAX_DEPTH {
                return Err(format!("line {}: more than {MAX_DEPTH} elements are nested", line()).into());
            }
        }
        rest = &rest[end..];
    }
    Ok(())
}

type Out = Text<Vec<u8>>;

fn write_materials(out: &mut Out, root: Node) -> Result<bool, Invalid> {
    let io = |error: io::Error| Invalid::from(error.to_string());
    out.open("Scope", "MaterialX", Role::Plain).map_err(io)?;
    out.open("Scope", "Materials", Role::Plain).map_err(io)?;
    let document = Names::of(root)?;
    let (mut written, mut copies) = (false, 0);
    for material in root.children().filter(|node| node.has_tag_name("surfacematerial")) {
        written = true;
        let name = name_of(material)?;
        out.open("Material", name, Role::Plain).map_err(io)?;
        let path = format!("{MATERIALS}/{name}");
        let mut writer = Writer {
            out,
            root,
            names: &document,
            path,
            instances: Vec::new(),
            inside: HashMap::new(),
            waiting: Vec::new(),
            known: HashMap::new(),
            used: HashSet::new(),
        };
        if let Some(surface) = document.child(material, "input", "surfaceshader")
            && let Some(source) = writer.source(surface, None)?
        {
            writer.out.line(&format!("token outputs:mtlx:surface.connect = <{source}>")).map_err(io)?;
        }
        while let Some(node) = writer.waiting.pop() {
            copies += 1 + writer.node(node)?;
            if copies > MAX_COPIES {
                return Err(format!("its materials have more than {MAX_COPIES} nodes and inputs").into());
            }
        }
        out.close().map_err(io)?;
    }
    out.close().map_err(io)?;
    out.close().map_err(io)?;
    Ok(written)
}

/// A node that the document defines by a graph. The nodes of the graph are copied for each.
struct Instance<'d> {
    node: Node<'d, 'd>,
    definition: Node<'d, 'd>,
    graph: Node<'d, 'd>,
    /// The instance whose graph has the node.
    outer: Option<usize>,
    /// The number of instances around it.
    depth: usize,
}

/// A node, and the index of the instance that it is copied for.
type Copy<'d> = (Node<'d, 'd>, Option<usize>);

/// Writes one material and all nodes that it uses.
struct Writer<'t, 'd> {
    out: &'t mut Out,
    root: Node<'d, 'd>,
    names: &'t Names<'d>,
    /// The prim of the material.
    path: String,
    instances: Vec<Instance<'d>>,
    /// The indices of instances by their nodes.
    inside: HashMap<Copy<'d>, usize>,
    /// Nodes that are referred to and not written yet.
    waiting: Vec<Copy<'d>>,
    /// The names of the prims of all nodes that were referred to.
    known: HashMap<Copy<'d>, String>,
    /// Names of prims of nodes that are copied for instances.
    used: HashSet<String>,
}

impl<'d> Writer<'_, 'd> {
    /// The input whose value or connection an input has, and the instance that this one is in. An input of a node in a
    /// graph may have that of the graph, or that of the node which the graph implements.
    fn resolve(&self, input: Node<'d, 'd>, within: Option<usize>) -> Result<Copy<'d>, Invalid> {
        let (mut input, mut within) = (input, within);
        while let Some(name) = input.attribute("interfacename") {
            let graph = input.parent().and_then(|node| node.parent());
            let of = |element: Node<'d, 'd>| self.names.child(element, "input", name);
            let instance = within.map(|i| &self.instances[i]).filter(|instance| Some(instance.graph) == graph);
            let found = match instance {
                Some(Instance { node, definition, outer, .. }) => {
                    of(*node).or_else(|| of(*definition)).map(|found| (found, *outer))
                }
                None => graph.and_then(of).map(|found| (found, within)),
            };
            (input, within) = found.ok_or_else(|| at(input, format!("the node graph has no input {name}")))?;
        }
        Ok((input, within))
    }

    /// The output that an input is connected to, as a path. The input may belong to a node or a node graph.
    fn source(&mut self, input: Node<'d, 'd>, within: Option<usize>) -> Result<Option<String>, Invalid> {
        let (input, mut within) = self.resolve(input, within)?;
        let scope = input.parent().and_then(|node| node.parent()).unwrap_or(self.root);
        let (mut scope, mut name, mut output) = match (input.attribute("nodename"), input.attribute("nodegraph")) {
            (Some(name), _) => (scope, name, input.attribute("output")),
            (None, Some(graph)) => {
                let found = self.names.child(self.root, "nodegraph", graph);
                let found = found.ok_or_else(|| at(input, format!("there is no node graph {graph}")))?;
                let result = self.result(input, found, input.attribute("output"))?;
                let Some(name) = result.attribute("nodename") else { return Ok(None) };
                (found, name, result.attribute("output"))
            }
            (None, None) => return Ok(None),
        };
        let node = loop {
            let node = self.names.elements.get(&(scope, name)).copied();
            let node = node.ok_or_else(|| at(input, format!("there is no node {name}")))?;
            let Some([definition, graph]) = self.names.definition(node) else { break node };
            let result = self.result(input, graph, output)?;
            let Some(inner) = result.attribute("nodename") else { return Ok(None) };
            within = Some(self.instance(node, definition, graph, within)?);
            (scope, name, output) = (graph, inner, result.attribute("output"));
        };
        let output = output.unwrap_or("out");
        check_name(input, output)?;
        let prim = self.prim((node, within))?.to_owned();
        Ok(Some(format!("{}/{prim}.outputs:{output}", self.path)))
    }

    /// The output of a node graph. `None` is its first one.
    fn result(&self, from: Node, graph: Node<'d, 'd>, output: Option<&'d str>) -> Result<Node<'d, 'd>, Invalid> {
        let found = match output {
            Some(output) => self.names.child(graph, "output", output),
            None => self.names.outputs.get(&graph).copied(),
        };
        let name = graph.attribute("name").unwrap_or_default();
        found.ok_or_else(|| at(from, format!("the node graph {name} has no such output")))
    }

    /// The index of the instance of a node with a definition.
    fn instance(
        &mut self,
        node: Node<'d, 'd>,
        definition: Node<'d, 'd>,
        graph: Node<'d, 'd>,
        outer: Option<usize>,
    ) -> Result<usize, Invalid> {
        if let Some(&known) = self.inside.get(&(node, outer)) {
            return Ok(known);
        }
        let depth = outer.map_or(0, |outer| self.instances[outer].depth + 1);
        if depth >= MAX_NESTED {
            return Err(at(node, format!("more than {MAX_NESTED} nodes with a definition are nested")));
        }
        if self.instances.len() >= MAX_COPIES {
            return Err(at(node, format!("a material has more than {MAX_COPIES} nodes with a definition")));
        }
        self.instances.push(Instance { node, definition, graph, outer, depth });
        self.inside.insert((node, outer), self.instances.len() - 1);
        Ok(self.instances.len() - 1)
    }

    /// The name of the prim of a node. A node that was not referred to before is written later.
    fn prim(&mut self, copy: Copy<'d>) -> Result<&str, Invalid> {
        if !self.known.contains_key(&copy) {
            let (node, within) = copy;
            let prim = match within {
                None => self.names.prim(node)?.to_owned(),
                Some(i) => {
                    let Instance { node: of, outer, .. } = self.instances[i];
                    let number = outer.map_or(String::new(), |_| format!("{i}_"));
                    let mut prim = format!("{}_{number}{}", name_of(of)?, name_of(node)?);
                    while self.names.used.contains(&prim) || !self.used.insert(prim.clone()) {
                        prim.push('_');
                    }
                    prim
                }
            };
            self.known.insert(copy, prim);
            self.waiting.push(copy);
        }
        Ok(&self.known[&copy])
    }

    /// Writes a node, and returns the number of its inputs.
    fn node(&mut self, (node, within): Copy<'d>) -> Result<usize, Invalid> {
        let io = |error: io::Error| Invalid::from(error.to_string());
        let name = &self.known[&(node, within)];
        self.out.open("Shader", name, Role::Plain).map_err(io)?;
        let (category, kind) = (node.tag_name().name(), node.attribute("type").unwrap_or_default());
        let id = match node.attribute("nodedef") {
            Some(id) => id.to_owned(),
            None if UNTYPED.contains(&category) => format!("ND_{category}"),
            None => format!("ND_{category}_{kind}"),
        };
        self.out.line(&format!("uniform token info:id = {}", quoted(&id))).map_err(io)?;
        let mut inputs = 0;
        for input in node.children().filter(|child| child.has_tag_name("input")) {
            self.input(node, input, within)?;
            inputs += 1;
        }
        self.out.close().map_err(io)?;
        Ok(inputs)
    }

    fn input(&mut self, node: Node<'d, 'd>, input: Node<'d, 'd>, within: Option<usize>) -> Result<(), Invalid> {
        let io = |error: io::Error| Invalid::from(error.to_string());
        let name = name_of(input)?;
        let (value_of, kind) = (self.resolve(input, within)?.0, input.attribute("type").unwrap_or_default());
        if let Some(source) = self.source(input, within)? {
            return self.out.line(&format!("token inputs:{name}.connect = <{source}>")).map_err(io);
        }
        let Some(value) = value_of.attribute("value") else { return Ok(()) };
        let Some((_, usd, count)) = TYPES.iter().find(|(known, ..)| *known == kind) else {
            let defined = || self.names.child(self.root, "typedef", kind).is_some();
            if OTHER_TYPES.contains(&kind) || defined() {
                return Ok(());
            }
            return Err(at(input, format!("{name} has the unknown type {}", excerpt(kind.as_bytes(), 60))));
        };
        let value = if kind == "string" { value } else { value.trim() };
        let literal = match kind {
            "boolean" if ["true", "false"].contains(&value) => value.to_owned(),
            "boolean" => return Err(at(value_of, format!("{name} must be true or false"))),
            "integer" => match value.parse::<i32>() {
                Ok(number) => number.to_string(),
                Err(_) => return Err(at(value_of, format!("{name} must be an integer"))),
            },
            "string" => quoted(value),
            "filename" if value.is_empty() => return Ok(()),
            "filename" => asset(value_of, value)?,
            _ => numbers(value_of, value, *count)?,
        };
        let space = match kind {
            "filename" => file_space(node, value_of),
            "color3" | "color4" => nearest(value_of, "colorspace"),
            _ => None,
        };
        let space = space.map_or(String::new(), |space| format!(" ( colorSpace = {} )", quoted(space)));
        self.out.line(&format!("{usd} inputs:{name} = {literal}{space}")).map_err(io)
    }
}

/// An attribute of an element, or of the nearest element around it that has it.
fn nearest<'a>(node: Node<'a, 'a>, attribute: &str) -> Option<&'a str> {
    node.ancestors().find_map(|ancestor| ancestor.attribute(attribute))
}

/// The colour space of a file: that of the input, or the nearest one if the node gives colours.
fn file_space<'a>(node: Node<'a, 'a>, input: Node<'a, 'a>) -> Option<&'a str> {
    let is_color = node.attribute("type").is_some_and(|kind| kind.starts_with("color"));
    input.attribute("colorspace").or_else(|| if is_color { nearest(input, "colorspace") } else { None })
}

/// Numbers that are separated by commas or spaces, as a value or a tuple.
fn numbers(input: Node, value: &str, count: usize) -> Result<String, Invalid> {
    let wrong = || at(input, format!("{} must have {count} finite numbers", input.attribute("name").unwrap_or("")));
    let parts = value.split(|c: char| c == ',' || c.is_whitespace()).filter(|x| !x.is_empty());
    let numbers = parts.map(|x| x.parse::<f32>().ok().filter(|x| x.is_finite()));
    let numbers = numbers.collect::<Option<Vec<f32>>>().filter(|all| all.len() == count).ok_or_else(wrong)?;
    let texts: Vec<String> = numbers.iter().map(f32::to_string).collect();
    Ok(if count == 1 { texts.concat() } else { format!("({})", texts.join(", ")) })
}

/// The path of a file, with the nearest prefix. A prefix replaces those of the elements around it
/// (`Element::getActiveFilePrefix` of MaterialX).
fn asset(input: Node, value: &str) -> Result<String, Invalid> {
    let path = nearest(input, "fileprefix").unwrap_or_default().to_owned() + value;
    if path.contains('@') || path.chars().any(char::is_control) {
        return Err(at(input, "the name of a file must have no @ and no control characters".to_owned()));
    }
    Ok(format!("@{path}@"))
}

fn name_of<'a>(node: Node<'a, 'a>) -> Result<&'a str, Invalid> {
    let name = node.attribute("name").unwrap_or_default();
    check_name(node, name)?;
    Ok(name)
}

fn check_name(node: Node, name: &str) -> Result<(), Invalid> {
    let starts = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if starts && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Ok(());
    }
    Err(at(node, format!("{name:?} is no name: a name has only letters, digits and underscores")))
}

/// A message with the line of an element.
fn at(node: Node, what: String) -> Invalid {
    format!("line {}: {what}", node.document().text_pos_at(node.range().start).row).into()
}
