//! Skinning, linear or by dual quaternions, and blend shapes of arrays (UsdSkel).

use glam::{DMat3, DMat4, DQuat, DVec3, DVec4};

/// The index of the parent of each joint: the longest path among `joints` that is an ancestor.
pub(crate) fn parents(joints: &[String]) -> Vec<Option<usize>> {
    let index: std::collections::HashMap<&str, usize> =
        joints.iter().enumerate().map(|(i, path)| (path.as_str(), i)).collect();
    let parent = |path: &String| {
        let above = std::iter::successors(path.rsplit_once('/'), |(above, _)| above.rsplit_once('/'));
        above.map(|(above, _)| above).find_map(|above| index.get(above).copied())
    };
    joints.iter().map(parent).collect()
}

/// The transforms of joints to the space of the skeleton, from those to their parents. Parents may come after their
/// children.
pub(crate) fn concatenate(parents: &[Option<usize>], local: &[DMat4]) -> Vec<DMat4> {
    let mut whole: Vec<Option<DMat4>> = vec![None; local.len()];
    let mut chain = Vec::new();
    for joint in 0..local.len() {
        let mut next = Some(joint);
        while let Some(joint) = next.filter(|&joint| whole[joint].is_none()) {
            chain.push(joint);
            next = parents[joint];
        }
        // A path is shorter than those below it, so chains end.
        while let Some(joint) = chain.pop() {
            let above = parents[joint].and_then(|parent| whole[parent]).unwrap_or(DMat4::IDENTITY);
            whole[joint] = Some(above * local[joint]);
        }
    }
    whole.into_iter().map(Option::unwrap_or_default).collect()
}

/// The transform of a joint: a scale, then a rotation (x, y, z, w), then a translation. The quaternion is used as it
/// is: OpenUSD does not normalise it either, and along a chain of joints the difference adds up.
pub(crate) fn joint(translation: &[f32], rotation: &[f32], scale: &[f32]) -> DMat4 {
    let vector = |v: &[f32]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
    let [x, y, z, w] = [rotation[0], rotation[1], rotation[2], rotation[3]].map(f64::from);
    let rotation = DQuat::from_xyzw(x, y, z, w);
    DMat4::from_scale_rotation_translation(vector(scale), rotation, vector(translation))
}

/// The joints that move points, with their weights.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Influences {
    /// The joints of each point, or of all points if they are rigid.
    pub joints: Vec<u32>,
    /// As many weights. USD does not normalise them.
    pub weights: Vec<f32>,
    /// The number of joints of a point.
    pub each: usize,
    /// Whether all points have the same joints.
    pub rigid: bool,
}

impl Influences {
    /// The joints and weights of a point.
    fn of(&self, point: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        let first = if self.rigid { 0 } else { point * self.each };
        let pair = |(&joint, &weight): (&u32, &f32)| (joint as usize, f64::from(weight));
        let range = first..first + self.each;
        self.joints[range.clone()].iter().zip(&self.weights[range]).map(pair)
    }
}

/// How the points of a prim move.
#[derive(Clone, Debug)]
pub(crate) struct Skin {
    /// From the space of the points to that of the skeleton when they were bound.
    pub bind: DMat4,
    /// For each joint, from its place when bound to its place now, in the space of the skeleton.
    pub joints: Vec<DMat4>,
    /// The same as motions and scales, if these are blended.
    pub rigid: Option<Vec<Rigid>>,
    /// From the space of the skeleton back to that of the points.
    pub back: DMat4,
}

impl Skin {
    /// The points after skinning.
    pub fn points(&self, points: &[[f32; 3]], influences: &Influences) -> Vec<[f32; 3]> {
        let place = |(i, point): (usize, &[f32; 3])| {
            let bound = self.bind.transform_point3(DVec3::from(point.map(f64::from)));
            let moved = match &self.rigid {
                Some(rigid) => {
                    let scaled: DVec3 =
                        influences.of(i).map(|(joint, weight)| weight * (rigid[joint].scale * bound)).sum();
                    let [turn, shift] = blended(rigid, influences.of(i));
                    turn * scaled + 2.0 * (shift * turn.conjugate()).xyz()
                }
                None => {
                    influences.of(i).map(|(joint, weight)| weight * self.joints[joint].transform_point3(bound)).sum()
                }
            };
            self.back.transform_point3(moved).as_vec3().to_array()
        };
        points.iter().enumerate().map(place).collect()
    }

