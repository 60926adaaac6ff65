//! `.data` of USC-HairSalon and Hair20K: the number of strands, and for each one the number of its points and these.

use super::Polylines;
use crate::bytes::Bytes;
use crate::error::Error;

/// Reads a file.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<Polylines, Error> {
    let file = Bytes { file: name, bytes };
    let count = file.u32(0, "strands")? as usize;
    // Each strand needs its count.
    if count > bytes.len() / 4 {
        return Err(file.fail(0, format!("{count} strands do not fit in the file of {} bytes", bytes.len())));
    }
    let mut found = Polylines { starts: Vec::with_capacity(count + 1), ..Polylines::default() };
    found.starts.push(0);
    let mut at = 4;
    for _ in 0..count {
        let points = file.u32(at, "number of points")? as usize;
        found.points.extend(file.points(at + 4, points, 12)?);
        at += 4 + 12 * points;
        let end = u32::try_from(found.points.len());
        found.starts.push(end.map_err(|_| file.fail(at, "there are more than 2^32 points"))?);
    }
    match bytes.len() - at {
        0 => Ok(found),
        1 => Err(file.fail(at, "1 byte is left after the last strand")),
        left => Err(file.fail(at, format!("{left} bytes are left after the last strand"))),
    }
}
