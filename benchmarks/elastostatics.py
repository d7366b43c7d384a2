"""How long does the compliance of a whole arm take, at many poses?

python benchmarks/elastostatics.py [--poses 10000]
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import lostmotion
from lostmotion.mechanism.state import state_of

EXAMPLES = Path(__file__).parents[1] / "examples"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--poses", type=int, default=10_000)
    count = parser.parse_args().poses
    for name in ("z-arm.toml", "ur5e.urdf"):
        arm = lostmotion.read(EXAMPLES / name)
        q = lostmotion.sample_poses(arm, count, "uniform").q[:count]
        seconds = []
        for _ in range(6):  # the first one warms up
            start = time.perf_counter()
            found = state_of(arm, q).compliances
            seconds.append(time.perf_counter() - start)
        best = min(seconds[1:])
        print(
            f"{arm!r}: {len(found.parts)} parts that give, {len(q)} poses, {best:.3f} s, "
            f"{best / len(q) * 1e6:.1f} us per pose (best of five, warm)"
        )


if __name__ == "__main__":
    main()
