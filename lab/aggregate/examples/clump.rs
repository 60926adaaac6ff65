//! What a clump of 64 fibres does with light, as a renderer would ask: `cargo run -p vellus-aggregate --example clump`.

use vellus::{Fiber, Model, Scattering, Species, Window, direction};
use vellus_aggregate::{Aggregate, Bunch, Error};

fn main() -> Result<(), Error> {
    println!("fibres  passes  energy of light that meets a fibre");
    for (count, passes, energy) in clumps()? {
        println!("{count:6}  {passes:6.3}  {energy:6.3?}");
    }
    Ok(())
}

/// Clumps of different numbers of red fox hairs, as wide as 32 hairs.
fn clumps() -> Result<Vec<(u32, f64, [f32; 3])>, Error> {
    let fiber = Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]);
    let wo = direction(0.3, 0.0);
    [16, 64, 256]
        .into_iter()
        .map(|count| {
            let bunch = Bunch::separate(count, 1.0, 32.0)?;
            let aggregate = Aggregate::new(&fiber, bunch)?;
            Ok((count, bunch.mean_passes(), aggregate.at(wo, Window::far()).energy().total()))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::clumps;

    /// More fibres let less light pass, and absorb more of it.
    #[test]
    fn more_fibres_are_darker() {
        let clumps = clumps().unwrap();
        assert!(clumps.windows(2).all(|pair| pair[1].1 < pair[0].1 && pair[1].2[0] < pair[0].2[0]), "{clumps:?}");
    }
}
