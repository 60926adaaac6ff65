//! Writes small files of every kind to `corpus/TARGET/`, from which the fuzzer starts.

use glam::{Mat3, Mat4, Vec2, Vec3, Vec4};
use std::error::Error;
use std::io::Cursor;
use std::path::Path;
use vellus_io::Digest;
use vellus_render::{Checkpoint, Film, Layer, Layout};
use vellus_scene::*;

fn main() -> Result<(), Box<dyn Error>> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let save = |target: &str, name: &str, bytes: &[u8]| -> std::io::Result<()> {
        std::fs::create_dir_all(corpus.join(target))?;
        std::fs::write(corpus.join(target).join(name), bytes)
    };
    let scene = scene();
    let linear = scene.strands.iter().find(|s| s.basis == Basis::Linear).ok_or("there is one")?;
    save("hair", "strands.hair", &vellus_groom::write_hair(linear)?)?;
    save("research", "a.data", &[&[1u8, 0, 0, 0, 2, 0, 0, 0][..], &[0; 24]].concat())?;
    save("research", "a.ply", PLY.as_bytes())?;
    // The first byte says how a light uses the profile.
    let ies = "AIESNA:LM-63-2002\nTILT=NONE\n1 1 2 3 2 1 1 1 1 1\n1 1 1\n0 45 90\n0 90\n3 2 1\n3 1 0\n";
    save("ies", "a.ies", ies.as_bytes())?;
    save("tfx", "3.tfx", &tfx(3.0))?;
    save("tfx", "4.tfx", &tfx(4.0))?;
    for (name, layers) in [("few", &[Layer::Depth][..]), ("all", &Layer::ALL)] {
        let film = Film::new([9, 8], [2, 3, 3, 2], Layout::new(layers, &["key".to_owned(), "rim".to_owned()]));
        let notes = vec![("vellus_command".to_owned(), "vellus render".to_owned())];
        // Films without samples. The fuzzer fills them.
        let part = Checkpoint { identity: Digest::default(), samples: 0..0, planned: 0, notes, film };
        let bytes = part.to_bytes();
        // Without the checksum, which the target adds.
        save("film", &format!("{name}.film"), &bytes[..bytes.len() - 32])?;
    }

    for (color, name) in [(png::ColorType::Rgb, "rgb"), (png::ColorType::GrayscaleAlpha, "grey")] {
        for depth in [png::BitDepth::Eight, png::BitDepth::Sixteen] {
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, 4, 2);
            encoder.set_color(color);
            encoder.set_depth(depth);
            let data = vec![77; 8 * color.samples() * if depth == png::BitDepth::Eight { 1 } else { 2 }];
            encoder.write_header()?.write_image_data(&data)?;
            save("image", &format!("{name}{depth:?}.png"), &bytes)?;
        }
    }
    let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=0.5\n\n-Y 1 +X 8\n".as_slice();
    let rows = [&[2, 2, 0, 8, 136, 128, 136, 64, 3, 0, 0, 0, 133, 0, 136, 129][..], &[128, 64, 0, 129, 1, 1, 1, 7]];
    for (i, row) in rows.iter().enumerate() {
        save("image", &format!("{i}.hdr"), &[header, row].concat())?;
    }
    for name in ["grey", "baseline", "progressive"] {
        let file = format!("{}/../crates/vellus-usd/tests/data/images/{name}.jpg", env!("CARGO_MANIFEST_DIR"));
        save("image", &format!("{name}.jpg"), &std::fs::read(file)?)?;
    }
    for (name, channels) in [("Y", &["Y"][..]), ("layer", &["coat.R", "coat.G", "coat.B"])] {
        use exr::prelude::*;
        let plane = |channel: &&str| AnyChannel::new(*channel, FlatSamples::F16(vec![f16::from_f32(0.5); 8]));
        let channels = AnyChannels::sort(channels.iter().map(plane).collect());
        let mut bytes = Cursor::new(Vec::new());
        let layer = exr::prelude::Layer::new((4, 2), LayerAttributes::named("a"), Encoding::SMALL_LOSSLESS, channels);
        Image::from_layer(layer).write().to_buffered(&mut bytes)?;
        save("image", &format!("{name}.exr"), &bytes.into_inner())?;
    }
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels: Vec<u16> = (0..48).collect();
    tiff::encoder::TiffEncoder::new(&mut bytes)?.write_image::<tiff::encoder::colortype::RGB16>(4, 4, &pixels)?;
    save("image", "rgb.tif", &bytes.into_inner())?;

    let folder = tempfile::tempdir()?;
    let at = |name: &str| folder.path().join(name);
    let name = |path: std::path::PathBuf| path.to_string_lossy().into_owned();
    vellus_usd::write(&scene, &at("scene.usda"))?;
    let text = std::fs::read(at("scene.usda"))?;
    let image = std::fs::read(at("scene-textures/coat.exr"))?;
    save("image", "coat.exr", &image)?;
    // Textures are not copied: a text or binary layer alone refers to missing files.
    let alone = Scene { textures: Vec::new(), ..scene };
    let alone = Scene {
        looks: alone.looks.into_iter().map(|look| Look { textured: Vec::new(), ..look }).collect(),
        surfaces: vec![Surface::diffuse("skin", [0.5; 3])],
        lights: alone.lights.into_iter().skip(1).collect(),
        ..alone
    };
    vellus_usd::write(&alone, &at("alone.usda"))?;
    save("usda", "scene.usda", &text)?;
    save("usda", "alone.usda", &std::fs::read(at("alone.usda"))?)?;
    let home = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (own, tests) = (home.join("seeds"), home.join("../crates/vellus-usd/tests/data"));
    for text in [own.join("body.usda"), tests.join("chiang.usda"), tests.join("programs.usda")] {
        let file = text.file_name().ok_or("it has a name")?.to_string_lossy().into_owned();
        std::fs::copy(&text, at(&file))?;
        save("usda", &file, &std::fs::read(&text)?)?;
    }
    save("abc", "blender.abc", &std::fs::read(tests.join("blender/fur_catmull_rom.abc"))?)?;
    for document in [own.join("own_nodes.mtlx"), tests.join("hair.mtlx")] {
        let file = document.file_name().ok_or("it has a name")?.to_string_lossy().into_owned();
        save("mtlx", &file, &std::fs::read(&document)?)?;
    }
    for usd in ["scene", "alone", "body"] {
        let binary = at(&format!("{usd}.usdc"));
        let stage = openusd::usd::Stage::builder().open(&name(at(&format!("{usd}.usda"))))?;
        stage.root_layer().export(name(binary.clone()))?;
        save("usdc", &format!("{usd}.usdc"), &std::fs::read(&binary)?)?;
    }
    for binary in std::fs::read_dir(tests.join("usdc"))?.chain(std::fs::read_dir(tests.join("blender"))?) {
        let binary = binary?.path();
        if binary.extension().is_some_and(|kind| kind == "usdc") {
            save("usdc", &binary.file_name().ok_or("it has a name")?.to_string_lossy(), &std::fs::read(&binary)?)?;
        }
    }
    // Our own writer, and the tables of the oldest versions.
    vellus_usd::write(&alone, &at("written.usdc"))?;
    save("usdc", "written.usdc", &std::fs::read(at("written.usdc"))?)?;
    for version in [0, 1] {
        save("usdc", &format!("old{version}.usdc"), &old_layer(version))?;
    }
    for (layer, bytes) in [("scene.usda", &text), ("scene.usdc", &std::fs::read(at("scene.usdc"))?)] {
        let mut package = openusd::usdz::ArchiveWriter::new(Cursor::new(Vec::new()));
        package.add_layer(layer, bytes)?;
        package.add_layer("scene-textures/coat.exr", &image)?;
        save("usdz", &format!("{layer}.usdz"), &package.finish()?.into_inner())?;
    }
    Ok(())
}

