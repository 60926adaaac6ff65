//! A composed stage as paths, names and plain numbers. Only this module uses the crate `openusd`.
//!
//! Every call into `openusd` goes through [`guarded`], which turns a panic into an error. The stage is not used after
//! that. [`Careful`] checks each layer first, for failures that cannot be caught.

mod arc_list;
mod arcs;
mod careful;
mod classes;
mod collections;
mod files;
mod instances;
mod materialx;
mod names;
mod old_crate;
mod package;
mod properties;
mod text;
mod usdc_check;
mod values;

use crate::error::{Error, Invalid};
use crate::guard::catch;
use crate::image::{TILES, tile_name};
use careful::{Careful, parse_errors};
use classes::Classes;
use collections::Members;
use files::Files;
use glam::DMat4;
use instances::Instances;
pub(crate) use materialx::MATERIALS;
use openusd::tf::Token;
use openusd::{ar, pcp, sdf, usd};
pub(crate) use properties::Properties;
use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use text::ascii;
use values::{numbers, precise};
use vellus_io::Sources;
use vellus_scene::Units;

/// The largest number of sites of a small stage. Each prim is one site, and so is each reference, payload, inherit and
/// variant of a prim or its ancestors. `openusd` needs 4 to 10 KB and 20 to 40 µs for a site, so such a stage needs up
/// to 1 GB and 4 s.
const SMALL_SITES: usize = 100_000;

/// That of any stage: up to 2.6 GB and 10 s.
const MAX_SITES: usize = 1 << 18;

/// A stage may have one site more than [`SMALL_SITES`] for each so many bytes of its files. A prim in a text file needs
/// about as many, so a file that is slow to read is large.
const BYTES_PER_SITE: u64 = 32;

/// The largest number of prims that are left out because of circles and chains of references and classes.
const MOST_LEFT_OUT: usize = 100;

/// What each prim of a repeated instance counts: nothing is composed, but its values take about twice as long to read.
const REPEATED: usize = 2;

/// The time at which a value is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum When {
    /// When the shutter opens.
    Open,
    /// When the shutter closes.
    Close,
    /// At this time code.
    At(f64),
}

/// The time codes that are read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    /// Time code of the frame.
    pub frame: f64,
    /// Time code of [`When::Open`].
    pub open: f64,
    /// Time code of [`When::Close`].
    pub close: f64,
}

impl Clock {
    /// Whether neither the stage nor the options define a frame.
    pub fn is_timeless(&self) -> bool {
        self.frame == usd::TimeCode::EARLIEST.value()
    }
}

/// An array of numbers or vectors.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Numbers {
    /// The numbers, one vector after the other.
    pub values: Vec<f32>,
    /// Numbers per vector; 1 for plain numbers.
    pub lanes: usize,
}

impl Numbers {
    /// Number of vectors.
    pub fn len(&self) -> usize {
        self.values.len() / self.lanes
    }

    /// The vector with index `i`.
    pub fn row(&self, i: usize) -> &[f32] {
        &self.values[i * self.lanes..(i + 1) * self.lanes]
    }
}

/// A composed stage.
pub(crate) struct Stage {
    stage: usd::Stage,
    /// The times that are read.
    clock: Cell<Clock>,
    members: Members,
    files: Rc<Files>,
    classes: Classes,
    instances: RefCell<Instances>,
    /// Schemas, by prim. They are asked for when the camera is looked for, and again when the prim is read.
    types: RefCell<HashMap<String, Token>>,
    /// Names of properties, by prim.
    properties: RefCell<HashMap<String, Rc<Properties>>>,
    /// Those of the prim that was asked about last: most questions follow one about the same prim.
    last: RefCell<(String, Rc<Properties>)>,
    /// The prims that were visited, in this order, see [`Stage::visit`].
    visited: RefCell<Vec<String>>,
    /// The prims that were not composed, and why.
    left_out: RefCell<Vec<(String, String)>>,
    /// The number of sites so far, see [`SMALL_SITES`].
    sites: Cell<usize>,
}

/// A property of a prim.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Property {
    pub prim: String,
    pub name: String,
}

