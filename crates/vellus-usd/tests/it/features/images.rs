//! Images of several files, and images of skies.

use super::said;
use crate::common::read;
use std::path::Path;
use vellus_scene::{LightShape, Scene, Wrap};
use vellus_usd::{Options, Warning, write};

/// Writes a grey image.
fn png(file: &Path, width: u32, height: u32, data: &[u8]) {
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    let mut encoder = png::Encoder::new(std::fs::File::create(file).unwrap(), width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
}

const TILED: &str = "
def Mesh \"skin\" {
    int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0,0,0), (1,0,0), (1,1,0)]
    uniform token subdivisionScheme = \"none\"
    texCoord2f[] primvars:st = [(0,0), (1,0), (1,1)] ( interpolation = \"vertex\" )
    rel material:binding = </Skin>
}
def BasisCurves \"hair\" {
    uniform token type = \"linear\" int[] curveVertexCounts = [2] float[] widths = [1, 1]
    point3f[] points = [(0,0,0), (1,0,0)]
    texCoord2f[] primvars:st = [(0,0)]
    rel material:binding = </Fur>
}
def Material \"Skin\" {
    token outputs:surface.connect = </Skin/s.outputs:surface>
    def Shader \"s\" {
        uniform token info:id = \"UsdPreviewSurface\"
        color3f inputs:diffuseColor.connect = </Skin/t.outputs:rgb>
    }
    def Shader \"t\" { uniform token info:id = \"UsdUVTexture\" asset inputs:file = @./tex/skin.<UDIM>.png@ }
}
def Material \"Fur\" {
    token outputs:surface.connect = </Fur/s.outputs:surface>
    def Shader \"s\" {
        uniform token info:id = \"VellusFur\"
        float inputs:g.connect = </Fur/t.outputs:r>
    }
    def Shader \"t\" { uniform token info:id = \"UsdUVTexture\" asset inputs:file = @./tex/skin.<UDIM>.png@ }
}";

#[test]
fn tiles_become_one_image_for_meshes_and_fur() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("a.usda"), format!("#usda 1.0\n{TILED}")).unwrap();
    let open = |name: &str| vellus_usd::read(&at(name), &Options::default());
    let error = open("a.usda").map(|reading| said(&reading.warnings)).unwrap_or_else(|error| error.to_string());
    assert!(error.contains("skin.<UDIM>.png does not exist"), "{error}");
    png(&at("tex/skin.1002.png"), 1, 1, &[51]);
    png(&at("tex/skin.1011.png"), 2, 1, &[102, 255]);
    std::fs::write(at("tex/skin.1012.png"), "broken").unwrap();
    let reading = open("a.usda").unwrap();
    let scene = &reading.scene;
    assert!(said(&reading.warnings).contains("skin.1012.png: it is no PNG"), "{:?}", reading.warnings);
    let texture = &scene.textures[scene.surfaces[scene.meshes[0].surface].color.texture.unwrap()];
    assert_eq!(
        (texture.name.as_str(), texture.width, texture.wrap),
        ("skin.<UDIM>.png", 4, [Wrap::Tiles(2), Wrap::Tiles(2)])
    );
    let look = &scene.looks[scene.strands[0].look];
    let value = &scene.textures[look.textured[0].1.texture];
    for texture in [texture, value] {
        let at = |u, v| texture.at(glam::Vec2::new(u, v));
        assert_eq!([at(1.5, 0.5), at(0.25, 1.5), at(0.75, 1.5)], [[0.2; 3], [0.4; 3], [1.0; 3]]);
    }
    assert_eq!(texture.at(glam::Vec2::new(1.5, 1.5)), [1.0, 0.0, 1.0]);
    let sources: Vec<String> = reading.sources.iter().map(|(name, _)| name.to_owned()).collect();
    assert_eq!(sources, ["", "tex/skin.1002.png", "tex/skin.1011.png", "tex/skin.1012.png"]);

    // They are written as tiles, and in a package they are found too.
    write(scene, &at("b.usda")).unwrap();
    let again = open("b.usda").unwrap();
    assert_eq!(said(&again.warnings), "");
    let names = |scene: &Scene| scene.textures.iter().map(|texture| texture.pixels.clone()).collect::<Vec<_>>();
    assert_eq!(names(&again.scene), names(scene));
    let mut package = openusd::usdz::ArchiveWriter::new(std::io::Cursor::new(Vec::new()));
    package.add_layer("a.usda", format!("#usda 1.0\n{TILED}").as_bytes()).unwrap();
    for name in ["tex/skin.1002.png", "tex/skin.1011.png"] {
        package.add_layer(name, &std::fs::read(at(name)).unwrap()).unwrap();
    }
    std::fs::write(at("c.usdz"), package.finish().unwrap().into_inner()).unwrap();
    let packed = open("c.usdz").unwrap();
    assert_eq!((said(&packed.warnings), packed.scene.textures[0].width), (String::new(), 4));
}

/// A dome whose image has this size, and one white pixel in its middle row, a quarter from the left.
fn dome(size: [u32; 2], attribute: &str) -> (Scene, Vec<Warning>) {
    let folder = tempfile::tempdir().unwrap();
    let [width, height] = size;
    let mut data = vec![0; (width * height) as usize];
    data[(height / 2 * width + width / 4) as usize] = 255;
    png(&folder.path().join("sky.png"), width, height, &data);
    let stage = format!(
        "#usda 1.0
def DomeLight \"sky\" {{ asset inputs:texture:file = @sky.png@ {attribute} }}
def BasisCurves \"hair\" {{ uniform token type = \"linear\" {} }}",
        super::FOUR
    );
    std::fs::write(folder.path().join("a.usda"), stage).unwrap();
    read(&folder.path().join("a.usda"), &Options::default()).unwrap()
}

#[test]
fn a_sky_that_cannot_be_lat_long_is_named() {
    for (size, attribute) in [([32, 16], ""), ([17, 8], "token inputs:texture:format = \"latlong\"")] {
        assert_eq!(said(&dome(size, attribute).1), "");
    }
    let (scene, warnings) = dome([16, 16], "token inputs:texture:format = \"automatic\"");
    assert!(said(&warnings).contains("/sky: the image sky.png of a sky has 16 × 16 pixels"), "{warnings:?}");
    assert_eq!((scene.textures[0].width, scene.textures[0].height), (16, 16));
    let (_, warnings) = dome([16, 12], "token inputs:texture:format = \"cubeMapVerticalCross\"");
    assert!(said(&warnings).contains("cubeMapVerticalCross is not supported"), "{warnings:?}");
}

/// The white pixel is at 0.492 of the radius, to the left: at 89 degrees in an angular map, at 59 in a mirrored ball.
#[test]
fn probes_become_lat_long_images() {
    for (format, column) in [("angular", 23), ("mirroredBall", 30)] {
        let (scene, warnings) = dome([65, 65], &format!("token inputs:texture:format = \"{format}\""));
        assert!(said(&warnings).contains("where a probe points"), "{warnings:?}");
        let LightShape::Dome { texture: Some(index), .. } = scene.lights[0].shape else { panic!() };
        let sky = &scene.textures[index];
        assert_eq!((sky.width, sky.height), (92, 46));
        let lit: Vec<usize> = (0..sky.pixels.len()).filter(|&i| sky.pixels.get(i)[0] > 0.05).map(|i| i % 92).collect();
        assert!(!lit.is_empty() && lit.iter().all(|x| x.abs_diff(column) <= 1), "{format}: {lit:?}");
    }
}
