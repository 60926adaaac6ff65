//! Curves as sets of strands: widths, texture coordinates, colours, guides and groups.

use super::guides::{self, Bound, Guides};
use super::place::{Place, normal_of};
use super::shape::Shape;
use super::{Reader, Skipped};
use crate::Warning;
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;
use vellus_alembic::{Attribute, Curves, Values as AttributeValues, attributes};
use vellus_scene::{Custom, CustomValues, Parameter, Per, Strands, Values};

/// Attributes with the diameter, before and after the widths of the schema.
const WIDTHS: [&[&str]; 2] = [&["groom_width"], &["width", "widths", "pscale"]];
/// Attributes with the texture coordinates of the roots, before and after those of the schema.
const UV: [&[&str]; 2] = [&["groom_root_uv"], &["uv", "st"]];
/// Attributes with colours.
const COLORS: [&str; 3] = ["groom_color", "Cd", "displayColor"];
/// Attributes with the groups of strands: names, and numbers.
const GROUPS: [&str; 2] = ["groom_group_name", "groom_group_id"];
/// The attribute that says which strands are guides.
const GUIDE: &str = "groom_guide";
/// Attributes that change no picture.
const WITHOUT_EFFECT: [&str; 7] =
    ["groom_version_major", "groom_version_minor", "groom_tool", "groom_properties", "groom_id", "id", "name"];

/// The most sets of strands that the groups of an object become.
const MAX_GROUPS: usize = 64;

/// The strands of an object.
pub(super) struct Found {
    /// Its hair, one set for each group, and the guides that it follows, if it has no motion of its own.
    pub hair: Vec<(Strands, Option<Bound>)>,
    /// Attributes of the hair that rendering does not use, by the indices of the sets.
    pub custom: Vec<Custom>,
    /// Its guides, and whether their numbers are those of the file.
    pub guides: Option<(Guides, bool)>,
}

