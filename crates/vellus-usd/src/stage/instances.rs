//! Instances that share a prototype.

use openusd::pcp::{Node, PrimIndex};
use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;

/// The instances of a stage, and those whose content is the same as that of an earlier one.
///
/// `openusd` composes the content of each instance again. Levels of instances inside instances would take a time that
/// grows exponentially with their number, for a file of a few kilobytes. Here the content is composed for the first
/// instance of a prototype only, and questions about the others are asked about it.
#[derive(Default)]
pub(super) struct Instances {
    /// The prototype of each instance that was visited.
    prototypes: HashMap<String, String>,
    /// The first instance of each prototype, and the indices of its content in the list of prims.
    first: HashMap<String, (String, Range<usize>)>,
    /// First instances whose content is not complete, from outside to inside.
    open: Vec<String>,
    /// The first instance for each later one.
    repeated: HashMap<String, String>,
}

impl Instances {
    /// Visits an instance, which is the last of the prims so far, depth first. If its content is known, returns the
    /// length of the path of the first instance, and the indices of its content.
    pub fn visit(&mut self, prim: &str, prototype: &str, prims: &[String]) -> Option<(usize, Range<usize>)> {
        self.prototypes.insert(prim.to_owned(), prototype.to_owned());
        while let Some(root) = self.open.pop_if(|root| !is_inside(prim, &self.first[root].0)) {
            let known = self.first.get_mut(&root)?;
            // What follows the content of an instance is not inside.
            known.1.end = known.1.start + prims[known.1.start..].partition_point(|other| is_inside(other, &known.0));
        }
        match self.first.get(prototype) {
            // An instance that contains itself cannot be composed, so this does not happen.
            Some(_) if self.open.iter().any(|open| open == prototype) => None,
            Some((root, content)) => {
                self.repeated.insert(prim.to_owned(), root.clone());
                Some((root.len(), content.clone()))
            }
            None => {
                self.first.insert(prototype.to_owned(), (prim.to_owned(), prims.len()..prims.len()));
                self.open.push(prototype.to_owned());
                None
            }
        }
    }

    /// The prototype of a prim, if it is an instance.
    pub fn prototype(&self, prim: &str) -> Option<String> {
        self.prototypes.get(&*self.composed(prim).0).cloned()
    }

    /// The path under which a prim is composed, and the instances that were replaced for that, one after the other.
    pub fn composed<'p>(&self, prim: &'p str) -> (Cow<'p, str>, Vec<(&str, &str)>) {
        let (mut path, mut replaced) = (Cow::Borrowed(prim), Vec::new());
        if self.repeated.is_empty() {
            return (path, replaced);
        }
        // The end of an ancestor. The content of an instance is shared, but not the instance itself.
        let mut end = 0;
        while let Some(next) = path[end + 1..].find('/').map(|at| end + 1 + at) {
            end = next;
            if let Some((from, to)) = self.repeated.get_key_value(&path[..end]) {
                path = Cow::Owned(format!("{to}{}", &path[end..]));
                end = to.len();
                replaced.push((from.as_str(), to.as_str()));
            }
        }
        (path, replaced)
    }

    /// The path of a prim where `other` is composed.
    pub fn composed_with(&self, other: &str, prim: &str) -> String {
        let mut path = prim.to_owned();
        for (from, to) in self.composed(other).1 {
            if path == from || is_inside(&path, from) {
                path.replace_range(..from.len(), to);
            }
        }
        path
    }

    /// The path of a target as a prim sees it, from its path as the composed prim sees it.
    pub fn seen_from(&self, prim: &str, target: &str) -> String {
        let mut path = target.to_owned();
        for (from, to) in self.composed(prim).1.into_iter().rev() {
            if path == to || is_inside(&path, to) {
                path.replace_range(..to.len(), from);
            }
        }
        path
    }
}

/// The prototype of an instance: the sites that its own arcs, and the arcs of these, bring in. Arcs of its ancestors do
/// not count (`PcpInstanceKey` of OpenUSD). The prototypes of `openusd` also differ by the classes of ancestors, and to
/// ask for one takes a time that grows with the number of its instances.
pub(super) fn prototype(index: &PrimIndex) -> String {
    let mut key = String::new();
    for node in index.nodes().filter(|node| !is_above(index, node)) {
        let offset = node.map_to_root().time_offset();
        let (layer, arc, path) = (node.layer_id(), node.arc(), node.path());
        key += &format!("{arc:?} {layer:?} {path} {} {}\n", offset.offset, offset.scale);
    }
    key
}

/// Whether a node is the prim itself, or comes from an arc above the prim.
fn is_above(index: &PrimIndex, node: &Node) -> bool {
    let Some(parent) = node.parent() else { return true };
    let parent = index.node(parent);
    let is_due_to_ancestor = parent.path().prim_element_count() > usize::from(node.namespace_depth());
    is_due_to_ancestor && is_above(index, parent)
}

/// Whether a prim is a descendant of another one.
fn is_inside(prim: &str, other: &str) -> bool {
    prim.strip_prefix(other).is_some_and(|rest| rest.starts_with('/'))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of two instances of B has two instances of A, which have one prim.
    #[test]
    fn content_is_composed_once_and_targets_are_seen_from_each_instance() {
        let mut instances = Instances::default();
        let mut prims: Vec<String> = Vec::new();
        for (prim, prototype) in [("/b", "B"), ("/b/a", "A"), ("/b/a/x", ""), ("/b/c", "A"), ("/d", "B"), ("/e", "")] {
            prims.push(prim.to_owned());
            if prototype.is_empty() {
                continue;
            }
            if let Some((root, content)) = instances.visit(prim, prototype, &prims) {
                for i in content {
                    prims.push(format!("{prim}{}", &prims[i][root..]));
                }
            }
        }
        assert_eq!(prims, ["/b", "/b/a", "/b/a/x", "/b/c", "/b/c/x", "/d", "/d/a", "/d/a/x", "/d/c", "/d/c/x", "/e"]);
        let composed = ["/b", "/b/a", "/b/a/x", "/b/c", "/b/a/x", "/d", "/b/a", "/b/a/x", "/b/c", "/b/a/x", "/e"];
        for (prim, composed) in prims.iter().zip(composed) {
            assert_eq!(instances.composed(prim).0, composed, "{prim}");
        }
        assert_eq!(instances.prototype("/d/c").as_deref(), Some("A"));
        assert_eq!(instances.prototype("/d/c/x"), None);
        // A target inside, one in the outer instance, and one outside of both.
        for (target, seen) in [("/b/a/x", "/d/c/x"), ("/b/a", "/d/c"), ("/b/y", "/d/y"), ("/b", "/d"), ("/e", "/e")] {
            assert_eq!(instances.seen_from("/d/c/x", target), seen);
            assert_eq!(instances.composed_with("/d/c/x", seen), target);
        }
    }
}
