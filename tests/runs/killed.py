"""Start a run in a child of its own again and again, kill it at random moments, and go on with
other numbers of workers until it is done.

A process by itself, `python killed.py ARM FOLDER KILLS SEED`: everything is loaded and compiled and
no thread has begun, so that it can fork. Prints how often a child was killed with its work
unfinished, and how many blocks each left behind.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import time
from pathlib import Path

import zarr  # noqa: F401 - loaded before the fork, so that a child's time is its work's

from lostmotion.runs.blocks import compute_packed
from lostmotion.runs.execute import carry_out, order
from lostmotion.runs.store import Store

COUNTS = {"poses": 64, "robots": 20, "visits": 3, "seed": 1, "block": 4}
WORKERS = (1, 2, 7)


def main() -> None:
    """Kill, go on, kill."""
    path, folder, kills, seed = (
        Path(sys.argv[1]),
        Path(sys.argv[2]),
        int(sys.argv[3]),
        int(sys.argv[4]),
    )
    asked = order(path, **COUNTS)
    for design in range(asked.designs):
        compute_packed(asked.text(), design, 0)
    chance = random.Random(seed)  # noqa: S311 - moments, no secrets
    left = []
    # The longest that a child is left alone grows: so that the first kills fall into its
    # beginnings, and the run is done at last.
    for attempt in range(10 * kills):
        child = os.fork()
        if child == 0:
            carry_out(Store.begin(folder, asked), WORKERS[attempt % len(WORKERS)])
            os._exit(0)
        if len(left) < kills:
            time.sleep(chance.uniform(0.0, 0.3 * (1 + attempt % 4)))
            os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        if os.WIFSIGNALED(status):
            left.append(sum(1 for _ in (folder / "ledger").glob("*.json")))
        elif os.WEXITSTATUS(status):
            sys.exit(f"a child failed with {status}")
        elif len(left) >= kills:
            break
        else:  # done too early: start again in another folder
            folder.rename(folder.with_name(f"{folder.name}.done{attempt}"))
    sys.stdout.write(f"{len(left)} killed, leaving {left}\n")


main()
