//! The colours of coats: `cargo bench -p vellus --bench coat`.

use divan::{Bencher, black_box};
use vellus::{CoatColors, Fiber, Species};

/// The table of a fibre.
#[divan::bench]
fn table(bencher: Bencher) {
    let fiber = Fiber::preset(Species::RedFox);
    bencher.bench_local(|| CoatColors::new(black_box(&fiber)));
}

/// The absorption of one colour: all three channels.
#[divan::bench]
fn lookup(bencher: Bencher) {
    let colors = CoatColors::new(&Fiber::preset(Species::RedFox)).expect("the fibre is valid");
    let mut i = 0u32;
    bencher.bench_local(|| {
        i = i.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let color = [8, 14, 20].map(|shift| (i >> shift & 1023) as f32 / 1023.0);
        black_box(color.map(|c| colors.absorption(c)))
    });
}

fn main() {
    divan::main();
}