impl Stage {
    /// Opens and composes a file; `frame` is the time code to read.
    pub fn open(file: &Path, frame: Option<f64>) -> Result<Self, Error> {
        vellus_io::open_file(file).map_err(|error| Error::read(file, error))?;
        let name = file.to_str().ok_or_else(|| Error::file(file, "its name must be UTF-8"))?;
        let files = Rc::new(Files::default());
        let resolver = Careful::new(files.clone());
        files.set_top(ar::Resolver::create_identifier(&resolver, name, None));
        let stage =
            guarded(|| Ok(usd::Stage::builder().resolver(resolver).open(name)?)).map_err(|what| match parse_errors(
                &files,
            )
            .into_iter()
            .next()
            {
                Some((layer, what)) => Error::file(Path::new(&layer), what),
                None => Error::file(file, what),
            })?;
        let start = guarded(|| Ok(stage.has_authored_time_code_range().then(|| stage.start_time_code())));
        let start = start.map_err(|what| Error::file(file, what))?;
        let open = frame.or(start).unwrap_or(usd::TimeCode::EARLIEST.value());
        Ok(Stage {
            stage,
            clock: Cell::new(Clock { frame: open, open, close: open }),
            members: Members::default(),
            files,
            classes: Classes::default(),
            instances: RefCell::default(),
            types: RefCell::default(),
            properties: RefCell::default(),
            last: RefCell::new((String::new(), Rc::default())),
            visited: RefCell::default(),
            left_out: RefCell::default(),
            sites: Cell::new(0),
        })
    }

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

