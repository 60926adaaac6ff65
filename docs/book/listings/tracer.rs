//! A path tracer for straight fibres under a sky: every part that a renderer needs to use `vellus`.

use std::f32::consts::PI;
use std::io::Write;
use vellus::glam::Vec3;
use vellus::{Bcsdf, Fiber, FiberFrame, Species, Window};

const SIZE: u32 = 128;
const SAMPLES: u32 = 64;
/// Side of a pixel of the orthographic camera, in scene units.
const PIXEL: f32 = 2.0 / SIZE as f32;

// ANCHOR: geometry
#[derive(Clone, Copy)]
struct Ray {
    origin: Vec3,
    direction: Vec3,
}

/// A straight fibre without ends: a point on its axis, the unit tangent from root to tip,
/// and the radius.
struct Cylinder {
    point: Vec3,
    tangent: Vec3,
    radius: f32,
}

impl Cylinder {
    /// The distance at which a ray enters from outside.
    fn enter(&self, ray: &Ray) -> Option<f32> {
        let across = |v: Vec3| v - self.tangent * v.dot(self.tangent);
        let (o, d) = (across(ray.origin - self.point), across(ray.direction));
        let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared() - self.radius * self.radius);
        let discriminant = b * b - a * c;
        // c ≤ 0: the ray starts inside. It leaves; only entries count.
        (c > 0.0 && b < 0.0 && discriminant > 0.0).then(|| (-b - discriminant.sqrt()) / a)
    }
}
// ANCHOR_END: geometry

// ANCHOR: frame
/// The frame of a fibre at a hit.
fn frame_at(fiber: &Cylinder, hit: Vec3) -> FiberFrame {
    let center = fiber.point + fiber.tangent * (hit - fiber.point).dot(fiber.tangent);
    FiberFrame::new(fiber.tangent, center, fiber.radius)
}
// ANCHOR_END: frame

// ANCHOR: leave
/// A ray that leaves a fibre, from the side that faces `direction`.
fn leave(frame: &FiberFrame, direction: Vec3) -> Ray {
    let origin = frame.center() + frame.outward(direction) * (1.001 * frame.radius());
    Ray { origin, direction }
}
// ANCHOR_END: leave

struct Scene<'a> {
    fibers: Vec<Cylinder>,
    bcsdf: Bcsdf<'a>,
    sky: fn(Vec3) -> Vec3,
}

impl Scene<'_> {
    fn nearest(&self, ray: &Ray) -> Option<(f32, &Cylinder)> {
        let hits = self.fibers.iter().filter_map(|fiber| Some((fiber.enter(ray)?, fiber)));
        hits.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn blocked(&self, ray: &Ray) -> bool {
        self.fibers.iter().any(|fiber| fiber.enter(ray).is_some())
    }

    // ANCHOR: trace
    /// Radiance that arrives along a ray of the camera.
    fn radiance(&self, mut ray: Ray, random: &mut Random) -> Vec3 {
        // The sky is sampled evenly over the sphere.
        const SKY_PDF: f32 = 1.0 / (4.0 * PI);
        let mut light = Vec3::ZERO;
        let mut throughput = Vec3::ONE;
        // Density with which the ray's direction was drawn; none for the camera's ray.
        let mut drawn: Option<f32> = None;
        for depth in 0.. {
            let Some((t, fiber)) = self.nearest(&ray) else {
                let weight = drawn.map_or(1.0, |pdf| power_heuristic(pdf, SKY_PDF));
                light += throughput * (self.sky)(ray.direction) * weight;
                break;
            };
            let point = ray.origin + ray.direction * t;
            let frame = frame_at(fiber, point);
            let wo = -ray.direction;
            let h = frame.offset(point, wo);
            let window = if depth == 0 {
                Window::cell(h, 0.5 * frame.pixel_width(PIXEL), random.next())
            } else {
                Window::near(h)
            };
            let hit = self.bcsdf.at(frame.to_local(wo), window);

            // Next-event estimation. Light may come from anywhere: there is no cosine to test.
            let direction = random.direction();
            let (f, pdf) = hit.eval_pdf(frame.to_local(direction));
            if !self.blocked(&leave(&frame, direction)) {
                let weight = power_heuristic(SKY_PDF, pdf) / SKY_PDF;
                light += throughput * Vec3::from(f.total()) * (self.sky)(direction) * weight;
            }

            // The path goes on. `weight` is f·cos θ/pdf: multiply by nothing else.
            let Some(sample) = hit.sample(std::array::from_fn(|_| random.next())) else { break };
            throughput *= Vec3::from(sample.weight);
            drawn = Some(sample.pdf);
            ray = leave(&frame, frame.to_world(sample.wi));

            // Russian roulette. White fur scatters often: do not limit the depth instead.
            if depth >= 3 {
                let survival = throughput.max_element().min(1.0);
                if random.next() >= survival {
                    break;
                }
                throughput /= survival;
            }
        }
        light
    }
    // ANCHOR_END: trace
}

