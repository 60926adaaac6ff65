//! Opens Alembic archives as scenes.

mod camera;
mod guides;
mod mesh;
mod place;
mod shape;
mod strands;
pub(crate) mod write;

use crate::{Error, Opened, Options, Warning};
use guides::Guides;
use place::{Place, places};
use std::collections::BTreeSet;
use std::path::Path;
use vellus_alembic::{Archive, Camera, Curves, Mesh, TimeSampling};
use vellus_io::{Digest, Sources};
use vellus_scene::{Custom, Look, MAX_COPIED, Scene, Strands, Surface};
use vellus_usd::Shot;

/// Frames per second of an archive that does not say them.
const FRAMES_PER_SECOND: f64 = 24.0;

/// The reflectance of meshes: Alembic has no materials.
const SURFACE: [f32; 3] = [0.18; 3];

/// What is needed to read an object, and what is to be said of it.
struct Reader<'a> {
    archive: &'a Archive,
    /// The time of the frame, in seconds.
    time: f64,
    /// When the shutter opens and closes.
    times: [f64; 2],
    /// The width of strands without widths.
    missing: Option<f32>,
    warnings: Vec<Warning>,
    /// Names of attributes that are not used.
    unknown: BTreeSet<String>,
    /// Whether attributes that are not used are kept for a conversion.
    keeps: bool,
}

/// Why an object is left out.
enum Skipped {
    /// It cannot be read.
    Part(String),
    /// It has no widths, and there is no default.
    NoWidth,
}

impl Skipped {
    fn part(what: impl Into<String>) -> Self {
        Skipped::Part(what.into())
    }
}

impl From<vellus_alembic::Error> for Skipped {
    fn from(error: vellus_alembic::Error) -> Self {
        Skipped::Part(error.to_string())
    }
}

impl Reader<'_> {
    /// Adds a warning about an object.
    fn note(&mut self, place: &Place, what: Option<String>) {
        self.warnings.extend(what.map(|what| Warning::Alembic { object: place.path.clone(), what }));
    }
}

/// Opens an archive. Strands whose file has no width at all get the width `missing`.
pub(crate) fn open(path: &Path, options: &Options, missing: Option<f32>) -> Result<Opened, Error> {
    let mut sources = Sources::new();
    let unread = |source| Error::Read { path: path.to_owned(), source };
    // A long animation is larger than the memory: only the samples of the frame are read.
    let digest = vellus_io::open_file(path).and_then(Digest::of_reader).map_err(unread)?;
    sources.add_digest(".abc", digest);
    let file = vellus_io::open_file(path).map_err(unread)?;
    let archive = Archive::open_file(file).map_err(|source| Error::Alembic { path: path.to_owned(), source })?;
    let mut opened = read(path, &archive, options, missing)?;
    opened.sources = sources;
    Ok(opened)
}