/// Reads the strands of an object.
pub(super) fn read(reader: &mut Reader, place: &Place) -> Result<Found, Skipped> {
    let archive = reader.archive;
    let object = &archive.objects[place.object];
    if !place.is_regular() {
        return Err(Skipped::part("its transform flattens the strands: no scale may be 0"));
    }
    let [open, close] = reader.times;
    let curves = Curves::read(archive, object, open)?;
    let (sampled, samples) = Curves::sampled(archive, object, open)?.unwrap_or((open, 0));
    let (shape, note) = Shape::new(&curves).map_err(Skipped::part)?;
    reader.note(place, note);
    if shape.strands() == 0 {
        return Err(Skipped::part("it has no curves"));
    }
    let too_many = || Skipped::part("it has more than a billion points");
    let (starts, points) = shape.points(&curves.positions).ok_or_else(too_many)?;
    let mut positions = place.open(&points);
    let moved = if close > open {
        let later = Curves::read(archive, object, close)?;
        let same = later.counts == curves.counts && (later.kind, later.basis) == (curves.kind, curves.basis);
        // Samples of the same curves are more accurate than velocities. Other curves have no motion without them.
        let is_sampled = same && samples > 1;
        let velocities = curves.velocities.as_ref().filter(|_| !is_sampled);
        // What has one sample is there at any time.
        let sampled = if samples > 1 { sampled } else { reader.time };
        let drift = |time: f64, velocities: &[[f32; 3]]| -> Vec<[f32; 3]> {
            let by = (time - sampled) as f32;
            curves.positions.iter().zip(velocities).map(|(p, v)| [0, 1, 2].map(|k| p[k] + by * v[k])).collect()
        };
        if let Some(velocities) = velocities {
            positions = place.open(&shape.points(&drift(open, velocities)).ok_or_else(too_many)?.1);
        }
        let later = match velocities {
            Some(velocities) => Some(drift(close, velocities)),
            None => Some(later.positions).filter(|_| same),
        };
        let later = later.and_then(|later| shape.points(&later));
        later.map(|(_, later)| place.close(&later)).filter(|later| *later != positions)
    } else {
        None
    };

    let (mut known, mut kept) = (Vec::new(), Vec::new());
    for property in attributes(object) {
        let name = property.name.as_str();
        if reader.keeps
            && guides::BOUND.contains(&name)
            && let Ok(attribute) = Attribute::read(archive, property, open)
        {
            kept.extend(custom(&shape, &attribute));
        }
        if name == guides::ID
            && let Ok(attribute) = Attribute::read(archive, property, open)
        {
            known.push(attribute);
        }
        let is_used = WIDTHS.concat().contains(&name)
            || UV.concat().contains(&name)
            || COLORS.contains(&name)
            || GROUPS.contains(&name)
            || name == GUIDE
            || guides::BOUND.contains(&name)
            || own_parameter(name).is_some();
        if !is_used && reader.keeps {
            match Attribute::read(archive, property, open).map(|attribute| custom(&shape, &attribute)) {
                Ok(Some(found)) => kept.push(found),
                _ => reader.note(place, Some(format!("{name} cannot be kept: its values do not fit the strands"))),
            }
            continue;
        }
        if !is_used {
            if !WITHOUT_EFFECT.contains(&name) {
                reader.unknown.insert(property.name.clone());
            }
            continue;
        }
        match Attribute::read(archive, property, open) {
            Ok(attribute) => known.push(attribute),
            Err(error) => reader.note(place, Some(format!("{error}: it is ignored"))),
        }
    }
    let named = |names: &[&str]| names.iter().find_map(|name| known.iter().find(|found| found.name == *name));
    let widths = named(WIDTHS[0]).or(curves.widths.as_ref()).or(named(WIDTHS[1]));
    let radii = radii(reader, place, &shape, &starts, widths)?;
    let uv = named(UV[0]).or(curves.uv.as_ref()).or(named(UV[1]));
    let root_uv = uv.and_then(|uv| root_uv(reader, place, &shape, uv));
    let mut varying: Vec<_> =
        named(&COLORS).and_then(|color| colors(reader, place, &shape, color)).into_iter().collect();
    for attribute in &known {
        let Some(parameter) = own_parameter(&attribute.name) else { continue };
        match own_values(&shape, parameter, attribute) {
            Some(values) => varying.push((parameter, values)),
            None => reader.note(place, Some(misfit(&shape, attribute))),
        }
    }
    let mut all = Strands {
        name: place.path.clone(),
        basis: shape.basis,
        points: positions.iter().zip(radii).map(|(p, radius)| p.extend(radius)).collect(),
        starts,
        moved,
        normals: None,
        root_uv,
        look: 0,
        varying,
    };
    if let Some(found) = &curves.normals {
        let normal = normal_of(&place.to_world);
        all.normals = shape.spread::<3>(found).map(|n| all.at_points(&n).into_iter().map(normal).collect());
        reader.note(place, all.normals.is_none().then(|| misfit(&shape, found)));
    }
    let guides = named(&[GUIDE]).and_then(|guide| each(reader, place, &shape, guide, |row| guide.number(row, 0)));
    let mut guides: Option<Vec<bool>> = guides.map(|all| all.into_iter().map(|guide| guide != 0.0).collect());
    let ids = named(&[guides::ID]);
    let ids = ids.and_then(|ids| each(reader, place, &shape, ids, |row| ids.number(row, 0).map(|id| id as i64)));
    let mut ids = ids.filter(|_| guides.is_some());
    // Hair with motion of its own does not need that of its guides.
    let bound = named(&guides::BOUND[..1]).filter(|_| samples <= 1);
    let mut bound = bound.and_then(|all| {
        let bound = Bound::new(&shape, all, named(&guides::BOUND[1..]));
        reader.note(place, bound.is_none().then(|| misfit(&shape, all)));
        bound
    });
    let mut groups = groups(reader, place, &shape, named(&GROUPS[..1]), named(&GROUPS[1..]));
    let mut is_complete = true;
    if let Some(broken) = all.remove_broken() {
        let is_whole = |strand: usize| broken.strands.binary_search(&strand).is_err();
        fn keep<T>(all: &mut Vec<T>, is_whole: impl Fn(usize) -> bool) {
            let mut strand = 0..;
            all.retain(|_| strand.next().is_some_and(&is_whole));
        }
        guides.iter_mut().for_each(|guides| keep(guides, is_whole));
        ids.iter_mut().for_each(|ids| keep(ids, is_whole));
        groups.iter_mut().for_each(|(groups, _)| keep(groups, is_whole));
        bound = bound.map(|bound| bound.select(is_whole));
        is_complete = false;
        // Their rows do not fit any more.
        kept.retain(|custom: &Custom| custom.per == Per::Set);
        reader.warnings.push(Warning::Broken { strands: place.path.clone(), broken });
    }
    all.validate().map_err(|error| Skipped::part(error.to_string()))?;
    let is_guide = |strand: usize| guides.as_ref().is_some_and(|guides| guides[strand]);
    let mut custom = Vec::new();
    let mut hair = Vec::new();
    let names = groups.as_ref().map_or(&[][..], |(_, names)| names);
    for group in 0..names.len().max(1) {
        let is_own = |strand: usize| groups.as_ref().is_none_or(|(of, _)| of[strand] == group) && !is_guide(strand);
        let own = all.select(|strand| is_own(strand).then_some(1.0));
        if own.is_empty() {
            continue;
        }
        let name = names.get(group).map_or(all.name.clone(), |name| format!("{}/{name}", place.path));
        custom.extend(kept.iter().map(|custom| Custom { strands: hair.len(), ..selected(custom, &all, is_own) }));
        hair.push((Strands { name, ..own }, bound.as_ref().map(|bound| bound.select(is_own))));
    }
    let strands = all.select(|strand| is_guide(strand).then_some(1.0));
    if strands.is_empty() {
        return Ok(Found { hair, custom, guides: None });
    }
    let numbers = |strand: &usize| ids.as_ref().map_or(*strand as i64, |ids| ids[*strand]);
    let own: Vec<usize> = (0..all.len()).filter(|strand| is_guide(*strand)).collect();
    // Guides that are broken at one time have no motion.
    let first = if is_complete && samples > 1 {
        let first = Curves::read(archive, object, f64::NEG_INFINITY)?;
        Some(first.positions).filter(|first| first.len() == curves.positions.len())
    } else {
        None
    };
    let rest = first.and_then(|first| shape.points(&first)).map(|(_, first)| {
        let of = |points: Vec<Vec3>| {
            own.iter().flat_map(|&i| points[all.starts[i] as usize..all.starts[i + 1] as usize].to_vec()).collect()
        };
        [of(place.open(&first)), of(place.close(&first))]
    });
    let guides = Guides { strands, ids: own.iter().map(numbers).collect(), rest };
    Ok(Found { hair, custom, guides: Some((guides, ids.is_some())) })
}

