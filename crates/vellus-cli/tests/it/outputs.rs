//! The files that `vellus render` writes, the goals that end it, and the files that it keeps after a failure.

use crate::common::{LIMIT, Limited, Picture, command, ended_by, refused, refused_by, run, shell, vellus, wait_until};
use std::collections::BTreeSet;
use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};
use vellus_testing::need;
#[cfg(unix)]
use vellus_testing::program::Signal;

/// A lock of hair, and more options.
fn lock<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["render", "hair-lock", "--small", "--size", "48x32"], more].concat()
}

/// A picture has only the requested layers. With `all`, there is one for each light, and these sum to the beauty.
#[test]
fn pictures_have_the_requested_layers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, &lock(&["--spp", "2", "--layers", "id,beauty", "-o", "few.exr"]));
    let few = Picture::read(&path.join("few.exr"));
    assert_eq!(few.names(), ["B", "G", "R", "strand.id"]);
    let ids = &few.channels[3].1;
    assert!(ids.iter().any(|&id| id > 1.0) && ids.iter().all(|id| id.fract() == 0.0));
    run(path, &lock(&["--spp", "2", "--layers", "all", "--float", "-o", "all.exr"]));
    let all = Picture::read(&path.join("all.exr"));
    let lights: Vec<_> = all.channels.iter().filter(|(n, _)| n.starts_with("light_") && n.ends_with(".G")).collect();
    assert!(lights.len() > 1, "{:?}", all.names());
    let beauty = &all.channels.iter().find(|(n, _)| n == "G").unwrap().1;
    for (i, b) in beauty.iter().enumerate() {
        let sum: f32 = lights.iter().map(|(_, values)| values[i]).sum();
        assert!((sum - b).abs() < 1e-5 * b.max(1.0), "pixel {i}: {sum} {b}");
    }
    // Other notes of a picture.
    for (note, part) in [
        ("vellus_version", env!("CARGO_PKG_VERSION")),
        ("vellus_command", "vellus render hair-lock --small"),
        ("vellus_samples", "2"),
        ("vellus_ended_by", "samples"),
        ("vellus_scene", "hair-lock"),
        ("vellus_mode", "multiscale"),
        ("vellus_fiber_hair", "\"eta\":1.2,"),
    ] {
        assert!(all.note(note).contains(part), "{note}: {}", all.note(note));
    }
    // A picture of a film has the layers that the film was made for.
    run(path, &lock(&["--samples", "0..2", "--layers", "beauty,id", "-o", "few.exr"]));
    run(path, &["merge", "few.film", "-o", "merged.exr"]);
    let merged = Picture::read(&path.join("merged.exr"));
    assert_eq!(merged.names(), ["B", "G", "R", "strand.id"]);
    assert!(merged.note("vellus_command").contains("--samples 0..2"));
    run(path, &lock(&["--samples", "2..4", "--layers", "beauty", "-o", "other.exr"]));
    refused(path, &["merge", "few.film", "other.film"], &["not of the same picture"]);
}

/// Two strands that lean further each frame.
const LEANING: &str = "#usda 1.0
( startTimeCode = 1 endTimeCode = 4 )
def BasisCurves \"fur\" {
    uniform token type = \"linear\"
    int[] curveVertexCounts = [2, 2]
    float[] widths = [0.2] ( interpolation = \"constant\" )
    point3f[] points.timeSamples = {
        1: [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0)],
        4: [(0, 0, 0), (1, 1, 0), (1, 0, 0), (2, 1, 0)],
    }
}
def Camera \"camera\" {
    double3 xformOp:translate = (1, 0.5, 6) uniform token[] xformOpOrder = [\"xformOp:translate\"]
}
";

