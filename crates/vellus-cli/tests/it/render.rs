//! `vellus render` and `vellus merge`, on the processor and on a GPU.

use crate::common::{Limited, Picture, command, refused, refused_by, run, vellus};
use std::path::Path;
use std::process::Command;
use vellus_testing::need;

/// A small cat, and more options.
fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["render", "cat", "--small", "--size", "48x32"], more].concat()
}

/// Sample ranges that are rendered separately, with any number of threads, and resumed runs give the pixels of one run.
#[test]
fn parts_and_resumed_runs_are_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| Picture::read(&folder.path().join(name));
    run(folder.path(), &with(&["--spp", "6", "-o", "whole.exr"]));
    run(folder.path(), &with(&["--samples", "0..2", "--threads", "1", "-o", "a.exr"]));
    run(folder.path(), &with(&["--samples", "2..6", "--threads", "2", "-o", "b.exr"]));
    run(folder.path(), &["merge", "b.film", "a.film", "-o", "merged.exr"]);
    let merged = at("merged.exr");
    assert!(at("whole.exr").same(&merged) && merged.note("vellus_samples") == "6", "{:?}", merged.names());
    // The goal is reached after the first pass. This leaves a checkpoint only with --checkpoint.
    run(folder.path(), &with(&["--spp", "6", "--noise", "1e9", "-o", "two.exr"]));
    assert!(!["whole", "two"].iter().any(|name| folder.path().join(name).with_extension("checkpoint").exists()));
    let stopped =
        run(folder.path(), &with(&["--spp", "20", "--noise", "1e9", "--checkpoint", "60s", "-o", "noisy.exr"]));
    assert!(stopped.contains("samples a pixel"), "{stopped}");
    assert!(folder.path().join("noisy.checkpoint").exists());
    let resumed = run(folder.path(), &with(&["--spp", "20", "--resume", "-o", "noisy.exr"]));
    assert!(resumed.contains("continuing from"), "{resumed}");
    assert!(!folder.path().join("noisy.checkpoint").exists());
    run(folder.path(), &with(&["--spp", "20", "-o", "direct.exr"]));
    assert!(at("noisy.exr").same(&at("direct.exr")));
    refused(folder.path(), &["merge", "a.film", "a.film"], &["have samples in common"]);
}

/// Gaps, overlaps and damaged films are refused by name. Gaps can be allowed.
#[test]
fn merge_rejects_films_that_do_not_fit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (range, name) in [("0..2", "a.exr"), ("2..4", "b.exr"), ("3..6", "c.exr"), ("5..6", "d.exr")] {
        run(path, &with(&["--samples", range, "-o", name]));
    }
    refused(path, &["merge", "d.film", "a.film"], &["samples are missing: 2..5 before d.film", "--allow-gaps"]);
    refused(path, &["merge", "b.film"], &["samples are missing: 0..2 before b.film"]);
    refused(path, &["merge", "c.film", "b.film", "a.film"], &["b.film and c.film have samples in common"]);
    assert!(!path.join("out/render.exr").exists());
    let warning = run(path, &["merge", "--allow-gaps", "d.film", "a.film", "-o", "gap.exr"]);
    assert!(warning.contains("warning: samples are missing: 2..5"), "{warning}");
    assert_eq!(Picture::read(&path.join("gap.exr")).note("vellus_samples"), "3");
    let mut bytes = std::fs::read(path.join("b.film")).unwrap();
    let at = bytes.len() / 2;
    bytes[at] ^= 4;
    std::fs::write(path.join("damaged.film"), bytes).unwrap();
    refused(path, &["merge", "a.film", "damaged.film"], &["damaged.film: it is damaged"]);
}

