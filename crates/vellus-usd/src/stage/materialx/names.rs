//! The elements of a MaterialX document by their names, and the definitions of its own nodes.

use super::{UNTYPED, at, name_of};
use crate::error::Invalid;
use roxmltree::Node;
use std::collections::{HashMap, HashSet};
use vellus_io::excerpt;

/// Other nodes that are read as they are, also if the document has their definitions.
const READ: [&str; 6] =
    ["standard_surface", "open_pbr_surface", "UsdPreviewSurface", "image", "tiledimage", "constant"];

/// The elements of a document by their names, and the names of their prims.
pub(super) struct Names<'d> {
    /// By their parents and names.
    pub elements: HashMap<(Node<'d, 'd>, &'d str), Node<'d, 'd>>,
    /// The first output of each node graph.
    pub outputs: HashMap<Node<'d, 'd>, Node<'d, 'd>>,
    /// Names of prims of nodes in graphs. Other prims have the name of their node.
    prims: HashMap<Node<'d, 'd>, String>,
    /// All names of prims.
    pub used: HashSet<String>,
    /// Definitions of nodes and the graphs that implement them, by the name of the definition.
    definitions: HashMap<&'d str, [Node<'d, 'd>; 2]>,
    /// The names of these definitions, by the category and the type of the nodes.
    categories: HashMap<[&'d str; 2], &'d str>,
}

impl<'d> Names<'d> {
    pub fn of(root: Node<'d, 'd>) -> Result<Self, Invalid> {
        let mut names = Names {
            elements: HashMap::new(),
            outputs: HashMap::new(),
            prims: HashMap::new(),
            used: HashSet::new(),
            definitions: HashMap::new(),
            categories: HashMap::new(),
        };
        for node in root.descendants() {
            let (Some(parent), Some(name)) = (node.parent(), node.attribute("name")) else { continue };
            if names.elements.insert((parent, name), node).is_some() {
                return Err(at(node, format!("the name {} is used twice", excerpt(name.as_bytes(), 60))));
            }
        }
        let mut used: HashSet<String> =
            root.children().filter_map(|node| node.attribute("name")).map(str::to_owned).collect();
        for graph in root.children().filter(|node| node.has_tag_name("nodegraph")) {
            names.outputs.extend(graph.children().find(|node| node.has_tag_name("output")).map(|node| (graph, node)));
            for node in graph.children() {
                let [Some(graph), Some(name)] = [graph, node].map(|node| node.attribute("name")) else { continue };
                // A node of the document or of another graph may have the same name.
                let mut prim = format!("{graph}_{name}");
                while !used.insert(prim.clone()) {
                    prim.push('_');
                }
                names.prims.insert(node, prim);
            }
        }
        names.used = used;
        names.define(root);
        Ok(names)
    }

    /// Finds the definitions that node graphs implement: those that the graph names, or an `implementation`.
    fn define(&mut self, root: Node<'d, 'd>) {
        for element in root.children() {
            let graph = match element.tag_name().name() {
                "nodegraph" => Some(element),
                "implementation" => element.attribute("nodegraph").and_then(|name| self.child(root, "nodegraph", name)),
                _ => None,
            };
            let (Some(graph), Some(name)) = (graph, element.attribute("nodedef")) else { continue };
            let Some(definition) = self.child(root, "nodedef", name) else { continue };
            let Some(category) = definition.attribute("node") else { continue };
            if UNTYPED.contains(&category) || READ.contains(&category) {
                continue;
            }
            self.definitions.entry(name).or_insert([definition, graph]);
            let mut outputs = definition.children().filter(|node| node.has_tag_name("output"));
            let kind = match (outputs.next(), outputs.next()) {
                (Some(only), None) => only.attribute("type"),
                (Some(_), Some(_)) => Some("multioutput"),
                _ => definition.attribute("type"),
            };
            self.categories.entry([category, kind.unwrap_or_default()]).or_insert(name);
        }
    }

    /// The definition of a node and the graph that implements it, if the document has them.
    pub fn definition(&self, node: Node<'d, 'd>) -> Option<[Node<'d, 'd>; 2]> {
        let of_type = || self.categories.get(&[node.tag_name().name(), node.attribute("type")?]).copied();
        self.definitions.get(node.attribute("nodedef").or_else(of_type)?).copied()
    }

    /// The name of a node's prim. A node in a graph starts with the graph's name.
    pub fn prim(&self, node: Node<'d, 'd>) -> Result<&str, Invalid> {
        let name = name_of(node)?;
        match (self.prims.get(&node), node.parent()) {
            (Some(prim), Some(graph)) => name_of(graph).map(|_| prim.as_str()),
            _ => Ok(name),
        }
    }

    /// The child of a kind and name.
    pub fn child(&self, parent: Node<'d, 'd>, tag: &str, name: &'d str) -> Option<Node<'d, 'd>> {
        self.elements.get(&(parent, name)).copied().filter(|node| node.has_tag_name(tag))
    }
}
