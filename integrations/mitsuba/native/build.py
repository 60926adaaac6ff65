"""Builds the Mitsuba plugin `vellus` against the Mitsuba of this interpreter.

usage: python build.py --vellus PREFIX --out FOLDER

PREFIX is where `cargo xtask c PREFIX` put the library. The plugin becomes FOLDER/plugins/vellus.so. A scene loads
it after `mitsuba.file_resolver().append(FOLDER)`. It belongs to this version of Mitsuba: build it
again after an update.

needs: pip install mitsuba nanobind; a C++ compiler (CXX, or c++); an x86-64 processor
"""

import argparse
import importlib.metadata
import importlib.util
import os
import platform
import subprocess
import sys
from pathlib import Path

SOURCE = Path(__file__).resolve().parent / "vellus.cpp"


def package(name):
    """The folder of an installed package, without importing it."""
    found = importlib.util.find_spec(name)
    if found is None or not found.submodule_search_locations:
        sys.exit(f"no package {name}: run `{sys.executable} -m pip install {name}`")
    return Path(found.submodule_search_locations[0])


def command(prefix, out):
    """The compiler's command line."""
    if platform.machine() not in ("x86_64", "AMD64"):
        # On other processors Dr.Jit's vectors have a layout that was not tried.
        sys.exit(f"the plugin is for x86-64, not {platform.machine()}")
    mitsuba, drjit, nanobind = (package(name) for name in ("mitsuba", "drjit", "nanobind"))
    library = Path(prefix) / "lib" / "libvellus.a"
    if not library.exists():
        sys.exit(f"no {library}: run `cargo xtask c {prefix}`")
    return [
        os.environ.get("CXX", "c++"),
        "-std=c++17", "-O2", "-DNDEBUG", "-fno-strict-aliasing", "-fPIC", "-shared", "-fvisibility=hidden",
        # Mitsuba's wheel is built for it. Without SSE4.2 a vector of three numbers has another layout.
        "-march=ivybridge",
        *(f"-I{folder}" for folder in (mitsuba / "include", drjit / "include", nanobind / "include")),
        f"-I{Path(prefix) / 'include'}",
        str(SOURCE), "-o", str(out),
        f"-L{mitsuba}", f"-L{drjit}", "-lmitsuba", "-ldrjit-core", "-ldrjit-extra", "-lnanothread",
        # The static library: the plugin works wherever it is copied to.
        str(library), "-Wl,--exclude-libs,ALL", "-lpthread", "-ldl", "-lm",
    ]  # fmt: skip


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--vellus", required=True, metavar="PREFIX", help="folder of the installed library")
    arguments.add_argument("--out", required=True, metavar="FOLDER", help="folder of the plugin")
    options = arguments.parse_args()
    folder = Path(options.out) / "plugins"
    folder.mkdir(parents=True, exist_ok=True)
    done = subprocess.run(command(options.vellus, folder / "vellus.so"))
    if done.returncode == 0:
        print(f"{folder / 'vellus.so'}, for Mitsuba {importlib.metadata.version('mitsuba')}")
    sys.exit(done.returncode)


if __name__ == "__main__":
    main()
