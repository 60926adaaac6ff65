//! Reads strands (UsdGeomBasisCurves).

use crate::error::Error;
use crate::read::context::{BoundLook, Reader};
use crate::read::layout::Layout;
use crate::read::look::{SHADER, channels, look};
use crate::read::motion::{Points, points};
use crate::read::primvar::{Interpolation, Primvar, ancestors, inherited, primvar};
use crate::read::xform::{Place, mean_scale};
use crate::stage::{Stage, When};
use glam::{DMat4, DVec3, Vec2, Vec3};
use vellus_scene::{Basis, MAX_COORDINATE, Parameter, Strands, Values};

/// The largest width, in scene units.
pub(crate) const MAX_WIDTH: f32 = 2.0 * MAX_COORDINATE;

/// Primvars that may have the texture coordinates of the roots. Blender writes the last one.
const ROOT_UV: [&str; 3] = ["primvars:st", "primvars:uv", "primvars:surface_uv_coordinate"];

/// Reads the curves of a prim. Unsupported kinds of curves give a warning and nothing else.
pub(crate) fn read(reader: &mut Reader, place: &Place) -> Result<(), Error> {
    let prim = place.path.as_str();
    let Some((basis, pinned)) = kind(reader, prim)? else { return Ok(()) };
    if place.to_world.determinant() == 0.0 || place.moved.determinant() == 0.0 {
        return Err(Error::prim(
            prim,
            "its transform flattens the strands: no scale of the prim or of its ancestors may be 0",
        ));
    }
    let Points { open, close } = points(reader, prim).map_err(|error| match error {
        // Blender writes NaN handles for curves without handles.
        Error::Prim { prim, what } if basis == Basis::Bezier && what.contains("NaN") => {
            let what =
                format!("{what} (re-export the curves as Catmull-Rom: Blender writes Bézier handles that are NaN)");
            Error::Prim { prim, what }
        }
        error => error,
    })?;
    let counts = reader.stage.integers(prim, "curveVertexCounts", When::Open)?.unwrap_or_default();
    let layout = Layout::new(prim, basis, pinned, &counts, open.len())?;
    if layout.counts.is_empty() {
        reader.warnings.add(prim, "it has no curves");
        return Ok(());
    }
    let radii = radii(reader, place, &layout)?;
    let stage = &reader.stage;
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
                Values::PerPoint(radii) => radii[point][0].max(0.0),
            }));
        }
    }
    let root_uv = root_uv(stage, prim, &layout)?;
    let bound = look(reader, prim)?;
    let varying = varying(reader, prim, &layout, &bound)?;
    let mut strands = Strands {
        // The path, for the messages of the validation.
        name: prim.to_owned(),
        basis,
        starts,
        points: all,
        moved,
        root_uv,
        look: bound.look,
        varying,
    };
    strands.validate()?;
    strands.name = reader.name(prim)?;
    reader.scene.strands.push(strands);
    Ok(())
}

/// The basis of curves, and whether they need phantom points. `None` with a warning if they are not supported.
fn kind(reader: &mut Reader, prim: &str) -> Result<Option<(Basis, bool)>, Error> {
    let word = |name: &str, fallback: &str| -> Result<String, Error> {
        let words = reader.stage.words(prim, name)?.unwrap_or_default();
        Ok(words.into_iter().next().unwrap_or_else(|| fallback.to_owned()))
    };
    let (kind, basis, wrap) = (word("type", "cubic")?, word("basis", "bezier")?, word("wrap", "nonperiodic")?);
    let pinned = match wrap.as_str() {
        "nonperiodic" => false,
        "pinned" => true,
        "periodic" => {
            reader.warnings.add(prim, "periodic curves are not supported and are ignored");
            return Ok(None);
        }
        _ => {
            let what = format!("wrap is {wrap}: it must be nonperiodic, periodic or pinned");
            return Err(Error::prim(prim, what));
        }
    };
    match (kind.as_str(), basis.as_str()) {
        // Blender does not reset the basis of linear curves, so it has no meaning here.
        ("linear", _) => Ok(Some((Basis::Linear, false))),
        ("cubic", "bezier") => Ok(Some((Basis::Bezier, false))),
        ("cubic", "bspline") => Ok(Some((Basis::BSpline, pinned))),
        ("cubic", "catmullRom") => Ok(Some((Basis::CatmullRom, pinned))),
        ("cubic", "hermite" | "power") => {
            reader.warnings.add(prim, format!("curves of the basis {basis} are not supported and are ignored"));
            Ok(None)
        }
        ("cubic", _) => Err(Error::prim(prim, format!("basis is {basis}: it must be bezier, bspline or catmullRom"))),
        _ => Err(Error::prim(prim, format!("type is {kind}: it must be linear or cubic"))),
    }
}

/// Control points in world space, with phantom points.
fn to_world(layout: &Layout, points: &[[f32; 3]], matrix: &DMat4) -> Vec<Vec3> {
    // The identity is exact: it multiplies by 1 and adds 0.
    let place = |p: [f32; 3]| matrix.transform_point3(DVec3::from(p.map(f64::from))).as_vec3();
    layout.points(points, false).into_iter().map(place).collect()
}

