//! Tests of all lights together.

use super::environment::{Map, band, from_ground};
use super::sampling::uniform_cone;
use super::*;
use glam::{Mat3, Mat4, Vec2};
use std::f32::consts::PI;
use vellus_scene::{Ground, LightShape, Link, Objects, Profile, Shaping};

fn texture(width: usize, height: usize) -> Texture {
    let pixel = |i: usize| {
        let x = ((i * 7 + 3) % 11) as f32;
        [0.1 + x * x * 0.05, 0.2, 0.3 * x]
    };
    Texture {
        name: "sky".to_owned(),
        width,
        height,
        pixels: (0..width * height).map(pixel).collect(),
        wrap: [vellus_scene::Wrap::Repeat; 2],
    }
}

fn lighting() -> Lighting {
    Lighting { reach: 1.0, ..Lighting::default() }
}

fn tube() -> LightShape {
    let (center, half_axis) = (Vec3::new(-1.2, 0.5, -1.5), Vec3::new(0.8, 0.7, 0.1));
    LightShape::Cylinder { center, half_axis, radius: 0.3, radiance: [4.0, 1.0, 2.0] }
}

fn lights() -> (Vec<Light>, Vec<Texture>) {
    let place = |x: f32, size: f32| {
        Mat4::from_cols(
            Vec3::new(size, 0.2, 0.0).extend(0.0),
            Vec3::new(0.0, size * 0.7, 0.3).extend(0.0),
            Vec3::Z.extend(0.0),
            Vec3::new(x, 0.3, 2.0).extend(1.0),
        )
    };
    let lights = [
        LightShape::Dome {
            radiance: [0.5, 1.0, 2.0],
            texture: Some(0),
            rotation: Mat3::from_rotation_y(0.7),
            ground: None,
        },
        LightShape::Distant { direction: Vec3::new(1.0, 2.0, 0.5), half_angle: 0.3, irradiance: [2.0, 1.0, 0.5] },
        LightShape::Rect { to_world: place(0.5, 1.1), radiance: [3.0, 2.0, 1.0], texture: None },
        LightShape::Disk { to_world: place(-2.0, 0.6), radiance: [1.0, 5.0, 1.0] },
        LightShape::Sphere { center: Vec3::new(0.0, -2.0, 0.4), radius: 0.8, radiance: [2.0, 2.0, 7.0] },
        tube(),
        LightShape::Sphere { center: Vec3::new(1.5, 0.0, -2.0), radius: 0.7, radiance: [1.0, 2.0, 7.0] },
    ];
    (lights.map(Light::from).to_vec(), vec![texture(16, 8)])
}

