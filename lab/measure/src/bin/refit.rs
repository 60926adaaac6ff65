//! Fits the ten species again with the reflecting exit, to the far field of the published fibres with the open exit:
//! `cargo run --release --bin refit`. It prints the rows of `FITTED` in
//! `crates/vellus/src/fiber/species.rs`, and how well they match.

use vellus::{Fiber, ScatterExit, Species};
use vellus_fit::{Refit, refit};

fn main() {
    let only = std::env::args().nth(1);
    for species in Species::ALL.into_iter().filter(|s| only.as_ref().is_none_or(|o| o == s.name())) {
        let published = Fiber::published(species);
        let Refit { fiber: f, nrmse, nrmse_at, log_ratio, albedo } =
            refit(&published, ScatterExit::Reflecting, &()).expect("the preset is valid");
        let row = |f: &Fiber| {
            format!(
                "κ {:.3} σ_ca {:.3} σ_ms {:.3} σ_ma {:.3} g {:.3} l {:.3} β_n {:.2}",
                f.kappa,
                f.sigma_ca[0],
                f.sigma_ms,
                f.sigma_ma[0],
                f.g,
                f.layers,
                f.beta_n.to_degrees()
            )
        };
        println!("{:<10} published {}", species.name(), row(&published));
        println!("{:<10} refit     {}", "", row(&f));
        println!(
            "{:<10} NRMSE {:.2} % {:.2?} log {:.3?} albedo {:.3?}",
            "",
            100.0 * nrmse,
            nrmse_at.map(|x| 100.0 * x),
            log_ratio,
            albedo
        );
    }
}
