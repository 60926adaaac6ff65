//! Meshes and their surfaces.

use super::{said, scene};
use crate::common::{read, told};
use glam::{Vec2, Vec3};
use vellus_scene::{Scene, Wrap};
use vellus_usd::Options;

#[test]
fn polygons_become_triangles_with_their_corners() {
    let quad = |attributes: &str| {
        let body = format!(
            "def Mesh \"m\" {{
    uniform token subdivisionScheme = \"none\"
    int[] faceVertexCounts = [4, 3]
    int[] faceVertexIndices = [0, 1, 2, 3, 0, 2, 4]
    point3f[] points = [(0,0,0), (1,0,0), (1,1,0), (0,1,0), (0,0,1)]
    {attributes}
}}"
        );
        scene(&body)
    };
    let (scene, warnings) = quad(
        "normal3f[] normals = [(0,0,1), (0,0,1), (0,0,1), (0,1,0), (1,0,0)] (interpolation = \"vertex\")
    texCoord2f[] primvars:st = [(0,0), (1,0)] (interpolation = \"faceVarying\")
    int[] primvars:st:indices = [0, 0, 0, 1, 0, 0, 1]
    color3f[] primvars:displayColor = [(0.1, 0.2, 0.3)]",
    );
    assert_eq!(said(&warnings), "");
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 2, 4]]);
    assert_eq!(mesh.normals.as_ref().unwrap()[1], [Vec3::Z, Vec3::Z, Vec3::Y]);
    assert_eq!(mesh.uv.as_ref().unwrap()[1..], [[Vec2::ZERO, Vec2::ZERO, Vec2::X]; 2]);
    assert_eq!(scene.surfaces[mesh.surface].color.color, [0.1, 0.2, 0.3]);
    let (scene, _) = quad("uniform token orientation = \"leftHanded\" int[] holeIndices = [1]");
    assert_eq!(scene.meshes[0].triangles, [[0, 2, 1], [0, 3, 2]]);
    let mirror = "float3 xformOp:scale = (-2, 1, 1) uniform token[] xformOpOrder = [\"xformOp:scale\"]
    normal3f[] normals = [(0.6,0.8,0), (0,0,1), (0,0,1), (0,1,0), (1,0,0)]";
    let (scene, _) = quad(mirror);
    assert_eq!(scene.meshes[0].triangles[0], [0, 2, 1]);
    // If a slope is stretched along x, its normal turns away from x.
    let expected = Vec3::new(-0.3, 0.8, 0.0).normalize();
    assert!(scene.meshes[0].normals.as_ref().unwrap()[0][0].abs_diff_eq(expected, 1e-6));
}

#[test]
fn surfaces_read_preview_surfaces_and_their_textures() {
    let folder = tempfile::tempdir().unwrap();
    let mut encoder = png::Encoder::new(std::fs::File::create(folder.path().join("hide.png")).unwrap(), 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 51, 0]).unwrap();
    let stage = |file: &str, output: &str| {
        let body = format!(
            "#usda 1.0
def Mesh \"m\" {{
    int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0,0,0), (1,0,0), (1,1,0)]
    uniform token subdivisionScheme = \"none\"
    rel material:binding = </Hide>
}}
def Material \"Hide\" {{
    token inputs:wrap = \"clamp\"
    token outputs:surface.connect = </Hide/Graph.outputs:out>
    def NodeGraph \"Graph\" {{
        token outputs:out.connect = </Hide/Graph/Surface.outputs:surface>
        def Shader \"Surface\" {{
            uniform token info:id = \"UsdPreviewSurface\"
            color3f inputs:diffuseColor.connect = </Hide/Graph/Image.outputs:{output}>
            color3f inputs:emissiveColor = (0, 1, 2)
            float inputs:roughness = 0.25
            float inputs:metallic = 1
            float inputs:opacity = 0.5
            token outputs:surface
        }}
        def Shader \"Image\" {{
            uniform token info:id = \"UsdUVTexture\"
            asset inputs:file = @{file}@
            token inputs:sourceColorSpace = \"raw\"
            float4 inputs:scale = (0.5, 0.25, 1, 1)
            token inputs:wrapS = \"mirror\"
            token inputs:wrapT.connect = </Hide.inputs:wrap>
        }}
    }}
}}"
        );
        let path = folder.path().join("stage.usda");
        std::fs::write(&path, body).unwrap();
        read(&path, &Options::default())
    };
    let (scene, warnings) = stage("./hide.png", "rgb").unwrap();
    let surface = &scene.surfaces[0];
    assert_eq!((surface.color.color, surface.color.texture), ([0.5, 0.25, 1.0], Some(0)));
    assert_eq!((surface.emission, surface.roughness, surface.metallic, surface.ior), ([0.0, 1.0, 2.0], 0.25, 1.0, 1.5));
    assert_eq!((scene.textures[0].name.as_str(), scene.textures[0].pixels.get(0)), ("hide.png", [1.0, 0.2, 0.0]));
    assert_eq!(scene.textures[0].wrap, [Wrap::Mirror, Wrap::Clamp]);
    assert_eq!((surface.opacity.value, surface.opacity.texture, warnings.len()), (0.5, None, 1), "{}", said(&warnings));
    let (scene, _) = stage("hide.png", "g").unwrap();
    assert_eq!((scene.surfaces[0].color.color, scene.textures[0].pixels.get(0)), ([0.25; 3], [0.2; 3]));
    let error = told(stage("./none.png", "rgb"));
    assert!(error.contains("/Hide/Graph/Image") && error.contains("./none.png does not exist"), "{error}");
    std::fs::write(folder.path().join("text.png"), "no image").unwrap();
    let error = told(stage("./text.png", "rgb"));
    assert!(error.contains("text.png: it is no PNG"), "{error}");
}

