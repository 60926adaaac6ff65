//! Light linking, shadows and gains of UsdLux, and meshes that are lights.

use super::{FOUR, said, scene};
use crate::common::read_text;
use vellus_scene::{Light, Link, Objects, Scene};
use vellus_usd::Options;

fn except(names: &[&str]) -> Objects {
    Objects::Except(names.iter().map(|name| (*name).to_owned()).collect())
}

fn only(names: &[&str]) -> Objects {
    Objects::Only(names.iter().map(|name| (*name).to_owned()).collect())
}

/// The lights with links, and their links.
fn links(scene: &Scene) -> Vec<(usize, Link)> {
    let link = |(i, light): (usize, &Light)| Some((i, light.link.clone()?));
    scene.lights.iter().enumerate().filter_map(link).collect()
}

/// The root is a member if nothing else is said, unlike in other collections. The nearest rule decides.
#[test]
fn lights_are_linked_as_usdlux_defines() {
    let (scene, warnings) = scene(&format!(
        "( )
def Xform \"fur\" {{ def BasisCurves \"a\" {{ {FOUR} }}
    def BasisCurves \"b\" {{ {FOUR} custom string vellus:name = \"bee\" }} }}
def BasisCurves \"c\" {{ {FOUR} }}
def SphereLight \"all\" {{ bool collection:lightLink:includeRoot = 1 rel collection:shadowLink:includes = </c> }}
def SphereLight \"excluded\" {{ rel collection:lightLink:excludes = [</fur>, </missing>]
    rel collection:lightLink:includes = </fur/b> }}
def SphereLight \"none\" {{ uniform bool collection:lightLink:includeRoot = 0 }}
def SphereLight \"one\" {{ uniform bool collection:lightLink:includeRoot = 0 rel collection:lightLink:includes = </c> }}
def SphereLight \"explicit\" {{ uniform bool collection:shadowLink:includeRoot = 0
    uniform token collection:shadowLink:expansionRule = \"explicitOnly\"
    rel collection:shadowLink:includes = [</fur>, </c>] }}
def SphereLight \"nested\" {{ uniform bool collection:lightLink:includeRoot = 0
    rel collection:lightLink:includes = </set.collection:fur> }}
def Scope \"set\" {{ rel collection:fur:includes = </fur> rel collection:fur:excludes = </fur/a> }}
def SphereLight \"bare\" {{ bool inputs:shadow:enable = 0 }}
def SphereLight \"gains\" {{ float inputs:diffuse = 0 float inputs:specular = 2 bool inputs:shadow:enable = 1 }}"
    ));
    assert_eq!(said(&warnings), "");
    let lit = |lit| Link { lit, ..Link::default() };
    let casters = |casters| Link { casters, ..Link::default() };
    let expected = [
        (1, lit(except(&["/fur/a"]))),
        (2, lit(Objects::NONE)),
        (3, lit(only(&["/c"]))),
        (4, casters(only(&["/c"]))),
        (5, lit(only(&["bee"]))),
        (6, casters(Objects::NONE)),
        (7, Link { diffuse: 0.0, specular: 2.0, ..Link::default() }),
    ];
    assert_eq!(links(&scene), expected);
}

/// Native instances that other lights reach have prototypes of their own.
#[test]
fn instances_are_linked_one_by_one() {
    let stage = format!(
        "( )
class \"proto\" {{ def BasisCurves \"hair\" {{ {FOUR} }} }}
def Xform \"S\" {{
  def Xform \"a\" ( instanceable = true; inherits = </proto> ) {{}}
def Xform \"b\" ( instanceable = true; inherits = </proto> ) {{}}
def Xform \"c\" ( instanceable = true; inherits = </proto> ) {{}}
}}
def SphereLight \"key\" {{ rel collection:lightLink:excludes = </S/b> }}"
    );
    let read = |instances| read_text(&stage, &Options { instances, ..Options::default() }).unwrap();
    let (shared, warnings) = read(true);
    assert_eq!(said(&warnings), "");
    let link = |name: &str| vec![(0, Link { lit: except(&[name]), ..Link::default() })];
    assert_eq!((shared.prototypes.len(), shared.instances.len(), shared.strands.len()), (1, 2, 1));
    assert_eq!(links(&shared), link("/S/b/hair"));
    let (copied, _) = read(false);
    assert_eq!((copied.strands.len(), links(&copied)), (3, link("/S/b/hair")));
}

