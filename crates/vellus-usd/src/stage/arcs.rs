//! Refuses classes that inherit or specialize themselves, before `openusd` composes them.
//!
//! When `openusd` composes a prim, it first composes the classes of the prim and of its parent, then the classes of
//! those, and so on. In a circle it would not end, and a long chain takes minutes. This module follows the same arcs.

use super::Failure;
use openusd::{sdf, usd};
use std::cell::RefCell;
use std::collections::HashMap;

/// The longest chain of prims that inherit or specialize each other.
const LONGEST_CHAIN: usize = 100;

/// The prims whose classes were followed, with the lengths of their longest chains.
#[derive(Default)]
pub(super) struct Arcs(RefCell<HashMap<sdf::Path, usize>>);

impl Arcs {
    /// Checks a prim and its ancestors. The stage can compose the prim after that.
    pub fn check(&self, stage: &usd::Stage, prim: &sdf::Path) -> Result<(), Failure> {
        self.follow(stage, prim, &mut Vec::new()).map(|_| ())
    }

    /// The length of the longest chain of classes from a prim. `open` has the prims that lead here.
    fn follow(&self, stage: &usd::Stage, prim: &sdf::Path, open: &mut Vec<sdf::Path>) -> Result<usize, Failure> {
        let Some(parent) = prim.parent() else { return Ok(0) };
        if let Some(&length) = self.0.borrow().get(prim) {
            return Ok(length);
        }
        if open.contains(prim) {
            return Err(Failure(format!(
                "{prim} inherits or specializes itself, through other prims or its own child"
            )));
        }
        open.push(prim.clone());
        let mut length = 0;
        for ancestor in parent.ancestors().collect::<Vec<_>>().into_iter().rev() {
            length = length.max(self.follow(stage, &ancestor, open)?);
        }
        for class in classes(stage, &parent, prim)? {
            // The second limit is for the depth of these calls.
            if open.len() <= 4 * LONGEST_CHAIN {
                length = length.max(1 + self.follow(stage, &class, open)?);
            }
            if length > LONGEST_CHAIN || open.len() > 4 * LONGEST_CHAIN {
                let what = format!("more than {LONGEST_CHAIN} prims that inherit or specialize the next");
                return Err(Failure(format!("{prim} begins a chain of {what}")));
            }
        }
        open.pop();
        self.0.borrow_mut().insert(prim.clone(), length);
        Ok(length)
    }
}

/// The prims that a prim and its parent inherit and specialize, wherever a layer says so, as paths of that layer and as
/// paths of the stage. The parent is composed for that.
fn classes(stage: &usd::Stage, parent: &sdf::Path, prim: &sdf::Path) -> Result<Vec<sdf::Path>, Failure> {
    let graph = stage.prim_index(parent.clone()).graph()?;
    let mut classes = Vec::new();
    for node in graph.all_nodes() {
        let child = prim.name().and_then(|name| node.path().append_path(name).ok());
        for (layer, _) in stage.node_layer_stack(node) {
            let Some(layer) = stage.layer_identifier(layer) else { continue };
            let Some(layer) = stage.layer(&layer) else { continue };
            for site in [Some(node.path()), child.as_ref()].into_iter().flatten() {
                for field in ["inheritPaths", "specializes"] {
                    let Some(value) = layer.data().try_field(site, field)? else { continue };
                    let sdf::Value::PathListOp(list) = value.into_owned() else { continue };
                    classes.extend(list.flatten().iter().map(|class| site.make_absolute(class)));
                }
            }
        }
    }
    let mapped = |class: &sdf::Path| {
        graph.all_nodes().filter_map(|node| node.map_to_root().map_source_to_target(class)).collect::<Vec<_>>()
    };
    let mut all: Vec<sdf::Path> = classes.iter().flat_map(mapped).collect();
    all.extend(classes);
    all.sort_unstable();
    all.dedup();
    Ok(all)
}
