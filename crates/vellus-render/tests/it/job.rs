//! Jobs: events, checkpoints, and what is kept when files cannot be written.

use crate::common::{STATE, dome, fox, settings, world};
use glam::Vec3;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use vellus_io::Digest;
use vellus_render::session::{End, Event, IDENTITY_NOTE, Job, Options, Outcome, Picture, Rescue, read_film};
use vellus_render::{Denoise, Denoised, Error, Film, Layer, World};
use vellus_scene::{LightShape, Scene};
use vellus_testing::program::is_alone_with;

/// A job that writes `fox.exr` to a folder, with a checkpoint after each pass.
fn job(folder: &Path, samples: u64) -> Job {
    let identity = Digest::of(folder.to_string_lossy().as_bytes());
    let notes = vec![(IDENTITY_NOTE.to_owned(), identity.to_string())];
    let options = Options { identity, notes, ..Options::new(settings(), samples) };
    Job { interval: Duration::ZERO, resume: true, ..Job::new(options, Picture::new(folder.join("fox.exr"))) }
}

/// The name of an event, without its content.
fn name(event: &Event) -> String {
    format!("{event:?}").split([' ', '(', '{']).next().unwrap().to_owned()
}

/// Runs a job, and returns the names of its events. Passes that follow each other are one.
fn run(world: &World, job: Job) -> (Result<Outcome, Error>, Vec<String>) {
    let mut events = Vec::new();
    let result = job.run(world, &(), |event| events.push(name(&event)));
    events.dedup();
    // Not all systems report it.
    events.retain(|name| name != "CpuTime");
    (result, events)
}

/// Interrupts a job after its first pass.
fn interrupt(world: &World, job: Job) -> Outcome {
    let stop = AtomicBool::new(false);
    let outcome = job.run(world, &stop, |event| {
        if let Event::Pass(_) = event {
            stop.store(true, Ordering::Relaxed);
        }
    });
    outcome.unwrap()
}

#[test]
fn an_interrupted_job_keeps_a_checkpoint_and_the_next_one_finishes() {
    let world = world();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let first = interrupt(&world, Job { film: true, ..job(folder.path(), 5) });
    assert_eq!((first.end, first.kept), (End::Interrupted, Some(at("fox.checkpoint"))));
    assert_eq!(first.files, [at("fox.exr"), at("fox.png")]);
    assert_eq!(read_film(&at("fox.checkpoint")).unwrap(), first.checkpoint);
    // An interrupted job writes no film.
    assert!(first.checkpoint.film.samples() == 1 && !at("fox.film").exists());
    let (second, events) = run(&world, Job { film: true, preview: true, ..job(folder.path(), 5) });
    let second = second.unwrap();
    let expected = ["Resumed", "Started", "Pass", "Preview", "Pass", "Rendered", "WroteFilm", "Wrote"];
    assert_eq!(events, expected);
    assert_eq!((second.end, second.kept), (End::Samples, None));
    assert!(!at("fox.checkpoint").exists());
    assert_eq!(read_film(&at("fox.film")).unwrap(), second.checkpoint);
    let (whole, _) = run(&world, Job { resume: false, ..job(folder.path(), 5) });
    assert_eq!(whole.unwrap().checkpoint.film, second.checkpoint.film);
}

#[test]
fn a_job_without_samples_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = job(folder.path(), 5).run(&world(), &AtomicBool::new(true), |_| {}).unwrap();
    assert_eq!((outcome.end, outcome.checkpoint.film.samples()), (End::Interrupted, 0));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// A picture that ends by its noise can be continued, unless any end completes it.
#[test]
fn checkpoints_of_unfinished_pictures_stay() {
    let world = world();
    let folder = tempfile::tempdir().unwrap();
    let noisy = |any_end_completes: bool| {
        let mut job = Job { any_end_completes, ..job(folder.path(), 1000) };
        job.options.noise = Some(1e9);
        run(&world, job).0.unwrap()
    };
    let unfinished = noisy(false);
    assert_eq!((unfinished.end, unfinished.kept), (End::Noise, Some(folder.path().join("fox.checkpoint"))));
    assert_eq!((noisy(true).end, folder.path().join("fox.checkpoint").exists()), (End::Noise, false));
}

#[test]
fn a_checkpoint_of_another_picture_is_refused() {
    let world = world();
    let folder = tempfile::tempdir().unwrap();
    interrupt(&world, job(folder.path(), 5));
    let mut other = job(folder.path(), 5);
    other.options.identity = Digest::of(b"other");
    let (result, events) = run(&world, other);
    assert!(matches!(result, Err(Error::OtherCheckpoint(_))) && events.is_empty());
}

