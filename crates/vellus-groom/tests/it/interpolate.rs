//! Strands between guides.

use glam::{Mat4, Vec2, Vec3, Vec4};
use vellus::Parameter;
use vellus_groom::{Error, Interpolation, interpolate};
use vellus_scene::{Basis, Strands, Values};

const EVEN: Interpolation = Interpolation { clump: 0.0, length_variation: 0.0, seed: 3 };

/// Guides of four points at these roots. `tip` returns the way from the root to the tip.
fn guides(roots: &[Vec3], tip: impl Fn(Vec3) -> Vec3) -> Strands {
    let points = roots.iter().flat_map(|&root| (0..4).map(move |k| (root, k as f32 / 3.0)));
    Strands {
        name: "guides".to_owned(),
        basis: Basis::Linear,
        starts: (0..=roots.len() as u32).map(|i| 4 * i).collect(),
        points: points.map(|(root, t)| (root + t * tip(root)).extend(0.01 - 0.005 * t)).collect(),
        moved: None,
        normals: None,
        root_uv: Some(roots.iter().map(|root| Vec2::new(root.x, root.z)).collect()),
        look: 0,
        varying: vec![(Parameter::Reflectance, Values::PerStrand(roots.iter().map(|r| [r.x, r.y, r.z]).collect()))],
    }
}

/// Points on a unit sphere, evenly spread.
fn sphere(count: usize) -> Vec<Vec3> {
    let at = |i: usize| {
        let y = 1.0 - (2 * i + 1) as f32 / count as f32;
        let angle = 2.399_963_2 * i as f32;
        Vec3::new((1.0 - y * y).sqrt() * angle.cos(), y, (1.0 - y * y).sqrt() * angle.sin())
    };
    (0..count).map(at).collect()
}

/// A lattice of n × n points on y = 0, from 0 to 1.
fn square(n: usize) -> Vec<Vec3> {
    (0..n * n).map(|k| Vec3::new((k % n) as f32, 0.0, (k / n) as f32) / (n - 1) as f32).collect()
}

fn first(strands: &Strands, i: usize) -> Vec3 {
    strands.strand(i)[0].truncate()
}

#[test]
fn new_roots_lie_on_the_surface_of_the_old_ones_and_cover_it_evenly() {
    let fur = guides(&sphere(400), |root| 0.3 * root);
    let dense = interpolate(&fur, None, 20.0, EVEN).unwrap();
    dense.validate().unwrap();
    assert_eq!(dense.points[..fur.points.len()], fur.points);
    // Each cell loses a part of a strand at most.
    assert!((dense.len() as i64 - 8000).abs() <= 1, "{}", dense.len());
    // The middle of a triangle of guides is 5.4e-3 below the sphere: their distance is 0.18, and 0.18²/6. The mean of
    // tangent planes leaves an eighth of it on average, and more where neighbours are uneven.
    let below: Vec<f32> = (fur.len()..dense.len()).map(|i| (first(&dense, i).length() - 1.0).abs()).collect();
    let (mean, worst) = (below.iter().sum::<f32>() / below.len() as f32, below.iter().copied().fold(0.0, f32::max));
    assert!(mean < 7e-4 && worst < 5.4e-3, "{mean} {worst}");
    // In each eighth of the sphere are 1000 strands, within what the 70 cells at its border divide.
    for octant in 0..8 {
        let is_in = |p: Vec3| (0..3).all(|c| (p[c] > 0.0) == (octant >> c & 1 == 1));
        let count = (0..dense.len()).filter(|&i| is_in(first(&dense, i))).count();
        assert!((900..=1100).contains(&count), "{count}");
    }
}

#[test]
fn strands_between_guides_are_their_affine_mean() {
    // All values of the guides are linear in the root.
    let tip = |root: Vec3| Vec3::new(0.2 * root.x, 1.0 + 0.1 * root.z, -0.1 * root.x);
    let fur = guides(&square(9), tip);
    let dense = interpolate(&fur, None, 8.0, EVEN).unwrap();
    let Values::PerStrand(colors) = &dense.varying[0].1 else { panic!("colours are per strand") };
    let inside = |p: Vec3| p.x.min(p.z) > 0.07 && p.x.max(p.z) < 0.93;
    let new = (fur.len()..dense.len()).filter(|&i| inside(first(&dense, i)));
    let mut count = 0;
    for i in new {
        let (strand, root) = (dense.strand(i), first(&dense, i));
        assert!(root.y.abs() < 1e-5);
        // The lengths of tips differ by 1 % of each other, which is what keeps them from becoming shorter.
        assert!((strand[3].truncate() - root).distance(tip(root)) < 2e-3);
        assert!((strand[3].w - 0.005).abs() < 1e-6 && (strand[0].w - 0.01).abs() < 1e-6);
        assert!(Vec3::from_array(colors[i]).distance(root) < 1e-4);
        assert!(dense.root_uv.as_ref().unwrap()[i].distance(Vec2::new(root.x, root.z)) < 1e-4);
        count += 1;
    }
    assert!(count > 250, "{count}");
}

