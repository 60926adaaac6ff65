//! One prepared fibre.

use crate::bcsdf::Bcsdf;
use crate::exit::Reflection;
use crate::medulla::mixture::{Between, Weights};
use crate::prepared::Prepared;

/// The number of rows of a fibre.
pub const FIBER_ROWS: usize = 66;

/// Everything about a fibre that its hits in the near field need, in rows of four numbers.
///
/// The order: the parameters (3 rows), the longitudinal lobes (6), the azimuthal lobes (3), refraction and cone (3),
/// the exit (8 + 8 + 8), the weights of the components (10 + 4 + 8 + 4), and the turn of scattered light (1).
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
    let mut rows = vec![
        [fiber.eta, fiber.kappa, fiber.sigma_ms, fiber.layers],
        rgb(fiber.sigma_ca, gain),
        rgb(fiber.sigma_ma, medulla.optical_radius),
        longitudinal.sin_alpha,
        longitudinal.cos_alpha,
        longitudinal.v,
        longitudinal.inv_v,
        longitudinal.norm,
        longitudinal.floor,
        azimuthal.exponent,
        azimuthal.norm,
        rgb(azimuthal.sigma, f32::from(azimuthal.images)),
        [number(medulla.g.index), medulla.g.t, medulla.refraction.inverse_eta, medulla.refraction.excess],
        cone,
        [number(position.index), position.t, edge, exit.stays],
    ];
    rows.extend(exit.first);
    rows.extend(exit.escape);
    rows.extend(exit.ln_kept);
    extend(&mut rows, &medulla.azimuthal);
    extend(&mut rows, &medulla.backward);
    extend(&mut rows, &medulla.forward);
    extend(&mut rows, &medulla.backward_integrals);
    rows.push([constant, cosine, sine, slope]);
    match rows.try_into() {
        Ok(rows) => rows,
        Err(_) => unreachable!("the number of rows does not depend on the fibre"),
    }
}

fn extend<const C: usize>(rows: &mut Vec<[f32; 4]>, weights: &Weights<C>) {
    for eight in weights {
        let [a, b, c, d, e, f, g, h] = eight.to_array();
        rows.extend([[a, b, c, d], [e, f, g, h]]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fiber::Fiber;
    use crate::fiber::exit::Exit;

    #[test]
    fn every_fiber_has_the_same_number_of_rows() -> Result<(), crate::Error> {
        for exit in Exit::ALL {
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
