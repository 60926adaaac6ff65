//! Tests of the list of files that a scene was read from.

use std::collections::BTreeSet;
use std::path::Path;
use vellus_io::Digest;
use vellus_usd::{Options, Reading};

const CURVES: &str = "def BasisCurves \"c\" ( apiSchemas = [\"MaterialBindingAPI\"] ) {
    uniform token type = \"linear\" int[] curveVertexCounts = [2] float[] widths = [1, 1]
    point3f[] points = [(0,0,0), (1,0,0)] rel material:binding = </World/m> }";

/// A texture of one pixel.
fn png(grey: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&[grey]).unwrap();
    bytes
}

/// A stage with a sublayer, a reference, a payload and two textures; two layers have several names.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let material = "def Xform \"World\" { def Material \"m\" {
    token outputs:surface.connect = </World/m/fur.outputs:out>
    def Shader \"fur\" { uniform token info:id = \"VellusFur\" token outputs:out
        float inputs:g.connect = </World/m/one.outputs:r> float inputs:kappa.connect = </World/m/two.outputs:r> }
    def Shader \"one\" { uniform token info:id = \"UsdUVTexture\" asset inputs:file = @../tex/one.png@ float outputs:r }
    def Shader \"two\" { uniform token info:id = \"UsdUVTexture\" asset inputs:file = @../tex/two.png@ float outputs:r }
} }";
    let top = "( subLayers = [@./layers/light.usda@] )
def Xform \"World\" ( references = @./layers/material.usda@</World> payload = @groom/curves.usda@</World> ) {
    def Xform \"a\" ( references = @layers/../groom/../groom/curves.usda@</World> ) {}
    def Xform \"b\" ( references = @tex/../layers/material.usda@</World> ) {} }";
    let texts = [
        ("scene.usda", top.to_owned()),
        ("layers/light.usda", "def DomeLight \"sky\" {}".to_owned()),
        ("layers/material.usda", material.to_owned()),
        ("groom/curves.usda", format!("def Xform \"World\" {{ {CURVES} }}")),
    ];
    let mut files: Vec<_> =
        texts.into_iter().map(|(name, text)| (name, format!("#usda 1.0\n{text}").into_bytes())).collect();
    files.extend([("tex/one.png", png(50)), ("tex/two.png", png(90))]);
    files
}

fn write(folder: &Path, files: &[(&str, Vec<u8>)]) {
    for (name, bytes) in files {
        std::fs::create_dir_all(folder.join(name).parent().unwrap()).unwrap();
        std::fs::write(folder.join(name), bytes).unwrap();
    }
}

fn read(file: &Path) -> Reading {
    vellus_usd::read(file, &Options::default()).unwrap()
}

fn digest(folder: &Path, files: &[(&str, Vec<u8>)]) -> Digest {
    write(folder, files);
    read(&folder.join("scene.usda")).sources.digest()
}

#[test]
fn copies_have_equal_sources_and_changed_files_do_not() {
    let [here, there] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let files = files();
    write(here.path(), &files);
    let reading = read(&here.path().join("scene.usda"));
    let names: Vec<_> = reading.sources.iter().map(|(name, _)| name).collect();
    assert_eq!(
        names,
        ["", "groom/curves.usda", "layers/light.usda", "layers/material.usda", "tex/one.png", "tex/two.png"]
    );
    let expected = reading.sources.digest();
    for _ in 0..10 {
        assert_eq!(read(&here.path().join("layers/../scene.usda")).sources.digest(), expected);
    }
    assert_eq!(digest(there.path(), &files), expected);

    let mut digests = BTreeSet::from([expected]);
    for i in 0..files.len() {
        let mut changed = files.clone();
        // Bytes after the end of a layer or an image change the digest, too.
        changed[i].1.extend(b"\n#");
        assert!(digests.insert(digest(there.path(), &changed)), "{}", files[i].0);
    }
    let mut swapped = files.clone();
    (swapped[4].1, swapped[5].1) = (files[5].1.clone(), files[4].1.clone());
    assert!(digests.insert(digest(there.path(), &swapped)));
}

#[test]
fn a_package_is_one_file() {
    let folder = tempfile::tempdir().unwrap();
    let layer = format!(
        "#usda 1.0\n( defaultPrim = \"World\" )\ndef Xform \"World\" ( references = @sub/x.usda@</X> ) {{ {CURVES} }}"
    );
    let pack = |inner: &[u8]| {
        let mut writer = openusd::usdz::ArchiveWriter::new(std::io::Cursor::new(Vec::new()));
        writer.add_layer("root.usda", layer.as_bytes()).unwrap();
        writer.add_layer("sub/x.usda", inner).unwrap();
        writer.finish().unwrap().into_inner()
    };
    let top = b"#usda 1.0\ndef Xform \"a\" ( references = @packages/p.usdz@ ) {}".to_vec();
    let package = pack(b"#usda 1.0\ndef Xform \"X\" {}");
    write(folder.path(), &[("packages/p.usdz", package.clone()), ("scene.usda", top)]);
    let outside = read(&folder.path().join("scene.usda"));
    let found: Vec<_> = outside.sources.iter().collect();
    assert_eq!((found[1], found.len()), (("packages/p.usdz", Digest::of(&package)), 2));
    let inside = read(&folder.path().join("packages/p.usdz"));
    assert_eq!(inside.sources.iter().collect::<Vec<_>>(), [("", Digest::of(&package))]);
    write(folder.path(), &[("packages/p.usdz", pack(b"#usda 1.0\ndef Xform \"Y\" {} def Xform \"X\" {}"))]);
    assert_ne!(read(&folder.path().join("scene.usda")).sources, outside.sources);
}
