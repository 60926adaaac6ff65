//! Reads strands (UsdGeomCurves).

use crate::error::Error;
use crate::read::context::{BoundLook, Reader};
use crate::read::custom;
use crate::read::layout::{Ends, Layout};
use crate::read::look::{FALLBACK_LOOK, SHADER, channels, look};
use crate::read::motion::{Points, points};
use crate::read::nurbs::Nurbs;
use crate::read::primvar::{Interpolation, Primvar, ancestors, inherited, primvar};
use crate::read::xform::{Place, mean_scale};
use crate::stage::{Stage, When};
use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};
use vellus_scene::{Basis, MAX_COORDINATE, Parameter, Strands, Values};

/// The largest width, in scene units.
pub(crate) const MAX_WIDTH: f32 = 2.0 * MAX_COORDINATE;

/// Primvars that may have the texture coordinates of the roots. Blender writes the last one.
const ROOT_UV: [&str; 3] = ["primvars:st", "primvars:uv", "primvars:surface_uv_coordinate"];

/// Reads the curves of a prim. Unsupported kinds of curves give a warning and nothing else.
pub(crate) fn read(reader: &mut Reader, place: &Place) -> Result<(), Error> {
    let prim = place.path.as_str();
    let is_hermite = place.type_name == "HermiteCurves";
    let is_nurbs = place.type_name == "NurbsCurves";
    let Some((basis, ends)) =
        (if is_hermite || is_nurbs { Some((Basis::Bezier, Ends::Open)) } else { kind(reader, prim)? })
    else {
        return Ok(());
    };
    if place.to_world.determinant() == 0.0 || place.moved.determinant() == 0.0 {
        return Err(Error::prim(
            prim,
            "its transform flattens the strands: no scale of the prim or of its ancestors may be 0",
        ));
    }
    let Points { mut open, mut close, base } = points(reader, reader.prim(prim)?, &["curveVertexCounts"])?;
    let mut counts = reader.stage.integers(prim, "curveVertexCounts", base)?.unwrap_or_default();
    if is_hermite {
        // Checks the counts.
        Layout::new(prim, Basis::Linear, ends, &counts, open.len())?;
        let when = if close.is_some() { When::Close } else { base };
        close = close.map(|close| handles(reader.stage, prim, &counts, &close, when)).transpose()?;
        open = handles(reader.stage, prim, &counts, &open, base)?;
        counts.iter_mut().for_each(|count| *count = (3 * *count - 2).max(0));
    }
    let mut nurbs = None;
    if is_nurbs {
        let found = Nurbs::read(reader.stage, prim, &counts, open.len(), base)?;
        (open, close, counts) = (found.points(&open), close.map(|close| found.points(&close)), found.counts());
        nurbs = Some(found);
    }
    let layout =
        Layout { at_knots: is_hermite || is_nurbs, nurbs, ..Layout::new(prim, basis, ends, &counts, open.len())? };
    if layout.counts.is_empty() {
        reader.warnings.add(prim, "it has no curves");
        return Ok(());
    }
    let radii = radii(reader, place, &layout, base)?;
    warn_of_widths(reader, prim, base)?;
    let opened = to_world(&layout, &open, &place.to_world);
    let moved = close.map(|close| to_world(&layout, &close, &place.moved)).filter(|closed| *closed != opened);
    let starts = layout.starts();
    let mut all = Vec::with_capacity(opened.len());
    for (strand, ends) in starts.windows(2).enumerate() {
        for point in ends[0] as usize..ends[1] as usize {
            all.push(opened[point].extend(match &radii {
                Values::Constant([radius]) => *radius,
                Values::PerStrand(radii) => radii[strand][0],
                // Extrapolation beyond a thin tip may give a negative radius.
                Values::PerPoint(radii) => {
                    if radii[point][0] < 0.0 {
                        0.0
                    } else {
                        radii[point][0]
                    }
                }
            }));
        }
    }
    let bound = look(reader, prim)?;
    if reader.scene.looks[bound.look].name == FALLBACK_LOOK {
        let opacity = inherited(reader.stage, prim, "primvars:displayOpacity", base)?;
        if opacity.is_some_and(|opacity| opacity.values.values.iter().any(|x| *x < 1.0)) {
            reader.warnings.add(prim, "strands are opaque: primvars:displayOpacity is ignored");
        }
    }
    let root_uv = match root_uv(reader, prim, &layout, &bound, base) {
        Ok(uv) => uv,
        Err(error) => {
            reader.ignore(prim, error)?;
            None
        }
    };
    if root_uv.is_none() && !reader.scene.looks[bound.look].textured.is_empty() {
        let set = bound.uv.as_deref().unwrap_or("st");
        let what = format!("its material has textures, but it has no primvars:{set}: all strands have one texel");
        reader.warnings.add(prim, what);
    }
    let varying = varying(reader, prim, &layout, &bound, base)?;
    let mut strands = Strands {
        // The path, for the messages of the validation.
        name: prim.to_owned(),
        basis,
        starts,
        points: all,
        moved,
        normals: None,
        root_uv,
        look: bound.look,
        varying,
    };
    match normals(reader, place, &layout, base) {
        Ok(found) => strands.normals = found.map(|normals| strands.at_points(&normals)),
        Err(error) => reader.ignore(prim, error)?,
    }
    if let Some(broken) = strands.remove_broken() {
        // Blender writes NaN handles for curves without handles.
        let has_nan = basis == Basis::Bezier && open.as_flattened().iter().any(|x| x.is_nan());
        let hint = " (re-export the curves as Catmull-Rom: Blender writes Bézier handles that are NaN)";
        reader.warnings.add(prim, format!("{broken}{}", if has_nan { hint } else { "" }));
        if strands.is_empty() {
            return Ok(());
        }
    }
    strands.name = reader.name(prim)?;
    reader.scene.strands.push(strands);
    if reader.options.custom { custom::read(reader, prim, &layout, base) } else { Ok(()) }
}

