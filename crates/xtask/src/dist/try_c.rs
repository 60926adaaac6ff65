//! The archive for C, tried with pkg-config and with CMake: a program of the examples, which prints many results.

use super::{Dist, old_processor};
use crate::run::{Outcome, Report, output, run, succeeds};
use std::path::Path;
use std::process::Command;

/// A program for each library.
const PROJECT: &str = "\
cmake_minimum_required(VERSION 3.13)
project(trial C)
set(CMAKE_C_STANDARD 11)
find_package(vellus @VERSION@ REQUIRED)
foreach(kind vellus static)
  add_executable(${kind} \"@SOURCE@\")
  target_link_libraries(${kind} PRIVATE vellus::${kind})
endforeach()
";

/// Unpacks the archive and tries it.
pub fn all(dist: &Dist, report: &mut Report, archive: &Path) -> Result<(), String> {
    let folder = dist.empty("try/c")?;
    run(Command::new("tar").arg("-xf").arg(archive).arg("-C").arg(&folder))?;
    let name = archive.file_name().unwrap_or_default().to_string_lossy();
    let prefix = folder.join(name.trim_end_matches(".tar.gz").trim_end_matches(".zip"));
    let source = dist.root.join("examples/c/queries.c");
    report.attempt(&format!("{name} with pkg-config"), 15.0, || pkg_config(&prefix, &source))?;
    report.attempt(&format!("{name} with CMake"), 15.0, || cmake(&folder, &prefix, &source))?;
    let program = folder.join("build/static");
    if program.exists() {
        let message = "this library was built for AVX2";
        report.attempt(&format!("{name} without AVX2"), 15.0, || old_processor::refuses(&program, &[], message))?;
    }
    Ok(())
}

/// Compiles the program by hand.
fn pkg_config(prefix: &Path, source: &Path) -> Result<Outcome, String> {
    if let Some(missing) = ["cc", "pkg-config"].into_iter().find(|name| !exists(name)) {
        return Ok(Outcome::Skipped(format!("no {missing}")));
    }
    let mut flags = Command::new("pkg-config");
    flags.args(["--cflags", "--libs", "vellus"]).env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
    let program = prefix.join("program");
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c11", "-o"]).arg(&program).arg(source).args(output(&mut flags)?.split_whitespace());
    run(compiler.arg(format!("-Wl,-rpath,{}", prefix.join("lib").display())))?;
    results(prefix, &program).map(|_| Outcome::Passed)
}

/// Builds a small project. Both libraries give the same results.
fn cmake(folder: &Path, prefix: &Path, source: &Path) -> Result<Outcome, String> {
    if !exists("cmake") {
        return Ok(Outcome::Skipped("no cmake".to_owned()));
    }
    // CMake's strings have slashes on all systems.
    let source = source.display().to_string().replace('\\', "/");
    let project = PROJECT.replace("@SOURCE@", &source).replace("@VERSION@", super::VERSION);
    let lists = folder.join("CMakeLists.txt");
    std::fs::write(&lists, project).map_err(|e| format!("{}: {e}", lists.display()))?;
    let build = folder.join("build");
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(folder).arg("-B").arg(&build).arg("-DCMAKE_BUILD_TYPE=Release");
    run(configure.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display())))?;
    run(Command::new("cmake").arg("--build").arg(&build).args(["--config", "Release"]))?;
    let programs = if cfg!(windows) { build.join("Release") } else { build };
    let results = |name: &str| results(prefix, &programs.join(format!("{name}{}", std::env::consts::EXE_SUFFIX)));
    if results("vellus")? == results("static")? {
        Ok(Outcome::Passed)
    } else {
        Err("the shared and the static library give different results".to_owned())
    }
}

/// What the program prints.
fn results(prefix: &Path, program: &Path) -> Result<String, String> {
    let mut command = Command::new(program);
    if cfg!(windows) {
        // Windows looks for shared libraries in the current folder.
        command.current_dir(prefix.join("bin"));
    }
    let text = output(&mut command)?;
    if text.lines().count() > 40 { Ok(text) } else { Err(format!("{} printed {text:?}", program.display())) }
}

fn exists(program: &str) -> bool {
    succeeds(Command::new(program).arg("--version"))
}
