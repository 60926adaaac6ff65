//! Decodes and encodes OpenEXR.

use super::pixels::{Pixels, checked_size};
use crate::error::Invalid;
use exr::error::Error;
use exr::meta::MetaData;
use exr::prelude::{Image, ReadChannels, ReadLayers, ReadSpecificChannel, SpecificChannels, WritableImage};
use std::collections::BTreeSet;
use std::io::Cursor;
use vellus_scene::Texture;

/// How many channels a message names.
const SHOWN: usize = 16;

/// Decodes a file: its colour, or a single channel as grey, or its channel A, which is 1 if it is missing.
pub(crate) fn decode(bytes: &[u8], is_alpha: bool) -> Result<Pixels, Invalid> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(told)?;
    for header in &meta.headers {
        checked_size(header.layer_size.width(), header.layer_size.height())?;
        if header.channels.list.iter().any(|channel| channel.sampling != exr::math::Vec2(1, 1)) {
            return Err("OpenEXR image with channels of lower resolution, which are not supported".into());
        }
    }
    let Chosen { names: [first, second, third], is_grey } = choose(&meta)?;
    let alpha = if is_alpha { "A" } else { "" };
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required(first.as_str())
        .optional(second.as_str(), 0.0)
        .optional(third.as_str(), 0.0)
        .optional(alpha, 1.0)
        .collect_pixels(
            |size, _| (size.width(), vec![[0f32; 3]; size.width() * size.height()]),
            move |(width, pixels): &mut (usize, Vec<[f32; 3]>), at, (r, g, b, a): (f32, f32, f32, f32)| {
                let color = if is_grey { [r; 3] } else { [r, g, b] };
                pixels[at.y() * *width + at.x()] = if is_alpha { [a; 3] } else { color };
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(told)?;
    let (width, pixels) = image.layer_data.channel_data.pixels;
    Ok(Pixels { width, height: pixels.len() / width.max(1), rgb: pixels.into() })
}

fn told(error: Error) -> Invalid {
    match error {
        Error::NotSupported(what) => format!("OpenEXR image of a kind that is not supported: {what}").into(),
        error => format!("broken OpenEXR image: {error}").into(),
    }
}

/// The channels that become the colour. The first one is in the file.
struct Chosen {
    names: [String; 3],
    /// Whether only the first one counts.
    is_grey: bool,
}

/// Chooses R, G and B of the first layer that has all of them; otherwise those of the only layer with a name; otherwise
/// luminance, or the only channel besides alpha.
fn choose(meta: &MetaData) -> Result<Chosen, Invalid> {
    let layers: Vec<BTreeSet<String>> = meta
        .headers
        .iter()
        .map(|header| header.channels.list.iter().map(|channel| channel.name.to_string()).collect())
        .collect();
    let has = |names: &[String; 3]| layers.iter().any(|layer| names.iter().all(|name| layer.contains(name)));
    let colors = |prefix: &str| ["R", "G", "B"].map(|name| format!("{prefix}{name}"));
    let all: BTreeSet<&str> = layers.iter().flatten().map(String::as_str).collect();
    let named: Vec<[String; 3]> =
        all.iter().filter_map(|name| name.strip_suffix('R')).map(colors).filter(|names| has(names)).collect();
    let visible: Vec<&str> = all.iter().copied().filter(|name| *name != "A" && !name.ends_with(".A")).collect();
    let plain = colors("");
    if has(&plain) {
        return Ok(Chosen { names: plain, is_grey: false });
    }
    if let [names] = &named[..] {
        return Ok(Chosen { names: names.clone(), is_grey: false });
    }
    let only = match visible[..] {
        [only] => Some(only),
        _ => ["Y", "R"].into_iter().find(|name| all.contains(name)),
    };
    match only {
        Some("R") if all.contains("G") || all.contains("B") => Ok(Chosen { names: plain, is_grey: false }),
        // No channel has the other names.
        Some(name) => Ok(Chosen { names: [name.to_owned(), format!("{name}.G"), format!("{name}.B")], is_grey: true }),
        None => {
            let shown: Vec<&str> = all.iter().copied().take(SHOWN).collect();
            let more = if all.len() > SHOWN { format!(" and {} more", all.len() - SHOWN) } else { String::new() };
            let shown = vellus_io::excerpt(shown.join(", ").as_bytes(), 400);
            let what = "R, G and B of one layer, Y, or a single channel are needed";
            Err(format!("OpenEXR image with the channels {shown}{more}: {what}").into())
        }
    }
}

/// Encodes a texture with 32-bit floats, without loss.
pub(crate) fn encode(texture: &Texture) -> Result<Vec<u8>, Invalid> {
    let pixel = |at: exr::math::Vec2<usize>| {
        let [r, g, b] = texture.pixels.get(at.y() * texture.width + at.x());
        (r, g, b)
    };
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_channels((texture.width, texture.height), SpecificChannels::rgb(pixel));
    image.write().non_parallel().to_buffered(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{AnyChannel, AnyChannels, FlatSamples};

    /// An image of 2 × 1 pixels. The n-th channel, from 1, is n and −n.
    fn image(channels: &[&str]) -> Vec<u8> {
        let mut list = exr::prelude::SmallVec::new();
        for (name, n) in channels.iter().zip(1u8..) {
            list.push(AnyChannel::new(*name, FlatSamples::F32(vec![f32::from(n), -f32::from(n)])));
        }
        let mut bytes = Cursor::new(Vec::new());
        let image = Image::from_channels((2, 1), AnyChannels::sort(list));
        image.write().non_parallel().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    fn first(channels: &[&str]) -> [f32; 3] {
        decode(&image(channels), false).unwrap().rgb.get(0)
    }

    #[test]
    fn luminance_and_the_only_channel_are_grey() {
        let pixels = Pixels { width: 2, height: 1, rgb: vec![[1.0; 3], [-1.0; 3]].into() };
        for channels in [&["Y"][..], &["R"], &["Y", "A"], &["R", "A"], &["density"], &["mask.X"], &["Y", "id", "Z"]] {
            assert_eq!(decode(&image(channels), false).unwrap(), pixels, "{channels:?}");
        }
        assert_eq!(first(&["id", "R"]), [2.0; 3]);
    }

    #[test]
    fn colour_is_that_of_the_image_or_of_its_only_layer() {
        assert_eq!(first(&["B", "R", "A", "G", "N.R", "N.G", "N.B"]), [2.0, 4.0, 1.0]);
        assert_eq!(first(&["beauty.R", "beauty.G", "beauty.B", "beauty.A", "Z"]), [1.0, 2.0, 3.0]);
        assert_eq!(first(&["R", "G"]), [1.0, 2.0, 0.0]);
    }

    #[test]
    fn other_channels_are_named() {
        let error = decode(&image(&["N.R", "N.G", "N.B", "P.R", "P.G", "P.B"]), false).unwrap_err().0;
        assert!(error.contains("with the channels N.B, N.G, N.R, P.B, P.G, P.R: R, G and B"), "{error}");
        assert!(!error.contains("broken"));
        let names: Vec<String> = (0..40).map(|i| format!("c{i:02}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let error = decode(&image(&names), false).unwrap_err().0;
        assert!(error.contains("c15 and 24 more"), "{error}");
    }
}
