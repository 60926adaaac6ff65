//! Refuses classes that inherit or specialize themselves, before `openusd` composes them.
//!
//! When `openusd` composes a prim, it first composes the classes of the prim and of its parent, then the classes of
//! those, and so on. In a circle it would not end, and a long chain takes minutes. This module follows the same arcs.

use super::Failure;
use openusd::{sdf, usd};
use std::cell::RefCell;
use std::collections::HashSet;

/// The longest chain of prims that inherit or specialize each other.
const LONGEST_CHAIN: usize = 100;

/// The prims whose classes were followed.
#[derive(Default)]
pub(super) struct Arcs(RefCell<HashSet<sdf::Path>>);

impl Arcs {
    /// Checks a prim and its ancestors. The stage can compose the prim after that.
    pub fn check(&self, stage: &usd::Stage, prim: &sdf::Path) -> Result<(), Failure> {
        self.follow(stage, prim, &mut Vec::new())
    }

    /// `chain` has the prims that lead here.
    fn follow(&self, stage: &usd::Stage, prim: &sdf::Path, chain: &mut Vec<sdf::Path>) -> Result<(), Failure> {
        let Some(parent) = prim.parent().filter(|_| !self.0.borrow().contains(prim)) else { return Ok(()) };
        if chain.contains(prim) {
            return Err(Failure(format!(
                "{prim} inherits or specializes itself, through other prims or its own child"
            )));
        }
        if chain.len() == LONGEST_CHAIN {
            let (from, to) = (&chain[0], prim);
            let what = format!("from {from} to {to}, more than {LONGEST_CHAIN} prims inherit or specialize each other");
            return Err(Failure(what));
        }
        chain.push(prim.clone());
        // Ancestors are not part of a chain: they only make it longer if a class is deep in the hierarchy.
        for ancestor in parent.ancestors().collect::<Vec<_>>().into_iter().rev() {
            self.follow(stage, &ancestor, chain)?;
        }
        for class in classes(stage, &parent, prim)? {
            self.follow(stage, &class, chain)?;
        }
        chain.pop();
        self.0.borrow_mut().insert(prim.clone());
        Ok(())
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
