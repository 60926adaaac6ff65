//! Full disks: a limit on the size of files, and a small disk if this program may mount one.

use super::{Attack, places, same, temporary_files};
use crate::picture::Picture;
use crate::trial::{Stop, Trial};
use std::path::{Path, PathBuf};
use std::process::Command;
use vellus_testing::program::{LIMIT, Limited};

/// About 30 KB of pictures and 150 KB of checkpoint.
const SCENE: &str = "hair-lock --small --size 48x32 --spp 200 --float --layers beauty,alpha,variance";
const PIXELS: usize = 48 * 32;
/// The most bytes of its pictures: eight channels of four bytes in OpenEXR, and four bytes a pixel in PNG.
const PICTURES: usize = 36 * PIXELS;
/// A film of its layers, 24 words a pixel.
const FILM: usize = 96 * PIXELS;
/// The command asks for space for the pictures and two films. Pictures of an earlier run stay until the new ones
/// replace them. Each of these six files takes whole pages of 4 KiB, and its notes take less than a page.
const SMALLEST_DISK_KB: usize = (2 * PICTURES + 2 * FILM).div_ceil(1024) + 6 * 2 * 4;

#[derive(Default)]
pub struct Disk {
    /// The picture, and one with another seed.
    pictures: Option<[[Picture; 2]; 2]>,
    /// Whether mounting was refused.
    no_mount: bool,
}

impl Attack for Disk {
    fn name(&self) -> &'static str {
        "disk"
    }

    fn case(&mut self, trial: &mut Trial) -> Result<(), Stop> {
        if self.pictures.is_none() {
            self.pictures = prepare(trial)?;
        }
        let Some(pictures) = &self.pictures else { return Ok(()) };
        trial.tried += 1;
        match trial.dice.number(0..3) {
            0 => places::case(trial),
            1 => limited(trial, pictures),
            _ => {
                let disk = trial.at("disk");
                std::fs::create_dir_all(&disk)?;
                let kilobytes = trial.dice.number(SMALLEST_DISK_KB..2 * SMALLEST_DISK_KB);
                let mounted = if self.no_mount { None } else { Mount::new(&disk, kilobytes)? };
                match mounted {
                    Some(mount) => full(trial, pictures, &mount, kilobytes),
                    None => {
                        self.no_mount = true;
                        limited(trial, pictures)
                    }
                }
            }
        }
    }

    fn left_out(&self) -> Option<&'static str> {
        self.no_mount.then_some("a small separate disk: this user may not mount one")
    }
}

fn prepare(trial: &mut Trial) -> Result<Option<[[Picture; 2]; 2]>, Stop> {
    let mut found = Vec::new();
    for seed in ["0", "1"] {
        if !trial.prepare(&trial.vellus("render -o p.exr --seed").arg(seed).args(SCENE))? {
            return Ok(None);
        }
        let read = |trial: &mut Trial, name: &str| super::picture(trial, &trial.at(name), "an undisturbed run");
        let (Some(exr), Some(png)) = (read(trial, "p.exr"), read(trial, "p.png")) else { return Ok(None) };
        found.push([exr, png]);
    }
    std::fs::remove_file(trial.at("p.exr"))?;
    std::fs::remove_file(trial.at("p.png"))?;
    Ok(found.try_into().ok())
}

/// Runs with a limit on the size of files.
fn limited(trial: &mut Trial, pictures: &[[Picture; 2]; 2]) -> Result<(), Stop> {
    let folder = trial.at("out");
    std::fs::create_dir_all(&folder)?;
    let before = older(trial, &folder)?;
    let blocks = trial.dice.number(0..160) as u64;
    attempt(trial, &folder, pictures, before, Some(blocks), "a limit on file sizes")?;
    resumed(trial, &folder, pictures, "after a limit on file sizes")
}