/// Films identify their scene by content. A copy of a scene in another place is the same scene, whatever its paths and
/// file times. A changed texture, sublayer or reference makes another scene. A checkpoint continues only with the same
/// content.
#[test]
fn a_picture_is_known_by_the_content_of_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let curves = "#usda 1.0\n(defaultPrim = \"fur\")\ndef BasisCurves \"fur\" { uniform token type = \"linear\"
        int[] curveVertexCounts = [2] point3f[] points = [(0,0,0), (0,1,0)]
        float[] widths = [0.3] (interpolation = \"constant\") }";
    let top = "#usda 1.0\n(subLayers = [@light.usda@])\n
        def \"coat\" (references = @parts/curves.usda@) {}
        def DomeLight \"sky\" { asset inputs:texture:file = @parts/sky.png@ }";
    let png = |value: u8| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(&[value; 3]).unwrap();
        bytes
    };
    let light = |intensity: &str| {
        format!("#usda 1.0\ndef DistantLight \"sun\" {{ float inputs:intensity = {intensity} }}").into_bytes()
    };
    let files = || {
        [
            ("top.usda", top.as_bytes().to_vec()),
            ("light.usda", light("2")),
            ("parts/curves.usda", curves.as_bytes().to_vec()),
            ("parts/sky.png", png(99)),
        ]
    };
    let write = |folder: &str, files: &[(&str, Vec<u8>)]| {
        for (name, bytes) in files {
            let file = path.join(folder).join(name);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, bytes).unwrap();
        }
    };
    let render = |scene: &str, range: &str, name: &str| {
        run(path, &["render", scene, "--size", "8x8", "--samples", range, "-o", name]);
    };
    write("here", &files());
    write("there", &files());
    render("here/top.usda", "0..1", "here.exr");
    render("./there/../there/top.usda", "1..2", "there.exr");
    run(path, &["merge", "here.film", "there.film"]);
    let wider = curves.replace("0.3", "0.4").into_bytes();
    for (name, bytes) in [("light.usda", light("3")), ("parts/curves.usda", wider), ("parts/sky.png", png(98))] {
        write("there", &files());
        write("there", &[(name, bytes)]);
        render("there/top.usda", "1..2", "changed.exr");
        refused(
            path,
            &["merge", "here.film", "changed.film"],
            &["here.film and changed.film", "not of the same picture"],
        );
    }
    // A checkpoint of the old texture.
    let args = ["render", "here/top.usda", "--size", "8x8", "--spp", "20", "-o", "kept.exr"];
    run(path, &[&args[..], &["--noise", "1e9", "--checkpoint", "60s"]].concat());
    assert!(path.join("kept.checkpoint").exists());
    write("here", &[("parts/sky.png", png(98))]);
    refused(path, &[&args[..], &["--resume"]].concat(), &["kept.checkpoint", "of another picture"]);
    write("here", &files());
    run(path, &[&args[..], &["--resume"]].concat());
}

/// A picture names its model, and films of different models do not merge.
#[test]
fn models_are_distinguished() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, &with(&["--samples", "0..1", "-o", "ours.exr"]));
    run(path, &with(&["--samples", "1..2", "--model", "yan2015", "-o", "old.exr"]));
    run(path, &with(&["--samples", "1..2", "--model", "yan2015", "--eta-m", "1.2", "-o", "two.exr"]));
    let old = Picture::read(&path.join("old.exr"));
    assert_eq!((old.note("vellus_model"), old.note("vellus_samples")), ("yan2015", "1"));
    assert_eq!(Picture::read(&path.join("two.exr")).note("vellus_model"), "yan2015, η_m 1.2");
    assert!(!old.same(&Picture::read(&path.join("ours.exr"))) && !old.same(&Picture::read(&path.join("two.exr"))));
    refused(path, &["merge", "ours.film", "old.film"], &["old.film"]);
    refused(path, &["merge", "two.film", "old.film"], &["old.film"]);
}

