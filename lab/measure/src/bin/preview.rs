//! A picture of a built-in scene in a second, to look at grooms without a renderer: strands as lines, brighter
//! toward their tips, and a depth buffer. `cargo run --release --bin preview -- raccoon out.png [small]`

use glam::{Vec2, Vec3};
use std::time::Instant;
use vellus::Fiber;
use vellus_groom::{flatten, scene};
use vellus_scene::{Mesh, Parameter, Scene, Strands, Values};

const HEIGHT: usize = 1200;

/// Position, normal, uv.
type Corner = (Vec3, Vec3, Vec2);

struct Film {
    width: usize,
    pixels: Vec<([f32; 3], f32)>,
    to_camera: glam::Mat4,
    scale: f32,
    light: Vec3,
}

impl Film {
    /// Pixel coordinates and depth.
    fn project(&self, p: Vec3) -> Vec3 {
        let q = self.to_camera.transform_point3(p);
        let centre = 0.5 * Vec2::new(self.width as f32, HEIGHT as f32);
        (centre + Vec2::new(q.x, -q.y) / -q.z * self.scale).extend(-q.z)
    }

    fn put(&mut self, x: f32, y: f32, depth: f32, color: [f32; 3]) {
        if x < 0.0 || y < 0.0 || x >= self.width as f32 || y >= HEIGHT as f32 || depth <= 0.0 {
            return;
        }
        let pixel = &mut self.pixels[y as usize * self.width + x as usize];
        if depth < pixel.1 {
            *pixel = (color, depth);
        }
    }

