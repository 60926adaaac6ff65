//! Cryptomatte: any division of the samples gives the same file, and Blender's compositor reads it.

use exr::prelude::{AnyChannels, AttributeValue, FlatSamples, ReadChannels, ReadLayers, Text, read};
use glam::{Vec3, Vec4};
use std::collections::HashMap;
use std::io::Cursor;
use std::process::Command;
use vellus::{Fiber, Species};
use vellus_render::{Checkpoint, Film, Layer, PIXELS_NOTE, PixelType, Settings, World, check_picture};
use vellus_scene::{Basis, Camera, Look, Mesh, Scene, Strands, Surface};

const SIZE: [usize; 2] = [40, 30];

/// Two sets of strands with one look, and two meshes. Most pixels show several of them.
fn scene() -> Scene {
    let strands = |name: &str, look: usize, phase: f32| {
        let strand = |i: usize| {
            let x = i as f32 * 0.04 - 0.6;
            let lean = (i as f32 * 1.7 + phase).sin() * 0.4;
            [Vec4::new(x, -0.5, 0.02 * phase, 0.012), Vec4::new(x + lean, 0.5, 0.02 * phase, 0.004)]
        };
        Strands {
            name: name.to_owned(),
            basis: Basis::Linear,
            starts: (0..=30).map(|i| 2 * i).collect(),
            points: (0..30).flat_map(strand).collect(),
            moved: None,
            normals: None,
            root_uv: None,
            look,
            varying: Vec::new(),
        }
    };
    let mesh = |name: &str, x: f32, surface: usize| Mesh {
        name: name.to_owned(),
        positions: [[-0.3, -0.4, -0.3], [0.3, -0.4, -0.3], [0.0, 0.4, -0.3]]
            .map(|p| Vec3::from(p) + Vec3::X * x)
            .to_vec(),
        triangles: vec![[0, 1, 2]],
        normals: None,
        uv: None,
        surface,
        moved: None,
    };
    Scene {
        strands: vec![
            strands("/fox/coat", 0, 0.0),
            strands("/fox/guard \"hairs\"", 0, 1.0),
            strands("whiskers", 1, 2.0),
        ],
        meshes: vec![mesh("/fox/skin", -0.2, 0), mesh("ground", 0.3, 1)],
        looks: ["red", "white"].map(|name| Look::constant(name, Fiber::preset(Species::RedFox))).to_vec(),
        surfaces: vec![Surface::diffuse("leather", [0.4; 3]), Surface::diffuse("狐", [0.2; 3])],
        camera: Some(Camera::look_at(Vec3::Z * 3.0, Vec3::ZERO, Vec3::Y, 0.5, 4.0 / 3.0)),
        ..Scene::default()
    }
}

fn film(world: &World, samples: std::ops::Range<u64>) -> Film {
    let settings = Settings { max_depth: Some(1), ..Settings::new(SIZE) };
    let mut film = Film::new(SIZE, settings.area(), world.layout(&Layer::CRYPTOMATTE));
    world.render(&settings, &mut film, samples, &()).unwrap();
    film
}

fn exr(film: &Film) -> Vec<u8> {
    film.to_exr(&Layer::ALL, None, PixelType::Half, &[]).unwrap()
}

/// The channels of a file, and the text attributes of its header.
fn content(bytes: &[u8]) -> (HashMap<String, Vec<f32>>, HashMap<String, String>) {
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let layer = image.from_buffered(Cursor::new(bytes)).unwrap().layer_data;
    let AnyChannels { list } = layer.channel_data;
    let channels = list.into_iter().filter_map(|channel| match channel.sample_data {
        FlatSamples::F32(values) => Some((channel.name.to_string(), values)),
        _ => None,
    });
    let text = |(name, value): (Text, AttributeValue)| match value {
        AttributeValue::Text(value) => Some((name.to_string(), String::from_utf8(value.as_slice().to_vec()).unwrap())),
        _ => None,
    };
    (channels.collect(), layer.attributes.other.into_iter().filter_map(text).collect())
}

/// The coverage of all ranks with this id.
fn matte(channels: &HashMap<String, Vec<f32>>, layer: &str, id: u32) -> Vec<f32> {
    let mut sum = vec![0.0; SIZE[0] * SIZE[1]];
    for (rank, pair) in (0..6usize).map(|rank| (rank / 2, if rank.is_multiple_of(2) { ["R", "G"] } else { ["B", "A"] }))
    {
        let [ids, cover] = pair.map(|c| &channels[&format!("{layer}{rank:02}.{c}")]);
        for i in (0..sum.len()).filter(|&i| ids[i].to_bits() == id) {
            sum[i] += cover[i];
        }
    }
    sum
}

