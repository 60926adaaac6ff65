//! What the coats of a world show for a reflectance.
//!
//! Someone who asks for a reflectance means the colour that the fur shows. The absorption for it is known for a dense
//! reference coat ([`CoatColors`]). Other coats are thinner, show their skin, or have shadows between their clumps. So
//! a world renders its own coats in a white dome, from all sides, for a few reflectances of the dense coat, and inverts
//! what it finds. Channels are independent: a picture has three reflectances at once.

mod reach;
mod skin;

use crate::film::fibonacci;
use crate::film::layout::Layout;
use crate::geometry::instances::Hit;
use crate::geometry::ray::Ray;
use crate::geometry::triangles::Triangles;
use crate::integrator::cache::Indirect;
use crate::integrator::geometry::Geometry;
use crate::integrator::path::{Shared, Trace, camera_ray};
use crate::integrator::settings::{Mode, Settings};
use crate::integrator::view::View;
use crate::light::{Lighting, Lights};
use crate::shading::fibers::Fibers;
use glam::{Mat3, Vec3, Vec4Swizzles};
use rayon::prelude::*;
use std::collections::{BTreeSet, HashSet};
use vellus::{Bcsdf, CoatColors, Fiber, Parameter};
use vellus_scene::{Camera, LightShape, Look, Mesh, Strands};

/// Reflectances of the dense coat for which coats are rendered, three in each picture.
const DENSE: [[f32; 3]; 4] = [[0.001, 0.04, 0.1], [0.2, 0.35, 0.5], [0.65, 0.8, 0.88], [0.94, 0.98, 0.999]];
const NODES: usize = 3 * DENSE.len();

/// Directions from which coats are seen, pixels on a side of each picture, and samples of a pixel.
const VIEWS: usize = 24;
const SIZE: usize = 20;
const SAMPLES: u64 = 2;

/// The distance of the cameras, in radii of the sphere around the strands: rays are nearly parallel.
const DISTANCE: f32 = 20.0;

/// A coat of which fewer samples than this are seen is not measured. The mean of this many has an error of about 1 %.
const FEWEST: u64 = 400;

/// Cells of the grid that finds furred skin have at least this many roots on average.
const ROOTS: usize = 8;

/// Roots of each set of strands that look for their skin.
const PROBES: usize = 64;

/// What a coat shows, as a function of the reflectance that a dense coat of the same fibres has.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Reflectances of the dense coat, increasing.
    dense: [f32; NODES],
    /// The colours that the coat shows, never decreasing.
    shown: [f32; NODES],
    /// The share of the furred skin that fur hides, seen from all sides, in [0, 1].
    pub cover: f32,
}

impl Shown {
    /// The darkest and the brightest colour that pigment gives to the coat.
    pub fn range(&self) -> [f32; 2] {
        [self.shown[0], self.shown[NODES - 1]]
    }

    /// The colour of the coat that is nearest to a request. A request that is too bright is darkened as a whole, so
    /// that it keeps its hue.
    pub fn nearest(&self, asked: [f32; 3]) -> [f32; 3] {
        let [low, high] = self.range();
        let brightest = asked.iter().copied().fold(high, f32::max);
        asked.map(|c| (c * (high / brightest)).max(low))
    }

    /// The reflectance of a dense coat for which the coat shows a colour, or the nearest that it can show.
    pub fn dense(&self, shown: f32) -> f32 {
        let above = self.shown.partition_point(|s| *s < shown);
        if above == 0 || above == NODES {
            return self.dense[above.min(NODES - 1)];
        }
        let [low, high] = [self.shown[above - 1], self.shown[above]];
        self.dense[above - 1] + (shown - low) / (high - low) * (self.dense[above] - self.dense[above - 1])
    }
}

/// What a reflectance means for the coats of a world.
#[derive(Clone, Debug)]
pub(crate) enum Reflectance {
    /// The colour of a dense coat.
    Dense,
    /// The colour that the coat itself shows, for each look. `None` for coats that were not measured.
    Shown(Vec<Option<Shown>>),
    /// While coats are measured, all have this reflectance.
    Fixed([f32; 3]),
}

impl Reflectance {
    /// The reflectance of a dense coat that stands for a request.
    pub fn dense(&self, look: usize, asked: [f32; 3]) -> [f32; 3] {
        match self {
            Reflectance::Dense => asked,
            Reflectance::Fixed(fixed) => *fixed,
            Reflectance::Shown(all) => all
                .get(look)
                .and_then(Option::as_ref)
                .map_or(asked, |shown| shown.nearest(asked).map(|c| shown.dense(c))),
        }
    }
}

/// Whether somebody asks for the reflectance of a coat.
fn is_asked(geometry: &Geometry) -> bool {
    let reflectance = |parameter: &Parameter| *parameter == Parameter::Reflectance;
    geometry
        .looks
        .iter()
        .any(|look| look.fiber.reflectance.is_some() || look.textured.iter().any(|(p, _)| reflectance(p)))
        || geometry.all_strands().any(|strands| strands.varying.iter().any(|(p, _)| reflectance(p)))
}

