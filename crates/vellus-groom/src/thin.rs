//! Reduces the number of strands for previews.

use vellus_scene::{Strands, Values};

/// Keeps about the fraction `share` of the strands, in (0, 1], and divides their radii by it. Coverage stays about the
/// same.
///
/// The selection depends on the index of a strand only. The strands of a smaller share are a subset of those of a
/// larger share.
pub fn thin(strands: &Strands, share: f32) -> Strands {
    let kept: Vec<usize> = (0..strands.len()).filter(|&i| unit(i as u32) < share).collect();
    let range = |i: usize| strands.starts[i] as usize..strands.starts[i + 1] as usize;
    let mut starts = vec![0];
    for &i in &kept {
        starts.push(starts[starts.len() - 1] + range(i).len() as u32);
    }
    let points = kept.iter().flat_map(|&i| &strands.points[range(i)]).map(|p| p.truncate().extend(p.w / share));
    let varying = strands.varying.iter().map(|(parameter, values)| {
        let values = match values {
            Values::Constant(value) => Values::Constant(*value),
            Values::PerStrand(values) => Values::PerStrand(kept.iter().map(|&i| values[i]).collect()),
            Values::PerPoint(values) => {
                Values::PerPoint(kept.iter().flat_map(|&i| &values[range(i)]).copied().collect())
            }
        };
        (*parameter, values)
    });
    Strands {
        name: strands.name.clone(),
        basis: strands.basis,
        points: points.collect(),
        moved: strands.moved.as_ref().map(|moved| kept.iter().flat_map(|&i| &moved[range(i)]).copied().collect()),
        root_uv: strands.root_uv.as_ref().map(|uv| kept.iter().map(|&i| uv[i]).collect()),
        look: strands.look,
        varying: varying.collect(),
        starts,
    }
}

/// A pseudo-random number in [0, 1) for each strand.
fn unit(i: u32) -> f32 {
    // The hash lowbias32 by Chris Wellons.
    let mut x = i;
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    ((x ^ (x >> 16)) >> 8) as f32 / (1u32 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    #[test]
    fn a_share_stays_valid_and_covers_the_same() {
        let Some(scene) = scene("cat", true) else { panic!("there is a cat") };
        let cover = |s: &Strands| s.points.iter().map(|p| f64::from(p.w)).sum::<f64>();
        for strands in &scene.strands {
            let few = thin(strands, 0.25);
            assert_eq!(few.validate(), Ok(()));
            let share = few.len() as f64 / strands.len() as f64;
            // A quarter of the strands, within four standard deviations.
            let tolerance = 4.0 * (0.25 * 0.75 / strands.len() as f64).sqrt();
            assert!((share - 0.25).abs() < tolerance, "{share}");
            assert!((cover(&few) / cover(strands) - 1.0).abs() < 5.0 * tolerance);
            assert_eq!(thin(strands, 1.0), *strands);
        }
    }
}
