//! Profiles in files: all formats give the same profile, and an error names its place.

use exr::prelude::{Image, SpecificChannels, WritableImage};
use std::path::{Path, PathBuf};
use vellus::{Fiber, Species};
use vellus_fit::{
    Angles, Axis, Forward, Profile, Quantity, Reading, Synthetic, csv, gantry_text, parse_blur, read, simulate,
};

fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// An error and its cause.
fn chain(error: &dyn std::error::Error) -> String {
    error.source().map_or_else(|| error.to_string(), |cause| format!("{error}: {cause}"))
}

/// Writes NumPy's format, version 1.
fn npy(kind: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let mut head = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    head += &" ".repeat(63 - (head.len() + 10) % 64);
    head.push('\n');
    [b"\x93NUMPY\x01\x00".as_slice(), &(head.len() as u16).to_le_bytes(), head.as_bytes(), data].concat()
}

/// Sorts the points and rounds the values to single precision.
fn same(a: &Profile, b: &Profile) {
    let sorted = |p: &Profile| {
        let mut points = p.points.clone();
        points.sort_by(|a, b| a.theta.total_cmp(&b.theta).then(a.phi.total_cmp(&b.phi)));
        points
    };
    assert_eq!((a.channels, a.theta_o, a.missing.len()), (b.channels, b.theta_o, b.missing.len()));
    assert!(a.simulated.is_empty() || a.simulated == b.simulated, "{a:?}");
    for (a, b) in sorted(a).iter().zip(&sorted(b)) {
        assert!((a.theta - b.theta).abs() < 1e-9 && (a.phi - b.phi).abs() < 1e-9, "{a:?} {b:?}");
        for c in 0..3 {
            // Text has seven digits.
            assert!((a.value[c] - b.value[c]).abs() <= 6e-7 * b.value[c], "{a:?} {b:?}");
        }
    }
}

#[test]
fn all_formats_give_the_same_profile() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let fiber = Fiber::preset(Species::Cat).with_absorption([0.1, 0.3, 0.9]);
    for channels in [1, 3] {
        let synthetic = Synthetic { step: [8.0, 11.0], theta_o: -22.5, channels, ..Synthetic::default() };
        let mut profile = simulate::from_model(Forward::default(), &fiber.into(), &synthetic).unwrap();
        if channels == 1 {
            profile.points.iter_mut().for_each(|p| p.value[1..].fill(0.0));
        }
        let notes = ["a note".to_owned()];
        let plain = Reading::default();
        let text = read(&write(folder, "a.txt", gantry_text(&profile, &notes)), &plain).unwrap();
        let (name, kappa) = &text.simulated[0];
        assert!(name == "kappa" && *kappa as f32 == fiber.kappa, "{name} {kappa}");
        same(&text, &profile);
        same(&read(&write(folder, "a.csv", csv(&profile, &notes)), &plain).unwrap(), &profile);
        // As images: θ from 10 to 50, φ from −20 to 200, NaN for a missing value.
        let (rows, columns) = (6, 21);
        let mut pixels = vec![[f64::NAN; 3]; rows * columns];
        for p in &profile.points {
            let (row, column) = (((p.theta - 10.0) / 8.0).round(), ((p.phi + 20.0) / 11.0).round());
            pixels[row as usize * columns + column as usize] = p.value;
        }
        let axes = [Axis { first: 10.0, last: 50.0 }, Axis { first: -20.0, last: 200.0 }];
        let reading = Reading { theta_o: Some(-22.5), axes: Some(axes), ..Reading::default() };
        let values = || pixels.iter().flat_map(|p| &p[..channels]);
        let shape = if channels == 1 { "(6, 21)" } else { "(6, 21, 3)" };
        let double: Vec<u8> = values().flat_map(|x| x.to_le_bytes()).collect();
        let single: Vec<u8> = values().flat_map(|x| (*x as f32).to_le_bytes()).collect();
        same(&read(&write(folder, "a.npy", npy("<f8", shape, &double)), &reading).unwrap(), &profile);
        same(&read(&write(folder, "b.npy", npy("<f4", shape, &single)), &reading).unwrap(), &profile);
        let mut bytes = std::io::Cursor::new(Vec::new());
        let at = |at: exr::math::Vec2<usize>| pixels[at.y() * columns + at.x()].map(|x| x as f32);
        if channels == 1 {
            let channel = SpecificChannels::build().with_channel("Y").with_pixel_fn(|p| (at(p)[0],));
            Image::from_channels((columns, rows), channel).write().non_parallel().to_buffered(&mut bytes).unwrap();
        } else {
            let rgb = SpecificChannels::rgb(|p| (at(p)[0], at(p)[1], at(p)[2]));
            Image::from_channels((columns, rows), rgb).write().non_parallel().to_buffered(&mut bytes).unwrap();
        }
        same(&read(&write(folder, "a.exr", bytes.into_inner()), &reading).unwrap(), &profile);
    }
}

