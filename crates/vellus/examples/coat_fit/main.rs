//! Dumps moments.
use vellus::parts::Shape;
use vellus::{Exit, Fiber};
fn main() {
    let path = std::env::args().nth(1).unwrap();
    for line in std::fs::read_to_string(path).unwrap().lines() {
        let w: Vec<&str> = line.split(',').collect();
        if w.len() < 22 { continue; }
        let n = |i: usize| w[i].parse::<f32>().unwrap_or(f32::NAN);
        let exit = if w[9] == "true" { Exit::Reflecting } else { Exit::Open };
        let f = Fiber { eta: n(1), kappa: n(2), alpha: n(3), beta_m: n(4), beta_n: n(5), sigma_ms: n(6), g: n(7), layers: n(8), exit,
            sigma_ca: [n(10), n(11), n(12)], sigma_ma: [n(10), n(11), n(12)].map(|x| x * n(13)) };
        let m = Shape::new(&f).moments(f.sigma_ca, f.sigma_ma);
        for c in 0..3 {
            print!("{},{},{},{},{},{},{},{},{},{},{},{},{}", w[0], c, n(15 + c), n(18 + c), f.eta, f.kappa, f.beta_m, f.beta_n, f.sigma_ms, f.g, f.layers, w[9] == "true", n(10 + c));
            for t in m[c] { for [a, b] in t { print!(",{a:.6},{b:.6}"); } }
            println!();
        }
    }
}