#[test]
fn bad_requests_are_refused_before_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("broken.hair"), b"HAIR and then nothing").unwrap();
    std::fs::write(path.join("broken.film"), b"VELLUSF3 cut").unwrap();
    std::fs::write(path.join("file"), b"").unwrap();
    refused(path, &["render", "unicorn"], &["unicorn", "raccoon", ".usda"]);
    refused(path, &["render", "cat", "--width", "1"], &["--width", "built-in scene cat has its own"]);
    refused(path, &["render", "missing.hair"], &["cannot read missing.hair"]);
    refused(path, &["render", "broken.hair"], &["broken.hair"]);
    refused(path, &with(&["--model", "phong"]), &["unknown model 'phong'", "yan2015"]);
    refused(path, &with(&["--eta-m", "1.2"]), &["--eta-m", "only yan2015"]);
    refused(path, &with(&["-o", "x.jpg"]), &["x.jpg", ".exr or .png"]);
    refused(path, &with(&["-o", "file/x.exr"]), &["cannot write file/x.exr"]);
    refused(path, &["render", "cat", "--size", "0x3"], &["[1, 32768]"]);
    refused(path, &with(&["--crop", "40,0,9,9"]), &["--crop 40,0,9,9", "48x32"]);
    refused(path, &with(&["--crop", "4,0,9"]), &["X,Y,W,H"]);
    refused(path, &with(&["--strands", "0%"]), &["above 0%"]);
    refused(path, &with(&["--min-pixel-width", "-1"]), &["[0, 100] pixels"]);
    refused(path, &with(&["--noise", "0"]), &["--noise", "a finite number above 0"]);
    refused(path, &with(&["--samples", "4..4"]), &["A < B"]);
    refused(path, &with(&["--time", "soon"]), &["60s, 5m or 2h"]);
    refused(path, &with(&["--layers", "beauty,depht"]), &["unknown layer", "depth"]);
    refused(path, &with(&["--denoise", "--samples", "0..2"]), &["--denoise", "--samples"]);
    refused(path, &["merge", "broken.film"], &["broken.film", "damaged"]);
    assert!(!path.join("out").join("render.exr").exists());
}

/// A denoised picture is closer to a converged one than the noisy picture is, and so are its lights and lobes. The
/// lights add up to the picture. The noisy channels stay unchanged.
/// Without the library, there is one message before anything is rendered.
#[test]
fn denoising_reduces_noise() {
    let folder = tempfile::tempdir().unwrap();
    let scene =
        ["render", "cat", "--small", "--size", "96x64", "--layers", "beauty,albedo,normal,lights,lobes", "--float"];
    let with = |more: &[&'static str]| [&scene[..], more].concat();
    let missing = with(&["--denoise"]);
    let output = command(folder.path(), &missing).env("VELLUS_OIDN", "nothing.so").run().unwrap();
    refused_by(&output, &missing, &["Open Image Denoise 2", "pip install pyoidn", "VELLUS_OIDN", "nothing.so"]);
    if cfg!(target_os = "linux") {
        // Another library, which every Linux has.
        let output = command(folder.path(), &missing).env("VELLUS_OIDN", "libc.so.6").run().unwrap();
        refused_by(&output, &missing, &["libc.so.6 is not Intel Open Image Denoise 2", "pip install pyoidn"]);
    }
    assert!(!folder.path().join("out/render.exr").exists());
    if need("denoiser", vellus_render::denoise::Denoiser::load()).is_none() {
        return;
    }
    run(folder.path(), &with(&["--spp", "256", "-o", "converged.exr"]));
    run(folder.path(), &with(&["--spp", "4", "-o", "noisy.exr"]));
    run(folder.path(), &with(&["--spp", "4", "--denoise", "-o", "denoised.exr"]));
    let [converged, noisy, denoised] =
        ["converged", "noisy", "denoised"].map(|name| Picture::read(&folder.path().join(format!("{name}.exr"))));
    let channel = |picture: &Picture, name: &str| {
        picture.channels.iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("no {name}")).1.clone()
    };
    for c in ["R", "G", "B"] {
        let (truth, before) = (channel(&converged, c), channel(&noisy, c));
        assert_eq!(before, channel(&denoised, c));
        let error = |values: &[f32], truth: &[f32]| values.iter().zip(truth).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
        let whole = channel(&denoised, &format!("denoised.{c}"));
        let (after, before) = (error(&whole, &truth), error(&before, &truth));
        assert!(after < 0.5 * before, "{c}: {after} of {before}");
        for kind in ["light_", "lobe_"] {
            let names = noisy.channels.iter().map(|(name, _)| name);
            let names: Vec<_> = names.filter(|n| n.starts_with(kind) && n.ends_with(&format!(".{c}"))).collect();
            assert!(names.len() > 1, "{kind}");
            let parts = |picture: &Picture, prefix: &str| {
                names.iter().map(|name| channel(picture, &format!("{prefix}{name}"))).collect::<Vec<Vec<f32>>>()
            };
            let (truth, clean) = (parts(&converged, ""), parts(&denoised, "denoised_"));
            let [before, after] = [parts(&noisy, ""), clean.clone()]
                .map(|all| all.iter().zip(&truth).map(|(values, truth)| error(values, truth)).sum::<f32>());
            assert!(after < 0.6 * before, "{kind} {c}: {after} of {before}");
            for (i, whole) in whole.iter().enumerate() {
                let missing = whole - clean.iter().map(|part| part[i]).sum::<f32>();
                assert!(missing > -1e-4 && (kind == "lobe_" || missing < 1e-4), "{kind} {c} {i}: {missing}");
            }
        }
    }
}

