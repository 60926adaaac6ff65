//! Films as OpenEXR files.

use super::attributes;
use super::denoised::Denoised;
use super::picture::{Notes, PIXELS_NOTE, PixelType, check_claim};
use crate::error::Error;
use crate::film::{Film, Layer, cryptomatte};
use ::exr::prelude::*;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use std::io::Cursor;
use vellus_io::{Digest, DigestBuilder};

/// Compositors read this encoding fastest.
const ENCODING: Encoding = Encoding {
    compression: Compression::ZIP16,
    blocks: ::exr::image::Blocks::ScanLines,
    line_order: LineOrder::Increasing,
};

/// The primaries of Rec. 709 and its white.
const REC_709: ::exr::meta::attribute::Chromaticities = ::exr::meta::attribute::Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.3, 0.6),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.329),
};

impl Film {
    /// The bytes of an OpenEXR file.
    ///
    /// It has the `layers` that the film keeps, with linear colours (Rec. 709), and attributes for `notes` (names and
    /// values): of the standard's types for names of the standard, texts for others. The beauty of
    /// `denoised` becomes the layer `denoised`, and its parts layers like `denoised_light_key` and `denoised_lobe_TT`.
    ///
    /// Albedo, normal, depth and motion are means over the covered part of the pixel. Tangent and root coordinates are
    /// means over the part that fibres cover. The variance is that of the pixel's mean brightness. If a film covers
    /// only a part of the picture, the data window is this part. The layers of [`Layer::CRYPTOMATTE`] follow the
    /// Cryptomatte specification 1.2, with six ranks in 32 bits.
    ///
    /// # Errors
    /// [`Error::Encode`] with what the encoder reports.
    pub fn to_exr(
        &self,
        layers: &[Layer],
        denoised: Option<&Denoised>,
        pixel_type: PixelType,
        notes: &[(String, String)],
    ) -> std::result::Result<Vec<u8>, Error> {
        let (width, height) = (self.width(), self.height());
        let pixels = || (0..width * height).into_par_iter().map(|i| (i % width, i / width));
        let (mut channels, mut cryptomattes) = (Vec::new(), Vec::new());
        // All channels of a layer have one type: many programs cannot read colours with mixed types.
        let mut push = |names: &[String], values: Vec<Vec<f32>>, exact: bool| {
            let half = pixel_type == PixelType::Half && !exact && fits_half(values.iter().flatten().copied());
            for (name, values) in names.iter().zip(values) {
                let samples = if half {
                    FlatSamples::F16(values.into_iter().map(f16::from_f32).collect())
                } else {
                    FlatSamples::F32(values)
                };
                channels.push(AnyChannel::new(name.as_str(), samples));
            }
        };
        let kept = |layer: &Layer| layers.contains(layer) && self.layout().has(*layer);
        for layer in Layer::ALL.into_iter().filter(|layer| kept(layer) && *layer != Layer::Strand) {
            if Layer::CRYPTOMATTE.contains(&layer) {
                push(&layer.channel_names(&[]), self.cryptomatte(layer), true);
                cryptomattes.extend(cryptomatte::attributes(layer, self.layout().things()));
                continue;
            }
            let names = layer.channel_names(self.layout().groups());
            let values = |k| pixels().map(|(x, y)| self.value(x, y, layer, k)).collect();
            use Layer::{CacheError, Depth, Motion, RootUv, SecondMoment};
            let exact = matches!(layer, SecondMoment | CacheError | Depth | RootUv | Motion);
            push(&names, (0..names.len()).map(values).collect(), exact);
        }
        if let Some(denoised) = denoised {
            let mut push_clean = |names: &[String], all: &[f32]| {
                let values = |k| all.iter().skip(k).step_by(names.len()).copied().collect();
                push(names, (0..names.len()).map(values).collect(), false);
            };
            push_clean(&["R", "G", "B"].map(|c| format!("denoised.{c}")), &denoised.beauty);
            for (layer, values) in &denoised.parts {
                let names = layer.channel_names(self.layout().groups());
                push_clean(&names.iter().map(|name| format!("denoised_{name}")).collect::<Vec<_>>(), values);
            }
        }
        if kept(&Layer::Strand) {
            let ids = FlatSamples::U32(pixels().map(|(x, y)| self.strand(x, y)).collect());
            channels.push(AnyChannel::new(Layer::Strand.channel_names(&[])[0].as_str(), ids));
        }
        let channels = AnyChannels::sort(channels.into_iter().collect());
        let [left, top, ..] = self.area().map(|n| n as i32);
        let mut attributes = LayerAttributes::named("");
        attributes.layer_name = None;
        attributes.layer_position = Vec2(left, top);
        attributes.software_name = Some("vellus".into());
        let pixels = (PIXELS_NOTE.to_owned(), exr_digest(&channels).to_string());
        let space = ("colorInteropID".to_owned(), "lin_rec709_scene".to_owned());
        for (name, value) in notes.iter().chain(&cryptomattes).chain([&pixels, &space]) {
            attributes::add(&mut attributes, name, value);
        }
        let layer = ::exr::image::Layer::new((width, height), attributes, ENCODING, channels);
        let [whole_width, whole_height] = self.whole();
        let mut image = Image::from_layer(layer);
        image.attributes.display_window = IntegerBounds::from_dimensions((whole_width, whole_height));
        image.attributes.chromaticities = Some(REC_709);
        let mut bytes = Cursor::new(Vec::new());
        let failed = |e: ::exr::error::Error| Error::Encode { format: "OpenEXR", what: e.to_string() };
        image.write().non_parallel().to_buffered(&mut bytes).map_err(failed)?;
        Ok(bytes.into_inner())
    }