/// Light samples and uniform rays find the same light, for each light alone and for all together. The density that a
/// ray reports is that of its sample.
#[test]
fn sampling_finds_what_rays_find() {
    let (all, textures) = lights();
    // The last light shines to the left, and its edge crosses the view of it.
    let spot = Shaping {
        axis: Vec3::new(-1.0, 0.2, 0.5),
        cone: 0.9,
        softness: 0.9,
        focus: 1.5,
        tint: [0.2, 0.0, 0.5],
        profile: Some(Profile { texture: 0, side: Vec3::new(0.3, 1.0, -0.4) }),
    };
    let sets = all.iter().map(|light| vec![light.clone()]).chain([all.clone()]);
    for (which, mut set) in sets.enumerate() {
        if which + 1 >= all.len() {
            set.last_mut().unwrap().shaping = Some(spot);
        }
        let lights = Lights::new(&set, &lighting(), &textures);
        let point = Vec3::new(0.1, 0.2, -0.3);
        let seen = |direction: Vec3| {
            let ray = Ray::new(point, direction);
            match lights.intersect(&ray, Some(0)) {
                Some((_, emission)) => vec![emission],
                None => lights.escaped(&ray, Some(0)).map(|(_, emission)| emission).collect(),
            }
        };
        let n = 200_000;
        let (mut sampled, mut shot) = ([0.0f64; 2], [0.0f64; 2]);
        let mut draw = |u: [f32; 4]| {
            if let Some((_, s)) = lights.sample(0, point, [u[0], u[1], u[2]]) {
                // Only if no nearer light blocks it.
                let open = seen(s.direction).iter().any(|e| (e.t - s.distance).abs() < 1e-3 || e.t == s.distance);
                if open {
                    sampled[0] += f64::from(brightness(s.radiance) / s.pdf);
                    if set.len() == 1 {
                        let pdf = seen(s.direction)[0].pdf;
                        assert!((pdf / s.pdf - 1.0).abs() < 2e-2, "light {which}: {pdf} {}", s.pdf);
                    }
                }
                sampled[1] += 1.0;
            }
            let direction = uniform_cone(Vec3::Z, -1.0, [u[0], u[3]]);
            let found = seen(direction).into_iter().filter(|e| e.pdf > 0.0);
            shot[0] += found.map(|e| f64::from(brightness(e.radiance) * 4.0 * PI)).sum::<f64>();
            shot[1] += 1.0;
        };
        for index in 0..n {
            draw(crate::integrator::sampler::Sampler::new([which as u32, index as u32 >> 16], index, 3).next());
        }
        let (a, b) = (sampled[0] / n as f64, shot[0] / n as f64);
        // Uniform rays hit the smallest light, of 0.3 sr, 4800 times: one standard error is at most 1.5 %.
        assert!((a / b - 1.0).abs() < 0.03, "light {which}: sampled {a}, shot {b}");
    }
}

/// The light of a cylinder on a small plane, by the mean over samples and by an integral over its surface. The plane is
/// at the side, beyond an end, and nearby. From inside the infinite cylinder, its outside is not visible.
#[test]
fn light_of_a_cylinder_is_the_integral_over_its_surface() {
    let LightShape::Cylinder { center, half_axis, radius, .. } = tube() else { panic!() };
    let lights = Lights::new(&[tube().into()], &lighting(), &[]);
    let (axis, half) = (half_axis.normalize().as_dvec3(), f64::from(half_axis.length()));
    let (x, y) = { axis.any_orthonormal_pair() };
    let at = |along: f64, off: f64| center.as_dvec3() + axis * (along * half) + x * (off * f64::from(radius));
    for point in [at(0.2, 6.0), at(2.5, 3.0), at(-0.9, 1.05), at(0.0, 200.0)] {
        let point = point.as_vec3().as_dvec3();
        let normal = (center.as_dvec3() - point).normalize();
        let n = 1500;
        let mut expected = 0.0;
        for i in 0..n {
            let (sin, cos) = ((f64::from(i) + 0.5) / f64::from(n) * std::f64::consts::TAU).sin_cos();
            let out = x * cos + y * sin;
            for k in 0..n {
                let along = (2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0) * half;
                let to = center.as_dvec3() + out * f64::from(radius) + axis * along - point;
                let (d2, d) = (to.length_squared(), to.length());
                expected += (-to.dot(out) / d).max(0.0) * (to.dot(normal) / d).max(0.0) / d2;
            }
        }
        expected *= 2.0 * std::f64::consts::TAU * f64::from(radius) * half / f64::from(n * n);
        let samples = 40_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for index in 0..samples {
            let u = crate::integrator::sampler::Sampler::new([5, index >> 16], u64::from(index), 3).next();
            let found = lights
                .sample(0, point.as_vec3(), [u[0], u[1], u[2]])
                .map_or(0.0, |(_, s)| f64::from(s.direction.dot(normal.as_vec3()).max(0.0) / s.pdf));
            (sum, squares) = (sum + found, squares + found * found);
        }
        let count = f64::from(samples);
        let mean = sum / count;
        let error = ((squares / count - mean * mean) / count).sqrt();
        // Five standard errors give one false alarm in 1.7 million. The relative errors of the grid and of single
        // precision are below 1e-5.
        assert!((mean - expected).abs() < 5.0 * error + 3e-5 * expected, "{point}: {mean} {expected} ± {error}");
    }
    for inside in [at(0.3, 0.5), at(4.0, 0.9)] {
        assert!(lights.sample(0, inside.as_vec3(), [0.3, 0.6, 0.5]).is_none());
        let ray = Ray::new(inside.as_vec3(), (center - inside.as_vec3() + Vec3::new(0.1, 0.0, 0.0)).normalize());
        assert!(lights.intersect(&ray, Some(0)).is_none());
    }
}

