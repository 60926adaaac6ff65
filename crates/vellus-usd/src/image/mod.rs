//! Reads images: PNG, JPEG, TIFF, Radiance HDR and OpenEXR. The first bytes determine the format.

mod exr;
mod ies;
mod jpeg;
mod pixels;
mod png;
mod probe;
mod rgbe;
mod samples;
mod tiff;
mod tiles;

pub(crate) use exr::encode as encode_exr;
pub(crate) use ies::{Use, encode as encode_profile};
pub(crate) use probe::Probe;
pub(crate) use tiles::{TILES, UDIM, join, shrink, split, tile_name};

use crate::color::ColorSpace;
use crate::error::{Error, Invalid};
use crate::guard::catch;
use crate::warning::Warning;
use pixels::Pixels;
use std::path::Path;
use vellus_scene::{self as scene, Texture, Wrap};

/// The largest image file, in bytes: 4 GiB.
const MAX_BYTES: u64 = 4 << 30;

/// The memory for images of a scene, in bytes, before the files earn more: 2 GiB.
const MEMORY: u64 = 2 << 30;

/// How many bytes of memory a byte of an image file earns. Pictures have less than that, only flat ones have more.
const EARNED: u64 = 64;

/// What a light adds to each pixel of its image: a copy, and two numbers of its tables.
const LIT: u64 = 12 + 8;

/// The memory that all images of a scene use, and how much they may use.
#[derive(Debug, Default)]
pub(crate) struct Budget {
    used: u64,
    earned: u64,
}

impl Budget {
    /// Counts an image that was read from a file of this size.
    pub fn image(&mut self, texture: &Texture, file_bytes: usize) -> Result<(), Invalid> {
        self.earned = self.earned.saturating_add(EARNED * file_bytes as u64);
        self.take(texture, texture.pixels.size() as u64)
    }

    /// Counts what a light adds to its image.
    pub fn light(&mut self, texture: &Texture) -> Result<(), Invalid> {
        self.take(texture, LIT * texture.pixels.len() as u64)
    }

    fn take(&mut self, texture: &Texture, bytes: u64) -> Result<(), Invalid> {
        self.used = self.used.saturating_add(bytes);
        if self.used <= MEMORY + self.earned {
            return Ok(());
        }
        let (used, allowed) = (self.used >> 20, (MEMORY + self.earned) >> 20);
        let size = format!("{} × {} pixels", texture.width, texture.height);
        let why = format!("2 GiB, and {EARNED} bytes for each byte of the files");
        Err(format!(
            "with its {size}, images and the tables of lights need {used} MiB: {allowed} MiB are allowed ({why})"
        )
        .into())
    }
}

/// How the numbers in a file are meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) enum Encoding {
    /// As UsdPreviewSurface defines: a PNG is sRGB if it has an sRGB chunk or 8-bit colour. All others are linear.
    #[default]
    Auto,
    /// In this colour space.
    Space(ColorSpace),
    /// Its alpha channel, as plain numbers; 1 if it has none.
    Alpha,
    /// The intensity of a lamp by direction, as an IES profile.
    Profile(Use),
}

/// Reads an image as linear RGB. Alpha is ignored, and grey becomes three equal channels.
///
/// Negative values become 0, and the warning has their number. Resampling causes them near bright edges.
///
/// # Errors
/// [`Error::Read`] if the file cannot be read or has more than 4 GiB. [`Error::File`] if it is broken, has another
/// format, more than 2²⁷ pixels, or a pixel that is not finite.
pub fn load_texture(file: &Path) -> Result<(Texture, Option<Warning>), Error> {
    load(file, Encoding::Auto)
}

/// Reads an image of plain numbers, such as a density map. Its values are linear whatever the file says. Otherwise the
/// same as [`load_texture`].
///
/// # Errors
/// As [`load_texture`].
pub fn load_map(file: &Path) -> Result<(Texture, Option<Warning>), Error> {
    load(file, Encoding::Space(ColorSpace::LINEAR))
}

