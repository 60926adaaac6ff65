//! Whiskers: long stiff hairs beside the mouth.

use glam::{Vec3, Vec4};
use vellus_scene::{Basis, Parameter, Scene, Strands, Values};

const SEGMENTS: usize = 10;

/// Whiskers on both sides of a face that looks along +x.
pub(super) struct Whiskers {
    /// The middle of the pad at positive z.
    pub pad: Vec3,
    /// Distance between rows, and between whiskers of a row.
    pub spacing: [f32; 2],
    /// Rows, and whiskers in a row.
    pub count: [usize; 2],
    /// The direction of a whisker in the middle of the pad.
    pub direction: Vec3,
    pub length: f32,
    /// Radius at the root.
    pub radius: f32,
    /// Concentrations of eumelanin and pheomelanin.
    pub melanin: [f32; 2],
}

impl Whiskers {
    /// Adds them to a scene. They have the fibre of the coat, which must be in the scene. `project` returns the nearest
    /// point on the skin.
    pub fn add(&self, scene: &mut Scene, project: impl Fn(Vec3) -> Vec3) {
        let Some(look) = scene.strands.first().map(|coat| coat.look) else { return };
        let [rows, columns] = self.count;
        let mut points = Vec::new();
        for i in 0..2 * rows * columns {
            let (row, column) = (i / 2 / columns, i / 2 % columns);
            let middle = |k: usize, n: usize| k as f32 - 0.5 * (n - 1) as f32;
            let (v, u) = (middle(row, rows), middle(column, columns));
            // Fixed irregularities.
            let vary = |k: f32| (12.9 * i as f32 + k).sin();
            let backward = Vec3::new(-u + 0.3 * vary(0.0), 0.15 * vary(1.0), 0.0) * self.spacing[1];
            let root = project(self.pad + backward - Vec3::Y * (v * self.spacing[0]));
            let way = self.direction.normalize_or(Vec3::Z) + Vec3::new(-0.22 * -u, -0.28 * v + 0.06 * vary(2.0), 0.0);
            let way = (way + Vec3::X * (0.1 * vary(3.0))).normalize_or(Vec3::Z);
            let length = self.length * (0.85 + 0.15 * vary(4.0)) * (1.0 - 0.16 * u.abs());
            let flip = if i % 2 == 0 { 1.0 } else { -1.0 };
            // One more point at each end, as Catmull–Rom curves need.
            points.extend((-1..=SEGMENTS as i32 + 1).map(|k| {
                let s = k as f32 / SEGMENTS as f32;
                let bend = Vec3::new(-0.12, -0.2 - 0.06 * vary(5.0), 0.0) * (s * s);
                let p = root + (way * s + bend) * length;
                let radius = self.radius * (1.0 - 0.85 * s.clamp(0.0, 1.0));
                Vec4::new(p.x, p.y, p.z * flip, radius)
            }));
        }
        let per_strand = SEGMENTS + 3;
        let [eumelanin, pheomelanin] = self.melanin;
        scene.strands.push(Strands {
            name: "whiskers".to_owned(),
            basis: Basis::CatmullRom,
            starts: (0..=2 * rows * columns).map(|i| (i * per_strand) as u32).collect(),
            points,
            moved: None,
            normals: None,
            root_uv: None,
            look,
            varying: vec![(Parameter::Melanin, Values::Constant([eumelanin, pheomelanin, 0.0]))],
        });
    }
}