fn read(path: &Path, archive: &Archive, options: &Options, missing: Option<f32>) -> Result<Opened, Error> {
    let frames_per_second = archive.frames_per_second().unwrap_or(FRAMES_PER_SECOND);
    let start = start(archive);
    let time = options.frame.map_or(start.unwrap_or(0.0), |frame| frame / frames_per_second);
    let mut reader = Reader {
        archive,
        time,
        times: [time, time],
        missing,
        warnings: Vec::new(),
        unknown: BTreeSet::new(),
        keeps: options.custom,
    };
    let first = camera::find(&mut reader, path, options.camera.as_deref())?;
    let shutter = match (options.shutter, &first) {
        (Some(frames), _) => frames.map(|frame| frame / frames_per_second),
        (None, Some((_, camera))) if camera.shutter.iter().all(|x| x.is_finite()) => camera.shutter,
        _ => [0.0; 2],
    };
    reader.times = [time + shutter[0], time + shutter[1].max(shutter[0])];
    // The shutter of the camera decides when it is where.
    let view = match first {
        Some(_) => camera::find(&mut reader, path, options.camera.as_deref())?,
        None => None,
    };
    let focal_length = view.as_ref().map(|(_, camera)| 0.1 * camera.focal_length);
    let camera = view.and_then(|(place, camera)| camera::shown(&mut reader, &place, &camera));

    let (name, fiber) = options.fiber();
    let mut scene = Scene { looks: vec![Look::constant(name, fiber)], camera, ..Scene::default() };
    let (places, faults) = places(archive, reader.times);
    reader.warnings.extend(faults.into_iter().map(|(object, what)| Warning::Alembic { object, what }));
    let (mut guides, mut bound, mut copied) = (Vec::<Guides>::new(), Vec::new(), 0usize);
    for place in &places {
        if copied > MAX_COPIED {
            reader.note(place, Some(format!("left out: copies of instances have more than {MAX_COPIED} points")));
            break;
        }
        let read = if place.has_schema(archive, Curves::SCHEMA) {
            strands::read(&mut reader, place).map(|found| {
                let own = found.guides.iter().map(|(guides, _)| &guides.strands);
                let points = found.hair.iter().map(|(strands, _)| strands).chain(own).map(|all| all.points.len()).sum();
                let before = scene.strands.len();
                let moved =
                    found.custom.into_iter().map(|custom| Custom { strands: before + custom.strands, ..custom });
                scene.custom.extend(moved);
                for (strands, own) in found.hair {
                    bound.extend(own.map(|own| (scene.strands.len(), own)));
                    scene.strands.push(strands);
                }
                guides.extend(found.guides.map(|(all, is_numbered)| {
                    // Guides without numbers are counted.
                    let count = guides.iter().map(|guides: &Guides| guides.ids.len() as i64).sum::<i64>();
                    let ids = if is_numbered { all.ids } else { (count..count + all.ids.len() as i64).collect() };
                    Guides { ids, ..all }
                }));
                points
            })
        } else if place.has_schema(archive, Mesh::POLYGONS) || place.has_schema(archive, Mesh::SUBDIVISION) {
            mesh::read(&mut reader, place).map(|mesh| {
                let points = mesh.positions.len();
                scene.meshes.push(mesh);
                points
            })
        } else {
            reader.note(place, unsupported(&archive.objects[place.object]));
            Ok(0)
        };
        match read {
            Ok(points) if place.nested > 0 => copied = copied.saturating_add(points),
            Ok(_) => {}
            Err(Skipped::Part(what)) => reader.note(place, Some(format!("left out: {what}"))),
            Err(Skipped::NoWidth) => {
                let file = format!("{}: {}", path.display(), place.path);
                return Err(vellus_groom::Error::NoWidth { file }.into());
            }
        }
    }
    if guides.iter().any(|guides| guides.rest.is_some()) {
        for (set, bound) in bound {
            let strands = &mut scene.strands[set];
            let lost = bound.follow(strands, &guides);
            let what = format!("{lost} of its strands do not move: the file does not have their guides");
            let object = strands.name.clone();
            reader.warnings.extend((lost > 0).then_some(Warning::Alembic { object, what }));
        }
    }
    leave_guides(&mut reader, &mut scene, guides.into_iter().map(|guides| guides.strands).collect());
    if !reader.unknown.is_empty() {
        let names: Vec<String> = std::mem::take(&mut reader.unknown).into_iter().collect();
        let what = format!("these attributes are not used: {}", names.join(", "));
        reader.warnings.push(Warning::Alembic { object: path.display().to_string(), what });
    }
    if scene.strands.is_empty() && scene.meshes.is_empty() {
        return Err(Error::Empty { path: path.to_owned(), warnings: reader.warnings });
    }
    if !scene.meshes.is_empty() {
        scene.surfaces.push(Surface { skin: true, ..Surface::diffuse("skin", SURFACE) });
    }
    if options.fiber.is_some() && scene.strands.is_empty() {
        reader.warnings.push(Warning::unused_fiber(path, &[]));
    }
    let frame = options.frame.or(start.map(|start| start * frames_per_second));
    let focal_length = focal_length.filter(|_| scene.camera.is_some());
    let range = archive.range().map(|range| range.map(|time| time * frames_per_second));
    let shot = Some(Shot { frame, frames_per_second, focal_length, range });
    Ok(Opened { scene, warnings: reader.warnings, shot, ..Opened::default() })
}

/// Guides are no hair, unless there is nothing else.
fn leave_guides(reader: &mut Reader, scene: &mut Scene, guides: Vec<Strands>) {
    let are_alone = scene.strands.is_empty();
    for strands in &guides {
        let count = strands.len();
        let what = match are_alone {
            true => format!("it has guides only: its {count} guides are shown as hair (groom_guide)"),
            false => format!("its {count} guides are left out (groom_guide)"),
        };
        reader.warnings.push(Warning::Alembic { object: strands.name.clone(), what });
    }
    if are_alone {
        scene.strands = guides;
    }
}

/// The time of the first sample of the archive's animation, in seconds. `None` if nothing has a time.
fn start(archive: &Archive) -> Option<f64> {
    // The first sampling is for what has no time.
    archive.times.iter().skip(1).map(|times: &TimeSampling| times.time(0)).min_by(f64::total_cmp)
}

/// What is said of an object that is left out because of its kind. Objects without a schema are folders.
fn unsupported(object: &vellus_alembic::Object) -> Option<String> {
    let schema = object.schema()?;
    let is_known = schema.starts_with(Camera::SCHEMA) || schema.starts_with("AbcGeom_FaceSet_v");
    (!is_known).then(|| format!("left out: objects of the schema {schema} are not supported"))
}
