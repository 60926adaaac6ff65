//! Reads AMD's TressFX `.tfx` files, versions 3 and 4, in little-endian.
//!
//! ```text
//! 0 version f32   4 strands u32   8 points per strand u32
//! version 3: 144 offset of the points (3 × f32)   148 offset of the strands' uv, u32; a header of 296 bytes
//! version 4:  12 offset of the points (4 × f32)    16 offset of the strands' uv, u32; a header of 160 bytes
//! ```

use crate::bytes::{Bytes, given_width};
use crate::error::Error;
use glam::Vec2;
use vellus_scene::{Basis, Strands};

/// Reads the guide strands of a `.tfx` file as [`Basis::Linear`], with the uv of the roots if the file has them.
///
/// `name` is used in messages and becomes the name of the strands. `width` is the diameter in the unit of the file:
/// TressFX itself ignores the widths of the format and leaves them to the application. Fourth coordinates are weights
/// of its simulation and are ignored.
///
/// Strands with coordinates of which nothing can be rendered are there too: [`Strands::remove_broken`] removes them.
///
/// # Errors
/// [`Error::File`] if the file is invalid. [`Error::NoWidth`] if `width` is `None`. [`Error::Width`] if it is not in
/// [0, 2·10⁹].
pub fn read_tfx(bytes: &[u8], name: &str, width: Option<f32>) -> Result<Strands, Error> {
    let width = given_width(width)?;
    let file = Bytes { file: name, bytes };
    let version = file.f32(0, "version")?;
    let (offsets_at, header, stride) = match version {
        v if (3.0..4.0).contains(&v) => (144, 296, 12),
        v if (4.0..5.0).contains(&v) => (12, 160, 16),
        v => return Err(file.fail(0, format!("version {v} of TressFX is not supported: it must be 3 or 4"))),
    };
    file.array(0, 1, header, "header")?;
    let [count, per_strand] = [file.u32(4, "strands")? as usize, file.u32(8, "points per strand")? as usize];
    if per_strand < 2 {
        return Err(file.fail(8, format!("a strand has {per_strand} points: it must have at least 2")));
    }
    let offset = |at: usize, name: &str| match file.u32(at, name)? as usize {
        inside if inside != 0 && inside < header => {
            Err(file.fail(at, format!("the {name} cannot begin at byte {inside}, which is in the header")))
        }
        offset => Ok(offset),
    };
    let points_at = offset(offsets_at, "points")?;
    if points_at == 0 {
        return Err(file.fail(offsets_at, "the file has no points according to its header"));
    }
    let total = count.checked_mul(per_strand).filter(|&n| u32::try_from(n).is_ok());
    let total = total.ok_or_else(|| file.fail(4, format!("{count} strands of {per_strand} points are too many")))?;
    let points = file.points(points_at, total, stride)?;
    let root_uv = match offset(offsets_at + 4, "uv")? {
        0 => None,
        at => {
            let uv = file.floats(at, 2 * count, "uv", |_| true, "")?;
            Some(uv.chunks_exact(2).map(Vec2::from_slice).collect())
        }
    };
    let radius = 0.5 * width.ok_or_else(|| Error::NoWidth { file: name.to_owned() })?;
    Ok(Strands {
        name: name.to_owned(),
        basis: Basis::Linear,
        starts: (0..=count).map(|i| (i * per_strand) as u32).collect(),
        points: points.into_iter().map(|p| p.extend(radius)).collect(),
        moved: None,
        normals: None,
        root_uv,
        look: 0,
        varying: Vec::new(),
    })
}