/// Reads the image of a sky, in lat-long. Otherwise the same as [`load_texture`]; a warning says if the image has
/// another shape.
///
/// # Errors
/// As [`load_texture`].
pub fn load_sky(file: &Path) -> Result<(Texture, Vec<Warning>), Error> {
    let (texture, warning) = load_texture(file)?;
    let shape =
        not_latlong(&texture).map(|what| Warning { fault: None, prims: vec![file.display().to_string()], what });
    let warnings = warning.into_iter().chain(shape).collect();
    Ok((texture, warnings))
}

/// What to say of the image of a sky that cannot be lat-long.
pub(crate) fn not_latlong(image: &Texture) -> Option<String> {
    let Texture { name, width, height, .. } = image;
    let what = "a lat-long image is twice as wide as high, so it is stretched";
    (!image.is_latlong()).then(|| format!("the image {name} of a sky has {width} × {height} pixels: {what}"))
}

fn load(file: &Path, encoding: Encoding) -> Result<(Texture, Option<Warning>), Error> {
    let bytes = vellus_io::read_at_most(file, MAX_BYTES).map_err(|error| Error::read(file, error))?;
    let Image { texture, warning } = decode(file, &bytes, encoding)?;
    let mut budget = Budget::default();
    // The image may be that of a light.
    let counted = budget.image(&texture, bytes.len()).and_then(|()| budget.light(&texture));
    counted.map_err(|what| Error::file(file, what))?;
    Ok((texture, warning.map(|what| Warning { fault: None, prims: vec![file.display().to_string()], what })))
}

/// A decoded image, and a warning about its pixels.
#[derive(Debug, PartialEq)]
pub(crate) struct Image {
    pub texture: Texture,
    pub warning: Option<String>,
}

/// Decodes the bytes of a file, which may be inside a package.
pub(crate) fn decode(file: &Path, bytes: &[u8], encoding: Encoding) -> Result<Image, Error> {
    let mut damage = None;
    let mut by_format = || match bytes {
        [0x89, b'P', b'N', b'G', ..] => png::decode(bytes).map(|samples| samples.pixels(encoding)),
        [0xff, 0xd8, 0xff, ..] => guarded(|| jpeg::decode(bytes)).map(|(samples, what)| {
            damage = what;
            samples.pixels(encoding)
        }),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => {
            guarded(|| tiff::decode(bytes)).map(|samples| samples.pixels(encoding))
        }
        [b'#', b'?', ..] => rgbe::decode(bytes).map(|pixels| converted(pixels, encoding, false)),
        [0x76, 0x2f, 0x31, 0x01, ..] => {
            guarded(|| exr::decode(bytes, encoding == Encoding::Alpha)).map(|pixels| converted(pixels, encoding, true))
        }
        _ => Err("it is no PNG, JPEG, TIFF, Radiance HDR or OpenEXR image".into()),
    };
    let decoded = if let Encoding::Profile(used) = encoding { ies::decode(bytes, used) } else { by_format() };
    let Pixels { width, height, rgb: mut pixels } = decoded.map_err(|what| Error::file(file, what))?;
    let name = file.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
    let mut negative = 0;
    // Bytes stand for no negative values.
    if let scene::Pixels::Colors(colors) = &mut pixels {
        for pixel in colors {
            if pixel.iter().any(|x| *x < 0.0 && x.is_finite()) {
                negative += 1;
                *pixel = pixel.map(|x| if x.is_finite() { x.max(0.0) } else { x });
            }
        }
    }
    let negative = (negative > 0).then(|| format!("has {negative} pixels with negative values: these become 0"));
    let warning = damage.or(negative).map(|what| format!("the image {name} {what}"));
    let texture = Texture { name, width, height, pixels, wrap: [Wrap::Repeat; 2] };
    texture.validate().map_err(|error| Error::file(file, error))?;
    Ok(Image { texture, warning })
}

/// The result of a decoder that may panic.
fn guarded<T>(decode: impl FnOnce() -> Result<T, Invalid>) -> Result<T, Invalid> {
    catch(decode).unwrap_or(Err("broken image: it cannot be decoded".into()))
}

