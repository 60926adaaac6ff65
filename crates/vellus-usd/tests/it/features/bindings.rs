//! Bindings of materials to prims and to collections.

use super::{FOUR, said, scene};
use crate::common::{read_text, told};
use vellus::Fiber;
use vellus_usd::Options;

/// The nearest prim with a binding applies. It may bind a material to the curves or to a collection with them. A
/// binding for final pictures takes precedence over one for all purposes. Prims further up take precedence only if they
/// are marked as stronger.
#[test]
fn materials_are_bound_by_collections() {
    let fur = |name: &str, g: f32| {
        format!(
            "def Material \"{name}\" {{ token outputs:surface.connect = </{name}/Fur.outputs:surface>
    def Shader \"Fur\" {{ uniform token info:id = \"VellusFur\" float inputs:g = {g} token outputs:surface }} }}\n"
        )
    };
    let furs = [("A", 0.1), ("B", 0.2), ("C", 0.3), ("D", 0.4)].map(|(name, g)| fur(name, g)).concat();
    // The values of g of the three curves, for bindings on the world, on their parent and on the last curve.
    let read = |world: &str, parent: &str, last: &str| {
        let curve = |name: &str, more: &str| format!("def BasisCurves \"{name}\" {{ {FOUR}\n {more} }}\n");
        let body = format!(
            "def Xform \"world\" {{\n {world}\n def Xform \"coat\" {{\n {parent}\n {}{}{} }}\n }}\n{furs}",
            curve("one", ""),
            curve("two", ""),
            curve("three", last)
        );
        let (scene, warnings) = scene(&body);
        let g: Vec<_> = scene.strands.iter().map(|s| scene.looks[s.look].fiber.g).collect();
        (g, said(&warnings))
    };
    let none = Fiber::hair().g;
    let collection = "rel collection:some:includes = [</world/coat/two>, </world/coat/three>]
        rel material:binding:collection:some = [</world.collection:some>, </A>]\n";
    assert_eq!(read(collection, "", "").0, [none, 0.1, 0.1]);
    // An excluded member, and a binding on the prim itself, which is nearer.
    let without = format!("{collection} rel collection:some:excludes = </world/coat/two>");
    assert_eq!(read(&without, "", "rel material:binding = </B>").0, [none, none, 0.2]);
    // On one prim, the first collection takes precedence, then other collections, then the direct binding. The second
    // collection does not include the prims below its target.
    let both = format!(
        "{collection} rel material:binding = </B>
        uniform token collection:all:expansionRule = \"explicitOnly\" rel collection:all:includes = </world/coat>
        rel material:binding:collection:all = [</world.collection:all>, </C>]"
    );
    assert_eq!(read(&both, "", "").0, [0.2, 0.1, 0.1]);
    let stronger = "rel material:binding = </B> ( bindMaterialAs = \"strongerThanDescendants\" )";
    assert_eq!(read(stronger, "rel material:binding = </C>", "rel material:binding = </D>").0, [0.2; 3]);
    assert_eq!(read("rel material:binding = </B>", "rel material:binding = </C>", "").0, [0.3; 3]);
    // Bindings for final pictures apply at any distance.
    let full = "rel collection:some:includes = </world/coat/two>
        rel material:binding:collection:full:some = [</world.collection:some>, </A>]
        rel material:binding:collection:preview:some = [</world.collection:some>, </D>]";
    assert_eq!(read(full, "rel material:binding = </C>", "rel material:binding:full = </B>").0, [0.3, 0.1, 0.2]);
    // A collection inside another one, and targets that are not collections.
    let chained = "rel collection:some:includes = </world/coat/two>
        rel collection:more:includes = [</world.collection:some>, </world/coat/three>]
        rel material:binding:collection:x = [</world.collection:more>, </A>]
        rel material:binding:collection:y = [</world/coat>, </B>]";
    assert_eq!(read(chained, "", "").0, [none, 0.1, 0.1]);
    let wrong = "rel material:binding:collection:x = </A>
        uniform string collection:e:membershipExpression = \"/world//{isa:Mesh}\"
        rel material:binding:collection:e = [</world.collection:e>, </A>]";
    let (g, said) = read(wrong, "", "");
    assert_eq!(g, [none; 3]);
    assert!(said.contains("/world: material:binding:collection:x must have two targets"), "{said}");
    assert!(said.contains("/world.collection:e: the collection is empty: "), "{said}");
    assert_eq!(read(&wrong.replace("{isa:Mesh}", "t*"), "", "").0, [none, 0.1, 0.1]);
    let chain = |n: usize| {
        let link = |i: usize| format!("rel collection:c{i}:includes = </world.collection:c{}>\n", (i + 1) % n);
        let links: String = (0..n).map(link).collect();
        format!("{links} rel material:binding:collection:x = [</world.collection:c0>, </A>]")
    };
    assert_eq!(read(&chain(100), "", "").0, [none; 3]);
    let body = format!("def Xform \"world\" {{ {} def BasisCurves \"b\" {{ {FOUR} }} }}", chain(1000));
    let error = told(read_text(&body, &Options::default()));
    assert!(error.contains("more than 200 collections"), "{error}");
}
