//! Colours of melanin with three channels beside 31 wavelengths: `cargo run --release --bin spectral`.
//!
//! The albedo of a fibre to the power of 1, 5 and 20 is light after as many bounces. CIEDE2000 compares the colour from
//! the RGB constants of [`Color::Melanin`] in white light with that from the spectrum in three lights, white-balanced.

use glam::{DMat3, DVec3};
use std::error::Error;
use vellus::{Bcsdf, Color, Fiber, Species};
use vellus_experiments::coat::delta_e2000_of_labs;
use vellus_models::energies;

/// Concentrations of eumelanin and pheomelanin: blond, red, brown, dark brown, black.
const PIGMENTS: [[f32; 2]; 5] = [[0.1, 0.05], [0.2, 1.0], [0.6, 0.1], [1.3, 0.2], [4.0, 0.0]];

const BOUNCES: [i32; 3] = [1, 5, 20];

/// 400 to 700 nm in steps of 10 nm.
const WAVELENGTHS: usize = 31;

type Spectrum = [f64; WAVELENGTHS];

/// Evaluates a function of the wavelength in nanometres.
fn spectrum(value: impl Fn(f64) -> f64) -> Spectrum {
    std::array::from_fn(|i| value(400.0 + 10.0 * i as f64))
}

/// The absorption of melanin, per fibre radius: the exponents of Donner and Jensen 2006, A Spectral BSSRDF for Shading
/// Human Skin. At 641, 550 and 449 nm this is within 3 % of the RGB constants.
fn absorption([eumelanin, pheomelanin]: [f32; 2]) -> Spectrum {
    let [e, p] = [eumelanin, pheomelanin].map(f64::from);
    spectrum(|l| e * 0.697 * (l / 550.0).powf(-3.33) + p * 0.4 * (l / 550.0).powf(-4.75))
}

/// The observer of CIE 1931: the multi-lobe fit of Wyman, Sloan and Shirley 2013, Simple Analytic Approximations to
/// the CIE XYZ Color Matching Functions.
fn observer(l: f64) -> DVec3 {
    let lobe = |height: f64, mean: f64, below: f64, above: f64| {
        height * (-0.5 * ((l - mean) / if l < mean { below } else { above }).powi(2)).exp()
    };
    DVec3::new(
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) - lobe(0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    )
}

/// The tristimulus values of light.
fn xyz(light: &Spectrum) -> DVec3 {
    light.iter().enumerate().map(|(i, x)| *x * observer(400.0 + 10.0 * i as f64)).sum()
}

/// CIE standard illuminant of daylight, 6504 K (ISO/CIE 11664-2).
const DAYLIGHT: Spectrum = [
    82.755, 91.486, 93.432, 86.682, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811, 109.354, 107.802, 104.79,
    107.689, 104.405, 104.046, 100.0, 96.334, 95.788, 88.686, 90.006, 89.599, 87.699, 83.289, 83.699, 80.027, 80.215,
    82.278, 78.284, 69.721, 71.609,
];

