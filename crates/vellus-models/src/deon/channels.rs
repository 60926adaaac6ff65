//! The tables of the three channels of a fibre. Fibres that differ in colour only share tables and interpolate.

use super::azimuths::Azimuths;
use std::sync::{Arc, OnceLock};
use vellus::Fiber;

/// Tables over σ_c,a for one η and β_n. Each is computed on first use.
#[derive(Debug)]
struct Shared {
    eta: f32,
    beta_n: f32,
    tables: [OnceLock<Arc<Azimuths>>; NODES],
}

/// Number of nodes, up to σ_c,a = 19, where TT is negligible.
const NODES: usize = 32;

/// σ_c,a of a node. The spacing is 0.03 for transparent fibres, and a sixth of σ_c,a for dark ones.
fn node(k: usize) -> f32 {
    0.18 * ((k as f32 * 0.15).exp() - 1.0)
}

impl Shared {
    fn table(&self, k: usize) -> Arc<Azimuths> {
        let make = || Arc::new(Azimuths::new(self.eta, self.beta_n, node(k)));
        Arc::clone(self.tables[k].get_or_init(make))
    }

    fn between(&self, sigma: f32) -> Channel {
        let sigma = sigma.min(node(NODES - 1));
        let k = ((sigma / 0.18).ln_1p() / 0.15) as usize;
        let k = k.min(NODES - 2);
        // This is exact for the centre of TT, whose path is two radii long, and nearly exact for longer paths.
        let left = |sigma: f32| (-2.0 * sigma).exp();
        let (a, b) = (left(node(k)), left(node(k + 1)));
        let t = ((a - left(sigma)) / (a - b)).clamp(0.0, 1.0);
        Channel { tables: [self.table(k), self.table(k + 1)], t }
    }
}

/// One channel: an interpolation between two tables.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    tables: [Arc<Azimuths>; 2],
    t: f32,
}

impl Channel {
    #[inline(always)]
    fn mix(&self, of: impl Fn(&Azimuths) -> f32) -> f32 {
        let first = of(&self.tables[0]);
        // This form stays positive if one of the values is tiny.
        if self.t > 0.0 { (1.0 - self.t) * first + self.t * of(&self.tables[1]) } else { first }
    }

    /// N_p(φ).
    #[inline(always)]
    pub fn eval(&self, p: usize, theta: (usize, f32), phi: f32) -> f32 {
        self.mix(|table| table.eval(p, theta, phi))
    }

    /// ∫ N_p dφ.
    #[inline(always)]
    pub fn energy(&self, p: usize, theta: (usize, f32)) -> f32 {
        self.mix(|table| table.energy(p, theta))
    }

    /// Draws φ with the density N_p/∫ N_p.
    pub fn sample(&self, p: usize, theta: (usize, f32), [a, b]: [f32; 2]) -> f32 {
        let [first, second] = [0, 1].map(|k| self.tables[k].energy(p, theta));
        let share = self.t * second / ((1.0 - self.t) * first + self.t * second);
        let (table, b) = if b < share { (1, b / share) } else { (0, (b - share) / (1.0 - share)) };
        self.tables[table].sample(p, theta, [a, b.min(1.0 - f32::EPSILON)])
    }
}

/// The tables of all three channels.
#[derive(Clone, Debug)]
pub(super) struct Channels {
    pub rgb: [Channel; 3],
    /// The channel with the least absorption. It is the brightest in every direction.
    pub brightest: usize,
    shared: Arc<Shared>,
}

impl Channels {
    /// Computes exact tables for a fibre.
    pub fn new(fiber: &Fiber) -> Self {
        let (eta, beta_n) = (fiber.eta, fiber.beta_n);
        let shared = Arc::new(Shared { eta, beta_n, tables: [const { OnceLock::new() }; NODES] });
        let mut rgb: Vec<Channel> = Vec::with_capacity(3);
        for (c, &sigma) in fiber.sigma_ca.iter().enumerate() {
            let known = fiber.sigma_ca[..c].iter().position(|&s| s == sigma);
            let table = known
                .map_or_else(|| Arc::new(Azimuths::new(eta, beta_n, sigma)), |same| Arc::clone(&rgb[same].tables[0]));
            rgb.push(Channel { tables: [Arc::clone(&table), table], t: 0.0 });
        }
        Channels { rgb: std::array::from_fn(|c| rgb[c].clone()), brightest: brightest(fiber), shared }
    }

    /// Interpolates between shared tables, if η and β_n are the same.
    pub fn with_fiber(&self, fiber: &Fiber) -> Option<Self> {
        let shared = &self.shared;
        (shared.eta == fiber.eta && shared.beta_n == fiber.beta_n).then(|| Channels {
            rgb: fiber.sigma_ca.map(|sigma| shared.between(sigma)),
            brightest: brightest(fiber),
            shared: Arc::clone(shared),
        })
    }
}

fn brightest(fiber: &Fiber) -> usize {
    (0..3).min_by(|&a, &b| fiber.sigma_ca[a].total_cmp(&fiber.sigma_ca[b])).unwrap_or(0)
}
