//! Growth: strands have the requested number, lie on the surface, follow the density, and do not depend on the number
//! of threads.

use glam::{Vec2, Vec3};
use vellus_groom::{Clump, Error, GrowSettings, Maps, grow};
use vellus_scene::{Basis, Mesh, Parameter, Values};

/// A square of 10 × 10 at y = 0 that faces up, in 2 × 32 × 32 triangles, with uv in [0, 1].
fn square() -> Mesh {
    const N: u32 = 32;
    let vertex = |i: u32| Vec2::new((i % (N + 1)) as f32, (i / (N + 1)) as f32) / N as f32;
    let cell = |i: u32| {
        let a = i / N * (N + 1) + i % N;
        [[a, a + N + 1, a + N + 2], [a, a + N + 2, a + 1]]
    };
    let triangles: Vec<[u32; 3]> = (0..N * N).flat_map(cell).collect();
    Mesh {
        moved: None,
        name: "square".to_owned(),
        positions: (0..(N + 1) * (N + 1)).map(|i| 10.0 * Vec3::new(vertex(i).x, 0.0, vertex(i).y)).collect(),
        uv: Some(triangles.iter().map(|t| t.map(vertex)).collect()),
        triangles,
        normals: None,
        surface: 0,
    }
}

fn settings() -> GrowSettings {
    GrowSettings {
        count: 4000,
        segments: 7,
        guard_share: 0.3,
        gravity: 0.4,
        clump: Clump { strands: 20, strength: 0.7, power: 1.2 },
        curl_radius: 0.05,
        curl_turns: 2.0,
        noise: 0.05,
        ..GrowSettings::default()
    }
}

#[test]
fn the_requested_number_of_strands_begins_on_the_surface() {
    for basis in [Basis::Linear, Basis::BSpline, Basis::CatmullRom] {
        let strands = grow(&square(), &GrowSettings { basis, ..settings() }, &Maps::default()).unwrap();
        assert_eq!(strands.validate(), Ok(()));
        assert_eq!((strands.len(), strands.segments()), (4000, 28_000));
        let root = usize::from(basis != Basis::Linear);
        assert!((0..strands.len()).all(|i| strands.strand(i)[root].y.abs() < 1e-6));
        for (i, uv) in strands.root_uv.as_ref().unwrap().iter().enumerate() {
            let p = strands.strand(i)[root];
            assert!((10.0 * *uv - Vec2::new(p.x, p.z)).length() < 1e-4);
        }
    }
}

#[test]
fn threads_do_not_change_the_fur() {
    let color = |_: &_, draw: &vellus_groom::Draw| [draw.random; 3];
    let maps = Maps { color: Some((Parameter::Reflectance, &color)), ..Maps::default() };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| grow(&square(), &settings(), &maps).unwrap())
    };
    let one = with(1);
    assert_eq!(one, with(3));
    assert!(matches!(&one.varying[0].1, Values::PerStrand(values) if values.len() == 4000));
    let other = grow(&square(), &GrowSettings { seed: 2, ..settings() }, &maps).unwrap();
    assert_ne!(one.points, other.points);
}

/// 100 squares have 40 roots each on average. Their number of roots varies less than by chance, where σ of the Poisson
/// distribution is √40 = 6.3.
#[test]
fn roots_are_spread_more_evenly_than_by_chance() {
    let strands = grow(&square(), &settings(), &Maps::default()).unwrap();
    let mut counts = [0i32; 100];
    for i in 0..strands.len() {
        let p = strands.strand(i)[1];
        counts[(p.x as usize).min(9) * 10 + (p.z as usize).min(9)] += 1;
    }
    let variance = counts.iter().map(|n| ((n - 40) * (n - 40)) as f32).sum::<f32>() / 100.0;
    assert!(variance < 0.5 * 40.0, "{variance}");
}

