//! The command's archive, tried as its users would.

use super::sandbox::Sandbox;
use super::{VERSION, old_processor, toolchain};
use crate::run::{Outcome, Report, output, run, succeeds};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Unpacks the archive and tries the command, its manual and its completions.
pub fn all(report: &mut Report, sandbox: &Sandbox, archive: &Path) -> Result<(), String> {
    let name = archive.file_name().unwrap_or_default().to_string_lossy();
    let top = PathBuf::from(name.trim_end_matches(".tar.gz").trim_end_matches(".zip"));
    let program = top.join("bin").join(format!("vellus{}", std::env::consts::EXE_SUFFIX));
    sandbox.unpack(archive)?;
    let share = sandbox.work().join(&top).join("share");
    report.step(&format!("{name}, tried"), 15.0, || {
        old_enough(&sandbox.work().join(&program))?;
        let version = output(sandbox.program(&program).arg("--version"))?;
        if version.trim() != format!("vellus {VERSION}") {
            return Err(format!("--version printed {version:?}"));
        }
        run(sandbox
            .program(&program)
            .args(["render", "cat", "--small", "--spp", "1", "--size", "64x64", "-o", "cat.exr"]))?;
        for picture in ["cat.exr", "cat.png"] {
            has_bytes(&sandbox.work().join(picture))?;
        }
        pages(&share, &output(sandbox.program(&program).arg("--help"))?)
    })?;
    report.attempt("manual in man", 15.0, || manual(&share))?;
    for (shell, line) in [("bash", BASH), ("zsh", "zsh -n \"$1\""), ("fish", "fish --no-execute \"$1\"")] {
        report.attempt(&format!("completions in {shell}"), 15.0, || completions(&share, shell, line))?;
    }
    let program = sandbox.work().join(program);
    report.attempt(&format!("{name} without AVX2"), 15.0, || on_old_processor(&program))
}

/// Every subcommand in the help has a page.
fn pages(share: &Path, help: &str) -> Result<(), String> {
    let list = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let commands: Vec<&str> = list.filter_map(|line| line.strip_prefix("  ")?.split(' ').next()).collect();
    let names = commands.iter().filter(|name| !name.is_empty() && **name != "help");
    let mut count = 0;
    for name in names {
        has_bytes(&share.join(format!("man/man1/vellus-{name}.1")))?;
        count += 1;
    }
    if count == 0 { Err("the help lists no subcommand".to_owned()) } else { Ok(()) }
}

/// man can show every page.
fn manual(share: &Path) -> Result<Outcome, String> {
    if !succeeds(Command::new("man").arg("--version")) {
        return Ok(Outcome::Skipped("no man".to_owned()));
    }
    let folder = share.join("man/man1");
    for entry in folder.read_dir().map_err(|e| format!("{}: {e}", folder.display()))?.flatten() {
        let page = output(Command::new("man").arg(entry.path()).env("MANPAGER", "cat").env("MANWIDTH", "100"))?;
        if !page.contains("SYNOPSIS") {
            return Err(format!("{}: no synopsis", entry.path().display()));
        }
    }
    Ok(Outcome::Passed)
}

/// bash completes `vellus ren` to `render`.
const BASH: &str = "source \"$1\" && COMP_WORDS=(vellus ren) COMP_CWORD=1 && _vellus vellus ren vellus; \
                    test \"${COMPREPLY[*]}\" = render";

/// A shell reads its completions.
fn completions(share: &Path, shell: &str, line: &str) -> Result<Outcome, String> {
    if !succeeds(Command::new(shell).arg("--version")) {
        return Ok(Outcome::Skipped(format!("no {shell}")));
    }
    let file = match shell {
        "bash" => "bash-completion/completions/vellus",
        "zsh" => "zsh/site-functions/_vellus",
        _ => "fish/vendor_completions.d/vellus.fish",
    };
    run(Command::new("bash").args(["-c", line, "bash"]).arg(share.join(file)))?;
    Ok(Outcome::Passed)
}

/// On an old processor, the usual command ends with a message, and the other one works.
fn on_old_processor(program: &Path) -> Result<Outcome, String> {
    if !program.to_string_lossy().contains("-baseline") {
        return old_processor::refuses(program, &["--version"], "archive whose name ends in -baseline");
    }
    // A render takes minutes in QEMU.
    old_processor::runs(program, &["energy", "--fiber", "red-fox"])
}

/// A program for Linux needs no later glibc than promised.
fn old_enough(program: &Path) -> Result<(), String> {
    let bytes = std::fs::read(program).map_err(|e| format!("{}: {e}", program.display()))?;
    match needed_glibc(&bytes) {
        Some(needed) if needed > version(toolchain::GLIBC) => {
            Err(format!("{} needs glibc {}.{}", program.display(), needed.0, needed.1))
        }
        _ => Ok(()),
    }
}

/// The latest version among the names `GLIBC_2.17` in a program.
fn needed_glibc(program: &[u8]) -> Option<(u32, u32)> {
    let text = String::from_utf8_lossy(program);
    text.split("GLIBC_").skip(1).map(version).max()
}

/// The two numbers at the start of a text.
fn version(text: &str) -> (u32, u32) {
    let mut numbers = text.split(|c: char| !c.is_ascii_digit());
    let mut next = || numbers.next().and_then(|digits| digits.parse().ok()).unwrap_or(0);
    (next(), next())
}

/// An error if the file is missing or empty.
pub fn has_bytes(file: &Path) -> Result<(), String> {
    match std::fs::metadata(file) {
        Ok(metadata) if metadata.len() > 0 => Ok(()),
        Ok(_) => Err(format!("{} is empty", file.display())),
        Err(e) => Err(format!("{}: {e}", file.display())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_needed_glibc_is_the_latest_version_by_number() {
        assert_eq!(needed_glibc(b"\0GLIBC_2.4\0\xffGLIBC_2.28\0GLIBC_2.9\0"), Some((2, 28)));
        assert_eq!(needed_glibc(b"GCC_3.0"), None);
        assert!(version("2.36") > version(toolchain::GLIBC));
    }
}
