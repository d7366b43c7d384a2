"""Flexibilities that are kept in files: the same figures to the bit, computed once, and again where
a file is damaged or of other laws.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lostmotion.checked_file import write_checked
from lostmotion.io import flexibility_files
from lostmotion.io.flexibility_files import FlexibilityFiles, keep_flexibilities
from lostmotion.io.part_file import read_gearbox
from lostmotion.laws.cycloid import drive, kept

EXAMPLE = Path(__file__).parents[2] / "examples" / "gearbox" / "two-stage-lobes.toml"


@pytest.fixture
def computed(monkeypatch):
    """Return the number of times that flexibilities were computed, as a list of one element each;
    nothing is remembered from other tests.
    """
    kept.keep_in(None)  # a command that ran in this process may have set a folder
    calls = []
    law = drive._flexibilities
    monkeypatch.setattr(drive, "_flexibilities", lambda *given: calls.append(1) or law(*given))
    yield calls
    kept.keep_in(None)
    drive._bodies.cache_clear()


@pytest.fixture(scope="module")
def drawn():
    """Return a stage of an example on elastic bodies."""
    return read_gearbox(EXAMPLE).part.drive


def bodies(stage):
    """Return the flexibility as in a new process."""
    drive._bodies.cache_clear()
    return stage.bodies(np.array([0.0, 0.05]))


def test_a_second_run_reads_the_same_bits_and_computes_nothing(tmp_path, computed, drawn):
    """What is read is what was computed, without a single difference."""
    without = bodies(drawn)
    kept.keep_in(FlexibilityFiles(tmp_path / "cache"))
    first, second = bodies(drawn), bodies(drawn)
    assert len(computed) == 2  # without the files, and the first time with them
    for each in zip(without, first, second, strict=True):
        np.testing.assert_array_equal(each[0], each[1], strict=True)
        np.testing.assert_array_equal(each[0], each[2], strict=True)
    assert len(list((tmp_path / "cache").iterdir())) == 1


def spoil(raw):
    """Return a file with one bit changed in the middle."""
    middle = len(raw) // 2
    return raw[:middle] + bytes([raw[middle] ^ 1]) + raw[middle + 1 :]


@pytest.mark.parametrize(
    "damaged",
    [spoil, lambda raw: raw[:-8], lambda raw: raw[:0], lambda raw: raw[:40], lambda raw: raw * 100],
)
def test_a_damaged_file_is_computed_again(tmp_path, computed, drawn, damaged):
    """One wrong bit is enough: no figure ever follows from it, and the file is whole again."""
    kept.keep_in(FlexibilityFiles(tmp_path))
    first = bodies(drawn)
    (file,) = tmp_path.iterdir()
    sound = file.read_bytes()
    file.write_bytes(damaged(sound))
    np.testing.assert_array_equal(bodies(drawn)[0], first[0], strict=True)
    assert len(computed) == 2
    assert file.read_bytes() == sound


def test_content_that_is_no_array_is_computed_again(tmp_path, computed, drawn):
    """The checksum of the file is right, and what it contains cannot be read."""
    kept.keep_in(FlexibilityFiles(tmp_path))
    first = bodies(drawn)
    (file,) = tmp_path.iterdir()
    write_checked(file, file.name.encode(), b"no array")
    np.testing.assert_array_equal(bodies(drawn)[0], first[0], strict=True)
    assert len(computed) == 2


def test_a_file_in_the_place_of_another_is_not_read(tmp_path):
    """Two files of one size that were swapped belong to other bodies: both are unknown."""
    files = FlexibilityFiles(tmp_path)
    for key in "ab":
        files.write(key, (np.full(3, ord(key)),))
    one, other = files._file("a"), files._file("b")
    contents = one.read_bytes(), other.read_bytes()
    other.write_bytes(contents[0])
    one.write_bytes(contents[1])
    assert files.read("a") is None
    assert files.read("b") is None


def test_other_laws_read_other_files(tmp_path, computed, drawn, monkeypatch):
    """A change of the source text of any law makes every file unknown."""
    kept.keep_in(FlexibilityFiles(tmp_path))
    bodies(drawn)
    monkeypatch.setattr(flexibility_files, "_laws", lambda: "later")
    bodies(drawn)
    assert len(computed) == 2


def test_the_folder_does_not_grow_without_end(tmp_path, monkeypatch):
    """The older half goes once the folder is full."""
    monkeypatch.setattr(flexibility_files, "_MOST", 10)
    files = FlexibilityFiles(tmp_path)
    for k in range(40):
        files.write(str(k), (np.array([float(k)]),))
    assert len(list(tmp_path.iterdir())) <= 10
    assert files.read("39")[0] == 39


def test_a_folder_that_cannot_be_made_costs_only_time(tmp_path, computed, drawn, monkeypatch):
    """Nothing is kept below a file, nor without a home; the figures are computed each time."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    keep_flexibilities()
    bodies(drawn)
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    keep_flexibilities()
    bodies(drawn)
    assert len(computed) == 2
    assert [each.name for each in tmp_path.iterdir()] == ["file"]


def test_a_file_that_cannot_take_its_place_leaves_nothing_behind(tmp_path, monkeypatch):
    """Where the last step fails, and on a full disk, no part of a file stays in the folder."""
    files = FlexibilityFiles(tmp_path)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    files.write("key", (np.arange(3.0),))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_the_place_of_a_file_is_replaced(tmp_path):
    """Whatever lies under the name of a file is no obstacle."""
    files = FlexibilityFiles(tmp_path)
    files._file("key").mkdir()
    files.write("key", (np.arange(3.0),))
    np.testing.assert_array_equal(files.read("key")[0], np.arange(3.0))