/// Gives the looks with a constant reflectance the pigment with which their coats show it, after measuring the coats if
/// nobody asked for a reflectance before.
///
/// If `shows` is false, only skin gets its colour.
pub(crate) fn resolve(geometry: &mut Geometry, shows: bool) {
    let measures = shows && is_asked(geometry);
    let is_new = measures && matches!(geometry.reflectance, Reflectance::Dense);
    if is_new || geometry.surfaces.iter().any(|surface| surface.skin) {
        let roots = Roots::new(geometry.curves.strands());
        let owners = roots.owners(geometry);
        if is_new {
            geometry.reflectance = Reflectance::Shown(measure(geometry, &roots, &owners));
        }
        skin::color(geometry, &owners, None);
    }
    if !measures {
        return;
    }
    let Geometry { looks, reflectance, .. } = geometry;
    for (i, look) in looks.iter_mut().enumerate() {
        if let Some(asked) = look.fiber.reflectance {
            look.fiber = with_reflectance(look, reflectance.dense(i, asked));
        }
    }
}

/// The fibre of a look, with the pigment for the reflectance of a dense coat. The request stays.
fn with_reflectance(look: &Look, dense: [f32; 3]) -> Fiber {
    let mut fiber = look.fiber;
    Parameter::Reflectance.set_nearest(&mut fiber, dense);
    Fiber { reflectance: look.fiber.reflectance, ..fiber }
}

/// What the camera sees of coats with three reflectances: for each look, and last the furred skin, the sum of radiances
/// and the number of samples.
type Seen = Vec<([f64; 3], u64)>;

/// Renders the coats of a geometry.
///
/// The lights, the camera and the meshes without fur do not matter; they are as before in the end. Looks for which
/// nobody asks a reflectance keep their colours.
fn measure(geometry: &mut Geometry, roots: &Roots, owners: &[BTreeSet<usize>]) -> Vec<Option<Shown>> {
    let white = LightShape::Dome { radiance: [1.0; 3], texture: None, rotation: Mat3::IDENTITY, ground: None };
    let meshes = geometry.triangles.meshes().iter().zip(owners).filter(|(_, looks)| !looks.is_empty());
    let (bodies, owners): (Vec<Mesh>, Vec<BTreeSet<usize>>) = meshes.map(|(m, o)| (m.clone(), o.clone())).unzip();
    let body = Triangles::new(bodies);
    let lights = Lights::new(&[white.into()], &Lighting::default(), &[]);
    let body = std::mem::replace(&mut geometry.triangles, body);
    let lights = std::mem::replace(&mut geometry.lights, lights);
    let (view, background, looks) = (geometry.view, geometry.background.take(), geometry.looks.clone());
    let surfaces = geometry.surfaces.clone();
    geometry.update_motion();

    let tables: Vec<Option<CoatColors>> = looks.iter().map(|look| CoatColors::new(&look.fiber).ok()).collect();
    let mut seen: Vec<Seen> = Vec::new();
    // A reflectance is the colour of dry fur.
    geometry.looks.iter_mut().for_each(|look| look.fiber.wet = 0.0);
    for dense in DENSE {
        for (look, asked) in geometry.looks.iter_mut().zip(&looks) {
            if asked.fiber.reflectance.is_some() {
                look.fiber = Fiber { wet: 0.0, ..with_reflectance(asked, dense) };
            }
        }
        geometry.reflectance = Reflectance::Fixed(dense);
        skin::color(geometry, &owners, Some(dense));
        seen.push(look_at(geometry, roots));
    }
    geometry.triangles = body;
    geometry.lights = lights;
    geometry.background = background;
    geometry.looks = looks;
    geometry.surfaces = surfaces;
    geometry.view = view;
    geometry.update_motion();
    let of_look = |(look, table): (usize, &Option<CoatColors>)| shown(&seen, look, table.as_ref()?);
    tables.iter().enumerate().map(of_look).collect()
}

/// What a look shows, from what was seen with the reflectances of [`DENSE`].
fn shown(seen: &[Seen], look: usize, table: &CoatColors) -> Option<Shown> {
    let looks = seen[0].len() - 1;
    let count = |of: usize| seen[0][of].1;
    if count(look) < FEWEST {
        return None;
    }
    let hidden: u64 = (0..looks).map(count).sum();
    let cover = hidden as f64 / (hidden + count(looks)) as f64;
    let [low, high] = table.range();
    let mut result = Shown { dense: [0.0; NODES], shown: [0.0; NODES], cover: cover as f32 };
    let mut brightest = 0.0;
    for (i, dense) in DENSE.concat().into_iter().enumerate() {
        let mean = |of: usize| {
            let (sum, count) = seen[i / 3][of];
            sum[i % 3] / count.max(1) as f64
        };
        // Noise may make a darker pigment brighter by a little.
        brightest = f64::max(brightest, cover * mean(look) + (1.0 - cover) * mean(looks));
        result.dense[i] = dense.clamp(low, high);
        result.shown[i] = brightest as f32;
    }
    Some(result)
}