    /// The value of a channel in the file.
    pub(super) fn value(&self, x: usize, y: usize, layer: Layer, k: usize) -> f32 {
        let mean = self.mean(x, y, layer, k);
        let over = |cover: Layer| {
            let covered = self.mean(x, y, cover, 0);
            if covered > 0.0 { (mean / covered) as f32 } else { 0.0 }
        };
        match layer {
            Layer::SecondMoment => self.error(x, y).powi(2) as f32,
            Layer::CacheError => mean.powi(2) as f32,
            Layer::Albedo | Layer::Normal | Layer::Depth | Layer::Motion => over(Layer::Alpha),
            Layer::Tangent | Layer::RootUv => over(Layer::Fibers),
            _ => mean as f32,
        }
    }
}

/// The digest of all channels: names, types and stored values.
fn exr_digest(channels: &AnyChannels<FlatSamples>) -> Digest {
    let digest = channels.list.iter().fold(DigestBuilder::new(), |builder, channel| {
        // The digest includes the type, because the bits of 1.0 are also an integer.
        let (kind, bytes): (&str, Vec<u8>) = match &channel.sample_data {
            FlatSamples::F16(values) => ("half", values.iter().flat_map(|v| v.to_le_bytes()).collect()),
            FlatSamples::F32(values) => ("float", values.iter().flat_map(|v| v.to_le_bytes()).collect()),
            FlatSamples::U32(values) => ("uint", values.iter().flat_map(|v| v.to_le_bytes()).collect()),
        };
        builder.field(&channel.name.to_string(), kind).field("values", bytes)
    });
    digest.finish()
}

/// Whether 16 bits can hold these values. The largest half float is 65504. If the largest value is below 2⁻⁷, a value
/// 128 times darker is subnormal and loses digits.
fn fits_half(values: impl Iterator<Item = f32>) -> bool {
    let largest = values.fold(0.0f32, |largest, v| largest.max(v.abs()));
    largest == 0.0 || (0.5f32.powi(7)..=65504.0).contains(&largest)
}

