//! Turns a MaterialX document into a text layer of USD: each material becomes a prim under `/MaterialX/Materials`, as
//! OpenUSD's plugin for MaterialX does it. The nodes that a material uses are its children.

use crate::error::Invalid;
use crate::write::text::{Text, quoted};
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::{HashMap, HashSet};
use std::io;

/// The largest number of XML nodes of a document.
const MAX_NODES: u32 = 1 << 20;

/// The largest number of nodes of all materials. Materials that share a node have a copy each.
const MAX_COPIES: usize = 1 << 16;

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

/// Nodes whose definition is named after the node alone. Others have the type of their output as a suffix.
const UNTYPED: [&str; 5] = [
    "chiang_hair_bsdf",
    "chiang_hair_roughness",
    "chiang_hair_absorption_from_color",
    "deon_hair_absorption_from_melanin",
    "surface",
];

/// The text layer of a document.
///
/// # Errors
/// A message with the line if the document is no MaterialX, or has a value or connection that is not valid.
pub(super) fn to_usda(bytes: &[u8]) -> Result<String, Invalid> {
    let text = std::str::from_utf8(bytes).map_err(|error| format!("it is not UTF-8 (byte {})", error.valid_up_to()))?;
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
    let text = out.finish().map_err(|error| error.to_string())?;
    String::from_utf8(text).map_err(|error| error.to_string().into())
}

type Out = Text<Vec<u8>>;

fn write_materials(out: &mut Out, root: Node) -> Result<bool, Invalid> {
    let io = |error: io::Error| Invalid::from(error.to_string());
    out.open("Scope", "MaterialX", "").map_err(io)?;
    out.open("Scope", "Materials", "").map_err(io)?;
    let named = root.descendants().filter_map(|node| Some(((node.parent()?, node.attribute("name")?), node)));
    let document = Names(named.collect());
    let (mut written, mut copies) = (false, 0);
    for material in root.children().filter(|node| node.has_tag_name("surfacematerial")) {
        written = true;
        let name = name_of(material)?;
        out.open("Material", name, "").map_err(io)?;
        let path = format!("{MATERIALS}/{name}");
        let mut writer = Writer { out, root, names: &document, path, waiting: Vec::new(), known: HashSet::new() };
        if let Some(surface) = document.child(material, "input", "surfaceshader")
            && let Some(source) = writer.source(surface)?
        {
            writer.out.line(&format!("token outputs:mtlx:surface.connect = <{source}>")).map_err(io)?;
        }
        while let Some(node) = writer.waiting.pop() {
            copies += 1;
            if copies > MAX_COPIES {
                return Err(format!("its materials have more than {MAX_COPIES} nodes").into());
            }
            writer.node(node)?;
        }
        out.close().map_err(io)?;
    }
    out.close().map_err(io)?;
    out.close().map_err(io)?;
    Ok(written)
}

/// The elements of a document, by their parents and names.
struct Names<'d>(HashMap<(Node<'d, 'd>, &'d str), Node<'d, 'd>>);

impl<'d> Names<'d> {
    /// The child of a kind and name.
    fn child(&self, parent: Node<'d, 'd>, tag: &str, name: &'d str) -> Option<Node<'d, 'd>> {
        self.0.get(&(parent, name)).copied().filter(|node| node.has_tag_name(tag))
    }
}

/// Writes one material and all nodes that it uses.
struct Writer<'t, 'd> {
    out: &'t mut Out,
    root: Node<'d, 'd>,
    names: &'t Names<'d>,
    /// The prim of the material.
    path: String,
    /// Nodes that are referred to and not written yet.
    waiting: Vec<Node<'d, 'd>>,
    /// All nodes that were referred to.
    known: HashSet<Node<'d, 'd>>,
}

