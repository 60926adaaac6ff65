//! Transforms, visibility and purpose of prims, inherited from parent to child.

use crate::error::Error;
use crate::read::GROUPS;
use crate::read::context::Reader;
use crate::read::motion::{BENDS, STRAIGHT};
use crate::stage::When;
use crate::warning::Fault;
use glam::{DMat3, DMat4, DQuat, DVec3, DVec4};

/// A prim with its inherited transform and visibility.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    /// The path of the prim.
    pub path: String,
    /// The schema of the prim.
    pub type_name: String,
    /// The transform to world space when the shutter opens.
    pub to_world: DMat4,
    /// The transform to world space when the shutter closes.
    pub moved: DMat4,
    /// Whether the prim is visible, and neither a guide nor a proxy.
    pub shown: bool,
    visible: bool,
    /// Whether the prim or an ancestor could not be read.
    broken: bool,
    purpose: String,
    /// Whether an ancestor is a point instancer, which draws its prototypes itself.
    pub swallowed: bool,
    /// Whether its place may change with time. Known if [`Stage::watch_time`](crate::stage::Stage::watch_time) was
    /// called.
    pub varies: bool,
}

impl Place {
    /// Whether a prim looks the same in another frame. What is below a group has places of its own.
    pub fn is_like(&self, other: &Place) -> bool {
        let of = |place: &Place| (place.to_world, place.moved, place.shown);
        let kind = self.type_name.as_str();
        kind == "Camera" || GROUPS.contains(&kind) || !(self.shown || other.shown) || of(self) == of(other)
    }

    /// Why a prim is not shown, in a few words. `None` if it is shown.
    pub fn hidden(&self) -> Option<String> {
        match (self.shown, self.visible) {
            (true, _) => None,
            (false, false) if self.broken => Some("left out, or below a prim that is".to_owned()),
            (false, false) => Some("invisible".to_owned()),
            (false, true) => Some(format!("purpose {}", self.purpose)),
        }
    }
}

/// All prims of a stage, parents before children.
pub(crate) fn places(reader: &mut Reader, paths: &[String]) -> Result<Vec<Place>, Error> {
    let mut places: Vec<Place> = Vec::with_capacity(paths.len());
    // Indices of the ancestors of the current prim.
    let mut ancestors: Vec<usize> = Vec::new();
    for path in paths {
        let is_ancestor = |&i: &usize| path.strip_prefix(&places[i].path).is_some_and(|rest| rest.starts_with('/'));
        while ancestors.last().is_some_and(|i| !is_ancestor(i)) {
            ancestors.pop();
        }
        let parent = ancestors.last().map(|&i| &places[i]);
        let place = place(reader, path, parent)?;
        ancestors.push(places.len());
        places.push(place);
    }
    Ok(places)
}

/// A prim whose place is not valid is left out, with its descendants.
fn place(reader: &mut Reader, path: &str, parent: Option<&Place>) -> Result<Place, Error> {
    let stage = reader.stage;
    let word = |name| Ok::<_, Error>(stage.words(path, name)?.and_then(|words| words.into_iter().next()));
    let mut read = || {
        stage.forget_time();
        let (local, resets) = local_transform(reader, path, When::Open)?;
        let moves = stage.clock().close != stage.clock().open;
        let moved = if moves { local_transform(reader, path, When::Close)?.0 } else { local };
        if moved != local {
            warn_of_bends(reader, path, &local, &moved)?;
        }
        let is_visible = word("visibility")?.as_deref() != Some("invisible");
        Ok((local, resets, moved, is_visible, word("purpose")?, stage.type_name(path)?))
    };
    let mut broken = parent.is_some_and(|p| p.broken);
    let (local, resets, local_moved, is_visible, purpose, type_name) = match read() {
        Ok(read) => read,
        Err(error) => {
            reader.fault(Fault::Prim, path, error, "it and what is in it are left out")?;
            broken = true;
            (DMat4::IDENTITY, false, DMat4::IDENTITY, false, None, String::new())
        }
    };
    let parent_or = |of: fn(&Place) -> DMat4| parent.filter(|_| !resets).map_or(DMat4::IDENTITY, of);
    let visible = parent.is_none_or(|p| p.visible) && is_visible;
    let inherited = parent.map_or("default".to_owned(), |p| p.purpose.clone());
    let purpose = purpose.unwrap_or(inherited);
    Ok(Place {
        path: path.to_owned(),
        type_name,
        to_world: parent_or(|p| p.to_world) * local,
        moved: parent_or(|p| p.moved) * local_moved,
        shown: visible && !matches!(purpose.as_str(), "guide" | "proxy"),
        visible,
        broken,
        purpose,
        swallowed: parent.is_some_and(|p| p.swallowed || p.type_name == "PointInstancer"),
        varies: stage.varies() || parent.is_some_and(|p| p.varies),
    })
}