/// An attribute for conversions. `None` if it does not fit the strands.
fn custom(shape: &Shape, attribute: &Attribute) -> Option<Custom> {
    let lanes = attribute.lanes;
    let values = match &attribute.values {
        AttributeValues::Single(values) => CustomValues::F32(values.clone()),
        AttributeValues::Double(values) => CustomValues::F64(values.clone()),
        AttributeValues::Whole(values) => {
            CustomValues::I32(values.iter().map(|x| i32::try_from(*x).ok()).collect::<Option<_>>()?)
        }
        AttributeValues::Text(values) => CustomValues::Text(values.clone()),
    };
    let all = Custom { strands: 0, name: attribute.name.clone(), per: Per::Set, lanes, values };
    let all = match &attribute.indices {
        Some(indices) => {
            let rows: Vec<usize> = indices.iter().map(|index| *index as usize).collect();
            rows.iter().all(|row| *row < all.rows()).then(|| all.with_rows(&rows))?
        }
        None => all,
    };
    match all.rows() {
        1 => Some(all),
        rows if rows == shape.strands() => Some(Custom { per: Per::Strand, ..all }),
        rows if rows == shape.total() => Some(Custom { per: Per::Point, ..all.with_rows(&shape.rows_of_points()?) }),
        _ => None,
    }
}