/// `--shutter` replaces the shutter of the camera, which has none here.
#[test]
fn a_shutter_gives_motion_blur() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("lean.usda"), LEANING).unwrap();
    let render = |more: &[&str]| {
        let args =
            ["render", "lean.usda", "--size", "24x16", "--spp", "2", "--frame", "2", "--layers", "beauty,motion"];
        run(path, &[&args, more, &["-o", "lean.exr"]].concat());
        Picture::read(&path.join("lean.exr"))
    };
    let (still, blurred) = (render(&[]), render(&["--shutter", "-0.5:0.5"]));
    assert!(!still.same(&blurred) && still.same(&render(&["--shutter=off"])));
    let moves = |picture: &Picture| {
        let motion = picture.channels.iter().find(|(name, _)| name == "motion.X").unwrap();
        motion.1.iter().any(|x| *x > 0.0)
    };
    assert_eq!((moves(&still), moves(&blurred)), (false, true));
    refused(path, &["render", "cat", "--shutter", "off"], &["--shutter", "cat"]);
    refused(path, &["render", "lean.usda", "--shutter", "1:0"], &["--shutter", "OPEN at most CLOSE"]);
}

#[test]
fn frames_are_rendered_and_finished_frames_are_skipped() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("lean.usda"), LEANING).unwrap();
    let render = |more: &[&str]| run(path, &[&["render", "lean.usda", "--size", "24x16"], more].concat());
    let frame = |n: u32| Picture::read(&path.join(format!("lean.000{n}.exr")));
    render(&["--spp", "2", "--frames", "1-4", "-o", "lean.exr"]);
    assert!(!frame(1).same(&frame(2)) && !frame(2).same(&frame(3)) && !frame(3).same(&frame(4)));
    assert_eq!(frame(3).note("imageCounter"), "I32(3)");
    render(&["--spp", "2", "--frame", "3", "-o", "third.exr"]);
    assert!(frame(3).same(&Picture::read(&path.join("third.exr"))));
    // One frame is missing and one has another seed: both are rendered.
    let first = std::fs::metadata(path.join("lean.0001.exr")).unwrap().modified().unwrap();
    std::fs::remove_file(path.join("lean.0002.png")).unwrap();
    render(&["--spp", "2", "--frames", "3-3", "--seed", "9", "-o", "lean.exr"]);
    let said = render(&["--spp", "2", "--frames", "1-4", "--resume", "-o", "lean.exr"]);
    for (n, there) in [(1, true), (2, false), (3, false), (4, true)] {
        assert_eq!(said.contains(&format!("frame {n}: lean.000{n}.exr is finished")), there, "{said}");
    }
    assert_eq!(std::fs::metadata(path.join("lean.0001.exr")).unwrap().modified().unwrap(), first);
    assert!(frame(3).same(&Picture::read(&path.join("third.exr"))));
    // A damaged finished frame is rendered again, and so is a damaged PNG.
    for (n, extension) in [(1, "exr"), (4, "png")] {
        let file = path.join(format!("lean.000{n}.{extension}"));
        let mut bytes = std::fs::read(&file).unwrap();
        let middle = bytes.len() - 60;
        bytes[middle] ^= 1;
        std::fs::write(&file, bytes).unwrap();
    }
    let said = render(&["--spp", "2", "--frames", "1-4", "--resume", "-o", "lean.exr"]);
    for (n, there) in [(1, false), (2, true), (3, true), (4, false)] {
        assert_eq!(said.contains(&format!("frame {n}: lean.000{n}.exr is finished")), there, "{said}");
    }
    // A placeholder in the name becomes the number, also without --frames.
    render(&["--spp", "2", "--frames", "1-4x3", "-o", "at_%03d.exr"]);
    render(&["--spp", "2", "--frame", "1", "-o", "first.##.png"]);
    assert!(path.join("at_001.png").exists() && path.join("at_004.exr").exists() && path.join("first.01.png").exists());
    for more in [&["--frame", "1.5"][..], &[]] {
        let args = [&["render", "lean.usda", "-o", "first.####.png"], more].concat();
        refused(path, &args, &["first.####.png", "needs --frames"]);
    }
    // More samples than the finished frames have.
    let said = render(&["--frames", "1-4x3", "--spp", "4", "--resume", "-o", "lean.exr"]);
    assert!(!said.contains("is finished") && said.contains("frame 4 (2 of 2)"), "{said}");
    refused(path, &lock(&["--frames", "1-2"]), &["--frames are for files"]);
    refused(path, &["render", "lean.usda", "--frames", "4-1"], &["A-B", "1-48"]);
}

