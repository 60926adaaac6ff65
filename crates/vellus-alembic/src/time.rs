//! Time samplings: the times of the samples of a property.

use crate::cursor::Cursor;
use crate::error::Error;

/// The time of a cycle that says that there are no cycles: the largest number of double precision over 32.
const ACYCLIC: f64 = f64::MAX / 32.0;

/// Times that differ by less, in seconds, are equal: the library of Alembic has the same tolerance.
const EQUAL: f64 = 1e-5;

/// When the samples of a property are, in seconds.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeSampling {
    /// Sample `i` is at `start + i · step`.
    Uniform {
        /// The time of the first sample.
        start: f64,
        /// The time between two samples, above 0.
        step: f64,
    },
    /// The same times again and again: sample `i` is at `times[i % n] + (i / n) · period` for n times.
    Cyclic {
        /// The times of the first cycle, which increase. At least two.
        times: Vec<f64>,
        /// The time of a cycle, at least that from the first to the last time.
        period: f64,
    },
    /// Sample `i` is at `times[i]`. The times increase.
    Acyclic(Vec<f64>),
}

/// Two samples around a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Between {
    /// The last sample that is not later. The first one for times before it.
    pub floor: u32,
    /// The next one. Equal to `floor` at the time of a sample, and before the first and after the last one.
    pub ceil: u32,
    /// From 0 at `floor` to 1 at `ceil`.
    pub share: f64,
}

impl TimeSampling {
    /// The time of a sample. Acyclic samplings repeat their last time.
    pub fn time(&self, sample: u32) -> f64 {
        match self {
            TimeSampling::Uniform { start, step } => start + f64::from(sample) * step,
            TimeSampling::Cyclic { times, period } => {
                let (cycle, i) = (sample as usize / times.len(), sample as usize % times.len());
                times[i] + cycle as f64 * period
            }
            TimeSampling::Acyclic(times) => times.get(sample as usize).or(times.last()).copied().unwrap_or_default(),
        }
    }

    /// Appends the times as they are in the file.
    pub(crate) fn write(&self, bytes: &mut Vec<u8>) {
        let (period, times) = match self {
            TimeSampling::Uniform { start, step } => (*step, std::slice::from_ref(start)),
            TimeSampling::Cyclic { times, period } => (*period, &times[..]),
            TimeSampling::Acyclic(times) => (ACYCLIC, &times[..]),
        };
        bytes.extend(period.to_le_bytes());
        bytes.extend((times.len() as u32).to_le_bytes());
        bytes.extend(times.iter().flat_map(|time| time.to_le_bytes()));
    }

    /// The samples around a time, of a property with this many of them.
    pub fn between(&self, time: f64, samples: u32) -> Between {
        // Times do not decrease, so the floor is found by halving.
        let (mut floor, mut end) = (0, samples.max(1));
        while end - floor > 1 {
            let middle = floor + (end - floor) / 2;
            if self.time(middle) <= time + EQUAL { floor = middle } else { end = middle }
        }
        let [from, to] = [floor, floor.saturating_add(1)].map(|sample| self.time(sample));
        let is_at = time <= from + EQUAL || floor + 1 >= samples || to <= from;
        match is_at {
            true => Between { floor, ceil: floor, share: 0.0 },
            false => Between { floor, ceil: floor + 1, share: ((time - from) / (to - from)).clamp(0.0, 1.0) },
        }
    }
}

