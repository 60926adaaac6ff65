//! Positions of points when the shutter opens and closes (UsdGeomPointBased).

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::prim::Prim;
use crate::read::skeleton::pose;
use crate::stage::When;

/// The points of a prim in its own space. Coordinates need not be finite.
pub(crate) struct Points {
    /// When the shutter opens.
    pub open: Vec<[f32; 3]>,
    /// When the shutter closes, as many; `None` if both are the same.
    pub close: Option<Vec<[f32; 3]>>,
    /// The time whose topology and widths these points have.
    pub base: When,
}

/// Reads the points of a prim, in the pose of its skeleton. `topology` names what must be the same while the shutter is
/// open: otherwise the points do not move, and are those of the frame.
pub(crate) fn points(reader: &mut Reader, prim: Prim, topology: &[&str]) -> Result<Points, Error> {
    let points = authored(reader, prim, topology)?;
    pose(reader, prim.path, points)
}

/// Reads the points of a prim as they are in the file.
///
/// If the prim has velocities, they move the points of the last sample up to the frame, or of the frame if there are no
/// samples (UsdGeomPointBased, `ComputePointsAtTimes`). Other samples are then ignored, because they may have other
/// points.
fn authored(reader: &mut Reader, prim: Prim, topology: &[&str]) -> Result<Points, Error> {
    let clock = reader.stage.clock();
    if let Some(points) = by_velocities(reader, prim)? {
        return Ok(points);
    }
    let at = |when| Ok::<_, Error>(vectors(prim, "points", when)?.unwrap_or_default());
    let open = at(When::Open)?;
    if clock.close == clock.open {
        return Ok(Points { open, close: None, base: When::Open });
    }
    let close = at(When::Close)?;
    let same = |name: &&str| {
        let [a, b] = [When::Open, When::Close].map(|when| prim.stage.integers(prim.path, name, when));
        Ok::<_, Error>(a? == b?)
    };
    if close.len() == open.len() && topology.iter().map(same).collect::<Result<Vec<_>, _>>()?.into_iter().all(|x| x) {
        warn_of_bends(reader, prim, &open, &close)?;
        return Ok(Points { open, close: Some(close), base: When::Open });
    }
    let what = "its points change in number or order while the shutter is open: it has no deformation blur";
    reader.warnings.add(prim.path, what);
    let base = When::At(clock.frame);
    Ok(Points { open: at(base)?, close: None, base })
}

/// How far a path may be from the straight line between its ends, relative to the length of that line.
pub(crate) const STRAIGHT: f64 = 0.05;

/// What to say of a path that bends.
pub(crate) const BENDS: &str =
    "bends while the shutter is open: motion blur is straight from its opening to its closing";

/// The most samples inside the shutter that are compared with a straight line.
const MOST_SAMPLES: usize = 8;

/// Adds a warning if samples inside the shutter are not on the lines between its ends.
fn warn_of_bends(reader: &mut Reader, prim: Prim, open: &[[f32; 3]], close: &[[f32; 3]]) -> Result<(), Error> {
    let clock = reader.stage.clock();
    let farthest = |a: &[[f32; 3]], b: &dyn Fn(usize) -> [f32; 3]| {
        let square = |(i, a): (usize, &[f32; 3])| (0..3).map(|k| f64::from(a[k] - b(i)[k]).powi(2)).sum::<f64>();
        a.iter().enumerate().map(square).fold(0.0, f64::max).sqrt()
    };
    let bound = (STRAIGHT * farthest(close, &|i| open[i])).max(1e-5 * farthest(open, &|_| open[0]));
    let mut time = clock.open;
    for _ in 0..MOST_SAMPLES {
        let Some(next) = reader.stage.sample_after(prim.path, "points", time)?.filter(|next| *next < clock.close)
        else {
            break;
        };
        time = next;
        let share = ((time - clock.open) / (clock.close - clock.open)) as f32;
        let inner = vectors(prim, "points", When::At(time))?.unwrap_or_default();
        let line = |i: usize| std::array::from_fn(|k| open[i][k] + share * (close[i][k] - open[i][k]));
        if inner.len() == open.len() && farthest(&inner, &line) > bound {
            reader.warnings.add(prim.path, format!("the path of its points {BENDS}"));
            break;
        }
    }
    Ok(())
}

