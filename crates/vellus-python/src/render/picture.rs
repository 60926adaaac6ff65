//! Pictures: layers as arrays, and files.

use crate::checks::within;
use crate::error::{value, with_causes};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use std::path::PathBuf;
use vellus::Lobe;
use vellus_render::session::BACKGROUND_NOTE;
use vellus_render::{Denoised, Display, Film, Layer, Notes, PixelType, session};

/// A rendered picture: a mapping from names of layers to arrays.
///
/// An array has the shape (height, width, channels) or (height, width), with the top row first. Layers: `beauty`, and
/// with `denoise=True` `denoised`; `alpha` and `fibers` (coverage), `variance`, `albedo`, `normal`, `tangent`, `depth`,
/// `uv`, `motion`; `lobes` (height, width, 6, 3) in the order of `lobes`; `lights` (height, width, groups, 3) in the
/// order of `light_groups`; with `denoise=True` also `denoised_lobes` and `denoised_lights`, which add up to `denoised`
/// as the noisy ones do to `beauty`; `id`, the number of the nearest strand from 1 on, 0 for none; `crypto-object`,
/// `crypto-look` and `crypto-group`, pairs of an id and its coverage; with a radiance cache `cache-error`, the part of
/// the variance that belongs to it. Colours are linear sRGB.
#[pyclass(frozen, mapping, module = "vellus", name = "Picture")]
pub struct Picture {
    pub film: Film,
    pub denoised: Option<Denoised>,
    pub notes: Notes,
    pub is_transparent: bool,
    pub rays: u64,
    pub rejected: u64,
    pub seconds: f64,
}

impl Picture {
    fn layers(&self) -> impl Iterator<Item = Layer> + '_ {
        Layer::ALL.into_iter().filter(|layer| self.film.layout().has(*layer))
    }

    fn names(&self) -> Vec<&'static str> {
        let parts = self.denoised.iter().flat_map(|denoised| &denoised.parts).map(|(layer, _)| clean_name(*layer));
        let beauty = self.denoised.is_some().then_some("denoised");
        self.layers().map(Layer::name).chain(beauty).chain(parts).collect()
    }

    fn shape(&self, channels: &[usize]) -> Vec<usize> {
        [&[self.film.height(), self.film.width()], channels].concat()
    }

    fn array<'py>(&self, py: Python<'py>, layer: Layer) -> PyResult<Option<Bound<'py, PyAny>>> {
        let (width, height) = (self.film.width(), self.film.height());
        if layer == Layer::Strand {
            let ids = (0..width * height).map(|i| self.film.strand(i % width, i / width)).collect();
            return Ok(Some(PyArray1::from_vec(py, ids).reshape(self.shape(&[]))?.into_any()));
        }
        let Some(values) = crate::threads::run(py, |_| self.film.values(layer))? else { return Ok(None) };
        let channels = values.len() / (width * height).max(1);
        let shape = match layer {
            Layer::Lobes | Layer::Lights => self.shape(&[channels / 3, 3]),
            _ if channels == 1 => self.shape(&[]),
            _ => self.shape(&[channels]),
        };
        Ok(Some(PyArray1::from_vec(py, values).reshape(shape)?.into_any()))
    }
}

