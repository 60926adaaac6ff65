//! What tells one picture from another: a digest of everything that was read or set and that can change a pixel.

use super::Args;
use anyhow::Result;
use vellus::{Fiber, Tables};
use vellus_io::{Digest, DigestBuilder, Sources};
use vellus_render::{Filter, Layer, Mode, PICTURE_VERSION};

/// The note with it in pictures.
pub const IDENTITY_NOTE: &str = "vellus_identity";

/// Films with the same identity may be added. It does not depend on where files are stored, on their times, on the
/// machine or on the compiler. Two releases that make the same pictures have the same [`PICTURE_VERSION`].
pub fn identity(args: &Args, sources: &Sources) -> Result<Digest> {
    let numbers = |numbers: &[u64]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let size = args.size.map(|n| n as u64);
    let crop = args.crop.map_or_else(Vec::new, |crop| numbers(&crop.map(|n| n as u64)));
    let mode = match args.mode.into() {
        Mode::MultiScale => "multiscale",
        Mode::Near => "near",
        Mode::Far => "far",
    };
    let filter = match args.filter.into() {
        Filter::Box => "box",
        Filter::Tent => "tent",
    };
    let layers: Vec<u8> = Layer::ALL.map(|layer| u8::from(args.layers().contains(&layer))).to_vec();
    let builder = DigestBuilder::new()
        .field("picture version", PICTURE_VERSION.to_le_bytes())
        .field("tables", Digest::of(Tables::SHIPPED).0)
        .field("model", args.model.kind()?.to_string())
        .field("eta_m", optional(args.model.eta_m.map(f32::to_le_bytes)))
        .field("size", numbers(&size))
        .field("crop", crop)
        .field("mode", mode)
        .field("filter", filter)
        .field("seed", args.seed.to_le_bytes())
        .field("max depth", optional(args.max_depth.map(u32::to_le_bytes)))
        .field("min pixel width", args.min_pixel_width.to_le_bytes())
        .field("layers", layers)
        .field("sources", sources.digest().0);
    Ok(args.input.add_to(builder)?.finish())
}

/// Nothing, or the bytes of what is set.
pub fn optional<const N: usize>(bytes: Option<[u8; N]>) -> Vec<u8> {
    bytes.map_or_else(Vec::new, |bytes| bytes.to_vec())
}

/// All parameters of a fibre.
pub fn fiber(builder: DigestBuilder, fiber: &Fiber) -> DigestBuilder {
    // Without `..`: a parameter that is added later must be added here.
    let Fiber { eta, kappa, alpha, beta_m, beta_n, sigma_ca, sigma_ms, sigma_ma, g, layers } = *fiber;
    let [scalars, colors] =
        [&[eta, kappa, alpha, beta_m, beta_n, sigma_ms, g, layers][..], &[sigma_ca, sigma_ma].concat()]
            .map(|numbers| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
    builder.field("fiber", scalars).field("fiber absorption", colors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use std::collections::HashMap;

    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        args: Args,
    }

    fn of(options: &[&str]) -> Digest {
        let args = Command::parse_from(["vellus"].iter().chain(options)).args;
        identity(&args, &Sources::new()).unwrap()
    }

    #[test]
    fn every_option_that_changes_a_pixel_changes_the_identity() {
        let all: [&[&str]; 18] = [
            &[],
            &["cat"],
            &["--small"],
            &["--size", "640x960"],
            &["--crop", "0,0,8,8"],
            &["--mode", "near"],
            &["--filter", "box"],
            &["--seed", "1"],
            &["--max-depth", "9"],
            &["--min-pixel-width", "0.5"],
            &["--model", "yan2015"],
            &["--model", "yan2015", "--eta-m", "1.5"],
            &["--layers", "beauty"],
            &["--strands", "50%"],
            &["x.usda", "--width", "0.5"],
            &["x.usda", "--camera", "a"],
            &["x.usda", "--frame", "2"],
            &["x.usda", "--set", "kappa=0.5"],
        ];
        let mut seen = HashMap::new();
        for options in all {
            assert_eq!(seen.insert(of(options), options), None, "{options:?}");
        }
    }

    #[test]
    fn what_changes_no_pixel_does_not_change_the_identity() {
        let same: [&[&str]; 7] = [
            &["--spp", "7"],
            &["--samples", "3..9"],
            &["--threads", "1"],
            &["-o", "elsewhere/x.exr"],
            &["--exposure", "2"],
            &["--noise", "0.1", "--time", "9s", "--float"],
            &["--resume", "--checkpoint", "1s"],
        ];
        for options in same {
            assert_eq!(of(options), of(&[]), "{options:?}");
        }
        assert_eq!(of(&["a/x.usda"]), of(&["./a/../b/x.usda"]));
    }

    /// A digest that is written into films must be the same on every machine and in every release: it changes with
    /// [`PICTURE_VERSION`], the shipped tables, and what this function reads, and with nothing else.
    #[test]
    fn the_identity_is_the_same_everywhere() {
        assert_eq!((PICTURE_VERSION, of(&["cat", "--small"]).short().as_str()), (1, "2687decfdbf32395"));
    }
}
