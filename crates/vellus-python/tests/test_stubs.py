"""The stubs agree with the module."""

import ast
import importlib.util
import inspect
import os
import re
import subprocess
import sys

import pytest
import stub_docs
import typed

import vellus


needs_mypy = pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")


@needs_mypy
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


@needs_mypy
def test_types_are_as_wide_as_the_code(tmp_path):
    """An ignored error that mypy does not find is an error, too."""
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--config-file=", typed.__file__],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "MYPY_CACHE_DIR": str(tmp_path)},
    )
    assert run.returncode == 0, run.stdout + run.stderr


def test_what_the_types_accept_works():
    typed.accepted()


def test_everything_has_documentation():
    for name in set(vellus.__all__) - {"FATES", "LOBES", "__version__"}:
        public = getattr(vellus, name)
        assert public.__doc__, name
        for key, member in vars(public).items() if isinstance(public, type) else ():
            if not key.startswith("_"):
                assert member.__doc__, f"{name}.{key}"


def test_stubs_have_the_docstrings_of_the_module():
    # If this fails: python stub_docs.py
    text = stub_docs.STUBS.read_text()
    assert stub_docs.documented(text, vellus._vellus) == text


def test_docstrings_name_every_argument_and_the_shapes_of_results():
    module = vellus._vellus
    missing = []
    for node, public in stub_docs.entries(ast.parse(stub_docs.STUBS.read_text()), module):
        text = " ".join((inspect.getdoc(public) or "").split())
        assert text, node.name
        if isinstance(node, ast.FunctionDef) and "rguments as for `" not in text and "keyword arguments of" not in text:
            arguments = [a.arg for a in node.args.args + node.args.kwonlyargs if a.arg != "self"]
            missing += [f"{node.name}: {a}" for a in arguments if not re.search(f"`{a}[`(=]", text)]
        returned = ast.unparse(node.returns) if isinstance(node, ast.FunctionDef) and node.returns else ""
        if ("NDArray" in returned or "_Real" in returned) and not re.search(r"shape|\(\.\.\.", text):
            missing.append(f"{node.name}: the shape of the result")
    assert not missing