/// A sky of one colour is not sampled, with or without a lamp. In other skies, the part that is darker than the average
/// is not sampled.
#[test]
fn uniform_skies_are_not_sampled() {
    let (all, textures) = lights();
    let even = Texture { pixels: vec![[0.3, 0.7, 0.1]; 128].into(), ..textures[0].clone() };
    let dome =
        |texture| LightShape::Dome { radiance: [0.5, 1.0, 2.0], texture, rotation: Mat3::IDENTITY, ground: None };
    let up = Ray::new(Vec3::ZERO, Vec3::Y);
    for sky in [dome(None), dome(Some(0))].map(Light::from) {
        let alone = Lights::new(std::slice::from_ref(&sky), &lighting(), std::slice::from_ref(&even));
        assert!(alone.sample(0, Vec3::ZERO, [0.4, 0.2, 0.7]).is_none());
        assert!(alone.escaped(&up, Some(0)).all(|(_, e)| e.pdf == 0.0 && e.radiance[1] > 0.0));
        let lamp = Lights::new(&[sky, all[4].clone()], &lighting(), std::slice::from_ref(&even));
        assert!((0..9).all(|i| lamp.sample(0, Vec3::ZERO, [0.4, 0.2, i as f32 / 9.0]).is_some_and(|(i, _)| i == 1)));
    }
    let bright = |i: usize| {
        if i % 16 < 5 { [2.0, 3.0, 1.0 + (i / 16) as f32] } else { [0.2, 0.5 + 0.1 * (i % 3) as f32, 0.4] }
    };
    let sun = Texture { pixels: (0..128).map(bright).collect(), ..even };
    let map = Map::new(sun.clone());
    let texel = |y: usize, x: usize| Vec2::new((x as f32 + 0.5) / 16.0, 1.0 - (y as f32 + 0.5) / 8.0);
    let mean = |f: &dyn Fn(usize, usize) -> f32| {
        (0..128).map(|i| band(i / 16, 8) * f(i / 16, i % 16)).sum::<f32>() / (2.0 * 16.0)
    };
    let average = mean(&|y, x| brightness(sun.pixels.get(y * 16 + x)));
    let sampled = |y, x| map.pdf(texel(y, x)) > 0.0;
    assert!((0..128).all(|i| sampled(i / 16, i % 16) || brightness(sun.pixels.get(i)) <= average));
    // Texels next to bright ones are sampled, because lookups spread the light.
    assert_eq!((0..128).filter(|&i| !sampled(i / 16, i % 16)).count(), 9 * 8);
    assert!((4.0 * PI * mean(&|y, x| map.pdf(texel(y, x))) - 1.0).abs() < 1e-4);
}

