//! What a test needs from the machine. A test that cannot run says so in a file, and fails where its kind is required.

use crate::program::Limited;
use std::ffi::OsStr;
use std::fmt::Display;
use std::fs::OpenOptions;
use std::io::Write;
use std::process::Command;

/// The kinds of things that a test may need, and what they are.
pub const KINDS: &[(&str, &str)] = &[
    ("alembic", "a python3 with the module alembic3d, the library of Alembic"),
    ("blender", "a Python with Blender's module bpy, which VELLUS_BPY names"),
    ("browser", "node, its module playwright-core, and Chromium"),
    ("c++", "a C++ compiler, c++"),
    ("cc", "a C compiler, cc"),
    ("denoiser", "Intel Open Image Denoise, which `pip install pyoidn` installs or VELLUS_OIDN names"),
    ("disk", "a disk with less than 600 GB of free space"),
    ("dxc", "Microsoft's compiler of HLSL, dxc"),
    ("engines", "OpenJD, HyperQueue or Slurm"),
    ("gpu", "a GPU, or Mesa's lavapipe"),
    ("materialx", "a python3 with the module MaterialX"),
    ("mount", "permission to mount a small disk"),
    ("opengl", "OpenGL 4.3 through EGL without a window, which Mesa has"),
    ("openusd", "a python3 with Pixar's module pxr"),
    ("pkg-config", "pkg-config"),
    ("shader-compilers", "glslangValidator or spirv-val"),
    ("slangc", "the compiler of Slang, slangc, which VELLUS_SLANGC names"),
    ("valgrind", "valgrind"),
    ("vulkan", "the headers and the loader of Vulkan"),
];

/// What a test needs, if it is there. Otherwise the reason is printed and appended as one line to the file that
/// `VELLUS_SKIPPED` names, if any: `kind: test: reason`.
///
/// # Panics
/// If it is not there and `VELLUS_REQUIRE` lists its kind: `gpu,cc`, or `all`, or `all,-gpu` for all but one. Also if a
/// kind is not in [`KINDS`], or the file cannot be written.
pub fn need<T, E: Display>(kind: &str, found: Result<T, E>) -> Option<T> {
    let required = std::env::var("VELLUS_REQUIRE").unwrap_or_default();
    decide(kind, found, std::env::var_os("VELLUS_SKIPPED").as_deref(), &required)
}

fn decide<T, E: Display>(kind: &str, found: Result<T, E>, file: Option<&OsStr>, required: &str) -> Option<T> {
    let required: Vec<&str> = required.split(',').map(str::trim).filter(|kind| !kind.is_empty()).collect();
    let named = required.iter().map(|kind| kind.trim_start_matches('-'));
    for kind in [kind].into_iter().chain(named).filter(|kind| *kind != "all") {
        assert!(KINDS.iter().any(|(known, _)| *known == kind), "there is no kind '{kind}' in vellus_testing::KINDS");
    }
    let reason = match found {
        Ok(found) => return Some(found),
        Err(reason) => reason.to_string().replace('\n', " "),
    };
    // A test has the name of its thread.
    let thread = std::thread::current();
    let line = format!("{kind}: {}: {reason}", thread.name().unwrap_or("a thread without a name"));
    let all = required.contains(&"all") && !required.iter().any(|one| one.strip_prefix('-') == Some(kind));
    assert!(!all && !required.contains(&kind), "VELLUS_REQUIRE requires {line}");
    println!("skipped: {line}");
    if let Some(path) = file {
        let file = OpenOptions::new().create(true).append(true).open(path);
        // One write, so that lines of several programs do not mix.
        let written = file.and_then(|mut file| file.write_all(format!("{line}\n").as_bytes()));
        written.unwrap_or_else(|e| panic!("cannot write {}: {e}: {line}", path.display()));
    }
    None
}

/// Whether a command succeeds. Otherwise the reason.
pub fn succeeds(command: &mut Command) -> Result<(), String> {
    let name = command.get_program().display().to_string();
    let arguments = command.get_args().map(|arg| format!(" {}", arg.display())).collect::<String>();
    match command.run() {
        Err(e) => Err(format!("{name}: {e}")),
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(format!("{name}{arguments}: {}", output.status)),
    }
}

/// A Python with Blender's module bpy: the one that `VELLUS_BPY` names, or `python3`.
pub fn blender() -> Option<String> {
    let python = std::env::var("VELLUS_BPY").unwrap_or_else(|_| "python3".to_owned());
    let found = succeeds(Command::new(&python).args(["-c", "import bpy"]));
    need("blender", found.map(|()| python))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    const MISSING: Result<u8, &str> = Err("none was\nfound");

    #[test]
    fn a_missing_thing_is_one_line_in_the_file() {
        let file = std::env::temp_dir().join(format!("vellus-need-{}", std::process::id()));
        let decide = |found, required| decide("gpu", found, Some(file.as_os_str()), required);
        assert_eq!(decide(Ok(7), "gpu"), Some(7));
        assert!(!file.exists());
        assert_eq!((decide(MISSING, "all,-gpu"), decide(MISSING, "browser, c++")), (None, None));
        let line = "gpu: need::tests::a_missing_thing_is_one_line_in_the_file: none was found\n";
        let written = std::fs::read_to_string(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        assert_eq!(written, line.repeat(2));
    }

    #[test]
    fn a_required_or_unknown_kind_is_a_failure() {
        let fails = |kind: &str, found: Result<u8, &str>, required: &str| {
            let panic = catch_unwind(AssertUnwindSafe(|| decide(kind, found, None, required))).unwrap_err();
            panic.downcast_ref::<String>().cloned().unwrap_or_default()
        };
        for required in ["gpu", "all", "browser,gpu", "browser, gpu"] {
            let message = fails("gpu", MISSING, required);
            assert!(
                message.contains("gpu: need::tests::a_required") && message.contains("none was found"),
                "{message}"
            );
        }
        assert!(fails("gpus", Ok(7), "").contains("there is no kind 'gpus'"));
        assert!(fails("gpu", Ok(7), "gpu,browsers").contains("there is no kind 'browsers'"));
        let nowhere = OsStr::new("/nowhere/skipped");
        assert!(catch_unwind(|| decide("gpu", MISSING, Some(nowhere), "")).is_err());
    }

    #[test]
    fn kinds_are_sorted_and_have_one_name() {
        assert!(KINDS.is_sorted() && KINDS.windows(2).all(|two| two[0].0 != two[1].0));
    }
}
