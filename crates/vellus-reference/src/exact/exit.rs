//! D17: the share of scattered light that leaves the fibre, for [`vellus::ScatterExit::Reflecting`].
//!
//! Light that left the medulla is in one of the states of [`vellus::parts::cell`]. V, the share of it that leaves the
//! fibre, is the solution of V = A + B (U V + (1 − U) G x) with x = Σ ψ V, where A is the light that leaves at once,
//! and B the light that returns to the medulla. This module takes all means over a state by
//! quadrature, and solves the 24 equations by Gaussian elimination.

use super::formulas::fresnel;
use std::f64::consts::PI;
use vellus::parts::{
    ABSORPTIONS, ENTRIES, ExitData, MAX_SIN2, NODES, REACHES, ROWS, STATES, STEEP, TAU_STEP, absorption_at, cell,
    monomials,
};
use vellus::{Error, Fiber, grid};

/// Midpoints over each side of a cell.
const POINTS: usize = 64;

/// The exit of scattered light.
#[derive(Clone, Debug)]
pub struct ExactExit {
    /// Coefficients of [`monomials`], RGB: the share that leaves, and the logarithm of what absorption on the first
    /// path leaves, and the share of escaping light that leaves when it first meets the cuticle.
    polynomials: [[[f64; ENTRIES]; 3]; 3],
    turning: Turning,
}

/// D19, D20: how the cuticle turns scattered light in azimuth.
#[derive(Clone, Debug)]
pub(super) struct Turning {
    /// The angles of the constant, of cos ψ and of sin ψ, radians: per h″, per h″, and per 1 − h″².
    pub parts: [f64; 3],
    /// The slope of the angle by which the cuticle turns light, over the offset at which it leaves the medulla.
    pub slope: f64,
    /// The share of light that is turned as TT is.
    pub straight: f64,
    /// The mean of e^(i(φ − φ_c)) over light that leaves later, where φ_c is the azimuth where it enters the medulla.
    pub stays: f64,
}

impl Turning {
    fn new(fiber: &Fiber, data: &ExitData, states: &[State]) -> Self {
        let [kappa, g] = [fiber.kappa, fiber.g].map(f64::from);
        let tau = f64::from(fiber.sigma_ms) * kappa;
        let (four, two) = gauss();
        let [slope, reach] = outward(&Shell::new(fiber), [&four, &two]);
        let at = ((reach - REACHES[0]) / 0.2).clamp(0.0, 3.0);
        let low = (at as usize).min(REACHES.len() - 2);
        let mut parts = [0.0; 3];
        for (node, weight) in around(data, tau, g) {
            for (k, part) in parts.iter_mut().enumerate() {
                let value = |reach: usize| f64::from(data.turns[(node * REACHES.len() + reach) * 3 + k]);
                *part += weight * slope * (value(low) + (at - low as f64) * (value(low + 1) - value(low)));
            }
        }
        let mean = |value: fn(&State) -> f64| states.iter().map(|s| s.weight * value(s)).sum::<f64>();
        let reflected = 1.0 - mean(|s| s.through);
        let isotropic = tau * (1.0 - g);
        let pass = (isotropic - 1.15).max(0.0) / (isotropic + 0.79);
        let again = pass * mean(|s| s.keeps);
        let stays = 0.68 * pass * again * (1.0 - reflected) / (1.0 - again * reflected);
        Turning { parts, slope, straight: g.powi(4) * (-isotropic).exp(), stays }
    }
}

