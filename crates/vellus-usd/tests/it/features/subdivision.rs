//! Subdivision surfaces.

use super::{said, scene};
use glam::Vec3;

/// A cube of side 2 around the origin.
fn cube(more: &str) -> String {
    format!(
        "def Mesh \"m\" {{
    int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
    int[] faceVertexIndices = [3,2,1,0, 4,5,6,7, 0,1,5,4, 2,3,7,6, 1,2,6,5, 3,0,4,7]
    point3f[] points = [(-1,-1,-1), (1,-1,-1), (1,1,-1), (-1,1,-1), (-1,-1,1), (1,-1,1), (1,1,1), (-1,1,1)]
    {more}
}}"
    )
}

/// The triangles of the only mesh of a stage, and its warnings.
fn read(body: &str) -> (vellus_scene::Mesh, String) {
    let (mut scene, warnings) = scene(body);
    assert_eq!(scene.meshes.len(), 1);
    (scene.meshes.remove(0), said(&warnings))
}

/// The number of vertices at a place.
fn at(mesh: &vellus_scene::Mesh, place: Vec3) -> usize {
    mesh.positions.iter().filter(|p| p.abs_diff_eq(place, 1e-5)).count()
}

/// Without a scheme, a mesh is a Catmull–Clark surface: a corner of the cube goes to half its distance, the middle of
/// a face to 68/81.
#[test]
fn catmull_clark_is_the_default() {
    for scheme in ["", "uniform token subdivisionScheme = \"catmullClark\""] {
        let (mesh, said) = read(&cube(scheme));
        assert_eq!(said, "");
        assert_eq!(at(&mesh, Vec3::splat(0.5)), 1);
        assert_eq!(at(&mesh, Vec3::new(0.0, 0.0, 68.0 / 81.0)), 1);
        // Triangles and normals are seen from outside.
        let normals = mesh.normals.as_ref().unwrap();
        for (triangle, normals) in mesh.triangles.iter().zip(normals) {
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
            let face = (b - a).cross(c - a).normalize();
            assert!(face.dot(a) > 0.0 && normals.iter().all(|n| n.dot(face) > 0.9), "{normals:?} {face}");
        }
    }
    let (mesh, _) = read(&cube("uniform token orientation = \"leftHanded\""));
    let normals = mesh.normals.unwrap();
    assert!(mesh.triangles.iter().zip(normals).all(|(t, n)| n[0].dot(mesh.positions[t[0] as usize]) < 0.0));
}

