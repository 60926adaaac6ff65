//! The colour that fur shows is the reflectance that was asked for.

use glam::Vec3;
use std::fmt::Write as _;
use std::path::PathBuf;
use vellus::{Color, Fiber, Parameter, Species};
use vellus_groom::Group;
use vellus_open::{Growth, Skin};
use vellus_render::{Film, Layer, Settings, World};
use vellus_scene::{Camera, Look, ReflectanceOf, SKIN, Scene, Values};

const GINGER: [f32; 3] = [0.72, 0.34, 0.1];

/// A sphere as an .obj file.
fn ball(folder: &tempfile::TempDir) -> PathBuf {
    const ROWS: usize = 12;
    const COLUMNS: usize = 24;
    let mut text = String::new();
    for i in 0..=ROWS {
        for j in 0..COLUMNS {
            let (sin, cos) = (std::f32::consts::PI * i as f32 / ROWS as f32).sin_cos();
            let (y, x) = (std::f32::consts::TAU * j as f32 / COLUMNS as f32).sin_cos();
            writeln!(text, "v {} {} {}", sin * x, cos, -sin * y).unwrap();
        }
    }
    for (i, j) in (0..ROWS).flat_map(|i| (0..COLUMNS).map(move |j| (i, j))) {
        let vertex = |i: usize, j: usize| i * COLUMNS + j % COLUMNS + 1;
        let corners = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        writeln!(text, "f {} {} {} {}", corners[0], corners[1], corners[2], corners[3]).unwrap();
    }
    let path = folder.path().join("ball.obj");
    std::fs::write(&path, text).unwrap();
    path
}

/// The ball with fur of a fox.
fn furry(group: Group, color: [f32; 3], skin: Option<Skin>) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let fiber = Fiber::preset(Species::RedFox).with_color(Color::Reflectance(color)).unwrap();
    let groups = vec![(group, Look::constant("fox", fiber))];
    let growth = Growth { groups, meshes: Vec::new(), seed: 1, skin, strands_only: false };
    growth.grow(ball(&folder), |warning| panic!("{warning}")).unwrap().scene
}

/// Few and wide strands that hide the skin.
fn closed() -> Group {
    Group { count: Some(20_000), width: Some(0.03), segments: Some(6), ..Group::default() }
}

/// The mean colour of the ball in a white dome.
fn seen(world: &mut World) -> [f64; 3] {
    world.set_camera(Camera::look_at(Vec3::new(1.0, 2.0, 6.0), Vec3::ZERO, Vec3::Y, 0.45, 1.0)).unwrap();
    let settings = Settings::new([48, 48]);
    let mut film = Film::new(settings.size, settings.area(), world.layout(&[]));
    world.render(&settings, &mut film, 0..16, &()).unwrap();
    let mut sum = [0.0; 4];
    for (x, y) in (0..48).flat_map(|y| (0..48).map(move |x| (x, y))) {
        let alpha = film.mean(x, y, Layer::Alpha, 0);
        sum[3] += alpha;
        // The dome is white behind the ball.
        (0..3).for_each(|c| sum[c] += film.mean(x, y, Layer::Beauty, c) - (1.0 - alpha));
    }
    [0, 1, 2].map(|c| sum[c] / sum[3])
}

/// Coats are measured from all sides and rendered from one side: 6 % of a channel, and 0.005. The measurement adds 1 %
/// of noise, and its interpolation 1 %.
fn is_near(found: [f64; 3], wanted: [f32; 3]) -> bool {
    found.iter().zip(wanted.map(f64::from)).all(|(found, wanted)| (found - wanted).abs() < 0.06 * wanted + 0.005)
}