/// The least-squares slope of the angle by which the cuticle turns light that leaves, over its offset in the medulla,
/// and the mean of the largest offset at which light leaves. Light is diffuse inside the fibre. `points` are midpoints
/// of [0, 1] and their weights, for the sine of the inclination, and for the offset, dense near its limit.
fn outward(shell: &Shell, points: [&[[f64; 2]]; 2]) -> [f64; 2] {
    let Shell { eta, eta_m, kappa, layers } = *shell;
    let (mut line, mut square, mut limits, mut limits_squared) = (0.0, 0.0, 0.0, 0.0);
    for [s, weight] in points[0] {
        let cos_m = (1.0 - (s / eta_m).powi(2)).sqrt();
        let inside = weight * cos_m;
        let [cortex_prime, eta_prime] = [eta, eta_m].map(|eta| ((eta * eta - s * s) / (1.0 - s * s)).sqrt());
        let limit = (1.0 / (eta_prime * kappa)).min(1.0);
        limits += inside * limit;
        limits_squared += inside * limit * limit;
        for [t, weight] in points[1] {
            let h = limit * t * (2.0 - t);
            let [angle, turned] = [kappa * h, eta_prime * kappa * h].map(|x| x.min(1.0).asin());
            let passed = 1.0 - fresnel(eta, layers, (1.0 - s * s).sqrt() * turned.cos());
            let wall = if eta_m < eta { fresnel(eta / eta_m, 0.5, cos_m * (1.0 - h * h).sqrt()) } else { 0.0 };
            let in_cortex = h * eta_prime / cortex_prime;
            let more = if eta_m < eta { in_cortex.asin() - h.asin() + angle - (kappa * in_cortex).asin() } else { 0.0 };
            let weight = inside * weight * (1.0 - t) * limit * passed * (1.0 - wall) * h;
            line += weight * (turned - angle + more);
            square += weight * h;
        }
    }
    [line / square, limits_squared / limits]
}

/// Gauss–Legendre points on [0, 1], and their weights.
fn gauss() -> ([[f64; 2]; 4], [[f64; 2]; 2]) {
    let (near, far) = ((3.0 / 7.0 - 2.0 / 7.0 * 1.2f64.sqrt()).sqrt(), (3.0 / 7.0 + 2.0 / 7.0 * 1.2f64.sqrt()).sqrt());
    let (heavy, light) = ((18.0 + 30f64.sqrt()) / 72.0, (18.0 - 30f64.sqrt()) / 72.0);
    let four = [[-far, light], [-near, heavy], [near, heavy], [far, light]];
    let two = [-1.0, 1.0].map(|sign| [sign / 3f64.sqrt(), 0.5]);
    (four.map(|[x, w]| [0.5 + 0.5 * x, w]), two.map(|[x, w]| [0.5 + 0.5 * x, w]))
}

/// What is around the medulla.
struct Shell {
    eta: f64,
    /// The index of the medulla.
    eta_m: f64,
    kappa: f64,
    layers: f64,
}

impl Shell {
    fn new(fiber: &Fiber) -> Self {
        let [eta, eta_m, kappa, layers] = [fiber.eta, fiber.medulla_eta(), fiber.kappa, fiber.layers].map(f64::from);
        Shell { eta, eta_m, kappa, layers }
    }

    /// D24: means over a state of the reflectance of the wall, the transmittance of the cuticle, and the length of the
    /// path from the wall to the cuticle.
    fn around(&self, state: usize) -> [f64; 3] {
        let [inclinations, offsets] = cell(state);
        let (mut sums, mut weights) = ([0.0; 3], 0.0);
        for (theta, h) in midpoints(inclinations, POINTS).flat_map(|t| midpoints(offsets, POINTS).map(move |h| (t, h)))
        {
            let weight = theta.cos().powi(2);
            let [sin_t, sin_i] = [self.eta_m / self.eta, self.eta_m].map(|ratio| ratio * theta.sin());
            let cos_t = (1.0 - sin_t * sin_t).sqrt();
            let wall = fresnel(self.eta / self.eta_m, 0.5, theta.cos() * (1.0 - h * h).sqrt());
            // Snell's law in the normal plane keeps the index times the cosine of the inclination times the sine.
            let aside = self.eta_m * theta.cos() * self.kappa * h;
            let outside = 1.0 - sin_i * sin_i - aside * aside;
            let through = if outside > 0.0 { 1.0 - fresnel(self.eta, self.layers, outside.sqrt()) } else { 0.0 };
            let offset = aside / (self.eta * cos_t);
            let way = (1.0 - offset * offset).sqrt() - (self.kappa * self.kappa - offset * offset).max(0.0).sqrt();
            [wall, through, way / cos_t].iter().zip(&mut sums).for_each(|(x, sum)| *sum += weight * x);
            weights += weight;
        }
        sums.map(|sum| sum / weights)
    }
}

