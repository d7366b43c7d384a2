"""Start two runs of different seeds in one new folder at the same moment, again and again, and look
whose figures stand under whose order.

A process by itself, `python together.py ARM FOLDER TRIALS SEED`, so that it can fork. Prints how
many trials ended with one of the two orders and its own figures alone, and how often the second was
refused.
"""

from __future__ import annotations

import functools
import os
import random
import shutil
import sys
import time
from pathlib import Path

import numpy as np
import zarr  # noqa: F401 - loaded before the fork, so that both children begin at once

from lostmotion.errors import LostmotionError
from lostmotion.runs import workers
from lostmotion.runs.blocks import compute
from lostmotion.runs.checkpoint import read_regular
from lostmotion.runs.execute import carry_out, order
from lostmotion.runs.job import order_of
from lostmotion.runs.store import Store

COUNTS = {"poses": 16, "robots": 20, "visits": 2, "block": 2}
REFUSED = 2


def main() -> None:
    """Start together, look, and start again."""
    path, above, trials, seed = (
        Path(sys.argv[1]),
        Path(sys.argv[2]),
        int(sys.argv[3]),
        int(sys.argv[4]),
    )
    orders = [order(path, **COUNTS, seed=each) for each in (1, 2)]
    # What a block holds follows from its order: computed once here, it is written by every child.
    compute_packed = workers.compute_packed = functools.cache(workers.compute_packed)
    for asked in orders:
        Store.begin(above / "warm", asked)  # loads what the first store of a process loads
        shutil.rmtree(above / "warm")
        for design, block in np.ndindex(asked.designs, asked.blocks):
            compute_packed(asked.text(), design, block)
    own = [
        [compute(asked, 0, block).poses.tobytes() for block in range(asked.blocks)]
        for asked in orders
    ]
    chance = random.Random(seed)  # noqa: S311 - moments, no secrets
    right = refused = 0
    for trial in range(trials):
        folder = above / f"run{trial}"
        begin = time.monotonic() + 0.02
        children = [_child(folder, asked, begin + chance.uniform(0.0, 0.005)) for asked in orders]
        codes = [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children]
        refused += codes.count(REFUSED)
        text = read_regular(folder / "run.json", 1_000_000)
        there = order_of(text or b"")
        mine = own[orders.index(there)]
        store = Store.open(folder)
        found = [store.read(0, block).poses.tobytes() for block in range(there.blocks)]
        right += found == mine and sorted(codes) == [0, REFUSED] and codes[orders.index(there)] == 0
    sys.stdout.write(f"{right} right, {refused} refused\n")


def _child(folder: Path, asked: object, begin: float) -> int:
    child = os.fork()
    if child == 0:
        time.sleep(max(begin - time.monotonic(), 0.0))
        try:
            carry_out(Store.begin(folder, asked))
        except LostmotionError:
            os._exit(REFUSED)
        os._exit(0)
    return child


main()