/// Adds a warning if a transform is not on the straight line between those at the ends of the shutter.
fn warn_of_bends(reader: &mut Reader, path: &str, open: &DMat4, close: &DMat4) -> Result<(), Error> {
    let clock = reader.stage.clock();
    for share in [0.25, 0.5, 0.75] {
        let time = clock.open + share * (clock.close - clock.open);
        let inner = local_transform(reader, path, When::At(time))?.0;
        let away = inner - (*open + (*close - *open) * share);
        let lengths = |matrix: &DMat4| {
            let linear = DMat3::from_mat4(*matrix).to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
            [linear, matrix.w_axis.truncate().length()]
        };
        let (away, moved, size) = (lengths(&away), lengths(&(*close - *open)), lengths(open));
        if (0..2).any(|i| away[i] > (STRAIGHT * moved[i]).max(1e-5 * size[i])) {
            reader.warnings.add(path, format!("its path {BENDS}"));
            return Ok(());
        }
    }
    Ok(())
}

/// The product of the transform operations of a prim, and whether it ignores the transform of its parent. The last
/// operation applies first.
fn local_transform(reader: &mut Reader, prim: &str, when: When) -> Result<(DMat4, bool), Error> {
    let stage = reader.stage;
    let (mut product, mut resets) = (DMat4::IDENTITY, false);
    for name in stage.words(prim, "xformOpOrder")?.unwrap_or_default() {
        if name == "!resetXformStack!" {
            (product, resets) = (DMat4::IDENTITY, true);
            continue;
        }
        let (name, inverted) = name.strip_prefix("!invert!").map_or((name.as_str(), false), |name| (name, true));
        let Some(numbers) = stage.precise(prim, name, when)? else {
            if !stage.has_property(prim, name)? {
                reader.warnings.add(prim, format!("xformOpOrder names {name}, which does not exist: it is ignored"));
            }
            continue;
        };
        let fail = |what: &str| Error::prim(prim, format!("{name} {what}"));
        let matrix =
            operation(name, &numbers).ok_or_else(|| fail("is not a known transform operation with a valid value"))?;
        if !matrix.is_finite() {
            return Err(fail("must be finite"));
        }
        if matrix.row(3) != DVec4::W {
            return Err(fail("must be affine: its last column must be 0, 0, 0, 1"));
        }
        if inverted && matrix.determinant() == 0.0 {
            return Err(fail("cannot be inverted"));
        }
        product *= if inverted { matrix.inverse() } else { matrix };
    }
    Ok((product, resets))
}

