"""Installs the peers into target/peers, renders, and writes table.md there. README.md explains it."""

import argparse
import glob
import os
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
OUT = ROOT / "target" / "peers"


def python():
    """The interpreter of the virtual environment. Installs missing packages."""
    if sys.version_info[:2] != (3, 11):
        sys.exit("bpy 5.0.1 is made for Python 3.11 only: run this with it")
    folder = OUT / "venv"
    if not folder.exists():
        venv.create(folder, with_pip=True)
    interpreter = folder / "bin" / "python"
    subprocess.run([interpreter, "-m", "pip", "install", "--quiet", "-r", HERE / "requirements.txt"], check=True)
    return interpreter


def llvm():
    """The newest LLVM library on the system. Mitsuba's vector variant needs it, and its wheel does not contain it."""
    if "DRJIT_LIBLLVM_PATH" in os.environ:
        return os.environ["DRJIT_LIBLLVM_PATH"]
    found = glob.glob("/usr/lib/*/libLLVM.so.*") + glob.glob("/usr/lib/llvm-*/lib/libLLVM.so.*")
    version = lambda path: float(path.split(".so.")[1])
    if not found:
        sys.exit("no LLVM: install it (Debian: libllvm19), or set DRJIT_LIBLLVM_PATH")
    return max(found, key=version)


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--quick", action="store_true", help="fewer repeats and samples: about four minutes")
    arguments.add_argument("--cache", action="store_true", help="the radiance cache beside the peers, to cached.md")
    arguments.add_argument("--scenes", action="store_true", help="the built-in scenes beside the peers, to scenes.md")
    arguments.add_argument("--gpu", action="store_true", help="our GPU path beside Mitsuba's, to gpu.md")
    given = arguments.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    interpreter = python()
    environment = os.environ | {"DRJIT_LIBLLVM_PATH": llvm()}
    subprocess.run(["cargo", "build", "--release", "--quiet", "-p", "vellus-cli"], cwd=ROOT, check=True)
    done = OUT / "scenes" / "done"
    sources = max((HERE / name).stat().st_mtime for name in ("fur.py", "scene.py"))
    if not done.exists() or done.stat().st_mtime < sources:
        done.parent.mkdir(exist_ok=True)
        subprocess.run([interpreter, HERE / "fur.py", done.parent], check=True)
        done.touch()
    script = HERE / ("gpu.py" if given.gpu else "cached.py" if given.cache else "compare.py")
    script = HERE / "built_in.py" if given.scenes else script
    command = [interpreter, script, OUT, ROOT / "target" / "release" / "vellus"]
    sys.exit(subprocess.run(command + ["--quick"] * given.quick, env=environment).returncode)


if __name__ == "__main__":
    main()