/// Only the camera moves. The cache of a frame has records of the frames before, whether this process rendered them or
/// not.
#[test]
fn frames_share_a_radiance_cache() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let (groom, _) = LEANING.split_once("def Camera").unwrap();
    let still = groom.replace(".timeSamples = {", "= [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0)]");
    let (still, _) = still.split_once("\n        1:").unwrap();
    let shot = "}
def Camera \"camera\" {
    double3 xformOp:translate.timeSamples = { 1: (1, 0.5, 6), 9: (1.4, 0.5, 6) }
    uniform token[] xformOpOrder = [\"xformOp:translate\"]
}";
    std::fs::write(path.join("shot.usda"), format!("{still}{shot}")).unwrap();
    std::fs::write(path.join("lean.usda"), LEANING).unwrap();
    let render = |more: &[&str]| {
        let options = ["--size", "24x16", "--spp", "4", "--float", "--radiance-cache", "4"];
        run(path, &[&["render"], more, &options[..]].concat())
    };
    let picture = |name: &str| Picture::read(&path.join(name));
    render(&["shot.usda", "--frames", "1-5", "-o", "shot.exr"]);
    render(&["shot.usda", "--frame", "5", "-o", "fifth.exr"]);
    render(&["shot.usda", "--frames", "3-5x2", "-o", "some.exr"]);
    for other in ["fifth.exr", "some.0005.exr"] {
        assert!(picture("shot.0005.exr").same(&picture(other)), "{other}");
    }
    // The camera is that of frame 5, but there are no frames before.
    let (_, rest) = shot.split_once('}').unwrap();
    let alone = rest.replace(".timeSamples = { 1: (1, 0.5, 6), 9: (1.4, 0.5, 6) }", " = (1.2, 0.5, 6)");
    std::fs::write(path.join("alone.usda"), format!("{still}}}{alone}")).unwrap();
    render(&["alone.usda", "-o", "alone.exr"]);
    assert!(!picture("shot.0005.exr").same(&picture("alone.exr")));
    // Strands that move have no cache in common.
    render(&["lean.usda", "--frames", "1-3", "-o", "lean.exr"]);
    render(&["lean.usda", "--frame", "3", "-o", "third.exr"]);
    assert!(picture("lean.0003.exr").same(&picture("third.exr")));
}

/// The frames of an animation without lights have the exposure of the first frame, however they are rendered.
#[test]
fn frames_without_lights_have_one_exposure() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let (groom, _) = LEANING.split_once("def Camera").unwrap();
    std::fs::write(path.join("lean.usda"), groom).unwrap();
    let render = |more: &[&str]| run(path, &[&["render", "lean.usda", "--size", "24x16", "--spp", "2"], more].concat());
    let frame = |name: &str| Picture::read(&path.join(name));
    let said = render(&["--frames", "1-4x3", "-o", "lean.exr"]);
    // What is the same for all frames is said once.
    assert_eq!(said.matches("the file has no camera").count(), 1, "{said}");
    render(&["--frame", "4", "-o", "fourth.exr"]);
    render(&["-o", "first.exr"]);
    assert!(frame("lean.0004.exr").same(&frame("fourth.exr")) && frame("lean.0001.exr").same(&frame("first.exr")));
    assert!(!frame("first.exr").same(&frame("fourth.exr")));
}

/// Noise ends just below its goal. A time limit ends a run without other goals.
#[test]
fn goals_end_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, &lock(&["--spp", "100000", "--noise", "0.05", "-o", "noise.exr"]));
    let noise: f64 = Picture::read(&path.join("noise.exr")).note("vellus_noise").parse().unwrap();
    // The number of samples is estimated from the noise so far.
    assert!((0.04..=0.05).contains(&noise), "{noise}");
    let start = Instant::now();
    run(path, &lock(&["--spp", "1000000000", "--time", "1s", "-o", "time.exr"]));
    let time = Picture::read(&path.join("time.exr"));
    let seconds: f64 = time.note("vellus_seconds").parse().unwrap();
    assert!(time.note("vellus_ended_by") == "time" && start.elapsed() >= Duration::from_millis(900));
    // The upper bound is large, because the machine may be busy.
    assert!((0.9..5.0).contains(&seconds), "{seconds}");
    // Who does not ask for a checkpoint gets pictures only.
    let names = std::fs::read_dir(path).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap());
    let files: BTreeSet<String> = names.filter(|name| name != "state").collect();
    assert_eq!(files, ["noise.exr", "noise.png", "time.exr", "time.png"].map(str::to_owned).into());
}