#[test]
fn density_length_and_comb_are_followed() {
    let maps = Maps {
        density: &|site| if site.position.x < 4.0 { 0.0 } else { 1.0 + 2.0 * f32::from(site.position.x > 7.0) },
        length: &|site| 0.5 + 0.1 * site.position.z,
        comb: &|_| Vec3::new(0.0, -3.0, 2.0),
        ..Maps::default()
    };
    let plain = GrowSettings { count: 4000, length: 1.0, length_variation: 0.0, spread: 0.0, noise: 0.0, ..settings() };
    let plain =
        GrowSettings { clump: Clump { strands: 0, ..plain.clump }, curl_radius: 0.0, guard_share: 0.0, ..plain };
    let strands = grow(&square(), &plain, &maps).unwrap();
    let mut dense = 0;
    for i in 0..strands.len() {
        let points = strands.strand(i);
        let (root, tip) = (points[1], points[points.len() - 2]);
        assert!(root.x >= 4.0 && tip.z > root.z && (tip.x - root.x).abs() < 1e-4);
        let length: f32 = points[1..points.len() - 1].windows(2).map(|p| (p[1] - p[0]).truncate().length()).sum();
        assert!((length - 0.5 - 0.1 * root.z).abs() < 1e-4);
        dense += usize::from(root.x > 7.0);
    }
    // The expected share is 9 of 9 + 3 parts. Triangles at the border and chance change this by at most 2 %.
    assert!((dense as f32 / 4000.0 - 0.75).abs() < 0.02, "{dense}");
}

#[test]
fn clumps_pull_tips_together() {
    let near = |strength: f32| {
        let clump = Clump { strands: 20, strength, power: 1.0 };
        let settings = GrowSettings { count: 1000, clump, spread: 0.3, ..settings() };
        let strands = grow(&square(), &settings, &Maps::default()).unwrap();
        let tip = |i: usize| strands.strand(i)[8].truncate();
        let others = |i: usize| (0..1000).filter(move |&j| j != i);
        let nearest = |i: usize| others(i).map(|j| tip(i).distance(tip(j))).fold(f32::INFINITY, f32::min);
        (0..1000).map(nearest).sum::<f32>() / 1000.0
    };
    let (loose, drawn) = (near(0.0), near(1.0));
    assert!(drawn < 0.7 * loose, "{drawn} {loose}");
}

/// Five strands on a square of 10 × 10 are far apart. A clump stretches none of them by more than half. Waves are off.
/// Maps may return any value, and the result is finite strands or an error.
/// With full strength all tips of a clump are in one place, but not those of strays: a fifth of the strands, within
/// 4 √(n p (1 − p)). Some clumps are several times as large as others.
#[test]
fn strays_are_in_no_clump_and_clumps_differ_in_size() {
    let clump = Clump { strands: 40, strength: 1.0, power: 1.0 };
    let settings = GrowSettings { count: 4000, clump, stray: 0.2, length: 9.0, noise: 0.0, ..GrowSettings::default() };
    let strands = grow(&square(), &settings, &Maps::default()).unwrap();
    let tip = |i: usize| strands.strand(i)[strands.strand(i).len() - 2].truncate();
    let centers: Vec<Vec3> = (0..100).map(|i| tip(40 * i)).collect();
    let mut sizes = vec![0; centers.len()];
    for i in 0..strands.len() {
        if let Some(center) = centers.iter().position(|center| center.distance(tip(i)) < 1e-3) {
            sizes[center] += 1;
        }
    }
    let strays = strands.len() - sizes.iter().sum::<usize>();
    assert!(strays.abs_diff(800) < 102, "{strays}");
    sizes.sort_unstable();
    assert!(sizes[90] > 2 * sizes[10], "{sizes:?}");
}

