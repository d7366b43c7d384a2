"""Compiled kernels that are kept: read again, compiled again where the source has changed or a file
is damaged, and bounded in number.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from lostmotion import compile_cache, source_hash
from lostmotion.compiled import compiled
from lostmotion.error_model import draw_kernel

ROOT = Path(__file__).parents[1]
WORD = np.uint64(5)
KERNEL = '''
from lostmotion.compiled import compiled
from lostmotion.laws.probe_constant import FACTOR

@compiled
def scaled(x):
    """Return a multiple."""
    return FACTOR * x
'''


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return the folder that kernels are kept in."""
    monkeypatch.setattr(compile_cache, "folder_of", lambda _: tmp_path / "kernels" / "one")
    return tmp_path / "kernels" / "one"


def run() -> bool:
    """Return whether a kernel was read, not compiled, as in a new process; its result is right in
    any case.
    """
    kernel = compiled(draw_kernel.mix.py_func)
    with np.errstate(over="ignore"):
        assert kernel(WORD) == draw_kernel.mix.py_func(WORD)
    return sum(kernel.stats.cache_hits.values()) == 1


def test_a_kernel_is_compiled_once(folder):
    """The second process reads what the first one wrote."""
    assert not run()
    assert run()
    assert len(list(folder.iterdir())) == 1


def as_folder(file):
    """Put a folder in the place of a file."""
    file.unlink()
    (file / "something").mkdir(parents=True)


def without_folder(file):
    """Put a file in the place of the folder."""
    shutil.rmtree(file.parent)
    file.parent.write_text("")