/// A built-in scene that is written as USD and read again gives the same picture, up to the rounding of text.
#[test]
fn scenes_come_back_from_usd() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), &["scene", "cat", "--small", "-o", "cat.usda"]);
    let picture = |scene: &[&str], name: &str| {
        run(folder.path(), &[&["render"], scene, &["--size", "48x32", "--spp", "4", "-o", name]].concat());
        let decoder =
            png::Decoder::new(std::io::BufReader::new(std::fs::File::open(folder.path().join(name)).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        pixels
    };
    let (a, b) = (picture(&["cat", "--small"], "a.png"), picture(&["cat.usda"], "b.png"));
    let difference = a.iter().zip(&b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64;
    // The difference is in levels of 1/255. If rounding changes a path, pixels differ by their noise.
    assert!(difference < 1.0, "{difference}");
}

/// The light that --max-depth cuts is reported. A groom that is written and read again gives the same picture.
#[test]
fn cut_light_is_reported_and_grooms_are_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let cut = run(folder.path(), &with(&["--spp", "2", "--max-depth", "2", "-o", "cut.png"]));
    assert!(cut.contains("paths cut after 2 events"), "{cut}");
    assert!(!folder.path().join("cut.exr").exists());
    run(folder.path(), &with(&["--spp", "1", "--strands", "20%", "--crop", "8,8,24,16", "-o", "part.png"]));
    run(folder.path(), &["groom", "convert", "hair-lock", "--small", "-o", "lock.hair"]);
    let info = |scene: &[&str]| {
        String::from_utf8(vellus(folder.path(), &[&["groom", "info"], scene].concat()).stdout).unwrap()
    };
    let count = |text: &str| text.lines().find(|l| l.trim_start().starts_with("segments")).unwrap().to_owned();
    assert_eq!(count(&info(&["lock.hair"])), count(&info(&["hair-lock", "--small"])));
    run(folder.path(), &["render", "lock.hair", "--size", "16x16", "--spp", "1", "-o", "lock.png"]);
}

/// A minimum width increases coverage, with the scene's camera and with a view. The picture reports it, and
/// its identity changes. Without a minimum width nothing changes.
#[test]
fn minimum_widths_cover_more_and_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let curve = "#usda 1.0\ndef BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2, 2]
        point3f[] points = [(0,0,0), (0.3,1,0), (0.7,0,0), (1,1,0)] float[] widths = [0.0001] (interpolation = \"constant\") }";
    let camera = "def Camera \"eye\" { double3 xformOp:translate = (0.5, 0.5, 4)
        uniform token[] xformOpOrder = [\"xformOp:translate\"] }";
    std::fs::write(path.join("framed.usda"), curve).unwrap();
    std::fs::write(path.join("seen.usda"), format!("{curve}\n{camera}")).unwrap();
    for scene in ["framed.usda", "seen.usda"] {
        let picture = |width: &[&str], name: &str| {
            // The strands lean toward +x, so the front is −x: this view is from +z.
            let view: &[&str] = if scene == "framed.usda" { &["--view", "90,8.53"] } else { &[] };
            let render = ["render", scene, "--size", "48x32", "--spp", "16", "--float", "-o", name];
            run(path, &[&render[..], view, width].concat());
            Picture::read(&path.join(name))
        };
        let cover = |picture: &Picture| {
            let (_, values) = picture.channels.iter().find(|(name, _)| name == "fibers.A").unwrap();
            values.iter().map(|x| f64::from(*x)).sum::<f64>()
        };
        let (thin, wide) = (picture(&[], "thin.exr"), picture(&["--min-pixel-width", "1"], "wide.exr"));
        assert_eq!((thin.note("vellus_min_pixel_width"), wide.note("vellus_min_pixel_width")), ("0", "1"));
        assert!(thin.same(&picture(&["--min-pixel-width", "0"], "same.exr")));
        // Two strands are a pixel wide. They cover 0.9 of 32 rows, or 32 / (4 · 15.29 / 50) rows, and are √(1 + 0.3²)
        // times as long as that. About 8 of the 16 samples of their pixels hit them, and the tolerance is 4 σ of the
        // sum. Without the minimum, their width is 1/300 of a pixel.
        let rows = if scene == "framed.usda" { 28.8 } else { 26.2 };
        let expected = 2.0 * rows * 1.09f64.sqrt();
        let tolerance = 4.0 * (expected * 0.25 / 16.0 * 2.0).sqrt();
        assert!((cover(&wide) - expected).abs() < tolerance, "{scene}: {} is not {expected}", cover(&wide));
        assert!(cover(&thin) < 0.1 * cover(&wide), "{scene}: {}", cover(&thin));
    }
    run(path, &with(&["--samples", "0..1", "-o", "thin.exr"]));
    run(path, &with(&["--samples", "1..2", "--min-pixel-width", "0.5", "-o", "wide.exr"]));
    refused(path, &["merge", "thin.film", "wide.film"], &["not of the same picture"]);
}

/// A small hamster, and more options.
fn on_hamster<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["render", "hamster", "--small", "--size", "24x16"], more].concat()
}

