//! Refuses classes that inherit or specialize themselves, before `openusd` composes them.
//!
//! When `openusd` composes a prim, it first composes the classes of the prim and of its parent as prims of the stage,
//! then the classes of those, and so on. In a circle it would not end, and a long chain takes minutes. This module
//! follows the same classes.

use super::Failure;
use super::files::Files;
use openusd::{sdf, usd};
use std::cell::RefCell;
use std::collections::HashMap;

/// The longest chain of prims that inherit or specialize each other.
const LONGEST_CHAIN: usize = 100;

/// The prims whose classes were followed, with the lengths of their longest chains.
#[derive(Default)]
pub(super) struct Classes(RefCell<HashMap<sdf::Path, usize>>);

impl Classes {
    /// Checks a prim and its ancestors. The stage can compose the prim after that.
    pub fn check(&self, stage: &usd::Stage, files: &Files, prim: &sdf::Path) -> Result<(), Failure> {
        // Most stages have no classes.
        if files.arcs.has_classes() {
            self.follow(stage, files, prim, &mut Vec::new())?;
        }
        // The last one, because composition opens layers that may bring in this prim.
        Ok(files.arcs.check(files, prim.as_str())?)
    }

    /// Checks the prims that a property of a prim leads to: `openusd` composes those that come from a class.
    pub fn check_targets(&self, stage: &usd::Stage, files: &Files, prim: &str, name: &str) -> Result<(), Failure> {
        if !files.arcs.has_classes() {
            return Ok(());
        }
        let sites = |node: &sdf::Path| node.append_property(name).into_iter().collect();
        for target in authored(stage, &sdf::Path::new(prim)?, sites, &["targetPaths", "connectionPaths"])? {
            self.check(stage, files, &target.prim_path())?;
        }
        Ok(())
    }

    /// The length of the longest chain of classes from a prim. `open` has the prims that lead here.
    fn follow(
        &self,
        stage: &usd::Stage,
        files: &Files,
        prim: &sdf::Path,
        open: &mut Vec<sdf::Path>,
    ) -> Result<usize, Failure> {
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
            length = length.max(self.follow(stage, files, &ancestor, open)?);
        }
        files.arcs.check(files, prim.as_str())?;
        for class in classes(stage, &parent, prim)? {
            // The second limit is for the depth of these calls.
            if open.len() <= 4 * LONGEST_CHAIN {
                length = length.max(1 + self.follow(stage, files, &class, open)?);
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

/// The prims that a prim and its parent inherit and specialize. The parent is composed for that.
fn classes(stage: &usd::Stage, parent: &sdf::Path, prim: &sdf::Path) -> Result<Vec<sdf::Path>, Failure> {
    let sites = |node: &sdf::Path| {
        let child = prim.name().and_then(|name| node.append_path(name).ok());
        [Some(node.clone()), child].into_iter().flatten().collect()
    };
    authored(stage, parent, sites, &["inheritPaths", "specializes"])
}

/// The paths that these fields have anywhere in the layers of a prim, as paths of the layer and as paths of the stage.
fn authored(
    stage: &usd::Stage,
    prim: &sdf::Path,
    sites: impl Fn(&sdf::Path) -> Vec<sdf::Path>,
    fields: &[&str],
) -> Result<Vec<sdf::Path>, Failure> {
    let graph = stage.prim_index(prim.clone()).graph()?;
    let mut paths = Vec::new();
    for node in graph.all_nodes() {
        for (layer, _) in stage.node_layer_stack(node) {
            let Some(layer) = stage.layer_identifier(layer) else { continue };
            let Some(layer) = stage.layer(&layer) else { continue };
            for site in sites(node.path()) {
                for field in fields {
                    let Some(value) = layer.data().try_field(&site, field)? else { continue };
                    let sdf::Value::PathListOp(list) = value.into_owned() else { continue };
                    paths.extend(list.flatten().iter().map(|path| site.make_absolute(path)));
                }
            }
        }
    }
    let mapped = |path: &sdf::Path| {
        graph.all_nodes().filter_map(|node| node.map_to_root().map_source_to_target(path)).collect::<Vec<_>>()
    };
    let mut all: Vec<sdf::Path> = paths.iter().flat_map(mapped).collect();
    all.extend(paths);
    all.sort_unstable();
    all.dedup();
    Ok(all)
}