DAMAGES = {
    "empty": lambda file: file.write_bytes(b""),
    "half": lambda file: file.write_bytes(file.read_bytes()[: file.stat().st_size // 2]),
    "longer": lambda file: file.write_bytes(file.read_bytes() + b"\0"),
    "bit": lambda file: file.write_bytes(
        (raw := file.read_bytes())[:-200] + bytes([raw[-200] ^ 1]) + raw[-199:]
    ),
    "checksum": lambda file: file.write_bytes(b"\0" + file.read_bytes()[1:]),
    "text": lambda file: file.write_text("nothing of the kind"),
    "folder": as_folder,
    "no folder": without_folder,
    "dangling link": lambda file: (file.unlink(), file.symlink_to(file.parent / "nowhere")),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_file_is_compiled_again_and_replaced(folder, damage):
    """Whatever lies in its place, the kernel returns the right number, and the next process reads a
    whole file.
    """
    run()
    (file,) = folder.iterdir()
    damage(file)
    assert not run()
    assert run()
    assert [each.name for each in folder.iterdir()] == [file.name]


def test_the_file_of_another_kernel_is_not_read(folder):
    """A file is bound to its function and signature: one with the content of another is compiled
    again.
    """
    run()
    compiled(draw_kernel.mix.py_func)(np.uint32(5))
    one, other = folder.iterdir()
    contents = one.read_bytes(), other.read_bytes()
    other.write_bytes(contents[0])
    one.write_bytes(contents[1])
    assert not run()


def test_nothing_is_kept_of_source_that_changed_under_the_process(folder, monkeypatch):
    """What is in memory is then not what lies on the disk."""
    monkeypatch.setattr(
        source_hash, "_AT_START", dict.fromkeys(source_hash._AT_START, (0, 0, 0, 0))
    )
    assert not run()
    assert not folder.exists()
    source_hash.source_hash.cache_clear()
    assert source_hash.source_hash("laws") is None
    source_hash.source_hash.cache_clear()


def test_a_folder_that_cannot_be_written_to_costs_only_time(folder, monkeypatch):
    """As on a full disk."""

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tempfile.NamedTemporaryFile", full)
    assert not run()
    assert not run()
    assert list(folder.iterdir()) == []


def test_folders_of_other_versions_are_deleted(tmp_path, folder):
    """The least recently used go first."""
    for k in range(40):
        (tmp_path / "kernels" / f"old-{k}").mkdir(parents=True)
        os.utime(tmp_path / "kernels" / f"old-{k}", (k, k))
    run()
    assert {each.name for each in folder.parent.iterdir()} == {
        "one",
        *(f"old-{k}" for k in range(41 - compile_cache._MOST, 40)),
    }


def test_the_key_covers_what_a_kernel_can_see():
    """The layers that a hash covers are those below it by the contract of imports, and every kernel
    is of one of them.
    """
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
        "importlinter"
    ]["contracts"][0]["layers"]
    rooms = [room.strip() for line in contract for room in line.replace("|", ":").split(":")]
    order = [
        room.removeprefix("lostmotion.")
        for room in reversed(rooms)
        if (ROOT / "src" / room.replace(".", "/")).is_dir()
    ]
    assert order[: len(source_hash.LAYERS)] == list(source_hash.LAYERS)
    kernels = {
        path.relative_to(ROOT / "src" / "lostmotion").parts[0]
        for path in (ROOT / "src").rglob("*_kernel.py")
    }
    assert kernels <= set(source_hash.LAYERS)
    assert len({source_hash.source_hash(layer) for layer in source_hash.LAYERS}) == len(
        source_hash.LAYERS
    )


def test_no_function_is_cached_by_numba_itself():
    """Its cache does not see a change of another file."""
    assert [
        path
        for path in (ROOT / "src").rglob("*.py")
        if "cache=True" in path.read_text(encoding="utf-8")
    ] == []


def test_a_changed_constant_of_another_file_changes_the_result(tmp_path):
    """Even where the file keeps its size and its time; and the old result comes back with the old
    constant, without compiling.
    """
    package = tmp_path / "lostmotion"
    shutil.copytree(
        ROOT / "src" / "lostmotion", package, ignore=shutil.ignore_patterns("__pycache__")
    )
    constant = package / "laws" / "probe_constant.py"
    (package / "laws" / "probe_kernel.py").write_text(KERNEL)
    environment = {
        **os.environ,
        "PYTHONPATH": str(tmp_path),
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    program = (
        "from lostmotion.laws.probe_kernel import scaled; print(scaled(1.0), "
        "len(scaled.stats.cache_hits))"
    )

    def result(factor: str) -> str:
        constant.write_text(f"FACTOR = {factor}\n")
        os.utime(constant, (1e9, 1e9))
        return subprocess.run(
            [sys.executable, "-c", program],
            env=environment,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        ).stdout

    results = [result(factor) for factor in ("2.0", "3.0", "2.0")]
    assert results == ["2.0 0\n", "3.0 0\n", "2.0 1\n"]


_BITS = """
import hashlib
import numpy as np
from lostmotion.laws.cycloid.bodies import ElasticBody, flexibility
from lostmotion.laws.cycloid.contact import Flanks, Supports, load_sharing
from lostmotion.laws.cycloid.stage import Stage
from lostmotion.laws.rolling.equilibrium import shaft_equilibrium
from lostmotion.laws.rolling.rows import BallRow, CrossedRow, RowSeat
drawn = np.random.default_rng(1)
stage, flanks, crank = Stage(0.05, 0.003, 0.0012, 20), Flanks(0.01, 1.15e11, bending=2e-9), np.array([0.0, 0.05, 1.7])
bodies = flexibility(stage, ElasticBody("planet", 0.02, 210e9, 0.3), 0.01, crank)
gaps = drawn.normal(1e-6, 2e-6, (3, 30, 20))
found = load_sharing(stage, flanks, [-100.0, -3.0, 20.0, 200.0], crank, gaps, Supports(3e8, 1e6, 0.03), bodies=bodies)
print(hashlib.sha256(found.rotation.tobytes() + found.forces.tobytes() + found.stiffness.tobytes()).hexdigest())
ball = BallRow(count=15, ball=9.5e-3, pitch=60e-3, contact_angle=0.4)
pair = RowSeat(ball, 0.02, preload_shift=5e-6), RowSeat(ball, -0.02, mirrored=True, preload_shift=5e-6)
load = drawn.normal(size=(100, 5)) * [2000, 2000, 1000, 30, 30]
for seats in (pair, (RowSeat(CrossedRow(count=40, length=6e-3, pitch=80e-3)),)):
    found = shaft_equilibrium(seats, load, 1e-6)
    print(hashlib.sha256(found.displacement.tobytes() + found.stiffness.tobytes()).hexdigest())
"""


@pytest.mark.slow
def test_kernels_from_the_cache_give_the_bits_of_those_just_compiled(tmp_path):
    """Bearings and drives with elastic discs: their kernels fuse products and sums."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    compiled_now, from_cache = (
        subprocess.run(
            [sys.executable, "-c", _BITS],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for _ in range(2)
    )
    assert compiled_now == from_cache
    assert len(set(compiled_now.split())) == 3
