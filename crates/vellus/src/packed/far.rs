//! The far field of one fibre as a table of azimuthal factors, for shaders.
//!
//! In the far field each lobe is a product of a longitudinal density, which a shader evaluates in closed form, and a
//! factor of the azimuth φ, which is an integral over all offsets (Yan17 Eq. 14). The factor also depends on the
//! inclination of ω_o. It is the same for φ and −φ, and for θ_o and −θ_o, because the cross-section is a circle.

use crate::bcsdf::Bcsdf;
use crate::far::window_hit::{WindowHit, WindowState};
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::Range;
use wide::f32x4;

/// The lobes that depend on the azimuth: R, TT, TRT, and the backward and the forward half of scattered light.
const FACTORS: usize = 5;

/// The factors, and those of TTˢ alone in both halves.
const PARTS: usize = 7;

/// Rows with energies at the beginning of each inclination, and one for light that leaves late.
const ENERGIES: usize = 8;

/// The far field of one fibre, for shaders.
#[derive(Clone, Debug)]
pub struct FarTable {
    /// All numbers, in rows of four.
    ///
    /// The first row has the number of inclinations, the number of azimuths, the azimuths per radian, and the number of
    /// rows of an inclination. Each inclination has the energies of the seven components (RGB, and the largest
    /// channel, which sampling uses; for scattered light that of its halves), a row whose first two numbers turn light
    /// that leaves late, the factors (azimuth by azimuth, RGB
    /// and the largest channel), the cumulative integrals of the last channel (factor by factor), and the part of TTˢ
    /// in the last two factors (azimuth by azimuth).
    pub rows: Vec<[f32; 4]>,
    /// The number of inclinations, from 0 to π/2, closer together toward π/2.
    pub inclinations: usize,
    /// The number of azimuths, evenly from 0 to π.
    pub azimuths: usize,
}

/// The fewest and the most nodes of an axis: each step of the search halves the distances.
const FEWEST: [usize; 2] = [33, 65];
const MOST: [usize; 2] = [257, 513];

/// The largest error of the interpolation along one axis, relative to the largest factor at an inclination. Both axes
/// together stay within 1 %.
const TOLERANCE: f32 = 0.005;

/// The share of inclinations that may err more. The closed forms of the far field choose between approximations, whose
/// results differ by up to 2 %. No number of nodes removes such a step.
const STEPS: f64 = 0.05;

/// The table of a fibre.
///
/// The number of nodes grows until linear interpolation errs by at most 0.5 % of the largest factor along each axis, at
/// 95 % of the inclinations.
pub fn far(bcsdf: &Bcsdf<'_>) -> FarTable {
    let inclinations = enough(FEWEST[0], MOST[0], |nodes| along(bcsdf, nodes));
    let azimuths = enough(FEWEST[1], MOST[1], |nodes| around(bcsdf, nodes));
    let length = ENERGIES + PARTS * azimuths + (FACTORS * azimuths).div_ceil(4);
    let number = |count: usize| count as f32;
    let per_radian = (f64::from(number(azimuths - 1)) / PI) as f32;
    let mut rows = vec![[number(inclinations), number(azimuths), per_radian, number(length)]];
    for node in 0..inclinations {
        let position = node as f64 / (inclinations - 1) as f64;
        at(bcsdf, position, |hit| inclination(&mut rows, hit, azimuths));
    }
    FarTable { rows, inclinations, azimuths }
}

/// Passes `f` the hit at a position from 0 to 1 along the axis of θ_o = π/2 · (1 − (1 − position)²). Nodes are closer
/// together toward π/2, where the reflectance changes most.
fn at<R>(bcsdf: &Bcsdf<'_>, position: f64, f: impl FnOnce(WindowHit<'_>) -> R) -> R {
    let prepared = bcsdf.prepared();
    let rest = 1.0 - position;
    let (sin, cos) = (FRAC_PI_2 * (1.0 - rest * rest)).sin_cos();
    let mut state = WindowState::new(prepared, [sin as f32, cos as f32, 0.0], [-1.0, 1.0]);
    state.prepare(prepared);
    f(WindowHit::new(prepared, &state))
}

