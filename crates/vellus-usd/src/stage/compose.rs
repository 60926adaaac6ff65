//! Which prims a stage has, and what could not be composed.

use super::careful::{parse_errors, repairs};
use super::repair::{Losses, Repairs};
use super::{Failure, Stage, guarded, instances};
use crate::error::Invalid;
use openusd::{pcp, sdf};

/// The largest number of sites of a small stage. Each prim is one site, and so is each reference, payload, inherit and
/// variant of a prim or its ancestors. `openusd` needs 4 to 10 KB and 20 to 40 µs for a site, so such a stage needs up
/// to 1 GB and 4 s.
const SMALL_SITES: usize = 100_000;

/// That of any stage: up to 2.6 GB and 10 s.
const MAX_SITES: usize = 1 << 18;

/// A stage may have [`SMALL_SITES`] sites, and one more for each of this many bytes of its files. A prim in a text file
/// needs about as many, so a file that is slow to read is large.
const BYTES_PER_SITE: u64 = 32;

/// The largest number of prims that are left out because of circles and chains of references and classes.
const MOST_LEFT_OUT: usize = 100;

/// What each prim of a repeated instance counts: nothing is composed, but its values take about twice as long to read.
const REPEATED: usize = 2;

impl Stage {
    /// Paths of all prims that are defined, active and not abstract, depth first, instances included.
    ///
    /// The traversal of `openusd` would check for each prim whether all its ancestors are active and defined. The
    /// content of instances that share a prototype is composed once, see [`Instances`].
    pub fn prims(&self) -> Result<Vec<String>, Invalid> {
        self.prims_below(sdf::Path::abs_root().as_str())
    }

    /// A prim and its descendants that are defined, active and not abstract, as [`Stage::prims`].
    pub fn prims_below(&self, root: &str) -> Result<Vec<String>, Invalid> {
        self.prims_of(root, SMALL_SITES, MAX_SITES)
    }

    fn prims_of(&self, root: &str, small: usize, most: usize) -> Result<Vec<String>, Invalid> {
        guarded(|| {
            let mut prims = Vec::new();
            let mut instances = self.instances.borrow_mut();
            let mut rest = vec![self.stage.prim(root)];
            while let Some(prim) = rest.pop() {
                if *prim.path() != sdf::Path::abs_root() {
                    if let Err(Failure(what)) = self.classes.check(&self.stage, &self.files, prim.path()) {
                        self.leave_out(prim.path().as_str(), what)?;
                        continue;
                    }
                    // `get_metadata` only uses the path, so it works for prims too.
                    let active = self.stage.attribute(prim.path().clone()).get_metadata::<bool>("active")?;
                    if active == Some(false) || prim.specifier()? != Some(sdf::Specifier::Def) {
                        continue;
                    }
                    prims.push(prim.path().as_str().to_owned());
                }
                let index = prim.prim_index().graph()?;
                let nodes = index.all_nodes().count();
                let mut sites = self.sites.get() + nodes;
                // Without an arc there is no content to share. Most prims have none, and the question is slow.
                let repeated = match nodes > 1 && prim.is_instance()? {
                    true => instances.visit(prim.path().as_str(), &instances::prototype(&index), &prims),
                    false => None,
                };
                sites += REPEATED * repeated.as_ref().map_or(0, |(_, content)| content.len());
                // Payloads and references are opened on the way.
                let bytes = usize::try_from(self.files.size() / BYTES_PER_SITE).unwrap_or(usize::MAX);
                let allowed = most.min(small.saturating_add(bytes));
                self.sites.set(sites);
                if sites > allowed {
                    let what = "each prim, and each reference, payload, inherit and variant of it and its ancestors, \
                                is a site";
                    return Err(Failure(format!("the stage has more than {allowed} sites for its size: {what}")));
                }
                match repeated {
                    Some((first, content)) => {
                        for i in content {
                            prims.push(format!("{}{}", prim.path(), &prims[i][first..]));
                        }
                    }
                    None => rest.extend(prim.children()?.into_iter().rev()),
                }
            }
            Ok(prims)
        })
    }

    /// Notes that a prim is not composed, or that a property of it has no valid name.
    pub(super) fn leave_out(&self, prim: &str, what: String) -> Result<(), Failure> {
        let mut left_out = self.left_out.borrow_mut();
        left_out.push((prim.to_owned(), what));
        // Each may have taken a long walk.
        match left_out.last().filter(|_| left_out.len() > MOST_LEFT_OUT) {
            Some((prim, what)) => Err(Failure(format!("more than {MOST_LEFT_OUT} prims fail, such as {prim}: {what}"))),
            None => Ok(()),
        }
    }

    /// The prototype of an instance. Instances with the same prototype have the same content.
    pub fn prototype(&self, prim: &str) -> Option<String> {
        self.instances.borrow().prototype(prim)
    }