#[test]
fn sparse_clumps_keep_lengths_and_nothing_is_nan() {
    let sparse = GrowSettings {
        count: 60,
        clump: Clump { strands: 30, strength: 1.0, power: 1.0 },
        length_variation: 0.2,
        guard_share: 0.0,
        curl_radius: 0.0,
        noise: 0.0,
        ..settings()
    };
    let strands = grow(&square(), &sparse, &Maps::default()).unwrap();
    let [shortest, _, longest] = vellus_groom::measure(&strands).unwrap().lengths;
    assert!(shortest > 0.4 && longest < 1.2 * 1.5, "{shortest} {longest}");
    type Wild = fn(&vellus_groom::Site) -> f32;
    let wild: [Wild; 4] = [|_| f32::NAN, |_| f32::INFINITY, |_| -1.0, |site| (site.uv.x - 0.5).ln()];
    for value in wild {
        let comb = |site: &vellus_groom::Site| Vec3::splat(value(site));
        for maps in [
            Maps { density: &value, ..Maps::default() },
            Maps { length: &value, ..Maps::default() },
            Maps { comb: &comb, ..Maps::default() },
        ] {
            if let Ok(strands) = grow(&square(), &settings(), &maps) {
                assert_eq!(strands.validate(), Ok(()));
            }
        }
    }
}

/// There are only two triangles, but the density changes within them. It has stripes of 1 and 0, each a tenth of the
/// square wide.
#[test]
fn density_is_followed_within_large_triangles() {
    let mut quad = square();
    quad.positions = vec![Vec3::ZERO, Vec3::new(0.0, 0.0, 10.0), Vec3::new(10.0, 0.0, 10.0), Vec3::new(10.0, 0.0, 0.0)];
    quad.triangles = vec![[0, 1, 2], [0, 2, 3]];
    quad.uv = None;
    let stripes = |site: &vellus_groom::Site| f32::from(site.position.x.rem_euclid(2.0) < 1.0);
    // A border intersects 36 cells of area 0.15. The share of four probes in such a cell has a standard deviation of at
    // most 1/4 · √(4/4). This gives 0.23 for one border, and 0.7 for nine.
    let area = vellus_groom::area(&quad, &stripes).unwrap();
    assert!((area - 50.0).abs() < 3.0 * 0.7, "{area}");
    let strands =
        grow(&quad, &GrowSettings { count: 20_000, ..settings() }, &Maps { density: &stripes, ..Maps::default() });
    let strands = strands.unwrap();
    let mut counts = [0.0f64; 5];
    for i in 0..strands.len() {
        let x = strands.strand(i)[1].x;
        assert!(x.rem_euclid(2.0) < 1.0, "{x}");
        counts[(x / 2.0) as usize] += 1.0;
    }
    // Each stripe has 4000 strands, within three standard deviations. They come from its two borders, √2 · 0.23 of 10,
    // and from the Poisson distribution.
    assert!(
        counts.iter().all(|n| (n / 4000.0 - 1.0).abs() < 3.0 * (0.0325f64.powi(2) + 1.0 / 4000.0).sqrt()),
        "{counts:?}"
    );
}

#[test]
fn bad_settings_are_named() {
    let error = |settings: GrowSettings| grow(&square(), &settings, &Maps::default()).unwrap_err().to_string();
    let good = GrowSettings::default;
    assert!(error(GrowSettings { length: -1.0, ..good() }).contains("length = -1"));
    assert!(error(GrowSettings { noise: f32::NAN, ..good() }).contains("noise = NaN"));
    assert!(error(GrowSettings { segments: 0, ..good() }).contains("segments = 0"));
    assert!(error(GrowSettings { count: usize::MAX, ..good() }).contains("2^32"));
    assert!(error(GrowSettings { basis: Basis::Bezier, ..good() }).contains("B-spline"));
    let nowhere = Maps { density: &|_| f32::NAN, ..Maps::default() };
    assert!(matches!(grow(&square(), &good(), &nowhere), Err(Error::Nowhere(_))));
    let mut broken = square();
    broken.triangles[3][1] = 1_000_000;
    assert!(matches!(grow(&broken, &good(), &Maps::default()), Err(Error::Scene(_))));
}
