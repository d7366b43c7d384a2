"""The folder of a run: what is kept, what is found damaged, what is refused."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import xarray
import zarr

from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import LostmotionError, OutputExistsError
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.runs.blocks import COLUMNS, BlockRecord, compute, pack, unpack
from lostmotion.runs.execute import carry_out, order
from lostmotion.runs.job import Order, order_of
from lostmotion.runs.lock import lock
from lostmotion.runs.store import Store
from lostmotion.runs.stream import poses_between
from lostmotion.runs.summary import summarise
from tests.command import carried_out as lostmotion
from tests.runs.conftest import ARM, tree

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "big runs",
        (
            "10 kills at random moments, resumed on 1, 2 and 7 workers; a Dask worker killed; "
            "chunks cut or altered; the study in memory; all "
            "samples one by one"
        ),
        "byte for byte; bit for bit; 0.4 % of the 95th percentile",
        "tests/runs/test_sweep.py tests/runs/test_dask.py",
    ),
)

HERE = Path(__file__).parent
COUNTS = {"poses": 64, "robots": 20, "visits": 3, "seed": 1, "block": 4}


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """Return a run of one design that is done, and its order."""
    folder = tmp_path_factory.mktemp("small")
    path = folder / "tiny.toml"
    path.write_text(ARM, encoding="utf-8")
    asked = order(path, **COUNTS)
    store = Store.begin(folder / "run", asked)
    assert carry_out(store) == asked.blocks == 16
    return store


@pytest.fixture
def copy(small, tmp_path):
    """Return a copy of that run to spoil."""
    subprocess.run(["cp", "-r", small.folder, tmp_path / "run"], check=True)
    return tmp_path / "run"


def test_blocks_hold_what_the_study_finds(small, tmp_path):
    """Block by block or whole, every pose has the same figures to the bit, and counts are equal;
    sums differ by rounding alone.
    """
    path = tmp_path / "tiny.toml"
    path.write_text(ARM, encoding="utf-8")
    arm = small.order.read(0)
    whole = run(arm, sample_poses(arm, 64, seed=1), 20, 3, 1)
    records = [small.read(0, block) for block in range(small.order.blocks)]
    rows = np.concatenate([record.poses for record in records])
    kernel_columns = whole.per_pose.shape[1]
    np.testing.assert_array_equal(rows[:, :kernel_columns], whole.per_pose)
    np.testing.assert_array_equal(rows[:, kernel_columns : kernel_columns + 4], whole.accuracy)
    np.testing.assert_array_equal(rows[:, COLUMNS.index("worst_case")], whole.worst)
    np.testing.assert_array_equal(sum(record.histogram for record in records), whole.group_hist)
    np.testing.assert_allclose(
        sum(record.robots for record in records) / 64, whole.robot_means.mean(axis=0), rtol=1e-12
    )
    levels = rows[:, COLUMNS.index("bias_square") : COLUMNS.index("visit_square") + 1].sum(axis=0)
    np.testing.assert_allclose(levels, whole.tally.levels, rtol=1e-12)
    outcome = summarise(small)[0]
    assert outcome.rms == pytest.approx(np.sqrt(whole.tally.total / 64), rel=1e-12)
    assert outcome.figures["mean"].value == pytest.approx(
        whole.robot_means[:, :, 0].mean(), rel=1e-12
    )
    assert outcome.worst[0].error == whole.per_pose[:, COLUMNS.index("largest")].max()
    square = whole.per_pose[:, COLUMNS.index("mean_square")].mean()
    deviation = outcome.figures["standard_deviation"]
    assert deviation.value == pytest.approx(
        np.sqrt(square - outcome.figures["mean"].value ** 2), rel=1e-9
    )
    assert deviation.low < deviation.value < deviation.high


def test_quantiles_are_those_of_the_samples_within_the_bins(small):
    """The 95 % error read from integer counts lies within 0.4 % of that of all samples, drawn one
    by one.
    """
    from lostmotion.propagation.exact import draws_of
    from lostmotion.runs.blocks import matrix_of

    robots, visits = (
        axis.ravel() for axis in np.meshgrid(np.arange(20), np.arange(3), indexing="ij")
    )
    lengths = []
    for block in range(small.order.blocks):
        matrix = matrix_of(small.order, 0, block)
        first, last = small.order.span(block)
        for row in range(last - first):
            draws = draws_of(matrix, row, 1, first + row, robots, visits)
            lengths.append(np.linalg.norm(matrix.tool[row, 3:] @ draws, axis=0))
    found = summarise(small)[0].p95.value
    assert found == pytest.approx(
        np.quantile(np.concatenate(lengths), 0.95, method="inverted_cdf"), rel=0.004
    )


def test_anyone_can_open_the_blocks(small):
    """Zarr and xarray read the arrays as the store does, with dimensions named."""
    group = zarr.open_group(small.folder / "blocks.zarr", mode="r")
    record = small.read(0, 5)
    for name, value in record._asdict().items():
        np.testing.assert_array_equal(group[name][0, 5], value)
    assert group.attrs["seed"] == 1
    with xarray.open_zarr(small.folder / "blocks.zarr", consolidated=False, chunks=None) as found:
        assert found["poses"].dims[:2] == ("design", "block")
        assert int(found["histogram"].sum()) == 64 * 20 * 3


def test_a_record_comes_back_from_its_bytes(small):
    """Packing and unpacking change no bit, and bytes that claim another size are refused before
    they take room.
    """
    record = compute(small.order, 0, 3)
    packed = pack(record)
    for one, other in zip(record, unpack(small.order, packed), strict=True):
        np.testing.assert_array_equal(one, other)
    larger = pack(BlockRecord(np.zeros((5000, 5000)), *record[1:]))
    with pytest.raises(ValueError, match="another size"):
        unpack(small.order, {**packed, "poses": larger["poses"]})


@pytest.mark.parametrize(
    "victim", ["blocks.zarr/poses/c.0.3.0.0", "blocks.zarr/histogram/c.0.3.0.0", "ledger/0.3.json"]
)
@pytest.mark.parametrize("how", ["gone", "cut", "turned"])
def test_a_damaged_block_is_found_and_done_again(small, copy, victim, how):
    """A chunk or a line of the ledger that is gone, cut short or has one bit turned is computed
    again, and nothing else; bytes are as before.
    """
    path = copy / victim
    raw = bytearray(path.read_bytes())
    raw[len(raw) // 2] ^= 1
    path.unlink() if how == "gone" else path.write_bytes(
        raw[: len(raw) // 2] if how == "cut" else raw
    )
    (copy / "ledger" / "0.9.json.0123abcd.partial").write_text("{")
    with pytest.raises(LostmotionError, match="run the same `lostmotion sweep` again"):
        Store.open(copy).read(0, 3)
    assert carry_out(Store.begin(copy, small.order), 2) == 1
    assert tree(copy) == tree(small.folder)


def test_another_run_is_not_gone_on_with(small, copy):
    """Other counts, another seed or another arm are refused, each named, and nothing in the folder
    is touched.
    """
    before = tree(copy)
    for change, word in (
        ({"robots": 21}, "robots: 20 there, 21 here"),
        ({"seed": 2}, "seed: 1 there, 2 here"),
    ):
        with pytest.raises(OutputExistsError, match=word):
            Store.begin(copy, small.order.model_copy(update=change))
    other = {**small.order.files, "tiny.toml": ARM.replace("2 kg", "3 kg")}
    with pytest.raises(OutputExistsError, match=r"tiny\.toml: another text"):
        Store.begin(copy, small.order.model_copy(update={"files": other}))
    older = small.order.model_copy(update={"made_with": {**small.order.made_with, "numba": "0.1"}})
    with pytest.raises(OutputExistsError, match=r"numba: .* there, 0\.1 here"):
        Store.begin(copy, older)
    assert tree(copy) == before


def test_folders_of_others_are_left_alone(small, tmp_path):
    """A folder that holds something else, a file and a link are refused."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years")
    (tmp_path / "link").symlink_to(tmp_path / "mine")
    for name in ("mine", "link", "mine/thesis.tex"):
        with pytest.raises(OutputExistsError):
            Store.begin(tmp_path / name, small.order)
    assert tree(tmp_path / "mine").keys() == {"thesis.tex"}
    with pytest.raises(LostmotionError, match=r"no run: no run\.json in it"):
        Store.open(tmp_path / "mine")


