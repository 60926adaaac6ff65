//! No property is lost in silence.

use super::{FOUR, said, scene};

#[test]
fn properties_that_nobody_reads_are_named() {
    for (prim, name) in [
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
        "def Xform \"g\" {{ float newThing = 1 }} def Material \"m\" {{
            token outputs:surface.connect = </m/s.outputs:surface>
            def Shader \"s\" {{ uniform token info:id = \"VellusFur\" float inputs:newThing = 1
                token outputs:surface }} }}
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
        float[] primvars:arnold:radius = [1] float[] primvars:widths = [0.1] rel proxyPrim = </p>
        rel empty float declared bool pruning:prunable = 0 matrix4d constraintTargets:hand rel
        coordSys:map:binding = </k>
        rel collection:hair:includes = </c> double3 xformOp:scale = (2, 2, 2)";
    let body = format!(
        "def Xform \"g\" {{ {quiet} }} def BasisCurves \"c\" {{ {FOUR} {} }} def Mesh \"m\" {{ uniform bool
            doubleSided = 1
            point3f[] points = [(0,0,0), (1,0,0), (0,1,0)] int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            uniform token subdivisionScheme = \"none\" token interpolateBoundary = \"edgeAndCorner\"
            bool faceVaryingInterpolateBoundary = 1 token subsetFamily:materialBind:familyType = \"partition\"
            rel material:binding = </none> rel material:binding:full = </plain> }}
        def Material \"plain\" {{ token outputs:surface.connect = </plain/s.outputs:surface>
            def Shader \"s\" {{ uniform token info:id = \"UsdPreviewSurface\" token outputs:surface }} }}
        def DomeLight \"d\" {{ token inputs:texture:format = \"latlong\" }}
        def Camera \"k\" {{ float4[] clippingPlanes = [] float2 clippingRange = (0.1, 100)
            token projection = \"perspective\" float exposure:time = 1 }}
        def Scope \"s\" {{}} def Skeleton \"bones\" {{}} def HoudiniLayerInfo \"h\" {{}}",
        quiet.replace("uniform token wrap = \"nonperiodic\"", "")
    );
    assert_eq!(said(&scene(&body).1), "");
    let unknown = format!("def BasisCurves \"c\" {{ {FOUR} }} def Hologram \"x\" {{}}");
    assert_eq!(said(&scene(&unknown).1), "/x: Hologram is not known and is ignored");
}

/// What subdivision, skeletons, shapes, links and settings ask for, and what replaces something of the same name.
#[test]
fn readers_of_all_schemas_know_their_properties() {
    let body = "( renderSettingsPrimPath = \"/Render/settings\" )
        def SkelRoot \"body\" ( prepend apiSchemas = [\"SkelBindingAPI\"] ) {
            rel skel:skeleton = </body/bones> rel skel:animationSource = </body/walk>
            def Skeleton \"bones\" ( prepend apiSchemas = [\"SkelBindingAPI\"] ) {
                uniform token[] joints = [\"a\"] uniform token[] jointNames = [\"A\"]
                uniform matrix4d[] bindTransforms = [((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,0,1))]
                uniform matrix4d[] restTransforms = [((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,0,1))]
                rel skel:animationSource = </body/walk> }
            def SkelAnimation \"walk\" { uniform token[] joints = [\"a\"] float3[] translations = [(1,0,0)]
                quatf[] rotations = [(1,0,0,0)] half3[] scales = [(1,1,1)]
                uniform token[] blendShapes = [\"smile\"] float[] blendShapeWeights = [1] }
            def Mesh \"skin\" ( prepend apiSchemas = [\"SkelBindingAPI\"] ) { rel skel:skeleton = </body/bones>
                point3f[] points = [(0,0,0), (1,0,0), (0,1,0)] int[] faceVertexCounts = [3]
                int[] faceVertexIndices = [0, 1, 2]
                uniform token subdivisionScheme = \"none\" uniform token interpolateBoundary = \"edgeOnly\"
                int[] creaseIndices = [0, 1] int[] creaseLengths = [2] float[] creaseSharpnesses = [3]
                int[] primvars:skel:jointIndices = [0] (interpolation = \"constant\")
                float[] primvars:skel:jointWeights = [1] (interpolation = \"constant\")
                uniform token[] skel:joints = [\"a\"] uniform token[] skel:blendShapes = [\"smile\"]
                rel skel:blendShapeTargets = </body/skin/smile>
                def BlendShape \"smile\" { uniform vector3f[] offsets = [(0,0,1)] uniform int[] pointIndices = [0]
                    uniform vector3f[] normalOffsets = [(0,0,0)] } } }
        def Sphere \"ball\" { double radius = 2 float3[] extent = [(-2,-2,-2), (2,2,2)] }
        def SphereLight \"lamp\" { rel collection:lightLink:includes = </ball> bool collection:lightLink:includeRoot = 0
            bool inputs:shadow:enable = 0 float inputs:diffuse = 0.5 }
        def Camera \"eye\" {}
        def Scope \"Render\" { def RenderSettings \"settings\" { rel camera = </eye> rel products = </Render/beauty>
                uniform int2 resolution = (4, 2) uniform token[] materialBindingPurposes = [\"full\", \"allPurpose\"] }
            def RenderProduct \"beauty\" { uniform int2 resolution = (2, 1) token productName = \"a.exr\"
                rel orderedVars } }";
    assert_eq!(said(&scene(body).1), "");
    let others = body
        .replace("double radius", "float newSize = 1 double radius")
        .replace("offsets = [(0,0,1)]", "offsets = [(0,0,1)] float newShape = 1")
        .replace("rel camera", "token renderingColorSpace = \"acescg\" rel camera")
        .replace("float[] blendShapeWeights", "float newWeight = 1 float[] blendShapeWeights");
    let said = said(&scene(&others).1);
    for named in ["/ball: newSize", "smile: newShape", "/Render/settings: renderingColorSpace", "/body/walk: newWeight"]
    {
        assert!(said.contains(&format!("{named} is not read")), "{named}\n{said}");
    }
}
