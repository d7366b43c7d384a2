"""What does keeping blocks cost, against the same study held in memory? Processor time, median of
three, in one process and on one thread.

    python benchmarks/big_run.py [POSES]

Prints seconds for each, bytes kept for each pose, and how long a finished run takes to be checked
and summed up.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from pathlib import Path

from lostmotion.error_model.poses import sample_poses
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.runs.execute import carry_out, order
from lostmotion.runs.store import Store
from lostmotion.runs.summary import summarise

ARM = Path(__file__).parents[1] / "examples" / "z-arm.toml"
ROBOTS, VISITS = 1000, 30


def seconds(what):
    started = time.process_time()
    what()
    return time.process_time() - started


def main(poses):
    asked = order(ARM, poses=poses, robots=ROBOTS, visits=VISITS, seed=1)
    arm = asked.read(0)
    chosen = sample_poses(arm, poses, seed=1)
    times = {"study in memory": [], "run with its store": [], "check and sum up": []}
    run(arm, sample_poses(arm, 8, seed=1), ROBOTS, VISITS, 1)  # compiled
    for _ in range(3):
        with tempfile.TemporaryDirectory() as name:
            times["study in memory"].append(seconds(lambda: run(arm, chosen, ROBOTS, VISITS, 1)))
            store = Store.begin(Path(name) / "run", asked)
            times["run with its store"].append(seconds(lambda store=store: carry_out(store)))
            times["check and sum up"].append(
                seconds(lambda store=store: (store.done(), summarise(store)))
            )
            size = sum(path.stat().st_size for path in store.folder.rglob("*") if path.is_file())
    print(
        f"{len(chosen)} poses x {ROBOTS} robots x {VISITS} visits, blocks of {asked.block} "
        f"poses; {size / len(chosen):.0f} bytes kept for each pose"
    )
    for name, found in times.items():
        print(f"{name:20} {statistics.median(found):7.2f} s")


main(int(sys.argv[1]) if len(sys.argv) > 1 else 8192)
