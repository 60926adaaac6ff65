//! The searched space: every valid fibre, inclination, offset and window, as points of a unit cube.

use vellus::{Fiber, ScatterExit, Window};

/// Coordinates of a point: η, κ, α, β_m, β_n, σ_ca (3), σ_ms, σ_ma (3), g, l, θ_o, and the two ends of a window.
pub const DIMENSIONS: usize = 17;

/// A point of the unit cube.
pub type Point = [f64; DIMENSIONS];

/// One query.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub fiber: Fiber,
    /// θ_o, radians.
    pub theta_o: f64,
    /// h₁ < h₂.
    pub window: [f64; 2],
}

/// A part of the space, given by ranges of the parameters that matter most.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Lowest and highest η, β_n in degrees, g, and |θ_o| in degrees.
    pub eta: [f64; 2],
    pub beta_n: [f64; 2],
    pub g: [f64; 2],
    pub theta_o: [f64; 2],
    /// Whether absorption is the same in all channels.
    pub grey: bool,
}

impl Limits {
    /// The whole space.
    pub const NONE: Limits =
        Limits { eta: [1.0, 3.0], beta_n: [0.0, 91.0], g: [0.0, 1.0], theta_o: [0.0, 90.0], grey: false };

    /// Whether the case is inside these limits.
    pub fn hold(&self, case: &Case) -> bool {
        let within = |value: f64, [low, high]: [f64; 2]| low <= value && value <= high;
        within(case.fiber.eta.into(), self.eta)
            && within(case.fiber.beta_n.to_degrees().into(), self.beta_n)
            && within(case.fiber.g.into(), self.g)
            && within(case.theta_o.to_degrees().abs(), self.theta_o)
    }
}

/// The offsets that a hit represents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Offsets {
    /// The whole width.
    Far,
    /// Any window. One in four is a half of the width that starts at the axis.
    Window,
    /// One offset: the middle of `window`.
    Near,
}

/// Roughness in degrees: uniform in its logarithm over the valid range.
fn roughness(x: f64) -> f32 {
    ((0.1 * 900f64.powf(x)).clamp(0.1, 90.0) as f32).to_radians()
}

/// σ is 0 for a tenth of the axis. For the rest it is uniform in its logarithm from 0.001 to 1000.
fn sigma(x: f64) -> f32 {
    if x < 0.1 { 0.0 } else { 10f64.powf(-3.0 + 6.0 * (x - 0.1) / 0.9).min(1000.0) as f32 }
}

impl Case {
    /// The case at a point of the cube.
    pub fn at(x: &Point, offsets: Offsets, grey: bool, exit: ScatterExit) -> Case {
        let channels = |k: usize| [0, 1, 2].map(|c| sigma(x[if grey { k } else { k + c }]));
        let fiber = Fiber {
            // Quadratic and cubic in x, because small values are difficult.
            eta: (1.0 + 2.0 * x[0] * x[0]) as f32,
            kappa: (0.99 * x[1]) as f32,
            alpha: ((90.0 * x[2] - 45.0) as f32).to_radians(),
            beta_m: roughness(x[3]),
            beta_n: roughness(x[4]),
            sigma_ca: channels(5),
            sigma_ms: sigma(x[8]),
            sigma_ma: channels(9),
            // Uniform in ln(1 − g), like the tables.
            g: (1.0 - 0.05f64.powf(x[12])).min(0.95) as f32,
            layers: (20.0 * x[13].powi(3)) as f32,
            exit,
            ..Fiber::hair()
        };
        let theta_o = (179.98 * x[14] - 89.99).to_radians();
        let [a, b] = [x[15], x[16]];
        let window = match offsets {
            Offsets::Far => [-1.0, 1.0],
            Offsets::Window if a < 0.125 => [0.0, 1.0],
            Offsets::Window if a < 0.25 => [-1.0, 0.0],
            Offsets::Window => {
                // The middle of the window, and half of its width. The width is uniform in its logarithm from 0.002 to
                // 2.
                let (middle, half) = (2.0 * (a - 0.25) / 0.75 - 1.0, 0.001 * 1000f64.powf(b));
                [(middle - half).max(-1.0), (middle + half).min(1.0)]
            }
            Offsets::Near => [2.0 * a - 1.0; 2],
        };
        Case { fiber, theta_o, window: window.map(|h| f64::from(h as f32)) }
    }

    /// The window for the fast path.
    pub fn window(&self) -> Window {
        Window::range(self.window[0] as f32, self.window[1] as f32)
    }
}

impl std::fmt::Display for Case {
    fn fmt(&self, out: &mut std::fmt::Formatter) -> std::fmt::Result {
        let f = &self.fiber;
        write!(
            out,
            "eta {:.4} kappa {:.4} alpha {:.1}° beta_m {:.2}° beta_n {:.3}° sigma_ca {:?} sigma_ms {} sigma_ma {:?} \
             g {:.4} \
             layers {:.3} theta_o {:.2}° h {:.4}..{:.4}",
            f.eta,
            f.kappa,
            f.alpha.to_degrees(),
            f.beta_m.to_degrees(),
            f.beta_n.to_degrees(),
            f.sigma_ca,
            f.sigma_ms,
            f.sigma_ma,
            f.g,
            f.layers,
            self.theta_o.to_degrees(),
            self.window[0],
            self.window[1]
        )
    }
}
