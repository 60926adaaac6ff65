"""Builds the extension of Blender with the wheel of the package vellus in it.

usage: build.py --wheel FILE.whl --out FOLDER [--blender-ext FILE]

It leaves vellus_blender-VERSION.zip in the folder. `--blender-ext` is Blender's own tool, blender_ext.py; without it,
the one of the installed package bpy is used. Blender's tool validates the extension first.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent


def blender_ext():
    """The tool in the package bpy."""
    import bpy

    found = list(Path(bpy.utils.resource_path("LOCAL")).rglob("bl_pkg/cli/blender_ext.py"))
    if not found:
        sys.exit("error: bpy has no blender_ext.py: give --blender-ext")
    return found[0]


def stage(folder, wheel):
    """Copies everything that the extension consists of. The hook is one file, which also works alone."""
    package = folder / "vellus_blender"
    shutil.copytree(HERE / "vellus_blender", package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(HERE / "vellus_usd_hook.py", package / "hook.py")
    (package / "wheels").mkdir()
    shutil.copy(wheel, package / "wheels")
    with (package / "blender_manifest.toml").open("a") as manifest:
        manifest.write(f'wheels = ["./wheels/{wheel.name}"]\n')
    return package


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wheel", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--blender-ext", type=Path)
    arguments = parser.parse_args()
    tool = arguments.blender_ext or blender_ext()
    arguments.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        package = stage(Path(folder), arguments.wheel)
        subprocess.run([sys.executable, tool, "validate", package], check=True)
        build = [sys.executable, tool, "build", "--source-dir", package, "--output-dir", arguments.out]
        subprocess.run(build, check=True)


if __name__ == "__main__":
    main()
