//! Sessions: goals, cancellation, resumption, merging and files.

use crate::common::{STATE, settings, world};
use std::sync::atomic::{AtomicBool, Ordering};
use vellus_io::Digest;
use vellus_render::session::{
    End, Goals, IDENTITY_NOTE, Job, Merge, Options, Picture, Rescue, Store, end_notes, is_finished, read_film,
    write_film,
};
use vellus_render::{Checkpoint, Error, Film, Layer, Session, Settings, World};
use vellus_testing::program::is_alone_with;

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

/// The folder of a picture is gone: its film is saved in a folder of the user, found there, and removed with the
/// picture. What others could have put there is left out.
#[test]
fn films_are_rescued_to_a_private_folder() {
    let state = tempfile::tempdir().unwrap();
    if !is_alone_with("session::films_are_rescued_to_a_private_folder", STATE, state.path()) {
        return;
    }
    let world = world();
    let folder = tempfile::tempdir().unwrap();
    let identity = Digest::of(b"rescued");
    let film = finish(&world, Options { identity, ..Options::new(settings(), 3) });
    let mut lost = Store::beside(&folder.path().join("gone/fox.exr"));
    std::fs::write(folder.path().join("gone"), "no folder").unwrap();
    assert!(write_film(lost.path(), &film).is_err());
    assert!(lost.find(identity, &(0..9)).unwrap().unreadable.is_empty());
    let Rescue::Saved(path) = lost.rescue(&film) else { panic!("nothing was saved") };
    let found = lost.find(identity, &(0..9)).unwrap();
    assert_eq!((found.checkpoint, found.rescued), (Some(film.clone()), Some(path.clone())));
    lost.remove();
    assert!(!path.exists());

    #[cfg(unix)]
    {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let private = path.parent().unwrap();
        let mode = |bits| std::fs::set_permissions(private, std::fs::Permissions::from_mode(bits)).unwrap();
        assert_eq!(private.metadata().unwrap().permissions().mode() & 0o777, 0o700);
        let empty = |lost: &mut Store| {
            let found = lost.find(identity, &(0..9)).unwrap();
            assert_eq!((found.checkpoint, found.rescued), (None, None));
            found.unreadable.len()
        };
        // A link to a good film, and a pipe.
        let forged = folder.path().join("forged.film");
        write_film(&forged, &film).unwrap();
        symlink(&forged, &path).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(path.with_extension("9.film")).status().unwrap().success());
        assert_eq!(empty(&mut lost), 0);
        // It is not written through either.
        let Rescue::Lost(why) = lost.rescue(&film) else { panic!("it followed a link") };
        assert!(why.contains("symbolic link"), "{why}");
        std::fs::remove_file(&path).unwrap();
        // A folder that others can write to.
        std::fs::rename(&forged, &path).unwrap();
        mode(0o777);
        assert_eq!(empty(&mut lost), 1);
        let Rescue::Lost(why) = lost.rescue(&film) else { panic!("others can write there") };
        assert!(why.contains("other users can write"), "{why}");
        mode(0o700);
        assert_eq!(lost.find(identity, &(0..9)).unwrap().rescued, Some(path));
    }
}

/// A film keeps layers that its picture does not have.
#[test]
fn merged_pictures_have_the_layers_that_were_asked_for() {
    let world = world();
    let folder = tempfile::tempdir().unwrap();
    let lists: [&[Layer]; 3] = [&[Layer::Depth, Layer::RootUv], &[Layer::Beauty], &Layer::ALL];
    for (i, layers) in lists.into_iter().enumerate() {
        let path = |name: &str| folder.path().join(format!("{name}{i}.exr"));
        let run = |name: &str, samples: std::ops::Range<u64>| {
            let options = Options { samples, layers: layers.to_vec(), ..Options::new(settings(), 4) };
            let picture = Picture { layers: layers.to_vec(), ..Picture::new(path(name)) };
            Job { film: true, ..Job::new(options, picture) }.run(&world, &(), |_| {}).unwrap();
        };
        run("whole", 0..4);
        run("a", 0..1);
        run("b", 1..4);
        let mut merge = Merge::new();
        for name in ["b", "a"] {
            merge.add(name, read_film(&path(name).with_extension("film")).unwrap()).unwrap();
        }
        let merged = merge.finish().unwrap();
        assert_eq!(merged.layers, layers);
        assert!(merged.notes.iter().all(|(name, _)| name != "vellus_layers"));
        let whole = read_film(&path("whole").with_extension("film")).unwrap();
        assert!(merged.film == whole.film, "{layers:?}");
    }
    // Films without the note are of an older version.
    let mut merge = Merge::new();
    merge.add("old", finish(&world, Options::new(settings(), 1))).unwrap();
    assert_eq!(merge.finish().unwrap().layers, Layer::ALL);
}

#[test]
fn a_film_without_memory_is_refused() {
    let world = world();
    let huge = Options { layers: Layer::ALL.to_vec(), ..Options::new(Settings::new([32768; 2]), 1) };
    // On a machine with half a terabyte, it has room.
    if let Err(error) = Session::new(&world, huge) {
        assert!(matches!(error, Error::Memory { size: [32768, 32768], .. }), "{error}");
        assert!(error.to_string().contains("GB of memory"), "{error}");
    }
    let wide = Session::new(&world, Options::new(Settings::new([32769, 1]), 1)).unwrap_err();
    assert!(wide.to_string().contains("[1, 32768]"), "{wide}");
}
