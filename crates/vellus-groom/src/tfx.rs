//! AMD's TressFX `.tfx` files, versions 3 and 4, little-endian.
//!
//! ```text
//! 0 version f32   4 strands u32   8 points a strand u32
//! version 3: 144 offset of the points (3 × f32)   148 offset of the strands' uv, u32; a header of 296 bytes
//! version 4:  12 offset of the points (4 × f32)    16 offset of the strands' uv, u32; a header of 160 bytes
//! ```

use crate::bytes::{Bytes, given_width};
use crate::error::Error;
use glam::Vec2;
use vellus_scene::{Basis, Strands};

/// The guide strands of a `.tfx` file, as [`Basis::Linear`], with the roots' uv if it has them. `name` is for
/// messages and becomes the strands' name; `width` is the diameter, in the file's unit of length. TressFX leaves
/// widths to the application (it does not read those the format has a place for), and fourth coordinates are weights
/// of its simulation.
///
/// # Errors
/// [`Error::File`] says what is wrong and where; [`Error::NoWidth`] if no width is given; [`Error::Width`].
pub fn read_tfx(bytes: &[u8], name: &str, width: Option<f32>) -> Result<Strands, Error> {
    let width = given_width(width)?;
    let file = Bytes { file: name, bytes };
    let version = file.f32(0, "version")?;
    let (offsets_at, header, stride) = match version {
        v if (3.0..4.0).contains(&v) => (144, 296, 12),
        v if (4.0..5.0).contains(&v) => (12, 160, 16),
        v => return Err(file.fail(0, format!("version {v} of TressFX is unknown: 3 and 4 are read"))),
    };
    file.array(0, 1, header, "header")?;
    let [count, per_strand] = [file.u32(4, "strands")? as usize, file.u32(8, "points a strand")? as usize];
    if per_strand < 2 {
        return Err(file.fail(8, format!("a strand has {per_strand} points: it must have at least 2")));
    }
    let offset = |at: usize, name: &str| match file.u32(at, name)? as usize {
        inside if inside != 0 && inside < header => {
            Err(file.fail(at, format!("the {name} cannot begin at byte {inside}, within the header")))
        }
        offset => Ok(offset),
    };
    let points_at = offset(offsets_at, "points")?;
    if points_at == 0 {
        return Err(file.fail(offsets_at, "the file says that it has no points"));
    }
    let total = count.checked_mul(per_strand).filter(|&n| u32::try_from(n).is_ok());
    let total = total.ok_or_else(|| file.fail(4, format!("{count} strands of {per_strand} points are too many")))?;
    let points = file.points(points_at, total, stride)?;
    let root_uv = match offset(offsets_at + 4, "uv")? {
        0 => None,
        at => {
            let uv = file.floats(at, 2 * count, "uv", f32::is_finite, "one must be finite")?;
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
        root_uv,
        look: 0,
        varying: Vec::new(),
    })
}