/// The points of Bézier curves that are Hermite curves: a handle is a third of a tangent away from its point.
fn handles(stage: &Stage, prim: &str, counts: &[i64], points: &[[f32; 3]], when: When) -> Result<Vec<[f32; 3]>, Error> {
    let tangents = stage.numbers(prim, "tangents", when)?.map_or(Vec::new(), |numbers| numbers.values);
    if tangents.len() != 3 * points.len() {
        let what = format!("it has {} tangents, but {} points", tangents.len() / 3, points.len());
        return Err(Error::prim(prim, what));
    }
    let handle = |i: usize, share: f32| std::array::from_fn(|c| points[i][c] + share * tangents[3 * i + c]);
    let mut all = Vec::with_capacity(3 * points.len());
    let mut first = 0;
    for &count in counts {
        let next = first + usize::try_from(count).unwrap_or(0);
        for i in first..next {
            if i > first {
                all.push(handle(i, -1.0 / 3.0));
            }
            all.push(points[i]);
            if i + 1 < next {
                all.push(handle(i, 1.0 / 3.0));
            }
        }
        first = next;
    }
    Ok(all)
}

/// The basis of curves, and how their ends are treated. `None` with a warning if they are not supported.
fn kind(reader: &mut Reader, path: &str) -> Result<Option<(Basis, Ends)>, Error> {
    let prim = reader.prim(path)?;
    let word = |name: &str, fallback: &str| -> Result<String, Error> {
        Ok(prim.token(name)?.unwrap_or_else(|| fallback.to_owned()))
    };
    let (kind, basis, wrap) = (word("type", "cubic")?, word("basis", "bezier")?, word("wrap", "nonperiodic")?);
    let ends = match wrap.as_str() {
        "nonperiodic" => Ends::Open,
        "pinned" => Ends::Pinned,
        "periodic" => Ends::Closed,
        _ => return Err(prim.error(format!("wrap is {wrap}: it must be nonperiodic, periodic or pinned"))),
    };
    // Other curves interpolate their ends anyway.
    let unpinned = if ends == Ends::Pinned { Ends::Open } else { ends };
    match (kind.as_str(), basis.as_str()) {
        // Blender does not reset the basis of linear curves, so it has no meaning here.
        ("linear", _) => Ok(Some((Basis::Linear, unpinned))),
        ("cubic", "bezier") => Ok(Some((Basis::Bezier, unpinned))),
        ("cubic", "bspline") => Ok(Some((Basis::BSpline, ends))),
        ("cubic", "catmullRom") => Ok(Some((Basis::CatmullRom, ends))),
        ("cubic", "hermite" | "power") => {
            reader.left_out.insert(path.to_owned());
            reader.warnings.add(path, format!("curves of the basis {basis} are not supported and are ignored"));
            Ok(None)
        }
        ("cubic", _) => Err(prim.error(format!("basis is {basis}: it must be bezier, bspline or catmullRom"))),
        _ => Err(prim.error(format!("type is {kind}: it must be linear or cubic"))),
    }
}