/// The command on a machine without a GPU.
fn without_gpu(folder: &Path, args: &[&str]) -> Command {
    let mut command = command(folder, args);
    command.env("WGPU_ADAPTER_NAME", "a name that no GPU has");
    command
}

#[test]
fn an_absent_gpu_is_reported_before_any_file_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let args = on_hamster(&["--device", "gpu", "-o", "a.exr"]);
    let output = without_gpu(folder.path(), &args).run().unwrap();
    refused_by(&output, &args, &["error: no GPU was found", "; use --device cpu"]);
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

/// Without a GPU, `auto` gives the picture of the processor, and says why.
#[test]
fn auto_takes_the_processor_where_there_is_no_gpu() {
    let folder = tempfile::tempdir().unwrap();
    let args = on_hamster(&["--device", "auto", "--spp", "2", "-o", "auto.exr"]);
    let output = without_gpu(folder.path(), &args).run().unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && message.contains("the processor renders: no GPU was found"), "{message}");
    run(folder.path(), &on_hamster(&["--spp", "2", "-o", "cpu.exr"]));
    let at = |name: &str| Picture::read(&folder.path().join(name));
    assert!(at("auto.exr").same(&at("cpu.exr")));
}

/// The same GPU gives the same bits, however the samples are divided. Films of both devices may be merged.
#[test]
#[ignore = "full: a software GPU compiles the tracer in a minute"]
fn a_gpu_resumes_and_merges() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let at = |name: &str| Picture::read(&path.join(name));
    let probe = command(path, &on_hamster(&["--device", "gpu", "--spp", "1", "-o", "probe.exr"])).run().unwrap();
    let message = String::from_utf8_lossy(&probe.stderr).into_owned();
    if need("gpu", if message.contains("no GPU was found") { Err(&message) } else { Ok(()) }).is_none() {
        return;
    }
    assert!(probe.status.success() && message.contains(" renders\n"), "{message}");
    run(path, &on_hamster(&["--device", "gpu", "--spp", "6", "-o", "whole.exr"]));
    assert!(!at("whole.exr").note("vellus_gpu").is_empty());
    run(path, &on_hamster(&["--device", "gpu", "--samples", "0..2", "-o", "a.exr"]));
    run(path, &on_hamster(&["--device", "gpu", "--samples", "2..6", "-o", "b.exr"]));
    run(path, &["merge", "b.film", "a.film", "-o", "merged.exr"]);
    assert!(at("whole.exr").same(&at("merged.exr")));
    // A goal that the first pass reaches leaves a checkpoint. The processor continues from it.
    run(path, &on_hamster(&["--device", "gpu", "--spp", "40", "--noise", "1e9", "--checkpoint", "60s", "-o", "c.exr"]));
    let resumed = run(path, &on_hamster(&["--spp", "40", "--resume", "-o", "c.exr"]));
    assert!(resumed.contains("continuing from"), "{resumed}");
    run(path, &on_hamster(&["--samples", "2..6", "-o", "d.exr"]));
    run(path, &["merge", "d.film", "a.film", "-o", "both.exr"]);
    assert_eq!(at("both.exr").note("vellus_samples"), "6");
}