/// The lights: daylight, a light bulb (CIE standard illuminant A), and a lamp of three bands of 20 nm full width at
/// half maximum, as white as daylight.
fn lights() -> [(&'static str, Spectrum); 3] {
    let planck = |l: f64| l.powi(-5) / (1.435e7 / (2848.0 * l)).exp_m1();
    let bulb = spectrum(|l| 100.0 * planck(l) / planck(560.0));
    let band = |centre: f64| spectrum(|l| (-(4.0 * 2f64.ln()) * ((l - centre) / 20.0).powi(2)).exp());
    let bands = [450.0, 545.0, 610.0].map(band);
    let shares = DMat3::from_cols(xyz(&bands[0]), xyz(&bands[1]), xyz(&bands[2])).inverse() * xyz(&DAYLIGHT);
    let lamp = std::array::from_fn(|i| (0..3).map(|k| shares[k] * bands[k][i]).sum());
    [("daylight", DAYLIGHT), ("A", bulb), ("three bands", lamp)]
}

/// The tristimulus values of linear sRGB (IEC 61966-2-1), column by column.
const SRGB: DMat3 = DMat3::from_cols_array(&[0.4124, 0.2126, 0.0193, 0.3576, 0.7152, 0.1192, 0.1805, 0.0722, 0.9505]);

/// The responses of cones for chromatic adaptation (Bradford), column by column.
const CONES: DMat3 =
    DMat3::from_cols_array(&[0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296]);

/// A colour in a light of this white, as a white balance shows it: in light of the white of sRGB.
fn balanced(color: DVec3, white: DVec3) -> DVec3 {
    CONES.inverse() * (CONES * color / (CONES * white) * (CONES * SRGB * DVec3::ONE))
}

/// L*, a*, b* relative to the white of sRGB.
fn lab(color: DVec3) -> [f64; 3] {
    let [x, y, z] = (color / (SRGB * DVec3::ONE))
        .to_array()
        .map(|t| if t > (6.0f64 / 29.0).powi(3) { t.cbrt() } else { t * (29.0f64 / 6.0).powi(2) / 3.0 + 4.0 / 29.0 });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Total albedo of a fibre with three absorptions, for light in the normal plane.
fn albedo(fiber: Fiber, sigma: [f32; 3]) -> Result<[f64; 3], vellus::Error> {
    let sigma_ma = sigma.map(|x| x * fiber.medulla_pigment);
    let lobes = energies(&Bcsdf::new(&Fiber { sigma_ca: sigma, sigma_ma, ..fiber })?, 0.0, None);
    Ok([0, 1, 2].map(|c| lobes.iter().map(|lobe| lobe[c]).sum()))
}

/// The albedo at each wavelength.
fn albedos(fiber: Fiber, sigma: &Spectrum) -> Result<Spectrum, vellus::Error> {
    let mut all = [0.0; WAVELENGTHS];
    for (three, out) in sigma.chunks(3).zip(all.chunks_mut(3)) {
        let values = albedo(fiber, std::array::from_fn(|c| three.get(c).copied().unwrap_or(0.0) as f32))?;
        out.copy_from_slice(&values[..out.len()]);
    }
    Ok(all)
}

fn main() -> Result<(), Box<dyn Error>> {
    let fibers =
        [Fiber::hair(), Fiber::preset(Species::Cat), Fiber::preset(Species::Mouse), Fiber::preset(Species::RedFox)];
    let mut differences: Vec<Vec<f64>> = vec![Vec::new(); 9];
    for fiber in fibers {
        for pigment @ [eumelanin, pheomelanin] in PIGMENTS {
            let spectral = albedos(fiber, &absorption(pigment))?;
            let rgb = fiber.with_color(Color::Melanin { eumelanin, pheomelanin })?.sigma_ca;
            let rgb = albedo(fiber, rgb)?;
            for (k, (_, light)) in lights().iter().enumerate() {
                let white = xyz(light);
                for (b, &n) in BOUNCES.iter().enumerate() {
                    let seen = xyz(&std::array::from_fn(|i| light[i] * spectral[i].powi(n)));
                    let three = SRGB * DVec3::from(rgb.map(|x| x.powi(n)));
                    differences[3 * k + b].push(delta_e2000_of_labs(lab(balanced(seen, white)), lab(three)));
                }
            }
        }
    }
    println!("CIEDE2000, RGB against {WAVELENGTHS} wavelengths: mean, worst");
    for (k, found) in differences.iter().enumerate() {
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        let worst = found.iter().fold(0.0, |a: f64, b| a.max(*b));
        println!("{:<12} {:>2} bounces: {mean:.1}, {worst:.1}", lights()[k / 3].0, BOUNCES[k % 3]);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published chromaticities of both standard illuminants. The fit of the observer, the step of 10 nm and the
    /// ends at 400 and 700 nm move them by less than 0.002.
    #[test]
    fn lights_have_their_published_chromaticities() {
        for ((name, light), [x, y]) in lights().iter().zip([[0.3127, 0.3290], [0.4476, 0.4074], [0.3127, 0.3290]]) {
            let color = xyz(light);
            let found = [color.x, color.y].map(|v| v / color.element_sum());
            assert!((found[0] - x).abs() < 0.002 && (found[1] - y).abs() < 0.002, "{name}: {found:?}");
        }
        assert!(lights()[2].1.iter().all(|x| *x >= 0.0));
    }

    /// The power laws are the RGB constants at 641, 550 and 449 nm.
    #[test]
    fn power_laws_are_the_constants() -> Result<(), Box<dyn Error>> {
        for pigment @ [eumelanin, pheomelanin] in [[1.0, 0.0], [0.0, 1.0]] {
            let sigma = absorption(pigment);
            let constants = Fiber::hair().with_color(Color::Melanin { eumelanin, pheomelanin })?.sigma_ca;
            for (c, i) in [24.1, 15.0, 4.9f64].into_iter().enumerate() {
                let (low, share) = (i.floor() as usize, i.fract());
                let found = sigma[low] + (sigma[low + 1] - sigma[low]) * share;
                assert!((found / f64::from(constants[c]) - 1.0).abs() < 0.035, "{found} {constants:?}");
            }
        }
        Ok(())
    }
}
