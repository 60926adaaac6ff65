"""Files that cannot be opened, and files with bad contents."""

import os

import pytest

import vellus


def texture(path):
    return vellus.Scene().add_texture(path)


READERS = [
    ("a.toml", vellus.Fiber.read),
    ("a.json", vellus.Fiber.read),
    ("a.mtlx", vellus.Fiber.read),
    ("a.csv", vellus.Profile.read),
    ("a.txt", vellus.Profile.read),
    ("a.usda", vellus.Scene.open),
    ("a.usdc", vellus.Scene.open),
    ("a.hair", vellus.Scene.open),
    ("a.tfx", vellus.Scene.open),
    ("a.obj", vellus.Scene.open),
    ("a.png", texture),
    ("a.obj", lambda path: vellus.Scene.open("cat", small=True, body=path)),
    ("a.hdr", lambda path: vellus.Scene.open("cat", small=True, light=str(path))),
]
each_reader = pytest.mark.parametrize(("name", "read"), READERS)


@each_reader
def test_missing_files(name, read, tmp_path):
    with pytest.raises(FileNotFoundError, match=name):
        read(tmp_path / name)


@each_reader
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="this user may read all files")
def test_files_without_permission(name, read, tmp_path):
    path = tmp_path / name
    path.write_text("nothing")
    path.chmod(0)
    with pytest.raises(PermissionError, match=name):
        read(path)


@each_reader
def test_bad_contents(name, read, tmp_path):
    path = tmp_path / name
    path.write_text("nothing")
    with pytest.raises(ValueError, match=name):
        read(path)


def test_what_is_no_file_is_a_bad_value(tmp_path):
    for name in ("unicorn", "unicorn.xyz"):
        with pytest.raises(ValueError, match=name):
            vellus.Scene.open(name)
    with pytest.raises(ValueError, match="unicorn"):
        vellus.Fiber.read("unicorn")
    (tmp_path / "a.usda").mkdir()
    with pytest.raises(ValueError, match="it is a folder"):
        vellus.Scene.open(tmp_path / "a.usda")
