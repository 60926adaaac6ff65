//! A scene as plain rows of four numbers, for a tracer on a GPU.
//!
//! It is the same scene with the same hierarchies. Objects follow one another: what is in world space first, then the
//! prototypes. All indices count over all objects. The order of the numbers is not stable.

mod constants;
mod geometry;
mod lights;

pub use constants::constants;

use crate::error::Error;
use crate::film::{Film, Layer, Layout, nearest};
use crate::integrator::path::Seen;
use crate::integrator::settings::Settings;
use crate::integrator::view::Filter;
use crate::render::{Row, Statistics};
use crate::world::World;
use rayon::prelude::*;
use std::ops::Range;
use vellus::Fiber;
use vellus_io::Progress;
use vellus_scene::{Opacity, Tint, Wrap};

/// Marks a number that is missing.
pub const NONE: u32 = u32::MAX;

/// The nodes that can wait while a tracer follows a ray. [`World::packed`] refuses scenes that need more.
pub const STACK: usize = 192;

/// Rows of the header, at the beginning of [`PackedScene::data`]. The first channels of all layers follow.
const HEADER_ROWS: [&str; 18] = [
    "CAMERA_X",      // and film height
    "CAMERA_Y",      // and focus distance
    "CAMERA_Z",      // and lens radius
    "CAMERA_ORIGIN", // and filter
    "SIZE",          // of the whole picture, and the corner of the area
    "AREA",          // its size, the seed, the largest depth
    "ROOTS",         // of strands, meshes and instances, and the number of instances
    "SETS",          // numbers and rows of the sets of strands and of the meshes
    "LIGHTS",        // number, rows, what reaches the things of each class; rows of the surfaces
    "TEXTURES",      // rows; texture and group of the background; group of emission
    "BACKGROUND",    // its colour
    "OUTPUT",        // the limit of indirect light, channels, words of a sample, whether there is a background
    "INSTANCES",     // their rows, and those of their leaves
    "SHIFT",         // of the film, over the focal length
    "LINKS",         // the class of each thing
    "CLOSED",        // the distances in rows of nodes, chords, triangles and points when the shutter closes
    "CAMERA_TURN",   // the axis and the angle by which the camera turns while it is open
    "CAMERA_MOVE",   // and how far it moves
];

/// The names of [`PackedScene::features`].
pub const FEATURES: [&str; 19] = [
    "HAS_LOBES",
    "HAS_MOTION",
    "HAS_INSTANCES",
    "HAS_MESHES",
    "HAS_LINKS",
    "HAS_GAINS",
    "HAS_OPACITY",
    "HAS_NORMAL_MAPS",
    "HAS_TEXTURES",
    "HAS_SKY_IMAGES",
    "HAS_LAMP_IMAGES",
    "HAS_PROFILES",
    "HAS_SHAPING",
    "HAS_DOME",
    "HAS_DISTANT",
    "HAS_FLAT",
    "HAS_POINT",
    "HAS_SPHERE",
    "HAS_CYLINDER",
];

/// Rows of the header with those of the layers.
const HEADER: usize = HEADER_ROWS.len() + Layer::ALL.len().div_ceil(4);

/// Words after the channels of a sample: the distance of the strand that the camera sees and its number, the thing that
/// it sees, the rays, the throughput that was cut off, and the light that was removed.
pub const EXTRA_WORDS: usize = 6;

/// Rows of each surface: colour and its texture; roughness, metallic and index of refraction; emission; opacity,
/// threshold, and the textures of opacity and normals; the factors of the normal map; what it adds. A texture counts
/// from 1, and 0 is none.
const SURFACE_ROWS: usize = 6;

/// A scene in rows of four numbers.
#[derive(Clone, Debug, Default)]
pub struct PackedScene {
    /// Nodes of all hierarchies, 14 rows each. If anything moves, all arrays of shapes are twice as long: the second
    /// half is the scene when the shutter closes.
    pub nodes: Vec<[u32; 4]>,
    /// Chords of segments, 16 rows for each leaf.
    pub chords: Vec<[u32; 4]>,
    /// Triangles, 20 rows for each leaf.
    pub triangles: Vec<[u32; 4]>,
    /// Control points: x, y, z and radius.
    pub points: Vec<[f32; 4]>,
    /// Everything else: the header first.
    pub data: Vec<[u32; 4]>,
    /// The different fibres.
    pub fibers: Vec<Fiber>,
    /// The nodes that can wait while a ray is followed, at most [`STACK`].
    pub stack: usize,
    /// The words of one sample.
    pub sample_words: usize,
    /// What the scene and the picture have: a tracer may leave out the code of what they lack.
    pub features: Vec<(&'static str, bool)>,
}

impl PackedScene {
    /// Appends a row, and returns its index.
    fn row(&mut self, row: [u32; 4]) -> u32 {
        self.data.push(row);
        (self.data.len() - 1) as u32
    }