/// Reads all time samplings of an archive.
pub(crate) fn read(bytes: &[u8], at: usize) -> Result<Vec<TimeSampling>, Error> {
    let mut cursor = Cursor::new(bytes, "time samplings", at);
    let mut all = Vec::new();
    while !cursor.is_empty() {
        let _most_samples = cursor.u32()?;
        let (period, count) = (cursor.f64()?, cursor.u32()?);
        let bytes = cursor.bytes((count as usize).saturating_mul(8))?;
        let times: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|time| f64::from_le_bytes(*time)).collect();
        if times.is_empty() || times.iter().any(|time| !time.is_finite()) || !times.is_sorted_by(|a, b| a < b) {
            return Err(cursor.error(format!("sampling {}: its times must be finite and increase", all.len())));
        }
        let length = times[times.len() - 1] - times[0];
        all.push(match times[..] {
            _ if period == ACYCLIC => TimeSampling::Acyclic(times),
            _ if !(period > 0.0 && period < ACYCLIC && length <= period) => {
                return Err(cursor.error(format!("sampling {}: the time of a cycle is {period:?}", all.len())));
            }
            [start] => TimeSampling::Uniform { start, step: period },
            _ => TimeSampling::Cyclic { times, period },
        });
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn between(floor: u32, share: f64) -> Between {
        Between { floor, ceil: if share > 0.0 { floor + 1 } else { floor }, share }
    }

    fn near(found: Between, expected: Between) {
        let is_near = (found.floor, found.ceil) == (expected.floor, expected.ceil);
        assert!(is_near && (found.share - expected.share).abs() < 1e-9, "{found:?}, not {expected:?}");
    }

    /// Before the first sample, at a sample, between two, almost at one, and after the last one.
    #[test]
    fn times_are_between_their_samples() {
        let uniform = TimeSampling::Uniform { start: 1.0, step: 0.5 };
        near(uniform.between(0.0, 4), between(0, 0.0));
        near(uniform.between(1.5, 4), between(1, 0.0));
        near(uniform.between(1.625, 4), between(1, 0.25));
        near(uniform.between(2.0 - 1e-6, 4), between(2, 0.0));
        near(uniform.between(9.0, 4), between(3, 0.0));
        let cyclic = TimeSampling::Cyclic { times: vec![0.0, 0.1], period: 1.0 };
        near(cyclic.between(1.05, 6), between(2, 0.5));
        near(cyclic.between(1.55, 6), between(3, 0.5));
        let acyclic = TimeSampling::Acyclic(vec![0.0, 1.0, 5.0]);
        near(acyclic.between(2.0, 3), between(1, 0.25));
        near(acyclic.between(7.0, 3), between(2, 0.0));
        // There may be fewer times than samples, or no samples.
        near(acyclic.between(7.0, 9), between(8, 0.0));
        near(acyclic.between(2.0, 0), between(0, 0.0));
    }

    #[test]
    fn times_of_samples_follow_their_kind() {
        let cyclic = TimeSampling::Cyclic { times: vec![0.0, 0.25], period: 2.0 };
        assert_eq!([0, 1, 2, 5].map(|i| cyclic.time(i)), [0.0, 0.25, 2.0, 4.25]);
        assert_eq!(TimeSampling::Uniform { start: 1.0, step: 0.5 }.time(3), 2.5);
        assert_eq!(TimeSampling::Acyclic(vec![3.0, 4.0]).time(1), 4.0);
    }

    #[test]
    fn wrong_times_are_refused() {
        let bytes = |period: f64, times: &[f64]| {
            let mut bytes = 2u32.to_le_bytes().to_vec();
            bytes.extend(period.to_le_bytes());
            bytes.extend((times.len() as u32).to_le_bytes());
            times.iter().for_each(|time| bytes.extend(time.to_le_bytes()));
            bytes
        };
        let read = |period, times: &[f64]| read(&bytes(period, times), 0);
        assert_eq!(read(0.5, &[1.0]).unwrap(), [TimeSampling::Uniform { start: 1.0, step: 0.5 }]);
        assert_eq!(read(ACYCLIC, &[1.0, 2.0]).unwrap(), [TimeSampling::Acyclic(vec![1.0, 2.0])]);
        for (period, times) in
            [(0.0, &[1.0][..]), (1.0, &[]), (1.0, &[1.0, 1.0]), (1.0, &[0.0, 2.0]), (1.0, &[f64::NAN])]
        {
            assert!(read(period, times).is_err(), "{period} {times:?}");
        }
        assert!(super::read(&bytes(1.0, &[1.0])[..20], 0).is_err());
    }
}