/// Reads a packet: its kind and its content.
fn packet(stream: &mut impl Read) -> Option<(u8, Vec<u8>)> {
    let mut length = [0; 4];
    stream.read_exact(&mut length).ok()?;
    let mut rest = vec![0; u32::from_le_bytes(length) as usize - 4];
    stream.read_exact(&mut rest).unwrap();
    Some((rest[0], rest[1..].to_vec()))
}

fn take<'a>(bytes: &mut &'a [u8], count: usize) -> &'a [u8] {
    let (taken, rest) = bytes.split_at(count);
    *bytes = rest;
    taken
}

fn number(bytes: &mut &[u8]) -> usize {
    i32::from_le_bytes(take(bytes, 4).try_into().unwrap()) as usize
}

fn text(bytes: &mut &[u8]) -> String {
    let end = bytes.iter().position(|&b| b == 0).unwrap();
    String::from_utf8(take(bytes, end + 1)[..end].to_vec()).unwrap()
}

/// The first connection. Every wait for it has a limit.
fn accept(listener: &TcpListener) -> TcpStream {
    let mut found = None;
    listener.set_nonblocking(true).unwrap();
    wait_until("a connection", || {
        found = listener.accept().ok();
        found.is_some()
    });
    let (stream, _) = found.unwrap();
    stream.set_nonblocking(false).unwrap();
    stream.set_read_timeout(Some(LIMIT)).unwrap();
    stream
}

/// A viewer that parses packets like tev gets the picture that is written. A missing viewer is an error. A viewer that
/// closes is not.
#[test]
fn a_viewer_sees_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_owned();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let viewer = std::thread::spawn(move || {
        let mut stream = accept(&listener);
        let (mut image, mut size, mut updates) = (Vec::new(), [0, 0], 0);
        while let Some((kind, bytes)) = packet(&mut stream) {
            let mut rest = &bytes[1..];
            assert_eq!(text(&mut rest), "seen.exr");
            if kind == 4 {
                assert_eq!(bytes[0], 1);
                size = [number(&mut rest), number(&mut rest)];
                let channels: Vec<String> = (0..number(&mut rest)).map(|_| text(&mut rest)).collect();
                assert_eq!((channels.join(""), rest.len()), ("RGBA".to_owned(), 0));
                image = vec![0.0; size[0] * size[1] * 4];
                continue;
            }
            assert_eq!((kind, bytes[0]), (6, 0));
            updates += 1;
            let channels = number(&mut rest);
            assert_eq!((0..channels).map(|_| text(&mut rest)).collect::<String>(), "RGBA");
            let [x, y, width, height] = std::array::from_fn(|_| number(&mut rest));
            let mut longs = |_| i64::from_le_bytes(take(&mut rest, 8).try_into().unwrap()) as usize;
            let offsets: Vec<usize> = (0..channels).map(&mut longs).collect();
            let strides: Vec<usize> = (0..channels).map(&mut longs).collect();
            let data: Vec<f32> = rest.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
            assert_eq!(data.len(), width * height * channels);
            for (i, c) in (0..width * height).flat_map(|i| (0..channels).map(move |c| (i, c))) {
                let at = (y + i / width) * size[0] + x + i % width;
                image[4 * at + c] = data[offsets[c] + i * strides[c]];
            }
        }
        (image, size, updates)
    });
    run(&path, &lock(&["--spp", "5", "--tev", &address, "--crop", "8,4,30,20", "--float", "-o", "seen.exr"]));
    let (image, size, updates) = viewer.join().unwrap();
    assert!(size == [48, 32] && updates >= 2, "{size:?} {updates}");
    let written = Picture::read(&path.join("seen.exr"));
    for (c, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
        let channel = &written.channels.iter().find(|(n, _)| n == name).unwrap().1;
        for i in 0..48 * 32 {
            let (x, y) = (i % 48, i / 48);
            let inside = (8..38).contains(&x) && (4..24).contains(&y);
            let expected = if inside { channel[(y - 4) * 30 + x - 8] } else { 0.0 };
            assert_eq!(image[4 * i + c], expected, "{name} of {x}, {y}");
        }
    }
    // The viewer no longer listens.
    refused(&path, &lock(&["--tev", &address, "-o", "none.exr"]), &["--tev", &address, "start tev first"]);
    assert!(!path.join("none.exr").exists());
    // A picture larger than a socket's buffer, and a viewer that closes at once.
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let closing = std::thread::spawn(move || drop(accept(&listener)));
    let args =
        ["render", "hair-lock", "--small", "--size", "320x200", "--spp", "4", "--tev", &address, "-o", "left.exr"];
    let said = run(&path, &args);
    closing.join().unwrap();
    assert_eq!(said.matches("rendering goes on without it").count(), 1, "{said}");
    assert!(path.join("left.exr").exists());
}

