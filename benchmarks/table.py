"""How does the paper's Monte Carlo on a UR5e compare with what else one could write it in? One run,
one table.

Every joint angle errs by a normal law of sigma 3.27'/3, every joint's centre by +-30 um along three
axes: 24 independent terms; asked for are mean, 50/95/99 % and largest error at every pose, and the
histogram over all.

    pip install -e '.[benchmarks]'    # or one of benchmark-jax, benchmark-openturns,
                                      benchmark-pinocchio, benchmark-roboticstoolbox
    python benchmarks/table.py [--rounds 5] [--sweep]

Contestants alternate on one thread, the best of all rounds counts, by the processor's time, which
other work beside disturbs least. The slow ones take fewer poses or draws: what counts is time per
sample. One that is not installed is omitted. The column "mean" is each contestant's mean error over
lostmotion's at the same poses: ours cuts the normal law at three sigma, as a tolerance is, which
makes its mean 1 % smaller. What goes without samples counts as if it took as many as the others.

--sweep measures whole runs from 1e6 to 1e9 samples, each in a process of its own: time per sample,
what of it every pose takes once (frames, terms, bounds, exact check: a run of few samples), what
every further sample takes, and the most memory held.
"""

from __future__ import annotations

import argparse
import functools
import importlib.util
import math
import os
import platform
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from against_numpy import (
    ALPHA,
    EDGES,
    LEVELS,
    OFFSET,
    SIGMA,
    A,
    D,
    exact_numpy,
    lever,
    linear_numpy,
    summed_up,
    tool,
    ur5e,
)
from rich.console import Console
from rich.table import Table

from lostmotion import sample_poses, screws
from lostmotion.compiled import compiled
from lostmotion.error_model.draws import robot_draws
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.analytic import analytic
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.blocks import BlockPlan, sample_block
from lostmotion.propagation.montecarlo.montecarlo import BLOCK, run
from lostmotion.propagation.montecarlo.product_kernel import AT_ONCE, squared_lengths

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion import Poses

# One thread each, read when the libraries are loaded.
ONE_THREAD = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "JAX_PLATFORMS": "cpu",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
}


@dataclass(frozen=True)
class Contestant:
    """Who takes part: what it does on so many poses x draws, giving its mean error at each;
    `package` must be there.
    """

    name: str
    work: Callable[[np.ndarray, int], np.ndarray]
    poses: int
    draws: int
    package: str = ""


def mean_of(rows: list) -> np.ndarray:
    return np.array([row[0] for row in rows])


