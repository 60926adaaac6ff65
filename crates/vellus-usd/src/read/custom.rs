//! Primvars of curves that rendering does not use, for conversions.

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::layout::Layout;
use crate::stage::{Stage, When};
use vellus_scene::{Custom, CustomValues, Per};

/// The most numbers in a row: those of a matrix.
const MAX_LANES: usize = 16;

/// Reads the primvars of the curves that were read last, and which nobody asked for.
pub(crate) fn read(reader: &mut Reader, prim: &str, layout: &Layout, base: When) -> Result<(), Error> {
    let stage = reader.stage;
    let index = reader.scene.strands.len() - 1;
    let properties = stage.properties(prim)?;
    let names: Vec<String> =
        properties.unread().filter(|name| name.starts_with("primvars:")).map(str::to_owned).collect();
    for full in names.iter().filter(|name| !name.ends_with(":indices")) {
        let name = full.trim_start_matches("primvars:");
        let kept = values(stage, prim, full, base).ok().flatten().and_then(|(values, lanes)| {
            let custom = Custom { strands: index, name: name.to_owned(), per: Per::Set, lanes, values };
            let custom = match stage.integers(prim, &format!("{full}:indices"), base).ok()? {
                Some(indices) => {
                    let rows: Option<Vec<usize>> = indices
                        .iter()
                        .map(|&index| usize::try_from(index).ok().filter(|index| *index < custom.rows()))
                        .collect();
                    custom.with_rows(&rows?)
                }
                None => custom,
            };
            let scope = stage.metadata(prim, full, "interpolation").ok()?;
            let custom = match scope.as_deref() {
                None | Some("constant") => custom,
                Some("uniform") => Custom { per: Per::Strand, ..custom },
                Some("vertex") if custom.rows() == layout.total => {
                    Custom { per: Per::Point, ..custom.with_rows(&layout.rows_of_points()?) }
                }
                // Also varying values of straight curves.
                Some("varying") if custom.rows() == layout.total && layout.basis == vellus_scene::Basis::Linear => {
                    Custom { per: Per::Point, ..custom.with_rows(&layout.rows_of_points()?) }
                }
                _ => return None,
            };
            custom.validate(&reader.scene.strands).is_ok().then_some(custom)
        });
        match kept {
            Some(custom) => {
                stage.know(prim, &[full])?;
                reader.scene.custom.push(custom);
            }
            None => reader.warnings.add(prim, format!("{full} cannot be kept: its values do not fit the strands")),
        }
    }
    Ok(())
}

/// The values of an attribute of any type, and the number of them in a row.
fn values(stage: &Stage, prim: &str, name: &str, when: When) -> Result<Option<(CustomValues, usize)>, Error> {
    if let Ok(Some(words)) = stage.words(prim, name) {
        return Ok(Some((CustomValues::Text(words), 1)));
    }
    if let Ok(Some(whole)) = stage.integers(prim, name, when) {
        let narrow: Option<Vec<i32>> = whole.iter().map(|&x| i32::try_from(x).ok()).collect();
        let wide = || CustomValues::F64(whole.iter().map(|&x| x as f64).collect());
        return Ok(Some((narrow.map_or_else(wide, CustomValues::I32), 1)));
    }
    if let Ok(Some((double, lanes))) = stage.doubles(prim, name, when) {
        return Ok(Some((CustomValues::F64(double), lanes)));
    }
    let single = stage.numbers(prim, name, when)?.filter(|single| (1..=MAX_LANES).contains(&single.lanes));
    Ok(single.map(|single| (CustomValues::F32(single.values), single.lanes)))
}