/// Means over one state, weighted by cos²θ′.
struct State {
    /// The share of diffuse light.
    weight: f64,
    /// The length of the chord through the medulla, in radii of the medulla.
    chord: f64,
    /// The length of the path from the medulla to the cuticle, in fibre radii.
    cortex: f64,
    /// The transmittance of the cuticle.
    through: f64,
    /// The reflectance of the medulla's wall.
    wall: f64,
    /// The cosine of the angle around the fibre of a reflection at the cuticle.
    keeps: f64,
    /// [`monomials`] of the entry.
    entry: [f64; ENTRIES],
}

/// `n` midpoints from `a` to `b`.
fn midpoints([a, b]: [f64; 2], n: usize) -> impl Iterator<Item = f64> {
    (0..n).map(move |i| a + (b - a) * (i as f64 + 0.5) / n as f64)
}

/// The mean transmittance of the cuticle for the light of one state.
///
/// Light with cos θ′ cos γ below the critical cosine is totally reflected. Near the critical angle the reflectance
/// rises with a square root, so the points are dense there.
fn transmittance(eta: f64, kappa: f64, layers: f64, state: usize) -> f64 {
    let [[a, b], offsets] = cell(state);
    let critical = (1.0 - 1.0 / (eta * eta)).max(0.0).sqrt();
    let all: f64 = midpoints([a, b], POINTS).map(|theta| theta.cos().powi(2)).sum::<f64>() * (b - a) / POINTS as f64;
    let mut sum = 0.0;
    for h in midpoints(offsets, POINTS) {
        let cos_gamma = (1.0 - (kappa * h).powi(2)).sqrt();
        let last = (critical / cos_gamma).min(1.0).acos().min(b);
        if last <= a {
            continue;
        }
        for s in midpoints([0.0, 1.0], POINTS) {
            let theta = last - (last - a) * s * s;
            let slope = 2.0 * s * (last - a);
            // The reflectance is the same from both sides of the cuticle. The angle outside follows from Snell's law.
            let cos = theta.cos() * cos_gamma;
            let outside = (1.0 - eta * eta * (1.0 - cos * cos)).max(0.0).sqrt();
            sum += (1.0 - fresnel(eta, layers, outside)) * theta.cos().powi(2) * slope;
        }
    }
    sum / (POINTS * POINTS) as f64 / all
}

impl State {
    fn new(shell: &Shell, state: usize) -> Self {
        let Shell { eta, eta_m, kappa, layers } = *shell;
        let [inclinations, offsets] = cell(state);
        let mean = |range: [f64; 2], weight: fn(f64) -> f64, value: fn(f64) -> f64| {
            let points = || midpoints(range, 1000);
            points().map(|x| weight(x) * value(x)).sum::<f64>() / points().map(weight).sum::<f64>()
        };
        let squared_cosine = |theta: f64| theta.cos().powi(2);
        let elongation = mean(inclinations, squared_cosine, |theta| 1.0 / theta.cos());
        let half_chord = mean(offsets, |_| 1.0, |h| (1.0 - h * h).sqrt());
        // The cortex is measured at the middle of the offsets.
        let middle = 0.5 * (offsets[0] + offsets[1]);
        let cos_gamma = (1.0 - (kappa * middle).powi(2)).sqrt();
        let cos = half_chord * cos_gamma + kappa * middle * middle;
        let share: f64 = midpoints(inclinations, 1000).map(squared_cosine).sum::<f64>() / 1000.0;
        let [wall, through, cortex] = match eta_m < eta {
            true => shell.around(state),
            false => {
                let length = (cos_gamma - kappa * half_chord).max(0.0) * elongation;
                [0.0, transmittance(eta, kappa, layers, state), length]
            }
        };
        State {
            weight: share * (inclinations[1] - inclinations[0]) / (0.25 * PI) * (offsets[1] - offsets[0]),
            chord: 2.0 * half_chord * elongation,
            cortex,
            through,
            wall,
            keeps: 2.0 * cos * cos - 1.0,
            entry: mean_entry([inclinations, offsets]),
        }
    }
}