#[pymethods]
impl Picture {
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        if let Some(denoised) = &self.denoised {
            let part = denoised.parts.iter().find(|(layer, _)| name == clean_name(*layer)).map(|(_, values)| values);
            if let Some(values) = if name == "denoised" { Some(&denoised.beauty) } else { part } {
                let parts = values.len() / denoised.beauty.len().max(1);
                let shape = if part.is_some() { self.shape(&[parts, 3]) } else { self.shape(&[3]) };
                return Ok(PyArray1::from_slice(py, values).reshape(shape)?.into_any());
            }
        }
        let layer = name.parse::<Layer>().ok();
        let array = layer.map_or(Ok(None), |layer| self.array(py, layer))?;
        array.ok_or_else(|| {
            PyKeyError::new_err(format!("the picture has no layer {name:?}: it has {}", self.names().join(", ")))
        })
    }

    fn __contains__(&self, name: &str) -> bool {
        self.names().contains(&name)
    }

    fn __len__(&self) -> usize {
        self.names().len()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(PyList::new(py, self.names())?.try_iter()?.into_any())
    }

    /// The names of the layers.
    fn keys(&self) -> Vec<&'static str> {
        self.names()
    }

    /// The arrays of all layers: shapes as in the description of the class.
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        self.names().into_iter().map(|name| self.__getitem__(py, name)).collect()
    }

    /// Pairs of a name and an array: shapes as in the description of the class.
    fn items<'py>(&self, py: Python<'py>) -> PyResult<Vec<(&'static str, Bound<'py, PyAny>)>> {
        self.names().into_iter().map(|name| Ok((name, self.__getitem__(py, name)?))).collect()
    }

    /// The array of the layer `name`, or `default` if the picture does not have it: shape (height, width, ...).
    #[pyo3(signature = (name, default=None))]
    fn get<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        default: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        if self.__contains__(name) { self.__getitem__(py, name).map(Some) } else { Ok(default) }
    }

    /// Width of the picture, or of its crop, in pixels.
    #[getter]
    fn width(&self) -> usize {
        self.film.width()
    }

    /// Height of the picture, or of its crop, in pixels.
    #[getter]
    fn height(&self) -> usize {
        self.film.height()
    }

    /// Samples a pixel.
    #[getter]
    fn samples(&self) -> u64 {
        self.film.samples()
    }

    /// The noise of the picture: the root mean square of the pixels' standard errors over the mean brightness. `None`
    /// if it is unknown.
    #[getter]
    fn noise(&self) -> Option<f64> {
        self.film.noise()
    }

    /// The names of the light groups of the layer `lights`.
    #[getter]
    fn light_groups(&self) -> Vec<String> {
        self.film.layout().groups().to_vec()
    }

    /// The names of the six lobes of the layer `lobes`.
    #[getter]
    fn lobes(&self) -> Vec<&'static str> {
        Lobe::ALL.iter().map(|lobe| lobe.key()).collect()
    }

    /// The names of the things in a Cryptomatte `layer` (`crypto-object`, `crypto-look` or `crypto-group`), with their
    /// ids. The bits of an id, read as float32, are the value in the pixels of the layer.
    ///
    /// Raises `KeyError` if the picture does not have the layer, or if it is of another kind.
    fn ids<'py>(&self, py: Python<'py>, layer: &str) -> PyResult<Bound<'py, PyDict>> {
        let found = layer.parse::<Layer>().ok().filter(|found| Layer::CRYPTOMATTE.contains(found));
        let Some(found) = found.filter(|found| self.film.layout().has(*found)) else {
            return Err(PyKeyError::new_err(format!("the picture has no Cryptomatte layer {layer:?}")));
        };
        let all = PyDict::new(py);
        self.film.ids(found).into_iter().try_for_each(|(name, id)| all.set_item(name, id))?;
        Ok(all)
    }

    /// `seconds` of rendering, `rays` that were traced, and `rejected` samples, which were not finite.
    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        all.set_item("seconds", self.seconds)?;
        all.set_item("rays", self.rays)?;
        all.set_item("rejected", self.rejected)?;
        Ok(all)
    }

    /// Writes an OpenEXR file with all layers and a PNG preview beside it, or a PNG file alone, and returns their
    /// paths.
    ///
    /// `path`: ends in .exr or .png. `exposure`: stops by which the PNG is brighter, in [-100, 100]. `tone`: its tone
    /// curve, `neutral` (keeps colours and compresses highlights), `agx` or `srgb` (clips). `half`: colours in 16 bits
    /// where they fit.
    ///
    /// Raises `ValueError` for another extension, and `PermissionError` or `ValueError` if the file cannot be written.
    /// An older file then stays.
    #[pyo3(signature = (path, *, exposure=0.0, tone="neutral", half=true))]
    fn write(&self, py: Python<'_>, path: PathBuf, exposure: f32, tone: &str, half: bool) -> PyResult<Vec<PathBuf>> {
        if !matches!(path.extension().and_then(|e| e.to_str()), Some("exr" | "png")) {
            let path = path.display();
            return Err(PyValueError::new_err(format!("path = {path} has another extension: it must be .exr or .png")));
        }
        let display = display(exposure, tone)?;
        let mut notes = self.notes.clone();
        if self.is_transparent {
            notes.push((BACKGROUND_NOTE.to_owned(), "transparent".to_owned()));
        }
        let picture = session::Picture {
            layers: self.layers().collect(),
            pixel_type: if half { PixelType::Half } else { PixelType::Float },
            display,
            notes,
            ..session::Picture::new(path)
        };
        crate::threads::run(py, |_| picture.write(&self.film, self.denoised.as_ref()))?.map_err(|e| with_causes(&e))
    }

    /// The beauty, or the denoised picture, as sRGB bytes of the shape (height, width, 3). `exposure`: in stops,
    /// in [-100, 100]. `tone`: as in `write`.
    #[pyo3(signature = (exposure=0.0, *, tone="neutral"))]
    fn srgb<'py>(&self, py: Python<'py>, exposure: f32, tone: &str) -> PyResult<Bound<'py, PyAny>> {
        let display = display(exposure, tone)?;
        let bytes = match &self.denoised {
            Some(denoised) => self.film.denoised_to_srgb(&denoised.beauty, display),
            None => self.film.to_srgb(display),
        };
        Ok(PyArray1::from_vec(py, bytes).reshape(self.shape(&[3]))?.into_any())
    }

    /// The picture in a notebook.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let encode = if self.is_transparent { Film::to_transparent_png } else { Film::to_png };
        let png = encode(&self.film, self.denoised.as_ref().map(|d| &d.beauty[..]), Display::default(), &[])
            .map_err(value)?;
        Ok(PyBytes::new(py, &png))
    }

    fn __repr__(&self) -> String {
        let (width, height, samples) = (self.film.width(), self.film.height(), self.film.samples());
        format!("<vellus.Picture: {width} x {height}, {samples} samples, {}>", self.names().join(", "))
    }
}

/// The name of a denoised part.
fn clean_name(layer: Layer) -> &'static str {
    if layer == Layer::Lobes { "denoised_lobes" } else { "denoised_lights" }
}

/// How a picture is shown.
fn display(exposure: f32, tone: &str) -> PyResult<Display> {
    within("exposure", exposure.into(), -100.0..=100.0)?;
    Ok(Display { exposure, tone: super::scene::parsed("tone", Some(tone.to_owned()))?.unwrap_or_default() })
}
