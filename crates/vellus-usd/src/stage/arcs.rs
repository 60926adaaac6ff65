//! Refuses prims that bring in themselves, before `openusd` composes them.
//!
//! A prim brings in others by arcs: references, payloads, and classes, which it inherits or specializes. `openusd`
//! finds circles of references to root prims. Others keep it busy without end. This module follows the arcs as
//! composition does, but only collects the prims. It needs the arcs of each layer for that, which are collected when
//! the layer is read.

use super::files::Files;
use crate::error::Invalid;
use std::cell::{Cell, RefCell};
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// The longest chain of prims that bring in the next.
const LONGEST_CHAIN: usize = 100;

/// The largest number of prims that are followed for one prim.
const MOST_PRIMS: usize = 20_000;

/// A layer or a prim that another prim brings in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Arc {
    /// Whether the prim inherits or specializes the other.
    pub is_class: bool,
    /// The path of the layer, if it is not the same.
    pub layer: Option<String>,
    /// The path of the prim, if it is not the default prim.
    pub prim: Option<String>,
}

/// The arcs of a layer.
#[derive(Debug, Default)]
pub(super) struct LayerArcs {
    pub default_prim: Option<String>,
    pub sublayers: Vec<String>,
    /// By the path of the prim. The arcs of all variants belong to the prim.
    by_prim: HashMap<String, Vec<Arc>>,
    has_classes: bool,
    /// Whether an arc leads to a prim below a root prim.
    goes_deep: bool,
}

impl LayerArcs {
    /// Adds an arc of a prim.
    pub fn add(&mut self, prim: String, arc: Arc) {
        self.has_classes |= arc.is_class;
        self.goes_deep |= arc.prim.as_deref().is_some_and(is_deep);
        self.by_prim.entry(prim).or_default().push(arc);
    }

    /// Sets the prim of the layer that the last arc of a prim brings in.
    pub fn complete(&mut self, prim: &str, target: &str) {
        if let Some(last) = self.by_prim.get_mut(prim).and_then(|arcs| arcs.last_mut()) {
            last.prim = Some(target.to_owned());
            self.goes_deep |= is_deep(target);
        }
    }

    /// The arcs of a prim.
    pub fn of(&self, prim: &str) -> &[Arc] {
        self.by_prim.get(prim).map_or(&[], |arcs| arcs)
    }

    /// The number of prims that have arcs.
    #[cfg(test)]
    pub fn prims(&self) -> usize {
        self.by_prim.len()
    }
}

/// A prim of a layer and its sublayers.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Site {
    layer: String,
    prim: String,
}

/// A site that composition brings in, and the arc that does: from the prim `source`, which is a prim of the previous
/// site or an ancestor of it, to `target`, which is the same for this one.
struct Step {
    site: Site,
    source: String,
    target: String,
    is_class: bool,
}

/// The arcs of all layers that were read.
#[derive(Default)]
pub(super) struct Arcs {
    layers: RefCell<HashMap<String, Rc<LayerArcs>>>,
    has_classes: Cell<bool>,
    /// Whether there can be circles that `openusd` does not find.
    needs_checks: Cell<bool>,
    /// The prim that is composed.
    prim: RefCell<String>,
    /// The prims that were checked.
    checked: RefCell<HashSet<String>>,
}

impl Arcs {
    /// Adds a layer. Composition may go on after that: checks the prim that is composed again.
    pub fn add(&self, files: &Files, layer: &str, arcs: Rc<LayerArcs>) -> Result<(), Invalid> {
        self.has_classes.set(self.has_classes.get() || arcs.has_classes);
        self.needs_checks.set(self.needs_checks.get() || arcs.has_classes || arcs.goes_deep);
        self.layers.borrow_mut().insert(layer.to_owned(), arcs);
        self.checked.borrow_mut().clear();
        let result = self.follow_from(files, &self.prim.borrow());
        if result.is_err() {
            // The layer is not read, so what it would bring in is not composed.
            self.layers.borrow_mut().remove(layer);
        }
        result
    }