/// The id of a name in the manifest of a layer.
fn id(texts: &HashMap<String, String>, layer: &str, name: &str) -> u32 {
    let key = texts.iter().find(|(key, value)| key.ends_with("/name") && *value == layer).unwrap().0;
    let manifest = &texts[&key.replace("/name", "/manifest")];
    let start = manifest.find(&format!("\"{name}\":\"")).unwrap() + name.len() + 4;
    u32::from_str_radix(&manifest[start..start + 8], 16).unwrap()
}

/// Random divisions of the samples, rendered and merged in any order, give the film and the pixels of one run.
#[test]
fn any_division_of_the_samples_gives_the_same_file() {
    const SAMPLES: u64 = 24;
    let world = World::new(scene()).unwrap();
    let whole = film(&world, 0..SAMPLES);
    let digest = |bytes: &[u8]| check_picture(bytes).unwrap().into_iter().find(|note| note.0 == PIXELS_NOTE);
    let expected = digest(&exr(&whole));
    let mut state = 7u32;
    let mut random = move |n: u64| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        u64::from(state >> 8) % n
    };
    for _ in 0..6 {
        let mut cuts = vec![0, SAMPLES];
        cuts.extend((0..4).map(|_| random(SAMPLES)));
        cuts.sort_unstable();
        let mut parts: Vec<Film> = cuts.windows(2).map(|ends| film(&world, ends[0]..ends[1])).collect();
        let mut merged = parts.swap_remove(random(parts.len() as u64) as usize);
        while !parts.is_empty() {
            merged.merge(&parts.swap_remove(random(parts.len() as u64) as usize));
        }
        assert!(merged == whole, "{cuts:?}");
        assert_eq!(digest(&exr(&merged)), expected);
    }
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert!(one.install(|| film(&world, 0..SAMPLES)) == whole);
    let identity = vellus_io::Digest([1; 32]);
    let kept = Checkpoint { identity, samples: 0..SAMPLES, planned: SAMPLES, notes: vec![], film: whole };
    assert!(Checkpoint::from_bytes(&kept.to_bytes()).unwrap() == kept);
}

/// The mattes of all objects, and those of all looks, cover as much as the layer alpha. Those of sets of strands cover
/// as much as the layer of fibres.
#[test]
fn mattes_cover_the_alpha() {
    let film = film(&World::new(scene()).unwrap(), 0..32);
    let (channels, texts) = content(&exr(&film));
    let all = |layer: &str, names: &[&str]| -> Vec<f32> {
        let mattes = names.iter().map(|name| matte(&channels, layer, id(&texts, layer, name)));
        mattes.reduce(|a, b| a.iter().zip(b).map(|(a, b)| a + b).collect()).unwrap()
    };
    let cover = |layer| -> Vec<f32> {
        (0..SIZE[0] * SIZE[1]).map(|i| film.mean(i % SIZE[0], i / SIZE[0], layer, 0) as f32).collect()
    };
    // Shares of 32 samples are exact.
    assert_eq!(all("CryptoObject", &["/fox", "whiskers", "ground"]), cover(Layer::Alpha));
    assert_eq!(all("CryptoMaterial", &["red", "white", "leather", "狐"]), cover(Layer::Alpha));
    let groups = ["/fox/coat", "/fox/guard \\\"hairs\\\"", "whiskers"];
    assert_eq!(all("CryptoGroup", &groups), cover(Layer::Fibers));
}

/// Blender's Cryptomatte node finds each name, and its matte is the coverage in the file.
#[test]
fn blender_reads_the_mattes() {
    let Some(python) = vellus_testing::blender() else { return };
    let bytes = exr(&film(&World::new(scene()).unwrap(), 0..16));
    let (channels, texts) = content(&bytes);
    let folder = tempfile::tempdir().unwrap();
    let [picture, output] = ["picture.exr", "matte"].map(|name| folder.path().join(name));
    std::fs::write(&picture, &bytes).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/cryptomatte.py");
    for (layer, name) in [("CryptoObject", "/fox"), ("CryptoMaterial", "leather"), ("CryptoGroup", "whiskers")] {
        let mut run = Command::new(&python);
        run.arg(script).arg(&picture).args(SIZE.map(|n| n.to_string())).args([layer, name]).arg(&output);
        let run = vellus_testing::program::Limited::run(&mut run).unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let found = std::fs::read(&output).unwrap();
        let found: Vec<f32> = found.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        let expected = matte(&channels, layer, id(&texts, layer, name));
        assert!(expected.iter().any(|&x| x > 0.0 && x < 1.0));
        // Blender adds the ranks in single precision, and shares of 16 samples are exact.
        assert_eq!(found, expected, "{layer} {name}");
    }
}
