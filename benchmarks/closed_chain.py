"""How long do the position of a hexapod and its carry matrices take at many poses, beside loops of
SciPy's root and of Newton's method by Pinocchio over the same closures; and a study of each closed
example beside the z-arm's?

python benchmarks/closed_chain.py [--poses 10000] [--solved 20]
"""

from __future__ import annotations

import argparse
import importlib.util
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import root

import lostmotion
from lostmotion.mechanism.closed_home import home_of
from lostmotion.mechanism.closed_jacobian import frames_at, misfits, moved_on
from lostmotion.mechanism.state import state_of, states_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion import Arm

EXAMPLES = Path(__file__).parents[1] / "examples"


def solved(arm: Arm, q: np.ndarray) -> np.ndarray:
    """Return the tool (4, 4) at one pose by SciPy's root from home, with the same closures."""
    home = home_of(arm.tree)

    def closures(step: np.ndarray) -> np.ndarray:
        motions = moved_on(arm.tree, home.motions, step[None])
        return misfits(arm.tree, frames_at(arm.tree, q[None], motions)).ravel()

    found = root(closures, np.zeros(home.jacobian.shape[2]), tol=1e-12)
    motions = moved_on(arm.tree, home.motions, found.x[None])
    return frames_at(arm.tree, q[None], motions)[-1, 0]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--poses", type=int, default=10_000)
    parser.add_argument("--solved", type=int, default=20)
    given = parser.parse_args()
    arm = lostmotion.read(EXAMPLES / "closed-chains" / "hexapod.toml")
    q = lostmotion.sample_poses(arm, given.poses, "uniform").q[: given.poses]
    for name, work in (
        ("position", lambda: state_of(arm, q).frames),
        ("position and carry matrices", lambda: carried(arm, q)),
    ):
        work()  # compiles
        seconds = min(timed(work) for _ in range(3))
        print(f"{name}: {len(q)} poses, {seconds:.2f} s, {1e6 * seconds / len(q):.0f} us per pose")
    few = q[: given.solved]
    tools = state_of(arm, few).frames[-1]
    start = time.process_time()
    found = np.array([solved(arm, each) for each in few])
    seconds = time.process_time() - start
    same = np.abs(found - tools).max(axis=(1, 2)) < 1e-8
    print(
        f"SciPy's root: {1e3 * seconds / len(few):.1f} ms per pose, {np.count_nonzero(same)} of "
        f"{len(few)} poses in the assembly mode of home"
    )
    if importlib.util.find_spec("pinocchio") is None:
        print("Pinocchio: not installed (pip install 'lostmotion[benchmark-pinocchio]')")
    else:
        by_pinocchio(arm, q[: 10 * given.solved])
    names = ("five-bar", "delta-printer", "hexapod", "parallelogram-palletiser")
    for file in ("z-arm.toml", *(f"closed-chains/{name}.toml" for name in names)):
        print(f"study of {file}: {min(studied(file) for _ in range(3)):.2f} s")


def by_pinocchio(arm: Arm, q: np.ndarray) -> None:
    """Time Newton's method by Pinocchio from home, with the rates of the passive joints."""
    from pinocchio_hexapod import Hexapod

    other = Hexapod(arm)
    tools = state_of(arm, q).frames[-1]
    start = time.process_time()
    found = np.array([other.tool(each) for each in q])
    seconds = time.process_time() - start
    same = np.abs(found - tools).max(axis=(1, 2)) < 1e-8
    print(
        f"Pinocchio, Newton's method in Python: {1e6 * seconds / len(q):.0f} us per pose, "
        f"{np.count_nonzero(same)} of {len(q)} poses the same"
    )


def carried(arm: Arm, q: np.ndarray) -> None:
    """Compute the carry matrices of all places."""
    for _, state in states_of(arm, q):
        for place in range(len(arm.places)):
            state.carry(place)


def studied(file: str) -> float:
    """Return the processor seconds of a study of an example."""
    arm = lostmotion.read(EXAMPLES / file)
    return timed(lambda: lostmotion.study(arm, 256, robots=200))


def timed(work: Callable[[], object]) -> float:
    """Return the processor seconds that a function takes."""
    start = time.process_time()
    work()
    return time.process_time() - start


if __name__ == "__main__":
    main()