/// Edges are at most 1/128 of the diagonal long without a camera, and 1/256 of the height of the picture with one.
#[test]
fn edges_are_short_in_the_picture() {
    let (mesh, _) = read(&cube(""));
    // 2 / (√12 / 128) = 73.9, so there are 7 levels, of which 6 are allowed: 6 · 4⁶ quads.
    assert_eq!(mesh.triangles.len(), 2 * 6 * 4096);
    let seen = |distance: f32| {
        let camera = format!(
            "def Camera \"eye\" {{ float focalLength = 50 float verticalAperture = 50
    double3 xformOp:translate = (0, 0, {distance}) uniform token[] xformOpOrder = [\"xformOp:translate\"] }}"
        );
        read(&(cube("") + "\n" + &camera)).0.triangles.len() / 12
    };
    // Edges are 2 long and the picture is as high as the distance. 95 % of the edges are below 2 · 256 / 100 = 5.12 and
    // 2 · 256 / 1000.
    assert_eq!([seen(101.0), seen(1000.0)], [4usize.pow(3), 1]);
}

/// Without a camera, many meshes share the number of faces: a million for 200 meshes are 5,242, of 6 · 4⁴ each.
#[test]
fn many_meshes_share_the_number_of_faces() {
    let hidden = "def Mesh \"h\" { token visibility = \"invisible\" }\n";
    let many: String = (0..199).map(|i| hidden.replace("\"h\"", &format!("\"h{i}\""))).collect();
    let (mesh, said) = read(&(cube("") + "\n" + &many));
    assert_eq!(mesh.triangles.len(), 2 * 6 * 256);
    assert!(said.contains("/m: it is subdivided 4 times instead of 6"), "{said}");
}

/// A mesh of quads that has too many faces already keeps them, and its vertices move to the limit. With heights x² that
/// is x² + h²/3, for a distance h of the vertices.
#[test]
fn a_fine_mesh_keeps_its_faces() {
    const SIDE: usize = 40;
    let hidden: String =
        (0..256).map(|i| format!("def Mesh \"h{i}\" {{ token visibility = \"invisible\" }}\n")).collect();
    let points = |(i, j): (usize, usize)| format!("({i}, {j}, {})", i * i);
    let all = |n: usize| (0..n).flat_map(move |i| (0..n).map(move |j| (i, j)));
    let points: Vec<String> = all(SIDE + 1).map(points).collect();
    let corner = |i: usize, j: usize| i * (SIDE + 1) + j;
    let face =
        |(i, j)| format!("{}, {}, {}, {}", corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
    let faces: Vec<String> = all(SIDE).map(face).collect();
    let text = format!(
        "def Mesh \"m\" {{ int[] faceVertexCounts = [{}] int[] faceVertexIndices = [{}] point3f[] points = [{}] }}",
        vec!["4"; SIDE * SIDE].join(", "),
        faces.join(", "),
        points.join(", ")
    );
    let (mesh, said) = read(&(text + "\n" + &hidden));
    assert!(mesh.triangles.len() == 2 * SIDE * SIDE && said.contains("/m: it is subdivided 0 times"), "{said}");
    for (i, j) in all(SIDE).filter(|(i, j)| (1..SIDE).contains(i) && (1..SIDE).contains(j)) {
        let p = mesh.positions[corner(i, j)];
        let x = i as f32;
        assert!(p.abs_diff_eq(Vec3::new(x, j as f32, x * x + 1.0 / 3.0), 1e-3), "{p}");
    }
}

/// An infinitely sharp edge loop is a cubic B-spline, and has two normals.
#[test]
fn creases_corners_holes_and_borders_are_read() {
    let crease = "int[] creaseIndices = [4, 5, 6, 7, 4] int[] creaseLengths = [5] float[] creaseSharpnesses = [10]";
    let (mesh, said) = read(&cube(crease));
    assert_eq!(said, "");
    assert_eq!(at(&mesh, Vec3::new(2.0 / 3.0, 2.0 / 3.0, 1.0)), 1);
    let upright = |mesh: &vellus_scene::Mesh| {
        let corners = mesh.triangles.iter().zip(mesh.normals.as_ref().unwrap());
        let at = corners.flat_map(|(t, n)| t.iter().zip(n).map(|(v, n)| (mesh.positions[*v as usize], *n)));
        let edge = at.filter(|(p, _)| p.abs_diff_eq(Vec3::new(2.0 / 3.0, 2.0 / 3.0, 1.0), 1e-5));
        let normals: Vec<Vec3> = edge.map(|(_, n)| n).collect();
        (normals.iter().filter(|n| n.z > 0.999).count(), normals.iter().filter(|n| n.z < 0.9).count())
    };
    let (top, side) = upright(&mesh);
    assert!(top > 0 && side > 0, "{top} {side}");

    let corner = "int[] cornerIndices = [6] float[] cornerSharpnesses = [10]";
    assert_eq!(at(&read(&cube(corner)).0, Vec3::ONE), 1);

    let (mesh, _) = read(&cube("int[] holeIndices = [1]"));
    assert_eq!(mesh.triangles.len(), 2 * 5 * 4096);
    assert_eq!(at(&mesh, Vec3::splat(0.5)), 1);

    // Without the top, its border is a spline, its corners stay, or the faces at the border are gone.
    let open = |rule: &str| {
        cube(&format!("uniform token interpolateBoundary = \"{rule}\""))
            .replace("[4, 4, 4, 4, 4, 4]", "[4, 4, 4, 4, 4]")
            .replace("4,5,6,7, ", "")
    };
    assert_eq!(at(&read(&open("edgeOnly")).0, Vec3::new(2.0 / 3.0, 2.0 / 3.0, 1.0)), 1);
    assert_eq!(read(&open("none")).0.triangles.len(), 2 * 4096);

    for (bad, message) in [
        (
            "int[] creaseIndices = [4, 9] int[] creaseLengths = [2] float[] creaseSharpnesses = [1]",
            "creases are incons",
        ),
        ("int[] creaseIndices = [4] int[] creaseLengths = [2] float[] creaseSharpnesses = [1]", "creases are incons"),
        ("int[] cornerIndices = [1, 2, 3] float[] cornerSharpnesses = [1, 2]", "corners are inconsistent"),
        ("uniform token interpolateBoundary = \"some\"", "interpolateBoundary must be none, edgeOnly"),
        ("uniform token subdivisionScheme = \"loop\"", "loop is for triangles"),
        ("uniform token subdivisionScheme = \"butterfly\"", "butterfly is not known"),
    ] {
        let (_, said) = read(&cube(bad));
        assert!(said.contains(message), "{said}");
    }
}

/// Texture coordinates are refined with the surface, and moving points too.
#[test]
fn uv_and_motion_are_refined() {
    let uv = "(0,0), (1,0), (1,1), (0,1), ".repeat(6);
    let uv = format!("texCoord2f[] primvars:st = [{}] (interpolation = \"faceVarying\")", uv.trim_end_matches(", "));
    let motion = "point3f[] points.timeSamples = {
        0: [(-1,-1,-1), (1,-1,-1), (1,1,-1), (-1,1,-1), (-1,-1,1), (1,-1,1), (1,1,1), (-1,1,1)],
        1: [(0,-1,-1), (2,-1,-1), (2,1,-1), (0,1,-1), (0,-1,1), (2,-1,1), (2,1,1), (0,1,1)] }";
    let body = format!(
        "( startTimeCode = 0 endTimeCode = 1 )\n{}\ndef Camera \"c\" {{ double shutter:close = 1
    double3 xformOp:translate = (0, 0, 50) uniform token[] xformOpOrder = [\"xformOp:translate\"] }}",
        cube(&format!("{uv}\n{motion}"))
    );
    let (mesh, said) = read(&body);
    assert_eq!(said, "");
    let moved = mesh.moved.as_ref().unwrap();
    assert!(mesh.positions.iter().zip(moved).all(|(p, q)| (*q - *p).abs_diff_eq(Vec3::X, 1e-5)));
    // Each face has its own square, whose corners stay.
    let all: Vec<[f32; 2]> = mesh.uv.unwrap().iter().flatten().map(|uv| uv.to_array()).collect();
    for corner in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        assert!(all.contains(&corner), "{corner:?}");
    }
    assert!(all.as_flattened().iter().all(|x| (0.0..=1.0).contains(x)));
}

/// Plane faces of a bilinear surface are the polygons themselves.
#[test]
fn bilinear_surfaces_are_refined_where_they_bend() {
    let bilinear = "uniform token subdivisionScheme = \"bilinear\" normal3f[] normals = [(1,0,0)]
    ( interpolation = \"constant\" )";
    let (mesh, said) = read(&cube(bilinear));
    assert_eq!((mesh.triangles.len(), mesh.normals, said.as_str()), (12, None, ""));
    let bent = cube(bilinear).replace("(1,1,1)", "(1,1,2)");
    let (mesh, _) = read(&bent);
    // The middle of the bent face is the mean of its corners.
    assert_eq!(at(&mesh, Vec3::new(0.0, 0.0, 1.25)), 1);
}

/// Without a camera, edges need not be shorter than 1/512 of the diagonal of all meshes, by their `extent`.
#[test]
fn a_small_mesh_of_a_large_stage_has_few_faces() {
    let ground = "def Mesh \"ground\" { uniform token subdivisionScheme = \"none\" int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2] point3f[] points = [(-500,0,-500), (500,0,-500), (0,0,500)]
        float3[] extent = [(-500,0,-500), (500,0,500)] }";
    let triangles = |size: &str| {
        let (scene, _) = scene(&(cube("") + "\n" + &ground.replace("500", size)));
        scene.meshes[0].triangles.len() / 12
    };
    // √2 · 1000 / 512 = 2.8 is more than an edge, and √2 · 100 / 512 = 0.28 is an eighth.
    assert_eq!([triangles("500"), triangles("50")], [1, 4usize.pow(3)]);
}
