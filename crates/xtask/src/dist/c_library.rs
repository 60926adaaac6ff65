//! The library for C as a prefix: shared and static library, header, `vellus.pc` and the files for CMake.

use super::command::copy;
use super::{Dist, VERSION, archive, licences, packages};
use crate::run::run;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The names of the libraries on one system.
struct System {
    /// As the compiler makes them: the shared library, the static one, and on Windows the one to link with.
    built: &'static [&'static str],
    /// Where they go. The number of the ABI replaces `@ABI@`.
    installed: &'static [&'static str],
    /// The name without a number, a symbolic link to the shared library.
    link: Option<&'static str>,
    /// How the linker gets the name that programs will look for.
    soname: Option<&'static str>,
    /// What the static library needs.
    libraries: &'static [&'static str],
}

const SYSTEM: System = if cfg!(windows) {
    System {
        // The library to link with contains the name of the shared one, which therefore stays.
        built: &["vellus_c.dll", "vellus_c.lib", "vellus_c.dll.lib"],
        installed: &["bin/vellus_c.dll", "lib/vellus_static.lib", "lib/vellus.lib"],
        link: None,
        soname: None,
        libraries: &["kernel32", "ntdll", "userenv", "ws2_32", "dbghelp"],
    }
} else if cfg!(target_os = "macos") {
    System {
        built: &["libvellus_c.dylib", "libvellus_c.a"],
        installed: &["lib/libvellus.@ABI@.dylib", "lib/libvellus.a"],
        link: Some("lib/libvellus.dylib"),
        soname: Some("-Wl,-install_name,@rpath/libvellus.@ABI@.dylib"),
        libraries: &["m"],
    }
} else {
    System {
        built: &["libvellus_c.so", "libvellus_c.a"],
        installed: &["lib/libvellus.so.@ABI@", "lib/libvellus.a"],
        link: Some("lib/libvellus.so"),
        soname: Some("-Wl,-soname,libvellus.so.@ABI@"),
        libraries: &["pthread", "dl", "m"],
    }
};

/// Compiles the library with `cargo rustc`, which leaves it in `built`, and installs it into a prefix.
pub fn install(root: &Path, cargo: &mut Command, built: &Path, prefix: &Path) -> Result<(), String> {
    let package = root.join("crates/vellus-c");
    let header = package.join("include/vellus.h");
    let abi = abi(&std::fs::read_to_string(&header).map_err(|e| format!("{}: {e}", header.display()))?)?;
    let soname = SYSTEM.soname.map(|argument| format!("link-arg={}", argument.replace("@ABI@", &abi)));
    cargo.args(["--package", "vellus-c", "--lib", "--"]).args(soname.iter().flat_map(|soname| ["-C", soname]));
    run(cargo)?;
    copy(&header, &prefix.join("include/vellus.h"))?;
    for (from, to) in SYSTEM.built.iter().zip(SYSTEM.installed) {
        copy(&built.join(from), &prefix.join(to.replace("@ABI@", &abi)))?;
    }
    if let Some(name) = SYSTEM.link {
        let shared = SYSTEM.installed[0].replace("@ABI@", &abi);
        link(&prefix.join(name), Path::new(&shared).file_name().unwrap_or_default().as_ref())?;
    }
    for (name, text) in [
        ("lib/pkgconfig/vellus.pc", include_str!("vellus.pc")),
        ("lib/cmake/vellus/vellusConfig.cmake", include_str!("vellusConfig.cmake")),
        ("lib/cmake/vellus/vellusConfigVersion.cmake", include_str!("vellusConfigVersion.cmake")),
    ] {
        let path = prefix.join(name);
        let made = std::fs::create_dir_all(path.parent().unwrap_or(prefix));
        made.and_then(|()| std::fs::write(&path, filled(text, &abi)))
            .map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

/// A template with the values of this version and system.
fn filled(text: &str, abi: &str) -> String {
    let private: Vec<String> = SYSTEM.libraries.iter().map(|name| format!("-l{name}")).collect();
    let minor = VERSION.rsplit_once('.').map_or(VERSION, |(minor, _)| minor);
    text.replace("@SHARED@", SYSTEM.installed[0])
        .replace("@STATIC@", SYSTEM.installed[1])
        .replace("@PRIVATE@", &private.join(" "))
        .replace("@SYSTEM@", &SYSTEM.libraries.join(";"))
        .replace("@VERSION@", VERSION)
        .replace("@MINOR@", minor)
        .replace("@ABI@", abi)
}

/// The number of the ABI in the header.
fn abi(header: &str) -> Result<String, String> {
    let line = header.lines().find_map(|line| line.strip_prefix("#define VELLUS_ABI_VERSION "));
    line.map(|number| number.trim().to_owned()).ok_or("vellus.h has no VELLUS_ABI_VERSION".to_owned())
}

/// A symbolic link, which replaces the one that is there.
fn link(path: &Path, target: &Path) -> Result<(), String> {
    std::fs::remove_file(path).ok();
    #[cfg(unix)]
    std::os::unix::fs::symlink(target, path).map_err(|e| format!("{} to {}: {e}", path.display(), target.display()))?;
    Ok(())
}

/// Builds the archive.
pub fn build(dist: &Dist) -> Result<PathBuf, String> {
    let triple = &dist.tools.triple;
    let folder = dist.empty(&format!("stage/vellus-c-{VERSION}-{triple}"))?;
    install(&dist.root, &mut dist.tools.cargo("rustc", "build"), &dist.tools.release("build"), &folder)?;
    std::fs::write(folder.join("README.md"), include_str!("c_library.md").replace("VERSION", VERSION))
        .map_err(|e| format!("README.md: {e}"))?;
    let packages = packages::compiled_into(&dist.root, &["vellus-c"], triple)?;
    licences::copy(&dist.root, &folder, packages.values())?;
    archive::pack(&folder, &dist.out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_for_other_build_systems_have_no_place_holder_left() {
        for text in
            [include_str!("vellus.pc"), include_str!("vellusConfig.cmake"), include_str!("vellusConfigVersion.cmake")]
        {
            assert!(!filled(text, "1").contains('@'), "{}", filled(text, "1"));
        }
        assert_eq!(abi("\n#define VELLUS_ABI_VERSION 7\n").as_deref(), Ok("7"));
        assert!(abi("#define VELLUS_ABI 7").is_err());
    }
}
