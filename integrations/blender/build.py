"""Builds the extension of Blender with the wheel of the package vellus in it.

usage: build.py --wheel FILE.whl --out FOLDER [--blender-ext FILE]

It leaves vellus_blender-VERSION-PLATFORM.zip in the folder, for the platform of the wheel. Blender's own tool,
blender_ext.py, validates it if it is given or the package bpy is installed. It needs Python 3.11 or later.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path

HERE = Path(__file__).parent

# The start and the end of a wheel's platform, and Blender's name for it.
PLATFORMS = [
    ("manylinux", "_x86_64", "linux-x64"),
    ("linux", "_x86_64", "linux-x64"),
    ("macosx", "_arm64", "macos-arm64"),
    ("macosx", "_x86_64", "macos-x64"),
    ("win", "_amd64", "windows-x64"),
    ("win", "_arm64", "windows-arm64"),
]


def blender_ext():
    """The tool in the package bpy, if that is installed."""
    try:
        import bpy
    except ImportError:
        return None
    found = list(Path(bpy.utils.resource_path("LOCAL")).rglob("bl_pkg/cli/blender_ext.py"))
    return found[0] if found else None


def platform(wheel):
    """Blender's name of the platform that a wheel is for."""
    tag = wheel.stem.split("-")[-1]
    for start, end, name in PLATFORMS:
        if tag.startswith(start) and tag.endswith(end):
            return name
    sys.exit(f"error: Blender has no platform {tag}, which is that of {wheel.name}")


def stage(folder, wheel):
    """Copies everything that the extension consists of. The hook is one file, which also works alone."""
    package = folder / "vellus_blender"
    shutil.copytree(HERE / "vellus_blender", package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(HERE / "vellus_usd_hook.py", package / "hook.py")
    for name in ("LICENSE-MIT", "LICENSE-APACHE"):
        shutil.copy(HERE.parents[1] / name, package)
    (package / "wheels").mkdir()
    shutil.copy(wheel, package / "wheels")
    with (package / "blender_manifest.toml").open("a") as manifest:
        manifest.write(f'wheels = ["./wheels/{wheel.name}"]\nplatforms = ["{platform(wheel)}"]\n')
    return package


def pack(package, file):
    """Writes the zip file. Its bytes depend only on its contents: each entry has the earliest time of the format."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(package.rglob("*")):
            if path.is_file():
                entry = zipfile.ZipInfo(path.relative_to(package).as_posix())
                archive.writestr(entry, path.read_bytes(), zipfile.ZIP_DEFLATED)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wheel", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--blender-ext", type=Path)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        package = stage(Path(folder), arguments.wheel)
        manifest = tomllib.loads((package / "blender_manifest.toml").read_text(encoding="utf-8"))
        name = f"{manifest['id']}-{manifest['version']}-{manifest['platforms'][0].replace('-', '_')}.zip"
        pack(package, arguments.out / name)
    tool = arguments.blender_ext or blender_ext()
    if tool is None:
        print("not validated: neither --blender-ext nor the package bpy is there")
    else:
        subprocess.run([sys.executable, tool, "validate", arguments.out / name], check=True)
    print(arguments.out / name)


if __name__ == "__main__":
    main()
