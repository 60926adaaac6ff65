//! All files that a stage opens: references to them, their digests, and limits.

use super::arcs::Arcs;
use super::package::Package;
use super::repair::Repairs;
use super::text::Content;
use crate::error::Invalid;
use crate::image::{TILES, UDIM, tile_name};
use openusd::ar::{self, Resolver};
use std::borrow::Cow;
use std::cell::{Cell, OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::{self, Error, ErrorKind, Seek};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use vellus_io::{Digest, DigestBuilder, Sources};

/// The largest number of files of a stage.
const MAX_FILES: usize = 1 << 16;

/// The largest total size of the files of a stage, in bytes: 16 GiB.
const MAX_BYTES: u64 = 16 << 30;

/// The largest number of references of expression variables to others.
const MOST_VARIABLES: usize = 32;

/// The end of the resolved path of a MaterialX document, which becomes a text layer. The name of a file cannot have a
/// zero.
pub(super) const MATERIALX: &str = "\0.usda";

/// A file that a layer refers to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Reference {
    /// The path in the layer.
    authored: String,
    /// The file, or the package that contains it.
    file: PathBuf,
}

/// The files of a stage.
///
/// Composition resolves the same identifiers many times, so results are cached. Files must not move while a stage is
/// read.
#[derive(Default)]
pub(super) struct Files {
    pub disk: ar::DefaultResolver,
    /// By the path of the layer and the path in the layer.
    identifiers: RefCell<HashMap<String, HashMap<String, String>>>,
    /// By identifier.
    pub resolved: RefCell<HashMap<String, Option<ar::ResolvedPath>>>,
    /// The identifier of the root file of the stage.
    top: OnceCell<String>,
    /// References, by the file that contains them.
    references: RefCell<BTreeMap<PathBuf, BTreeSet<Reference>>>,
    /// Digests of the files that were opened.
    digests: RefCell<BTreeMap<PathBuf, Digest>>,
    /// Their total size.
    bytes: RefCell<u64>,
    /// Text layers.
    texts: RefCell<BTreeSet<String>>,
    packages: RefCell<HashMap<PathBuf, Rc<Package>>>,
    /// Layers without what cannot be read.
    pub repairs: Repairs,
    /// What the layers bring in.
    pub arcs: Arcs,
    /// How often the values of expression variables refer to other variables.
    variables: Cell<usize>,
    /// Whether a layer has a spline.
    pub splines: Cell<bool>,
    /// Binary layers with splines, and the attributes.
    pub unread: RefCell<BTreeMap<String, Vec<String>>>,
}

impl Files {
    /// No files yet. Repaired layers replace those that will be read.
    pub fn with(repairs: Repairs) -> Self {
        Files { repairs, ..Files::default() }
    }

    /// Sets the root file.
    pub fn set_top(&self, identifier: String) {
        self.top.get_or_init(|| identifier);
    }

    /// The path of the root layer, once it was read.
    pub fn top_layer(&self) -> Option<String> {
        self.resolved(self.top.get()?)
    }

    /// The path of a layer that another one names, if it was resolved.
    pub fn layer_of(&self, layer: &str, authored: &str) -> Option<String> {
        let anchor = ar::ResolvedPath::new(layer);
        self.resolved(&self.identifier(authored, Some(&anchor)))
    }

    /// The path of a file that a layer names by a string.
    pub fn find(&self, layer: &str, authored: &str) -> Option<String> {
        let anchor = ar::ResolvedPath::new(layer);
        let identifier = self.identifier(authored, Some(&anchor));
        self.refer(layer, authored, &identifier);
        Some(self.disk.resolve(&identifier)?.to_string_lossy().into_owned())
    }

    fn resolved(&self, identifier: &str) -> Option<String> {
        let resolved = self.resolved.borrow();
        resolved.get(identifier)?.as_ref().map(|path| path.to_string_lossy().into_owned())
    }

    /// The identifier of a file that a layer names.
    pub fn identifier(&self, authored: &str, layer: Option<&ar::ResolvedPath>) -> String {
        let name = layer.map_or(Cow::Borrowed(""), |layer| layer.to_string_lossy());
        if let Some(known) = self.identifiers.borrow().get(&*name).and_then(|known| known.get(authored)) {
            return known.clone();
        }
        let identifier = self.disk.create_identifier(authored, layer);
        let mut identifiers = self.identifiers.borrow_mut();
        identifiers.entry(name.into_owned()).or_default().insert(authored.to_owned(), identifier.clone());
        identifier
    }