/// A run that was killed and resumed gives the same bits as one run.
#[test]
fn a_killed_run_only_loses_samples_after_its_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    // One thread takes about a second, so it is killed before its end.
    let args = |name| {
        let often = ["--threads", "1", "--checkpoint", "0.05s"];
        lock(&[&["--spp", "600", "--layers", "all", "--float", "-o", name][..], &often].concat())
    };
    let checkpoint = path.join("killed.checkpoint");
    let written = || std::fs::metadata(&checkpoint).and_then(|m| m.modified()).ok();
    for _ in 0..2 {
        let before = written();
        let child = command(path, &[&args("killed.exr")[..], &["--resume"]].concat()).start().unwrap();
        wait_until("a checkpoint", || written() != before);
        child.kill();
        assert!(checkpoint.exists() && !path.join("killed.exr").exists(), "killed too late: make it longer");
    }
    let said = run(path, &[&args("killed.exr")[..], &["--resume"]].concat());
    assert!(said.contains("continuing from"), "{said}");
    run(path, &args("whole.exr"));
    let (killed, whole) = (Picture::read(&path.join("killed.exr")), Picture::read(&path.join("whole.exr")));
    assert!(killed.same(&whole) && killed.note("vellus_samples") == "600");
    // Kills leave temporary files. A finished run removes its checkpoint.
    assert!(!checkpoint.exists());
    // A sample range is resumed too, with a radiance cache that grows at the sample 256.
    let part = |name: &'static str, more: &[&'static str]| {
        let cache = ["--radiance-cache", "4"];
        let args = ["--samples", "7..407", "--threads", "1", "--checkpoint", "0.05s", "-o", name];
        let args = lock(&[&args[..], &cache].concat());
        [&args[..], more].concat()
    };
    let child = command(path, &part("part.exr", &[])).start().unwrap();
    wait_until("a checkpoint", || path.join("part.checkpoint").exists());
    child.kill();
    refused(
        path,
        &lock(&["--spp", "9", "--radiance-cache", "4", "--resume", "-o", "part.exr"]),
        &["part.checkpoint has the samples 7..", "delete it"],
    );
    assert!(run(path, &part("part.exr", &["--resume"])).contains("continuing from"));
    run(path, &part("once.exr", &[]));
    assert!(Picture::read(&path.join("part.exr")).same(&Picture::read(&path.join("once.exr"))));
}

/// With a limit on file sizes, as on a full disk, the last checkpoint stays, and there is one message.
#[cfg(unix)]
#[test]
fn a_full_disk_only_loses_samples_after_the_last_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let checkpoint = path.join("full.checkpoint");
    let args = |spp: &'static str, more: &[&'static str]| {
        [&lock(&["--checkpoint", "0s", "-o", "full.exr"])[..], &["--spp", spp], more].concat()
    };
    // A checkpoint with some samples.
    run(path, &args("100", &["--noise", "1e9"]));
    let before = std::fs::read(&checkpoint).unwrap();
    std::fs::remove_file(path.join("full.exr")).unwrap();
    // The limit is 16 or 32 KB, depending on the shell. This is enough for the probe, but not for a film of 650 KB.
    let limited = args("100", &["--resume"]);
    let output = shell(path, "ulimit -f 32; exec \"$@\"", &limited).run().unwrap();
    ended_by(
        &output,
        75,
        &limited,
        &["the picture is not written", "full.checkpoint", "--resume", "cannot write full.exr"],
    );
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(message.matches("no checkpoint could be written, the last one stays").count(), 1, "{message}");
    assert_eq!(std::fs::read(&checkpoint).unwrap(), before);
    assert!(!path.join("full.exr").exists());
    assert!(run(path, &args("100", &["--resume"])).contains("continuing from"));
}