/// A binary layer of version 0.0 or 0.1, with the prims /a, /a/b and /c, and the property /a.x. There is no writer for
/// these.
fn old_layer(minor: u8) -> Vec<u8> {
    let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    // The first version has 4 bytes without meaning before each path and spec.
    let row = |row: &[u32]| words(&[if minor == 0 { &[0][..] } else { &[] }, row].concat());
    let tokens = [words(&[5, 0, 20, 0]), b"x\0a\0b\0c\0specifier\0".to_vec()].concat();
    let fields = words(&[1, 0, 0, 4, 0, 0x400b << 16]);
    let specs = [words(&[3, 0]), row(&[0, 0, 7]), row(&[1, 0, 6]), row(&[3, 0, 1])].concat();
    let before = 24 + tokens.len() + fields.len() + 16 + specs.len() + 8;
    let sibling = ((before + 4 * row(&[0; 3]).len() + 8) as u64).to_le_bytes().to_vec();
    let tree = [row(&[0, 0, 1]), row(&[1, 1, 3]), sibling, row(&[2, 2, 2]), row(&[3, 0, 4]), row(&[4, 3, 0])];
    let paths = [words(&[5, 0]), tree.concat()].concat();
    let mut bytes = [b"PXR-USDC\0".as_slice(), &[minor], &[0; 14]].concat();
    let mut table = 5u64.to_le_bytes().to_vec();
    let sets = words(&[2, 0, 0, u32::MAX]);
    let parts = [("TOKENS", tokens), ("FIELDS", fields), ("FIELDSETS", sets), ("SPECS", specs), ("PATHS", paths)];
    for (name, section) in parts {
        table.extend([name.as_bytes(), &vec![0; 16 - name.len()]].concat());
        table.extend([bytes.len() as u64, section.len() as u64].iter().flat_map(|place| place.to_le_bytes()));
        bytes.extend(section);
    }
    let place = (bytes.len() as u64).to_le_bytes();
    bytes[16..24].copy_from_slice(&place);
    [bytes, table].concat()
}

