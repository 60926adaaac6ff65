//! Sessions: goals, cancellation, resumption, merging and files.

use crate::common::{settings, world};
use std::sync::atomic::{AtomicBool, Ordering};
use vellus_io::Digest;
use vellus_render::session::{
    End, Goals, IDENTITY_NOTE, Merge, Options, Picture, Rescue, Store, end_notes, is_finished, read_film, write_film,
};
use vellus_render::{Checkpoint, Error, Film, Layer, Session, Settings, World};

/// All samples at once.
fn expected(world: &World, samples: u64) -> Film {
    let mut film = Film::new([8, 8], [0, 0, 8, 8], world.layout(&[Layer::Beauty]));
    world.render(&settings(), &mut film, 0..samples, &()).unwrap();
    film
}

fn finish(world: &World, options: Options) -> Checkpoint {
    let mut session = Session::new(world, options).unwrap();
    assert_eq!(session.run(&(), |_| Ok::<(), Error>(())).unwrap(), End::Samples);
    session.into_checkpoint()
}

#[test]
fn a_cancelled_session_continues_to_the_same_film() {
    let world = world();
    let stop = AtomicBool::new(false);
    let mut session = Session::new(&world, Options::new(settings(), 9)).unwrap();
    let end = session.run(&stop, |pass| {
        stop.store(pass.state.samples >= 2, Ordering::Relaxed);
        Ok::<(), Error>(())
    });
    assert_eq!(end.unwrap(), End::Interrupted);
    let checkpoint = Checkpoint::from_bytes(&session.into_checkpoint().to_bytes()).unwrap();
    assert!((2..9).contains(&checkpoint.film.samples()) && checkpoint.planned == 9);
    let mut session = Session::new(&world, Options::new(settings(), 9)).unwrap();
    session.resume(checkpoint).unwrap();
    session.run(&(), |_| Ok::<(), Error>(())).unwrap();
    assert_eq!(*session.film(), expected(&world, 9));
    // A goal that is already reached renders nothing.
    let mut again = Session::new(&world, Options::new(settings(), 4)).unwrap();
    again.resume(session.into_checkpoint()).unwrap();
    assert_eq!(again.run(&(), |_| Ok::<(), Error>(())).unwrap(), End::Samples);
    assert_eq!((again.film().samples(), again.statistics().rays), (9, 0));
}

#[test]
fn an_error_of_the_callback_ends_the_session() {
    let world = world();
    let mut session = Session::new(&world, Options::new(settings(), 9)).unwrap();
    let end = session.run(&(), |_| Err(Error::Settings("full".to_owned())));
    assert_eq!((end.unwrap_err().to_string().as_str(), session.film().samples()), ("full", 1));
}

#[test]
fn checkpoints_of_other_pictures_are_refused() {
    let world = world();
    let kept = finish(&world, Options { samples: 2..5, ..Options::new(settings(), 1) });
    let refused = |options: Options, what: &str| {
        let mut session = Session::new(&world, options).unwrap();
        let error = session.resume(kept.clone()).unwrap_err();
        assert!(matches!(&error, Error::OtherCheckpoint(text) if text.contains(what)), "{error}");
        assert_eq!(session.film().samples(), 0);
    };
    let options = Options { samples: 2..5, ..Options::new(settings(), 1) };
    refused(Options { identity: Digest::of(b"other"), ..options.clone() }, "another picture");
    refused(Options { layers: vec![Layer::Depth], ..options.clone() }, "another picture");
    refused(Options { samples: 0..5, ..options.clone() }, "2..5");
    refused(Options { samples: 2..4, exact: true, ..options.clone() }, "2..5");
    let mut session = Session::new(&world, Options { samples: 2..4, ..options }).unwrap();
    session.resume(kept.clone()).unwrap();
    assert_eq!(*session.film(), kept.film);
}

#[test]
fn options_out_of_range_are_refused() {
    let world = world();
    let good = Options::new(settings(), 4);
    let crop = |crop| Options { settings: Settings { crop: Some(crop), ..settings() }, ..good.clone() };
    let bad = [
        (Options::new(Settings::new([0, 8]), 4), "size"),
        (Options::new(Settings::new([8, 1 << 20]), 4), "size"),
        (crop([4, 0, 5, 8]), "crop"),
        (crop([0, 0, 0, 8]), "crop"),
        (crop([usize::MAX, 0, 2, 8]), "crop"),
        (Options::new(settings(), 0), "samples"),
        (Options::new(settings(), u64::MAX), "samples"),
        (Options { noise: Some(0.0), ..good.clone() }, "noise"),
        (Options { noise: Some(f64::NAN), ..good.clone() }, "noise"),
    ];
    for (options, what) in bad {
        let error = Session::new(&world, options).map(drop).unwrap_err();
        assert!(matches!(&error, Error::Settings(text) if text.contains(what)), "{error}");
    }
}