    /// Appends numbers one after another. Returns the index of the first number.
    fn numbers(&mut self, numbers: impl IntoIterator<Item = u32>) -> u32 {
        let begin = 4 * self.data.len() as u32;
        let numbers: Vec<u32> = numbers.into_iter().collect();
        let chunk = |chunk: &[u32]| std::array::from_fn(|i| chunk.get(i).copied().unwrap_or(0));
        self.data.extend(numbers.chunks(4).map(chunk));
        begin
    }
}

/// What the processor can render, and a tracer of packed scenes cannot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lacking {
    /// Models other than [`vellus::Bcsdf`].
    Models,
    /// A radiance cache.
    RadianceCache,
    /// Fibres that are not round.
    FlatFibers,
    /// Air in the medulla.
    Air,
    /// Hierarchies in which more than [`STACK`] nodes wait.
    DeepHierarchies,
}

// The number in the name of [`Lacking::DeepHierarchies`].
const _: () = assert!(STACK == 192);

impl Lacking {
    /// All features that are lacking.
    pub const ALL: [Lacking; 5] =
        [Lacking::Models, Lacking::RadianceCache, Lacking::FlatFibers, Lacking::Air, Lacking::DeepHierarchies];

    /// Its name in messages, and the option or the parameter that needs it.
    pub fn names(self) -> [&'static str; 2] {
        match self {
            Lacking::Models => ["a reflectance model other than vellus", "--model"],
            Lacking::RadianceCache => ["a radiance cache", "--radiance-cache"],
            Lacking::FlatFibers => ["fibres that are not round", "aspect_ratio"],
            Lacking::Air => ["fibres with air in the medulla", "medulla_air"],
            Lacking::DeepHierarchies => ["a hierarchy in which more than 192 nodes wait", "no scene that we know"],
        }
    }
}

impl std::fmt::Display for Lacking {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [name, option] = self.names();
        write!(f, "{name} ({option})")
    }
}

fn rgb(c: [f32; 3], w: f32) -> [f32; 4] {
    [c[0], c[1], c[2], w]
}

