//! Files for x86-64 on a processor without AVX2, which QEMU simulates: they must end with a message, or work.

use crate::run::{Outcome, succeeds};
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// A processor of 2008.
const PROCESSOR: &str = "Nehalem";

/// Runs a program on the old processor. It must fail with this part of a message.
pub fn refuses(program: &Path, args: &[&str], message: &str) -> Result<Outcome, String> {
    expect(program, args, |output| {
        output.status.code().is_some_and(|code| code != 0) && String::from_utf8_lossy(&output.stderr).contains(message)
    })
}

/// Runs a program on the old processor. It must succeed.
pub fn runs(program: &Path, args: &[&str]) -> Result<Outcome, String> {
    expect(program, args, |output| output.status.success())
}

fn expect(program: &Path, args: &[&str], good: impl Fn(&Output) -> bool) -> Result<Outcome, String> {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return Ok(Outcome::Skipped("QEMU simulates only Linux on x86-64".to_owned()));
    }
    if !succeeds(Command::new("qemu-x86_64").arg("--version")) {
        return Ok(Outcome::Skipped("no qemu-x86_64".to_owned()));
    }
    let mut command = Command::new("qemu-x86_64");
    command.args(["-cpu", PROCESSOR]).arg(program).args(args).stdin(Stdio::null());
    let output = command.output().map_err(|e| format!("cannot run qemu-x86_64: {e}"))?;
    if good(&output) {
        return Ok(Outcome::Passed);
    }
    Err(format!("{} ended with {}: {}", program.display(), output.status, String::from_utf8_lossy(&output.stderr)))
}