/// The matrix of an operation `xformOp:kind` or `xformOp:kind:suffix` (UsdGeomXformOp). Angles are in degrees.
fn operation(name: &str, numbers: &[f64]) -> Option<DMat4> {
    let kind = name.strip_prefix("xformOp:")?.split(':').next()?;
    let axis = |kind: &str| match kind.chars().last() {
        Some('X') => DVec3::X,
        Some('Y') => DVec3::Y,
        _ => DVec3::Z,
    };
    let turn = |axis: DVec3, degrees: f64| DMat4::from_axis_angle(axis, degrees.to_radians());
    Some(match (kind, numbers) {
        ("transform", numbers) => {
            let numbers: [f64; 16] = numbers.try_into().ok()?;
            // Homogeneous coordinates: a matrix and its multiples are the same transform.
            let w = if numbers[15] == 0.0 { 1.0 } else { numbers[15] };
            DMat4::from_cols_array(&numbers.map(|x| x / w))
        }
        ("translate", &[x, y, z]) => DMat4::from_translation(DVec3::new(x, y, z)),
        ("scale", &[x, y, z]) => DMat4::from_scale(DVec3::new(x, y, z)),
        ("orient", &[x, y, z, w]) => DMat4::from_quat(DQuat::from_xyzw(x, y, z, w).normalize()),
        ("translateX" | "translateY" | "translateZ", &[d]) => DMat4::from_translation(d * axis(kind)),
        ("scaleX" | "scaleY" | "scaleZ", &[s]) => DMat4::from_scale(DVec3::ONE + (s - 1.0) * axis(kind)),
        ("rotateX" | "rotateY" | "rotateZ", &[angle]) => turn(axis(kind), angle),
        ("rotateXYZ" | "rotateXZY" | "rotateYXZ" | "rotateYZX" | "rotateZXY" | "rotateZYX", &[x, y, z]) => {
            // The first axis in the name applies first, so its matrix is the last factor.
            kind["rotate".len()..].chars().fold(DMat4::IDENTITY, |product, axis| {
                let next = match axis {
                    'X' => turn(DVec3::X, x),
                    'Y' => turn(DVec3::Y, y),
                    _ => turn(DVec3::Z, z),
                };
                next * product
            })
        }
        _ => return None,
    })
}

/// The mean scale of a transform (the cube root of its determinant), and whether the scale is uniform to 0.1 %.
pub(crate) fn mean_scale(matrix: &DMat4) -> (f64, bool) {
    let linear = DMat3::from_mat4(*matrix);
    let scale = linear.determinant().abs().cbrt();
    let gram = linear.transpose() * linear;
    let away = gram - DMat3::from_diagonal(DVec3::splat(scale * scale));
    let is_uniform = away.to_cols_array().iter().all(|x| x.abs() <= 2e-3 * scale * scale);
    (if is_rigid(matrix) { 1.0 } else { scale }, is_uniform)
}

/// Whether a matrix is a rotation, a translation or a reflection. Products of rotations in single precision stay within
/// the tolerance.
pub(crate) fn is_rigid(matrix: &DMat4) -> bool {
    let linear = DMat3::from_mat4(*matrix);
    (linear.transpose() * linear - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-5)
}

/// The rotation and translation of a matrix, without scale, shear and reflection.
pub(crate) fn rigid(matrix: &DMat4) -> DMat4 {
    if is_rigid(matrix) && matrix.determinant() > 0.0 {
        return *matrix;
    }
    let z = matrix.z_axis.truncate().normalize_or(DVec3::Z);
    let x = matrix.y_axis.truncate().cross(z).normalize_or(z.any_orthonormal_vector());
    DMat4::from_cols(x.extend(0.0), z.cross(x).extend(0.0), z.extend(0.0), matrix.w_axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn euler_angles_are_applied_in_the_order_of_the_name() {
        let at = |name, angles: [f64; 3]| operation(name, &angles).unwrap().transform_vector3(DVec3::X);
        // x → y by z, then y → z by x.
        assert!(at("xformOp:rotateZXY", [90.0, 0.0, 90.0]).abs_diff_eq(DVec3::Z, 1e-12));
        // x is not moved by x, then x → y by z.
        assert!(at("xformOp:rotateXYZ:second", [90.0, 0.0, 90.0]).abs_diff_eq(DVec3::Y, 1e-12));
        assert!(operation("xformOp:rotateXXY", &[0.0; 3]).is_none());
        assert!(operation("xformOp:scale", &[1.0]).is_none());
    }

    #[test]
    fn scale_and_its_uniformity_are_found_under_rotation() {
        let turn = DMat4::from_rotation_x(0.7) * DMat4::from_rotation_y(0.3);
        let (scale, uniform) = mean_scale(&(turn * DMat4::from_scale(DVec3::splat(-3.0))));
        assert!((scale - 3.0).abs() < 1e-12 && uniform);
        let (scale, uniform) = mean_scale(&(turn * DMat4::from_scale(DVec3::new(1.0, 2.0, 4.0))));
        assert!((scale - 2.0).abs() < 1e-12 && !uniform);
        let camera = turn * DMat4::from_scale(DVec3::new(2.0, 3.0, -4.0));
        assert!(is_rigid(&rigid(&camera)) && rigid(&camera).determinant() > 0.0);
    }
}