    /// Whether a prim of the layers that were read inherits or specializes others.
    pub fn has_classes(&self) -> bool {
        self.has_classes.get()
    }

    /// Checks a prim.
    pub fn check(&self, files: &Files, prim: &str) -> Result<(), Invalid> {
        self.begin(prim);
        if !self.needs_checks.get() || self.checked.borrow().contains(prim) {
            return Ok(());
        }
        self.follow_from(files, prim)?;
        self.checked.borrow_mut().insert(prim.to_owned());
        Ok(())
    }

    /// Notes the prim that is composed from now on.
    fn begin(&self, prim: &str) {
        prim.clone_into(&mut self.prim.borrow_mut());
    }

    fn follow_from(&self, files: &Files, prim: &str) -> Result<(), Invalid> {
        if !self.needs_checks.get() {
            return Ok(());
        }
        let layers = self.layers.borrow();
        let top = files.top_layer().filter(|layer| layers.contains_key(layer));
        let Some(layer) = top.filter(|_| !prim.is_empty()) else { return Ok(()) };
        let start = Step {
            site: Site { layer, prim: prim.to_owned() },
            source: String::new(),
            target: String::new(),
            is_class: false,
        };
        let mut walk = Walk { files, layers: &layers, chain: Vec::new(), done: HashSet::new(), rest: MOST_PRIMS };
        walk.follow(start).map(|_| ())
    }
}

/// A walk along the arcs from one prim.
struct Walk<'a> {
    files: &'a Files,
    layers: &'a HashMap<String, Rc<LayerArcs>>,
    /// The sites that lead to the current one.
    chain: Vec<Step>,
    /// Sites that were followed, and that lead to no class.
    done: HashSet<Site>,
    /// How many sites may be followed.
    rest: usize,
}