/// Control points in world space, with phantom points.
fn to_world(layout: &Layout, points: &[[f32; 3]], matrix: &DMat4) -> Vec<Vec3> {
    // The identity is exact: it multiplies by 1 and adds 0.
    let place = |p: [f32; 3]| matrix.transform_point3(DVec3::from(p.map(f64::from))).as_vec3();
    layout.points(points, false).into_iter().map(place).collect()
}

/// Radii in world space: half the widths.
fn radii(reader: &mut Reader, place: &Place, layout: &Layout, base: When) -> Result<Values<[f32; 1]>, Error> {
    let prim = place.path.as_str();
    let (scale, is_uniform) = mean_scale(&place.to_world);
    reader.stage.know(prim, &["widths"])?;
    for name in ["primvars:widths", "widths"] {
        let Some(widths) = primvar(reader.stage, prim, name, Interpolation::Vertex, base)? else { continue };
        if widths.values.lanes != 1 {
            return Err(Error::prim(prim, format!("{name} must be numbers")));
        }
        let is_width = |w: &f32| (0.0..=MAX_WIDTH).contains(w);
        if let [w] = widths.values.values[..]
            && !is_width(&w)
        {
            return Err(Error::prim(prim, format!("{name} is {w:?}: it must be in [0, {MAX_WIDTH:e}]")));
        }
        if !is_uniform {
            reader
                .warnings
                .add(prim, "its scale is not uniform: strands stay round, and the mean scale applies to their widths");
        }
        // A strand with NaN is left out.
        let radius = |w: f32| if is_width(&w) { (0.5 * scale * f64::from(w)) as f32 } else { f32::NAN };
        match layout.spread(prim, name, &widths, |w| [radius(w[0])]) {
            Err(error) if reader.options.default_width.is_some() => reader.ignore(prim, error)?,
            radii => return radii,
        }
    }
    match reader.options.default_width {
        Some(width) => Ok(Values::Constant([(0.5 * f64::from(width) * reader.local_scale) as f32])),
        None => Err(Error::prim(prim, "it has no widths: set a default diameter in scene units (--width)")),
    }
}

/// The normals of ribbons, in world space: the shorter axes of sections that are not round.
fn normals(reader: &Reader, place: &Place, layout: &Layout, base: When) -> Result<Option<Values<Vec3>>, Error> {
    let prim = place.path.as_str();
    let of_normals = DMat3::from_mat4(place.to_world).inverse().transpose();
    // A strand with NaN is left out, but one without a direction is not.
    let in_world = |n: [f32; 3]| (of_normals * DVec3::from(n.map(f64::from))).normalize_or_zero().as_vec3();
    for name in ["primvars:normals", "normals"] {
        let Some(found) = primvar(reader.stage, prim, name, Interpolation::Vertex, base)? else { continue };
        if found.values.lanes != 3 {
            return Err(Error::prim(prim, format!("{name} must be vectors")));
        }
        return Ok(Some(match layout.spread(prim, name, &found, |row| [row[0], row[1], row[2]])? {
            Values::Constant(n) => Values::Constant(in_world(n)),
            Values::PerStrand(all) => Values::PerStrand(all.into_iter().map(in_world).collect()),
            Values::PerPoint(all) => Values::PerPoint(all.into_iter().map(in_world).collect()),
        }));
    }
    Ok(None)
}

/// One uv for each strand. If the file has one for each point, the uv of the first point.
fn root_uv(
    reader: &Reader,
    prim: &str,
    layout: &Layout,
    bound: &BoundLook,
    base: When,
) -> Result<Option<Vec<Vec2>>, Error> {
    let asked = bound.uv.as_ref().map(|set| format!("primvars:{set}"));
    for name in asked.iter().map(String::as_str).chain(ROOT_UV) {
        let Some(uv) = primvar(reader.stage, prim, name, Interpolation::Constant, base)? else { continue };
        if uv.values.lanes < 2 {
            return Err(Error::prim(prim, format!("{name} must have two coordinates")));
        }
        let strands = layout.counts.len();
        return Ok(Some(match layout.spread(prim, name, &uv, |row| [row[0], row[1]])? {
            Values::Constant(uv) => vec![Vec2::from(uv); strands],
            Values::PerStrand(uv) => uv.into_iter().map(Vec2::from).collect(),
            Values::PerPoint(uv) => {
                // The first point in the file, not the phantom point before it.
                let skipped = usize::from(layout.ends == Ends::Pinned);
                let at = |start: &u32| uv.get(*start as usize + skipped).map_or(Vec2::NAN, |uv| Vec2::from(*uv));
                layout.starts()[..strands].iter().map(at).collect()
            }
        }));
    }
    Ok(None)
}

