//! FLIP: how visible the difference between two pictures is when a viewer alternates between them (Andersson et al.
//! 2020, "FLIP: A Difference Evaluator for Alternating Images", pictures of low dynamic range).
//!
//! The value of a pixel is 0 if the pictures look the same there, and at most 1. The colours are first blurred as the
//! eye blurs them at the distance of the viewer. Edges and points that only one picture has increase the value.

use std::f64::consts::PI;

/// Pixels per degree of the published default: a screen of 3,840 pixels that is as wide as it is far away.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// Sensitivity of the eye to lightness, red–green and blue–yellow: a₁, b₁, a₂, b₂ of two Gaussians (Table 1).
const SENSITIVITY: [[f64; 4]; 3] = [[1.0, 0.0047, 0.0, 1e-5], [1.0, 0.0053, 0.0, 1e-5], [34.1, 0.04, 13.5, 0.025]];
/// Exponents of the differences of colours and of features.
const COLOR_EXPONENT: f64 = 0.7;
const FEATURE_EXPONENT: f64 = 0.5;
/// The share of the largest difference of colours that maps to this value.
const BEND: [f64; 2] = [0.4, 0.95];
/// The width of a feature, degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// From linear sRGB to CIE XYZ (IEC 61966-2-1). The sums of the rows are the white point, daylight of 6504 K.
const XYZ: [[f64; 3]; 3] = [
    [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
    [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
    [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
];

/// The inverse of [`XYZ`].
const RGB: [[f64; 3]; 3] = [
    [3.241003275, -1.537398934, -0.498615861],
    [-0.969224334, 1.875930071, 0.041554224],
    [0.055639423, -0.204011202, 1.057148933],
];

/// A picture in linear sRGB, row by row. Values are clamped to [0, 1], as a display does.
#[derive(Clone, Debug)]
pub struct Shown {
    width: usize,
    pixels: Vec<[f64; 3]>,
}

impl Shown {
    /// A picture of this width. `color` returns linear sRGB at the column and the row.
    pub fn new([width, height]: [usize; 2], color: impl Fn(usize, usize) -> [f64; 3]) -> Self {
        let at = |i: usize| color(i % width.max(1), i / width.max(1)).map(|v| v.clamp(0.0, 1.0));
        Shown { width, pixels: (0..width * height).map(at).collect() }
    }
}

/// The value of each pixel, in [0, 1], row by row. `pixels_per_degree` is the number of pixels in a degree of the
/// viewer's sight. The result is empty if the sizes differ.
#[doc(alias = "FLIP")]
pub fn flip(reference: &Shown, test: &Shown, pixels_per_degree: f64) -> Vec<f64> {
    if (reference.width, reference.pixels.len()) != (test.width, test.pixels.len()) {
        return Vec::new();
    }
    let largest = hyab(hunt([0.0, 1.0, 0.0]), hunt([0.0, 0.0, 1.0])).powf(COLOR_EXPONENT);
    let [a, b] = [reference, test].map(|picture| perceived(picture, pixels_per_degree));
    let [edges, points] = features(reference, test, pixels_per_degree);
    let colors = a.iter().zip(&b).map(|(&p, &q)| {
        let (distance, bend) = (hyab(hunt(p), hunt(q)).powf(COLOR_EXPONENT), BEND[0] * largest);
        if distance < bend {
            BEND[1] * distance / bend
        } else {
            BEND[1] + (1.0 - BEND[1]) * (distance - bend) / (largest - bend)
        }
    });
    let features = edges.iter().zip(&points).map(|(e, p)| (e.max(*p) / 2f64.sqrt()).powf(FEATURE_EXPONENT));
    colors.zip(features).map(|(color, feature)| color.powf(1.0 - feature)).collect()
}

/// L*, a*, b* of linear sRGB, clamped to 0 to 1 as a display does (CIE 15:2004, Eq. 8.3 to 8.11).
pub(crate) fn lab(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative(rgb.map(|v| v.clamp(0.0, 1.0)))
        .map(|t| if t > (6.0f64 / 29.0).powi(3) { t.cbrt() } else { t * (29.0f64 / 6.0).powi(2) / 3.0 + 4.0 / 29.0 });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// X, Y, Z relative to those of white.
fn relative(rgb: [f64; 3]) -> [f64; 3] {
    XYZ.map(|row| row.iter().zip(rgb).map(|(m, v)| m * v).sum::<f64>() / row.iter().sum::<f64>())
}

/// L*, a*, b* where dark colours differ less: the effect of Hunt.
fn hunt(rgb: [f64; 3]) -> [f64; 3] {
    let [l, a, b] = lab(rgb);
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// The distance of two colours: the city-block distance of lightness and Euclidean distance of hue and chroma.
fn hyab(p: [f64; 3], q: [f64; 3]) -> f64 {
    (p[0] - q[0]).abs() + (p[1] - q[1]).hypot(p[2] - q[2])
}

/// Lightness, red–green and blue–yellow, linear in the light: Y, Cx, Cz.
fn opponent(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The inverse of [`opponent`], clamped to [0, 1].
fn displayed([l, a, b]: [f64; 3]) -> [f64; 3] {
    let y = (l + 16.0) / 116.0;
    let light: [f64; 3] = [y + a / 500.0, y, y - b / 200.0];
    let white = XYZ.map(|row| row.iter().sum::<f64>());
    RGB.map(|row| (0..3).map(|c| row[c] * light[c] * white[c]).sum::<f64>().clamp(0.0, 1.0))
}

/// The picture in linear sRGB as the eye sees it.
fn perceived(picture: &Shown, pixels_per_degree: f64) -> Vec<[f64; 3]> {
    let channels: Vec<[f64; 3]> = picture.pixels.iter().map(|&rgb| opponent(rgb)).collect();
    let widest = SENSITIVITY.iter().flat_map(|s| [s[1], s[3]]).fold(0.0, f64::max);
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i64;
    let seen: [Vec<f64>; 3] = std::array::from_fn(|c| {
        let plane: Vec<f64> = channels.iter().map(|v| v[c]).collect();
        let [a1, b1, a2, b2] = SENSITIVITY[c];
        let gaussians = [(a1, b1), (a2, b2)].map(|(a, b)| {
            let kernel = sampled(radius, |x| (-(PI * x / pixels_per_degree).powi(2) / b).exp());
            let sum: f64 = kernel.iter().sum();
            let filtered = if a > 0.0 { filter(&plane, picture.width, &unit(&kernel), &unit(&kernel)) } else { vec![] };
            (a * (PI / b).sqrt() * sum * sum, filtered)
        });
        let all: f64 = gaussians.iter().map(|(weight, _)| weight).sum();
        let mut sum = vec![0.0; plane.len()];
        for (weight, filtered) in &gaussians {
            sum.iter_mut().zip(filtered).for_each(|(sum, x)| *sum += weight / all * x);
        }
        sum
    });
    (0..channels.len()).map(|i| displayed([0, 1, 2].map(|c| seen[c][i]))).collect()
}

/// Differences of edges and of points.
fn features(reference: &Shown, test: &Shown, pixels_per_degree: f64) -> [Vec<f64>; 2] {
    let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as i64;
    let gaussian = |x: f64| (-0.5 * (x / deviation).powi(2)).exp();
    let smooth = unit(&sampled(radius, gaussian));
    let edge = balanced(&sampled(radius, |x| -x * gaussian(x)));
    let point = balanced(&sampled(radius, |x| ((x / deviation).powi(2) - 1.0) * gaussian(x)));
    let sizes = [reference, test].map(|picture| {
        let light: Vec<f64> = picture.pixels.iter().map(|&rgb| relative(rgb)[1]).collect();
        [&edge, &point].map(|kernel| {
            let along = filter(&light, picture.width, kernel, &smooth);
            let across = filter(&light, picture.width, &smooth, kernel);
            along.iter().zip(&across).map(|(x, y)| x.hypot(*y)).collect::<Vec<f64>>()
        })
    });
    let [a, b] = &sizes;
    [0, 1].map(|k| a[k].iter().zip(&b[k]).map(|(x, y)| (x - y).abs()).collect())
}

/// The values of a function at −radius, …, radius.
fn sampled(radius: i64, of: impl Fn(f64) -> f64) -> Vec<f64> {
    (-radius..=radius).map(|x| of(x as f64)).collect()
}

/// A kernel with the sum 1.
fn unit(kernel: &[f64]) -> Vec<f64> {
    let sum: f64 = kernel.iter().sum();
    kernel.iter().map(|x| x / sum).collect()
}

/// A kernel whose positive values sum to 1 and whose negative values sum to −1.
fn balanced(kernel: &[f64]) -> Vec<f64> {
    let sum = |sign: f64| kernel.iter().map(|x| (sign * x).max(0.0)).sum::<f64>();
    let [above, below] = [sum(1.0), sum(-1.0)];
    kernel.iter().map(|x| if *x > 0.0 { x / above } else { x / below }).collect()
}

/// A plane filtered by `across` along its rows and by `down` along its columns. Pixels at the border are repeated.
fn filter(plane: &[f64], width: usize, across: &[f64], down: &[f64]) -> Vec<f64> {
    let height = plane.len() / width.max(1);
    let pass = |plane: &[f64], kernel: &[f64], count: usize, step: usize, start: &dyn Fn(usize) -> usize| {
        let radius = (kernel.len() / 2) as i64;
        (0..plane.len())
            .map(|i| {
                let (place, first) = ((i / step % count) as i64, start(i));
                let at = |k: usize| (place + k as i64 - radius).clamp(0, count as i64 - 1) as usize;
                kernel.iter().enumerate().map(|(k, weight)| weight * plane[first + step * at(k)]).sum()
            })
            .collect::<Vec<f64>>()
    };
    let rows = pass(plane, across, width, 1, &|i| i / width * width);
    pass(&rows, down, height, width, &|i| i % width)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pictures with smooth colours, a step, a point and a line.
    fn pictures() -> [Shown; 2] {
        let [width, height] = [32, 24];
        let first = |x: usize, y: usize| {
            let (u, v) = (x as f64, y as f64);
            let blue = (u + v) / (width + height) as f64;
            [0.5 + 0.4 * (0.7 * u + 0.2 * v).sin(), 0.4 + 0.3 * (0.3 * u - 0.5 * v).cos(), blue]
        };
        let second = |x: usize, y: usize| {
            let [r, g, b] = first(x, y);
            let step = if (8..20).contains(&x) && (8..16).contains(&y) { 0.2 } else { 0.0 };
            match (x, y) {
                (25, 4) => [1.0; 3],
                (2..4, 18..) => [0.0; 3],
                _ => [0.9 * r, g + step, b],
            }
        };
        [Shown::new([width, height], first), Shown::new([width, height], second)]
    }

    /// The Python package flip-evaluator 1.7 computed the expected values from the same pictures in single precision:
    /// `evaluate(a, b, "LDR", inputsRGB=False, applyMagma=False)`; the second mean has `parameters={"ppd": 30.0}`. It
    /// rounds colours and filters to seven digits, and errors grow where a difference of colours is near 0.
    #[test]
    fn values_are_those_of_the_published_program() {
        let [a, b] = pictures();
        let found = flip(&a, &b, PIXELS_PER_DEGREE);
        let expected = [
            ([0, 0], 0.16529635),
            ([25, 4], 0.21923265),
            ([12, 12], 0.7217751),
            ([3, 20], 0.6345896),
            ([31, 23], 0.16502598),
            ([8, 10], 0.5464661),
            ([24, 5], 0.12730981),
        ];
        for ([x, y], value) in expected {
            assert!((found[y * 32 + x] - value).abs() < 1e-4, "{x} {y}: {} {value}", found[y * 32 + x]);
        }
        let mean = |found: &[f64]| found.iter().sum::<f64>() / found.len() as f64;
        assert!((mean(&found) - 0.235_478_684).abs() < 2e-5, "{}", mean(&found));
        let far = mean(&flip(&a, &b, 30.0));
        assert!((far - 0.224_965_408).abs() < 2e-5, "{far}");
    }

    #[test]
    fn equal_pictures_do_not_differ_and_sizes_must_agree() {
        let [a, b] = pictures();
        assert!(flip(&a, &a, PIXELS_PER_DEGREE).iter().all(|x| *x == 0.0));
        let [there, back] = [flip(&a, &b, 30.0), flip(&b, &a, 30.0)];
        assert!(there.iter().zip(&back).all(|(x, y)| (x - y).abs() < 1e-12 && (0.0..=1.0).contains(x)));
        assert!(flip(&a, &Shown::new([24, 32], |_, _| [0.0; 3]), 67.0).is_empty());
        assert!(flip(&Shown::new([0, 0], |_, _| [0.0; 3]), &Shown::new([0, 0], |_, _| [0.0; 3]), 67.0).is_empty());
        // Black against white has the largest difference of lightness, 100 of 203.
        let black = Shown::new([9, 9], |_, _| [0.0; 3]);
        let most = flip(&black, &Shown::new([9, 9], |_, _| [9.0; 3]), PIXELS_PER_DEGREE);
        assert!(most.iter().all(|x| *x > 0.95 && *x < 1.0), "{most:?}");
    }

    #[test]
    fn lab_matches_the_standard() {
        let close = |rgb: [f64; 3], expected: [f64; 3]| {
            let found = lab(rgb);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.05), "{found:?} {expected:?}");
        };
        close([1.0; 3], [100.0, 0.0, 0.0]);
        close([0.0; 3], [0.0; 3]);
        // Red has the published values of sRGB, within the digits of the white point.
        close([0.1842; 3], [50.0, 0.0, 0.0]);
        close([1.0, 0.0, 0.0], [53.24, 80.09, 67.20]);
        // A display clamps to white.
        close([9.0, 9.0, 9.0], [100.0, 0.0, 0.0]);
    }
}
