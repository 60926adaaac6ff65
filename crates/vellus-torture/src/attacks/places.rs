//! Outputs to special files, standard streams that are full or closed, and file modes.

use super::picture;
use crate::child::{Call, Outcome, Sink};
use crate::trial::{Stop, Trial};
use rustix::fs::{FileType, Mode};
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::Command;
use vellus_testing::program::{LIMIT, Limited};

/// Commands that print their result to standard output.
const TALKING: [&str; 7] = [
    "scene",
    "fiber list",
    "fiber show cat",
    "eval",
    "energy --format json",
    "table info",
    "groom info hair-lock --small",
];

/// Commands that also write files.
const WRITING: [&str; 4] = [
    "render hair-lock --small --size 8x6 --spp 1 -o x.exr",
    "render hair-lock --small --size 8x6 --samples 0..1 -o x.exr",
    "scene hair-lock --small -o x.usda",
    "fit --simulate cat --step 30 --out x.csv",
];

/// One case of the attack `disk`.
pub fn case(trial: &mut Trial) -> Result<(), Stop> {
    match trial.dice.number(0..6) {
        0 => streams(trial),
        1 => device(trial),
        2 => link(trial),
        3 => fifo(trial),
        4 => mode(trial),
        _ => umask(trial),
    }
}

/// Standard output is full, closed, or read by nobody.
fn streams(trial: &mut Trial) -> Result<(), Stop> {
    let talks = trial.dice.chance(0.5);
    let line = *if talks { trial.dice.pick(&TALKING) } else { trial.dice.pick(&WRITING) };
    let mut call = trial.vellus(line);
    let full = Sink::File(PathBuf::from("/dev/full"));
    let (sink, name) = match trial.dice.number(0..3) {
        0 => (full, "full"),
        1 => (Sink::ClosedPipe, "a closed pipe"),
        _ => (Sink::Closed, "closed"),
    };
    // A full device is an error; a missing reader need not be.
    let codes: &[i32] = match (talks, name) {
        (true, "full") => &[75],
        _ => &[0, 2, 75],
    };
    if trial.dice.chance(0.3) {
        call.stderr = sink.clone();
        call.stdout = if trial.dice.chance(0.5) { sink } else { Sink::Read };
        let outcome = trial.run(&call)?;
        trial.ended_with(&outcome, &[0, 2, 75], &format!("standard error is {name}"));
    } else {
        call.stdout = sink;
        let outcome = trial.run(&call)?;
        trial.ended_with(&outcome, codes, &format!("standard output is {name}"));
    }
    Ok(())
}

/// A command that writes one file. Its name is the last argument.
fn writer(trial: &mut Trial) -> (Call, &'static str) {
    let lines = [
        ("render hair-lock --small --size 8x6 --spp 1 -o", "png"),
        ("scene hair-lock --small -o", "usda"),
        ("eval --format csv --out", "csv"),
        ("fit --simulate cat --step 30 --out", "csv"),
        ("plot lobes --out", "svg"),
    ];
    let (line, extension) = *trial.dice.pick(&lines);
    (trial.vellus(line), extension)
}

/// Output to a full device. It is a device of this program, or one behind a link, so that a device in /dev is never
/// replaced.
fn device(trial: &mut Trial) -> Result<(), Stop> {
    let own = trial.at("full-device");
    let made = rustix::fs::mknodat(
        rustix::fs::CWD,
        &own,
        FileType::CharacterDevice,
        Mode::from_raw_mode(0o666),
        rustix::fs::makedev(1, 7),
    );
    let (call, extension) = writer(trial);
    let name = format!("full.{extension}");
    if made.is_ok() && trial.dice.chance(0.5) {
        std::fs::rename(&own, trial.at(&name))?;
    } else {
        // A user without permission to create a device cannot replace one in /dev either.
        let target = if made.is_ok() { own } else { PathBuf::from("/dev/full") };
        std::os::unix::fs::symlink(target, trial.at(&name))?;
    }
    let outcome = trial.run(&call.arg(&name))?;
    trial.ended_with(&outcome, &[75], "output to a full device");
    let still = std::fs::metadata(trial.at(&name)).is_ok_and(|m| m.file_type().is_char_device());
    if !still {
        trial.finding("output replaces a device, or the link to it", name);
    }
    Ok(())
}