/// The published measurements have `phi theta value` in the coordinates of their gantry, and no header.
#[test]
fn gantry_coordinates_are_those_of_the_published_measurements() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::new();
    for phi in (70..=290).step_by(20) {
        for theta in (40..=80).step_by(10) {
            text += &format!("{phi} {theta} {}\n", if (phi, theta) == (90, 60) { "?" } else { "0.5" });
        }
    }
    let path = write(folder.path(), "bobcat.txt", &text);
    let profile = read(&path, &Reading { theta_o: Some(-30.0), ..Reading::default() }).unwrap();
    assert_eq!((profile.axis(|p| p.theta), profile.quantity), (vec![10.0, 20.0, 30.0, 40.0, 50.0], Quantity::FCos));
    assert_eq!(profile.axis(|p| p.phi), (0..12).map(|i| f64::from(i) * 20.0 - 20.0).collect::<Vec<_>>());
    assert_eq!(profile.missing, [[30.0, 0.0]]);
    // The first line, 70 40, is θ = 50° and φ = −20°.
    assert_eq!((profile.points[0].theta, profile.points[0].phi), (50.0, -20.0));
    let fiber = Reading { theta_o: Some(-30.0), angles: Some(Angles::Fiber), ..Reading::default() };
    assert_eq!(read(&path, &fiber).unwrap().axis(|p| p.theta)[0], 40.0);
}

