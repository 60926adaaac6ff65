//! Lists of arcs in the text of a layer.

use super::arcs::{Arc, LayerArcs};
use crate::error::Invalid;

/// The largest number of layers or prims in a list of arcs. Composition compares each with each.
pub(super) const MOST_ARCS: usize = 1000;

/// A list of arcs that is open.
pub(super) struct ArcList<'a> {
    pub field: &'a str,
    /// The depth of the field.
    pub depth: usize,
    /// The number of its layers and prims.
    pub count: usize,
    /// Whether the last item is a layer, whose prim may follow.
    pub after_layer: bool,
}

impl ArcList<'_> {
    /// Adds a layer, or a prim of it or of the layer that has the list.
    pub fn add(&mut self, arcs: &mut LayerArcs, prims: &[(usize, String)], item: Item) -> Result<(), Invalid> {
        self.count += 1;
        // A reference may have both a layer and a prim.
        if self.count > 2 * MOST_ARCS {
            return Err(format!("a prim or layer has more than {MOST_ARCS} references, payloads or classes").into());
        }
        let of = || prims.iter().map(|(_, name)| format!("/{name}")).collect::<String>();
        let is_class = is_class(self.field);
        match item {
            Item::Layer(path) if self.field == "subLayers" => arcs.sublayers.push(path.to_owned()),
            Item::Layer(path) => arcs.add(of(), Arc { is_class, layer: Some(path.to_owned()), prim: None }),
            Item::Prim(prim) if self.after_layer => arcs.complete(&of(), prim),
            Item::Prim(prim) => arcs.add(of(), Arc { is_class, layer: None, prim: Some(prim.to_owned()) }),
        }
        self.after_layer = matches!(item, Item::Layer(_));
        Ok(())
    }
}

/// An item of a list of arcs.
#[derive(Clone, Copy)]
pub(super) enum Item<'a> {
    Layer(&'a str),
    Prim(&'a str),
}

/// Whether this field is a list of layers or prims that composition brings in.
pub(super) fn is_arc(field: &str) -> bool {
    matches!(field, "references" | "payload" | "subLayers") || is_class(field)
}

fn is_class(field: &str) -> bool {
    matches!(field, "inherits" | "specializes")
}
