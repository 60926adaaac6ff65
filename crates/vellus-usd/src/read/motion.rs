//! Positions of points when the shutter opens and closes (UsdGeomPointBased).

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::skeleton::pose;
use crate::stage::{Stage, When};

/// The points of a prim in its own space. All coordinates are finite.
pub(crate) struct Points {
    /// When the shutter opens.
    pub open: Vec<[f32; 3]>,
    /// When the shutter closes, as many; `None` if both times are the same.
    pub close: Option<Vec<[f32; 3]>>,
}

/// Reads the points of a prim, in the pose of its skeleton.
pub(crate) fn points(reader: &mut Reader, prim: &str) -> Result<Points, Error> {
    let points = authored(reader, prim)?;
    pose(reader, prim, points)
}

/// Reads the points of a prim as they are in the file.
///
/// If the prim has velocities, they move the points of the last sample before the shutter opens, or of the frame if
/// there are no samples. Later samples are then ignored, because they may have other points.
fn authored(reader: &mut Reader, prim: &str) -> Result<Points, Error> {
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
        let what = format!("it has {} points when the shutter opens, but {} when it closes", open.len(), close.len());
        return Err(Error::prim(prim, what));
    }
    Ok(Points { open, close: Some(close) })
}

/// The points, moved by velocities; `None` if the prim has no velocities that match its points.
fn by_velocities(reader: &mut Reader, prim: &str) -> Result<Option<Points>, Error> {
    let stage = &reader.stage;
    let clock = stage.clock;
    // Without a frame, there is no reference time.
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
        reader.warnings.add(prim, "its velocities do not match its points in number or in time, and are ignored");
        return Ok(None);
    }
    let accelerations = vectors(stage, prim, "accelerations", when)?.unwrap_or_default();
    let same = accelerations.len() == points.len() && stage.sample_before(prim, "accelerations", clock.open)? == sample;
    if !accelerations.is_empty() && !same {
        reader.warnings.add(prim, "its accelerations do not match its points in number or in time, and are ignored");
    }
    let per_second = reader.stage.time_codes_per_second().map_err(|what| Error::prim(prim, what))?;
    if let Some(sample) = sample {
        warn_of_frames(reader, prim, sample, (&points, &velocities), per_second)?;
    }
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
            Err(Error::prim(prim, "its velocities move points to infinity"))
        }
    };
    let close = if clock.close == clock.open { None } else { Some(at(clock.close)?) };
    Ok(Some(Points { open: at(clock.open)?, close }))
}

/// Adds a warning if the next sample of the points shows that velocities are per time code instead of per second.
/// Attributes of simulations often are, and exporters copy them as they are.
fn warn_of_frames(
    reader: &mut Reader,
    prim: &str,
    sample: f64,
    (points, velocities): (&[[f32; 3]], &[[f32; 3]]),
    per_second: f64,
) -> Result<(), Error> {
    let Some(next) = reader.stage.sample_after(prim, "points", sample)? else { return Ok(()) };
    let later = vectors(&reader.stage, prim, "points", When::At(next))?.unwrap_or_default();
    if later.len() != points.len() {
        return Ok(());
    }
    let miss = |seconds: f64| -> f64 {
        let all = points.as_flattened().iter().zip(later.as_flattened()).zip(velocities.as_flattened());
        all.map(|((now, later), v)| (f64::from(*later) - f64::from(*now) - f64::from(*v) * seconds).powi(2)).sum()
    };
    let codes = next - sample;
    // Half of the distance, so that noise does not decide.
    if miss(codes) < 0.25 * miss(codes / per_second).min(miss(0.0)) {
        let what = format!(
            "its velocities fit its points per frame, but USD has them per second: multiply them by {per_second}, or \
             motion blur is too short"
        );
        reader.warnings.add(prim, what);
    }
    Ok(())
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