/// A strand of two points.
const PLY: &str = "ply
format ascii 1.0
element vertex 2
property float x
property float y
property float z
element edge 1
property int vertex1
property int vertex2
end_header
0 0 0
1 1 1
0 1
";

/// A .tfx file of 3 strands with 4 points and uv. There is no writer for this format.
fn tfx(version: f32) -> Vec<u8> {
    let (header, at, width) = if version < 4.0 { (296usize, 144, 3) } else { (160, 12, 4) };
    let mut bytes = vec![0; header];
    let mut put = |at: usize, word: u32| bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
    put(0, version.to_bits());
    put(4, 3);
    put(8, 4);
    put(at, header as u32);
    put(at + 4, (header + 12 * width * 4) as u32);
    let points = (0..12 * width).map(|i| i as f32 * 0.5);
    points.chain((0..6).map(|i| i as f32 / 8.0)).for_each(|x| bytes.extend(x.to_le_bytes()));
    bytes
}

/// A scene with an object of every kind.
fn scene() -> Scene {
    let strands = |basis, counts: &[u32]| {
        let mut starts = vec![0];
        counts.iter().for_each(|n| starts.push(starts[starts.len() - 1] + n));
        let total = starts[starts.len() - 1] as usize;
        let points: Vec<Vec4> = (0..total).map(|i| Vec4::new(i as f32, 0.5 * i as f32, 1.0, 0.01)).collect();
        Strands {
            name: format!("{basis:?}"),
            basis,
            normals: None,
            root_uv: Some(counts.iter().map(|_| Vec2::new(0.25, 0.75)).collect()),
            moved: (basis == Basis::BSpline).then(|| points.iter().map(|p| p.truncate() + Vec3::X).collect()),
            varying: vec![
                (Parameter::BetaM, Values::PerStrand(counts.iter().map(|_| [0.1; 3]).collect())),
                (Parameter::Melanin, Values::PerPoint(points.iter().map(|_| [0.5, 0.2, 0.0]).collect())),
            ],
            starts,
            points,
            look: 0,
        }
    };
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE];
    let square = Vec2::splat(1.0);
    let pose = Mat4::from_rotation_y(0.3) * Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0));
    Scene {
        strands: vec![
            strands(Basis::Linear, &[2, 3]),
            strands(Basis::BSpline, &[4, 6]),
            strands(Basis::CatmullRom, &[5]),
            strands(Basis::Bezier, &[4, 7]),
        ],
        meshes: vec![Mesh {
            name: "skin".to_owned(),
            moved: Some(positions.iter().map(|p| *p + Vec3::X).collect()),
            positions,
            triangles: vec![[0, 1, 2], [1, 3, 2]],
            normals: Some(vec![[Vec3::Z; 3]; 2]),
            uv: Some(vec![[Vec2::ZERO, Vec2::X, square]; 2]),
            surface: 0,
        }],
        looks: vec![Look {
            textured: vec![(Parameter::Reflectance, Value { texture: 0, scale: [0.9; 3] })],
            ..Look::constant("fur", vellus_usd::Options::default().fallback)
        }],
        surfaces: vec![Surface {
            color: Tint { color: [0.5; 3], texture: Some(0) },
            ..Surface::diffuse("skin", [0.5; 3])
        }],
        textures: vec![Texture {
            name: "coat".to_owned(),
            width: 2,
            height: 2,
            pixels: vec![[0.1, 0.2, 0.3]; 4].into(),
            wrap: Default::default(),
        }],
        lights: [
            LightShape::Dome {
                radiance: [1.0; 3],
                texture: Some(0),
                rotation: Mat3::IDENTITY,
                ground: Some(Ground { origin: Vec3::ZERO, height: 1.5, radius: 20.0 }),
            },
            LightShape::Distant { direction: Vec3::Y, half_angle: 0.01, irradiance: [2.0; 3] },
            LightShape::Rect { to_world: pose, radiance: [3.0; 3], texture: None },
            LightShape::Disk { to_world: pose, radiance: [4.0; 3] },
            LightShape::Sphere { center: Vec3::Y, radius: 0.5, radiance: [5.0; 3] },
            LightShape::Cylinder { center: Vec3::Y, half_axis: Vec3::X, radius: 0.5, radiance: [6.0; 3] },
        ]
        .into_iter()
        .zip(["sky", "sun", "key", "key", "lamp", "tube"])
        .map(|(shape, group)| Light { group: Some(group.to_owned()), visible: group != "key", ..shape.into() })
        .collect(),
        camera: Some(Camera::look_at(Vec3::splat(9.0), Vec3::ZERO, Vec3::Y, 0.5, 1.5)),
        units: Some(Units { meters_per_unit: 1.0, z_up: true }),
        ..Scene::default()
    }
}