/// The means of [`monomials`] over light in a cell that enters the medulla.
fn mean_entry([inclinations, offsets]: [[f64; 2]; 2]) -> [f64; ENTRIES] {
    let (mut sums, mut weights) = ([0.0; ENTRIES], 0.0);
    for h in midpoints(offsets, POINTS) {
        for theta in midpoints(inclinations, POINTS) {
            let weight = theta.cos().powi(2);
            let values = monomials((1.0 - h * h).sqrt(), theta.sin().powi(2) / MAX_SIN2);
            sums.iter_mut().zip(values).for_each(|(sum, x)| *sum += weight * x);
            weights += weight;
        }
    }
    sums.map(|sum| sum / weights)
}

/// The nodes of the table around τ and g, and their weights.
fn around(data: &ExitData, tau: f64, g: f64) -> [(usize, f64); 4] {
    let on = |x: f64, nodes: usize| {
        let x = x.clamp(0.0, (nodes - 1) as f64);
        let i = (x as usize).min(nodes - 2);
        (i, x - i as f64)
    };
    let [taus, gs] = data.nodes;
    let ((i, s), (j, t)) =
        (on(grid::tau_position(tau) / TAU_STEP, taus), on(grid::g_position(g) * (gs - 1) as f64, gs));
    [
        (i * gs + j, (1.0 - s) * (1.0 - t)),
        (i * gs + j + 1, (1.0 - s) * t),
        ((i + 1) * gs + j, s * (1.0 - t)),
        ((i + 1) * gs + j + 1, s * t),
    ]
}

/// The rows of the table at τ and g, by bilinear interpolation. The probabilities of the states sum to 1 at each node.
fn rows(data: &ExitData, tau: f64, g: f64) -> [[f64; ENTRIES]; ROWS] {
    let mut sum = [[0.0; ENTRIES]; ROWS];
    for (node, weight) in around(data, tau, g) {
        let value = |row: usize, entry: usize| f64::from(data.values[(node * ROWS + row) * ENTRIES + entry]);
        for entry in 0..ENTRIES {
            let all: f64 = (0..STATES).map(|row| value(row, entry)).sum();
            for (row, out) in sum.iter_mut().enumerate() {
                out[entry] += weight * value(row, entry) / if row < STATES { all } else { 1.0 };
            }
        }
    }
    sum
}

/// ln E[e^(−a path)] at each node of the entry. The effective path is linear in ln(1 + 4a) between its nodes.
fn ln_kept(rows: &[[f64; ENTRIES]; ROWS], a: f64) -> [f64; ENTRIES] {
    let position = |a: f64| (1.0 + 4.0 * a).ln();
    let node = (0..ABSORPTIONS - 2).rev().find(|&k| absorption_at(k) <= a).unwrap_or(0);
    let [low, high] = [node, node + 1].map(|k| position(absorption_at(k)));
    let t = ((position(a) - low) / (high - low)).min(1.0);
    std::array::from_fn(|entry| {
        let [low, high] = [0, 1].map(|k| rows[STATES + node + k][entry]);
        let (line, inverse) = ((1.0 - t) * low + t * high, 1.0 / ((1.0 - t) / low + t / high));
        // A dense medulla, where the effective path falls fast from its mean.
        let [most, least] = STEEP.map(f64::from);
        let share = if node == 0 { ((most - high / low) / (most - least)).clamp(0.0, 1.0) } else { 0.0 };
        let path = 1.0 / ((1.0 - share) / line + share / inverse);
        // The product does not exceed that of the next node.
        -(a * path).min(absorption_at(node + 1) * high)
    })
}

/// Solves a linear system by Gaussian elimination with pivots.
fn solve<const N: usize>(mut a: [[f64; N]; N], mut b: [f64; N]) -> [f64; N] {
    for i in 0..N {
        let pivot = (i..N).fold(i, |best, k| if a[k][i].abs() > a[best][i].abs() { k } else { best });
        a.swap(i, pivot);
        b.swap(i, pivot);
        for k in i + 1..N {
            let factor = a[k][i] / a[i][i];
            for j in i..N {
                a[k][j] -= factor * a[i][j];
            }
            b[k] -= factor * b[i];
        }
    }
    for i in (0..N).rev() {
        let known: f64 = (i + 1..N).map(|j| a[i][j] * b[j]).sum();
        b[i] = (b[i] - known) / a[i][i];
    }
    b
}