impl World {
    /// The scene for a picture with these settings and layers.
    ///
    /// # Errors
    /// What the packed form does not have, of [`Lacking`].
    pub fn packed(&self, settings: &Settings, layout: &Layout) -> Result<PackedScene, Lacking> {
        let geometry = &self.geometry;
        if !self.fibers.is_bcsdf() {
            return Err(Lacking::Models);
        }
        if settings.radiance_cache.is_some() {
            return Err(Lacking::RadianceCache);
        }
        let mut packed = PackedScene { data: vec![[0; 4]; HEADER], ..PackedScene::default() };
        packed.sample_words = layout.channels() + EXTRA_WORDS;
        let own = geometry::pack(&mut packed, geometry)?;
        if packed.fibers.iter().any(|fiber| fiber.aspect_ratio < 1.0) {
            return Err(Lacking::FlatFibers);
        }
        if packed.fibers.iter().any(|fiber| fiber.medulla_air > 0.0) {
            return Err(Lacking::Air);
        }
        let lights = geometry.lights.packed(&mut packed, &geometry.groups);
        let surfaces = packed.data.len() as u32;
        for surface in &geometry.surfaces {
            let texture = surface.color.texture.map_or(0, |texture| texture as u32 + 1);
            let [r, g, b] = surface.color.color.map(f32::to_bits);
            let Opacity { value, texture: holes, threshold } = surface.opacity;
            let [normals, holes] =
                [surface.normals.map(|map| map.texture), holes].map(|texture| texture.map_or(0, |t| t as u32 + 1));
            let [factors, added] = surface.normals.map_or([[0.0; 3]; 2], |map| [map.scale, map.bias]);
            let rows: [[u32; 4]; SURFACE_ROWS] = [
                [r, g, b, texture],
                [surface.roughness, surface.metallic, surface.ior, 0.0].map(f32::to_bits),
                rgb(surface.emission, 0.0).map(f32::to_bits),
                [value.to_bits(), threshold.to_bits(), holes, normals],
                rgb(factors, 0.0).map(f32::to_bits),
                rgb(added, 0.0).map(f32::to_bits),
            ];
            packed.data.extend(rows);
        }
        let textures = self.pack_textures(&mut packed);
        let [dome, distant, flat, point, sphere, cylinder] = lights.kinds;
        let [sky, lamp, profile] = lights.images;
        let all = [
            layout.has(Layer::Lobes),
            geometry.moves(),
            !geometry.instances.is_empty(),
            own.sets[2] > 0,
            geometry.lights.is_linked(),
            geometry.lights.any_gains(),
            geometry.surfaces.iter().any(|surface| surface.opacity != Opacity::FULL),
            geometry.surfaces.iter().any(|surface| surface.normals.is_some()),
            !geometry.textures.is_empty(),
            sky,
            lamp,
            profile,
            lights.shaping,
            dome,
            distant,
            flat,
            point,
            sphere,
            cylinder,
        ];
        packed.features = FEATURES.into_iter().zip(all).collect();
        let axes = geometry.view.packed(settings);
        let [turn, way] = geometry.view.packed_motion();
        let [right, up] = geometry.view.camera().shift;
        let [left, top, width, height] = settings.area().map(|n| n as u32);
        let [whole_width, whole_height] = settings.size.map(|n| n as u32);
        let background = geometry.background.as_ref();
        let tint = background.map_or(Tint { color: [0.0; 3], texture: None }, |background| background.tint);
        let channels = layout.channels() as u32;
        let clamp = settings.clamp_indirect.map_or(0, f32::to_bits);
        let header: [[u32; 4]; HEADER_ROWS.len()] = [
            axes[0],
            axes[1],
            axes[2],
            axes[3],
            [whole_width, whole_height, left, top],
            [width, height, settings.seed, settings.max_depth.unwrap_or(NONE)],
            own.roots,
            own.sets,
            [geometry.lights.len() as u32, lights.rows, lights.reaching, surfaces],
            [
                textures,
                tint.texture.map_or(0, |texture| texture as u32 + 1),
                background.map_or(0, |background| background.group as u32),
                geometry.emission_group as u32,
            ],
            rgb(tint.color, 0.0).map(f32::to_bits),
            [clamp, channels, packed.sample_words as u32, u32::from(background.is_some())],
            own.instances,
            [right.to_bits(), up.to_bits(), 0, 0],
            [lights.classes, 0, 0, 0],
            own.closed,
            turn,
            way,
        ];
        packed.data[..header.len()].copy_from_slice(&header);
        let starts: Vec<u32> =
            Layer::ALL.iter().map(|&layer| layout.start(layer).map_or(NONE, |start| start as u32)).collect();
        for (row, starts) in packed.data[header.len()..].iter_mut().zip(starts.chunks(4)) {
            row[..starts.len()].copy_from_slice(starts);
        }
        Ok(packed)
    }

    /// The textures: a row for each with its size, its first pixel and how it continues; then all pixels.
    fn pack_textures(&self, packed: &mut PackedScene) -> u32 {
        let textures = &self.geometry.textures;
        let begin = packed.data.len();
        packed.data.extend(textures.iter().map(|_| [0; 4]));
        for (k, texture) in textures.iter().enumerate() {
            let wrap = texture.wrap.map(|wrap| match wrap {
                Wrap::Repeat => 0,
                Wrap::Clamp => 1,
                Wrap::Mirror => 2,
                Wrap::Black => 3,
                Wrap::Tiles(count) => 3 + u32::from(count),
            });
            let first = packed.data.len() as u32;
            packed.data[begin + k] = [texture.width as u32, texture.height as u32, first, wrap[0] | wrap[1] << 16];
            packed.data.extend(texture.pixels.iter().map(|pixel| rgb(pixel, 0.0).map(f32::to_bits)));
        }
        begin as u32
    }
}

/// Computes samples, on a GPU.
///
/// A [`Job`](crate::session::Job) or a [`Session`](crate::session::Session) renders with it.
pub trait SampleTracer: std::fmt::Debug + Send + Sync {
    /// The number of samples to trace at once.
    fn samples_at_once(&self) -> usize;