#[test]
fn errors_name_the_file_and_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let known = Reading { theta_o: Some(-30.0), ..Reading::default() };
    let refused = |name: &str, bytes: &[u8], reading: &Reading, parts: &[&str]| {
        let message = read(&write(folder.path(), name, bytes), reading).unwrap_err().to_string();
        for part in parts.iter().chain([&name]) {
            assert!(message.contains(part), "{name}: '{part}' is not in: {message}");
        }
        assert_eq!(message.lines().count(), 1, "{message}");
    };
    let row = |theta: i32| (0..60).map(|i| format!("{} {theta} 0.1\n", 70 + i)).collect::<String>();
    for (text, parts) in [
        ("", &["no measurements"][..]),
        ("# theta_o = -30\n", &["no measurements"]),
        ("70 40 ?\n72 40 ?\n", &["all 2 measurements are missing"]),
        ("70 40 0\n72 40 -0.2\n", &["all 2 measurements are missing"]),
        ("70 40 0.1\n72 40 NaN\n", &["line 2", "'NaN' is not a number"]),
        ("70 40 0.1\n\n72 40 inf\n", &["line 3", "'inf' is not a number"]),
        ("70 40 0.1\n72 x 0.2\n", &["line 2", "theta = 'x'"]),
        ("70 40 0.1\n72 ? 0.2\n", &["line 2", "theta is missing"]),
        ("70 40 0.1\n72 185 0.2\n", &["line 2", "theta = 185", "(-90, 90)", "fibre's own angles"]),
        ("70 40 0.1\n500 40 0.2\n", &["line 2", "phi = 500", "[-360, 360]"]),
        ("70 40 0.1\n72 40\n", &["line 2", "2 numbers", "phi theta value"]),
        ("70 40 0.1\n72 40 1 2 3\n", &["line 2", "5 numbers", "first line has 3"]),
        ("# theta_o = up\n70 40 0.1\n", &["line 1", "theta_o = 'up'", "degrees"]),
        ("# angles = odd\n70 40 0.1\n", &["line 1", "odd", "fiber or gantry"]),
        (&row(40), &["same theta, 50", "both theta and phi"]),
        ("70 40 1\n72 41 1\n74 42 1\n", &["3 measurements are too few", "36"]),
    ] {
        refused("a.txt", text.as_bytes(), &known, parts);
    }
    refused("a.txt", (row(40) + &row(50)).as_bytes(), &Reading::default(), &["--theta-o"]);
    refused("a.txt", (row(40) + &row(50)).as_bytes(), &Reading { theta_o: Some(95.0), ..known }, &["theta_o = 95"]);
    refused("a.txt", &[0xff, 0xfe, 0x00], &known, &["byte 0", "UTF-8"]);
    refused("a.dat", b"70 40 0.1\n", &known, &["unknown format", ".txt, .csv, .npy or .exr"]);
    for (text, parts) in [
        ("theta,phi\n10,20\n", &["line 1", "theta, phi", "value or r, g, b"][..]),
        ("theta,phi,r,g\n10,20,1,2\n", &["line 1", "expected theta"]),
        ("theta,phi,value\n10,20,0.1\n10,20,NaN\n", &["line 3", "value = 'NaN'"]),
        ("# a note\ntheta,phi,value\n10,20,0.1\n95,20,0.1\n", &["line 4", "theta = 95"]),
        ("theta,phi,value\n10,20\n", &["line 2", "2 columns", "expected 3"]),
        ("theta,phi,value\n", &["no measurements"]),
        (
            "theta,phi,value,noise\n10,20,0.1,0.01\n",
            &["line 1", "'noise'", "expected theta, phi, value or r, g, b, and sigma or sigma_r, sigma_g, sigma_b"],
        ),
        ("theta,phi,value,sigma\n10,20,0.1,0\n", &["line 2", "sigma = 0 is out of range", "above 0"]),
        ("theta,phi,value,sigma\n10,20,0.1,1\n10,30,0.1,-0.5\n", &["line 3", "sigma = -0.5 is out of range"]),
        ("theta,phi,value,sigma\n10,20,0.1,?\n", &["line 2", "sigma", "above 0"]),
        ("theta,phi,value,sigma\n10,20,0.1,x\n", &["line 2", "sigma = 'x' is not a number"]),
        ("theta,phi,r,g,b,sigma_r,sigma_g\n10,20,1,1,1,1,1\n", &["line 1", "2 columns of sigma for 3"]),
        ("theta,phi,value,sigma_r,sigma_g,sigma_b\n10,20,1,1,1,1\n", &["line 1", "3 columns of sigma for 1"]),
        ("theta,phi,value,sigma,sigma_r\n10,20,1,1,1\n", &["line 1", "column 'sigma_r'"]),
        ("# blur = wide\ntheta,phi,value\n10,20,0.1\n", &["line 1", "blur = 'wide'", "degrees"]),
        ("# blur = 1,2,3\ntheta,phi,value\n10,20,0.1\n", &["line 1", "blur = '1,2,3'"]),
        ("# blur = 31\ntheta,phi,value\n10,20,0.1\n", &["line 1", "blur = '31'"]),
        ("# a note\nr,g,b,theta,phi,value\n1,1,1,10,20,0.1\n", &["line 2", "column 'r'", "expected theta"]),
    ] {
        refused("a.csv", text.as_bytes(), &known, parts);
    }
    let axes = Some([Axis { first: 10.0, last: 50.0 }, Axis { first: -20.0, last: 200.0 }]);
    let image = Reading { axes, ..known };
    let data: Vec<u8> = (0..64).flat_map(|i| (f64::from(i) + 1.0).to_le_bytes()).collect();
    refused("a.npy", &npy("<f8", "(8, 8)", &data), &known, &["--theta FIRST:LAST", "--phi"]);
    refused("a.npy", &npy("<f8", "(8, 9)", &data), &image, &["512 bytes of values from byte 128", "needs 576"]);
    refused("a.npy", &npy("<i8", "(8, 8)", &data), &image, &["<i8", "float64"]);
    refused("a.npy", &npy("<f8", "(64,)", &data), &image, &["[64]", "rows, columns"]);
    refused("a.npy", &npy("<f8", "(99999999, 99999999)", &data), &image, &["it claims", "expected 1 to"]);
    refused("a.npy", b"no array", &image, &["byte 0", "no NPY"]);
    refused("a.npy", b"\x93NUMPY\x07\x00\x10\x00", &image, &["byte 6", "version 7", "expected 1, 2 or 3"]);
    refused("a.npy", b"\x93NUMPY\x01\x00\x10\x00{", &image, &["byte 11", "16 bytes"]);
    let cut = [b"\x93NUMPY\x01\x00\x17\x00{'fortran_order': False}".as_slice(), &data].concat();
    refused("a.npy", &cut, &image, &["'descr'", "'<f4' or '<f8'"]);
    refused("a.exr", b"no image at all", &image, &["OpenEXR"]);
    let missing = chain(&read(Path::new("no/such.txt"), &known).unwrap_err());
    assert!(missing.starts_with("cannot read no/such.txt: ") && missing.contains("(os error"), "{missing}");
}