/// From any point above the ground, the camera sees a pattern on the ground where it was when the image was taken. The
/// light from the dome does not change.
#[test]
fn ground_is_seen_where_it_was() {
    let pattern = |p: Vec2| [0.5 + 0.4 * (0.9 * p.x).sin(), 0.5 + 0.4 * (1.3 * p.y).cos(), 0.25];
    let (origin, height, radius) = (Vec3::new(1.0, -0.5, 2.0), 1.6, 12.0);
    let rotation = Mat3::from_rotation_x(0.4) * Mat3::from_rotation_y(0.7);
    let up = rotation.y_axis;
    let (w, h) = (2048, 1024);
    let pixel = |i: usize| {
        let uv = Vec2::new(((i % w) as f32 + 0.5) / w as f32, 1.0 - ((i / w) as f32 + 0.5) / h as f32);
        let d = Map::direction(uv);
        if d.y >= 0.0 { [0.0, 0.0, 1.0 + d.y] } else { pattern(Vec2::new(d.x, d.z) * (height / -d.y)) }
    };
    let image = Texture {
        name: "g".to_owned(),
        width: w,
        height: h,
        pixels: (0..w * h).map(pixel).collect(),
        wrap: [vellus_scene::Wrap::Repeat; 2],
    };
    let ground = Ground { origin, height, radius };
    let dome = LightShape::Dome { radiance: [1.0, 1.0, 2.0], texture: Some(0), rotation, ground: Some(ground) };
    let lights = Lights::new(&[dome.into()], &lighting(), &[image]);
    let seen = |ray: &Ray, camera: bool| lights.escaped(ray, (!camera).then_some(0)).next().unwrap().1.radiance;
    for i in 0..2000 {
        let [a, b, c, d] = crate::integrator::sampler::Sampler::new([1, 2], i, 3).next();
        let spot = Vec2::new(6.0 * a - 3.0, 6.0 * b - 3.0);
        let target = origin + rotation * Vec3::new(spot.x, 0.0, spot.y);
        let eye = origin + rotation * Vec3::new(4.0 * c - 2.0, 0.3 + 3.0 * d, 1.5);
        let found = seen(&Ray::new(eye, (target - eye).normalize()), true);
        let expected = pattern(spot);
        // A texel spans 0.003 rad. At a distance of 4.5 from a height of 1.6, this is 0.04 of ground, where the pattern
        // changes by at most 0.02.
        assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 0.02), "{spot}: {found:?} {expected:?}");
        // Ground and sphere meet at the edge, with the sky above.
        let edge = origin + rotation * (Vec3::new(spot.x, 0.0, spot.y).normalize() * radius);
        let from = |to: Vec3| from_ground(&ground, up, &Ray::new(eye, (to - eye).normalize())).normalize();
        assert!(from(edge + 1e-3 * up).distance(from(edge - 1e-3 * up)) < 1e-3);
        assert!(from(edge + 1e-3 * up).distance((edge - origin - height * up).normalize()) < 1e-3);
        assert!(seen(&Ray::new(eye, (edge + 4.0 * up - eye).normalize()), true)[2] >= 2.0);
        let ray = Ray::new(eye, (target - eye).normalize());
        assert_eq!(seen(&ray, false), seen(&Ray::new(Vec3::splat(100.0), ray.direction), true));
    }
}

#[test]
fn the_camera_passes_through_lights_that_it_does_not_see() {
    let ball = |z, radiance| {
        Light::from(LightShape::Sphere { center: Vec3::new(0.0, 0.0, z), radius: 1.0, radiance: [radiance; 3] })
    };
    let sky = LightShape::Dome { radiance: [5.0; 3], texture: None, rotation: Mat3::IDENTITY, ground: None };
    let unseen = |light| Light { visible: false, ..light };
    let mut lights = Lights::new(&[unseen(ball(3.0, 1.0)), ball(6.0, 2.0), unseen(sky.into())], &lighting(), &[]);
    let ray = Ray::new(Vec3::ZERO, Vec3::Z);
    let hit = |lights: &Lights, from| lights.intersect(&ray, from).map(|(i, e)| (i, e.radiance[0]));
    assert_eq!((hit(&lights, None), hit(&lights, Some(0))), (Some((1, 2.0)), Some((0, 1.0))));
    assert_eq!((lights.escaped(&ray, None).count(), lights.escaped(&ray, Some(0)).count()), (0, 1));
    lights.scale(4.0);
    assert_eq!(hit(&lights, None), Some((1, 8.0)));
    assert!(!lights.is_black() && Lights::new(&[ball(1.0, 0.0)], &lighting(), &[]).is_black());
}