#[test]
fn merged_ranges_are_the_whole_film() {
    let world = world();
    let part = |samples| finish(&world, Options { samples, ..Options::new(settings(), 1) });
    let mut merge = Merge::new();
    for (name, samples) in [("b", 4..7), ("a", 0..4)] {
        merge.add(name, part(samples)).unwrap();
    }
    let merged = merge.finish().unwrap();
    assert_eq!((merged.film, merged.gaps), (expected(&world, 7), Vec::new()));
    let mut merge = Merge::new();
    merge.add("a", part(1..3)).unwrap();
    merge.add("b", part(4..5)).unwrap();
    assert_eq!(merge.finish().unwrap().gaps, ["0..1 before a", "3..4 before b"]);
    let mut merge = Merge::new();
    merge.add("a", part(0..3)).unwrap();
    merge.add("b", part(2..5)).unwrap();
    assert_eq!(merge.finish().unwrap_err().to_string(), "a and b have samples in common");
    let mut merge = Merge::new();
    merge.add("a", part(0..3)).unwrap();
    let other = Options { identity: Digest::of(b"other"), ..Options::new(settings(), 1) };
    let error = merge.add("c", finish(&world, other)).unwrap_err();
    assert_eq!(error.to_string(), "a and c are not of the same picture");
    assert!(Merge::new().finish().is_err());
}

#[test]
fn pictures_and_checkpoints_are_kept_in_files() {
    let world = world();
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("fox.exr");
    let identity = Digest::of(output.to_string_lossy().as_bytes());
    let notes = vec![(IDENTITY_NOTE.to_owned(), identity.to_string())];
    let film = finish(&world, Options { identity, notes: notes.clone(), ..Options::new(settings(), 3) });
    let mut store = Store::beside(&output);
    assert!(store.find(identity, &(0..9)).unwrap().checkpoint.is_none());
    store.save(&film).unwrap();
    assert_eq!(store.find(identity, &(0..9)).unwrap().checkpoint, Some(film.clone()));
    assert!(store.check_space(u64::MAX, 0, &output).is_err() && store.check_space(1000, 1000, &output).is_ok());
    std::fs::write(store.path(), "damaged").unwrap();
    assert!(matches!(store.find(identity, &(0..9)), Err(Error::Film { .. })));
    assert_eq!(store.rescue(&film), Rescue::Saved(store.path().to_owned()));
    assert_eq!(read_film(store.path()).unwrap(), film);
    store.remove();
    assert!(!store.path().exists());
    // The folder is gone: the film is saved elsewhere, found there, and removed with the picture.
    let mut lost = Store::beside(&folder.path().join("gone/fox.exr"));
    std::fs::write(folder.path().join("gone"), "no folder").unwrap();
    assert!(write_film(lost.path(), &film).is_err());
    let Rescue::Saved(path) = lost.rescue(&film) else { panic!("nothing was saved") };
    let found = lost.find(identity, &(0..9)).unwrap();
    assert_eq!((found.checkpoint, found.rescued), (Some(film.clone()), Some(path.clone())));
    lost.remove();
    assert!(!path.exists());

    let picture = Picture { notes: [notes, end_notes(&film.film, End::Time)].concat(), ..Picture::new(&output) };
    let written = picture.write(&film.film, None).unwrap();
    assert_eq!(written, [output.clone(), output.with_extension("png")]);
    let bytes: u64 = written.iter().map(|path| std::fs::metadata(path).unwrap().len()).sum();
    // Besides the pixels, headers take about a thousand bytes each.
    assert!(bytes <= picture.max_bytes(64, film.film.layout()) + 4000);
    let goals = |samples, time| Goals { samples, noise: None, time };
    let day = Some(std::time::Duration::from_secs(86400));
    assert!(is_finished(&output, identity, &goals(3, None)) && is_finished(&output, identity, &goals(9, day)));
    assert!(
        !is_finished(&output, identity, &goals(9, None)) && !is_finished(&output, Digest::of(b""), &goals(3, None))
    );
}
