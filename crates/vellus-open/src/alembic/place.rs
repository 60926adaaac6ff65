//! Where the objects of an archive are: transforms, visibility and instances.

use glam::{DMat3, DMat4, DVec3, Mat4, Vec3};
use vellus_alembic::{Archive, Error, Visibility, Xform, instance_source, visibility};

/// The most places of objects, and how many instances may be inside each other.
const MAX_PLACES: usize = 1 << 20;
const MAX_NESTED: usize = 16;

/// An object at its place.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// The index of the object.
    pub object: usize,
    /// Its path, for names and messages.
    pub path: String,
    /// To world space when the shutter opens.
    pub to_world: DMat4,
    /// The same when it closes.
    pub moved: DMat4,
    /// In how many instances it is.
    pub nested: usize,
    is_hidden: bool,
}

/// All visible objects that are no transforms, in the order of the file, and what went wrong with others.
pub(super) fn places(archive: &Archive, [open, close]: [f64; 2]) -> (Vec<Place>, Vec<(String, String)>) {
    let (mut places, mut faults) = (Vec::new(), Vec::new());
    let identity = DMat4::IDENTITY;
    let root =
        Place { object: 0, path: String::new(), to_world: identity, moved: identity, nested: 0, is_hidden: false };
    let mut rest = vec![root];
    let mut visited = 0;
    while let Some(mut place) = rest.pop() {
        visited += 1;
        if visited > MAX_PLACES {
            faults.push((place.path, format!("there are more than {MAX_PLACES} objects: others are left out")));
            break;
        }
        let object = &archive.objects[place.object];
        match instance_source(archive, object) {
            Ok(None) => {}
            Ok(Some(source)) => {
                match archive.find(&source) {
                    Some(found) if place.nested < MAX_NESTED => {
                        rest.push(Place { object: found, nested: place.nested + 1, ..place });
                    }
                    Some(_) => {
                        let what = format!("left out: more than {MAX_NESTED} instances are inside each other");
                        faults.push((place.path, what));
                    }
                    None => faults.push((place.path, format!("left out: its source {source} does not exist"))),
                }
                continue;
            }
            Err(error) => faults.push((place.path.clone(), error.to_string())),
        }
        let is_xform = object.schema().is_some_and(|schema| schema.starts_with(Xform::SCHEMA));
        if is_xform && let Err(error) = place.enter(archive, [open, close]) {
            faults.push((place.path, format!("left out with all inside: {error}")));
            continue;
        }
        match visibility(archive, object, open) {
            Ok(Visibility::Inherited) => {}
            Ok(visibility) => place.is_hidden = visibility == Visibility::Hidden,
            Err(error) => faults.push((place.path.clone(), error.to_string())),
        }
        for &child in object.children.iter().rev() {
            let path = format!("{}/{}", place.path, archive.objects[child].name);
            rest.push(Place { object: child, path, ..place.clone() });
        }
        if !is_xform && place.object != 0 && !place.is_hidden {
            places.push(place);
        }
    }
    (places, faults)
}

impl Place {
    fn enter(&mut self, archive: &Archive, [open, close]: [f64; 2]) -> Result<(), Error> {
        let object = &archive.objects[self.object];
        for (matrix, time) in [(&mut self.to_world, open), (&mut self.moved, close)] {
            let xform = Xform::read(archive, object, time)?;
            // Rows of Alembic are columns here: points are on the other side.
            let own = DMat4::from_cols_array_2d(&xform.matrix());
            *matrix = if xform.inherits { *matrix * own } else { own };
        }
        Ok(())
    }

    /// Whether the schema of the object begins with `name`.
    pub fn has_schema(&self, archive: &Archive, name: &str) -> bool {
        archive.objects[self.object].schema().is_some_and(|schema| schema.starts_with(name))
    }

    /// Whether the transforms are finite and have a volume.
    pub fn is_regular(&self) -> bool {
        [self.to_world, self.moved].iter().all(|m| m.is_finite() && m.determinant() != 0.0)
    }

    /// Points in world space when the shutter opens.
    pub fn open(&self, points: &[[f32; 3]]) -> Vec<Vec3> {
        world(&self.to_world, points)
    }

    /// Points in world space when the shutter closes.
    pub fn close(&self, points: &[[f32; 3]]) -> Vec<Vec3> {
        world(&self.moved, points)
    }

    /// The mean scale of the transform.
    pub fn scale(&self) -> f64 {
        let scale = DMat3::from_mat4(self.to_world).determinant().abs().cbrt();
        // Products of rotations are rounded.
        if (scale - 1.0).abs() < 1e-6 { 1.0 } else { scale }
    }
}

fn world(matrix: &DMat4, points: &[[f32; 3]]) -> Vec<Vec3> {
    points.iter().map(|p| matrix.transform_point3(DVec3::from(p.map(f64::from))).as_vec3()).collect()
}

/// Turns a normal into world space. The result has unit length, or is 0.
pub(super) fn normal_of(matrix: &DMat4) -> impl Fn([f32; 3]) -> Vec3 {
    let of_normals = DMat3::from_mat4(*matrix).inverse().transpose();
    move |n| (of_normals * DVec3::from(n.map(f64::from))).normalize_or_zero().as_vec3()
}

/// A rotation and a translation: the transform without its scale.
pub(super) fn rigid(matrix: &DMat4) -> Mat4 {
    let z = matrix.z_axis.truncate().normalize_or(DVec3::Z);
    let x = matrix.y_axis.truncate().cross(z).normalize_or(z.any_orthonormal_vector());
    DMat4::from_cols(x.extend(0.0), z.cross(x).extend(0.0), z.extend(0.0), matrix.w_axis).as_mat4()
}