/// The coefficients of the polynomial with these values at the nodes.
fn polynomial(values: [f64; ENTRIES]) -> [f64; ENTRIES] {
    solve(NODES.map(|[c, y]| monomials(c, y)), values)
}

fn at(polynomial: &[f64; ENTRIES], c: f64, y: f64) -> f64 {
    monomials(c, y).iter().zip(polynomial).map(|(m, p)| m * p).sum()
}

impl ExactExit {
    /// `None` if all scattered light leaves: the exit is open, or the medulla does not scatter.
    ///
    /// # Errors
    /// [`Error::Table`] if the table of first exits is damaged.
    pub fn new(fiber: &Fiber) -> Result<Option<Self>, Error> {
        if fiber.exit == vellus::ScatterExit::Open || fiber.kappa * fiber.sigma_ms == 0.0 {
            return Ok(None);
        }
        let fiber = &fiber.in_air();
        let data = ExitData::from_bytes(vellus::parts::SHIPPED_EXITS)?;
        let [kappa, g] = [fiber.kappa, fiber.g].map(f64::from);
        let tau = f64::from(fiber.sigma_ms) * kappa;
        let shell = Shell::new(fiber);
        let states: Vec<State> = (0..STATES).map(|state| State::new(&shell, state)).collect();
        let rows = rows(&data, tau, g);
        let turning = Turning::new(fiber, &data, &states);
        let mut exit = ExactExit { polynomials: [[[0.0; ENTRIES]; 3]; 3], turning };
        for channel in 0..3 {
            let medulla = f64::from(fiber.sigma_ma[channel]) * kappa;
            let kept = ln_kept(&rows, medulla);
            let absorption = Absorption::new(&states, polynomial(kept), tau, g, medulla);
            let [value, at_once] =
                leaving(&states, tau * (1.0 - g).powf(0.7), f64::from(fiber.sigma_ca[channel]), &absorption);
            // The probability of each state, times the factor √k of absorption.
            let mean = |value: &[f64; STATES]| -> [f64; ENTRIES] {
                std::array::from_fn(|entry| {
                    let light = |state: usize| rows[state][entry] * absorption.root[state];
                    let sum: f64 = (0..STATES).map(|state| light(state) * value[state]).sum();
                    // The probabilities of rare states may be below 0, and the sum of all too.
                    (sum / (0..STATES).map(light).sum::<f64>().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
                })
            };
            let [all, first] = [value, at_once].map(|value| mean(&value));
            let share = std::array::from_fn(|k| (first[k] / all[k].max(f64::MIN_POSITIVE)).min(1.0));
            exit.polynomials[channel] = [polynomial(all), polynomial(kept), polynomial(share)];
        }
        Ok(Some(exit))
    }

    /// The share of scattered light that leaves, and the share of that light that leaves when it first meets the
    /// cuticle, RGB, for the offset in the medulla h″ and the inclination θ_t of the light that enters.
    pub fn escape(&self, h: f64, theta_t: f64) -> [[f64; 3]; 2] {
        let (c, y) = ((1.0 - h * h).max(0.0).sqrt(), theta_t.sin().powi(2) / MAX_SIN2);
        let [mut escape, mut first] = [[0.0; 3]; 2];
        for (channel, [all, kept, share]) in self.polynomials.iter().enumerate() {
            escape[channel] = at(all, c, y).clamp(0.0, 1.0) * at(kept, c, y).min(0.0).exp();
            first[channel] = at(share, c, y).clamp(0.0, 1.0);
        }
        [escape, first]
    }

    /// How the cuticle turns scattered light.
    pub(super) fn turning(&self) -> &Turning {
        &self.turning
    }
}

/// The density over sin θᵢ of light that leaves later: ∝ cos²θᵢ over θᵢ.
pub(super) fn diffuse(theta_i: f64) -> f64 {
    2.0 * theta_i.cos() / PI
}

/// The effect of absorption in the medulla on light in each state.
struct Absorption {
    /// What remains of light that crosses the medulla unscattered.
    chord: [f64; STATES],
    /// √k. Absorption leaves k of scattered light that entered in a state. The probability to leave in this state has
    /// the factor √k.
    root: [f64; STATES],
    /// G, what remains of light that the chain has as scattered.
    scattered: [f64; STATES],
}

impl Absorption {
    /// `ln_kept` is the polynomial of ln k in the entry, and `medulla` is σ_ma κ.
    fn new(states: &[State], ln_kept: [f64; ENTRIES], tau: f64, g: f64, medulla: f64) -> Self {
        let mut all = Absorption { chord: [1.0; STATES], root: [1.0; STATES], scattered: [1.0; STATES] };
        if medulla == 0.0 {
            return all;
        }
        for (i, state) in states.iter().enumerate() {
            let mean: f64 = state.entry.iter().zip(ln_kept).map(|(x, k)| x * k).sum();
            let kept = mean.min(0.0).exp();
            all.root[i] = kept.sqrt();
            all.chord[i] = (-medulla * state.chord).exp();
            // The chain has (1 − g) σ_ms. So it passes more light as unscattered than the medulla does. The rest must
            // carry what the medulla leaves of all light.
            let [scattered, isotropic] = [tau, tau * (1.0 - g).powf(0.7)].map(|tau| -(-tau * state.chord).exp_m1());
            let light = scattered * kept + (isotropic - scattered) * all.chord[i];
            all.scattered[i] = (light / isotropic).clamp(0.0, 1.0);
        }
        all
    }
}

/// V, the share of the light in each state that leaves, and the part of it that leaves at once. `tau` is the optical
/// radius of isotropic scattering, and `cortex` is σ_ca.
fn leaving(states: &[State], tau: f64, cortex: f64, absorption: &Absorption) -> [[f64; STATES]; 2] {
    let scattered: Vec<f64> = states.iter().map(|s| -(-tau * s.chord).exp_m1()).collect();
    // ψ, not normalised.
    let again: Vec<f64> = (0..states.len()).map(|j| states[j].weight * scattered[j] * absorption.root[j]).collect();
    let all: f64 = again.iter().sum();
    let (mut matrix, mut once) = ([[0.0; STATES]; STATES], [0.0; STATES]);
    for (i, state) in states.iter().enumerate() {
        let c = (-cortex * state.cortex).exp();
        // Between the wall and the cuticle, light goes back and forth.
        let between = 1.0 / (1.0 - state.wall * (1.0 - state.through) * c * c);
        let passes = (1.0 - state.wall) * between;
        let reflected = state.wall + (1.0 - state.wall) * passes * (1.0 - state.through) * c * c;
        once[i] = passes * state.through * c;
        let row = reflected * scattered[i] * absorption.scattered[i] / all.max(f64::MIN_POSITIVE);
        (0..STATES).for_each(|j| matrix[i][j] = -row * again[j]);
        matrix[i][i] += 1.0 - reflected * (-tau * state.chord).exp() * absorption.chord[i];
    }
    [solve(matrix, once), once]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four and two points are enough for the slope and the limit, which the azimuths of scattered light need. They
    /// are within 7 % of the slope, which is at most 4° of azimuth.
    #[test]
    fn few_points_follow_many() {
        let many: Vec<[f64; 2]> = midpoints([0.0, 1.0], 400).map(|x| [x, 1.0 / 400.0]).collect();
        let (four, two) = gauss();
        for (eta, kappa, layers) in
            [(1.05, 0.9, 1.0), (1.3, 0.5, 2.0), (1.55, 0.95, 0.5), (1.9, 0.98, 1.0), (2.5, 0.8, 1.0)]
        {
            let shell = Shell { eta, eta_m: eta, kappa, layers };
            let [exact, few] = [outward(&shell, [&many, &many]), outward(&shell, [&four, &two])];
            println!("{eta} {kappa}: {exact:.4?} {few:.4?}");
            let errors = [0, 1].map(|k| (few[k] - exact[k]).abs());
            assert!(errors[0] < 0.07 * exact[0].max(0.2) && errors[1] < 0.02, "{eta} {kappa}: {exact:?} {few:?}");
        }
    }
}