/// Pixels in linear Rec. 709.
fn converted(mut pixels: Pixels, encoding: Encoding, has_alpha: bool) -> Pixels {
    if encoding == Encoding::Alpha && !has_alpha {
        pixels.rgb.map(|_| [1.0; 3]);
    }
    if let Encoding::Space(space) = encoding
        && space != ColorSpace::LINEAR
    {
        let convert = space.converter();
        pixels.rgb.map(|pixel| convert(pixel.map(f64::from)).map(|x| x as f32));
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;
    // The crate, not the module beside this one.
    use ::png;

    /// Files of `tests/data/images/make_images.py`.
    pub(super) const GREY_JPEG: &[u8] = include_bytes!("../../tests/data/images/grey.jpg");
    const JPEG: &[u8] = include_bytes!("../../tests/data/images/baseline.jpg");
    const PROGRESSIVE: &[u8] = include_bytes!("../../tests/data/images/progressive.jpg");

    fn tiff<C: ::tiff::encoder::colortype::ColorType>(samples: &[C::Inner]) -> Vec<u8>
    where
        [C::Inner]: ::tiff::encoder::TiffValue,
    {
        let mut bytes = std::io::Cursor::new(Vec::new());
        ::tiff::encoder::TiffEncoder::new(&mut bytes).unwrap().write_image::<C>(2, 1, samples).unwrap();
        bytes.into_inner()
    }

    fn png(color: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    #[test]
    fn colour_is_srgb_and_grey_is_linear_unless_told() {
        let rgb = png(png::ColorType::Rgb, png::BitDepth::Eight, &[0, 128, 255, 10, 20, 30]);
        let read = |bytes: &[u8], encoding| decode(Path::new("a/b.png"), bytes, encoding).unwrap().texture;
        let texture = read(&rgb, Encoding::Auto);
        assert_eq!((texture.name.as_str(), texture.width, texture.height), ("b.png", 2, 1));
        assert!((texture.pixels.get(0)[1] - 0.215_860_5).abs() < 1e-6 && texture.pixels.get(0)[2] == 1.0);
        assert_eq!(read(&rgb, Encoding::Space(ColorSpace::LINEAR)).pixels.get(0)[1], 128.0 / 255.0);
        let grey = png(png::ColorType::Grayscale, png::BitDepth::Eight, &[51, 102]);
        assert_eq!(read(&grey, Encoding::Auto).pixels, vec![[0.2; 3], [0.4; 3]].into());
        let deep = png(png::ColorType::GrayscaleAlpha, png::BitDepth::Sixteen, &[0x80, 0, 9, 9, 255, 255, 0, 0]);
        assert_eq!(read(&deep, Encoding::Auto).pixels, vec![[32768.0 / 65535.0; 3], [1.0; 3]].into());
    }

    /// Brown and blue, quantised: a channel is within 2 of the value that was encoded.
    #[test]
    fn jpeg_is_srgb_if_it_has_a_colour() {
        for bytes in [JPEG, PROGRESSIVE] {
            let Image { texture, warning } = decode(Path::new("a.jpg"), bytes, Encoding::Auto).unwrap();
            assert_eq!((texture.width, texture.height, warning), (16, 8, None));
            for (x, color) in [(3, [200.0, 100.0, 50.0]), (12, [20.0, 40.0, 220.0])] {
                for c in 0..3 {
                    let [low, high] = [-2.0, 2.0].map(|d| ColorSpace::SRGB.decode((color[c] + d) / 255.0) as f32);
                    assert!((low..=high).contains(&texture.pixels.get(3 * 16 + x)[c]), "{x} {c}: {texture:?}");
                }
            }
        }
        let grey = decode(Path::new("a.jpg"), GREY_JPEG, Encoding::Auto).unwrap().texture;
        assert_eq!((grey.width, grey.height, grey.pixels), (8, 8, vec![[0.2; 3]; 64].into()));
    }

    #[test]
    fn a_damaged_jpeg_is_shown_with_a_warning() {
        let Image { texture, warning } = decode(Path::new("a.jpg"), &JPEG[..JPEG.len() - 8], Encoding::Auto).unwrap();
        assert_eq!((texture.width, texture.height), (16, 8));
        let warning = warning.unwrap();
        assert!(warning.starts_with("the image a.jpg is damaged, and parts of it are grey: "), "{warning}");
    }

    #[test]
    fn tiff_has_grey_or_colour_in_whole_numbers_or_floats() {
        use ::tiff::encoder::colortype as kind;
        let read = |bytes: &[u8]| -> Vec<[f32; 3]> {
            decode(Path::new("a.tif"), bytes, Encoding::Auto).unwrap().texture.pixels.iter().collect()
        };
        assert_eq!(read(&tiff::<kind::Gray8>(&[51, 102])), [[0.2; 3], [0.4; 3]]);
        assert_eq!(read(&tiff::<kind::Gray16>(&[0, 13107])), [[0.0; 3], [0.2; 3]]);
        assert_eq!(read(&tiff::<kind::Gray32>(&[0, u32::MAX])), [[0.0; 3], [1.0; 3]]);
        assert_eq!(read(&tiff::<kind::Gray32Float>(&[0.25, 7.5])), [[0.25; 3], [7.5; 3]]);
        let eight = read(&tiff::<kind::RGBA8>(&[0, 128, 255, 9, 255, 0, 0, 9]));
        assert!((eight[0][1] - 0.215_860_5).abs() < 1e-6 && eight[1] == [1.0, 0.0, 0.0], "{eight:?}");
        assert_eq!(read(&tiff::<kind::RGB16>(&[0, 13107, 65535, 65535, 0, 0])), [[0.0, 0.2, 1.0], [1.0, 0.0, 0.0]]);
        let floats = [0.0, 1e-30, 3e38, 0.1, 0.2, 0.3];
        assert_eq!(read(&tiff::<kind::RGB32Float>(&floats)), [[0.0, 1e-30, 3e38], [0.1, 0.2, 0.3]]);
        let negative = decode(Path::new("a.tif"), &tiff::<kind::Gray32Float>(&[-1.0, 1.0]), Encoding::Auto).unwrap();
        assert_eq!((negative.texture.pixels.get(0), negative.warning.is_some()), ([0.0; 3], true));
        let other = decode(Path::new("a.tif"), &tiff::<kind::CMYK8>(&[0; 8]), Encoding::Auto).unwrap_err().to_string();
        assert!(other.contains("CMYK(8)") && other.contains("grey or RGB"), "{other}");
    }

    /// 0x8080 is 0.501961 of the largest number: ((0.501961 + 0.055) / 1.055)^2.4 = 0.215861.
    #[test]
    fn sixteen_bits_with_an_srgb_chunk_or_read_as_srgb_have_the_curve() {
        let encode = |chunk: bool| {
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Sixteen);
            if chunk {
                encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
            }
            encoder.write_header().unwrap().write_image_data(&[0x80, 0x80, 0, 0, 0xff, 0xff]).unwrap();
            bytes
        };
        let read = |bytes: &[u8], encoding| decode(Path::new("b.png"), bytes, encoding).unwrap().texture.pixels.get(0);
        let srgb = Encoding::Space(ColorSpace::SRGB);
        for pixel in [read(&encode(true), Encoding::Auto), read(&encode(false), srgb)] {
            assert!((pixel[0] - 0.215_860_5).abs() < 1e-6 && pixel[1..] == [0.0, 1.0], "{pixel:?}");
        }
        let linear = Encoding::Space(ColorSpace::LINEAR);
        for pixel in [read(&encode(false), Encoding::Auto), read(&encode(true), linear)] {
            assert!((pixel[0] - 0.501_960_8).abs() < 1e-6, "{pixel:?}");
        }
    }

    #[test]
    fn images_of_a_scene_have_a_budget() {
        let texture = |pixels: usize| {
            let pixels = vec![[0.0; 3]; pixels];
            Texture {
                name: String::new(),
                width: pixels.len(),
                height: 1,
                pixels: pixels.into(),
                wrap: [Wrap::Repeat; 2],
            }
        };
        // 2²⁰ pixels have 12 MiB, and 20 MiB more for each light.
        let image = texture(1 << 20);
        let mut budget = Budget::default();
        budget.image(&image, 0).unwrap();
        for _ in 0..101 {
            budget.light(&image).unwrap();
        }
        let error = budget.light(&image).unwrap_err().0;
        assert!(error.contains("1048576 × 1 pixels") && error.contains("2052 MiB: 2048 MiB are allowed"), "{error}");
        // A file with content earns its memory.
        let mut budget = Budget::default();
        (0..1000).for_each(|_| budget.image(&image, 1 << 20).unwrap());
    }

    #[test]
    fn exr_keeps_every_bit() {
        let pixels = vec![[0.0, 1e-30, 3.4e38], [0.1, 0.2, 0.3], [1.0 / 3.0, 5.0, 7e7]].into();
        let texture = Texture { name: "t.exr".to_owned(), width: 1, height: 3, pixels, wrap: [Wrap::Repeat; 2] };
        let read = decode(Path::new("t.exr"), &encode_exr(&texture).unwrap(), Encoding::Auto).unwrap();
        assert_eq!(read, Image { texture, warning: None });
    }

    #[test]
    fn negative_pixels_become_black_and_are_counted() {
        let image = |pixels: Vec<[f32; 3]>| {
            let texture = Texture {
                name: String::new(),
                width: pixels.len(),
                height: 1,
                pixels: pixels.into(),
                wrap: [Wrap::Repeat; 2],
            };
            decode(Path::new("a.exr"), &encode_exr(&texture).unwrap(), Encoding::Auto)
        };
        let read = image(vec![[1.0, -0.01, 2.0], [0.5; 3], [-1.0; 3]]).unwrap();
        assert_eq!(read.texture.pixels, vec![[1.0, 0.0, 2.0], [0.5; 3], [0.0; 3]].into());
        assert!(read.warning.unwrap().contains("a.exr has 2 pixels"));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(image(vec![[bad, -1.0, 0.0]]).unwrap_err().to_string().contains("not finite"), "{bad}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_no_images() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.png", "a.exr", "a.hdr"] {
            std::os::unix::fs::symlink("/dev/zero", folder.path().join(name)).unwrap();
            let error = load_map(&folder.path().join(name)).unwrap_err();
            assert!(
                matches!(error, Error::Read { source, .. } if source.to_string().contains("it is a device")),
                "{name}"
            );
        }
    }

    #[test]
    fn broken_images_are_errors() {
        let whole = [
            png(png::ColorType::Rgb, png::BitDepth::Eight, &[1; 6]),
            encode_exr(&Texture {
                name: String::new(),
                width: 4,
                height: 4,
                pixels: vec![[1.0; 3]; 16].into(),
                wrap: [Wrap::Repeat; 2],
            })
            .unwrap(),
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x01\x02\x03\x80\x01\x02\x03\x80".to_vec(),
            tiff::<::tiff::encoder::colortype::RGB16>(&[1, 2, 3, 4, 5, 6]),
            JPEG.to_vec(),
            PROGRESSIVE.to_vec(),
        ];
        for bytes in whole {
            assert!(decode(Path::new("x"), &bytes, Encoding::Auto).is_ok());
            for end in 0..bytes.len() - 1 {
                // A chunk after the pixels may be missing; before, it is an error or a warning, never a panic.
                let result = decode(Path::new("x"), &bytes[..end], Encoding::Auto);
                let is_whole = result.is_ok_and(|image| image.warning.is_none());
                assert!(!is_whole || end + 20 > bytes.len(), "{end} of {}", bytes.len());
            }
            for at in 0..bytes.len() {
                let mut garbled = bytes.clone();
                garbled[at] ^= 0xff;
                let _ = decode(Path::new("x"), &garbled, Encoding::Auto);
            }
        }
        let error = load_texture(Path::new("no/such.png")).unwrap_err().to_string();
        assert!(error.contains("no/such.png"), "{error}");
        let huge = b"#?RADIANCE\n\n-Y 999999 +X 999999\n";
        assert!(decode(Path::new("x"), huge, Encoding::Auto).unwrap_err().to_string().contains("999999 × 999999"));
    }
}
