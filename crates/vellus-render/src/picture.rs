//! Films as files: OpenEXR with all layers, PNG to look at.

use crate::film::{Film, Layer};
use exr::prelude::*;
use std::io::Cursor;

/// How colours are stored in OpenEXR. Distances and variances are 32 bit always.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// 16 bit.
    Half,
    /// 32 bit.
    Float,
}

/// What compositors read fastest.
const ENCODING: Encoding = Encoding {
    compression: Compression::ZIP16,
    blocks: exr::image::Blocks::ScanLines,
    line_order: LineOrder::Increasing,
};

/// Channel names of a layer, as compositors know them: `R`, `albedo.R`, `lobe_TT.G`, `light_key.B`, `N.X`, `Z`.
fn names(layer: Layer, groups: &[String]) -> Vec<String> {
    let rgb = |prefix: &str| ["R", "G", "B"].map(|c| format!("{prefix}{c}")).to_vec();
    let xyz = |prefix: &str| ["X", "Y", "Z"].map(|c| format!("{prefix}.{c}")).to_vec();
    match layer {
        Layer::Beauty => rgb(""),
        Layer::Alpha => vec!["A".to_owned()],
        Layer::Square => vec!["variance.V".to_owned()],
        Layer::Lobes => vellus::Lobe::ALL.iter().flat_map(|lobe| rgb(&format!("lobe_{}.", lobe.key()))).collect(),
        Layer::Albedo => rgb("albedo."),
        Layer::Normal => xyz("N"),
        Layer::Tangent => xyz("T"),
        Layer::Depth => vec!["Z".to_owned()],
        Layer::Fibers => vec!["fibers.A".to_owned()],
        Layer::RootUv => vec!["root.U".to_owned(), "root.V".to_owned()],
        Layer::Motion => vec!["motion.X".to_owned(), "motion.Y".to_owned()],
        Layer::Lights => groups.iter().flat_map(|group| rgb(&format!("light_{group}."))).collect(),
        Layer::Strand => vec!["strand.id".to_owned()],
    }
}

impl Film {
    /// Three channels of a layer, pixel by pixel, means over the whole pixel; none where the film does not keep it or has another
    /// number of channels.
    pub fn rgb(&self, layer: Layer) -> Option<Vec<f32>> {
        let kept = self.layout().range(layer).is_some_and(|range| range.len() == 3);
        let places =
            || (0..self.height()).flat_map(|y| (0..self.width()).flat_map(move |x| [0, 1, 2].map(|c| (x, y, c))));
        kept.then(|| places().map(|(x, y, c)| self.mean(x, y, layer, c) as f32).collect())
    }

    /// An OpenEXR file with these layers, as far as the film keeps them, the beauty as a denoiser left it (three values a pixel; layer
    /// `denoised`), and notes. Features (albedo, normal, depth; of fibres alone:
    /// tangent, root uv) are means over what the pixel sees of them; the variance is that of the pixel's mean brightness. A crop
    /// is the data window of the whole picture.
    ///
    /// # Errors
    /// What the encoder says.
    pub fn to_exr(
        &self,
        layers: &[Layer],
        denoised: Option<&[f32]>,
        depth: Depth,
        notes: &[(String, String)],
    ) -> std::result::Result<Vec<u8>, String> {
        let (width, height) = (self.width(), self.height());
        let pixels = || (0..width * height).map(|i| (i % width, i / width));
        let mut channels = Vec::new();
        let color = |values: Vec<f32>| match depth {
            Depth::Float => FlatSamples::F32(values),
            Depth::Half => {
                FlatSamples::F16(values.into_iter().map(|v| f16::from_f32(v.clamp(-65504.0, 65504.0))).collect())
            }
        };
        for layer in Layer::ALL.into_iter().filter(|l| layers.contains(l) && self.layout().has(*l)) {
            for (k, name) in names(layer, self.layout().groups()).into_iter().enumerate() {
                let values: Vec<f32> = pixels().map(|(x, y)| self.value(x, y, layer, k)).collect();
                let exact = matches!(layer, Layer::Square | Layer::Depth | Layer::RootUv | Layer::Motion);
                let samples = if layer == Layer::Strand {
                    FlatSamples::U32(pixels().map(|(x, y)| self.strand(x, y)).collect())
                } else if exact {
                    FlatSamples::F32(values)
                } else {
                    color(values)
                };
                channels.push(AnyChannel::new(name.as_str(), samples));
            }
        }
        for (k, name) in ["denoised.R", "denoised.G", "denoised.B"].into_iter().enumerate() {
            let Some(denoised) = denoised else { break };
            let values = denoised.iter().skip(k).step_by(3).copied();
            channels.push(AnyChannel::new(name, color(values.collect())));
        }
        let [left, top, ..] = self.area().map(|n| n as i32);
        let mut attributes = LayerAttributes::named("");
        attributes.layer_name = None;
        attributes.layer_position = Vec2(left, top);
        attributes.software_name = Some("vellus".into());
        for (name, value) in notes {
            // UTF-8, as most programs have it; the encoder's own conversion would refuse all but Latin.
            let value = AttributeValue::Text(Text::from_slice_unchecked(value.as_bytes()));
            attributes.other.insert(Text::from_slice_unchecked(name.as_bytes()), value);
        }
        let channels = AnyChannels::sort(channels.into_iter().collect());
        let layer = exr::image::Layer::new((width, height), attributes, ENCODING, channels);
        let [whole_width, whole_height] = self.whole();
        let mut image = Image::from_layer(layer);
        image.attributes.display_window = IntegerBounds::from_dimensions((whole_width, whole_height));
        let mut bytes = Cursor::new(Vec::new());
        image.write().non_parallel().to_buffered(&mut bytes).map_err(|e| e.to_string())?;
        Ok(bytes.into_inner())
    }

