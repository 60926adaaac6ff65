//! Pictures without noise: the beauty, and its parts, which add up to it.

use super::{Film, Layer};
use crate::error::Error;

/// Removes noise from pictures. With the feature `denoise`, the type `Denoiser` does so.
pub trait Denoise: std::fmt::Debug {
    /// These pictures of a film without noise: each has three values a pixel, row by row. The layers albedo and normal
    /// of the film may guide the denoiser.
    ///
    /// # Errors
    /// [`Error::Denoise`].
    fn clean(&self, film: &Film, pictures: &[Vec<f32>]) -> Result<Vec<Vec<f32>>, Error>;
}

/// What a denoiser leaves of a film.
#[derive(Clone, Debug, PartialEq)]
pub struct Denoised {
    /// Three values a pixel, row by row.
    pub beauty: Vec<f32>,
    /// [`Layer::Lobes`] and [`Layer::Lights`]: all channels of a pixel, row by row. The lights of all groups add up to
    /// the beauty. So do the lobes where the camera sees fibres alone.
    pub parts: Vec<(Layer, Vec<f32>)>,
}

impl Denoised {
    /// Denoises the beauty of a film, and those of [`Layer::Lobes`] and [`Layer::Lights`] that it keeps and that are in
    /// `layers`.
    ///
    /// Each light, each lobe and the light without lobes is denoised alone. Then all of a pixel are multiplied by
    /// the factor that makes their sum the denoised beauty.
    ///
    /// # Errors
    /// [`Error::Denoise`] with what the denoiser reports, or if the film has no beauty.
    pub fn new(denoiser: &dyn Denoise, film: &Film, layers: &[Layer]) -> Result<Self, Error> {
        let beauty = film.rgb(Layer::Beauty).ok_or_else(|| Error::Denoise("the film has no beauty".to_owned()))?;
        let mut pictures = vec![beauty];
        let mut kept = Vec::new();
        for layer in [Layer::Lobes, Layer::Lights].into_iter().filter(|layer| layers.contains(layer)) {
            let Some(values) = film.values(layer) else { continue };
            let channels = values.len() / (film.width() * film.height());
            let first = pictures.len();
            pictures.extend((0..channels / 3).map(|part| {
                values.chunks_exact(channels).flat_map(|pixel| &pixel[3 * part..][..3]).copied().collect::<Vec<f32>>()
            }));
            let count = pictures.len() - first;
            if layer == Layer::Lobes {
                pictures.push(rest(&pictures[0], &pictures[first..]));
            }
            kept.push((layer, first..first + count, first..pictures.len()));
        }
        let mut clean = denoiser.clean(film, &pictures)?;
        let parts = kept.into_iter().map(|(layer, parts, all)| {
            let (beauty, others) = clean.split_at_mut(1);
            make_sum(&mut others[all.start - 1..all.end - 1], &beauty[0]);
            let parts = &others[parts.start - 1..parts.end - 1];
            let pixels = 0..beauty[0].len() / 3;
            (layer, pixels.flat_map(|i| parts.iter().flat_map(move |part| &part[3 * i..][..3])).copied().collect())
        });
        let parts = parts.collect();
        Ok(Denoised { beauty: clean.swap_remove(0), parts })
    }
}

/// What parts lack of the whole. Rounding may leave a little less than 0.
fn rest(whole: &[f32], parts: &[Vec<f32>]) -> Vec<f32> {
    let left = |(i, x): (usize, &f32)| (x - parts.iter().map(|part| part[i]).sum::<f32>()).max(0.0);
    whole.iter().enumerate().map(left).collect()
}

/// Multiplies the parts so that they add up to the whole. Where all are 0, they get equal shares.
fn make_sum(parts: &mut [Vec<f32>], whole: &[f32]) {
    for (i, whole) in whole.iter().enumerate() {
        let sum: f32 = parts.iter().map(|part| part[i]).sum();
        let count = parts.len() as f32;
        parts.iter_mut().for_each(|part| part[i] = if sum > 0.0 { part[i] * whole / sum } else { whole / count });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_to_the_whole() {
        let whole = [0.5, 2.0, 0.0, 0.3];
        let mut parts = vec![vec![0.1, 3.0, 0.5, 0.0], vec![0.2, 1.0, 0.0, 0.0]];
        make_sum(&mut parts, &whole);
        for (i, whole) in whole.iter().enumerate() {
            assert!((parts[0][i] + parts[1][i] - whole).abs() < 1e-6);
        }
        assert!((parts[0][0] - 0.5 / 3.0).abs() < 1e-6 && parts[0][1] == 1.5 && parts[1][3] == 0.15);
        assert_eq!(rest(&[1.0, 1.0], &[vec![0.25, 0.75], vec![0.25, 0.5]]), [0.5, 0.0]);
    }
}
