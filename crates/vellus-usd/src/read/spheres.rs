//! Points (UsdGeomPoints) as spheres: instances of one mesh.

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::instances::add;
use crate::read::mesh::show;
use crate::read::motion::{Points, points};
use crate::read::primvar::{Interpolation, primvar};
use crate::read::shapes::sphere;
use crate::read::surface::surface;
use crate::read::xform::Place;
use glam::{DMat4, DQuat, DVec3};
use vellus_scene::Prototype;

/// Reads the points of a prim.
pub(crate) fn read(reader: &mut Reader, place: &Place) -> Result<(), Error> {
    let prim = place.path.as_str();
    let handle = reader.prim(prim)?;
    let Points { open, close, base } = points(reader, handle, &[])?;
    reader.stage.know(prim, &["ids", "widths", "normals"])?;
    let mut found = None;
    for name in ["primvars:widths", "widths"] {
        found = found.or(primvar(reader.stage, prim, name, Interpolation::Vertex, base)?);
    }
    let widths = match found.map(|widths| widths.values.values) {
        Some(widths) if widths.len() == 1 || widths.len() == open.len() => widths,
        Some(widths) => {
            return Err(handle.error(format!("it has {} widths, but {} points", widths.len(), open.len())));
        }
        None => {
            reader.warnings.add(prim, "its points have no widths: they are spheres with the diameter 1");
            vec![1.0]
        }
    };
    if !reader.options.instances {
        reader.warnings.add(prim, "its points are left out, because instances are copied here");
        return Ok(());
    }
    if close.is_some_and(|close| close != open) {
        reader.warnings.add(prim, "its points do not move while the shutter is open");
    }
    let Some(surface) = surface(reader, prim)? else { return Ok(()) };
    let first = reader.scene.meshes.len();
    let mut local = place.clone();
    (local.to_world, local.moved) = (DMat4::IDENTITY, DMat4::IDENTITY);
    show(reader, &local, false, sphere(), &[Some(surface)])?;
    let meshes = reader.scene.meshes.split_off(first);
    let name = reader.name(prim)?;
    reader.scene.prototypes.push(Prototype { name, strands: Vec::new(), meshes });
    let prototype = reader.scene.prototypes.len() - 1;
    let mut left_out = 0;
    for (i, point) in open.iter().enumerate() {
        let radius = 0.5 * f64::from(widths[i.min(widths.len() - 1)]);
        let center = DVec3::from(point.map(f64::from));
        if !(center.is_finite() && radius.is_finite() && radius >= 0.0) {
            left_out += 1;
        } else if radius > 0.0 {
            let ball = DMat4::from_scale_rotation_translation(DVec3::splat(radius), DQuat::IDENTITY, center);
            add(reader, prim, prototype, &(place.to_world * ball))?;
        }
    }
    if left_out > 0 {
        let what =
            format!("{left_out} of {} points are left out: they are not finite, or have such widths", open.len());
        reader.warnings.add(prim, what);
    }
    Ok(())
}