/// A pentagon with a notch, an arrow, and a bow tie: the first two have their areas, 2.5 and 0.5.
#[test]
fn concave_faces_do_not_leave_their_outlines() {
    for (orientation, up) in [("rightHanded", 1.0), ("leftHanded", -1.0)] {
        let (scene, warnings) = scene(&format!(
            "def Mesh \"m\" {{
    uniform token subdivisionScheme = \"none\" uniform token orientation = \"{orientation}\"
    int[] faceVertexCounts = [5, 4, 4] int[] faceVertexIndices = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]
    point3f[] points = [(0,0,0), (2,0,0), (2,0,-2), (1,0,-0.5), (0,0,-2),
        (0,0,0), (2,0,1), (0.5,0,0), (2,0,-1), (0,0,0), (2,0,-2), (2,0,0), (0,0,-1)]
}}"
        ));
        assert!(said(&warnings).contains("/m: 1 of its 3 faces cross themselves"), "{warnings:?}");
        let mesh = &scene.meshes[0];
        let normal = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            0.5 * up * (b - a).cross(c - a).y
        };
        let normals: Vec<f32> = mesh.triangles.iter().map(normal).collect();
        assert!(normals[..5].iter().all(|area| *area > 0.0), "{normals:?}");
        assert_eq!((normals[..3].iter().sum::<f32>(), normals[3..5].iter().sum::<f32>()), (2.5, 0.5));
    }
}

#[test]
fn wrong_normals_and_coordinates_do_not_hide_a_mesh() {
    let (scene, warnings) = scene(
        "def Mesh \"m\" { uniform token subdivisionScheme = \"none\" int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2] point3f[] points = [(0,0,0), (1,0,0), (0,1,0)]
            normal3f[] normals = [(0,0,1), (0,0,1)]
            texCoord2f[] primvars:st = [] (interpolation = \"faceVarying\") }",
    );
    assert_eq!((scene.meshes[0].triangles.len(), &scene.meshes[0].normals), (1, &None));
    let said = said(&warnings);
    assert!(said.contains("normals has 2 values") && said.contains("primvars:st has 0 values"), "{said}");
}

/// Colours of two faces, of four points, and of points on a subdivision surface with a hole.
#[test]
fn display_colors_vary_over_a_mesh() {
    let mesh = |scheme: &str, colors: &str| {
        scene(&format!(
            "( )
def Mesh \"m\" {{ uniform token subdivisionScheme = \"{scheme}\"
    int[] faceVertexCounts = [3, 3] int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
    point3f[] points = [(0,0,0), (1,0,0), (1,1,0), (0,1,0)]
    color3f[] primvars:displayColor = {colors} }}"
        ))
    };
    let looked_up = |scene: &Scene, triangle: usize, weights: [f32; 3]| {
        let mesh = &scene.meshes[0];
        let corners = mesh.uv.as_ref().unwrap()[triangle];
        let uv = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        scene.textures[scene.surfaces[mesh.surface].color.texture.unwrap()].at(uv)
    };
    let near = |a: [f32; 3], b: [f32; 3]| assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5), "{a:?} {b:?}");
    let (found, warnings) = mesh("none", "[(1, 0, 0), (0, 0.5, 0)] ( interpolation = \"uniform\" )");
    assert!(warnings.is_empty(), "{}", said(&warnings));
    near(looked_up(&found, 0, [0.2, 0.3, 0.5]), [1.0, 0.0, 0.0]);
    near(looked_up(&found, 1, [0.2, 0.3, 0.5]), [0.0, 0.5, 0.0]);
    let values = "[(0.5, 0.5, 0.5), (0.5, 0.25, 0.5), (0.5, 0.5, 0.5), (1, 0.5, 0.25)] ( interpolation = \"vertex\" )";
    let (found, warnings) = mesh("none", values);
    assert!(warnings.is_empty(), "{}", said(&warnings));
    near(looked_up(&found, 0, [0.5, 0.5, 0.0]), [0.5, 0.375, 0.5]);
    near(looked_up(&found, 1, [0.0, 0.5, 0.5]), [0.75, 0.5, 0.375]);
    // Bilinear refinement keeps the colours at the points, and between them.
    let (found, _) = mesh("bilinear", values);
    let mesh = &found.meshes[0];
    for (triangle, points) in mesh.triangles.iter().enumerate() {
        for (corner, point) in points.iter().enumerate() {
            let Vec3 { x, y, .. } = mesh.positions[*point as usize];
            let red = 0.5 + 0.5 * (y - x).max(0.0);
            let weights = std::array::from_fn(|k| f32::from(u8::from(k == corner)));
            assert!((looked_up(&found, triangle, weights)[0] - red).abs() < 1e-5, "{x} {y}");
        }
    }
}