/// Output to a link to a file: the file must be written, and the link must remain.
fn link(trial: &mut Trial) -> Result<(), Stop> {
    let (call, extension) = writer(trial);
    let (name, target) = (format!("link.{extension}"), format!("elsewhere/target.{extension}"));
    std::fs::create_dir_all(trial.at("elsewhere"))?;
    let there = trial.dice.chance(0.5);
    if there {
        std::fs::write(trial.at(&target), "old")?;
    }
    std::os::unix::fs::symlink(&target, trial.at(&name))?;
    let outcome = trial.run(&call.arg(&name))?;
    if trial.ended_with(&outcome, &[0], "output through a link") {
        if !std::fs::symlink_metadata(trial.at(&name))?.file_type().is_symlink() {
            trial.finding("output replaces a link", name);
        } else if std::fs::metadata(trial.at(&target)).map_or(0, |m| m.len()) < 4 {
            trial.finding("output through a link does not reach its target", name);
        }
    }
    Ok(())
}

/// Output to a named pipe: its reader must get everything.
fn fifo(trial: &mut Trial) -> Result<(), Stop> {
    let (call, extension) = writer(trial);
    let name = format!("pipe.{extension}");
    let path = trial.at(&name);
    make_fifo(&path)?;
    // A pipe to this program would become full, because nobody reads it while the command runs.
    let received = trial.at("received");
    let mut reader = Command::new("cat").arg(&path).stdout(std::fs::File::create(&received)?).start()?;
    let outcome = trial.run(&call.arg(&name))?;
    let still = std::fs::symlink_metadata(&path).is_ok_and(|m| m.file_type().is_fifo());
    if !still {
        trial.finding("output replaces a named pipe", name.clone());
    }
    // Otherwise the reader may still wait for a writer.
    if outcome.code == Some(0) && still {
        reader.ended_within(LIMIT);
    }
    reader.kill();
    let empty = std::fs::metadata(&received)?.len() == 0;
    if trial.ended_with(&outcome, &[0], "output to a named pipe") && still && empty {
        trial.finding("the reader of a named pipe gets nothing", name);
    }
    Ok(())
}

/// Creates a named pipe.
pub fn make_fifo(path: &Path) -> Result<(), Stop> {
    let made = rustix::fs::mknodat(rustix::fs::CWD, path, FileType::Fifo, Mode::from_raw_mode(0o600), 0);
    Ok(made.map_err(std::io::Error::from)?)
}

/// A file that is replaced must keep its mode.
fn mode(trial: &mut Trial) -> Result<(), Stop> {
    let (call, extension) = writer(trial);
    let name = format!("kept.{extension}");
    let mode = *trial.dice.pick(&[0o600, 0o640, 0o664, 0o666, 0o755]);
    std::fs::write(trial.at(&name), "old")?;
    std::fs::set_permissions(trial.at(&name), std::fs::Permissions::from_mode(mode))?;
    let outcome = trial.run(&call.arg(&name))?;
    written_with(trial, &outcome, &name, mode, "the mode of a replaced file changes")
}

/// A new file must have the mode that the umask allows.
fn umask(trial: &mut Trial) -> Result<(), Stop> {
    let (mut call, extension) = writer(trial);
    let name = format!("new.{extension}");
    let (umask, mode) = *trial.dice.pick(&[("077", 0o600), ("027", 0o640), ("022", 0o644), ("002", 0o664)]);
    call.umask = Some(umask);
    let outcome = trial.run(&call.arg(&name))?;
    written_with(trial, &outcome, &name, mode, "the umask is ignored")
}

fn written_with(trial: &mut Trial, outcome: &Outcome, name: &str, mode: u32, kind: &str) -> Result<(), Stop> {
    if trial.ended_with(outcome, &[0], "output to a file with a mode") {
        let found = std::fs::metadata(trial.at(name))?.mode() & 0o7777;
        if found != mode {
            trial.finding(kind, format!("{name}: {found:o}, not {mode:o}"));
        }
        if name.ends_with("png") {
            picture(trial, &trial.at(name), kind);
        }
    }
    Ok(())
}