/// The rows of an attribute that belong to some of the strands.
fn selected(custom: &Custom, all: &Strands, is_own: impl Fn(usize) -> bool) -> Custom {
    let strands = (0..all.len()).filter(|strand| is_own(*strand));
    match custom.per {
        Per::Set => custom.clone(),
        Per::Strand => custom.with_rows(&strands.collect::<Vec<_>>()),
        Per::Point => {
            let points = |strand: usize| all.starts[strand] as usize..all.starts[strand + 1] as usize;
            custom.with_rows(&strands.flat_map(points).collect::<Vec<_>>())
        }
    }
}

/// The radius of each point in world space.
fn radii(
    reader: &mut Reader,
    place: &Place,
    shape: &Shape,
    starts: &[u32],
    widths: Option<&Attribute>,
) -> Result<Vec<f32>, Skipped> {
    let scale = 0.5 * place.scale();
    let spread = widths.and_then(|widths| {
        let spread = shape.spread::<1>(widths);
        reader.note(place, spread.is_none().then(|| misfit(shape, widths)));
        spread
    });
    let Some(spread) = spread else {
        let width = reader.missing.ok_or(Skipped::NoWidth)?;
        return Ok(vec![(scale * f64::from(width)) as f32; starts[starts.len() - 1] as usize]);
    };
    // Beyond a thin tip, a phantom point may have a negative width. A strand with NaN is left out.
    let radius = |[width]: [f32; 1]| if width < 0.0 { 0.0 } else { (scale * f64::from(width)) as f32 };
    Ok(match spread {
        Values::Constant(width) => vec![radius(width); starts[starts.len() - 1] as usize],
        Values::PerStrand(widths) => {
            let of = |(pair, width): (&[u32], [f32; 1])| vec![radius(width); (pair[1] - pair[0]) as usize];
            starts.windows(2).zip(widths).flat_map(of).collect()
        }
        Values::PerPoint(widths) => widths.into_iter().map(radius).collect(),
    })
}

/// The texture coordinates of the roots.
fn root_uv(reader: &mut Reader, place: &Place, shape: &Shape, uv: &Attribute) -> Option<Vec<Vec2>> {
    each(reader, place, shape, uv, |row| Some([uv.number(row, 0)?, uv.number(row, 1)?]))
        .map(|all| all.into_iter().map(|[u, v]| Vec2::new(u as f32, v as f32)).collect())
}

/// Reflectances from colours.
fn colors(
    reader: &mut Reader,
    place: &Place,
    shape: &Shape,
    color: &Attribute,
) -> Option<(Parameter, Values<[f32; 3]>)> {
    let mut spread = shape.spread::<3>(color);
    let is_outside = |row: usize| {
        (0..3).any(|lane| color.number(row, lane).is_some_and(|x| x.is_finite() && !(0.0..=1.0).contains(&x)))
    };
    let outside = (0..color.rows()).any(is_outside);
    let range = Parameter::Reflectance.range();
    let hold = |value: &mut [f32; 3]| {
        value.iter_mut().filter(|x| x.is_finite()).for_each(|x| *x = range.nearest(*x));
    };
    match &mut spread {
        Some(Values::Constant(value)) if value.iter().any(|x| !x.is_finite()) => spread = None,
        Some(Values::Constant(value)) => hold(value),
        Some(Values::PerStrand(all) | Values::PerPoint(all)) => all.iter_mut().for_each(hold),
        None => {}
    }
    let held = outside.then(|| format!("colours of {} outside of [0, 1] are clamped", color.name));
    let note = if spread.is_none() { Some(misfit(shape, color)) } else { held };
    reader.note(place, note);
    spread.map(|values| (Parameter::Reflectance, values))
}