    /// The words of these samples: the values of all channels, and [`EXTRA_WORDS`]. A sample is the number of its pixel
    /// in the film's area, row by row from the top, and its index in the pixel. Samples are sorted.
    ///
    /// # Errors
    /// [`Error::Device`].
    fn trace(&mut self, samples: &[[u32; 2]]) -> Result<Vec<u32>, Error>;
}

impl World {
    /// As [`World::render`], but another tracer computes the samples.
    ///
    /// # Errors
    /// Those of [`World::render`] and of `tracer`.
    pub fn render_packed(
        &self,
        settings: &Settings,
        film: &mut Film,
        samples: Range<u64>,
        progress: &dyn Progress,
        tracer: &mut dyn SampleTracer,
    ) -> Result<Statistics, Error> {
        let [_, _, width, height] = settings.area();
        self.check_film(settings, film)?;
        let layout = film.layout();
        let words = layout.channels() + EXTRA_WORDS;
        let indices = |pixel: usize| film.range(pixel % width, pixel / width, &samples);
        let mut waiting = (0..width * height).flat_map(|pixel| indices(pixel).map(move |index| (pixel as u32, index)));
        let mut rows: Vec<Row> = (0..height).map(|_| Row::new(width * layout.words())).collect();
        loop {
            if progress.is_cancelled() {
                return Err(Error::Cancelled);
            }
            let number = |index| u32::try_from(index).map_err(|_| Error::Device(format!("no sample {index} on a GPU")));
            let next = waiting.by_ref().take(tracer.samples_at_once().max(1));
            let work = next.map(|(pixel, index)| Ok([pixel, number(index)?])).collect::<Result<Vec<_>, Error>>()?;
            let (Some(first), Some(last)) = (work.first(), work.last()) else { break };
            let (first, last) = (first[0] as usize / width, last[0] as usize / width);
            let traced = tracer.trace(&work)?;
            rows[first..=last].par_iter_mut().enumerate().for_each(|(k, row)| {
                let begin = (first + k) * width;
                let [start, end] = [begin, begin + width].map(|end| work.partition_point(|w| (w[0] as usize) < end));
                let traced = traced[start * words..end * words].chunks_exact(words);
                self.add_packed(settings, layout, begin, row, work[start..end].iter().zip(traced));
            });
        }
        rows.iter_mut().for_each(Row::end_pixel);
        Ok(film.add_traced(rows, samples))
    }

    /// Adds samples to a row, whose first pixel is `begin`.
    fn add_packed<'a>(
        &self,
        settings: &Settings,
        layout: &Layout,
        begin: usize,
        row: &mut Row,
        samples: impl Iterator<Item = (&'a [u32; 2], &'a [u32])>,
    ) {
        let mut values = vec![0.0; layout.channels()];
        for (&[pixel, _], sample) in samples {
            values.iter_mut().zip(sample).for_each(|(value, bits)| *value = f32::from_bits(*bits));
            let [distance, number, thing, rays, cut, removed] = std::array::from_fn(|k| sample[values.len() + k]);
            let strand = if number == 0 { 0 } else { nearest(f32::from_bits(distance), number) };
            let seen = Seen {
                strand,
                thing: (thing != NONE).then_some(thing),
                rays: rays.into(),
                cut: f32::from_bits(cut),
                removed: f32::from_bits(removed),
                record: None,
            };
            let pixel = pixel as usize;
            row.add(settings, layout, [pixel - begin, pixel], &values, &seen);
        }
    }
}

impl crate::integrator::view::View {
    /// The axis of the camera's turn in the world with the angle, and its movement, while the shutter is open.
    fn packed_motion(&self) -> [[u32; 4]; 2] {
        let (axis, angle, way) = self.turn();
        [axis.extend(angle), way.extend(0.0)].map(|row| row.to_array().map(f32::to_bits))
    }

    /// The axes and the origin of the camera, with film height, focus distance, lens radius and filter.
    fn packed(&self, settings: &Settings) -> [[u32; 4]; 4] {
        let (frame, camera) = self.still();
        let axes = [frame.matrix3.x_axis, frame.matrix3.y_axis, frame.matrix3.z_axis, frame.translation];
        let filter = match settings.filter {
            Filter::Box => 0,
            Filter::Tent => 1,
        };
        let rest = [self.film_height(settings.size), camera.focus_distance, camera.lens_radius].map(f32::to_bits);
        let last = [rest[0], rest[1], rest[2], filter];
        std::array::from_fn(|k| {
            let [x, y, z] = axes[k].to_array().map(f32::to_bits);
            [x, y, z, last[k]]
        })
    }
}