/// The points, moved by velocities; `None` if the prim has no velocities that match its points.
fn by_velocities(reader: &mut Reader, prim: Prim) -> Result<Option<Points>, Error> {
    let stage = reader.stage;
    let clock = stage.clock();
    let has_velocities = prim.has_value("velocities")?;
    let has_accelerations = stage.has_property(prim.path, "accelerations")?;
    // Without a frame, there is no reference time.
    if clock.is_timeless() || !has_velocities {
        return Ok(None);
    }
    let sample = stage.sample_before(prim.path, "points", clock.frame)?;
    let when = sample.map_or(When::At(clock.frame), When::At);
    let points = vectors(prim, "points", when)?.unwrap_or_default();
    let velocities = vectors(prim, "velocities", when)?.unwrap_or_default();
    if velocities.is_empty() {
        return Ok(None);
    }
    if velocities.len() != points.len() || stage.sample_before(prim.path, "velocities", clock.frame)? != sample {
        reader.warnings.add(prim.path, "its velocities do not match its points in number or in time, and are ignored");
        return Ok(None);
    }
    let accelerations = if has_accelerations { vectors(prim, "accelerations", when)? } else { None };
    let accelerations = accelerations.unwrap_or_default();
    let same =
        accelerations.len() == points.len() && stage.sample_before(prim.path, "accelerations", clock.frame)? == sample;
    if !accelerations.is_empty() && !same {
        reader
            .warnings
            .add(prim.path, "its accelerations do not match its points in number or in time, and are ignored");
    }
    let per_second = reader.stage.time_codes_per_second().map_err(|what| prim.error(what))?;
    if let Some(sample) = sample {
        warn_of_frames(reader, prim, sample, (&points, &velocities), per_second)?;
    }
    let at = |time: f64| -> Vec<[f32; 3]> {
        let t = (time - sample.unwrap_or(clock.frame)) / per_second;
        let place = |i: usize| -> [f32; 3] {
            std::array::from_fn(|k| {
                let bend = if same { 0.5 * f64::from(accelerations[i][k]) * t } else { 0.0 };
                (f64::from(points[i][k]) + (f64::from(velocities[i][k]) + bend) * t) as f32
            })
        };
        (0..points.len()).map(place).collect()
    };
    let close = (clock.close != clock.open).then(|| at(clock.close));
    Ok(Some(Points { open: at(clock.open), close, base: When::At(clock.frame) }))
}

/// Adds a warning if the next sample of the points shows that velocities are per time code instead of per second.
/// Attributes of simulations often are, and exporters copy them as they are.
fn warn_of_frames(
    reader: &mut Reader,
    prim: Prim,
    sample: f64,
    (points, velocities): (&[[f32; 3]], &[[f32; 3]]),
    per_second: f64,
) -> Result<(), Error> {
    let Some(next) = reader.stage.sample_after(prim.path, "points", sample)? else { return Ok(()) };
    let later = vectors(prim, "points", When::At(next))?.unwrap_or_default();
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
        reader.warnings.add(prim.path, what);
    }
    Ok(())
}

fn vectors(prim: Prim, name: &str, when: When) -> Result<Option<Vec<[f32; 3]>>, Error> {
    let Some(numbers) = prim.stage.numbers(prim.path, name, when)? else { return Ok(None) };
    if numbers.lanes != 3 && !numbers.values.is_empty() {
        return Err(prim.error(format!("{name} must have three coordinates")));
    }
    let (vectors, _) = numbers.values.as_chunks::<3>();
    Ok(Some(vectors.to_vec()))
}
