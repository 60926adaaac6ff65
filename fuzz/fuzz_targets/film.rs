#![no_main]
//! Films: checkpoints and sample ranges to merge. This target adds the checksum at the end, because otherwise no input
//! would pass the check.

use vellus_io::Digest;
use vellus_render::{Checkpoint, Layer, PixelType};

libfuzzer_sys::fuzz_target!(|content: &[u8]| {
    let bytes = [content, &Digest::of(content).0].concat();
    if let Ok(part) = Checkpoint::from_bytes(&bytes) {
        assert_eq!(part.to_bytes(), bytes);
        let mut film = part.film.clone();
        film.merge(&part.film);
        let _ = film.noise();
        assert!(film.to_png(None, 0.0, &[]).is_ok() && film.to_exr(&Layer::ALL, None, PixelType::Half, &[]).is_ok());
    }
});