def test_only_one_run_works_in_a_folder(small, copy):
    """A second process that comes to the same folder is refused while the first is at work."""
    pytest.importorskip("fcntl")
    store = Store.begin(copy, small.order)
    with store.locked(), pytest.raises(LostmotionError, match="another process"):
        carry_out(Store.begin(copy, small.order))


def test_a_run_waits_for_one_that_only_reads_the_order(small, copy):
    """Whoever holds the lock for a moment, to find that the folder is another run's, does not stop
    the run whose folder it is.
    """
    pytest.importorskip("fcntl")
    store, held = Store.begin(copy, small.order), threading.Event()

    def reads_the_order():
        with lock(copy):
            held.set()
            time.sleep(0.2)

    reader = threading.Thread(target=reads_the_order)
    reader.start()
    held.wait()
    assert carry_out(store) == 0
    reader.join()


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a system that forks")
def test_twenty_concurrent_starts_never_mix(arm, tmp_path):
    """Of two runs of different seeds that start at the same moment in a new folder one is refused,
    and the folder holds the other's order and figures alone, twenty times.
    """
    ran = subprocess.run(
        [sys.executable, HERE / "together.py", arm, tmp_path, "20", "7"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout == "20 right, 20 refused\n"


def test_a_run_whose_folder_became_another_ones_is_not_carried_out(small, tmp_path):
    """Where run.json states another order by the time that the work begins, nothing is computed and
    no report is written beside it.
    """
    mine = Store.begin(tmp_path / "run", small.order)
    shutil.rmtree(tmp_path / "run")
    Store.begin(tmp_path / "run", small.order.model_copy(update={"seed": 2}))
    with pytest.raises(OutputExistsError, match="seed: 2 there, 1 here"):
        carry_out(mine)
    with pytest.raises(OutputExistsError, match="seed: 2 there, 1 here"):
        mine.keep("result.json", b"{}")
    assert not (tmp_path / "run" / "ledger").exists()


def test_figures_do_not_outlive_an_edited_order(small, copy):
    """After an edit of run.json that keeps every size, the stored blocks are of another order: they
    are not read, but computed again.
    """
    edited = small.order.model_copy(update={"seed": 2})
    (copy / "run.json").write_bytes(edited.text())
    for name in ("blocks.zarr/zarr.json",):
        path = copy / name
        path.write_text(path.read_text().replace('"seed": 1', '"seed": 2'))
    with pytest.raises(LostmotionError, match=r"of another job than its run\.json"):
        Store.open(copy).read(0, 0)
    done = lostmotion("replay", copy, cwd=copy.parent)
    assert done.returncode == 2
    assert "of another job" in done.stderr
    assert carry_out(Store.begin(copy, edited)) == edited.blocks


def test_a_killed_process_leaves_no_lock(copy, small):
    """A process that dies by SIGKILL while it holds the lock keeps nobody else out."""
    said = (
        "import sys, time; from pathlib import Path; from lostmotion.runs.lock import lock\n"
        "with lock(Path(sys.argv[1])): print('held', flush=True); time.sleep(600)"
    )
    child = subprocess.Popen([sys.executable, "-c", said, copy], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "held\n"
    with pytest.raises(LostmotionError, match="another process is writing"):
        carry_out(Store.begin(copy, small.order))
    child.kill()
    child.communicate()
    assert carry_out(Store.begin(copy, small.order)) == 0


def spoiled(copy, change):
    """Change the first block of a run and sign it with a valid checksum, as a stranger would."""
    store = Store.open(copy)
    record = BlockRecord(*(np.array(each) for each in store.read(0, 0)))
    change(record)
    store.write(0, 0, pack(record))
    return store


@pytest.mark.parametrize(
    "change",
    [
        lambda record: record.poses.__setitem__((0, COLUMNS.index("largest_robot")), 10_000.0),
        lambda record: record.poses.__setitem__((0, COLUMNS.index("largest_visit")), -1.0),
        lambda record: record.poses.__setitem__((0, COLUMNS.index("largest_robot")), 0.5),
        lambda record: record.poses.__setitem__((0, COLUMNS.index("mean")), np.nan),
        lambda record: record.poses.__setitem__((1, COLUMNS.index("largest")), -1e300),
        lambda record: record.poses.__setitem__((1, COLUMNS.index("largest")), np.inf),
        lambda record: record.poses.__setitem__((1, COLUMNS.index("worst_case")), np.nan),
        lambda record: record.poses.__setitem__((1, COLUMNS.index("worst_case")), -1.0),
        lambda record: record.histogram.__setitem__((0, 0), -(2**62)),
        lambda record: record.histogram.__setitem__((0, 0), 2**62),
        lambda record: record.robots.__setitem__((0, 0), np.inf),
        lambda record: record.parts.__setitem__((0, 0), np.nan),
    ],
)
def test_nonsense_with_a_valid_checksum_is_not_read(small, copy, change):
    """Robots out of range, counts below zero and lengths that are no numbers are no figures of a
    run: one message, and they are computed again.
    """
    store = spoiled(copy, change)
    with pytest.raises(LostmotionError, match="block 0 of design 0"):
        store.read(0, 0)
    with pytest.raises(LostmotionError, match="block 0 of design 0"):
        summarise(store)
    assert carry_out(Store.begin(copy, small.order)) == 1
    assert tree(copy) == tree(small.folder)


def test_a_replay_that_does_not_reproduce_fails(copy):
    """A plausible figure, under a valid checksum, that differs from that of its pose and draws is
    reported in the headline, with exit code 1.
    """
    spoiled(copy, lambda record: record.poses.__setitem__((0, COLUMNS.index("largest")), 0.5))
    done = lostmotion("replay", copy, cwd=copy.parent)
    assert done.returncode == 1, done.stderr
    assert "an error is not reproduced" in done.stderr
    assert "The stored figure is not reproduced" in done.stdout
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "place",
    [
        "ledger",
        "blocks.zarr/poses",
        "ledger/0.0.json",
        "blocks.zarr/poses/c.0.0.0.0",
        "run.json",
        "run.lock",
        "blocks.zarr/zarr.json",
    ],
)
def test_a_file_where_a_folder_belongs_and_the_reverse_are_one_message(small, copy, place):
    """Whatever stands in the wrong place in a store: a message with the path, no traceback."""
    path = copy / place
    if path.is_dir():
        path.rename(copy.parent / "aside")
        path.write_text("a file")
    else:
        path.unlink()
        path.mkdir()
    with pytest.raises(LostmotionError):
        carry_out(Store.begin(copy, small.order))
    with suppress(LostmotionError):
        Store.open(copy).read(0, 0)


@pytest.mark.parametrize(
    "name",
    [
        "../../evil.toml",
        "/tmp/evil.toml",  # noqa: S108
        "a/../../evil.toml",
        "..\\evil.toml",
        "C:evil.toml",
        "evil.py",
        "a\nb.toml",
    ],
)
def test_an_order_stays_in_its_folder(small, name):
    """An order from a stranger that would lay files elsewhere is refused."""
    said = json.loads(small.order.text())
    said["files"][name] = "x"
    with pytest.raises(LostmotionError, match=r"not a readable run\.json"):
        order_of(json.dumps(said).encode())


@pytest.mark.parametrize(
    "change",
    [
        {"block": 2**40},
        {"block": 16384, "robots": 1_000_000},
        {"robots": 1_000_000, "visits": 10_000, "block": 1},
        {"robots": 2**40},
        {"poses": 2**60},
        {"poses": 63},
        {"sets": 7},
        {"law": "given"},
        {"law": "grid"},
        {"sets": 1},
        {"arm": "other.toml"},
        {"axes": [{"key": f"k{k}", "values": list(range(1000))} for k in range(4)]},
        {"axes": [{"key": "", "values": []}]},
        {"seed": -1},
        {"surprise": 1},
        {"made_with": {}},
        {"made_with": {"lostmotion": "1"}},
        {"axes": [{"key": "payload.mass", "values": [math.nan]}]},
        {"axes": [{"key": "payload.mass", "values": [math.inf]}]},
        {"axes": [{"key": "payload.mass", "values": ["\ud800"]}]},
        {"parts": ["\udcff"]},
        {"files": {"tiny.toml": "\ud800"}},
        {"arm": "ä" * 195 + ".toml", "files": {"ä" * 195 + ".toml": ""}},
    ],
)
def test_an_order_that_cannot_be_is_refused(small, change):
    """Counts beyond every run, grids of a million million designs and unknown keys end in a
    message, not in memory.
    """
    said = {**json.loads(small.order.text()), **change}
    with pytest.raises(LostmotionError, match=r"not a readable run\.json"):
        order_of(json.dumps(said).encode())


def test_a_file_that_is_another_ones_folder_is_one_message(small):
    """An order that lays one file out inside another, and one whose text is no arm, are refused,
    each in one message.
    """
    said = json.loads(small.order.text())
    said["files"]["tiny.toml/inner.toml"] = ""
    with pytest.raises(LostmotionError, match="cannot be written to a temporary"):
        order_of(json.dumps(said).encode()).read(0)


@pytest.mark.parametrize("poses", [7, 10, 63, 65])
def test_a_grid_of_a_count_that_no_grid_has_is_refused(small, copy, poses):
    """Two joints make squares; another count in a damaged order is one message, from Python and
    with exit code 2, before a block is read.
    """
    said = {**json.loads(small.order.text()), "law": "grid", "sets": 1, "poses": poses}
    (copy / "run.json").write_text(json.dumps(said))
    with pytest.raises(
        LostmotionError, match=f"a grid of {poses} poses, and an arm with 2 moving joints has none"
    ):
        Store.open(copy)
    with pytest.raises(LostmotionError, match=f"a grid of {poses} poses"):
        poses_between(small.order.read(0), "grid", poses, 1, 0, poses)


def test_the_command_reports_a_damaged_grid_in_one_message(small, copy):
    """As above, from the command line."""
    said = {**json.loads(small.order.text()), "law": "grid", "sets": 1, "poses": 10}
    (copy / "run.json").write_text(json.dumps(said))
    done = lostmotion("replay", copy, cwd=copy.parent)
    assert done.returncode == 2
    assert "a grid of 10 poses" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "text", [b"", b"[" * 100_000, b"\xff", b"null", b'{"poses": 1' + b"0" * 5000 + b"}"]
)
def test_what_is_no_order_is_refused(text):
    """No JSON, JSON nested without end, and numbers without end are refused with a word."""
    with pytest.raises(LostmotionError, match=r"not a readable run\.json"):
        order_of(text)


def test_hostile_metadata_and_links_are_not_believed(small, copy):
    """Metadata that claim other chunks, or a link in place of a folder, are refused; a run that
    goes on mends the first.
    """
    path = copy / "blocks.zarr" / "poses" / "zarr.json"
    said = json.loads(path.read_text())
    said["chunk_grid"]["configuration"]["chunk_shape"] = [1, 1, 2**40, 28]
    path.write_text(json.dumps(said))
    with pytest.raises(LostmotionError, match="not what the run's order says"):
        Store.open(copy)
    assert carry_out(Store.begin(copy, small.order)) == 0
    assert tree(copy) == tree(small.folder)
    (copy / "ledger").rename(copy.parent / "elsewhere")
    (copy / "ledger").symlink_to(copy.parent / "elsewhere")
    with pytest.raises(LostmotionError, match="a link"):
        Store.open(copy)
    with pytest.raises(LostmotionError, match="a link"):
        Store.begin(copy, small.order)


def test_a_chunk_that_is_a_link_or_a_pipe_is_not_read(small, copy):
    """Whatever stands in a chunk's place and is no regular file counts as not done."""
    chunk = copy / "blocks.zarr" / "parts" / "c.0.0.0.0"
    real = chunk.read_bytes()
    (copy.parent / "real").write_bytes(real)
    for make in (lambda: chunk.symlink_to(copy.parent / "real"), lambda: os.mkfifo(chunk)):
        chunk.unlink()
        make()
        with pytest.raises(LostmotionError, match="block 0 of design 0"):
            Store.open(copy).read(0, 0)
    assert carry_out(Store.begin(copy, small.order)) == 1
    assert chunk.read_bytes() == real
    assert (copy.parent / "real").read_bytes() == real


def test_every_pose_stands_in_one_block():
    """Spans of the blocks follow each other without gap or overlap, and none reaches over two sets,
    also where blocks do not fit.
    """
    for poses, sets, block in ((64, 8, 3), (64, 8, 8), (243, 1, 50), (8, 8, 1)):
        asked = Order.model_construct(poses=poses, sets=sets, block=block)
        spans = [asked.span(k) for k in range(asked.blocks)]
        assert [first for first, _ in spans[1:]] == [last for _, last in spans[:-1]]
        assert (spans[0][0], spans[-1][1]) == (0, poses)
        each = poses // sets
        assert all(
            first // each == (last - 1) // each == asked.set_of(k)
            for k, (first, last) in enumerate(spans)
        )
        assert max(last - first for first, last in spans) <= block


def killed(arm, folder, kills, seed):
    """Kill a run so often and go on with it; gives the folder that is done at last."""
    ran = subprocess.run(
        [sys.executable, HERE / "killed.py", arm, folder, str(kills), str(seed)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.startswith(f"{kills} killed")
    return [folder, *folder.parent.glob(f"{folder.name}.done*")]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a system that forks")
def test_a_run_killed_ten_times_goes_on_to_the_same_bytes(arm, tmp_path):
    """Killed ten times at random moments and resumed on 1, 2 and 7 workers, a run leaves the same
    files as one that was left alone.
    """
    whole = Store.begin(tmp_path / "whole", order(arm, **COUNTS))
    carry_out(whole, 2)
    for found in killed(arm, tmp_path / "killed", kills=10, seed=5):
        assert tree(found) == tree(whole.folder)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a system that forks")
def test_memory_does_not_grow_with_the_poses(tmp_path):
    """Ten times as many poses take at most a tenth more memory at the peak, summing up included."""
    path = tmp_path / "tiny.toml"
    path.write_text(ARM, encoding="utf-8")
    ran = subprocess.run(
        [sys.executable, HERE / "peak.py", path, tmp_path / "p", "2048", "20480"],
        capture_output=True,
        text=True,
        check=True,
    )
    few, many = map(float, ran.stdout.split())
    assert many < 1.1 * few
