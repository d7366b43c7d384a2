"""Where extensions of other packages are looked for."""

import importlib.metadata
import sys
import zipfile

import pytest

from lostmotion.extensions import extensions

FILES = {
    "METADATA": "Metadata-Version: 2.1\nName: other\nVersion: 1.2\n",
    "PKG-INFO": "Metadata-Version: 2.1\nName: other\nVersion: 1.2\n",
    "entry_points.txt": "[lostmotion.figures]\nlast_percent = other:last_percent\n",
}


@pytest.mark.parametrize(
    ("place", "folder"),
    [
        ("packages", "other-1.2.dist-info"),
        ("packages", "other.egg-info"),
        ("other-1.2-py3.11.egg", "EGG-INFO"),
        ("packages.zip", "other-1.2.dist-info"),
    ],
)
def test_a_package_of_every_form_is_found(place, folder, tmp_path, monkeypatch):
    """Installed, from its source, an egg, or in an archive on the path."""
    at = tmp_path / place
    if at.suffix == ".zip":
        with zipfile.ZipFile(at, "w") as archive:
            for name, content in FILES.items():
                archive.writestr(f"{folder}/{name}", content)
    else:
        (at / folder).mkdir(parents=True)
        for name, content in FILES.items():
            (at / folder / name).write_text(content)
    monkeypatch.syspath_prepend(at)
    found = extensions("figures")["last_percent"]
    assert found.package == ("other", "1.2")


def test_metadata_are_not_loaded_for_packages_that_bring_nothing(tmp_path, monkeypatch):
    """A package with entry points of other groups, a folder that is not there, and the current
    one.
    """
    (tmp_path / "other-1.2.dist-info").mkdir()
    (tmp_path / "other-1.2.dist-info" / "entry_points.txt").write_text(
        "[console_scripts]\nother = lostmotion.cli:main\n"
    )
    asked = []
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda **_: asked.append(1))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path), str(tmp_path / "none"), ""])
    assert extensions("questions") == {}
    assert not asked
