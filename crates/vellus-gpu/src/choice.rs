//! The choice of the device that renders.

use crate::device::{Device, DeviceError};
use crate::trace::Tracer;
use std::fmt;
use std::str::FromStr;
use vellus_render::packed::{Lacking, SampleTracer};
use vellus_render::{Error, Layout, Notes, Settings, World};

/// What renders a picture.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub enum Choice {
    /// The processor.
    #[default]
    Cpu,
    /// A GPU.
    Gpu,
    /// A GPU if there is one that can render the scene, otherwise the processor.
    Auto,
}

/// What [`Choice::renderer`] chose.
#[derive(Debug, Default)]
pub struct Renderer {
    /// The GPU, for [`Job::tracer`](vellus_render::session::Job::tracer). `None` is the processor.
    pub tracer: Option<Box<dyn SampleTracer>>,
    /// Which device was chosen and why, for users. `None` for [`Choice::Cpu`].
    pub message: Option<String>,
    /// The name of the GPU, for the attributes of a picture.
    pub notes: Notes,
}

impl Choice {
    /// All choices.
    pub const ALL: [Choice; 3] = [Choice::Cpu, Choice::Gpu, Choice::Auto];

    /// Its name on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Choice::Cpu => "cpu",
            Choice::Gpu => "gpu",
            Choice::Auto => "auto",
        }
    }

    /// Checks what can be checked before a scene is read: is there a GPU?
    ///
    /// # Errors
    /// [`Error::Device`] for [`Choice::Gpu`] if there is none.
    pub fn check(self) -> Result<(), Error> {
        if self == Choice::Gpu { Device::open().map(|_| ()).map_err(failed) } else { Ok(()) }
    }

    /// Prepares the GPU for a scene. [`Choice::Auto`] takes the processor if there is no GPU other than a
    /// [software](Device::is_software) one, or if the GPU cannot render the scene.
    ///
    /// # Errors
    /// [`Error::Device`] for [`Choice::Gpu`] if there is no GPU, or if it cannot render the scene.
    pub fn renderer(self, world: &World, settings: &Settings, layout: &Layout) -> Result<Renderer, Error> {
        let open = || {
            let device = Device::open().map_err(failed)?;
            if self == Choice::Auto && device.is_software() {
                return Err(Error::Device(format!("the GPU {} is a program on the processor", device.name())));
            }
            let tracer = Tracer::new(&device, world, settings, layout)?;
            let name = device.name().to_owned();
            Ok(Renderer {
                tracer: Some(Box::new(tracer)),
                message: Some(format!("the GPU {name} renders")),
                notes: vec![("vellus_gpu".to_owned(), name)],
            })
        };
        match self {
            Choice::Cpu => Ok(Renderer::default()),
            Choice::Gpu => open(),
            Choice::Auto => match open() {
                Err(Error::Device(why)) => {
                    Ok(Renderer { message: Some(format!("the processor renders: {why}")), ..Renderer::default() })
                }
                opened => opened,
            },
        }
    }
}

/// A feature that the path tracer on a GPU does not have.
pub(crate) fn refused(what: Lacking) -> Error {
    Error::Device(format!("the GPU cannot render {what}"))
}

pub(crate) fn failed(error: DeviceError) -> Error {
    Error::Device(error.to_string())
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Choice {
    type Err = Error;

    /// Reads [`Choice::name`].
    fn from_str(name: &str) -> Result<Self, Error> {
        Choice::ALL.into_iter().find(|choice| choice.name() == name).ok_or_else(|| {
            let known = Choice::ALL.map(Choice::name).join(", ");
            Error::Settings(format!("unknown device '{name}': known are {known}"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for choice in Choice::ALL {
            assert_eq!(choice.name().parse::<Choice>().ok(), Some(choice));
        }
        let error = "cuda".parse::<Choice>().map_err(|e| e.to_string());
        assert_eq!(error.err().as_deref(), Some("unknown device 'cuda': known are cpu, gpu, auto"));
    }
}
