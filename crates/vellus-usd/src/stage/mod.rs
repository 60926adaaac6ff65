//! A composed stage as paths, names and plain numbers. Only this module uses the crate `openusd`.
//!
//! Every call into `openusd` goes through [`guarded`], which turns a panic into an error. The stage is not used after
//! that. [`Careful`] checks each layer first, for failures that cannot be caught.

mod arc_list;
mod arcs;
mod attributes;
mod careful;
mod classes;
mod collections;
mod compose;
mod expression;
mod files;
mod instances;
mod materialx;
mod names;
mod old_crate;
mod package;
mod properties;
mod repair;
mod spline;
mod text;
mod usdc_check;
mod values;

use crate::error::{Error, Invalid};
use crate::guard::catch;
use careful::{Careful, parse_errors, repairs};
use classes::Classes;
use collections::Members;
use files::Files;
use instances::Instances;
pub(crate) use materialx::MATERIALS;
use openusd::tf::Token;
use openusd::{ar, sdf, usd};
pub(crate) use properties::Properties;
pub(crate) use repair::Repairs;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use values::precise;
use vellus_io::Sources;
use vellus_scene::Units;

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
    /// Whether a value that was read may change with time. `None` before [`Stage::watch_time`].
    varies: Cell<Option<bool>>,
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
    /// Opens and composes a file; `frame` is the time code to read. Repaired layers replace those of the files.
    pub fn open(file: &Path, frame: Option<f64>, known: Repairs) -> Result<Self, Error> {
        vellus_io::open_file(file).map_err(|error| Error::read(file, error))?;
        let name = file.to_str().ok_or_else(|| Error::file(file, "its name must be UTF-8"))?;
        let count = known.0.len();
        let files = Rc::new(Files::with(known));
        let resolver = Careful::new(files.clone());
        files.set_top(ar::Resolver::create_identifier(&resolver, name, None));
        let stage = match guarded(|| Ok(usd::Stage::builder().resolver(resolver).open(name)?)) {
            Ok(stage) => stage,
            Err(what) => {
                let repairs = repairs(&files);
                if repairs.0.len() > count {
                    return Stage::open(file, frame, repairs);
                }
                return Err(match parse_errors(&files).into_iter().next() {
                    Some((layer, what)) => Error::file(Path::new(&layer), what),
                    None => Error::file(file, what),
                });
            }
        };
        let start = guarded(|| Ok(stage.has_authored_time_code_range().then(|| stage.start_time_code())));
        let start = start.map_err(|what| Error::file(file, what))?;
        let open = frame.or(start).unwrap_or(usd::TimeCode::EARLIEST.value());
        Ok(Stage {
            stage,
            clock: Cell::new(Clock { frame: open, open, close: open }),
            varies: Cell::new(None),
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

    /// Reads other times from now on.
    pub fn set_clock(&self, clock: Clock) {
        self.clock.set(clock);
    }

    /// Notes from now on whether a value may change with time: see [`Stage::varies`].
    pub fn watch_time(&self) {
        self.varies.set(Some(false));
    }

    /// Forgets what [`Stage::varies`] noted.
    pub fn forget_time(&self) {
        self.varies.set(self.varies.get().map(|_| false));
    }

    /// Whether a value that was read since [`Stage::watch_time`] or [`Stage::forget_time`] may change with time.
    pub fn varies(&self) -> bool {
        self.varies.get() == Some(true)
    }

    /// Sets when the shutter opens and closes, in time codes relative to the frame.
    pub fn set_shutter(&self, [open, close]: [f64; 2]) {
        let frame = self.clock.get().frame;
        self.clock.set(Clock { frame, open: frame + open, close: frame + close });
    }

    /// The first and the last time code of the animation. `None` if the stage does not say them.
    pub fn range(&self) -> Option<[f64; 2]> {
        let stage = &self.stage;
        let range = || [stage.start_time_code(), stage.end_time_code()];
        guarded(|| Ok(stage.has_authored_time_code_range().then(range))).unwrap_or_default()
    }

    /// Time codes per second. Velocities are per second.
    pub fn time_codes_per_second(&self) -> Result<f64, Invalid> {
        let codes = guarded(|| Ok(self.stage.time_codes_per_second()))?;
        if codes.is_finite() && codes > 0.0 { Ok(codes) } else { Err("timeCodesPerSecond must be positive".into()) }
    }

    /// All files that were opened.
    pub fn sources(&self) -> Sources {
        self.files.sources()
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