    fn mesh(&mut self, scene: &Scene, mesh: &Mesh) {
        let surface = &scene.surfaces[mesh.surface];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let corners = triangle.map(|v| mesh.positions[v as usize]);
            let flat = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
            let normals = mesh.normals.as_ref().map_or([flat; 3], |n| n[t]);
            let uv = mesh.uv.as_ref().map_or([Vec2::ZERO; 3], |uv| uv[t]);
            let texture = surface.color.texture.map(|i| &scene.textures[i]);
            let light = self.light;
            self.triangle(std::array::from_fn(|i| (corners[i], normals[i], uv[i])), 14, &|n, uv| {
                let tint = texture.map_or([1.0; 3], |texture| texture.at(uv));
                let facing = n.dot(light).max(0.0);
                let gloss = if surface.ior > 1.0 { 0.6 * facing.powf(60.0) } else { 0.0 };
                std::array::from_fn(|c| tint[c] * surface.color.color[c] * (0.25 + 0.75 * facing) + gloss)
            });
        }
    }

    /// Draws a triangle from positions, normals and uv. Triangles that reach behind the camera are divided.
    fn triangle(&mut self, [a, b, c]: [Corner; 3], depth: usize, color: &dyn Fn(Vec3, Vec2) -> [f32; 3]) {
        let [p, q, r] = [a, b, c].map(|corner| self.project(corner.0));
        if p.z.min(q.z).min(r.z) <= 1.0 {
            if depth > 0 && p.z.max(q.z).max(r.z) > 1.0 {
                let middle = |a: Corner, b: Corner| (a.0.midpoint(b.0), a.1.midpoint(b.1), a.2.midpoint(b.2));
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
                    self.triangle(part, depth - 1, color);
                }
            }
            return;
        }
        let low = p.min(q).min(r).max(Vec3::ZERO);
        let high = p.max(q).max(r).min(Vec3::new(self.width as f32, HEIGHT as f32, f32::INFINITY));
        let area = (q - p).truncate().perp_dot((r - p).truncate());
        for y in low.y as usize..(high.y + 1.0).max(0.0) as usize {
            for x in low.x as usize..(high.x + 1.0).max(0.0) as usize {
                let pixel = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - p.truncate();
                let v = pixel.perp_dot((r - p).truncate()) / area;
                let w = (q - p).truncate().perp_dot(pixel) / area;
                let u = 1.0 - v - w;
                if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                    let n = (u * a.1 + v * b.1 + w * c.1).normalize_or_zero();
                    // The inverse of the depth is linear on the screen.
                    let depth = 1.0 / (u / p.z + v / q.z + w / r.z);
                    self.put(x as f32, y as f32, depth, color(n, u * a.2 + v * b.2 + w * c.2));
                }
            }
        }
    }

    fn strands(&mut self, strands: &Strands, fiber: &Fiber) {
        let absorption = strands.varying.iter().find_map(|(parameter, values)| match (parameter, values) {
            (Parameter::SigmaCa | Parameter::Melanin, Values::PerStrand(values)) => Some((*parameter, values)),
            _ => None,
        });
        for i in 0..strands.len() {
            let mut fiber = *fiber;
            if let Some((parameter, values)) = absorption {
                parameter.set_nearest(&mut fiber, values[i]);
            }
            let sigma = fiber.sigma_ca;
            let albedo = sigma.map(|sigma| 0.85 * (-5.9 * (sigma * (1.0 - fiber.kappa)).sqrt()).exp());
            let points = strands.strand(i);
            for (k, pair) in points.windows(2).enumerate() {
                let s = k as f32 / (points.len() - 1) as f32;
                let tangent = (pair[1] - pair[0]).truncate().normalize_or_zero();
                let across = (1.0 - tangent.dot(self.light).powi(2)).max(0.0).sqrt();
                let shade = (0.35 + 0.65 * s) * (0.25 + 0.75 * across) + 0.15 * across.powi(40);
                let color = albedo.map(|a| a * shade + 0.008);
                let (a, b) = (self.project(pair[0].truncate()), self.project(pair[1].truncate()));
                let steps = (b - a).truncate().length().ceil().max(1.0);
                for j in 0..steps as usize {
                    let p = a.lerp(b, j as f32 / steps);
                    // A strand narrower than a pixel covers it with a probability. A wider strand covers several
                    // pixels.
                    let width = 2.0 * pair[0].w / p.z * self.scale;
                    let chance = (i * 7919 + k * 104_729 + j * 31) as u32;
                    if width < 1.0 && (chance.wrapping_mul(0x9e37_79b9) >> 8) as f32 / (1 << 24) as f32 > width {
                        continue;
                    }
                    let side = (b - a).truncate().perp().normalize_or_zero();
                    for w in 0..(width.ceil() as usize).max(1) {
                        let q = p.truncate() + side * (w as f32 - 0.5 * width.floor());
                        self.put(q.x, q.y, p.z, color);
                    }
                }
            }
        }
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, file, rest @ ..] = &arguments[..] else {
        eprintln!("usage: preview NAME FILE.png [small]");
        std::process::exit(2);
    };
    let start = Instant::now();
    let Some(scene) = scene(name, rest.first().is_some_and(|s| s == "small")) else {
        eprintln!("no scene {name}");
        std::process::exit(2);
    };
    let [strands, segments] = [Strands::len, Strands::segments].map(|f| scene.strands.iter().map(f).sum::<usize>());
    println!("{name}: {strands} strands, {segments} segments in {:.1} s", start.elapsed().as_secs_f32());
    let camera = scene.camera.expect("built-in scenes have one");
    let width = (HEIGHT as f32 * camera.film_width / camera.film_height) as usize;
    let eye = camera.to_world.transform_point3(Vec3::ZERO);
    let view = camera.to_world.transform_vector3(Vec3::NEG_Z);
    let right = camera.to_world.transform_vector3(Vec3::X);
    let mut film = Film {
        width,
        pixels: vec![([0.5, 0.55, 0.6], f32::INFINITY); width * HEIGHT],
        to_camera: camera.to_world.inverse(),
        scale: HEIGHT as f32 / camera.film_height,
        light: (Vec3::Y - 0.6 * view - 0.5 * right).normalize(),
    };
    // Omit faces that face away: the camera of the preview may be behind a backdrop.
    for mesh in &scene.meshes {
        let mut mesh = mesh.clone();
        if mesh.name == "backdrop" {
            mesh.normals = Some(vec![[eye.normalize_or_zero(); 3]; mesh.triangles.len()]);
        }
        film.mesh(&scene, &mesh);
    }
    for strands in &scene.strands {
        film.strands(&flatten(strands, 2), &scene.looks[strands.look].fiber);
    }
    // Average 2 × 2 pixels, and apply a gamma of 2.2.
    let (w, h) = (width / 2, HEIGHT / 2);
    let bytes: Vec<u8> = (0..w * h)
        .flat_map(|i| {
            let at = |dx: usize, dy: usize| film.pixels[(2 * (i / w) + dy) * width + 2 * (i % w) + dx].0;
            let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
            std::array::from_fn::<u8, 3, _>(|c| {
                let mean: f32 = 0.25 * four.iter().map(|p| p[c]).sum::<f32>();
                (mean.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0) as u8
            })
        })
        .collect();
    let output = std::fs::File::create(file).expect("the file can be written");
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(output), w as u32, h as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(&bytes)).expect("the file can be written");
}