    /// Records that a layer refers to a file. Both may be inside packages.
    pub fn refer(&self, layer: &str, authored: &str, file: &str) {
        let authored = authored.split_once('[').map_or(authored, |(package, _)| package).to_owned();
        let reference = Reference { authored, file: outer(file) };
        self.references.borrow_mut().entry(outer(layer)).or_default().insert(reference);
    }

    /// Records that a file is a text layer.
    pub fn note_text(&self, path: &str) {
        self.texts.borrow_mut().insert(path.to_owned());
    }

    /// Records what composition must know about a layer.
    pub fn note_content(&self, path: &str, layer: Content) -> Result<(), Invalid> {
        self.variables.set(self.variables.get() + layer.variables);
        self.splines.set(self.splines.get() || layer.splines);
        if !layer.unread.is_empty() {
            self.unread.borrow_mut().insert(path.to_owned(), layer.unread);
        }
        // Each reference may double the length of a value.
        if self.variables.get() > MOST_VARIABLES {
            return Err(format!("expression variables refer to others more than {MOST_VARIABLES} times").into());
        }
        self.arcs.add(self, path, layer.arcs)
    }

    /// The text layers.
    pub fn texts(&self) -> BTreeSet<String> {
        self.texts.borrow().clone()
    }

    /// The bytes of a file, which may be inside a package: `a.usdz[b.usda]`.
    pub fn read(&self, path: &str) -> io::Result<Vec<u8>> {
        let path = path.strip_suffix(MATERIALX).unwrap_or(path);
        let Some((package, inner)) = ar::split_package_relative_path_outer(path) else {
            let path = Path::new(path);
            vellus_io::open_file(path)?;
            let bytes = vellus_io::read_at_most(path, MAX_BYTES)?;
            self.note(path, Digest::of(&bytes), bytes.len() as u64)?;
            return Ok(bytes);
        };
        let package = Path::new(&package);
        let mut file = vellus_io::open_file(package)?;
        let length = file.metadata()?.len();
        self.package(package)?.read(&mut file, length, &inner)
    }

    /// The bytes of a layer, or those of its repaired form.
    pub fn layer(&self, path: &str) -> io::Result<Vec<u8>> {
        let bytes = self.read(path)?;
        Ok(self.repairs.0.get(path).map_or(bytes, |(text, _)| text.clone().into_bytes()))
    }

    /// Whether a file exists, which may be inside a package.
    pub fn exists(&self, path: &str) -> bool {
        match ar::split_package_relative_path_outer(path) {
            None => Path::new(path).exists(),
            Some((package, inner)) => self.package(Path::new(&package)).is_ok_and(|package| package.contains(&inner)),
        }
    }

    /// The directory of a package.
    pub fn package(&self, path: &Path) -> io::Result<Rc<Package>> {
        if let Some(package) = self.packages.borrow().get(path) {
            return Ok(package.clone());
        }
        let mut file = vellus_io::open_file(path)?;
        let length = file.metadata()?.len();
        let package = Rc::new(Package::open(&mut file, length)?);
        file.rewind()?;
        self.note(path, Digest::of_reader(&file)?, length)?;
        self.packages.borrow_mut().insert(path.to_owned(), package.clone());
        Ok(package)
    }

    fn note(&self, path: &Path, digest: Digest, length: u64) -> io::Result<()> {
        let mut digests = self.digests.borrow_mut();
        if let Some(before) = digests.insert(path.to_owned(), digest) {
            // The root is read twice, and so is a texture with two encodings.
            let same = before == digest;
            return if same { Ok(()) } else { Err(Error::new(ErrorKind::InvalidData, "it changed while it was read")) };
        }
        let mut bytes = self.bytes.borrow_mut();
        *bytes += length;
        let limit = |what: String| Err(Error::new(ErrorKind::FileTooLarge, what));
        if digests.len() > MAX_FILES {
            return limit(format!("the stage has more than {MAX_FILES} files"));
        }
        if *bytes > MAX_BYTES {
            return limit(format!("the files of the stage have more than {} GiB in total", MAX_BYTES >> 30));
        }
        Ok(())
    }

    /// The size of all files that were opened, in bytes.
    pub fn size(&self) -> u64 {
        *self.bytes.borrow()
    }

