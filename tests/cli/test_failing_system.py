"""Every read, write and allocation fails once: a correct result or one message, nothing lost and
nothing half written.
"""

from __future__ import annotations

import functools
import shutil
import sys

import numpy as np
import pytest

from lostmotion import Study, checked_file, study
from lostmotion.accuracy import workspace
from lostmotion.cli import app as _  # noqa: F401 - loaded before calls are counted
from lostmotion.cli.app import _carried_out
from lostmotion.errors import LostmotionError
from lostmotion.io.flexibility_files import FlexibilityFiles
from lostmotion.reporting import svg
from lostmotion.reporting.folder import write_whole
from lostmotion.runs import workers
from lostmotion.runs.execute import carry_out, order
from lostmotion.runs.store import Store
from tests.cli.failing_calls import every_failure
from tests.runs.conftest import ARM, tree

OLD = {"report.html": b"old page", "result.json": b"old", "tables/a.csv": b"old table"}
NEW = {
    "report.html": b"new page" * 1000,
    "result.json": b"new",
    "tables/b.csv": b"new table",
    "figures/c.svg": b"x",
}
EXPECTED = (OSError, MemoryError, LostmotionError)


def contents(folder):
    """Return the content of every file of a folder."""
    return (
        {
            str(path.relative_to(folder)): path.read_bytes()
            for path in folder.rglob("*")
            if path.is_file()
        }
        if folder.exists()
        else {}
    )


@pytest.mark.parametrize("force", [False, True])
def test_results_are_written_whole_or_the_earlier_ones_stay(tmp_path, force):
    """Whichever call fails, old or new results stand whole, and the message says which."""
    place = tmp_path / "place"
    target = place / "deep" / "out"

    def prepare():
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        if force:
            write_whole(OLD, target)

    count = 0
    for name, at, found, raised in every_failure(
        place, lambda: write_whole(NEW, target, force=force), prepare
    ):
        count += 1
        case = f"{name}, call {at}: {raised!r}"
        there = contents(target)
        assert there == NEW if found is not None else isinstance(raised, EXPECTED), case
        assert there in ((OLD if force else {}), NEW), case
        if raised is not None and there == NEW:
            assert "is written" in str(raised), case
        beside = (
            [each.name for each in target.parent.iterdir() if each != target]
            if target.parent.exists()
            else []
        )
        # the empty folder of a trial, whose removal is what failed
        if raised is not None and beside and beside[0].startswith(".lostmotion-"):
            beside = []
        if beside:  # what could not be removed is named
            assert there == NEW, case
            assert beside[0] in str(raised), case
        if raised is not None and there == {}:
            assert not target.exists(), case
    assert count > 60


def test_a_cache_that_fails_costs_only_time(tmp_path):
    """Kernels and flexibilities are read whole or not at all, and an entry that was there before
    stays whole or is gone.
    """
    folder = tmp_path / "cache"
    file = folder / "entry"
    files = FlexibilityFiles(folder / "flexibilities")
    arrays = (np.arange(50.0), np.eye(3))
    files.read("key")  # hashes the source, which is not in this folder

    def prepare():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        checked_file.write_checked(file, b"key", b"old" * 100)
        files.write("key", arrays)

    def work():
        checked_file.write_checked(file, b"key", b"new" * 100)
        read = checked_file.read_checked(file, b"key")
        files.write("other", arrays)
        return read, files.read("key"), files.read("other")

    count = 0
    for name, at, found, raised in every_failure(folder, work, prepare):
        count += 1
        case = f"{name}, call {at}: {raised!r}"
        assert raised is None or isinstance(raised, MemoryError), case
        if found is not None:
            assert found[0] in (None, b"old" * 100, b"new" * 100), case
            for read in found[1:]:
                assert read is None or all(map(np.array_equal, read, arrays)), case
        assert checked_file.read_checked(file, b"key") in (b"old" * 100, b"new" * 100), case
        # no part of a file
        assert {each.name for each in folder.iterdir()} <= {"entry", "flexibilities"}, case
        assert all(len(each.name) == 64 for each in (folder / "flexibilities").iterdir()), case
    assert count > 30