/// Looks at coats from all sides.
fn look_at(geometry: &mut Geometry, roots: &Roots) -> Seen {
    let spheres = geometry.spheres(VIEWS);
    let angle = 2.0 * (1.0 / DISTANCE).atan();
    let settings = Settings { mode: Mode::Near, ..Settings::new([SIZE; 2]) };
    let layout = Layout::new(&[], &[]);
    let fibers: Fibers<Bcsdf<'static>> = match Fibers::new(geometry.all_strands(), &geometry.looks, Bcsdf::new) {
        Ok(fibers) => fibers,
        Err(error) => unreachable!("the looks were valid: {error}"),
    };
    let look_of: Vec<usize> = geometry.all_strands().map(|strands| strands.look).collect();
    let skin = geometry.looks.len();
    let mut seen: Seen = vec![([0.0; 3], 0); skin + 1];
    for (i, &(middle, radius)) in spheres.iter().cycle().take(VIEWS).enumerate() {
        let toward = fibonacci(i, VIEWS);
        let up = toward.any_orthonormal_vector();
        geometry.view = View::new(Camera::look_at(middle + DISTANCE * radius * toward, middle, up, angle, 1.0));
        let geometry = &*geometry;
        let settings = Settings { seed: i as u32, ..settings };
        let view = &geometry.view;
        let shared = Shared { settings: &settings, layout: &layout, view, indirect: Indirect::Traced };
        let rows: Vec<Seen> = (0..SIZE)
            .into_par_iter()
            .map(|y| {
                let mut row: Seen = vec![([0.0; 3], 0); skin + 1];
                let mut values = vec![0.0; layout.channels()];
                for (x, index) in (0..SIZE).flat_map(|x| (0..SAMPLES).map(move |index| (x, index))) {
                    let first = fibers.trace(geometry, shared, [x, y], index, &mut values).thing;
                    let Some(thing) = first.map(|thing| thing as usize) else { continue };
                    let of = match look_of.get(thing) {
                        Some(look) => *look,
                        None if roots.is_near(geometry, &settings, [x, y], index) => skin,
                        None => continue,
                    };
                    let (sum, count) = &mut row[of];
                    (0..3).for_each(|c| sum[c] += f64::from(values[c]));
                    *count += 1;
                }
                row
            })
            .collect();
        for (all, one) in rows.iter().flatten().enumerate().map(|(k, one)| (k % (skin + 1), one)) {
            (0..3).for_each(|c| seen[all].0[c] += one.0[c]);
            seen[all].1 += one.1;
        }
    }
    seen
}

/// A grid of the roots of strands. It tells the skin under fur from other skin.
struct Roots {
    side: f32,
    cells: HashSet<[i32; 3]>,
}

impl Roots {
    fn new(sets: &[Strands]) -> Self {
        let roots: Vec<Vec3> = sets.iter().flat_map(|set| (0..set.len()).map(|i| set.strand(i)[0].xyz())).collect();
        let bounds = roots.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let size = (bounds.1 - bounds.0).max_element().max(f32::MIN_POSITIVE);
        let mut side = size / 512.0;
        loop {
            let cells: HashSet<[i32; 3]> = roots.iter().map(|root| cell(*root, side)).collect();
            if cells.len() * ROOTS <= roots.len() || side >= size {
                return Roots { side, cells };
            }
            side *= 1.5;
        }
    }

    /// The looks whose roots stand on each mesh.
    fn owners(&self, geometry: &Geometry) -> Vec<BTreeSet<usize>> {
        let mut owners = vec![BTreeSet::new(); geometry.triangles.meshes().len()];
        for strands in geometry.curves.strands() {
            for probe in 0..PROBES.min(strands.len()) {
                let strand = strands.strand(probe * strands.len() / PROBES.min(strands.len()));
                let [root, next, ..] = strand else { continue };
                let along = (next.xyz() - root.xyz()).normalize_or(Vec3::Y);
                // Roots may hover over their skin, or lie below it.
                let ray = Ray { t_max: 2.0 * self.side, ..Ray::new(root.xyz() + along * self.side, -along) };
                if let Some(hit) = geometry.triangles.intersect(&ray) {
                    owners[hit.mesh].insert(strands.look);
                }
            }
        }
        owners
    }

    /// Whether the camera sees skin with fur in a sample of a pixel.
    fn is_near(&self, geometry: &Geometry, settings: &Settings, pixel: [usize; 2], index: u64) -> bool {
        let (_, _, ray) = camera_ray(geometry, &geometry.view, settings, pixel, index);
        match geometry.intersect(&ray) {
            Some(Hit::Triangle(hit)) => self.cells.contains(&cell(ray.at(hit.t), self.side)),
            _ => false,
        }
    }
}

fn cell(point: Vec3, side: f32) -> [i32; 3] {
    (point / side).floor().as_ivec3().to_array()
}