/// Three squares: one of the mesh's own material, one of a subset, and one that is invisible. Parts have the vertices
/// that they need. Faces keep their parts when they are refined.
#[test]
fn parts_of_a_mesh_have_materials_of_their_own() {
    let stage = |scheme: &str, subset: &str| {
        scene(&format!(
            "( )
def Mesh \"m\" {{ uniform token subdivisionScheme = \"{scheme}\"
    int[] faceVertexCounts = [4, 4, 4] int[] faceVertexIndices = [0, 1, 2, 3, 1, 4, 5, 2, 4, 6, 7, 5]
    point3f[] points = [(0,0,0), (1,0,0), (1,1,0), (0,1,0), (2,0,0), (2,1,0), (3,0,0), (3,1,0)]
    rel material:binding = </Red>
    def GeomSubset \"blue\" {{ {subset} rel material:binding = </Blue> }}
    def GeomSubset \"glass\" {{ int[] indices = [2] rel material:binding = </Glass> }}
    def GeomSubset \"same\" {{ int[] indices = [2] rel material:binding = </Red> }}
}}
def Material \"Red\" {{ token outputs:surface.connect = </Red/s.outputs:out>
    def Shader \"s\" {{ uniform token info:id = \"UsdPreviewSurface\" color3f inputs:diffuseColor = (1, 0, 0) }} }}
def Material \"Blue\" {{ token outputs:surface.connect = </Blue/s.outputs:out>
    def Shader \"s\" {{ uniform token info:id = \"UsdPreviewSurface\" color3f inputs:diffuseColor = (0, 0, 1) }} }}
def Material \"Glass\" {{ token outputs:surface.connect = </Glass/s.outputs:out>
    def Shader \"s\" {{ uniform token info:id = \"UsdPreviewSurface\" float inputs:opacity = 0 }} }}"
        ))
    };
    for (scheme, triangles) in [("none", 2), ("bilinear", 2), ("catmullClark", 2 * 4 * 4)] {
        let (found, warnings) = stage(scheme, "uniform token elementType = \"face\" int[] indices = [1]");
        let said = said(&warnings);
        assert!(warnings.len() == 1 && said.contains("/glass: inputs:opacity of its material is 0"), "{said}");
        let [red, blue] = &found.meshes[..] else { panic!("{} meshes", found.meshes.len()) };
        let color = |mesh: &vellus_scene::Mesh| found.surfaces[mesh.surface].color.color;
        assert_eq!((color(red), color(blue)), ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]));
        assert!(red.triangles.len() >= triangles && red.triangles.len() == blue.triangles.len(), "{scheme}");
        let across = |mesh: &vellus_scene::Mesh| {
            mesh.positions.iter().map(|p| p.x).fold([9.0f32, -9.0], |[a, b], x| [a.min(x), b.max(x)])
        };
        // The limit of a boundary's corner is inside.
        let near = |found: [f32; 2], expected: [f32; 2]| (0..2).all(|k| (found[k] - expected[k]).abs() < 0.2);
        assert!(
            near(across(red), [0.0, 1.0]) && near(across(blue), [1.0, 2.0]),
            "{:?} {:?}",
            across(red),
            across(blue)
        );
    }
    for broken in
        ["int[] indices = [3]", "int[] indices = [-1]", "uniform token elementType = \"point\" int[] indices = [1]"]
    {
        let (found, warnings) = stage("none", broken);
        assert!(said(&warnings).contains("/m/blue: its material is ignored: its indices must be faces"), "{broken}");
        assert_eq!((found.meshes.len(), found.meshes[0].triangles.len()), (1, 4));
    }
}