/// The parameter that an attribute is, as [`super::write`] writes it.
fn own_parameter(name: &str) -> Option<Parameter> {
    let name = name.strip_prefix("vellus:")?;
    Parameter::ALL.into_iter().find(|parameter| parameter.varies() && parameter.name() == name)
}

/// The values of a parameter. `None` if they do not fit, or one is out of range.
fn own_values(shape: &Shape, parameter: Parameter, attribute: &Attribute) -> Option<Values<[f32; 3]>> {
    let spread = match parameter.channels() {
        1 => match shape.spread::<1>(attribute)? {
            Values::Constant([x]) => Values::Constant([x; 3]),
            Values::PerStrand(all) => Values::PerStrand(all.into_iter().map(|[x]| [x; 3]).collect()),
            Values::PerPoint(all) => Values::PerPoint(all.into_iter().map(|[x]| [x; 3]).collect()),
        },
        _ => shape.spread::<3>(attribute)?,
    };
    let (range, unit) = (parameter.range(), parameter.unit());
    let stored = |value: [f32; 3]| {
        let is_good = value.iter().all(|x| range.contains(*x));
        is_good.then(|| value.map(|x| unit.to_stored(x)))
    };
    Some(match spread {
        Values::Constant(value) => Values::Constant(stored(value)?),
        Values::PerStrand(all) => Values::PerStrand(all.into_iter().map(stored).collect::<Option<_>>()?),
        // Beyond the ends of splines, values may be out of range: they have no effect there.
        Values::PerPoint(all) => {
            let near = |value: [f32; 3]| value.map(|x| unit.to_stored(range.nearest(x)));
            Values::PerPoint(all.into_iter().map(near).collect())
        }
    })
}

/// The group of each strand, and the names of the groups. `None` if there are no groups.
fn groups(
    reader: &mut Reader,
    place: &Place,
    shape: &Shape,
    names: Option<&Attribute>,
    numbers: Option<&Attribute>,
) -> Option<(Vec<usize>, Vec<String>)> {
    let attribute = names.or(numbers)?;
    let name = |row: usize| match attribute.text(row) {
        Some(name) => Some(name.to_owned()),
        None => Some(format!("group {}", attribute.number(row, 0)? as i64)),
    };
    let of = each(reader, place, shape, attribute, name)?;
    let mut known = BTreeMap::new();
    let mut all = Vec::new();
    for name in &of {
        if known.len() >= MAX_GROUPS && !known.contains_key(name) {
            let what = format!("it has more than {MAX_GROUPS} groups: it is one set of strands");
            reader.note(place, Some(what));
            return None;
        }
        known.entry(name.clone()).or_insert_with(|| {
            all.push(name.clone());
            all.len() - 1
        });
    }
    Some((of.iter().map(|name| known[name]).collect(), all))
}

/// A value for each strand: of an attribute for points, that of the first one.
fn each<T: Clone>(
    reader: &mut Reader,
    place: &Place,
    shape: &Shape,
    attribute: &Attribute,
    value: impl Fn(usize) -> Option<T>,
) -> Option<Vec<T>> {
    let all: Option<Vec<T>> =
        shape.rows_of_roots(attribute.rows()).and_then(|rows| rows.into_iter().map(value).collect());
    reader.note(place, all.is_none().then(|| misfit(shape, attribute)));
    all
}

/// Why an attribute is ignored.
fn misfit(shape: &Shape, attribute: &Attribute) -> String {
    let (rows, lanes) = (attribute.rows(), attribute.lanes);
    let [strands, points] = [shape.strands(), shape.total()];
    let name = &attribute.name;
    format!("{name} has {rows} rows of {lanes}, which do not fit {strands} strands with {points} points: it is ignored")
}
