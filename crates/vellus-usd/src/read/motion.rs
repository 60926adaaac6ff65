//! Where points are as the shutter opens and closes (UsdGeomPointBased).

use crate::error::Error;
use crate::read::context::Reader;
use crate::stage::{Stage, When};

/// The points of a prim in its own space, each of three finite numbers.
pub(crate) struct Points {
    /// As the shutter opens.
    pub open: Vec<[f32; 3]>,
    /// As it closes, as many; `None` where it does not stay open.
    pub close: Option<Vec<[f32; 3]>>,
}

/// Reads them. Velocities, where there are any, move them from the last sample before the shutter opens, or from the frame where there are no
/// samples; later samples, which may be of other points, are then not looked at.
pub(crate) fn points(reader: &mut Reader, prim: &str) -> Result<Points, Error> {
    let clock = reader.stage.clock;
    let moves = clock.close != clock.open;
    if let Some(points) = by_velocities(reader, prim)? {
        return Ok(points);
    }
    let open = vectors(&reader.stage, prim, "points", When::Open)?.unwrap_or_default();
    if !moves {
        return Ok(Points { open, close: None });
    }
    let close = vectors(&reader.stage, prim, "points", When::Close)?.unwrap_or_default();
    if close.len() != open.len() {
        let what = format!("it has {} points as the shutter opens, {} as it closes", open.len(), close.len());
        return Err(Error::prim(prim, what));
    }
    Ok(Points { open, close: Some(close) })
}

/// `None` where the prim has no velocities that fit its points.
fn by_velocities(reader: &mut Reader, prim: &str) -> Result<Option<Points>, Error> {
    let stage = &reader.stage;
    let clock = stage.clock;
    // Without a frame there is no time from which to count.
    if clock.is_timeless() || !stage.has_value(prim, "velocities")? {
        return Ok(None);
    }
    let sample = stage.sample_before(prim, "points", clock.open)?;
    let when = sample.map_or(When::Open, When::At);
    let points = vectors(stage, prim, "points", when)?.unwrap_or_default();
    let velocities = vectors(stage, prim, "velocities", when)?.unwrap_or_default();
    if velocities.is_empty() {
        return Ok(None);
    }
    if velocities.len() != points.len() || stage.sample_before(prim, "velocities", clock.open)? != sample {
        reader
            .warnings
            .add(prim, "its velocities are not those of its points, in number or in time: they are left out");
        return Ok(None);
    }
    let accelerations = vectors(stage, prim, "accelerations", when)?.unwrap_or_default();
    let same = accelerations.len() == points.len() && stage.sample_before(prim, "accelerations", clock.open)? == sample;
    if !accelerations.is_empty() && !same {
        reader
            .warnings
            .add(prim, "its accelerations are not those of its points, in number or in time: they are left out");
    }
    let per_second = reader.stage.time_codes_per_second().map_err(|what| Error::prim(prim, what))?;
    let at = |time: f64| -> Result<Vec<[f32; 3]>, Error> {
        let t = (time - sample.unwrap_or(clock.frame)) / per_second;
        let place = |i: usize| -> [f32; 3] {
            std::array::from_fn(|k| {
                let bend = if same { 0.5 * f64::from(accelerations[i][k]) * t } else { 0.0 };
                (f64::from(points[i][k]) + (f64::from(velocities[i][k]) + bend) * t) as f32
            })
        };
        let moved: Vec<_> = (0..points.len()).map(place).collect();
        if moved.as_flattened().iter().all(|x| x.is_finite()) {
            Ok(moved)
        } else {
            Err(Error::prim(prim, "its velocities carry its points to infinity"))
        }
    };
    let close = if clock.close == clock.open { None } else { Some(at(clock.close)?) };
    Ok(Some(Points { open: at(clock.open)?, close }))
}

fn vectors(stage: &Stage, prim: &str, name: &str, when: When) -> Result<Option<Vec<[f32; 3]>>, Error> {
    let Some(numbers) = stage.numbers(prim, name, when)? else { return Ok(None) };
    if numbers.lanes != 3 && !numbers.values.is_empty() {
        return Err(Error::prim(prim, format!("{name} must have three coordinates")));
    }
    let (vectors, _) = numbers.values.as_chunks::<3>();
    match vectors.iter().position(|v| v.iter().any(|x| !x.is_finite())) {
        Some(i) => Err(Error::prim(prim, format!("{name}[{i}] is {:?}: it must be finite", vectors[i]))),
        None => Ok(Some(vectors.to_vec())),
    }
}