/// A CSV file with a row for each of 8 × 8 directions.
fn table(head: &str, row: &dyn Fn(f64) -> String) -> String {
    let rows = (0..64).map(|i| format!("{},{},{}\n", 10 + 2 * (i / 8), 10 * (i % 8), row(f64::from(i) + 1.0)));
    format!("theta,phi,{head}\n{}", rows.collect::<String>())
}

/// Standard deviations are one number for each value, or one for all three channels. A missing value needs none.
#[test]
fn standard_deviations_are_read_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let known = Reading { theta_o: Some(-30.0), ..Reading::default() };
    let grey = table("value,sigma", &|x| format!("{x},{}", 0.1 * x));
    let one = table("r,g,sigma,b", &|x| format!("{x},{x},{},{x}", 0.1 * x));
    let three = table("sigma_b,r,g,b,sigma_r,sigma_g", &|x| format!("{},{x},{x},{x},{},{}", 0.3 * x, 0.1 * x, 0.2 * x));
    let missing = table("value,sigma", &|x| if x == 9.0 { "?,?".to_owned() } else { format!("{x},{}", 0.1 * x) });
    for (text, channels, count, relative) in [
        (&grey, 1, 64, [0.1; 3]),
        (&one, 3, 64, [0.1; 3]),
        (&three, 3, 64, [0.1, 0.2, 0.3]),
        (&missing, 1, 63, [0.1; 3]),
    ] {
        let profile = read(&write(folder.path(), "a.csv", text), &known).unwrap();
        assert_eq!((profile.channels, profile.points.len()), (channels, count));
        let again = read(&write(folder.path(), "b.csv", csv(&profile, &[])), &Reading::default()).unwrap();
        same(&again, &profile);
        for p in profile.points.iter().chain(&again.points) {
            let sigma = p.sigma.unwrap();
            for c in 0..channels {
                assert!((sigma[c] / p.value[c] / relative[c] - 1.0).abs() < 2e-6, "{p:?}");
            }
        }
    }
    let plain = read(&write(folder.path(), "a.csv", table("value", &|x| x.to_string())), &known).unwrap();
    assert!(plain.points.iter().all(|p| p.sigma.is_none()) && !csv(&plain, &[]).contains("sigma"));
}