@pytest.mark.slow
@pytest.mark.few_counts
def test_a_run_keeps_its_finished_blocks(tmp_path, monkeypatch):
    """Whichever call fails while a run is begun, continued and read: the same order then ends with
    the same bytes as an undisturbed one. Of all calls every second fails, in one of three ways.
    """
    # What a block holds, computed from no file, is the same each time.
    monkeypatch.setattr(workers, "compute_packed", functools.cache(workers.compute_packed))
    arm = tmp_path / "tiny.toml"
    arm.write_text(ARM, encoding="utf-8")
    asked = order(arm, poses=16, robots=10, visits=2, seed=1, pose_law="uniform", block=8)
    folder, undisturbed = tmp_path / "runs" / "one", tmp_path / "undisturbed"

    def run(at):
        store = Store.begin(at, asked)
        carry_out(store)
        record = store.read(0, 0)
        store.keep("result.json", b"{}")
        return record

    reference = run(undisturbed)
    expected = tree(undisturbed)
    begun = tmp_path / "begun"
    Store.begin(begun, asked)
    count = 0

    def prepare():
        shutil.rmtree(folder, ignore_errors=True)
        if count % 2:
            shutil.copytree(begun, folder)

    for name, at, found, raised in every_failure(
        tmp_path / "runs", lambda: run(folder), prepare, step=6
    ):
        count += 1
        case = f"{name}, call {at}: {raised!r}"
        assert raised is None or isinstance(raised, EXPECTED), case
        if found is not None:
            assert all(
                np.array_equal(getattr(found, each), getattr(reference, each))
                for each in found.__slots__
            ), case
            assert tree(folder) == expected, case
        run(folder)
        assert tree(folder) == expected, case
    assert count > 30


@pytest.mark.slow
@pytest.mark.few_counts
def test_a_command_whose_files_fail_is_one_message(tmp_path, monkeypatch, capsys):
    """A study from its arm file to its report, of whose calls every fifth fails in one of three
    ways: exit code 2 and a message, or the result to the byte; the earlier result stays where there
    is none.
    """
    place = tmp_path / "place"
    place.mkdir()
    (place / "tiny.toml").write_text(ARM, encoding="utf-8")
    out = place / "out"
    words = [
        "study",
        str(place / "tiny.toml"),
        "--poses",
        "16",
        "--robots",
        "8",
        "--visits",
        "2",
        "--quiet",
        "--force",
        "--out",
        str(out),
    ]
    monkeypatch.setenv("XDG_CACHE_HOME", str(place / "cache"))
    # Computed in memory from no file, and most of the time of a study and of its report.
    monkeypatch.setattr(workspace, "SAMPLES", 4096)
    pictures = [study(place / "tiny.toml", 16, 8, visits=2)._first_plot()]
    picture = svg.raw_svg(pictures[0].figure)
    monkeypatch.setattr(Study, "plots", property(lambda _of: pictures))
    monkeypatch.setattr(svg, "raw_svg", lambda _of: picture)
    monkeypatch.setattr(sys, "argv", ["lostmotion", *words])
    assert _carried_out()[0] == 0
    expected = contents(out)
    old = {"result.json": b"{}", "report.html": b"old"}

    def prepare():
        shutil.rmtree(out, ignore_errors=True)
        write_whole(old, out)

    for name, at, found, raised in every_failure(place, _carried_out, prepare, step=15):
        case = f"{name}, call {at}: {found} {raised!r}"
        assert raised is None, case
        code, message = found
        assert contents(out) == (expected if code == 0 or "is written" in message else old), case
        assert (code == 0) == (message == ""), case
        assert code in (0, 2), case
        assert "Traceback" not in "".join(capsys.readouterr()), case
