"""How much memory do runs of so many poses take at their peak? `python peak.py ARM FOLDER POSES…`
prints MB, each run in a child of its own.
"""

from __future__ import annotations

import os
import resource
import sys
from pathlib import Path

import zarr  # noqa: F401 - loaded before the fork, so that children differ by their work alone

from lostmotion.runs.blocks import compute_packed
from lostmotion.runs.execute import carry_out, order
from lostmotion.runs.store import Store
from lostmotion.runs.summary import summarise

COUNTS = {"robots": 20, "visits": 2, "seed": 1, "block": 256}
path, folder = Path(sys.argv[1]), Path(sys.argv[2])
first = order(path, poses=256, **COUNTS)
compute_packed(first.text(), 0, 0)
for poses in map(int, sys.argv[3:]):
    child = os.fork()
    if child == 0:
        store = Store.begin(
            folder.with_name(f"{folder.name}{poses}"), order(path, poses=poses, **COUNTS)
        )
        carry_out(store, 2)
        summarise(store)
        sys.stdout.write(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.1f}\n")
        sys.stdout.flush()
        os._exit(0)
    if os.waitpid(child, 0)[1]:
        sys.exit("a child failed")