/// Runs on a disk with little space, partly filled.
fn full(trial: &mut Trial, pictures: &[[Picture; 2]; 2], mount: &Mount, kilobytes: usize) -> Result<(), Stop> {
    let before = older(trial, &mount.0)?;
    let filler = mount.0.join("filler");
    let taken = trial.dice.number(0..kilobytes);
    // The disk may become full while this file is written. That is intended.
    let fill = format!("head -c {} /dev/zero > \"$0\" 2> /dev/null", taken << 10);
    let mut filling = Command::new("/bin/sh");
    let later = trial.dice.chance(0.7);
    let what = if later {
        let after = trial.dice.within(0.0, 0.4);
        filling.arg("-c").arg(format!("sleep {after:.3}; {fill}")).arg(&filler);
        "a disk that becomes full"
    } else {
        filling.arg("-c").arg(fill).arg(&filler);
        "a full disk"
    };
    let mut filling = filling.start()?;
    if !later {
        filling.ended_within(LIMIT);
    }
    let result = attempt(trial, &mount.0, pictures, before, None, what);
    filling.ended_within(LIMIT);
    filling.kill();
    result?;
    std::fs::remove_file(&filler).ok();
    resumed(trial, &mount.0, pictures, &format!("after {what}"))
}

/// In some cases a picture with another seed already exists.
fn older(trial: &mut Trial, folder: &Path) -> Result<bool, Stop> {
    let there = trial.dice.chance(0.5);
    Ok(there && trial.prepare(&render(trial, folder).arg("--seed").arg("1"))?)
}

fn render(trial: &Trial, folder: &Path) -> crate::child::Call {
    let folder = folder.strip_prefix(&trial.folder).unwrap_or(folder);
    trial.vellus("render --checkpoint 0s -o").arg(folder.join("p.exr")).args(SCENE)
}

/// Renders with too little space. The old files must be intact, or the new ones complete.
fn attempt(
    trial: &mut Trial,
    folder: &Path,
    pictures: &[[Picture; 2]; 2],
    before: bool,
    blocks: Option<u64>,
    what: &str,
) -> Result<(), Stop> {
    let mut call = render(trial, folder);
    call.file_blocks = blocks;
    let outcome = trial.run(&call)?;
    trial.ended_with(&outcome, &[0, 75], what);
    for (i, name) in ["p.exr", "p.png"].into_iter().enumerate() {
        let path = folder.join(name);
        if !path.exists() {
            if before {
                trial.finding(format!("{what}: the previous file is lost"), name);
            }
            continue;
        }
        if let Some(picture) = super::picture(trial, &path, what) {
            let new = picture == pictures[0][i];
            let old = before && picture == pictures[1][i];
            let right = if outcome.code == Some(0) { new } else { new || old };
            if !right {
                trial.finding(format!("{what}: a picture that is neither the old nor the new one"), name);
            }
        }
    }
    if outcome.signal.is_none() {
        for folder in [folder, &trial.at("tmp")] {
            if !temporary_files(folder)?.is_empty() {
                trial.finding(format!("{what}: a temporary file is left"), "");
            }
        }
    }
    Ok(())
}

/// With enough space again, the picture must be completed.
fn resumed(trial: &mut Trial, folder: &Path, pictures: &[[Picture; 2]; 2], what: &str) -> Result<(), Stop> {
    let outcome = trial.run(&render(trial, folder).arg("--resume"))?;
    let what = format!("--resume {what}");
    if trial.ended_with(&outcome, &[0], &what) {
        same(trial, &folder.join("p.exr"), &pictures[0][0], &what);
        same(trial, &folder.join("p.png"), &pictures[0][1], &what);
    }
    Ok(())
}

/// A small disk in memory, unmounted when it is dropped.
struct Mount(PathBuf);

impl Mount {
    fn new(folder: &Path, kilobytes: usize) -> Result<Option<Mount>, Stop> {
        if !rustix::process::geteuid().is_root() {
            return Ok(None);
        }
        let size = format!("size={kilobytes}k");
        let output = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "vellus-torture"]).arg(folder).output();
        Ok(output.is_ok_and(|output| output.status.success()).then(|| Mount(folder.to_owned())))
    }
}

impl Drop for Mount {
    fn drop(&mut self) {
        let unmounted = Command::new("umount").arg(&self.0).status();
        if !unmounted.is_ok_and(|status| status.success()) {
            eprintln!("warning: cannot unmount {}", self.0.display());
        }
    }
}
