//! One prepared fibre.

use crate::bcsdf::Bcsdf;
use crate::cylinder::frame::Refraction;
use crate::exit::Reflection;
use crate::medulla::mixture::Between;
use crate::packed::{Record, count, pairs};
use crate::prepared::Prepared;

/// The parts of a fibre: the name, the number of rows, and what they are.
pub const FIBER_LAYOUT: [(&str, usize, &str); 16] = [
    ("OPTICS", 1, "eta, kappa, sigma_ms, layers"),
    ("CORTEX", 1, "sigma_ca; the gain of the backward half, 0 if the exit is open"),
    ("MEDULLA", 1, "sigma_ma, and the optical radius"),
    ("SHIFT", 6, "sines and cosines of the shifts, v, 1/v, the norms, exp(-2/v)"),
    ("AZIMUTHAL", 3, "exponents, norms, widths with the number of images"),
    ("REFRACTION", 1, "node of g and fraction, 1/eta, 1 - 1/eta^2"),
    ("CONE", 1, "loss, half angle, its inverse, share of light that is turned like TT"),
    ("CONE_POSITION", 1, "node and fraction, edge, what is left of the direction of late light"),
    ("FIRST", 8, "first exits"),
    ("ESCAPE", 8, "all exits"),
    ("KEPT", 8, "logarithm of what absorption leaves"),
    ("AZIMUTH_WEIGHTS", 10, "of the components of C^N"),
    ("BACKWARD_WEIGHTS", 4, "of the backward half of C^M"),
    ("FORWARD_WEIGHTS", 8, "of the forward half of C^M"),
    ("BACKWARD_INTEGRALS", 4, "of the components of the backward half"),
    ("TURN", 1, "of scattered light: constant, cosine, sine, and the slope"),
];

/// The number of rows of a fibre.
pub const FIBER_ROWS: usize = count(&FIBER_LAYOUT);

/// Everything about a fibre that its hits in the near field need, in rows of four numbers: see [`FIBER_LAYOUT`].
pub fn fiber(bcsdf: &Bcsdf<'_>) -> [[f32; 4]; FIBER_ROWS] {
    let Prepared { in_air: fiber, longitudinal, azimuthal, medulla, reflection, turning, .. } = bcsdf.prepared();
    let rgb = |c: [f32; 3], w: f32| [c[0], c[1], c[2], w];
    let ([constant, cosine, sine], slope, straight) =
        turning.as_ref().map_or(([0.0; 3], 0.0, 0.0), |turning| (turning.parts, turning.slope, turning.straight));
    let (cone, edge, position) = match medulla.cone {
        Some((cone, _)) => ([cone.loss, cone.half, cone.inverse_half, straight], cone.edge, cone.position),
        None => ([0.0; 4], 0.0, Between { index: 0, t: 0.0 }),
    };
    let none = Reflection { escape: [[0.0; 4]; 8], ln_kept: [[0.0; 4]; 8], first: [[0.0; 4]; 8], stays: 0.0 };
    let exit = reflection.as_ref().unwrap_or(&none);
    // Indices are below 4096, and exact in single precision.
    let number = |index: usize| index as f32;
    let gain = medulla.cone.map_or(0.0, |(cone, _)| cone.backward_gain);
    let mut record = Record::new(&FIBER_LAYOUT);
    let mut put = |name: &str, values: &[[f32; 4]]| record.put(name, values);
    put("OPTICS", &[[fiber.eta, fiber.kappa, fiber.sigma_ms, fiber.layers]]);
    put("CORTEX", &[rgb(fiber.sigma_ca, gain)]);
    put("MEDULLA", &[rgb(fiber.sigma_ma, medulla.optical_radius)]);
    let shifts = [longitudinal.sin_alpha, longitudinal.cos_alpha];
    let widths = [longitudinal.v, longitudinal.inv_v, longitudinal.norm, longitudinal.floor];
    put("SHIFT", &[shifts[0], shifts[1], widths[0], widths[1], widths[2], widths[3]]);
    put("AZIMUTHAL", &[azimuthal.exponent, azimuthal.norm, rgb(azimuthal.sigma, f32::from(azimuthal.images))]);
    let Refraction { inverse_eta, excess } = medulla.refraction;
    put("REFRACTION", &[[number(medulla.g.index), medulla.g.t, inverse_eta, excess]]);
    put("CONE", &[cone]);
    put("CONE_POSITION", &[[number(position.index), position.t, edge, exit.stays]]);
    put("FIRST", &exit.first);
    put("ESCAPE", &exit.escape);
    put("KEPT", &exit.ln_kept);
    put("AZIMUTH_WEIGHTS", &pairs(&medulla.azimuthal));
    put("BACKWARD_WEIGHTS", &pairs(&medulla.backward));
    put("FORWARD_WEIGHTS", &pairs(&medulla.forward));
    put("BACKWARD_INTEGRALS", &pairs(&medulla.backward_integrals));
    put("TURN", &[[constant, cosine, sine, slope]]);
    record.rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fiber::Fiber;
    use crate::fiber::exit::ScatterExit;

    #[test]
    fn every_fiber_has_the_same_number_of_rows() -> Result<(), crate::Error> {
        for exit in ScatterExit::ALL {
            for kappa in [0.0, 0.8] {
                let bcsdf = Bcsdf::new(&Fiber { exit, kappa, sigma_ms: 2.0, ..Fiber::hair() })?;
                let rows = fiber(&bcsdf);
                assert_eq!(rows[0][1], kappa);
                assert!(rows.iter().flatten().all(|x| x.is_finite()));
            }
        }
        Ok(())
    }
}