/// An expression counts if nothing else is said. Its paths move with the layer that has it.
#[test]
fn expressions_link_lights() {
    let folder = tempfile::tempdir().unwrap();
    let set = format!(
        "#usda 1.0\n( defaultPrim = \"M\" )
def Xform \"M\" {{ def BasisCurves \"a1\" {{ {FOUR} }}
    def BasisCurves \"a2\" {{ {FOUR} }}
    def SphereLight \"key\" {{ uniform bool collection:lightLink:includeRoot = 0
        pathExpression collection:lightLink:membershipExpression = \"/M/a? - ../a2\" }}
    def SphereLight \"fill\" {{ uniform bool collection:lightLink:includeRoot = 0
        pathExpression collection:lightLink:membershipExpression = \"~%/M:set & //\" }}
    pathExpression collection:set:membershipExpression = \"a1\"
    def SphereLight \"rim\" {{ pathExpression collection:lightLink:membershipExpression = \"/M/a1\" }}
    def SphereLight \"back\" {{ uniform bool collection:lightLink:includeRoot = 0
        pathExpression collection:lightLink:membershipExpression = \"//{{isa:Mesh}}\" }} }}"
    );
    std::fs::write(folder.path().join("set.usda"), set).unwrap();
    let file = folder.path().join("stage.usda");
    let stage = "#usda 1.0\ndef Xform \"W\" { def \"N\" ( references = @./set.usda@ ) {} }";
    std::fs::write(&file, stage).unwrap();
    let (scene, warnings) = crate::common::read(&file, &Options::default()).unwrap();
    let lit = |lit| Link { lit, ..Link::default() };
    assert_eq!(links(&scene), [(0, lit(except(&["/W/N/a2"]))), (1, lit(except(&["/W/N/a1"])))]);
    let said = said(&warnings);
    for expected in [
        "/W/N/rim: collection:lightLink:membershipExpression has no effect: the collection has the root",
        "collection:lightLink:membershipExpression cannot be read: it has a predicate",
    ] {
        assert!(said.contains(expected), "{said}");
    }
    assert_eq!(warnings.len(), 2, "{said}");
}

#[test]
fn what_is_not_read_of_a_light_is_named() {
    let (scene, warnings) = scene(&format!(
        "( )
def BasisCurves \"b\" {{ {FOUR} }}
def PointInstancer \"field\" {{ rel prototypes = </protos/hair>
    point3f[] positions = [(0, 0, 0)] int[] protoIndices = [0] }}
def Scope \"protos\" {{ def BasisCurves \"hair\" {{ {FOUR} }} }}
def SphereLight \"instancer\" {{ rel collection:lightLink:excludes = </field> }}
def SphereLight \"filter\" {{ rel light:filters = </b>
    color3f inputs:shadow:color = (1, 0, 0) float inputs:shadow:distance = 3 }}
def SphereLight \"idle\" {{ color3f inputs:shadow:color = (0, 0, 0) float inputs:shadow:distance = -1 }}
def SphereLight \"circle\" {{ rel collection:lightLink:includes = </circle.collection:lightLink>
    rel collection:lightLink:excludes = </x> }}"
    ));
    let said = said(&warnings);
    for expected in [
        "/instancer: its links of the prototypes of an instancer count",
        "/filter: inputs:shadow:color is not supported",
        "/filter: inputs:shadow:distance is not supported",
        "/filter: light:filters are not supported",
    ] {
        assert!(said.contains(expected), "{said}");
    }
    assert_eq!((warnings.len(), links(&scene)), (4, vec![]), "{said}");
}

fn lamp(more: &str) -> Scene {
    let (scene, warnings) = scene(&format!(
        "( )
def BasisCurves \"b\" {{ {FOUR} }}
def Mesh \"lamp\" ( prepend apiSchemas = [\"MeshLightAPI\"] ) {{ {more} uniform token subdivisionScheme = \"none\"
    int[] faceVertexCounts = [4] int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0,0,0), (2,0,0), (2,3,0), (0,3,0)] }}
def Mesh \"skin\" {{ uniform token subdivisionScheme = \"none\"
    int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 2] point3f[] points = [(0,0,0), (2,0,0), (2,3,0)] }}"
    ));
    let said = said(&warnings);
    assert!(said.contains("/lamp: a mesh that is a light is found only by") && warnings.len() == 1, "{said}");
    scene
}

/// The emission of a mesh that is a light, with and without the normalization by its area of 6.
#[test]
fn meshes_that_are_lights_emit() {
    let emission = |more| {
        let scene = lamp(more);
        let of = |mesh: usize| scene.surfaces[scene.meshes[mesh].surface].emission;
        assert_eq!(of(1), [0.0; 3]);
        of(0)
    };
    assert_eq!(emission(""), [1.0; 3]);
    assert_eq!(emission("float inputs:intensity = 3 color3f inputs:color = (1, 0.5, 0)"), [3.0, 1.5, 0.0]);
    assert_eq!(emission("float inputs:intensity = 3 bool inputs:normalize = 1"), [0.5; 3]);
}