    /// Normals after skinning; `points` has the point of each.
    pub fn normals(
        &self,
        normals: &[[f32; 3]],
        points: impl Iterator<Item = usize>,
        influences: &Influences,
    ) -> Vec<[f32; 3]> {
        let across = |matrix: &DMat4| {
            let linear = DMat3::from_mat4(*matrix);
            if linear.determinant() == 0.0 { linear } else { linear.inverse().transpose() }
        };
        let (bind, back) = (across(&self.bind), across(&self.back));
        let joints: Vec<DMat3> = match &self.rigid {
            Some(rigid) => rigid.iter().map(|joint| across(&DMat4::from_mat3(joint.scale))).collect(),
            None => self.joints.iter().map(across).collect(),
        };
        let place = |(normal, point): (&[f32; 3], usize)| {
            let bound = bind * DVec3::from(normal.map(f64::from));
            let moved: DVec3 = influences.of(point).map(|(joint, weight)| weight * (joints[joint] * bound)).sum();
            let turn = self.rigid.as_ref().map_or(DQuat::IDENTITY, |rigid| blended(rigid, influences.of(point))[0]);
            (back * (turn * moved)).normalize_or_zero().as_vec3().to_array()
        };
        normals.iter().zip(points).map(place).collect()
    }
}

/// A transform as a scale, then a rotation, then a translation.
#[derive(Clone, Debug)]
pub(crate) struct Rigid {
    scale: DMat3,
    /// A dual quaternion: the rotation, and half of the translation times the rotation.
    motion: [DQuat; 2],
}

impl Rigid {
    /// The parts of a transform. The scale has no rotation: both follow from the polar decomposition.
    pub fn of(matrix: &DMat4) -> Self {
        let linear = DMat3::from_mat4(*matrix);
        // A reflection is a part of the scale.
        let mut turn = if linear.determinant() < 0.0 { linear * -1.0 } else { linear };
        // Newton's method (Higham 1986), which doubles the digits in each step.
        for _ in 0..STEPS {
            let next = (turn + turn.inverse().transpose()) * 0.5;
            if !next.is_finite() {
                turn = DMat3::IDENTITY;
                break;
            }
            turn = next;
        }
        let rotation = DQuat::from_mat3(&turn).normalize();
        let shift = DQuat::from_vec4((0.5 * matrix.w_axis.truncate()).extend(0.0));
        Rigid { scale: turn.transpose() * linear, motion: [rotation, shift * rotation] }
    }
}

/// Enough for scales from 10⁻⁶ to 10⁶.
const STEPS: usize = 32;

/// A blend of the motions of joints (Kavan et al. 2008), on the side of the joint with the largest weight.
fn blended(joints: &[Rigid], influences: impl Iterator<Item = (usize, f64)> + Clone) -> [DQuat; 2] {
    let pivot =
        influences.clone().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(DQuat::IDENTITY, |(j, _)| joints[j].motion[0]);
    let mut sum = [DVec4::ZERO; 2];
    for (joint, weight) in influences {
        let motion = &joints[joint].motion;
        let weight = weight * if motion[0].dot(pivot) < 0.0 { -1.0 } else { 1.0 };
        sum = [0, 1].map(|k| sum[k] + weight * DVec4::from(motion[k]));
    }
    let length = sum[0].length();
    if length > 0.0 {
        sum.map(|part| DQuat::from_vec4(part / length))
    } else {
        [DQuat::IDENTITY, DQuat::from_vec4(DVec4::ZERO)]
    }
}

