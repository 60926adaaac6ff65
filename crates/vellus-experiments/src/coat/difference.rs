//! The difference of two colours as people see it.

use crate::flip::lab;

/// CIEDE2000 of two colours in linear sRGB (Sharma, Wu and Dalal 2005, The CIEDE2000 Color-Difference Formula). White
/// is 1, 1, 1. About 1 is just visible side by side.
pub fn delta_e2000(a: [f64; 3], b: [f64; 3]) -> f64 {
    delta_e2000_of_labs(lab(a), lab(b))
}

/// CIEDE2000 of two colours in CIE L\*a\*b\*, with L\* in [0, 100].
pub fn delta_e2000_of_labs([l1, a1, b1]: [f64; 3], [l2, a2, b2]: [f64; 3]) -> f64 {
    let flat = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let g = 0.5 * (1.0 - flat(0.5 * (a1.hypot(b1) + a2.hypot(b2))));
    let (a1, a2) = ((1.0 + g) * a1, (1.0 + g) * a2);
    let (c1, c2) = (a1.hypot(b1), a2.hypot(b2));
    let hue = |a: f64, b: f64| if a == 0.0 && b == 0.0 { 0.0 } else { b.atan2(a).to_degrees().rem_euclid(360.0) };
    let (h1, h2) = (hue(a1, b1), hue(a2, b2));
    let is_grey = c1 * c2 == 0.0;
    // The difference of hues, in (−180°, 180°].
    let turn = if is_grey { 0.0 } else { 180.0 - (180.0 - (h2 - h1)).rem_euclid(360.0) };
    let (dl, dc) = (l2 - l1, c2 - c1);
    let dh = 2.0 * (c1 * c2).sqrt() * (0.5 * turn).to_radians().sin();
    let (l, c) = (0.5 * (l1 + l2), 0.5 * (c1 + c2));
    let h = match (is_grey, (h1 - h2).abs() <= 180.0) {
        (true, _) => h1 + h2,
        (_, true) => 0.5 * (h1 + h2),
        _ => (0.5 * (h1 + h2 + 360.0)).rem_euclid(360.0),
    };
    let cos = |degrees: f64| degrees.to_radians().cos();
    let t = 1.0 - 0.17 * cos(h - 30.0) + 0.24 * cos(2.0 * h) + 0.32 * cos(3.0 * h + 6.0) - 0.2 * cos(4.0 * h - 63.0);
    let rotation = 2.0 * flat(c) * (60.0 * (-((h - 275.0) / 25.0).powi(2)).exp()).to_radians().sin();
    let sl = 1.0 + 0.015 * (l - 50.0).powi(2) / (20.0 + (l - 50.0).powi(2)).sqrt();
    let (dl, dc, dh) = (dl / sl, dc / (1.0 + 0.045 * c), dh / (1.0 + 0.015 * c * t));
    (dl * dl + dc * dc + dh * dh - rotation * dc * dh).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of the test data of Sharma, Wu and Dalal 2005, Table 1.
    #[test]
    fn differences_agree_with_the_published_test_data() {
        for (a, b, expected) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, -1.0, 2.0], [50.0, 0.0, 0.0], 2.3669),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
            ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
        ] {
            let found = delta_e2000_of_labs(a, b);
            assert!((found - expected).abs() < 1e-4, "{a:?} {b:?}: {found}");
        }
    }
}
