"""What does it cost to settle an arm under its loads, beside a study at the same poses?

    python benchmarks/settled.py [--arm examples/z-arm.toml] [--poses 10000]

Processor time, best of three, warm. The count of evaluations of all deflections is exact: it does
not depend on the machine.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import lostmotion
from lostmotion.mechanism.state import states_of

EXAMPLE = Path(__file__).parent.parent / "examples" / "z-arm.toml"


def seconds(what, repeats=3) -> float:
    times = []
    for _ in range(repeats):
        start = time.process_time()
        what()
        times.append(time.process_time() - start)
    return min(times)


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--arm", default=EXAMPLE)
    asked.add_argument("--poses", type=int, default=10_000)
    given = asked.parse_args()
    arm = lostmotion.read(given.arm)
    q = lostmotion.sample_poses(arm, given.poses).q
    rounds = [state.settled().equilibrium.rounds for _, state in states_of(arm, q)]
    settled = seconds(lambda: [state.settled() for _, state in states_of(arm, q)])
    commanded = seconds(lambda: list(states_of(arm, q)))
    whole = seconds(lambda: lostmotion.study(arm, given.poses), 1)
    own = settled - commanded
    mean = sum(each.sum() for each in rounds) / len(q)
    most = max(map(max, rounds))
    print(f"{len(q)} poses of {arm.name}: {mean:.2f} evaluations per pose, most {most}")
    print(f"settling {own:.2f} s, study {whole:.2f} s: {100 * own / (whole - own):.1f} % more")


if __name__ == "__main__":
    main()
