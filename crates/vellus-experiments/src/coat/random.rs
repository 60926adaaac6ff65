//! Random fibres and colours. The same number always gives the same.

use vellus::{Fiber, ScatterExit, Species};

/// SplitMix64.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Uniform in the logarithm.
    fn log(&mut self, low: f32, high: f32) -> f32 {
        self.between(low.ln(), high.ln()).exp()
    }
}

/// The absorptions of the cortex of random fibres.
const ABSORPTION: [f32; 2] = [0.003, 30.0];

/// A random fibre. A quarter are presets or published fibres. The others have η in 1.2 to 1.75, κ of 0 or 0.2 to 0.96,
/// α to 5°, β_m 2° to 20°, β_n 1.3° to 30°, σ_m,s 0.3 to 8, g to 0.85 and l 0.4 to 2.5. Three quarters have reflecting
/// exits. The absorption of the cortex is 0.003 to 30, a third of the range for each channel, and that of the medulla
/// is 0, 0.3 or 1 times as much.
pub fn random_fiber(number: u64) -> Fiber {
    let mut random = Random(number.wrapping_mul(0x1234_5678_9abc_def1));
    let exit = if random.unit() < 0.75 { ScatterExit::Reflecting } else { ScatterExit::Open };
    let kappa = if random.unit() < 0.15 { 0.0 } else { random.between(0.2, 0.96) };
    let mut fiber = Fiber {
        eta: random.between(1.2, 1.75),
        kappa,
        alpha: random.between(0.0, 5f32.to_radians()),
        beta_m: random.log(2.0, 20.0).to_radians(),
        beta_n: random.log(1.3, 30.0).to_radians(),
        sigma_ms: random.log(0.3, 8.0),
        g: random.between(0.0, 0.85),
        layers: random.between(0.4, 2.5),
        exit,
        ..Fiber::hair()
    };
    if random.unit() < 0.25 {
        let species = Species::ALL[(random.unit() * 10.0) as usize];
        fiber = if exit == ScatterExit::Open { Fiber::published(species) } else { Fiber::preset(species) };
    }
    let share = [0.0, 0.3, 1.0][(random.unit() * 3.0) as usize];
    let [least, most] = ABSORPTION.map(f32::ln);
    let sigma_ca: [f32; 3] = std::array::from_fn(|c| (least + (c as f32 + random.unit()) / 3.0 * (most - least)).exp());
    Fiber { sigma_ca, sigma_ma: sigma_ca.map(|sigma| share * sigma), ..fiber }
}

/// A random colour: its largest channel is 0.1 to 0.9, and the others are 5 to 100 % of it, uniform in the logarithm.
pub fn random_color(number: u64) -> [f32; 3] {
    let mut random = Random(number.wrapping_mul(0x9876_5432_1fed_cba1));
    let most = random.log(0.1, 0.9);
    let mut color = [most; 3];
    let first = (random.unit() * 3.0) as usize;
    color[(first + 1) % 3] = most * random.log(0.05, 1.0);
    color[(first + 2) % 3] = most * random.log(0.05, 1.0);
    color
}
