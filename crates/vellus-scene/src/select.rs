//! Some of the strands of a set.

use crate::strands::{Basis, MAX_COORDINATE, Strands, Values, is_within};
use std::fmt;

/// Strands that were left out because nothing can be rendered of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Broken {
    /// Their indices, in order. There is at least one.
    pub strands: Vec<usize>,
    /// How many strands there were.
    pub of: usize,
    /// The basis of all.
    pub basis: Basis,
}

impl fmt::Display for Broken {
    /// Names at most five strands.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let points = match self.basis {
            Basis::Linear => "at least 2 points",
            Basis::Bezier => "3k + 1 points (4, 7, 10, …)",
            Basis::BSpline | Basis::CatmullRom => "at least 4 points, or 2 if it is pinned",
        };
        let shown: Vec<String> = self.strands.iter().take(5).map(usize::to_string).collect();
        let more = if self.strands.len() > shown.len() { ", …" } else { "" };
        write!(
            f,
            "{} of {} strands are left out (strand {}{more}): a {:?} curve has {points}, all coordinates are finite \
             and within ±{MAX_COORDINATE:e}, widths are in [0, {:e}], and other values are finite",
            self.strands.len(),
            self.of,
            shown.join(", "),
            self.basis,
            2.0 * MAX_COORDINATE
        )
    }
}

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
            normals: self.normals.as_ref().map(of_points),
            root_uv: self.root_uv.as_ref().map(|uv| kept.iter().map(|&(i, _)| uv[i]).collect()),
            look: self.look,
            varying: varying.collect(),
            starts,
            points,
        }
    }

    /// Removes the strands of which nothing can be rendered: those with a number of points that the basis does not
    /// allow, and those with coordinates, radii or other values for which [`Strands::validate`] fails. Returns which.
    ///
    /// All arrays must have the lengths that `starts` says.
    pub fn remove_broken(&mut self) -> Option<Broken> {
        let strands: Vec<usize> = (0..self.len()).filter(|&i| self.is_broken(i)).collect();
        if strands.is_empty() {
            return None;
        }
        let broken = Broken { of: self.len(), basis: self.basis, strands };
        *self = self.select(|i| broken.strands.binary_search(&i).is_err().then_some(1.0));
        Some(broken)
    }

    fn is_broken(&self, i: usize) -> bool {
        let range = self.starts[i] as usize..self.starts[i + 1] as usize;
        let is_good = |p: &glam::Vec4| is_within(p.truncate()) && (0.0..=MAX_COORDINATE).contains(&p.w);
        let is_finite = |value: &[f32; 3]| value.iter().all(|x| x.is_finite());
        self.basis.segments(range.len()).is_none()
            || !self.points[range.clone()].iter().all(is_good)
            || self.moved.as_ref().is_some_and(|moved| !moved[range.clone()].iter().all(|p| is_within(*p)))
            || self.normals.as_ref().is_some_and(|normals| !normals[range.clone()].iter().all(|n| n.is_finite()))
            || self.root_uv.as_ref().is_some_and(|uv| !uv[i].is_finite())
            || self.varying.iter().any(|(_, values)| match values {
                Values::Constant(_) => false,
                Values::PerStrand(values) => !is_finite(&values[i]),
                Values::PerPoint(values) => !values[range.clone()].iter().all(is_finite),
            })
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

    #[test]
    fn broken_strands_are_removed_and_named() {
        let points =
            [[0.0, 0.0], [1.0, 0.0], [f32::NAN, 0.0], [3.0, 0.0], [4.0, 0.0], [5.0, -1.0], [6.0, 0.0], [7.0, 0.0]];
        let mut strands = Strands {
            name: "fur".to_owned(),
            basis: Basis::Linear,
            starts: vec![0, 2, 4, 5, 6, 8],
            points: points.map(|[x, w]| Vec4::new(x, 0.0, 0.0, w)).to_vec(),
            moved: None,
            normals: None,
            root_uv: Some(vec![Vec2::ZERO, Vec2::ZERO, Vec2::ZERO, Vec2::ZERO, Vec2::ONE]),
            look: 0,
            varying: Vec::new(),
        };
        let broken = strands.remove_broken().unwrap();
        assert_eq!((broken.strands.as_slice(), broken.of), (&[1, 2, 3][..], 5));
        assert!(
            broken
                .to_string()
                .starts_with("3 of 5 strands are left out (strand 1, 2, 3): a Linear curve has at least 2")
        );
        assert_eq!((strands.starts.as_slice(), strands.points[2].x), (&[0, 2, 4][..], 6.0));
        assert_eq!((strands.validate(), strands.remove_broken()), (Ok(()), None));
    }

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
            normals: None,
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