/// The folder is a file. Samples are rescued to a folder of the user, and found there.
#[test]
fn samples_that_cannot_be_written_are_rescued() {
    let state = tempfile::tempdir().unwrap();
    if !is_alone_with("job::samples_that_cannot_be_written_are_rescued", STATE, state.path()) {
        return;
    }
    let world = world();
    let folder = tempfile::tempdir().unwrap();
    let gone = folder.path().join("gone");
    std::fs::write(&gone, "no folder").unwrap();
    let (result, events) = run(&world, job(&gone, 3));
    // Each of the checkpoints fails, and one is reported.
    assert_eq!(events, ["Started", "Pass", "CheckpointFailed", "Pass", "Rendered"]);
    let error = result.unwrap_err();
    let text = error.to_string();
    let Error::NotWritten { rescue: Rescue::Saved(path), samples: 3, complete: true, source } = error else {
        panic!("{error:?}")
    };
    assert_eq!(text, format!("the picture is not written; all 3 samples a pixel are kept in {}", path.display()));
    assert!(source.to_string().contains("cannot write") && path.exists());
    std::fs::remove_file(&gone).unwrap();
    let damaged = path.with_file_name(path.file_name().unwrap().to_string_lossy().replace("-3.film", "-9.film"));
    std::fs::write(&damaged, "damaged").unwrap();
    let (result, events) = run(&world, job(&gone, 3));
    std::fs::remove_file(damaged).unwrap();
    let expected = ["UnreadableRescue", "FoundRescue", "Resumed", "Started", "Rendered", "Wrote"];
    assert_eq!((result.unwrap().end, events), (End::Samples, expected.map(str::to_owned).to_vec()));
    assert!(!path.exists());
}

/// Returns a constant picture, or fails.
#[derive(Debug)]
struct Constant(bool);

impl Denoise for Constant {
    fn clean(&self, film: &Film, pictures: &[Vec<f32>]) -> Result<Vec<Vec<f32>>, Error> {
        let picture = vec![0.5; 3 * film.width() * film.height()];
        if self.0 { Ok(vec![picture; pictures.len()]) } else { Err(Error::Denoise("broken".to_owned())) }
    }
}

#[test]
fn a_denoiser_that_fails_costs_no_picture() {
    let world = world();
    let folder = tempfile::tempdir().unwrap();
    let png = |works: bool| {
        let (result, events) = run(&world, Job { denoiser: Some(Box::new(Constant(works))), ..job(folder.path(), 1) });
        assert_eq!(result.unwrap().files.len(), 2);
        assert_eq!(events.contains(&"DenoiserFailed".to_owned()), !works);
        std::fs::read(folder.path().join("fox.png")).unwrap()
    };
    assert_ne!(png(true), png(false));
}

/// Makes each picture brighter than the one before it.
#[derive(Debug)]
struct Unequal;

impl Denoise for Unequal {
    fn clean(&self, _: &Film, pictures: &[Vec<f32>]) -> Result<Vec<Vec<f32>>, Error> {
        let brighter = |(i, picture): (usize, &Vec<f32>)| picture.iter().map(|x| x * (1.0 + 0.2 * i as f32)).collect();
        Ok(pictures.iter().enumerate().map(brighter).collect())
    }
}

/// Denoised lights add up to the denoised beauty, and denoised lobes where the camera sees fibres, whatever the
/// denoiser does to each of them. Only layers that are asked for are denoised.
#[test]
fn denoised_parts_add_up() {
    let lamp = LightShape::Distant { direction: Vec3::Y, half_angle: 0.1, irradiance: [3.0, 2.0, 1.0] };
    let world = World::new(Scene { lights: vec![dome(), lamp.into()], ..fox() }).unwrap();
    let settings = settings();
    let layers = [Layer::Beauty, Layer::Lobes, Layer::Lights, Layer::Fibers];
    let mut film = Film::new(settings.size, settings.area(), world.layout(&layers));
    world.render(&settings, &mut film, 0..4, &()).unwrap();
    let denoised = Denoised::new(&Unequal, &film, &layers).unwrap();
    assert_eq!(denoised.beauty, film.rgb(Layer::Beauty).unwrap());
    let [covered, beauty] = [Layer::Fibers, Layer::Beauty].map(|layer| film.values(layer).unwrap());
    let names: Vec<Layer> = denoised.parts.iter().map(|(layer, _)| *layer).collect();
    assert_eq!(names, [Layer::Lobes, Layer::Lights]);
    let mut full = 0;
    for (layer, values) in &denoised.parts {
        let channels = values.len() / covered.len();
        assert_eq!(channels, if *layer == Layer::Lobes { 18 } else { 6 });
        for (i, pixel) in values.chunks_exact(channels).enumerate() {
            for c in 0..3 {
                let (sum, whole) = (pixel.iter().skip(c).step_by(3).sum::<f32>(), beauty[3 * i + c]);
                let all = *layer == Layer::Lights || covered[i] == 1.0;
                full += usize::from(all && whole > 0.0);
                assert!(sum <= whole + 1e-4 * whole.max(1.0), "{layer:?} {i}: {sum} of {whole}");
                assert!(!all || sum >= whole - 1e-4 * whole.max(1.0), "{layer:?} {i}: {sum} of {whole}");
            }
        }
    }
    assert!(full > covered.len());
    assert!(Denoised::new(&Unequal, &film, &[Layer::Beauty]).unwrap().parts.is_empty());
}

#[test]
fn a_job_needs_room_and_valid_options() {
    let world = world();
    let folder = tempfile::tempdir().unwrap();
    let (result, events) = run(&world, Job { pictures: u64::MAX, ..job(folder.path(), 1) });
    assert!(matches!(result, Err(Error::Write { .. })) && events.is_empty());
    let mut huge = job(folder.path(), 1);
    huge.options.settings.crop = Some([0, 0, usize::MAX, usize::MAX]);
    assert!(matches!(run(&world, huge).0, Err(Error::Settings(_))));
    // A damaged checkpoint.
    std::fs::write(folder.path().join("fox.checkpoint"), "damaged").unwrap();
    assert!(matches!(run(&world, job(folder.path(), 5)).0, Err(Error::Film { .. })));
}