/// Weight of a sample drawn with density `own` where another technique could have drawn it with `other` (Veach 1997).
fn power_heuristic(own: f32, other: f32) -> f32 {
    own * own / (own * own + other * other)
}

/// The picture's linear RGB, row by row from the top.
fn render(scene: &Scene) -> Vec<Vec3> {
    let mut picture = Vec::new();
    for y in 0..SIZE {
        for x in 0..SIZE {
            let mut random = Random(u64::from(y * SIZE + x) << 32);
            let mut sum = Vec3::ZERO;
            for _ in 0..SAMPLES {
                let (u, v) = (x as f32 + random.next(), y as f32 + random.next());
                let origin = Vec3::new(u * PIXEL - 1.0, 1.0 - v * PIXEL, 10.0);
                sum += scene.radiance(Ray { origin, direction: Vec3::NEG_Z }, &mut random);
            }
            picture.push(sum / SAMPLES as f32);
        }
    }
    picture
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut random = Random(7);
    let fibers = || {
        let point = Vec3::new(2.0 * random.next() - 1.0, 0.0, 2.0 * random.next() - 1.0);
        let tangent = (Vec3::Y + 0.2 * random.direction()).normalize();
        Cylinder { point, tangent, radius: 0.03 }
    };
    let fibers = std::iter::repeat_with(fibers).take(60).collect();

    // White fibres under a white sky: every pixel must be 1.
    let white = Fiber::preset(Species::RedFox).without_absorption();
    let mut scene = Scene { fibers, bcsdf: Bcsdf::new(&white)?, sky: |_| Vec3::ONE };
    let picture = render(&scene);
    let n = picture.len() as f32;
    let mean = picture.iter().sum::<Vec3>() / n;
    let deviation = picture.iter().map(|p| (p.x - mean.x).powi(2)).sum::<f32>() / (n - 1.0);
    println!("white furnace: {:.4} ± {:.4}", mean.x, (deviation / n).sqrt());

    // A red fox under a sky that is bright to the right.
    let fox = Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]);
    scene.bcsdf = Bcsdf::new(&fox)?;
    scene.sky = |w| Vec3::splat(0.1) + Vec3::splat(3.0 * w.x.max(0.0).powi(8));
    let mut file = std::fs::File::create("fox.ppm")?;
    writeln!(file, "P6 {SIZE} {SIZE} 255")?;
    for pixel in render(&scene) {
        file.write_all(&pixel.to_array().map(|c| (255.0 * c.min(1.0).powf(1.0 / 2.2)) as u8))?;
    }
    Ok(())
}

/// A small random number generator (SplitMix64).
struct Random(u64);

impl Random {
    /// Uniform in [0, 1).
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Uniform over the sphere, with density 1/4π.
    fn direction(&mut self) -> Vec3 {
        let (z, phi) = (2.0 * self.next() - 1.0, 2.0 * PI * self.next());
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    }
}