/// The notes of a file, and the digest of its pixels.
pub(super) fn exr_notes(bytes: &[u8]) -> std::result::Result<(Notes, Digest), String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    // The reader allocates the pixels of all layers of the largest level.
    let claimed = |header: &::exr::meta::header::Header| -> u128 {
        [header.layer_size.0, header.layer_size.1, header.channels.bytes_per_pixel].map(|n| n as u128).iter().product()
    };
    check_claim(meta.headers.iter().map(claimed).sum(), bytes.len())?;
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = image.non_parallel().from_buffered(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let layer = &image.layer_data;
    let note = |(name, value): (&Text, &AttributeValue)| match value {
        AttributeValue::Text(value) => Some((name.to_string(), String::from_utf8(value.as_slice().to_vec()).ok()?)),
        _ => None,
    };
    Ok((layer.attributes.other.iter().filter_map(note).collect(), exr_digest(&layer.channel_data)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::layout::Layout;
    use crate::film::picture::check_picture;
    use crate::film::{add, nearest};

    #[test]
    fn the_digest_covers_the_type_of_a_channel() {
        let digest = |samples| exr_digest(&AnyChannels::sort([AnyChannel::new("N.Y", samples)].into_iter().collect()));
        let bits = FlatSamples::U32(vec![1f32.to_bits()]);
        assert_ne!(digest(FlatSamples::F32(vec![1.0])), digest(bits));
    }

    #[test]
    fn pictures_carry_a_digest_of_their_pixels() {
        let layout = Layout::new(&[Layer::Albedo, Layer::Strand], &[]);
        let mut film = Film::new([8, 9], [4, 5, 3, 2], layout.clone());
        film.add_rows(
            (0..2usize).into_par_iter().map(|y| (0..3 * layout.words()).map(|i| (i * 77 + y) as u32).collect()),
        );
        film.advance(1);
        let notes = [("vellus_identity".to_owned(), "狐".to_owned())];
        let exr = film.to_exr(&[Layer::Beauty, Layer::Strand], None, PixelType::Half, &notes).unwrap();
        let png = film.to_png(None, crate::Display::default(), &notes).unwrap();
        for bytes in [exr, png] {
            assert!(check_picture(&bytes).unwrap().contains(&notes[0]));
            for at in 0..bytes.len() {
                let mut damaged = bytes.clone();
                damaged[at] ^= 1 << (at % 8);
                // Damage outside of the pixels may pass unnoticed. Accepted pixels are undamaged.
                if let Ok(found) = check_picture(&damaged) {
                    let digest = |notes: &[(String, String)]| notes.iter().find(|n| n.0 == PIXELS_NOTE).cloned();
                    assert_eq!(digest(&found), digest(&check_picture(&bytes).unwrap()));
                }
            }
            for end in 0..bytes.len() {
                assert!(check_picture(&bytes[..end]).is_err(), "{end} of {}", bytes.len());
            }
        }
    }

    #[test]
    fn sizes_that_a_file_cannot_have_are_refused_before_memory_is_allocated() {
        let mut film = Film::new([3, 2], [0, 0, 3, 2], Layout::new(&[], &[]));
        let length = 3 * film.layout().words();
        film.add_rows((0..2usize).into_par_iter().map(|_| vec![0; length]));
        film.advance(1);
        let exr = film.to_exr(&[Layer::Beauty], None, PixelType::Float, &[]).unwrap();
        let name = b"dataWindow\0box2i\0";
        let x_max = exr.windows(name.len()).position(|part| part == name).unwrap() + name.len() + 4 + 2 * 4;
        let mut png = Vec::new();
        let mut writer = png::Encoder::new(&mut png, 20_000, 20_000).write_header().unwrap();
        writer.write_chunk(png::chunk::IDAT, &[0; 9]).unwrap();
        drop(writer);
        let claimed = |bytes: &[u8]| check_picture(bytes).unwrap_err().to_string().contains("it claims");
        assert!(check_picture(&exr).is_ok() && claimed(&png));
        // 0.8 MB to 6 GB a row.
        for last in [1i32 << 16, (1 << 25) + 2, 1 << 29] {
            let mut damaged = exr.clone();
            damaged[x_max..][..4].copy_from_slice(&last.to_le_bytes());
            assert!(claimed(&damaged), "{last}");
        }
    }

    #[test]
    fn light_beyond_16_bits_is_stored_in_32() {
        assert!(fits_half([0.0; 3].into_iter()) && fits_half([0.5, -65504.0].into_iter()));
        assert!(!fits_half([65505.0].into_iter()) && !fits_half([1e-9, 1e-3].into_iter()));
        for light in [1e-9f32, 1e9] {
            let layout = Layout::new(&[], &[]);
            let mut values = vec![0.0; layout.channels()];
            values[..4].copy_from_slice(&[light, light, light, 1.0]);
            let mut row = vec![0; layout.words()];
            assert!(add(&layout, &mut row, &values, 0));
            let mut film = Film::new([1, 1], [0, 0, 1, 1], layout);
            film.add_rows(rayon::iter::once(row));
            film.advance(1);
            let bytes = film.to_exr(&[Layer::Beauty, Layer::Alpha], None, PixelType::Half, &[]).unwrap();
            let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
            let image = image.all_attributes().from_buffered(Cursor::new(bytes)).unwrap();
            let channels = &image.layer_data.channel_data.list;
            let red = channels.iter().find(|c| c.name.eq("R")).unwrap();
            assert!(matches!(red.sample_data, FlatSamples::F32(_)));
            assert!((red.sample_data.value_by_flat_index(0).to_f32() / light - 1.0).abs() < 1e-6);
            let alpha = channels.iter().find(|c| c.name.eq("A")).unwrap();
            assert!(matches!(alpha.sample_data, FlatSamples::F16(_)));
        }
    }

    #[test]
    fn layers_come_back_from_exr() {
        let layout = Layout::new(&Layer::ALL, &["key".to_owned(), "rim".to_owned()]);
        let (words, channels) = (layout.words(), layout.channels());
        let start = |layer| layout.start(layer).unwrap();
        let row = |y: usize| {
            let mut row = vec![0; 3 * words];
            for x in 0..3 {
                let mut values: Vec<f32> = (0..channels).map(|c| (c + 10 * x) as f32 * 0.25 + y as f32).collect();
                (values[start(Layer::Alpha)], values[start(Layer::Fibers)]) = (0.5, 0.25);
                let strand = nearest(2.0, 40_000_000 + x as u32);
                assert!(add(&layout, &mut row[x * words..][..words], &values, strand));
            }
            row
        };
        let mut film = Film::new([8, 9], [4, 5, 3, 2], layout.clone());
        film.add_rows((0..2usize).into_par_iter().map(row));
        film.advance(1);
        let notes = [("vellus_command".to_owned(), "vellus render 狐.usda".to_owned())];
        let numbers = |count: u8| (0..count).map(f32::from).collect();
        let denoised = Denoised { beauty: numbers(18), parts: vec![(Layer::Lights, numbers(36))] };
        let bytes = film.to_exr(&Layer::ALL, Some(&denoised), PixelType::Float, &notes).unwrap();
        let image =
            read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
        let image = image.from_buffered(Cursor::new(bytes)).unwrap();
        let layer = &image.layer_data;
        assert_eq!(image.attributes.display_window.size, Vec2(8, 9));
        assert_eq!(layer.attributes.layer_position, Vec2(4, 5));
        // Three of the denoised beauty, six of its lights, and twelve for each Cryptomatte.
        assert_eq!(layer.channel_data.list.len(), channels + 9 + 36);
        let Some(AttributeValue::Text(note)) = layer.attributes.other.get(&Text::from("vellus_command")) else {
            panic!()
        };
        assert_eq!(std::str::from_utf8(note.as_slice()), Ok("vellus render 狐.usda"));
        let channel = |name: &str| layer.channel_data.list.iter().find(|c| c.name.eq(name)).unwrap();
        let at = |name: &str, i: usize| channel(name).sample_data.value_by_flat_index(i).to_f32();
        let mean = |x, y, layer, k| film.mean(x, y, layer, k) as f32;
        assert_eq!(at("G", 4), mean(1, 1, Layer::Beauty, 1));
        assert_eq!(at("lobe_TRTs.B", 2), mean(2, 0, Layer::Lobes, 14));
        assert_eq!(at("light_rim.R", 2), mean(2, 0, Layer::Lights, 3));
        assert_eq!(at("N.Y", 3), 2.0 * mean(0, 1, Layer::Normal, 1));
        assert_eq!(at("T.Y", 3), 4.0 * mean(0, 1, Layer::Tangent, 1));
        assert_eq!(at("root.V", 3), 4.0 * mean(0, 1, Layer::RootUv, 1));
        let FlatSamples::U32(ids) = &channel("strand.id").sample_data else { panic!() };
        assert_eq!(ids[..3], [40_000_000, 40_000_001, 40_000_002]);
        assert_eq!((at("denoised.G", 4), at("denoised_light_rim.R", 2)), (13.0, 15.0));
        assert_eq!(film.rgb(Layer::Beauty).unwrap()[13], mean(1, 1, Layer::Beauty, 1));
        assert!(film.rgb(Layer::Depth).is_none() && film.rgb(Layer::Lobes).is_none());
        assert_ne!(
            film.to_png(None, crate::Display::default(), &notes).unwrap(),
            film.to_png(Some(&denoised.beauty), crate::Display::default(), &notes).unwrap()
        );
        // Layers have 16 bits if that is enough. The numbers of strands reach 4e7, and all other values here are small.
        let bytes = film.to_exr(&Layer::ALL, None, PixelType::Half, &notes).unwrap();
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).unwrap();
        let kind = |name: &str| meta.headers[0].channels.list.iter().find(|c| c.name.eq(name)).unwrap().sample_type;
        assert_eq!((kind("R"), kind("Z"), kind("strand.id")), (SampleType::F16, SampleType::F32, SampleType::U32));
        // The file only has layers that are requested and kept.
        let few = Film::new([8, 9], [4, 5, 3, 2], Layout::new(&[Layer::Depth], &[]));
        let bytes = few.to_exr(&[Layer::Beauty, Layer::Albedo], None, PixelType::Half, &[]).unwrap();
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).unwrap();
        assert_eq!(meta.headers[0].channels.list.len(), 3);
    }
}