/// A spot above a plane: the irradiance at the distance r from its middle is I cos³θ/h², times the factor of the cone.
#[test]
fn a_spot_has_the_irradiance_of_the_closed_form() {
    let (height, intensity) = (2.0f32, 3.0f32);
    let spot = LightShape::Point { position: Vec3::Y * height, intensity: [intensity; 3] };
    let shaping =
        Shaping { axis: Vec3::NEG_Y * 5.0, cone: 0.5, softness: 0.5, focus: 2.0, tint: [0.0; 3], profile: None };
    let spot = Light { shaping: Some(shaping), ..spot.into() };
    let lights = Lights::new(&[spot], &lighting(), &[]);
    for i in 0..100 {
        let theta = 0.0075 * i as f32;
        let point = Vec3::X * (height * theta.tan());
        // The smoothstep between 0.25 and 0.5 radians.
        let edge = ((0.5 - theta) / 0.25).clamp(0.0, 1.0);
        let expected = intensity * theta.cos().powi(5) / (height * height) * edge * edge * (3.0 - 2.0 * edge);
        let found = lights.sample(0, point, [0.3, 0.8, 0.5]).map_or(0.0, |(_, s)| {
            assert!(s.pdf.is_infinite() && (s.distance - height / theta.cos()).abs() < 1e-5);
            s.radiance[1] * s.direction.y
        });
        assert!((found - expected).abs() < 1e-5, "{theta}: {found} {expected}");
    }
    // No ray hits a point.
    assert!(lights.intersect(&Ray::new(Vec3::ZERO, Vec3::Y), Some(0)).is_none());
}

/// The power of a light with a shaping, in closed form: (1 − cos c)/2 of a sphere in a cone of c, 1/(2(n + 1)) with the
/// focus n in a half space, and sin²c of a flat light.
#[test]
fn the_mean_of_a_shaping_is_its_share_of_the_power() {
    let shaped = |cone: f32, focus, face| {
        Shaped::new(
            &Shaping { axis: Vec3::new(1.0, 2.0, -0.5), cone, softness: 0.0, focus, tint: [0.0; 3], profile: None },
            face,
            &[],
        )
        .mean
    };
    let along = Some(Vec3::new(1.0, 2.0, -0.5).normalize());
    for cone in [0.2f32, 0.7, 1.3] {
        // One of 1024 directions is a step of 0.001.
        assert!((shaped(cone, 0.0, None) - 0.5 * (1.0 - cone.cos())).abs() < 0.001);
        assert!((shaped(cone, 0.0, along) - cone.sin().powi(2)).abs() < 0.005);
    }
    assert!((shaped(0.5 * PI, 3.0, None) - 0.125).abs() < 0.001);
    assert!(shaped(1e-4, 0.0, None) > 0.0);
}

/// Rows go from the axis to the opposite direction, and columns turn from the side.
#[test]
fn a_profile_is_looked_up_by_its_angles() {
    let pixels = (0..12).map(|i| [i as f32; 3]).collect();
    let image = Texture { name: String::new(), width: 4, height: 3, pixels, wrap: Default::default() };
    let profile = Some(Profile { texture: 0, side: Vec3::new(-2.0, 0.0, 5.0) });
    let axis = Vec3::NEG_Z;
    let shaping = Shaping { axis, cone: PI, softness: 0.0, focus: 0.0, tint: [0.0; 3], profile };
    let shaped = Shaped::new(&shaping, None, &[image]);
    let directions = [Vec3::NEG_X, Vec3::NEG_Y, Vec3::X, Vec3::Y];
    for (i, direction) in directions.into_iter().enumerate() {
        let down = (0.5 * axis + 0.5f32.sqrt() * direction).normalize();
        let rows = [4.0 + i as f32, (4.0 + i as f32) - 4.0 * (1.0 - down.dot(axis).acos() / (0.5 * PI))];
        assert!((shaped.factor(direction)[0] - rows[0]).abs() < 1e-4, "{direction}");
        assert!((shaped.factor(down)[2] - rows[1]).abs() < 1e-3, "{direction}");
    }
    // The mean of the middle row with the weight ∫ sin θ (1 − |θ − π/2|/(π/2)) dθ / 2 = 2/π, and of both poles.
    let expected = 5.5 * 2.0 / PI + (1.5 + 9.5) * 0.5 * (1.0 - 2.0 / PI);
    assert!((shaped.mean - expected).abs() < 0.02, "{} {expected}", shaped.mean);
}