impl<'d> Writer<'_, 'd> {
    /// The output that an input is connected to, as a path. The input may belong to a node or a node graph.
    fn source(&mut self, input: Node<'d, 'd>) -> Result<Option<String>, Invalid> {
        let mut input = input;
        // An input of a node in a graph may have the value of an input of the graph.
        if let Some(interface) = input.attribute("interfacename") {
            let graph = input.parent().and_then(|node| node.parent());
            let found = graph.and_then(|graph| self.names.child(graph, "input", interface));
            input = found.ok_or_else(|| at(input, format!("the node graph has no input {interface}")))?;
        }
        let scope = input.parent().and_then(|node| node.parent()).unwrap_or(self.root);
        let (scope, name, output) = match (input.attribute("nodename"), input.attribute("nodegraph")) {
            (Some(name), _) => (scope, name, input.attribute("output")),
            (None, Some(graph)) => {
                let found = self.names.child(self.root, "nodegraph", graph);
                let found = found.ok_or_else(|| at(input, format!("there is no node graph {graph}")))?;
                let result = match input.attribute("output") {
                    Some(wanted) => self.names.child(found, "output", wanted),
                    None => found.children().find(|node| node.has_tag_name("output")),
                };
                let result = result.ok_or_else(|| at(input, format!("the node graph {graph} has no such output")))?;
                let Some(name) = result.attribute("nodename") else { return Ok(None) };
                (found, name, result.attribute("output"))
            }
            (None, None) => return Ok(None),
        };
        let node = self.names.0.get(&(scope, name)).copied();
        let node = node.ok_or_else(|| at(input, format!("there is no node {name}")))?;
        if self.known.insert(node) {
            self.waiting.push(node);
        }
        let output = output.unwrap_or("out");
        check_name(input, output)?;
        Ok(Some(format!("{}/{}.outputs:{output}", self.path, prim_name(node)?)))
    }

    fn node(&mut self, node: Node<'d, 'd>) -> Result<(), Invalid> {
        let io = |error: io::Error| Invalid::from(error.to_string());
        let name = prim_name(node)?;
        self.out.open("Shader", &name, "").map_err(io)?;
        let (category, kind) = (node.tag_name().name(), node.attribute("type").unwrap_or_default());
        let id = match node.attribute("nodedef") {
            Some(id) => id.to_owned(),
            None if UNTYPED.contains(&category) => format!("ND_{category}"),
            None => format!("ND_{category}_{kind}"),
        };
        self.out.set("uniform token info:id", &quoted(&id)).map_err(io)?;
        for input in node.children().filter(|child| child.has_tag_name("input")) {
            self.input(node, input)?;
        }
        self.out.close().map_err(io)
    }

    fn input(&mut self, node: Node<'d, 'd>, input: Node<'d, 'd>) -> Result<(), Invalid> {
        let io = |error: io::Error| Invalid::from(error.to_string());
        let name = name_of(input)?;
        let interface =
            input.attribute("interfacename").and_then(|name| self.names.child(node.parent()?, "input", name));
        let (value_of, kind) = (interface.unwrap_or(input), input.attribute("type").unwrap_or_default());
        if let Some(source) = self.source(input)? {
            return self.out.line(&format!("token inputs:{name}.connect = <{source}>")).map_err(io);
        }
        let Some(value) = value_of.attribute("value") else { return Ok(()) };
        let Some((_, usd, count)) = TYPES.iter().find(|(known, ..)| *known == kind) else { return Ok(()) };
        let literal = match kind {
            "boolean" => (value == "true").to_string(),
            "string" => quoted(value),
            "filename" => asset(value_of, value)?,
            _ => numbers(value_of, value, *count)?,
        };
        let space = (kind == "filename").then(|| color_space(node, value_of)).flatten();
        let space = space.map_or(String::new(), |space| format!(" ( colorSpace = {} )", quoted(space)));
        self.out.set(&format!("{usd} inputs:{name}"), &(literal + &space)).map_err(io)
    }
}

/// The colour space of a file: that of the input, or that of the document if the node gives colours.
fn color_space<'a>(node: Node<'a, 'a>, input: Node<'a, 'a>) -> Option<&'a str> {
    let is_color = node.attribute("type").is_some_and(|kind| kind.starts_with("color"));
    let inherited = || node.ancestors().find_map(|ancestor| ancestor.attribute("colorspace"));
    input.attribute("colorspace").or_else(|| if is_color { inherited() } else { None })
}

/// Numbers that are separated by commas, as a value or a tuple.
fn numbers(input: Node, value: &str, count: usize) -> Result<String, Invalid> {
    let wrong = || at(input, format!("{} must have {count} finite numbers", input.attribute("name").unwrap_or("")));
    let numbers = value.split(',').map(|x| x.trim().parse::<f32>().ok().filter(|x| x.is_finite()));
    let numbers = numbers.collect::<Option<Vec<f32>>>().filter(|all| all.len() == count).ok_or_else(wrong)?;
    let texts: Vec<String> = numbers.iter().map(f32::to_string).collect();
    Ok(if count == 1 { texts.concat() } else { format!("({})", texts.join(", ")) })
}

/// The path of a file, with the prefixes of the element and its parents.
fn asset(input: Node, value: &str) -> Result<String, Invalid> {
    let prefixes: Vec<&str> = input.ancestors().filter_map(|node| node.attribute("fileprefix")).collect();
    let path = prefixes.into_iter().rev().collect::<String>() + value;
    if path.contains('@') || path.chars().any(char::is_control) {
        return Err(at(input, "the name of a file must have no @ and no control characters".to_owned()));
    }
    Ok(format!("@{path}@"))
}

/// The name of a node's prim. A node in a graph starts with the graph's name.
fn prim_name(node: Node) -> Result<String, Invalid> {
    let name = name_of(node)?;
    match node.parent().filter(|parent| parent.has_tag_name("nodegraph")) {
        Some(graph) => Ok(format!("{}_{name}", name_of(graph)?)),
        None => Ok(name.to_owned()),
    }
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