/// Radii in world space: half the widths.
fn radii(reader: &mut Reader, place: &Place, layout: &Layout) -> Result<Values<[f32; 1]>, Error> {
    let prim = place.path.as_str();
    let (scale, is_uniform) = mean_scale(&place.to_world);
    for name in ["primvars:widths", "widths"] {
        let Some(widths) = primvar(&reader.stage, prim, name, Interpolation::Vertex)? else { continue };
        if widths.values.lanes != 1 {
            return Err(Error::prim(prim, format!("{name} must be numbers")));
        }
        if let Some(i) = widths.values.values.iter().position(|w| !(0.0..=MAX_WIDTH).contains(w)) {
            let what = format!("{name}[{i}] is {:?}: it must be in [0, {MAX_WIDTH:e}]", widths.values.values[i]);
            return Err(Error::prim(prim, what));
        }
        if !is_uniform {
            reader
                .warnings
                .add(prim, "its scale is not uniform: strands stay round, and the mean scale applies to their widths");
        }
        return layout.spread(prim, name, &widths, |w| [(0.5 * scale * f64::from(w[0])) as f32]);
    }
    match reader.options.default_width {
        Some(width) => Ok(Values::Constant([(0.5 * f64::from(width) * reader.local_scale) as f32])),
        None => Err(Error::prim(prim, "it has no widths: set a default diameter in scene units (--width)")),
    }
}

/// One uv for each strand. If the file has one for each point, the uv of the first point.
fn root_uv(stage: &Stage, prim: &str, layout: &Layout) -> Result<Option<Vec<Vec2>>, Error> {
    for name in ROOT_UV {
        let Some(uv) = primvar(stage, prim, name, Interpolation::Constant)? else { continue };
        if uv.values.lanes < 2 {
            return Err(Error::prim(prim, format!("{name} must have two coordinates")));
        }
        let strands = layout.counts.len();
        return Ok(Some(match layout.spread(prim, name, &uv, |row| [row[0], row[1]])? {
            Values::Constant(uv) => vec![Vec2::from(uv); strands],
            Values::PerStrand(uv) => uv.into_iter().map(Vec2::from).collect(),
            Values::PerPoint(uv) => {
                // The first point in the file, not the phantom point before it.
                let skipped = usize::from(layout.starts()[1] as usize != layout.counts[0]);
                layout.starts()[..strands].iter().map(|&start| Vec2::from(uv[start as usize + skipped])).collect()
            }
        }));
    }
    Ok(None)
}

/// Prefix of the primvars for parameters of the fibre.
const PRIMVARS: &str = "primvars:vellus:";

/// [`Strands::varying`].
type Varying = Vec<(Parameter, Values<[f32; 3]>)>;

/// Parameters of the fibre from `primvars:vellus:KEY`, or from the primvar that the shader reads.
fn varying(reader: &mut Reader, prim: &str, layout: &Layout, bound: &BoundLook) -> Result<Varying, Error> {
    let mut varying = Vec::new();
    for parameter in Parameter::ALL {
        let ours = format!("{PRIMVARS}{}", parameter.name());
        let theirs = bound.primvars.iter().find(|(p, _)| *p == parameter).map(|(_, name)| format!("primvars:{name}"));
        for name in std::iter::once(ours).chain(theirs) {
            let Some(mut values) = inherited(&reader.stage, prim, &name)? else { continue };
            let space = values.space.take();
            reader.convert_parameter(parameter, prim, &name, space.as_deref(), &mut values.values)?;
            if let Some(i) = values.values.values.iter().position(|x| !x.is_finite()) {
                let what = format!("{name}[{}] is not finite", i / values.values.lanes);
                return Err(Error::prim(prim, what));
            }
            varying.push((parameter, layout.spread(prim, &name, &values, |row| channels(parameter, row))?));
            if let Some((i, value)) = outside(parameter, &values) {
                warn_of_range(reader, prim, (parameter, &name), bound.look, (i, value));
            }
            break;
        }
    }
    for path in ancestors(prim) {
        for name in reader.stage.properties(path)?.iter() {
            let key = name.as_str().strip_prefix(PRIMVARS).map(|key| key.strip_suffix(":indices").unwrap_or(key));
            if key.is_some_and(|key| Parameter::from_name(key).is_none()) {
                reader.warnings.add(path, format!("{} is not a parameter of {SHADER} and is ignored", name.as_str()));
            }
        }
    }
    Ok(varying)
}

/// The first value of a primvar that is outside the range of the parameter, and its index.
fn outside(parameter: Parameter, primvar: &Primvar) -> Option<(usize, f32)> {
    (0..primvar.values.len()).find_map(|i| {
        let row = primvar.values.row(i).iter().take(parameter.channels());
        row.copied().find(|x| !parameter.range().contains(*x)).map(|x| (i, x))
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
