#![no_main]
//! Films: checkpoints, and parts to merge.

use vellus_render::{Depth, Layer, Part};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(part) = Part::from_bytes(bytes) {
        assert_eq!(part.to_bytes(), bytes);
        let mut film = part.film.clone();
        film.merge(&part.film);
        let _ = film.noise();
        assert!(film.to_png(0.0, &[]).is_ok() && film.to_exr(&Layer::ALL, Depth::Half, &[]).is_ok());
    }
});