#[test]
fn a_parting_stays_a_parting() {
    let side = |root: Vec3| if root.x < 0.5 { -1.0 } else { 1.0 };
    let fur = guides(&square(10), |root| Vec3::new(side(root), 0.3, 0.0));
    let dense = interpolate(&fur, None, 10.0, EVEN).unwrap();
    for i in fur.len()..dense.len() {
        let (root, way) = (first(&dense, i), dense.strand(i)[3].truncate() - first(&dense, i));
        let [left, right] = [-1.0, 1.0].map(|x| way.distance(Vec3::new(x, 0.3, 0.0)) < 1e-3);
        // Cells of both sides meet between the guides, 0.11 apart.
        assert!(left && root.x < 0.56 || right && root.x > 0.44, "{root} {way}");
    }
}

#[test]
fn strands_keep_their_places_in_an_animation() {
    let rest = guides(&sphere(200), |root| 0.3 * root + 0.1 * Vec3::Y);
    let pose = Mat4::from_rotation_translation(glam::Quat::from_rotation_x(0.7), Vec3::new(3.0, -1.0, 2.0));
    let moved = |p: &Vec4| pose.transform_point3(p.truncate());
    let mut posed = rest.clone();
    posed.points.iter_mut().for_each(|p| *p = moved(p).extend(p.w));
    let now = interpolate(&posed, Some(&rest), 5.0, EVEN).unwrap();
    let before = Strands { moved: Some(posed.points.iter().map(|p| p.truncate()).collect()), ..rest };
    let before = interpolate(&before, None, 5.0, EVEN).unwrap();
    for ((p, now), later) in before.points.iter().zip(&now.points).zip(before.moved.as_ref().unwrap()) {
        assert!(moved(p).distance(now.truncate()) < 1e-4 && later.distance(now.truncate()) < 1e-4);
    }
}

#[test]
fn curls_of_guides_stay_curls() {
    // Helices in opposite phase: their mean is straight.
    let roots = square(8);
    let mut fur = guides(&roots, |_| Vec3::Y);
    let count = 24;
    fur.starts = (0..=roots.len() as u32).map(|i| count * i).collect();
    let turn = |(i, root): (usize, &Vec3)| {
        let root = *root;
        (0..count).map(move |k| {
            let t = k as f32 / (count - 1) as f32;
            let angle = 25.0 * t + std::f32::consts::PI * i as f32;
            (root + Vec3::new(0.1 * angle.cos(), t, 0.1 * angle.sin())).extend(0.01)
        })
    };
    fur.points = roots.iter().enumerate().flat_map(turn).collect();
    let length = |s: &[Vec4]| s.windows(2).map(|p| p[0].truncate().distance(p[1].truncate())).sum::<f32>();
    let dense = interpolate(&fur, None, 6.0, EVEN).unwrap();
    let guide = length(fur.strand(9));
    (0..dense.len()).for_each(|i| assert!((length(dense.strand(i)) / guide - 1.0).abs() < 0.1));
}

#[test]
fn clumps_gather_at_the_tips_of_guides() {
    let fur = guides(&square(8), |_| Vec3::Y);
    let away = |clump: f32| {
        let dense = interpolate(&fur, None, 10.0, Interpolation { clump, ..EVEN }).unwrap();
        let tips: Vec<Vec3> = (0..fur.len()).map(|i| fur.strand(i)[3].truncate()).collect();
        let nearest = |tip: Vec3| tips.iter().map(|guide| guide.distance(tip)).fold(f32::INFINITY, f32::min);
        let sum: f32 = (fur.len()..dense.len()).map(|i| nearest(dense.strand(i)[3].truncate())).sum();
        sum / (dense.len() - fur.len()) as f32
    };
    assert!(away(1.0) < 1e-5 && away(0.5) < 0.7 * away(0.0));
}

#[test]
fn what_is_out_of_range_is_an_error_and_few_guides_stay_alone() {
    let fur = guides(&square(3), |_| Vec3::Y);
    let wrong = |factor, settings| matches!(interpolate(&fur, None, factor, settings), Err(Error::Setting { .. }));
    assert!(wrong(0.5, EVEN) && wrong(f32::NAN, EVEN) && wrong(1e9, EVEN));
    assert!(wrong(2.0, Interpolation { clump: 1.5, ..EVEN }));
    assert!(wrong(2.0, Interpolation { length_variation: 1.0, ..EVEN }));
    let two = guides(&square(3)[..2], |_| Vec3::Y);
    assert_eq!(interpolate(&two, None, 10.0, EVEN).unwrap(), two);
    let none = guides(&[], |_| Vec3::Y);
    assert_eq!(interpolate(&none, None, 10.0, EVEN).unwrap(), none);
}