/// Adds weighted offsets to the points with these indices, or to all points in their order. `false` if they do not
/// match.
pub(crate) fn blend(points: &mut [[f32; 3]], offsets: &[[f32; 3]], indices: Option<&[i64]>, weight: f32) -> bool {
    let count = points.len();
    let fits = match indices {
        None => offsets.len() == count,
        Some(indices) => {
            let exists = |index: &i64| usize::try_from(*index).is_ok_and(|index| index < count);
            indices.len() == offsets.len() && indices.iter().all(exists)
        }
    };
    if fits {
        for (i, offset) in offsets.iter().enumerate() {
            let point = &mut points[indices.map_or(i, |indices| indices[i] as usize)];
            *point = std::array::from_fn(|k| point[k] + weight * offset[k]);
        }
    }
    fits
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(paths: &[&str]) -> Vec<String> {
        paths.iter().map(|path| (*path).to_owned()).collect()
    }

    #[test]
    fn joints_follow_their_nearest_ancestor_in_any_order() {
        let joints = names(&["a/b/c", "a", "a/b/c/d/e", "x/b"]);
        assert_eq!(parents(&joints), [Some(1), None, Some(0), None]);
        let moves: Vec<DMat4> = (0..4).map(|i| DMat4::from_translation(DVec3::X * f64::from(1 << i))).collect();
        let whole = concatenate(&parents(&joints), &moves);
        assert_eq!(whole.iter().map(|m| m.w_axis.x).collect::<Vec<_>>(), [3.0, 2.0, 7.0, 8.0]);
    }

    /// Halfway between a joint at rest and one that turns by 90° about z, a point has the mean of both places.
    #[test]
    fn points_are_blended_linearly() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let turned = joint(&[0.0, 0.0, 1.0], &[0.0, 0.0, half, half], &[2.0, 1.0, 1.0]);
        let skin =
            Skin { bind: DMat4::IDENTITY, joints: vec![DMat4::IDENTITY, turned], rigid: None, back: DMat4::IDENTITY };
        let influences = Influences { joints: vec![0, 1], weights: vec![0.5, 0.5], each: 2, rigid: true };
        let [point] = skin.points(&[[1.0, 0.0, 0.0]], &influences)[..] else { panic!() };
        let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(near(point, [0.5, 1.0, 0.5]), "{point:?}");
        let own = Influences { joints: vec![0, 1], weights: vec![1.0, 1.0], each: 1, rigid: false };
        let normals = skin.normals(&[[0.0, 1.0, 0.0], [0.6, 0.8, 0.0]], [0, 1].into_iter(), &own);
        // (0.6/2, 0.8) turned, of the length 1.
        let length = 0.3f32.hypot(0.8);
        assert!(near(normals[0], [0.0, 1.0, 0.0]) && near(normals[1], [-0.8 / length, 0.3 / length, 0.0]));
    }

    /// Between a joint at rest and one that turns by 90° about z, doubles x and moves by z, a point turns by 45°
    /// around its joints, has half of the scale and of the shift, and does not come nearer to the axis.
    #[test]
    fn dual_quaternions_keep_the_distance() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        for sign in [1.0, -1.0] {
            let turned = joint(&[0.0, 0.0, 1.0], &[0.0, 0.0, sign * half, sign * half], &[2.0, 1.0, 1.0]);
            let joints = vec![DMat4::IDENTITY, turned];
            let rigid = Some(joints.iter().map(Rigid::of).collect());
            let skin = Skin { bind: DMat4::IDENTITY, joints, rigid, back: DMat4::IDENTITY };
            let influences = Influences { joints: vec![0, 1], weights: vec![0.5, 0.5], each: 2, rigid: true };
            let [point] = skin.points(&[[1.0, 0.0, 0.0]], &influences)[..] else { panic!() };
            let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
            assert!(near(point, [1.5 * half, 1.5 * half, 0.5]), "{point:?}");
            let normals = skin.normals(&[[0.0, 1.0, 0.0]], [0].into_iter(), &influences);
            assert!(near(normals[0], [-half, half, 0.0]), "{normals:?}");
        }
    }

    /// UsdSkel.BakeSkinning of OpenUSD 26.11 takes (1, 0, 0) to (−0.00026369, 1.00026369, 0) from here.
    #[test]
    fn rotations_are_not_normalised() {
        let turned = joint(&[0.0; 3], &[0.0, 0.0, 0.7072, 0.7072], &[1.0; 3]);
        let expected = DVec3::new(-0.00026369, 1.00026369, 0.0);
        assert!(turned.transform_point3(DVec3::X).abs_diff_eq(expected, 1e-7));
    }

    #[test]
    fn offsets_that_do_not_match_change_nothing() {
        let mut points = [[0.0; 3]; 2];
        assert!(blend(&mut points, &[[2.0, 0.0, 0.0]], Some(&[1]), 0.5));
        assert_eq!(points, [[0.0; 3], [1.0, 0.0, 0.0]]);
        for indices in [None, Some(&[2][..]), Some(&[-1][..]), Some(&[0, 1][..])] {
            assert!(!blend(&mut points, &[[2.0, 0.0, 0.0]], indices, 0.5));
        }
        assert_eq!(points[0], [0.0; 3]);
    }
}