/// If the folder is removed before the end, all samples are saved in another place. The command in the message makes
/// the picture from them.
#[test]
fn samples_that_cannot_be_written_are_saved_in_another_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let args = lock(&["--spp", "300", "--threads", "1", "--checkpoint", "0s", "-o", "gone/a.exr"]);
    let child = command(path, &args).start().unwrap();
    wait_until("a checkpoint", || path.join("gone/a.checkpoint").exists());
    std::fs::rename(path.join("gone"), path.join("old")).unwrap();
    std::fs::write(path.join("gone"), "a file").unwrap();
    let output = child.end();
    refused_by(&output, &args, &["all 300 samples", "state/vellus/films", "vellus merge", "cannot write gone/a.exr"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    let kept = message.split("vellus merge ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().to_owned();
    run(path, &["merge", &kept, "-o", "a.exr"]);
    run(path, &lock(&["--spp", "300", "-o", "b.exr"]));
    let b = Picture::read(&path.join("b.exr"));
    assert!(Picture::read(&path.join("a.exr")).same(&b));
    // With --resume nothing is rendered again, although the checkpoint has fewer samples. The saved film is then no
    // longer needed.
    std::fs::remove_file(path.join("gone")).unwrap();
    std::fs::rename(path.join("old"), path.join("gone")).unwrap();
    let message = run(path, &[&args[..], &["--resume"]].concat());
    assert!(message.contains("continuing from 300 samples"), "{message}");
    assert!(Picture::read(&path.join("gone/a.exr")).same(&b));
    assert_eq!(std::fs::read_dir(path.join("state/vellus/films")).unwrap().count(), 0);
}

/// SIGINT, SIGTERM and SIGHUP have their own exit codes. The picture and the checkpoint are kept and named.
#[cfg(unix)]
#[test]
fn an_interrupted_run_reports_what_it_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (signal, name, code) in [(Signal::INT, "INT", 130), (Signal::TERM, "TERM", 143), (Signal::HUP, "HUP", 129)] {
        let (name, named) = (format!("{name}.exr"), format!("{name}.checkpoint"));
        let args = lock(&["--spp", "1000000", "--threads", "1", "--checkpoint", "0.05s", "-o", &name]);
        let child = command(path, &args).start().unwrap();
        let checkpoint = path.join(&named);
        wait_until("a checkpoint", || checkpoint.exists());
        child.send(signal);
        ended_by(&child.end(), code, &args, &["interrupted:", "samples a pixel are in", &name, &named, "--resume"]);
        assert!(path.join(&name).exists() && checkpoint.exists());
        // The checkpoint is valid, but has fewer samples than requested.
        refused(path, &["merge", &named], &["samples are missing", &named, "--allow-gaps"]);
        assert!(run(path, &["merge", "--allow-gaps", &named]).contains("samples are missing"));
    }
}

#[test]
fn a_picture_too_large_for_the_disk_is_not_started() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), &["render", "hair-lock", "--size", "16x16", "--spp", "1", "--small", "-o", "small.png"]);
    let args = ["render", "hair-lock", "--small", "--size", "32768x32768", "-o", "huge.exr"];
    let free = fs4::available_space(folder.path()).unwrap();
    let small = if free < 600_000_000_000 { Ok(()) } else { Err("a picture of a billion pixels has room here") };
    if need("disk", small).is_some() {
        ended_by(&vellus(folder.path(), &args), 75, &args, &["cannot write huge.exr", "MB are free"]);
    }
}
