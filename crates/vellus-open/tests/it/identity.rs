//! The identity of pictures: the digest of the settings of the path tracer and of the scene.

use vellus::{Color, Fiber, Species};
use vellus_groom::Interpolation;
use vellus_io::{Digest, Sources};
use vellus_open::{Backdrop, Lighting, Markings, Options, Recolor, Staging, Tips, identify};
use vellus_render::session::Identity;
use vellus_render::{Layer, Lod, Settings};
use vellus_scene::ReflectanceOf;

/// The identity of a picture of a scene, with the defaults of the command `vellus render`.
fn identity(scene: &str, options: &Options) -> Digest {
    let settings = Settings::new([960, 640]);
    let listed = Layer::list("all").unwrap_or_default().into_iter();
    let extra = |layer: &Layer| matches!(layer, Layer::Motion | Layer::Lights) || Layer::CRYPTOMATTE.contains(layer);
    let layers: Vec<Layer> = listed.filter(|layer| !extra(layer)).collect();
    let identity = Identity {
        settings: &settings,
        layers: &layers,
        model: "vellus",
        eta_m: None,
        min_pixel_width: 0.0,
        lod: Lod::Off,
    };
    identify(identity.digest(Sources::new().digest()), scene, options).finish()
}

/// The same value as that of the command.
#[test]
fn the_identity_is_the_same_everywhere() {
    assert_eq!(identity("cat", &Options { small: true, ..Options::default() }).short(), "a02173946a07670d");
}

#[test]
fn every_option_changes_the_identity() {
    let fox = Fiber::preset(Species::RedFox);
    let new = Options::default;
    let marked = |markings| Options { markings, ..new() };
    let staged = |staging| Options { staging: Some(staging), ..new() };
    let all = [
        new(),
        Options { width: Some(0.5), ..new() },
        Options { strands: Some(0.5), ..new() },
        Options { camera: Some("a".to_owned()), ..new() },
        Options { frame: Some(2.0), ..new() },
        Options { fiber: Some(("red-fox".to_owned(), Fiber { kappa: 0.5, ..fox })), ..new() },
        Options { recolor: Some(Recolor::new(Some("dog".into()), Vec::new()).unwrap()), ..new() },
        Options { recolor: Some(Recolor::new(None, vec!["kappa=0.5".to_owned()]).unwrap()), ..new() },
        Options { reflectance_of: ReflectanceOf::Dense, ..new() },
        marked(Markings { tips: Some(Tips { color: [0.1; 3], share: 0.3 }), ..Markings::default() }),
        Options { wet: 0.5, ..new() },
        Options { coat: Some(Species::Deer), ..new() },
        marked(Markings { belly: Some([0.1; 3]), ..Markings::default() }),
        Options { interpolation: Interpolation { clump: 0.5, ..Interpolation::default() }, ..new() },
        Options { fiber: Some(("red-fox".to_owned(), fox.with_color(Color::Reflectance([0.9; 3])).unwrap())), ..new() },
        staged(Staging::new(1.5)),
        staged(Staging { view: Some("1,2".parse().unwrap()), ..Staging::new(1.5) }),
        staged(Staging { light: Some(Lighting::Sun), ..Staging::new(1.5) }),
        staged(Staging { background: Some(Backdrop::Transparent), ..Staging::new(1.5) }),
        staged(Staging { background: Some(Backdrop::Color([0.5; 3])), ..Staging::new(1.5) }),
        staged(Staging { body: Some("body.obj".into()), ..Staging::new(1.5) }),
    ];
    let digests = all.each_ref().map(|options| identity("x.usda", options));
    for (i, digest) in digests.iter().enumerate() {
        assert!(!digests[..i].contains(digest), "{:?}", all[i]);
    }
    // The name of a fibre and the location of a file do not change pixels.
    let named = Options { fiber: Some(("fox".to_owned(), fox)), ..new() };
    assert_eq!(identity("x.usda", &named), digests[0]);
    assert_eq!(identity("elsewhere/y.usda", &new()), digests[0]);
    assert_ne!(identity("cat", &new()), identity("raccoon", &new()));
    // A built-in scene without options is not staged.
    assert_eq!(identity("cat", &staged(Staging::new(1.5))), identity("cat", &new()));
}
