//! No property is lost in silence.

use super::{FOUR, said, scene};

#[test]
fn properties_that_nobody_reads_are_named() {
    for (prim, name) in [
        (format!("def BasisCurves \"c\" {{ {FOUR} normal3f[] normals = [(0,0,1)] }}"), "normals"),
        (format!("def BasisCurves \"c\" {{ {FOUR} uniform token model:drawMode = \"bounds\" }}"), "model:drawMode"),
        (format!("def BasisCurves \"c\" {{ {FOUR} rel material:binding:render = </m> }}"), "material:binding:render"),
        (format!("def BasisCurves \"c\" {{ {FOUR} float newThing = 1 }}"), "newThing"),
    ] {
        let (_, warnings) = scene(&prim);
        assert_eq!(said(&warnings), format!("/c: {name} is not read and has no effect"), "{prim}");
    }
    // Prims that share a property share a line.
    let two = format!(
        "def BasisCurves \"a\" {{ {FOUR} float newThing = 1 }} def BasisCurves \"b\" {{ {FOUR} float newThing = 1 }}"
    );
    assert_eq!(said(&scene(&two).1), "/a, /b: newThing is not read and has no effect");
    // Shaders and groups, too. Materials that nothing is bound to are not read at all.
    let shader = format!(
        "def Xform \"g\" {{ float newThing = 1 }} def Material \"m\" {{ token outputs:surface.connect = </m/s.outputs:surface>
            def Shader \"s\" {{ uniform token info:id = \"VellusFur\" float inputs:newThing = 1 token outputs:surface }} }}
        def Material \"other\" {{ def Shader \"s\" {{ float inputs:unbound = 1 }} }}
        def BasisCurves \"c\" {{ {FOUR} rel material:binding = </m> }}"
    );
    let said = said(&scene(&shader).1);
    assert!(said.contains("/g: newThing is not read") && said.contains("/m/s: inputs:newThing is not read"), "{said}");
    assert!(!said.contains("unbound"), "{said}");
}

/// What exporters write and what nobody can see, and values that are those of the schema.
#[test]
fn ordinary_exports_are_quiet() {
    let quiet = "custom string userProperties:blender:object_name = \"x\" float3[] extent = [(0,0,0), (1,1,1)]
        uniform token purpose = \"default\" token visibility = \"inherited\" string ui:note = \"x\"
        uniform token wrap = \"nonperiodic\" custom float mine = 3 uniform token model:drawMode = \"default\"
        float[] primvars:arnold:radius = [1] float[] primvars:widths = [0.1] rel proxyPrim = </p> rel empty float declared
        rel collection:hair:includes = </c> double3 xformOp:scale = (2, 2, 2)";
    let body = format!(
        "def Xform \"g\" {{ {quiet} }} def BasisCurves \"c\" {{ {FOUR} {} }} def Mesh \"m\" {{ uniform bool doubleSided = 1
            point3f[] points = [(0,0,0), (1,0,0), (0,1,0)] int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 2]
            uniform token subdivisionScheme = \"none\" token interpolateBoundary = \"edgeAndCorner\" }}
        def Camera \"k\" {{ float2 clippingRange = (0.1, 100) token projection = \"perspective\" float exposure:time = 1 }}
        def Scope \"s\" {{}} def Skeleton \"bones\" {{}} def HoudiniLayerInfo \"h\" {{}}",
        quiet.replace("uniform token wrap = \"nonperiodic\"", "")
    );
    assert_eq!(said(&scene(&body).1), "");
    let unknown = format!("def BasisCurves \"c\" {{ {FOUR} }} def Hologram \"x\" {{}}");
    assert_eq!(said(&scene(&unknown).1), "/x: Hologram is not known and is ignored");
}