    /// Notes that a prim is not composed.
    fn leave_out(&self, prim: &str, what: String) -> Result<(), Failure> {
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

    /// The unit of length, and whether the up axis is z. Values that are not valid are ignored, and named.
    pub fn units(&self) -> Result<(Units, Vec<&'static str>), Invalid> {
        let mut ignored = Vec::new();
        let [axis, meters] = ["upAxis", "metersPerUnit"].map(|name| guarded(|| Ok(self.stage.stage_metadata(name)?)));
        let meters = match meters? {
            None => Units::CENTIMETERS.meters_per_unit,
            Some(value) => match precise(value).as_deref() {
                Some(&[x]) if x.is_finite() && x > 0.0 => x,
                _ => {
                    ignored.push("metersPerUnit must be a positive number: the unit is taken for a centimetre");
                    Units::CENTIMETERS.meters_per_unit
                }
            },
        };
        let z_up = match axis? {
            None => false,
            Some(axis) => match axis.as_str() {
                Some("Y") => false,
                Some("Z") => true,
                _ => {
                    ignored.push("upAxis must be Y or Z: Y is taken");
                    false
                }
            },
        };
        Ok((Units { meters_per_unit: meters, z_up }, ignored))
    }

    /// The prim of the RenderSettings that the stage names.
    pub fn settings_path(&self) -> Option<String> {
        let path = guarded(|| Ok(self.stage.stage_metadata("renderSettingsPrimPath")?)).ok().flatten()?;
        path.as_str().filter(|path| !path.is_empty()).map(str::to_owned)
    }

    /// The schema of a prim, or an empty string if it has none.
    pub fn type_name(&self, prim: &str) -> Result<String, Error> {
        if let Some(known) = self.types.borrow().get(prim) {
            return Ok(known.as_str().to_owned());
        }
        let name = self.ask(prim, |prim| Ok(self.stage.prim(prim).type_name()?.unwrap_or_default()))?;
        self.types.borrow_mut().insert(prim.to_owned(), name.clone());
        Ok(name.as_str().to_owned())
    }

    /// Whether a schema was applied to a prim.
    pub fn has_api(&self, prim: &str, schema: &str) -> Result<bool, Error> {
        self.ask(prim, |prim| Ok(self.stage.prim(prim).has_api_schema(schema)?))
    }

    /// The times that are read.
    pub fn clock(&self) -> Clock {
        self.clock.get()
    }

    /// Sets when the shutter opens and closes, in time codes relative to the frame.
    pub fn set_shutter(&self, [open, close]: [f64; 2]) {
        let frame = self.clock.get().frame;
        self.clock.set(Clock { frame, open: frame + open, close: frame + close });
    }

    /// Notes that a prim is read: each of its properties must then be asked for, or be known as one without effect.
    pub fn visit(&self, prim: &str) -> Result<(), Error> {
        if self.properties(prim)?.visit() {
            self.visited.borrow_mut().push(prim.to_owned());
        }
        Ok(())
    }

    /// Notes that properties are known, because others of the same prim replace them.
    pub fn know(&self, prim: &str, names: &[&str]) -> Result<(), Error> {
        let properties = self.properties(prim)?;
        names.iter().for_each(|name| {
            properties.ask(name);
        });
        Ok(())
    }

    /// The prims that were visited. Instances with the same content count once.
    pub fn visited(&self) -> Vec<String> {
        self.visited.borrow().clone()
    }

    /// All properties of a prim.
    pub fn properties(&self, prim: &str) -> Result<Rc<Properties>, Error> {
        if self.last.borrow().0 == prim {
            return Ok(self.last.borrow().1.clone());
        }
        let composed = self.instances.borrow().composed(prim).0.into_owned();
        let known = self.properties.borrow().get(&composed).cloned();
        let names = match known {
            Some(names) => names,
            None => self.ask(prim, |prim| Ok(Rc::new(Properties::new(self.stage.prim(prim).property_names()?))))?,
        };
        self.properties.borrow_mut().entry(composed).or_insert_with(|| names.clone());
        *self.last.borrow_mut() = (prim.to_owned(), names.clone());
        Ok(names)
    }

    /// Whether a prim has a property. Most properties are not set, and `openusd` is slow to report that.
    pub fn has_property(&self, prim: &str, name: &str) -> Result<bool, Error> {
        Ok(self.properties(prim)?.ask(&self.spelled(prim, name)?))
    }

    /// Reads numbers, vectors, or an array of them, in single precision.
    pub fn numbers(&self, prim: &str, name: &str, when: When) -> Result<Option<Numbers>, Error> {
        self.typed(prim, name, when, "numbers", numbers)
    }

    /// Reads one number, vector, quaternion (x, y, z, w) or matrix (column-major), in double precision.
    pub fn precise(&self, prim: &str, name: &str, when: When) -> Result<Option<Vec<f64>>, Error> {
        self.typed(prim, name, when, "a number, a vector or a matrix", precise)
    }

    /// Reads an array of matrices.
    pub fn matrices(&self, prim: &str, name: &str, when: When) -> Result<Option<Vec<DMat4>>, Error> {
        self.typed(prim, name, when, "matrices", |value| match value {
            // USD multiplies row vectors, so its rows are the columns for column vectors.
            sdf::Value::Matrix4dVec(v) => Some(v.iter().map(|m| DMat4::from_cols_array(&m.0)).collect()),
            _ => None,
        })
    }

    /// Reads an array of integers.
    pub fn integers(&self, prim: &str, name: &str, when: When) -> Result<Option<Vec<i64>>, Error> {
        self.typed(prim, name, when, "integers", |value| match value {
            sdf::Value::IntVec(v) => Some(v.into_iter().map(i64::from).collect()),
            sdf::Value::UintVec(v) => Some(v.into_iter().map(i64::from).collect()),
            sdf::Value::Int64Vec(v) => Some(v),
            _ => None,
        })
    }

    /// Reads a token or string, or an array of them.
    pub fn words(&self, prim: &str, name: &str) -> Result<Option<Vec<String>>, Error> {
        self.typed(prim, name, When::Open, "tokens or strings", |value| match value {
            sdf::Value::TokenVec(v) => Some(v.iter().map(|t| t.as_str().to_owned()).collect()),
            sdf::Value::StringVec(v) => Some(v),
            other => other.as_str().map(|word| vec![word.to_owned()]),
        })
    }

    /// Reads a boolean. Numbers other than 0 are true.
    pub fn flag(&self, prim: &str, name: &str) -> Result<Option<bool>, Error> {
        self.typed(prim, name, When::Open, "a boolean", |value| match value {
            sdf::Value::Bool(flag) => Some(flag),
            other => precise(other).map(|v| v.first().is_some_and(|x| *x != 0.0)),
        })
    }

    /// The file that an attribute refers to, resolved against the layer of the reference. A file inside a package has
    /// the form `a.usdz[b.png]`.
    pub fn asset(&self, prim: &str, name: &str) -> Result<Option<String>, Error> {
        let Some(value) = self.value(prim, name, When::Open)? else { return Ok(None) };
        let (authored, resolved) = match &value {
            sdf::Value::AssetPath(asset) => (asset.asset_path(), asset.resolved_path().map(str::to_owned)),
            other => match other.as_str() {
                Some(path) => (path, self.resolved(prim, name, path)?),
                None => return Err(Error::prim(prim, format!("{name} must be the path of a file"))),
            },
        };
        match (authored, resolved) {
            ("", _) => Ok(None),
            (_, Some(resolved)) if !resolved.is_empty() => Ok(Some(resolved)),
            (authored, _) => Err(Error::prim(prim, format!("{name}: the file {authored} does not exist"))),
        }
    }

    /// The file that a string stands for, resolved against the layer that has the value.
    fn resolved(&self, prim: &str, name: &str, authored: &str) -> Result<Option<String>, Error> {
        self.ask(prim, |prim| {
            let graph = self.stage.prim_index(sdf::Path::new(prim)?).graph()?;
            for node in graph.all_nodes() {
                let property = node.path().append_property(name)?;
                for (layer, _) in self.stage.node_layer_stack(node) {
                    let Some(layer) = self.stage.layer_identifier(layer) else { continue };
                    let has_value = self.stage.layer(&layer).is_some_and(|layer| {
                        ["default", "timeSamples"]
                            .iter()
                            .any(|field| matches!(layer.data().try_field(&property, field), Ok(Some(_))))
                    });
                    if has_value {
                        return Ok(self.files.find(&layer, authored));
                    }
                }
            }
            Ok(None)
        })
    }

    /// The bytes of a file that [`Stage::asset`] resolved.
    pub fn asset_bytes(&self, resolved: &str) -> Result<Vec<u8>, Error> {
        self.files.read(resolved).map_err(|what| Error::file(Path::new(resolved), what))
    }

    /// The numbers of the tiles of an image that [`Stage::asset`] resolved.
    pub fn tiles(&self, resolved: &str) -> Vec<usize> {
        TILES.filter(|&number| self.files.exists(&tile_name(resolved, number))).collect()
    }

    /// All files that were opened.
    pub fn sources(&self) -> Sources {
        self.files.sources()
    }

    /// The time of the last sample of an attribute up to `time`, or of the first sample if all are later. `None` if the
    /// attribute has no samples.
    pub fn sample_before(&self, prim: &str, name: &str, time: f64) -> Result<Option<f64>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(None);
        }
        self.ask(prim, |prim| {
            let around = self.attribute(prim, name)?.bracketing_time_samples(usd::TimeCode::new(time))?;
            Ok(around.map(|(before, _)| before))
        })
    }

    /// The time of the first sample of an attribute after `time`, if there is one.
    pub fn sample_after(&self, prim: &str, name: &str, time: f64) -> Result<Option<f64>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(None);
        }
        self.ask(prim, |prim| {
            let later = usd::TimeCode::new(time + 1e-6 * time.abs().max(1.0));
            let around = self.attribute(prim, name)?.bracketing_time_samples(later)?;
            Ok(around.map(|(_, after)| after).filter(|after| *after > time))
        })
    }

    /// Time codes per second. Velocities are per second.
    pub fn time_codes_per_second(&self) -> Result<f64, Invalid> {
        let codes = guarded(|| Ok(self.stage.time_codes_per_second()))?;
        if codes.is_finite() && codes > 0.0 { Ok(codes) } else { Err("timeCodesPerSecond must be positive".into()) }
    }

    /// Whether a property is marked as one that no schema defines.
    pub fn is_custom(&self, prim: &str, name: &str) -> Result<bool, Error> {
        self.ask(prim, |prim| Ok(self.attribute(prim, name)?.get_metadata::<bool>("custom")?.unwrap_or(false)))
    }

    /// Whether a property has a value, a connection or a target.
    pub fn has_content(&self, prim: &str, name: &str) -> Result<bool, Error> {
        // A relationship has no connections, and an attribute no targets.
        Ok(self.has_value(prim, name)?
            || self.connection(prim, name).is_ok_and(|found| found.is_some())
            || self.targets(prim, name).is_ok_and(|targets| !targets.is_empty()))
    }

    /// Whether an attribute has a value.
    pub fn has_value(&self, prim: &str, name: &str) -> Result<bool, Error> {
        Ok(self.value(prim, name, When::Open)?.is_some())
    }

    /// A token in the metadata of a property, such as the interpolation of a primvar or the strength of a binding.
    pub fn metadata(&self, prim: &str, name: &str, key: &str) -> Result<Option<String>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(None);
        }
        self.ask(prim, |prim| {
            // `get_metadata` only uses the path, so it works for relationships too.
            let value = self.attribute(prim, name)?.get_metadata::<sdf::Value>(key)?;
            Ok(value.and_then(|value| value.as_str().map(str::to_owned)))
        })
    }

    /// The property that an attribute is connected to.
    pub fn connection(&self, prim: &str, name: &str) -> Result<Option<Property>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(None);
        }
        let instances = self.instances.borrow();
        self.ask(prim, |composed| {
            self.classes.check_targets(&self.stage, &self.files, composed, name)?;
            let connections = self.attribute(composed, name)?.connections()?;
            let property = connections.first().and_then(|path| path.as_str().rsplit_once('.'));
            Ok(property.map(|(to, name)| Property { prim: instances.seen_from(prim, to), name: name.to_owned() }))
        })
    }

    /// The instances of a PointInstancer that are not active, which is metadata of the prim.
    pub fn inactive_ids(&self, prim: &str) -> Result<Vec<i64>, Error> {
        self.ask(prim, |prim| {
            // `get_metadata` only uses the path, so it works for prims too.
            let value = self.stage.attribute(sdf::Path::new(prim)?).get_metadata::<sdf::Value>("inactiveIds")?;
            Ok(match value {
                Some(sdf::Value::Int64ListOp(list)) => list.flatten().into_iter().collect(),
                Some(sdf::Value::Int64Vec(ids)) => ids,
                _ => Vec::new(),
            })
        })
    }

    /// The targets of a relationship.
    pub fn targets(&self, prim: &str, name: &str) -> Result<Vec<String>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(Vec::new());
        }
        let instances = self.instances.borrow();
        self.ask(prim, |composed| {
            self.classes.check_targets(&self.stage, &self.files, composed, name)?;
            let targets = self.stage.relationship(format!("{composed}.{name}")).targets()?;
            Ok(targets.iter().map(|path| instances.seen_from(prim, path.as_str())).collect())
        })
    }

    fn attribute(&self, prim: &str, name: &str) -> Result<usd::Attribute, Failure> {
        Ok(self.stage.attribute(format!("{prim}.{}", self.spelled(prim, name)?)))
    }

    /// The name of a property in the composed stage: text layers get names in ASCII.
    fn spelled<'n>(&self, prim: &str, name: &'n str) -> Result<Cow<'n, str>, Error> {
        let is_known = name.is_ascii() || self.properties(prim)?.iter().any(|known| known == name);
        Ok(if is_known { name.into() } else { ascii(name) })
    }

    /// Asks about a prim. The question gets the path under which it is composed.
    fn ask<T>(&self, prim: &str, question: impl FnOnce(&str) -> Result<T, Failure>) -> Result<T, Error> {
        let checked = || {
            let instances = self.instances.borrow();
            let (composed, _) = instances.composed(prim);
            self.classes.check(&self.stage, &self.files, &sdf::Path::new(&composed)?)?;
            question(&composed)
        };
        guarded(checked).map_err(|what| Error::prim(prim, what))
    }

    fn typed<T>(
        &self,
        prim: &str,
        name: &str,
        when: When,
        expected: &str,
        convert: impl FnOnce(sdf::Value) -> Option<T>,
    ) -> Result<Option<T>, Error> {
        let Some(value) = self.value(prim, name, when)? else { return Ok(None) };
        let converted = convert(value).ok_or_else(|| Error::prim(prim, format!("{name} must be {expected}")))?;
        Ok(Some(converted))
    }

    /// The value of an attribute, if a layer has one and it is not blocked. Within a layer, time samples precede the
    /// default value.
    fn value(&self, prim: &str, name: &str, when: When) -> Result<Option<sdf::Value>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(None);
        }
        let time = match when {
            When::Open => self.clock().open,
            When::Close => self.clock().close,
            When::At(time) => time,
        };
        self.ask(prim, |prim| {
            let attribute = self.attribute(prim, name)?;
            let real = |value: &sdf::Value| !matches!(value, sdf::Value::None | sdf::Value::ValueBlock);
            Ok(attribute.get_at::<sdf::Value>(usd::TimeCode::new(time))?.filter(real))
        })
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

/// An error of a call into `openusd`: the text of any error, with its causes.
struct Failure(String);

impl<E: std::fmt::Display> From<E> for Failure {
    fn from(error: E) -> Self {
        // The alternate form also prints the causes.
        Failure(format!("{error:#}"))
    }
}

/// Runs a call into `openusd`. Errors and panics become text.
fn guarded<T>(call: impl FnOnce() -> Result<T, Failure>) -> Result<T, Invalid> {
    match catch(call) {
        Some(result) => result.map_err(|error| error.0.replace('\n', "; ").into()),
        None => Err("the file is broken: its decoder failed".into()),
    }
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
        let stage = Stage::open(&file, None).unwrap();
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
