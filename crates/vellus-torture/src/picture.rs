//! The content of a picture: the exact bits of its channels. Files of equal pictures may differ, because the order of
//! an OpenEXR file's attributes is random.

use exr::prelude::{ReadChannels, ReadLayers, read};
use std::io::BufReader;
use std::path::Path;

/// Channels by name, and their values as bits.
#[derive(Clone, PartialEq)]
pub struct Picture(Vec<(String, Vec<u32>)>);

impl Picture {
    /// Reads a PNG or OpenEXR file. The message describes the problem.
    pub fn read(path: &Path) -> Result<Picture, String> {
        let read = || if path.extension().is_some_and(|e| e == "png") { png(path) } else { exr(path) };
        // Third-party readers may panic on a damaged file.
        std::panic::catch_unwind(read).unwrap_or_else(|_| Err("its reader panics".to_owned()))
    }

    /// Whether all values are finite.
    pub fn is_finite(&self) -> bool {
        self.0.iter().flat_map(|(_, values)| values).all(|bits| f32::from_bits(*bits).is_finite())
    }

    /// The first difference of two pictures.
    pub fn difference(&self, other: &Picture) -> Option<String> {
        let names = |p: &Picture| p.0.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        if names(self) != names(other) {
            return Some(format!("channels {:?} and {:?}", names(self), names(other)));
        }
        for ((name, a), (_, b)) in self.0.iter().zip(&other.0) {
            if a.len() != b.len() {
                return Some(format!("{name} has {} and {} pixels", a.len(), b.len()));
            }
            let differ = a.iter().zip(b).filter(|(a, b)| a != b).count();
            if let Some(i) = a.iter().zip(b).position(|(a, b)| a != b) {
                let (a, b) = (f32::from_bits(a[i]), f32::from_bits(b[i]));
                return Some(format!("{name} differs in {differ} pixels, first in pixel {i}: {a} and {b}"));
            }
        }
        None
    }
}

fn exr(path: &Path) -> Result<Picture, String> {
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = image.from_file(path).map_err(|e| e.to_string())?;
    let channels = image.layer_data.channel_data.list.iter().map(|channel| {
        let bits = channel.sample_data.values_as_f32().map(f32::to_bits).collect();
        (channel.name.to_string(), bits)
    });
    Ok(Picture(channels.collect()))
}

fn png(path: &Path) -> Result<Picture, String> {
    let file = std::fs::File::open(path).map_err(|e| e.to_string())?;
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().map_err(|e| e.to_string())?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or("too large")?];
    reader.next_frame(&mut bytes).map_err(|e| e.to_string())?;
    // The data after the pixels must be complete too.
    reader.finish().map_err(|e| e.to_string())?;
    let size = reader.info().size();
    let name = format!("{}x{} {:?}", size.0, size.1, reader.output_color_type());
    // Small whole numbers, which print the same as floats.
    Ok(Picture(vec![(name, bytes.into_iter().map(|b| f32::from(b).to_bits()).collect())]))
}
