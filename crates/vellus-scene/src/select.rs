//! Some of the strands of a set.

use crate::strands::{Strands, Values};

impl Strands {
    /// The strands for which `factor` returns a number, with their radii times that number. It receives the index of a
    /// strand.
    pub fn select(&self, factor: impl Fn(usize) -> Option<f32>) -> Strands {
        let kept: Vec<(usize, f32)> = (0..self.len()).filter_map(|i| Some((i, factor(i)?))).collect();
        let range = |i: usize| self.starts[i] as usize..self.starts[i + 1] as usize;
        let count = kept.iter().map(|&(i, _)| range(i).len()).sum();
        let mut starts = Vec::with_capacity(kept.len() + 1);
        starts.push(0);
        let mut points = Vec::with_capacity(count);
        for &(i, factor) in &kept {
            points.extend(self.points[range(i)].iter().map(|p| p.truncate().extend(p.w * factor)));
            starts.push(points.len() as u32);
        }
        let varying = self.varying.iter().map(|(parameter, values)| {
            let values = match values {
                Values::Constant(value) => Values::Constant(*value),
                Values::PerStrand(values) => Values::PerStrand(kept.iter().map(|&(i, _)| values[i]).collect()),
                Values::PerPoint(values) => {
                    Values::PerPoint(kept.iter().flat_map(|&(i, _)| &values[range(i)]).copied().collect())
                }
            };
            (*parameter, values)
        });
        let of_points = |moved: &Vec<_>| kept.iter().flat_map(|&(i, _)| &moved[range(i)]).copied().collect();
        Strands {
            name: self.name.clone(),
            basis: self.basis,
            moved: self.moved.as_ref().map(of_points),
            root_uv: self.root_uv.as_ref().map(|uv| kept.iter().map(|&(i, _)| uv[i]).collect()),
            look: self.look,
            varying: varying.collect(),
            starts,
            points,
        }
    }

    /// The rank of a strand in [0, 1): pseudo-random numbers that depend on its index only. The strands of the ranks
    /// below s are a random share s of all strands, and a subset of those of any larger share.
    pub fn rank(strand: usize) -> f32 {
        // The hash lowbias32 by Chris Wellons.
        let mut x = strand as u32;
        x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
        x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
        ((x ^ (x >> 16)) >> 8) as f32 / (1u32 << 24) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strands::Basis;
    use glam::{Vec2, Vec3, Vec4};
    use vellus::Parameter;

    /// Every array keeps the values of the strands that are kept.
    #[test]
    fn all_values_follow_their_strands() {
        let points = 4;
        let count = 50;
        let id = |i: usize| i as f32;
        let all = Strands {
            name: "fur".to_owned(),
            basis: Basis::BSpline,
            starts: (0..=count).map(|i| (i * points) as u32).collect(),
            points: (0..count * points).map(|k| Vec4::new(id(k / points), id(k % points), 0.0, 2.0)).collect(),
            moved: Some((0..count * points).map(|k| Vec3::new(id(k / points), id(k % points), 1.0)).collect()),
            root_uv: Some((0..count).map(|i| Vec2::splat(id(i))).collect()),
            look: 3,
            varying: vec![
                (Parameter::SigmaMs, Values::Constant([7.0; 3])),
                (Parameter::SigmaCa, Values::PerStrand((0..count).map(|i| [id(i); 3]).collect())),
                (Parameter::Kappa, Values::PerPoint((0..count * points).map(|k| [id(k); 3]).collect())),
            ],
        };
        let some = all.select(|i| (i % 7 == 3).then_some(0.5 * id(i)));
        assert_eq!(some.validate(), Ok(()));
        assert_eq!((some.len(), some.look, &some.name), (7, 3, &all.name));
        let Values::PerStrand(colors) = &some.varying[1].1 else { panic!("{:?}", some.varying) };
        let Values::PerPoint(kappas) = &some.varying[2].1 else { panic!("{:?}", some.varying) };
        assert_eq!(some.varying[0], all.varying[0]);
        for (k, point) in some.points.iter().enumerate() {
            let strand = 7.0 * id(k / points) + 3.0;
            assert_eq!(*point, Vec4::new(strand, id(k % points), 0.0, strand));
            assert_eq!(some.moved.as_ref().unwrap()[k], Vec3::new(strand, id(k % points), 1.0));
            assert_eq!(some.root_uv.as_ref().unwrap()[k / points], Vec2::splat(strand));
            assert_eq!(colors[k / points], [strand; 3]);
            assert_eq!(kappas[k], [strand * points as f32 + id(k % points); 3]);
        }
        assert_eq!(all.select(|_| Some(1.0)), all);
        assert!(all.select(|_| None).is_empty());
    }
}
