//! Lights.

use super::{NONE, PackedScene, rgb};
use crate::light::distribution::PiecewiseConstant1D;
use crate::light::environment::Map;
use crate::light::prepared::Prepared;
use crate::light::{Lights, Reaching};
use glam::Vec3;
use vellus_scene::Texture;

/// Rows of each light.
pub(super) const ROWS: u32 = 11;

/// What a light is to a tracer.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Dome = 1,
    Distant,
    Flat,
    Point,
    Sphere,
    Cylinder,
}

impl Kind {
    pub const ALL: [Kind; 6] = [Kind::Dome, Kind::Distant, Kind::Flat, Kind::Point, Kind::Sphere, Kind::Cylinder];
}

/// Where the lights are.
pub(crate) struct PackedLights {
    /// The first row, [`ROWS`] for each light.
    pub rows: u32,
    /// The first number of what reaches the things of each class: for each light its probability, then the sums of the
    /// probabilities from 0 to 1, then for each light whether rays find it (bit 0) and whether it reaches them (bit 1).
    pub reaching: u32,
    /// The first number of the classes of all things, or [`NONE`] if there are no links.
    pub classes: u32,
    /// Whether there are lights of each kind, in the order of [`Kind::ALL`]; whether any has a shaping; and images of
    /// skies, of lamps, and of profiles.
    pub kinds: [bool; 6],
    pub shaping: bool,
    pub images: [bool; 3],
}

fn vector(v: Vec3, w: f32) -> [f32; 4] {
    [v.x, v.y, v.z, w]
}

fn sums(packed: &mut PackedScene, distributions: &[&PiecewiseConstant1D]) -> u32 {
    packed.numbers(distributions.iter().flat_map(|d| d.sums().iter().map(|sum| sum.to_bits())))
}

/// Appends an image of its own. Returns its row: size, first pixel, and how it continues.
fn image(packed: &mut PackedScene, texture: &Texture) -> u32 {
    let first = packed.data.len() as u32 + 1;
    // A sky repeats from left to right. A lamp is only looked up inside of its image.
    let row = packed.row([texture.width as u32, texture.height as u32, first, 1 << 16]);
    packed.data.extend(texture.pixels.iter().map(|pixel| rgb(pixel, 0.0).map(f32::to_bits)));
    row
}

impl Lights {
    /// Packs all lights.
    pub(crate) fn packed(&self, packed: &mut PackedScene, groups: &[usize]) -> PackedLights {
        // Images and distributions come first, because the rows of the lights are adjacent.
        let mut all: Vec<[[u32; 4]; ROWS as usize]> = Vec::new();
        for (k, light) in self.all().iter().enumerate() {
            let mut rows = [[0u32; 4]; ROWS as usize];
            let casters = self.casters(k).map_or(NONE, |casts| packed.numbers(casts.iter().map(|&casts| casts.into())));
            let (kind, shape) = self.shape(packed, light);
            rows[0] = [kind as u32, casters, u32::from(self.is_visible(k)), groups[k] as u32];
            rows[1] = rgb(light.radiance(), 0.0).map(f32::to_bits);
            rows[2..7].copy_from_slice(&shape);
            if let Some(shaped) = self.shaping(k) {
                let (shaping, cos_end, profile) = shaped.packed();
                rows[1][3] = 1;
                rows[7] = vector(shaping.axis, cos_end).map(f32::to_bits);
                rows[8] = [0.0, shaping.cone, shaping.softness, shaping.focus].map(f32::to_bits);
                rows[8][0] = NONE;
                rows[9] = rgb(shaping.tint, 0.0).map(f32::to_bits);
                if let Some((profile, texture)) = profile {
                    rows[8][0] = image(packed, texture);
                    rows[10] = vector(profile.side, 0.0).map(f32::to_bits);
                }
            }
            let [diffuse, specular] = self.gains(k).unwrap_or([1.0; 2]).map(f32::to_bits);
            (rows[9][3], rows[10][3]) = (diffuse, specular);
            all.push(rows);
        }
        let reaching = |(class, Reaching { shares, chances, found }): (usize, &Reaching)| {
            let reached = |light: usize| self.links.as_ref().is_none_or(|links| links.reaches[class][light]);
            let bits =
                found.iter().enumerate().map(|(light, &found)| u32::from(found) | u32::from(reached(light)) << 1);
            let numbers = shares.iter().chain(chances.sums()).map(|number| number.to_bits());
            numbers.chain(bits).collect::<Vec<_>>()
        };
        let reaching = packed.numbers(self.reaching.iter().enumerate().flat_map(reaching));
        let classes = self.links.as_ref().map_or(NONE, |links| packed.numbers(links.classes().iter().copied()));
        let kinds = Kind::ALL.map(|kind| all.iter().any(|rows| rows[0][0] == kind as u32));
        let shaping = all.iter().any(|rows| rows[1][3] == 1);
        let sky = |rows: &[[u32; 4]; 11]| rows[0][0] == Kind::Dome as u32 && rows[5][0] != NONE;
        let lamp = |rows: &[[u32; 4]; 11]| rows[0][0] == Kind::Flat as u32 && rows[6][0] != NONE;
        let profile = |rows: &[[u32; 4]; 11]| rows[1][3] == 1 && rows[8][0] != NONE;
        let images = [all.iter().any(sky), all.iter().any(lamp), all.iter().any(profile)];
        let rows = packed.data.len() as u32;
        packed.data.extend(all.into_iter().flatten());
        PackedLights { rows, reaching, classes, kinds, shaping, images }
    }

