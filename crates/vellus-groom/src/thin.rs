//! Reduces the number of strands for previews.

use vellus_scene::Strands;

/// Keeps about the fraction `share` of the strands, in (0, 1], and divides their radii by it. Coverage stays about the
/// same.
///
/// The selection depends on the index of a strand only. The strands of a smaller share are a subset of those of a
/// larger share.
pub fn thin(strands: &Strands, share: f32) -> Strands {
    strands.select(|i| (Strands::rank(i) < share).then_some(1.0 / share))
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
