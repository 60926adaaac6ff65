"""The stubs agree with the module."""

import importlib.util
import os
import subprocess
import sys

import pytest


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")
def test_stubs_agree_with_the_module(tmp_path):
    allowed = tmp_path / "allowed"
    # PyO3 makes this list. It has the names of the module, which stubtest compares anyway.
    allowed.write_text("vellus\\._vellus\\.__all__\n")
    config = tmp_path / "mypy.ini"
    # Packages that the module uses only if they are installed.
    config.write_text("[mypy]\nignore_missing_imports = True\n")
    options = ["--concise", "--allowlist", str(allowed), "--mypy-config-file", str(config)]
    run = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "vellus._vellus", "vellus._types", *options],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "MYPY_CACHE_DIR": str(tmp_path)},
    )
    assert run.returncode == 0, run.stdout + run.stderr


def test_everything_has_documentation():
    import vellus

    for name in set(vellus.__all__) - {"FATES", "LOBES", "__version__"}:
        public = getattr(vellus, name)
        assert public.__doc__, name
        for key, member in vars(public).items() if isinstance(public, type) else ():
            if not key.startswith("_"):
                assert member.__doc__, f"{name}.{key}"
