"""Blocks computed by the workers of a Dask cluster, one of which dies."""

from __future__ import annotations

import subprocess
import sys
import time

import pytest

from lostmotion.errors import InputError
from lostmotion.runs.execute import carry_out, order
from lostmotion.runs.store import Store
from lostmotion.runs.workers import check_address, cluster
from tests.command import carried_out_by_process as lostmotion
from tests.runs.conftest import tree

pytest.importorskip("distributed", reason="Dask is not installed: pip install 'lostmotion[dask]'")
psutil = pytest.importorskip("psutil", reason="comes with Dask")

COUNTS = {"poses": 32, "robots": 20, "visits": 3, "seed": 1, "block": 1}


def blocks_done(folder):
    """Count the blocks that the ledger lists."""
    return len(list((folder / "ledger").glob("*.json")))


def test_what_is_no_address_is_refused_at_once():
    """A word without a port is no scheduler: it is refused before anything connects or is
    written.
    """
    with pytest.raises(InputError, match="dask"):
        check_address("foo")


@pytest.mark.parametrize("address", ["zzz://x:1", "tcp://no.such.host.invalid:8786"])
def test_an_address_without_a_scheduler_is_reported_at_once(address):
    """A scheme or a host that cannot be: one message."""
    with pytest.raises(InputError, match="dask") as caught, cluster(address):
        pass
    assert address in caught.value.problems[0].found


def test_a_scheduler_that_is_not_there_leaves_nothing(arm, tmp_path):
    """One message within seconds, exit code 2, and no folder that another command would go on
    with.
    """
    begun = time.monotonic()
    done = lostmotion(
        "sweep",
        arm.name,
        "--poses",
        "8",
        "--robots",
        "4",
        "--dask",
        "tcp://127.0.0.1:1",
        "--out",
        "run",
        cwd=tmp_path,
    )
    assert time.monotonic() - begun < 60  # most of it is the start of Python on a busy machine
    assert done.returncode == 2
    assert "--dask" in done.stderr
    assert "local:N" in done.stderr
    assert "Traceback" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == [arm.name]


DIES = """
import subprocess, sys
from pathlib import Path
from lostmotion.errors import LostmotionError
from lostmotion.runs import workers
from lostmotion.runs.execute import carry_out, order
from lostmotion.runs.store import Store

scheduler = subprocess.Popen(
    [sys.executable, "-c", "import asyncio; from distributed import Scheduler\\nasync def run():\\n"
     "    async with Scheduler(host='127.0.0.1', port=0, dashboard=False) as it:\\n        print(it.address, flush=True); await it.finished()\\n"
     "asyncio.run(run())"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
workers._SECONDS_TO_CONNECT = 8
asked = order(Path(sys.argv[1]), poses=64, robots=20, visits=3, seed=1, block=1)
try:
    with workers.cluster(scheduler.stdout.readline().strip()) as connected:
        scheduler.kill()
        scheduler.wait()
        carry_out(Store.begin(Path(sys.argv[2]), asked), 1, connected)
except LostmotionError as error:
    print(error)
"""


@pytest.mark.slow
def test_a_scheduler_that_dies_early_is_one_message(arm, tmp_path):
    """Killed before it hands out its first block: one message that the same command goes on, no
    traceback of ours or of Dask's.
    """
    done = subprocess.run(
        [sys.executable, "-c", DIES, arm, tmp_path / "run"],
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("the Dask scheduler is gone")
    assert "the same command resumes" in done.stdout
    assert "Traceback" not in done.stderr


# The command without the plots of its report, which go into no file that is compared.
UNDRAWN = """
from lostmotion.analyses.sweep.page import Sweep
from lostmotion.cli import main
if __name__ == "__main__":
    Sweep.plots = ()
    main()
"""


@pytest.mark.slow
def test_a_killed_worker_changes_no_byte(arm, tmp_path):
    """On two worker processes, one of them killed in mid-run, a run leaves the same bytes as on a
    thread.
    """
    asked = order(arm, **COUNTS)
    total = asked.designs * asked.blocks
    words = [word for name, value in COUNTS.items() for word in (f"--{name}", str(value))]
    command = [
        sys.executable,
        "-c",
        UNDRAWN,
        "sweep",
        arm.name,
        *words,
        "--dask",
        "local:2",
        "--out",
        "dask",
        "--quiet",
    ]
    child = subprocess.Popen(
        command, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
    )
    folder = tmp_path / "dask"
    deadline = time.monotonic() + 240
    while blocks_done(folder) < 10 and child.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    workers = [
        each
        for each in psutil.Process(child.pid).children(recursive=True)
        if "spawn_main" in " ".join(each.cmdline())
    ]
    listening = [
        each
        for each in workers
        for place in each.net_connections("inet")
        if place.status == "LISTEN" and place.laddr.ip != "127.0.0.1"
    ]
    workers[0].kill()
    assert blocks_done(folder) < total
    _, said = child.communicate(timeout=240)
    assert child.returncode == 0, said
    assert len(workers) == 2
    assert not listening, "a worker can be reached from other machines"
    whole = Store.begin(tmp_path / "threads", asked)
    carry_out(whole, 2)
    found = tree(folder)
    assert {found.pop(name) for name in ("report.html", "result.json")}
    assert found == tree(whole.folder)
