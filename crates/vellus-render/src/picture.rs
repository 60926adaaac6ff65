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

/// Channel names of a layer, as compositors know them: `R`, `albedo.R`, `lobe_TT.G`, `N.X`, `Z`.
fn names(layer: Layer) -> Vec<String> {
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
    }
}

impl Film {
    /// An OpenEXR file with these layers and notes. Features (albedo, normal, tangent, depth) are means over the covered part of
    /// the pixel; the variance is that of the pixel's mean brightness.
    ///
    /// # Errors
    /// What the encoder says.
    pub fn to_exr(
        &self,
        layers: &[Layer],
        depth: Depth,
        notes: &[(&str, String)],
    ) -> std::result::Result<Vec<u8>, String> {
        let (width, height) = (self.width(), self.height());
        let mut channels = Vec::new();
        for layer in layers {
            for (k, name) in names(*layer).into_iter().enumerate() {
                let values = (0..width * height).map(|i| self.value(i % width, i / width, *layer, k));
                let exact = matches!(layer, Layer::Square | Layer::Depth);
                let samples = if depth == Depth::Float || exact {
                    FlatSamples::F32(values.collect())
                } else {
                    FlatSamples::F16(values.map(|v| f16::from_f32(v.clamp(-65504.0, 65504.0))).collect())
                };
                channels.push(AnyChannel::new(name.as_str(), samples));
            }
        }
        let mut attributes = LayerAttributes::named("");
        attributes.layer_name = None;
        attributes.software_name = Some("vellus".into());
        for (name, value) in notes {
            attributes.other.insert((*name).into(), AttributeValue::Text(value.as_str().into()));
        }
        let channels = AnyChannels::sort(channels.into_iter().collect());
        let layer = exr::image::Layer::new((width, height), attributes, Encoding::FAST_LOSSLESS, channels);
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(|e| e.to_string())?;
        Ok(bytes.into_inner())
    }

    /// One channel of a layer as it is stored.
    fn value(&self, x: usize, y: usize, layer: Layer, k: usize) -> f32 {
        let mean = self.mean(x, y, layer.start() + k);
        match layer {
            Layer::Square => self.error(x, y).powi(2) as f32,
            Layer::Albedo | Layer::Normal | Layer::Tangent | Layer::Depth => {
                let covered = self.mean(x, y, Layer::Alpha.start());
                if covered > 0.0 { (mean / covered) as f32 } else { 0.0 }
            }
            _ => mean as f32,
        }
    }

    /// Eight-bit sRGB pixels of the beauty times 2^`exposure`, what is brighter than white held there.
    pub fn to_srgb(&self, exposure: f32) -> Vec<u8> {
        let scale = f64::from(exposure.exp2());
        let encode = |x: f64| {
            let x = (x * scale).clamp(0.0, 1.0);
            let y = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
            (255.0 * y).round() as u8
        };
        (0..self.height())
            .flat_map(|y| (0..self.width()).flat_map(move |x| [0, 1, 2].map(|c| (x, y, c))))
            .map(|(x, y, c)| encode(self.mean(x, y, c)))
            .collect()
    }

    /// A PNG of [`Film::to_srgb`].
    ///
    /// # Errors
    /// What the encoder says.
    pub fn to_png(&self, exposure: f32) -> std::result::Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width() as u32, self.height() as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
        writer.write_image_data(&self.to_srgb(exposure)).map_err(|e| e.to_string())?;
        writer.finish().map_err(|e| e.to_string())?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{CHANNELS, add};

    #[test]
    fn layers_come_back_from_exr() {
        let mut film = Film::new(3, 2);
        for (y, row) in film.rows_mut().enumerate() {
            for x in 0..3 {
                let mut values: [f32; CHANNELS] = std::array::from_fn(|c| (c + 10 * x) as f32 * 0.25 + y as f32);
                values[Layer::Alpha.start()] = 0.5;
                assert!(add(&mut row[x * CHANNELS..][..CHANNELS], &values));
            }
        }
        film.advance(1);
        let notes = [("vellus_samples", "1".to_owned())];
        let bytes = film.to_exr(&Layer::ALL, Depth::Float, &notes).unwrap();
        let image =
            read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
        let image = image.from_buffered(Cursor::new(bytes)).unwrap();
        let layer = &image.layer_data;
        assert_eq!(layer.channel_data.list.len(), CHANNELS);
        assert_eq!(layer.attributes.other.get(&Text::from("vellus_samples")), Some(&AttributeValue::Text("1".into())));
        let channel = |name: &str| layer.channel_data.list.iter().find(|c| c.name.eq(name)).unwrap();
        let at = |name: &str, i: usize| channel(name).sample_data.value_by_flat_index(i).to_f32();
        assert_eq!(at("G", 4), film.mean(1, 1, 1) as f32);
        assert_eq!(at("lobe_TRTs.B", 2), film.mean(2, 0, Layer::Lobes.start() + 14) as f32);
        assert_eq!(at("N.Y", 3), 2.0 * film.mean(0, 1, Layer::Normal.start() + 1) as f32);
        assert!(!film.to_png(0.0).unwrap().is_empty());
    }
}
