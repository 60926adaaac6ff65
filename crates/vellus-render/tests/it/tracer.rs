//! Another tracer computes the samples: here one of grey pixels, which fails when it is told to.

use crate::common::{settings, world};
use vellus_models::Marschner2003;
use vellus_render::packed::{EXTRA_WORDS, Lacking, NONE, SampleTracer};
use vellus_render::session::{Event, Job, Options, Picture};
use vellus_render::{Error, Layer, Mode, Settings, World};

/// Every channel of every sample is 0.25. The tracer fails at the first sample in `lost_at`.
#[derive(Debug)]
struct Grey {
    channels: usize,
    lost_at: u64,
}

impl SampleTracer for Grey {
    fn samples_at_once(&self) -> usize {
        37
    }

    fn trace(&mut self, samples: &[[u32; 2]]) -> Result<Vec<u32>, Error> {
        if samples.iter().any(|sample| u64::from(sample[1]) == self.lost_at) {
            return Err(Error::Device("the GPU was lost: no answer".to_owned()));
        }
        let mut sample = vec![0.25f32.to_bits(); self.channels];
        sample.extend([0f32.to_bits(), 0, NONE, 1, 0, 0]);
        assert_eq!(sample.len(), self.channels + EXTRA_WORDS);
        Ok(sample.repeat(samples.len()))
    }
}

fn options() -> Options {
    Options::new(Settings { mode: Mode::Near, ..settings() }, 16)
}

#[test]
fn a_job_renders_with_another_tracer() -> Result<(), Error> {
    let folder = tempfile::tempdir().unwrap();
    let world = world();
    let channels = world.layout(&options().layers).channels();
    let tracer = Grey { channels, lost_at: u64::MAX };
    let job = Job { tracer: Some(Box::new(tracer)), ..Job::new(options(), Picture::new(folder.path().join("a.exr"))) };
    let film = job.run(&world, &(), |_| {})?.checkpoint.film;
    assert_eq!(film.samples(), 16);
    assert!((0..8).all(|x| (0..8).all(|y| film.mean(x, y, Layer::Beauty, 0) == 0.25)));
    Ok(())
}

/// The samples before the failure are kept, and the processor continues from them.
#[test]
fn a_lost_device_keeps_the_samples() -> Result<(), Error> {
    let folder = tempfile::tempdir().unwrap();
    let world = world();
    let channels = world.layout(&options().layers).channels();
    let job = || Job::new(options(), Picture::new(folder.path().join("a.exr")));
    // Passes have 1, at most 2, and at most 4 samples.
    let tracer = Grey { channels, lost_at: 5 };
    let lost = Job { tracer: Some(Box::new(tracer)), ..job() }.run(&world, &(), |_| {});
    let Err(Error::DeviceLost { what, samples, kept: Some(kept) }) = lost else { panic!("{lost:?}") };
    assert_eq!((what.as_str(), kept.exists()), ("the GPU was lost: no answer", true));
    assert!((1..=5).contains(&samples), "{samples}");
    assert!(folder.path().join("a.exr").exists());
    let mut resumed = 0;
    let outcome = Job { resume: true, ..job() }.run(&world, &(), |event| {
        if let Event::Resumed(samples) = event {
            resumed = samples;
        }
    })?;
    assert_eq!((resumed, outcome.checkpoint.film.samples(), kept.exists()), (samples, 16, false));
    Ok(())
}

/// If the device fails before the first pass is finished, no file is written.
#[test]
fn a_device_that_fails_at_once_writes_nothing() -> Result<(), Error> {
    let folder = tempfile::tempdir().unwrap();
    let world = world();
    let tracer = Grey { channels: world.layout(&options().layers).channels(), lost_at: 0 };
    let job = Job { tracer: Some(Box::new(tracer)), ..Job::new(options(), Picture::new(folder.path().join("a.exr"))) };
    let lost = job.run(&world, &(), |_| {});
    assert!(matches!(&lost, Err(Error::Device(what)) if what.contains("lost")), "{lost:?}");
    assert!(folder.path().read_dir().is_ok_and(|mut files| files.next().is_none()));
    Ok(())
}

#[test]
fn what_is_lacking_is_refused() -> Result<(), Error> {
    let mut world = world();
    let refused = |world: &World, settings: Settings| {
        let layout = world.layout(&[]);
        world.packed(&settings, &layout).map(|_| ()).err()
    };
    let near = options().settings;
    assert_eq!(refused(&world, near), None);
    let cached = Settings { radiance_cache: Some(8), ..near };
    assert_eq!(refused(&world, cached), Some(Lacking::RadianceCache));
    assert_eq!(Lacking::RadianceCache.to_string(), "a radiance cache (--radiance-cache)");
    for mode in Mode::ALL {
        assert_eq!(refused(&world, Settings { mode, ..near }), None);
    }
    world.set_model(Marschner2003::new)?;
    assert_eq!(refused(&world, near), Some(Lacking::Models));
    Ok(())
}
