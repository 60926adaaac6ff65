//! Converts the value types of USD.

use super::Numbers;
use openusd::sdf;

/// Converts any array or single value of numbers or vectors to single precision.
pub(super) fn numbers(value: sdf::Value) -> Option<Numbers> {
    use sdf::Value as V;
    fn flat<const N: usize, T, S>(values: impl IntoIterator<Item = T>, to_f32: impl Fn(S) -> f32) -> Option<Numbers>
    where
        T: Into<[S; N]>,
    {
        let values = values.into_iter().flat_map(|v| v.into().map(&to_f32)).collect();
        Some(Numbers { values, lanes: N })
    }
    let (single, double) = (|x: f32| x, |x: f64| x as f32);
    match value {
        V::Float(x) => Some(Numbers { values: vec![x], lanes: 1 }),
        V::Double(x) => Some(Numbers { values: vec![x as f32], lanes: 1 }),
        V::Half(x) => Some(Numbers { values: vec![x.to_f32()], lanes: 1 }),
        V::Int(x) => Some(Numbers { values: vec![x as f32], lanes: 1 }),
        // Whole numbers in the time samples of a text layer.
        V::Int64(x) => Some(Numbers { values: vec![x as f32], lanes: 1 }),
        V::Bool(x) => Some(Numbers { values: vec![x.into()], lanes: 1 }),
        V::BoolVec(v) => flat(v.into_iter().map(|x| [f32::from(x)]), single),
        V::FloatVec(v) => Some(Numbers { values: v, lanes: 1 }),
        V::DoubleVec(v) => flat(v.into_iter().map(|x| [x]), double),
        V::HalfVec(v) => flat(v.into_iter().map(|x| [x.to_f32()]), single),
        V::IntVec(v) => flat(v.into_iter().map(|x| [x as f32]), single),
        V::Vec2f(v) => flat([v], single),
        V::Vec2d(v) => flat([v], double),
        V::Vec3f(v) => flat([v], single),
        V::Vec3d(v) => flat([v], double),
        V::Vec4f(v) => flat([v], single),
        V::Vec4d(v) => flat([v], double),
        V::Vec2fVec(v) => flat(v, single),
        V::Vec2dVec(v) => flat(v, double),
        V::Vec2hVec(v) => flat(v.into_iter().map(|v| [v.x.to_f32(), v.y.to_f32()]), single),
        V::Vec3fVec(v) => flat(v, single),
        V::Vec3dVec(v) => flat(v, double),
        V::Vec3hVec(v) => flat(v.into_iter().map(|v| [v.x.to_f32(), v.y.to_f32(), v.z.to_f32()]), single),
        V::Vec4fVec(v) => flat(v, single),
        // Quaternions are x, y, z, w.
        V::QuatfVec(v) => flat(v.into_iter().map(|q| [q.x, q.y, q.z, q.w]), single),
        V::QuathVec(v) => flat(v.into_iter().map(|q| [q.x, q.y, q.z, q.w].map(|x| x.to_f32())), single),
        V::Vec4dVec(v) => flat(v, double),
        _ => None,
    }
}

/// Converts a single number, vector, quaternion or matrix to double precision.
pub(super) fn precise(value: sdf::Value) -> Option<Vec<f64>> {
    use sdf::Value as V;
    let quaternion = |[w, x, y, z]: [f64; 4]| Some(vec![x, y, z, w]);
    match value {
        V::Double(x) => Some(vec![x]),
        V::Int(x) => Some(vec![f64::from(x)]),
        V::Int64(x) => Some(vec![x as f64]),
        V::Vec2i(v) => Some(vec![v.x.into(), v.y.into()]),
        V::Vec2d(v) => Some(<[f64; 2]>::from(v).to_vec()),
        V::Vec3d(v) => Some(<[f64; 3]>::from(v).to_vec()),
        V::Vec3h(v) => Some(vec![v.x.to_f64(), v.y.to_f64(), v.z.to_f64()]),
        V::Vec4d(v) => Some(<[f64; 4]>::from(v).to_vec()),
        V::Quatf(q) => quaternion([q.w, q.x, q.y, q.z].map(f64::from)),
        V::Quatd(q) => quaternion([q.w, q.x, q.y, q.z]),
        V::Quath(q) => quaternion([q.w, q.x, q.y, q.z].map(|x| x.to_f64())),
        // USD multiplies row vectors, so its rows are the columns for column vectors.
        V::Matrix4d(m) => Some(m.0.to_vec()),
        V::Float(_) | V::Half(_) | V::Vec2f(_) | V::Vec3f(_) | V::Vec4f(_) => {
            numbers(value).map(|n| n.values.into_iter().map(f64::from).collect())
        }
        _ => None,
    }
}