impl Walk<'_> {
    /// Follows the arcs of a site and its ancestors. Returns whether it leads to a class: then what it brings in
    /// depends on the chain.
    fn follow(&mut self, step: Step) -> Result<bool, Invalid> {
        let site = step.site.clone();
        if self.done.contains(&site) {
            return Ok(false);
        }
        let first = self.chain.first().map_or(&site, |step| &step.site).prim.clone();
        if self.chain.len() > LONGEST_CHAIN {
            let what = format!("more than {LONGEST_CHAIN} prims that inherit, specialize or refer to the next");
            return Err(format!("{first} begins a chain of {what}").into());
        }
        self.rest = self.rest.checked_sub(1).ok_or_else(|| {
            format!("{first} inherits, specializes and refers to more than {MOST_PRIMS} prims, or does so in a circle")
        })?;
        self.chain.push(step);
        let mut has_class = false;
        for next in self.arcs(&site) {
            has_class |= next.is_class;
            if self.is_on_chain(&next.site) {
                let what =
                    "inherits, specializes or refers to itself, through other prims, its parent or its own child";
                return Err(format!("{} {what}", next.site.prim).into());
            }
            has_class |= self.follow(next)?;
        }
        self.chain.pop();
        if !has_class {
            self.done.insert(site);
        }
        Ok(has_class)
    }

    /// Whether the chain has this site, its ancestor or its descendant.
    fn is_on_chain(&self, site: &Site) -> bool {
        let is_nested = |a: &str, b: &str| below(a, b).or(below(b, a)).is_some();
        self.chain.iter().any(|step| step.site.layer == site.layer && is_nested(&step.site.prim, &site.prim))
    }

    /// What a site and its ancestors bring in.
    fn arcs(&self, site: &Site) -> Vec<Step> {
        let mut steps = Vec::new();
        let ends = site.prim.match_indices('/').skip(1).map(|(end, _)| end).chain([site.prim.len()]);
        for layer in self.stack(&site.layer) {
            let arcs = &self.layers[&layer];
            for end in ends.clone() {
                let (source, rest) = site.prim.split_at(end);
                for arc in arcs.of(source) {
                    self.add(site, &layer, source, rest, arc, &mut steps);
                }
            }
        }
        steps
    }

    /// Adds what an arc of a prim of `layer` brings in for its descendant `rest`.
    fn add(&self, site: &Site, layer: &str, source: &str, rest: &str, arc: &Arc, steps: &mut Vec<Step>) {
        let layers = match arc.layer.as_deref() {
            None => vec![site.layer.clone()],
            // It depends on variables.
            Some(path) if path.starts_with('`') => self.layers.keys().cloned().collect(),
            Some(path) => self.known(layer, path).into_iter().collect(),
        };
        for layer in layers {
            let prim = match &arc.prim {
                Some(prim) => absolute(source, prim),
                None => match self.layers[&layer].default_prim.as_deref() {
                    Some(prim) => absolute("", prim),
                    None => continue,
                },
            };
            let step = Step {
                site: Site { layer, prim: format!("{prim}{rest}") },
                source: source.to_owned(),
                target: prim,
                is_class: arc.is_class,
            };
            let implied = if arc.is_class { self.implied(&step.site.prim) } else { Vec::new() };
            steps.push(step);
            steps.extend(implied.into_iter().map(|site| Step {
                target: site.prim.strip_suffix(rest).unwrap_or(&site.prim).to_owned(),
                site,
                source: source.to_owned(),
                is_class: true,
            }));
        }
    }

    /// A class that a site inherits is also inherited by the sites that led there, at its place in their layers.
    fn implied(&self, class: &str) -> Vec<Site> {
        let mut sites = Vec::new();
        let mut prim = class.to_owned();
        for pair in self.chain.windows(2).rev() {
            let [before, step] = pair else { continue };
            if let Some(rest) = below(&prim, &step.target) {
                prim = format!("{}{rest}", step.source);
            }
            // Composition ignores a class that would be its own.
            let is_new = prim != class || before.site.layer != step.site.layer;
            if is_new && prim != before.site.prim {
                sites.push(Site { layer: before.site.layer.clone(), prim: prim.clone() });
            }
        }
        sites
    }

    /// A layer and its sublayers, as far as they were read.
    fn stack(&self, layer: &str) -> Vec<String> {
        let mut stack = vec![layer.to_owned()];
        let mut i = 0;
        while let Some(layer) = stack.get(i).cloned() {
            for path in &self.layers[&layer].sublayers {
                let all = path.starts_with('`').then(|| self.layers.keys().cloned().collect());
                let found: Vec<String> = all.unwrap_or_else(|| self.known(&layer, path).into_iter().collect());
                for found in found {
                    if !stack.contains(&found) {
                        stack.push(found);
                    }
                }
            }
            i += 1;
        }
        stack
    }

    /// A layer that another one names, if it was read.
    fn known(&self, layer: &str, path: &str) -> Option<String> {
        self.files.layer_of(layer, path).filter(|layer| self.layers.contains_key(layer))
    }
}

/// Whether a path does not lead to a root prim.
fn is_deep(prim: &str) -> bool {
    prim.strip_prefix('/').is_none_or(|path| path.contains('/'))
}

/// What follows a prim in the path of its descendant, or of the prim itself.
fn below<'a>(path: &'a str, prim: &str) -> Option<&'a str> {
    path.strip_prefix(prim).filter(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// The path of a prim from a path relative to another one. Without selections of variants.
pub(super) fn absolute(prim: &str, path: &str) -> String {
    let mut absolute = if path.starts_with('/') { String::new() } else { prim.to_owned() };
    let mut inside = false;
    let plain: String = path
        .chars()
        .filter(|&c| {
            inside = c == '{' || inside && c != '}';
            !inside && c != '}'
        })
        .collect();
    for name in plain.split('/') {
        match name {
            "" | "." => {}
            ".." => absolute.truncate(absolute.rfind('/').unwrap_or(0)),
            name => {
                absolute.push('/');
                absolute += name;
            }
        }
    }
    absolute
}