/// Things share a class if the same lights reach them. Each class has the distribution of its lights, and a light that
/// lacks the shadows of some things is found through them, with the density of its samples.
#[test]
fn links_divide_things_into_classes() {
    let (mut all, textures) = lights();
    let named = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let links = vec![
        (1, Link { lit: Objects::Except(named(&["a", "c"])), ..Link::default() }),
        (4, Link { lit: Objects::Only(named(&["b", "c"])), casters: Objects::NONE, specular: 0.5, ..Link::default() }),
        (6, Link { casters: Objects::Except(named(&["d"])), ..Link::default() }),
    ];
    let plain = all.clone();
    links.into_iter().for_each(|(light, link)| all[light].link = Some(link));
    let linked = Lighting { things: named(&["a", "b", "c", "d", "a"]), ..lighting() };
    let lights = Lights::new(&all, &linked, &textures);
    assert_eq!([0, 1, 2, 3, 4].map(|thing| lights.class(thing)), [1, 0, 2, 3, 1]);
    assert_eq!(
        (lights.casters(4), lights.casters(6)),
        (Some(&[false; 5][..]), Some(&[true, true, true, false, true][..]))
    );
    assert_eq!((lights.casters(0), lights.gains(4), lights.gains(1)), (None, Some([1.0, 0.5]), None));
    let point = Vec3::new(0.1, 0.2, -0.3);
    let unlinked = Lights::new(&plain, &lighting(), &textures);
    for (class, dark) in [(0, vec![]), (1, vec![1, 4]), (2, vec![1]), (3, vec![4])] {
        let mut seen = [false; 7];
        for i in 0..4000 {
            let [u, v, w, _] = crate::integrator::sampler::Sampler::new([7, class as u32], i, 3).next();
            let Some((which, sample)) = lights.sample(class, point, [u, v, w]) else { continue };
            seen[which] = true;
            let ray = Ray::new(point, sample.direction);
            let through = lights.through(&ray, class).find(|(light, _)| *light == which);
            // The middle of the sample, so that no rounding error of an edge counts.
            if let (4 | 6, Some((_, emission))) = (which, through) {
                assert!((emission.pdf / sample.pdf - 1.0).abs() < 2e-2, "{class} {which}");
            }
        }
        assert_eq!((0..7).filter(|&light| !seen[light]).collect::<Vec<_>>(), dark, "{class}");
        // What a ray finds at once excludes the lights that are found through things.
        for i in 0..500 {
            let [u, v, ..] = crate::integrator::sampler::Sampler::new([8, class as u32], i, 3).next();
            let ray = Ray::new(point, uniform_cone(Vec3::Z, -1.0, [u, v]));
            let met = lights.intersect(&ray, Some(class)).into_iter().chain(lights.escaped(&ray, Some(class)));
            assert!(met.map(|(light, _)| light).all(|light| !dark.contains(&light) && light != 4 && light != 6));
            let [camera, plain] = [&lights, &unlinked].map(|l| l.intersect(&ray, None).map(|(i, e)| (i, e.t)));
            assert_eq!(camera, plain);
        }
    }
}