    /// The kind of a light, and five rows of its shape.
    fn shape(&self, packed: &mut PackedScene, light: &Prepared) -> (Kind, [[u32; 4]; 5]) {
        let none = [0.0; 4];
        let (kind, floats) = match light {
            Prepared::Dome { map, rotation, ground, .. } => {
                let mut rows = [
                    vector(rotation.x_axis, 0.0).map(f32::to_bits),
                    vector(rotation.y_axis, 0.0).map(f32::to_bits),
                    vector(rotation.z_axis, 0.0).map(f32::to_bits),
                    [NONE, NONE, NONE, 0],
                    [0; 4],
                ];
                if let Some(ground) = ground {
                    rows[4] = vector(ground.origin, ground.height).map(f32::to_bits);
                    rows[0][3] = ground.radius.to_bits();
                }
                if let Some(map) = map {
                    let Map { texture, rows: lines, columns, .. } = map;
                    let columns: Vec<&PiecewiseConstant1D> = columns.iter().collect();
                    let [lines, columns] = [sums(packed, &[lines]), sums(packed, &columns)];
                    rows[3] = [image(packed, texture), lines, columns, 0];
                }
                return (Kind::Dome, rows);
            }
            Prepared::Distant { direction, half_angle, .. } => {
                (Kind::Distant, [vector(*direction, *half_angle), [half_angle.cos(), 0.0, 0.0, 0.0], none, none, none])
            }
            Prepared::Flat { center, x, y, normal, area, disk, texture, .. } => {
                let disk = f32::from(u8::from(*disk));
                let rows = [vector(*center, *area), vector(*x, disk), vector(*y, 0.0), vector(*normal, 0.0), none];
                let mut rows = rows.map(|row| row.map(f32::to_bits));
                rows[4][0] = texture.as_ref().map_or(NONE, |texture| image(packed, texture));
                return (Kind::Flat, rows);
            }
            Prepared::Point { position, .. } => (Kind::Point, [vector(*position, 0.0), none, none, none, none]),
            Prepared::Sphere { center, radius, .. } => {
                (Kind::Sphere, [vector(*center, *radius), none, none, none, none])
            }
            Prepared::Cylinder { center, axis, half_length, radius, .. } => {
                (Kind::Cylinder, [vector(*center, *radius), vector(*axis, *half_length), none, none, none])
            }
        };
        (kind, floats.map(|row| row.map(f32::to_bits)))
    }
}