/// The number of nodes whose errors are small enough. `errors` returns those at some inclinations.
fn enough(fewest: usize, most: usize, errors: impl Fn(usize) -> Vec<f32>) -> usize {
    let mut nodes = fewest;
    while nodes < most {
        let errors = errors(nodes);
        let large = errors.iter().filter(|error| **error > TOLERANCE).count();
        if large as f64 <= STEPS * errors.len() as f64 {
            break;
        }
        nodes = 2 * nodes - 1;
    }
    nodes
}

/// The errors in the middle between inclinations, at 256 azimuths.
fn along(bcsdf: &Bcsdf<'_>, nodes: usize) -> Vec<f32> {
    let positions = 2 * (nodes - 1);
    let rows: Vec<Vec<[f32x4; PARTS]>> =
        (0..=positions).map(|k| at(bcsdf, k as f64 / positions as f64, |hit| factors(hit, 256))).collect();
    rows.windows(3).step_by(2).map(|rows| error(|j| [rows[0][j], rows[1][j], rows[2][j]], 256)).collect()
}

/// The errors in the middle between azimuths, at 32 inclinations.
fn around(bcsdf: &Bcsdf<'_>, nodes: usize) -> Vec<f32> {
    let between = |k: u32| {
        let row = at(bcsdf, (f64::from(k) + 0.5) / 32.0, |hit| factors(hit, 2 * nodes - 1));
        error(|j| [row[2 * j], row[2 * j + 1], row[2 * j + 2]], nodes - 1)
    };
    (0..32).map(between).collect()
}

/// The largest difference between the middle one of three values and the mean of the others, relative to the largest
/// value.
fn error(values: impl Fn(usize) -> [[f32x4; PARTS]; 3], count: usize) -> f32 {
    let (mut most, mut largest) = (0.0f32, f32::MIN_POSITIVE);
    for j in 0..count {
        let [low, middle, high] = values(j);
        for p in 0..FACTORS {
            let difference = ((low[p] + high[p]) * f32x4::splat(0.5) - middle[p]).abs().to_array();
            most = difference.into_iter().fold(most, f32::max);
            largest = middle[p].to_array().into_iter().fold(largest, f32::max);
        }
    }
    most / largest
}

/// The factors at evenly spaced azimuths from 0 to π.
fn factors(hit: WindowHit<'_>, azimuths: usize) -> Vec<[f32x4; PARTS]> {
    let step = PI / (azimuths - 1) as f64;
    (0..azimuths).map(|j| hit.factors((j as f64 * step) as f32)).collect()
}

/// Adds the rows of one inclination.
fn inclination(rows: &mut Vec<[f32; 4]>, hit: WindowHit<'_>, azimuths: usize) {
    let step = PI / (azimuths - 1) as f64;
    let values = factors(hit, azimuths);
    let mut sums = [[0.0f64; 4]; FACTORS];
    let mut cumulative = vec![0.0f32; FACTORS * azimuths];
    for j in 1..azimuths {
        for p in 0..FACTORS {
            let (a, b) = (values[j - 1][p].to_array(), values[j][p].to_array());
            (0..4).for_each(|c| sums[p][c] += 0.5 * step * (f64::from(a[c]) + f64::from(b[c])));
            cumulative[p * azimuths + j] = sums[p][3] as f32;
        }
    }
    // The integrals over the circle are those of the interpolated factors, so that densities integrate to 1.
    let circle = sums.map(|sum| sum.map(|x| (2.0 * x) as f32));
    let parts = hit.component_energies().map(f32x4::to_array);
    let halves = [3, 4].map(|q| [parts[q][0], parts[q][1], parts[q][2], circle[q][3]]);
    rows.extend([circle[0], circle[1], circle[2], halves[0], halves[1], parts[5], parts[6]]);
    let [re, im] = hit.later();
    rows.push([re, im, 0.0, 0.0]);
    let factors =
        |range: Range<usize>| values.iter().flat_map(move |value| value[range.clone()].iter().map(|f| f.to_array()));
    rows.extend(factors(0..FACTORS));
    rows.extend(cumulative.chunks(4).map(|chunk| std::array::from_fn(|i| chunk.get(i).copied().unwrap_or(0.0))));
    rows.extend(factors(FACTORS..PARTS));
}