/// Primvars of OpenUSD's renderer that change widths: the value without effect, and what happens instead.
const OTHER_WIDTHS: [(&str, f32, &str); 3] = [
    ("primvars:screenSpaceWidths", 0.0, "its widths are pixels in other renderers, and are read as scene units"),
    ("primvars:minScreenSpaceWidths", 0.0, "its strands may be thinner than so many pixels (--min-pixel-width)"),
    (
        "primvars:pointSizeScale",
        1.0,
        "other programs enlarge curves that they draw as points; its widths do not change",
    ),
];

/// Names primvars that change the widths elsewhere.
fn warn_of_widths(reader: &mut Reader, prim: &str, base: When) -> Result<(), Error> {
    for (name, idle, instead) in OTHER_WIDTHS {
        let has_effect = match inherited(reader.stage, prim, name, base) {
            Ok(found) => found.is_some_and(|found| found.values.values.iter().any(|x| *x != idle)),
            Err(error) => {
                reader.ignore(prim, error)?;
                false
            }
        };
        if has_effect {
            reader.warnings.add(prim, format!("{name} is not supported: {instead}"));
        }
    }
    Ok(())
}

/// Prefix of the primvars for parameters of the fibre.
const PRIMVARS: &str = "primvars:vellus:";

/// [`Strands::varying`].
type Varying = Vec<(Parameter, Values<[f32; 3]>)>;

/// Parameters of the fibre from `primvars:vellus:KEY`, or from the primvar that the shader reads.
fn varying(reader: &mut Reader, prim: &str, layout: &Layout, bound: &BoundLook, base: When) -> Result<Varying, Error> {
    let mut varying = Vec::new();
    for parameter in Parameter::ALL.into_iter().filter(|parameter| parameter.varies()) {
        let ours = format!("{PRIMVARS}{}", parameter.name());
        let theirs = bound.primvars.iter().find(|(p, _)| *p == parameter).map(|(_, name)| format!("primvars:{name}"));
        for name in std::iter::once(ours).chain(theirs) {
            let found = inherited(reader.stage, prim, &name, base).and_then(|found| {
                let Some(mut values) = found else { return Ok(None) };
                let space = values.space.take();
                reader.convert_parameter(parameter, prim, &name, space.as_deref(), &mut values.values)?;
                let spread = layout.spread(prim, &name, &values, |row| channels(parameter, row))?;
                if matches!(&spread, Values::Constant(value) if value.iter().any(|x| !x.is_finite())) {
                    return Err(Error::prim(prim, format!("{name} is not finite")));
                }
                Ok(Some((values, spread)))
            });
            let (values, spread) = match found {
                Ok(None) => continue,
                Ok(Some(found)) => found,
                Err(error) => {
                    reader.ignore(prim, error)?;
                    continue;
                }
            };
            varying.push((parameter, spread));
            if let Some((i, value)) = outside(parameter, &values) {
                warn_of_range(reader, prim, (parameter, &name), bound.look, (i, value));
            }
            break;
        }
    }
    for path in ancestors(prim) {
        for name in reader.stage.properties(path)?.iter() {
            let key = name.strip_prefix(PRIMVARS).map(|key| key.strip_suffix(":indices").unwrap_or(key));
            if key.is_some_and(|key| Parameter::from_name(key).is_none()) {
                reader.warnings.add(path, format!("{name} is not a parameter of {SHADER} and is ignored"));
            }
        }
    }
    Ok(varying)
}

/// The first value of a primvar that is outside the range of the parameter, and its index.
fn outside(parameter: Parameter, primvar: &Primvar) -> Option<(usize, f32)> {
    (0..primvar.values.len()).find_map(|i| {
        let row = primvar.values.row(i).iter().take(parameter.channels());
        row.copied().find(|x| x.is_finite() && !parameter.range().contains(*x)).map(|x| (i, x))
    })
}

/// Adds one warning for each primvar and look with values out of range.
fn warn_of_range(
    reader: &mut Reader,
    prim: &str,
    (parameter, name): (Parameter, &str),
    look: usize,
    (i, value): (usize, f32),
) {
    if !reader.held.insert((look, name.to_owned())) {
        return;
    }
    let (range, unit) = (parameter.range(), parameter.unit().suffix());
    let nearest = range.nearest(value);
    let what = format!("{name}[{i}] is {value}: the range is {range}{unit}, so it is clamped to {nearest}");
    let look = &reader.scene.looks[look].name;
    reader.warnings.add(prim, format!("{what}; other curves with the look {look} are clamped too"));
}