/// Files state the widths of cells in a comment. What the caller knows counts more.
#[test]
fn widths_of_cells_are_read_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let known = Reading { theta_o: Some(-30.0), ..Reading::default() };
    let of = |comment: &str, reading: &Reading| {
        let text = comment.to_owned() + &table("value", &|x| x.to_string());
        read(&write(folder.path(), "a.csv", text), reading).unwrap()
    };
    assert_eq!(of("", &known).blur, [0.0; 2]);
    assert_eq!(of("# blur = 4\n", &known).blur, [4.0; 2]);
    let profile = of("# blur = 5, 2.5\n", &known);
    assert_eq!(profile.blur, [5.0, 2.5]);
    assert_eq!(of("# blur = 4\n", &Reading { blur: Some([0.0, 1.0]), ..known }).blur, [0.0, 1.0]);
    for (name, text) in [("b.csv", csv(&profile, &[])), ("b.txt", gantry_text(&profile, &[]))] {
        let again = read(&write(folder.path(), name, text), &Reading::default()).unwrap();
        same(&again, &profile);
        assert_eq!(again.blur, profile.blur, "{name}");
    }
    for (text, part) in [
        ("31", "blur = 31 is out of range: it must be in [0, 30] degrees"),
        ("-1", "blur = -1"),
        ("NaN", "blur = NaN"),
        ("5,", "'' is not a number"),
        ("1,2,3", "'2,3' is not a number"),
    ] {
        let message = parse_blur(text).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
}

/// Noise leaves negative values where a background was subtracted. They count as missing.
#[test]
fn negative_values_are_missing_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let known = Reading { theta_o: Some(-30.0), ..Reading::default() };
    let axes = Some([Axis { first: 10.0, last: 24.0 }, Axis { first: 0.0, last: 70.0 }]);
    let at = |i: usize| if [9, 20].contains(&i) { -1.0 } else { i as f64 };
    let values: Vec<f64> = (0..64).map(at).collect();
    let place = |i: usize| (10 + 2 * (i / 8), 10 * (i % 8));
    let rows = |line: &dyn Fn((usize, usize), f64) -> String| -> String {
        values.iter().enumerate().map(|(i, x)| line(place(i), *x)).collect()
    };
    let text = rows(&|(theta, phi), x| format!("{} {} {x}\n", phi + 90, 90 - theta));
    let rgb = "theta,phi,r,g,b\n".to_owned() + &rows(&|(theta, phi), x| format!("{theta},{phi},1,{x},1\n"));
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    for (name, bytes, axes) in [
        ("a.txt", text.into_bytes(), None),
        ("a.csv", rgb.into_bytes(), None),
        ("a.npy", npy("<f8", "(8, 8)", &bytes), axes),
    ] {
        let profile = read(&write(folder.path(), name, bytes), &Reading { axes, ..known }).unwrap();
        // The value 0 is missing, but it is not negative.
        assert_eq!((profile.points.len(), profile.negative), (61, 2), "{name}");
        assert_eq!(profile.missing, [[10.0, 0.0], [12.0, 10.0], [14.0, 40.0]], "{name}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn devices_and_huge_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let known = Reading { theta_o: Some(-30.0), ..Reading::default() };
    for extension in ["txt", "csv", "npy", "exr"] {
        let link = folder.path().join(format!("zero.{extension}"));
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        let message = chain(&read(&link, &known).unwrap_err());
        assert!(message.contains(&format!("zero.{extension}: it is a device")), "{message}");
        // A sparse file: it takes no space on the disk.
        let sparse = folder.path().join(format!("sparse.{extension}"));
        std::fs::File::create(&sparse).unwrap().set_len((1 << 30) + 1).unwrap();
        let message = chain(&read(&sparse, &known).unwrap_err());
        assert!(message.contains("1073741825 bytes") && message.contains("at most 1073741824"), "{message}");
    }
}

/// Damaged bytes never make the reader of arrays panic.
#[test]
fn damaged_arrays_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let axes = Some([Axis { first: 10.0, last: 50.0 }, Axis { first: -20.0, last: 200.0 }]);
    let reading = Reading { theta_o: Some(0.0), axes, ..Reading::default() };
    let data: Vec<u8> = (0..48).flat_map(|i| (f64::from(i) + 1.0).to_le_bytes()).collect();
    let whole = npy("<f8", "(6, 8)", &data);
    assert!(read(&write(folder.path(), "a.npy", &whole), &reading).is_ok());
    for end in 0..whole.len() {
        assert!(read(&write(folder.path(), "a.npy", &whole[..end]), &reading).is_err(), "{end}");
    }
    for at in 0..160 {
        let mut garbled = whole.clone();
        garbled[at] ^= 0x5f;
        let _ = read(&write(folder.path(), "a.npy", &garbled), &reading);
    }
}