#[test]
fn coats_show_the_reflectance_that_is_asked_for() {
    let scene = furry(closed(), GINGER, None);
    let mut groom = World::new(scene.clone()).unwrap();
    assert_eq!(groom.unreached(), Vec::<String>::new());
    let found = seen(&mut groom);
    assert!(is_near(found, GINGER), "{found:?}");
    // The dense coat has more pigment than this one needs.
    let mut dense = World::new(Scene { reflectance: ReflectanceOf::Dense, ..scene.clone() }).unwrap();
    let found = seen(&mut dense);
    assert!(!is_near(found, GINGER), "{found:?}");
    assert!(dense.shown(0).is_none() && groom.shown(0).unwrap().cover > 0.97, "{:?}", groom.shown(0));
    // Colours of single strands mean the same.
    let mut varying = scene;
    varying.looks[0] = Look::constant("grey", Fiber::preset(Species::RedFox));
    let colors = vec![GINGER; varying.strands[0].len()];
    varying.strands[0].varying.push((Parameter::Reflectance, Values::PerStrand(colors)));
    let found = seen(&mut World::new(varying).unwrap());
    assert!(is_near(found, GINGER), "{found:?}");
}

/// A viewer that asks for another colour gets it without another measurement.
#[test]
fn another_colour_is_shown_in_the_same_world() {
    let mut world = World::new(furry(closed(), [0.5; 3], None)).unwrap();
    let measured = world.shown(0).unwrap().clone();
    let mut looks = world.looks().to_vec();
    looks[0].fiber = looks[0].fiber.with_color(Color::Reflectance([0.3, 0.1, 0.03])).unwrap();
    world.set_looks(looks, Vec::new()).unwrap();
    assert_eq!(world.shown(0), Some(&measured));
    let found = seen(&mut world);
    // The skin was that of a brighter coat when it was measured.
    assert!(is_near(found, [0.3, 0.1, 0.03]), "{found:?}");
}

/// A thin coat on black skin cannot be white. The message has the colour that it shows, and how much skin is seen.
#[test]
fn what_a_thin_coat_cannot_show_is_said_with_the_right_number() {
    let thin = Group { count: Some(2000), ..closed() };
    let mut world = World::new(furry(thin, [0.9; 3], Some(Skin::Color([0.02; 3])))).unwrap();
    let shown = world.shown(0).unwrap().clone();
    let nearest = shown.nearest([0.9; 3]);
    assert!((0.3..0.9).contains(&shown.cover) && nearest[0] < 0.6, "{shown:?}");
    let found = seen(&mut world);
    assert!(is_near(found, nearest), "{found:?} {nearest:?}");
    let said = world.unreached();
    let wanted = format!("the nearest is {:.3}", nearest[0]);
    assert!(said.len() == 1 && said[0].contains(&wanted) && said[0].contains("of its skin"), "{said:?}");
}

/// A request that is too bright is darkened as a whole: orange does not become yellow.
#[test]
fn a_colour_out_of_reach_keeps_its_hue() {
    let world = World::new(furry(closed(), [0.999, 0.3763, 0.001], Some(Skin::Color([0.1; 3])))).unwrap();
    let shown = world.shown(0).unwrap();
    let [r, g, _] = shown.nearest([0.999, 0.3763, 0.001]);
    assert!(r < 0.95 && (g / r - 0.3763 / 0.999).abs() < 1e-3, "{r} {g}");
    assert_eq!(shown.nearest([0.2, 0.2, 0.2]), [0.2; 3]);
}

#[test]
fn skin_has_the_colour_of_its_coat() {
    let scene = furry(closed(), GINGER, None);
    let skin = scene.surfaces[scene.meshes[0].surface].clone();
    assert!(skin.skin && skin.color.color == GINGER.map(|c| SKIN * c), "{skin:?}");
    let own = furry(closed(), GINGER, Some(Skin::Color([0.1, 0.2, 0.3])));
    let skin = own.surfaces[own.meshes[0].surface].clone();
    assert!(!skin.skin && skin.color.color == [0.1, 0.2, 0.3], "{skin:?}");
    assert!("auto".parse() == Ok(Skin::Auto) && "1,2,3".parse::<Skin>().is_err());
}

/// `vellus groom grow` with its defaults hides the skin, and more strands hide more of it.
#[test]
fn grown_fur_closes() {
    let cover = |count| {
        let group = Group { segments: Some(6), count, ..Group::default() };
        World::new(furry(group, GINGER, None)).unwrap().shown(0).unwrap().cover
    };
    let [usual, fewer] = [None, Some(25_000)].map(cover);
    assert!(usual >= 0.97 && fewer < usual, "{usual} {fewer}");
}