/// The sun at a pole: a bright pixel, or a bright row. Sampling finds the light of the image as it is looked up, by the
/// midpoint rule. At a pole itself, a ray sees its row alone, not the other pole.
#[test]
fn the_poles_of_a_sky_are_sampled_and_seen() {
    let (w, h) = (64, 32);
    for (top, bright) in [(true, 1), (true, w), (false, 1), (false, w)] {
        let row = if top { 0 } else { h - 1 };
        let sun = |i: usize| if i / w == row && i % w < bright { [1000.0, 500.0, 0.0] } else { [0.0, 0.25, 0.5] };
        let image = Texture {
            name: "sun".to_owned(),
            width: w,
            height: h,
            pixels: (0..w * h).map(sun).collect(),
            wrap: [vellus_scene::Wrap::Repeat; 2],
        };
        let sky = LightShape::Dome { radiance: [1.0; 3], texture: Some(0), rotation: Mat3::IDENTITY, ground: None };
        let lights = Lights::new(&[sky.into()], &lighting(), std::slice::from_ref(&image));
        let n = 40_000;
        let mut sum = 0.0f64;
        for i in 0..n {
            let [a, b, c, _] = crate::integrator::sampler::Sampler::new([9, bright as u32], i, 3).next();
            let (_, sample) = lights.sample(0, Vec3::ZERO, [a, b, c]).unwrap();
            assert!(sample.pdf.is_finite() && sample.direction.is_normalized());
            sum += f64::from(sample.radiance[0] / sample.pdf) / n as f64;
        }
        let map = Map::new(image);
        let fine = 64 * h;
        let light = |i: usize| {
            let (y, x) = (i / (2 * w), i % (2 * w));
            let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / Vec2::new((2 * w) as f32, fine as f32);
            let solid = f64::from((PI * at.y).sin() * 2.0 * PI * PI) / (fine * 2 * w) as f64;
            f64::from(map.texture.at(Vec2::new(at.x, 1.0 - at.y))[0]) * solid
        };
        let expected: f64 = (0..fine * 2 * w).map(light).sum();
        assert!((sum / expected - 1.0).abs() < 0.01, "{top} {bright}: {sum} {expected}");
        let seen = |direction| lights.escaped(&Ray::new(Vec3::ZERO, direction), Some(0)).next().unwrap().1.radiance[0];
        let pole = Vec3::Y * if top { 1.0 } else { -1.0 };
        assert!(bright == 1 || (seen(pole) == 1000.0 && seen(-pole) == 0.0), "{top}: {} {}", seen(pole), seen(-pole));
    }
}

/// A dome that is mirrored shows the mirror image, to rays and in its samples.
#[test]
fn a_mirrored_dome_shows_the_mirror_image() {
    let (_, textures) = lights();
    let mirror = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
    let turn = Mat3::from_rotation_y(0.3);
    let dome = |rotation| LightShape::Dome { radiance: [1.0; 3], texture: Some(0), rotation, ground: None };
    let [plain, mirrored] = [turn, mirror * turn].map(|turn| Lights::new(&[dome(turn).into()], &lighting(), &textures));
    for i in 0..300 {
        let [a, b, c, _] = crate::integrator::sampler::Sampler::new([4, 4], i, 3).next();
        let [(_, one), (_, other)] = [&plain, &mirrored].map(|lights| lights.sample(0, Vec3::ZERO, [a, b, c]).unwrap());
        assert!((mirror * one.direction).abs_diff_eq(other.direction, 1e-6) && one.radiance == other.radiance);
        let ray = Ray::new(Vec3::ZERO, other.direction);
        let seen = mirrored.escaped(&ray, Some(0)).next().unwrap().1;
        assert!((0..3).all(|c| (seen.radiance[c] - one.radiance[c]).abs() < 1e-2), "{seen:?} {one:?}");
    }
}