    /// The roots that are not read, and why: `over`, `class` or `inactive`.
    pub fn undefined_roots(&self) -> Result<Vec<(String, &'static str)>, Invalid> {
        guarded(|| {
            let mut roots = Vec::new();
            for prim in self.stage.prim(sdf::Path::abs_root().as_str()).children()? {
                // Those are reported as faults of composition.
                if self.classes.check(&self.stage, &self.files, prim.path()).is_err() {
                    continue;
                }
                let active = self.stage.attribute(prim.path().clone()).get_metadata::<bool>("active")?;
                let kind = match prim.specifier()? {
                    Some(sdf::Specifier::Def) if active != Some(false) => continue,
                    Some(sdf::Specifier::Def) => "inactive",
                    Some(sdf::Specifier::Class) => "class",
                    _ => "over",
                };
                roots.push((prim.path().as_str().to_owned(), kind));
            }
            Ok(roots)
        })
    }

    /// The defaultPrim of the root layer, if no prim has this name.
    pub fn missing_default(&self) -> Result<Option<String>, Invalid> {
        guarded(|| {
            let Some(name) = self.stage.default_prim() else { return Ok(None) };
            let name = name.as_str().trim_start_matches('/').to_owned();
            let path = sdf::Path::new(&format!("/{name}"))?;
            let is_left_out = self.classes.check(&self.stage, &self.files, &path).is_err();
            let is_there = is_left_out || self.stage.prim(path).specifier()?.is_some();
            Ok((!is_there).then_some(name))
        })
    }

    /// Names of the children of a prim.
    pub fn children(&self, prim: &str) -> Result<Vec<String>, Invalid> {
        guarded(|| {
            self.classes.check(&self.stage, &self.files, &sdf::Path::new(prim)?)?;
            let children = self.stage.prim(prim).children()?;
            let paths = children.iter().map(|child| child.path().as_str().to_owned());
            Ok(paths.filter_map(|path| path.rsplit_once('/').map(|(_, name)| name.to_owned())).collect())
        })
    }

    /// What could not be composed: a prim or a file, and why. Everything else is there.
    pub fn composition_faults(&self) -> Result<Vec<(String, String)>, Invalid> {
        let errors = guarded(|| Ok(self.stage.composition_errors().iter().map(composition_error).collect::<Vec<_>>()))?;
        let mut faults = self.left_out.borrow().clone();
        if errors.is_empty() {
            return Ok(faults);
        }
        let broken = parse_errors(&self.files);
        // The errors of `openusd` about these layers say less.
        let is_known = |error: &str| broken.iter().any(|(layer, _)| error.contains(layer.as_str()));
        faults.extend(errors.into_iter().filter(|error| !is_known(error)).map(|error| ("/".to_owned(), error)));
        faults.extend(broken.clone());
        Ok(faults)
    }

    /// What was left out of the stage: a prim, and what is not there.
    pub fn losses(&self) -> Losses {
        let mut layers: Vec<_> = self.files.repairs.0.iter().collect();
        layers.sort_unstable_by_key(|(path, _)| *path);
        let mut losses: Losses = layers.into_iter().flat_map(|(_, (_, losses))| losses.clone()).collect();
        for path in self.files.unread.borrow().values().flatten() {
            let (prim, name) = path.rsplit_once('.').unwrap_or((path, ""));
            let what =
                format!("{name} has a spline in a binary layer, which is not supported (usdcat makes text of it)");
            losses.push((prim.to_owned(), what));
        }
        losses
    }

    /// Layers without the properties that the parser cannot read, if there are more of them than the stage was opened
    /// with.
    pub fn repairs(&self) -> Option<Repairs> {
        if guarded(|| Ok(self.stage.composition_errors().is_empty())).unwrap_or(true) {
            return None;
        }
        Some(repairs(&self.files)).filter(|all| all.0.len() > self.files.repairs.0.len())
    }
}

/// What an error of composition says.
fn composition_error(error: &pcp::Error) -> String {
    let chain = match error {
        pcp::Error::ArcCycle(_) => ": its references and payloads form a circle, or a chain of more than 100",
        _ => "",
    };
    format!("{error}{chain}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_has_a_bounded_number_of_sites() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.usda");
        // Each level refers to the one below twice.
        let mut text = "#usda 1.0\nclass \"L0\" {}\n".to_owned();
        for level in 1..=5 {
            let two: String =
                ["a", "b"].map(|name| format!("def \"{name}\" ( references = </L{}> ) {{}}\n", level - 1)).concat();
            text += &format!("{} \"L{level}\" {{ {two} }}\n", if level == 5 { "def" } else { "class" });
        }
        let child = "{ def \"x\" {} }";
        text += &format!("over \"no\" {child}\nclass \"nor\" {child}\ndef \"off\" ( active = false ) {child}");
        std::fs::write(&file, text).unwrap();
        let stage = Stage::open(&file, None, Repairs::default()).unwrap();
        let prims = stage.prims().unwrap();
        // 1 + 2 + … + 2⁵, depth first.
        assert_eq!(prims.len(), 63);
        assert_eq!(prims[..4], ["/L5", "/L5/a", "/L5/a/a", "/L5/a/a/a"]);
        let error = stage.prims_of("/", 63, 63).unwrap_err().0;
        assert!(error.contains("more than 63 sites"), "{error}");
        // The file has less than 1600 bytes, for 50 sites.
        let error = stage.prims_of("/", 10, 200).unwrap_err().0;
        assert!(error.contains("sites for its size"), "{error}");
        assert!(stage.prims_of("/", 1000, 1000).is_ok());
    }
}