def drawn(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    return SIGMA * rng.standard_normal((6, count)), rng.uniform(-OFFSET, OFFSET, (6, 3, count))


def at_once(angles: np.ndarray, shifts: np.ndarray) -> np.ndarray:
    """Lay angles (6, draw) and shifts (6, 3, draw) out as 24 joint values (draw, 24): each angle,
    and the three shifts after it.
    """
    return np.ascontiguousarray(np.concatenate([angles[:, None], shifts], axis=1).reshape(24, -1).T)


def pinocchio(q: np.ndarray, draws: int) -> np.ndarray:
    """Ask the library for every sample's forward kinematics; an error of a joint's centre is a
    joint of its own, that slides three ways.
    """
    import pinocchio as pin

    model, last, step = pin.Model(), 0, pin.SE3.Identity()
    for k in range(6):
        turning = model.addJoint(last, pin.JointModelRZ(), step, f"angle {k}")
        last = model.addJoint(
            turning, pin.JointModelTranslation(), pin.SE3.Identity(), f"offset {k}"
        )
        c, s = math.cos(ALPHA[k]), math.sin(ALPHA[k])
        step = pin.SE3(np.array([[1, 0, 0], [0, c, -s], [0, s, c]]), np.array([A[k], 0, D[k]]))
    data, rng = model.createData(), np.random.default_rng(1)

    def reached(joints: np.ndarray) -> np.ndarray:
        pin.forwardKinematics(model, data, joints)
        return data.oMi[last].act(step.translation)

    out, histogram = [], np.zeros(len(EDGES) - 1, int)
    for row in q:
        right = reached(at_once(row[:, None], np.zeros((6, 3, 1)))[0])
        angles, shifts = drawn(rng, draws)
        errors = np.array(
            [reached(joints) - right for joints in at_once(row[:, None] + angles, shifts)]
        )
        summed_up(errors.T, out, histogram)
    return mean_of(out)


def toolbox(q: np.ndarray, draws: int) -> np.ndarray:
    """Give all draws of a pose at once to a chain of 24 elementary transforms, the library's own
    fastest way.
    """
    from roboticstoolbox import ET, ETS

    chain = []
    for k in range(6):
        chain += [ET.Rz(), ET.tx(), ET.ty(), ET.tz(), ET.tz(D[k]), ET.tx(A[k]), ET.Rx(ALPHA[k])]
    ets, rng = ETS(chain), np.random.default_rng(1)
    out, histogram = [], np.zeros(len(EDGES) - 1, int)
    for row in q:
        angles, shifts = drawn(rng, draws)
        right = ets.eval(at_once(row[:, None], np.zeros((6, 3, 1)))[0])[:3, 3]
        summed_up(
            (ets.eval(at_once(row[:, None] + angles, shifts))[:, :3, 3] - right).T, out, histogram
        )
    return mean_of(out)


def openturns(q: np.ndarray, draws: int) -> np.ndarray:
    """Let the library draw, call a vectorised NumPy model and reduce."""
    import openturns as ot

    ot.RandomGenerator.SetSeed(1)
    ot.TBB.Disable()  # one thread
    law = ot.JointDistribution([ot.Normal(0, SIGMA)] * 6 + [ot.Uniform(-OFFSET, OFFSET)] * 18)
    out = []
    for row in q:
        right = tool(row[:, None], np.zeros((6, 3, 1)))

        def length(sample: object, row: np.ndarray = row, right: np.ndarray = right) -> np.ndarray:
            given = np.asarray(sample).T
            return np.linalg.norm(
                tool(row[:, None] + given[:6], given[6:].reshape(6, 3, -1)) - right, axis=0
            )[:, None]

        sizes = ot.PythonFunction(24, 1, func_sample=length)(law.getSample(draws))
        out.append(
            (
                sizes.computeMean()[0],
                sizes.getMax()[0],
                *(sizes.computeQuantile(level)[0] for level in LEVELS),
            )
        )
        np.histogram(np.asarray(sizes), EDGES)
    return mean_of(out)


@functools.cache
def _jitted(draws: int) -> Callable:
    import jax
    import jax.numpy as jnp

    def at(q: object, key: object) -> object:
        one, two = jax.random.split(key)
        angles = q[:, None] + SIGMA * jax.random.normal(one, (6, draws), jnp.float64)
        shifts = jax.random.uniform(two, (6, 3, draws), jnp.float64, -OFFSET, OFFSET)

        def reached(angles: object, shifts: object) -> object:
            x = y = z = jnp.zeros(angles.shape[1])
            for k in range(5, -1, -1):
                ca, sa = math.cos(ALPHA[k]), math.sin(ALPHA[k])
                x, y, z = (
                    x + A[k] + shifts[k, 0],
                    ca * y - sa * z + shifts[k, 1],
                    sa * y + ca * z + D[k] + shifts[k, 2],
                )
                c, s = jnp.cos(angles[k]), jnp.sin(angles[k])
                x, y = c * x - s * y, s * x + c * y
            return jnp.stack([x, y, z])

        sizes = jnp.linalg.norm(
            reached(angles, shifts) - reached(q[:, None], jnp.zeros((6, 3, 1))), axis=0
        )
        ranked = jnp.sort(sizes)
        ranks = jnp.array([min(int(level * draws), draws - 1) for level in LEVELS])
        return (
            sizes.mean(),
            ranked[-1],
            ranked[ranks],
            jnp.diff(jnp.searchsorted(ranked, jnp.asarray(EDGES))),
        )

    return jax.jit(lambda q, keys: jax.lax.map(lambda each: at(*each), (q, keys)))


def jax_exact(q: np.ndarray, draws: int) -> np.ndarray:
    """Compile the whole of a pose, draws and statistics included, and map it over the poses."""
    import jax

    with jax.enable_x64(True):
        mean, *_ = _jitted(draws)(q, jax.random.split(jax.random.key(1), len(q)))
        return np.asarray(mean)


class Ours:
    """The kernel on pose matrices that are given to it, block by block; on `device`."""

    def __init__(self, varies: str, device: str = "cpu") -> None:
        self.arm, self.device = ur5e(varies), device
        self.blocks: list = []

    def prepare(self, poses: Poses) -> None:
        self.poses = poses
        self.blocks = [
            screws(state_of(self.arm, poses.q[first : first + BLOCK]))
            for first in range(0, len(poses), BLOCK)
        ]
        for matrix in self.blocks:
            _ = matrix.along_poses, matrix.bias, matrix.square_sums

    def __call__(self, q: np.ndarray, draws: int) -> np.ndarray:
        plan = replace(BlockPlan.of(self.arm, self.poses, draws, 1, 1, 0.0), device=self.device)
        found, first = [], 0
        for matrix in self.blocks:
            if first >= len(q):
                break
            found.append(sample_block(plan, matrix, first).per_pose[:, kernel.MEAN])
            first += len(matrix.tool)
        return np.concatenate(found)[: len(q)]


@compiled
def _product(
    bias: np.ndarray, shift: np.ndarray, drawn: np.ndarray, robots: int, out: np.ndarray
) -> None:
    """Form every squared error of a block, sixteen poses to a tile of robots, and ask nothing of
    it.
    """
    tiles, terms, lanes = drawn.shape
    screws, squares = np.empty((16, terms, 3)), np.empty((16, lanes))
    at = np.empty((16, terms), np.uintp)
    for start in range(0, len(bias), 16):
        some = min(16, len(bias) - start)
        for k in range(some):
            for t in range(terms):
                for c in range(3):
                    screws[k, t, c] = shift[c, t, start + k]
        for tile in range(tiles):
            for k in range(some):
                for t in range(terms):
                    at[k, t] = drawn.ctypes.data + np.uintp(8 * lanes * (tile * terms + t))
            width = (min(lanes, robots - tile * lanes) + AT_ONCE - 1) // AT_ONCE * AT_ONCE
            squared_lengths(some, width, screws, at, bias[start:], squares)
        # One robot's error of every pose is kept, so that no compiler leaves the rest out.
        for k in range(some):
            out[start + k] = np.sqrt(squares[k, 0])


class Product(Ours):
    """The linear product alone, from one table of draws: the bound of what any statistics on top of
    it can reach. It has no mean.
    """

    def prepare(self, poses: Poses) -> None:
        super().prepare(poses)
        streams = [self.blocks[0].infos[k].robot for k in self.blocks[0].columns("robot")]
        self.drawn = robot_draws(1, streams, 1000)
        self.given = [
            (np.ascontiguousarray(m.bias[:, 3:]), m.along_poses[3:][:, m.columns("robot")])
            for m in self.blocks
        ]

    def __call__(self, q: np.ndarray, draws: int) -> np.ndarray:
        for bias, shift in self.given:
            _product(bias, shift, self.drawn, draws, np.empty(len(bias)))
        return np.full(len(q), math.nan)


def kinematics(q: np.ndarray, draws: int) -> np.ndarray:
    """Ask NumPy for squared errors alone, by exact kinematics from one table of draws: what the
    product alone is to be held against.
    """
    angles, shifts = drawn(np.random.default_rng(1), draws)
    out = np.empty((len(q), draws))
    for row, squares in zip(q, out, strict=True):
        errors = tool(row[:, None] + angles, shifts) - tool(row[:, None], np.zeros((6, 3, 1)))
        np.einsum("cd,cd->d", errors, errors, out=squares)
    return np.full(len(q), math.nan)


def whole(varies: str, poses: Poses) -> Callable[[np.ndarray, int], np.ndarray]:
    arm = ur5e(varies)
    return lambda _, draws: run(arm, poses, draws, 1, 1).per_pose[:, kernel.MEAN]


def contestants(poses: Poses) -> list[Contestant]:
    matrices = lever(poses.q[:1000])
    shared, fresh, on_jax, product = (
        Ours("robot"),
        Ours("visit"),
        Ours("visit", "gpu"),
        Product("robot"),
    )
    for ours in (shared, fresh, on_jax, product):
        ours.prepare(poses)
    arm, many = ur5e(), len(poses.q)
    return [
        Contestant(
            "careful NumPy, exact kinematics",
            lambda q, draws: mean_of(exact_numpy(q, draws)),
            200,
            1000,
        ),
        Contestant(
            "careful NumPy, exact kinematics alone, one table of draws", kinematics, 200, 1000
        ),
        Contestant(
            "careful NumPy, linear, matrices given",
            lambda q, draws: mean_of(linear_numpy(draws, matrices[: len(q)])),
            500,
            1000,
        ),
        Contestant("lostmotion, the product alone, one table of draws", product, many, 1000),
        Contestant("lostmotion, one table of draws, matrices given", shared, many, 1000),
        Contestant("lostmotion, fresh draws, matrices given", fresh, many, 1000),
        Contestant(
            "lostmotion, one table of draws, the whole run", whole("robot", poses), many, 1000
        ),
        Contestant("lostmotion, fresh draws, the whole run", whole("visit", poses), many, 1000),
        Contestant(
            "lostmotion, without sampling, arm to figures",
            lambda q, _: analytic(arm, q).mean,
            many,
            1000,
        ),
        Contestant(
            "lostmotion on JAX, processor, matrices given", on_jax, min(BLOCK, many), 1000, "jax"
        ),
        Contestant("JAX, exact kinematics, processor", jax_exact, 500, 1000, "jax"),
        Contestant("OpenTURNS with a NumPy model", openturns, 100, 1000, "openturns"),
        Contestant("roboticstoolbox, elementary transforms", toolbox, 10, 1000, "roboticstoolbox"),
        Contestant("Pinocchio in a loop", pinocchio, 10, 1000, "pinocchio"),
    ]


def race(every: list[Contestant], poses: Poses, rounds: int, console: Console) -> None:
    taking_part = []
    for each in every:
        if each.package and importlib.util.find_spec(each.package) is None:
            console.print(
                (
                    f"left out: {each.name}: {each.package} is not installed; pip install -e "
                    f"'.[benchmark-{each.package}]'"
                ),
                markup=False,
            )
        else:
            taking_part.append(replace(each, poses=min(each.poses, len(poses))))
    truth = run(ur5e(), poses, 1000, 1, 2).per_pose[:, kernel.MEAN]
    best, means = {each.name: math.inf for each in taking_part}, {}
    for each in taking_part:
        each.work(poses.q[: each.poses], each.draws)  # compiles
    for _ in range(rounds):
        for each in taking_part:
            start = time.process_time()
            means[each.name] = each.work(poses.q[: each.poses], each.draws)
            best[each.name] = min(
                best[each.name], (time.process_time() - start) / (each.poses * each.draws) * 1e9
            )
    first = best[taking_part[0].name]
    table = Table(title=f"UR5e, 24 terms; one thread, best of {rounds} rounds, processor time")
    for head in ("", "poses x draws", "ns per sample", "times careful NumPy", "mean"):
        table.add_column(head, justify="left" if not head else "right")
    for each in taking_part:
        ratio = first / best[each.name]
        mean = float(np.mean(means[each.name]) / np.mean(truth[: each.poses]))
        shown = f"{ratio:.0f}" if ratio >= 10 else f"{ratio:.2g}"
        table.add_row(
            each.name,
            f"{each.poses} x {each.draws}",
            f"{best[each.name]:.3g}",
            shown,
            "-" if math.isnan(mean) else f"{mean:.3f}",
        )
    console.print(table)


SWEEP = """
import resource, sys, time
sys.path.insert(0, {folder!r})
from against_numpy import ur5e
from lostmotion import sample_poses
from lostmotion.propagation.montecarlo.montecarlo import run
arm = ur5e({varies!r})
run(arm, sample_poses(arm, 8, "uniform"), 64, {visits}, 1)
poses = sample_poses(arm, {poses}, "uniform")
samples = len(poses) * {robots} * {visits}
def took(robots, visits):
    start = time.process_time()
    run(arm, poses, robots, visits, 1)
    return time.process_time() - start
few = min({robots}, {least}), min({visits}, {least})
once = min(took(*few) for _ in range(3))
whole = min(took({robots}, {visits}) for _ in range(max(1, min(5, 10**8 // samples))))
further = (whole - once) / (samples - len(poses) * few[0] * few[1])
print(whole / samples * 1e9, once / len(poses) * 1e6, further * 1e9, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""  # noqa: E501
# With so few robots and visits, a run takes next to nothing but what it takes for every pose.
LEAST = 4
# One table of draws and fresh ones: more poses of as many draws, and more draws at as many poses;
# robots that return: more visits.
SIZES = [
    *(
        ("one table of draws", "robot", poses, 1000, 1)
        for poses in (1000, 10_000, 100_000, 1_000_000)
    ),
    *(("fresh draws", "visit", poses, 1000, 1) for poses in (1000, 10_000, 100_000, 1_000_000)),
    *(
        ("one table of draws", "robot", poses, robots, 1)
        for poses, robots in ((1000, 1000), (1000, 10_000), (10_000, 10_000), (10_000, 100_000))
    ),
    *(
        ("fresh draws", "visit", poses, robots, 1)
        for poses, robots in ((1000, 1000), (1000, 10_000), (10_000, 10_000), (10_000, 100_000))
    ),
    *(("fresh draws, AP and RP", "visit", 1000, 100, visits) for visits in (10, 100, 1000, 10_000)),
]


def sweep(console: Console) -> None:
    table = Table(title="Whole runs, one thread, processor time")
    for head in (
        "",
        "poses x robots x visits",
        "samples",
        "ns per sample",
        "µs per pose",
        "ns per further sample",
        "peak memory, MB",
    ):
        table.add_column(head, justify="left" if not head else "right")
    for name, varies, poses, robots, visits in SIZES:
        code = SWEEP.format(
            folder=str(Path(__file__).resolve().parent),
            varies=varies,
            poses=poses,
            robots=robots,
            visits=visits,
            least=LEAST,
        )
        found = subprocess.run(
            [sys.executable, "-c", code], check=True, capture_output=True, text=True
        ).stdout.split()
        size = f"{poses} x {robots} x {visits}"
        table.add_row(
            name, size, f"{poses * robots * visits:.0e}", *(f"{float(each):.3g}" for each in found)
        )
    console.print(table)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--poses", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--sweep", action="store_true")
    options = parser.parse_args()
    console = Console(width=140)
    console.print(
        f"{platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__}"
    )
    if options.sweep:
        sweep(console)
        return
    poses = sample_poses(ur5e(), options.poses, "uniform")
    race(contestants(poses), poses, options.rounds, console)


if __name__ == "__main__":
    if any(os.environ.get(name) != value for name, value in ONE_THREAD.items()):
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **ONE_THREAD})  # noqa: S606
    main()