    /// One channel of a layer as it is stored.
    fn value(&self, x: usize, y: usize, layer: Layer, k: usize) -> f32 {
        let mean = self.mean(x, y, layer, k);
        let over = |cover: Layer| {
            let covered = self.mean(x, y, cover, 0);
            if covered > 0.0 { (mean / covered) as f32 } else { 0.0 }
        };
        match layer {
            Layer::Square => self.error(x, y).powi(2) as f32,
            Layer::Albedo | Layer::Normal | Layer::Depth | Layer::Motion => over(Layer::Alpha),
            Layer::Tangent | Layer::RootUv => over(Layer::Fibers),
            _ => mean as f32,
        }
    }

    /// Eight-bit sRGB pixels of the beauty times 2^`exposure`, what is brighter than white held there.
    pub fn to_srgb(&self, exposure: f32) -> Vec<u8> {
        self.layer_to_srgb(Layer::Beauty, 0, exposure)
    }

    fn layer_to_srgb(&self, layer: Layer, first: usize, exposure: f32) -> Vec<u8> {
        let places = (0..self.height()).flat_map(|y| (0..self.width()).flat_map(move |x| [0, 1, 2].map(|c| (x, y, c))));
        srgb(places.map(|(x, y, c)| self.mean(x, y, layer, first + c)), exposure)
    }

    /// A PNG of three channels of a layer from the `first` on, shown as the beauty is.
    ///
    /// # Errors
    /// What the encoder says.
    pub fn layer_to_png(&self, layer: Layer, first: usize, exposure: f32) -> std::result::Result<Vec<u8>, String> {
        self.encode_png(&self.layer_to_srgb(layer, first, exposure), &[])
    }

    /// A PNG of [`Film::to_srgb`], or of the beauty as a denoiser left it, with notes.
    ///
    /// # Errors
    /// What the encoder says.
    pub fn to_png(
        &self,
        denoised: Option<&[f32]>,
        exposure: f32,
        notes: &[(String, String)],
    ) -> std::result::Result<Vec<u8>, String> {
        let pixels = match denoised {
            Some(denoised) => srgb(denoised.iter().map(|&v| f64::from(v)), exposure),
            None => self.to_srgb(exposure),
        };
        self.encode_png(&pixels, notes)
    }

    fn encode_png(&self, pixels: &[u8], notes: &[(String, String)]) -> std::result::Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width() as u32, self.height() as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        for (name, value) in notes {
            encoder.add_itxt_chunk(name.clone(), value.clone()).map_err(|e| e.to_string())?;
        }
        let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
        writer.write_image_data(pixels).map_err(|e| e.to_string())?;
        writer.finish().map_err(|e| e.to_string())?;
        Ok(bytes)
    }
}

/// Eight-bit sRGB of values times 2^`exposure`.
fn srgb(values: impl Iterator<Item = f64>, exposure: f32) -> Vec<u8> {
    let scale = f64::from(exposure.exp2());
    let encode = |x: f64| {
        let x = (x * scale).clamp(0.0, 1.0);
        let y = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (255.0 * y).round() as u8
    };
    values.map(encode).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{add, nearest};
    use crate::layout::Layout;

    #[test]
    fn layers_come_back_from_exr() {
        let layout = Layout::new(&Layer::ALL, &["key".to_owned(), "rim".to_owned()]);
        let (sums, channels) = (layout.sums(), layout.channels());
        let start = |layer| layout.start(layer).unwrap();
        let row = |y: usize| {
            let mut row = vec![0; 3 * channels];
            for x in 0..3 {
                let mut values: Vec<f32> = (0..sums).map(|c| (c + 10 * x) as f32 * 0.25 + y as f32).collect();
                (values[start(Layer::Alpha)], values[start(Layer::Fibers)]) = (0.5, 0.25);
                let strand = nearest(2.0, 40_000_000 + x as u32);
                assert!(add(&mut row[x * channels..][..channels], &values, strand));
            }
            row
        };
        let mut film = Film::new([8, 9], [4, 5, 3, 2], layout.clone());
        film.add_rows((0..2).map(row));
        film.advance(1);
        let notes = [("vellus_command".to_owned(), "vellus render 狐.usda".to_owned())];
        let denoised: Vec<f32> = (0..18).map(|i| i as f32).collect();
        let bytes = film.to_exr(&Layer::ALL, Some(&denoised), Depth::Float, &notes).unwrap();
        let image =
            read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
        let image = image.from_buffered(Cursor::new(bytes)).unwrap();
        let layer = &image.layer_data;
        assert_eq!(image.attributes.display_window.size, Vec2(8, 9));
        assert_eq!(layer.attributes.layer_position, Vec2(4, 5));
        assert_eq!(layer.channel_data.list.len(), channels + 3);
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
        assert_eq!(at("denoised.G", 4), 13.0);
        assert_eq!(film.rgb(Layer::Beauty).unwrap()[13], mean(1, 1, Layer::Beauty, 1));
        assert!(film.rgb(Layer::Depth).is_none() && film.rgb(Layer::Lobes).is_none());
        assert_ne!(film.to_png(None, 0.0, &notes).unwrap(), film.to_png(Some(&denoised), 0.0, &notes).unwrap());
        // Only what is asked for, of what there is.
        let few = Film::new([8, 9], [4, 5, 3, 2], Layout::new(&[Layer::Depth], &[]));
        let bytes = few.to_exr(&[Layer::Beauty, Layer::Albedo], None, Depth::Half, &[]).unwrap();
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).unwrap();
        assert_eq!(meta.headers[0].channels.list.len(), 3);
    }
}