    /// The files that were opened.
    ///
    /// If a file has several names, it gets the name that the shortest chain of references gives, and among those the
    /// first in alphabetical order. It has an absolute name only if no relative paths lead to it. Names therefore do
    /// not depend on the order in which files are found.
    pub fn sources(&self) -> Sources {
        let digests = self.digests.borrow();
        let mut named: BTreeMap<String, Vec<Digest>> = BTreeMap::new();
        for (file, name) in self.names() {
            if let Some(&digest) = digests.get(&file) {
                named.entry(name).or_default().push(digest);
            } else if let Some(pattern) = file.to_str().filter(|path| path.contains(UDIM)) {
                for tile in TILES {
                    let digest = digests.get(Path::new(&tile_name(pattern, tile)));
                    digest
                        .into_iter()
                        .for_each(|&digest| named.entry(tile_name(&name, tile)).or_default().push(digest));
                }
            }
        }
        let mut sources = Sources::new();
        for (name, mut digests) in named {
            // Links may give two files the same name.
            digests.sort_unstable();
            let all =
                |digests: &[Digest]| digests.iter().fold(DigestBuilder::new(), |all, digest| all.field("", digest.0));
            sources.add_digest(&name, if let [digest] = digests[..] { digest } else { all(&digests).finish() });
        }
        sources
    }

    fn names(&self) -> BTreeMap<PathBuf, String> {
        let references = self.references.borrow();
        let mut level: BTreeMap<PathBuf, String> =
            self.top.get().map(|top| (outer(top), String::new())).into_iter().collect();
        let (mut names, mut absolute) = (BTreeMap::new(), BTreeMap::new());
        while !level.is_empty() {
            names.extend(level.clone());
            let mut next = BTreeMap::new();
            for (layer, name) in &level {
                for Reference { authored, file } in references.get(layer).into_iter().flatten() {
                    let names = if Path::new(authored).is_absolute() { &mut absolute } else { &mut next };
                    let name = joined(name, authored);
                    let known: &mut String = names.entry(file.clone()).or_insert_with(|| name.clone());
                    if name < *known {
                        *known = name;
                    }
                }
            }
            next.retain(|file, _| !names.contains_key(file));
            level = next;
            if level.is_empty() {
                level = std::mem::take(&mut absolute);
                level.retain(|file, _| !names.contains_key(file));
            }
        }
        names
    }
}

/// The file on disk: the package, for a path inside a package.
fn outer(path: &str) -> PathBuf {
    let path = path.strip_suffix(MATERIALX).unwrap_or(path);
    ar::split_package_relative_path_outer(path).map_or_else(|| PathBuf::from(path), |(package, _)| package.into())
}

/// The name of a file that a layer refers to. `..` removes a folder if there is one to remove.
fn joined(layer: &str, path: &str) -> String {
    if Path::new(path).is_absolute() {
        return path.to_owned();
    }
    let mut parts: Vec<&str> = layer.rsplit_once('/').map_or(Vec::new(), |(folder, _)| folder.split('/').collect());
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|last| !matches!(*last, ".." | "")) => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_paths_from_the_folder_of_the_top_file() {
        assert_eq!(joined("", "./tex//a.png"), "tex/a.png");
        assert_eq!(joined("layers/skin.usda", "../tex/a.png"), "tex/a.png");
        assert_eq!(joined("layers/skin.usda", "../../a.png"), "../a.png");
        assert_eq!(joined("../skin.usda", "../a.png"), "../../a.png");
        assert_eq!(joined("layers/skin.usda", "/b/a.png"), "/b/a.png");
        assert_eq!(joined("/b/skin.usda", "../a.png"), "/a.png");
    }

    #[test]
    fn names_do_not_depend_on_the_order_of_references() {
        let references = [
            ("/x/top", "a", "/x/a"),
            ("/x/top", "/x/d", "/x/d"),
            ("/x/top", "sub/../b", "/x/b"),
            ("/x/a", "c/d", "/x/d"),
            ("/x/b", "c", "/x/c"),
            ("/x/a", "z", "/x/c"),
            ("/x/c", "/y/e", "/y/e"),
            ("/y/e", "f", "/y/f"),
        ];
        let names = |references: &mut dyn Iterator<Item = (&str, &str, &str)>| {
            let files = Files::default();
            files.set_top("/x/top".to_owned());
            references.for_each(|(layer, authored, file)| files.refer(layer, authored, file));
            files.names()
        };
        let first = names(&mut references.into_iter());
        let name = |file: &str| first[Path::new(file)].as_str();
        assert_eq!([name("/x/top"), name("/x/b"), name("/x/c"), name("/x/d")], ["", "b", "c", "c/d"]);
        assert_eq!([name("/y/e"), name("/y/f")], ["/y/e", "/y/f"]);
        assert_eq!(first, names(&mut references.into_iter().rev()));
    }
}
