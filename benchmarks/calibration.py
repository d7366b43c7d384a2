"""How much better a robot is predicted once it was measured at few poses: robots drawn from five
example arms, with unknown base and tool frames and drawn visits, against least squares.

python benchmarks/calibration.py [--robots 24] [--only errors|coverage|releases]

errors    mean error at 450 other poses against the mean of six visits, median over the robots, of
          base and tool frame alone, least squares of the constant errors that the file states,
          least squares of all that it states, and the calibration. None of them knows the noise;
          inf: the estimated robot cannot stand under its load
coverage  share of the errors that the file states within their 95 % intervals, 100 robots of each
          arm, 20 poses
releases  errors released of 200 robots drawn from the prior of the UR5, 20 poses: all are false
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import lostmotion
from lostmotion.calibration.choices import Asked
from lostmotion.calibration.fit import fit
from lostmotion.calibration.instruments import Points
from lostmotion.calibration.model import model_of
from lostmotion.calibration.terms import Deviations, added_terms, is_frame, is_seat, stated_scale
from lostmotion.error_model.poses import sample_poses
from lostmotion.parts.forms import Constant
from lostmotion.propagation.exact import compose, draws_of

if TYPE_CHECKING:
    from lostmotion.calibration.fit import Estimates
    from lostmotion.calibration.model import RobotModel
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

EXAMPLES = Path(__file__).parents[1] / "examples"
# Standard deviation of a measured coordinate, m.
ARMS = {
    "ur5e.urdf": 20e-6,
    "six-axis.toml": 20e-6,
    "z-arm.toml": 20e-6,
    "printed-hobby-arm.toml": 0.3e-3,
    "gantry.toml": 20e-6,
}
SIZES = (10, 20, 50)
OTHERS, VISITS, SEED = 450, 6, 2
# True deviations of the frames: 3 mrad, 3 mm, and 1 mm of the tool, of the priors in `Deviations`.
FRAMES = {"turn": 0.3, "shift": 0.3, "tool": 1 / 3}


class Drawn(NamedTuple):
    """The robots of an arm: model at measured poses and at others, and the true draws."""

    arm: Arm
    measured: RobotModel
    others: RobotModel
    noise: float

    def seen(self, model: RobotModel, robot: int, visits: int, first: int) -> Floats:
        """Return the mean tool point (pose, 3), m, of a robot over visits."""
        count = len(model)
        rows, each = np.repeat(np.arange(count), visits), np.tile(np.arange(visits), count)
        robots = np.full(len(rows), robot)
        draws = draws_of(model.matrix, rows, SEED, first + rows, robots, each)
        for k, info in enumerate(model.matrix.infos):
            if is_frame(info.owner):
                kind = "tool" if info.owner.startswith("tool") else info.of.term.name.split()[0]
                draws[k] *= FRAMES[kind]
            elif is_seat(info.owner):
                draws[k] = 0.0  # the file states all that these robots have
        shaped = draws.reshape(len(draws), count, visits).transpose(1, 0, 2)
        return compose(model.matrix, np.arange(count), shaped)[..., :3, 3].mean(axis=1)

    def truth(self, robot: int) -> Floats:
        """Return the draws (stream,) of a robot."""
        one = np.zeros(1, dtype=int)
        draws = draws_of(self.measured.matrix, one, SEED, one, one + robot, one)[:, 0]
        first = [int(np.flatnonzero(self.measured.of == k)[0]) for k in self.streams]
        return draws[first]

    @property
    def streams(self) -> range:
        """Return the numbers of the estimated draws."""
        return range(len(self.measured.streams))

    @property
    def stated(self) -> np.ndarray:
        """Return which draws the file states."""
        return np.array([not (is_frame(o) or is_seat(o)) for o in self.measured.owners])

    def fitted(self, robot: int, poses: int) -> tuple[RobotModel, Floats]:
        """Return the model at the measured poses, and what is measured there (pose, 3), m."""
        model = self.measured.rows(np.arange(poses))
        chance = np.random.default_rng([robot, poses])
        exact = self.seen(model, robot, 1, 0)
        return model, exact + chance.normal(0, self.noise, exact.shape)


def drawn(name: str) -> Drawn:
    """Return the robots of an example."""
    arm = lostmotion.read(EXAMPLES / name)
    added = added_terms(arm, Deviations())
    few, many = (sample_poses(arm, n, "sobol", seed).q for n, seed in ((64, 3), (512, 4)))
    return Drawn(arm, model_of(arm, few, added), model_of(arm, many[:OTHERS], added), ARMS[name])


def least_squares(model: RobotModel, points: Floats, kept: np.ndarray) -> Floats:
    """Return draws (stream,) of least squares, by a fixed basis of nominal columns."""
    columns = model.columns[:, 3:, kept].reshape(points.size, -1)
    _, sizes, across = np.linalg.svd(columns, full_matrices=False)
    basis = across[sizes > 1e-7 * sizes[0]].T
    draws, z = np.zeros(len(model.streams)), np.zeros(basis.shape[1])
    for _ in range(4):
        left = (points - model.frames(draws)[:, :3, 3]).ravel()
        if not np.isfinite(left).all():  # a robot that cannot stand under its load
            break
        z = z + np.linalg.lstsq(columns @ basis, left, rcond=None)[0]
        draws[kept] = basis @ z
    return draws


def calibrated(robots: Drawn, model: RobotModel, points: Floats) -> Estimates:
    """Return the estimates as `lostmotion calibrate` computes those of constant errors."""
    asked = Asked(np.ones(len(model.streams)), scale=stated_scale(robots.arm, Deviations()))
    return fit(model, Points(points), asked)


def errors(count: int) -> None:
    """Print the table of mean errors."""
    print("| arm | " + " | ".join(f"N = {n}" for n in SIZES) + " |")
    for name in ARMS:
        robots = drawn(name)
        model = robots.measured
        frame = np.array([is_frame(owner) for owner in model.owners])
        constant = np.array(
            [
                isinstance(model.matrix.infos[list(model.of).index(k)].of.term.form, Constant)
                for k in robots.streams
            ]
        )
        kinds = (frame, frame | (robots.stated & constant), frame | robots.stated)
        cells = []
        for poses in SIZES:
            out = []
            for robot in range(count):
                part, points = robots.fitted(robot, poses)
                truth = robots.seen(robots.others, robot, VISITS, 1000)
                found = [least_squares(part, points, np.flatnonzero(kind)) for kind in kinds]
                found.append(calibrated(robots, part, points).mean)
                out.append(
                    [
                        np.linalg.norm(robots.others.frames(d)[:, :3, 3] - truth, axis=1).mean()
                        for d in found
                    ]
                )
            middle = 1e6 * np.median(np.nan_to_num(out, nan=np.inf), axis=0)
            ratio = middle[3] / middle[:3].min()
            cells.append(", ".join(f"{each:.0f}" for each in middle) + f" ({ratio:.2f})")
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


def coverage(count: int) -> None:
    """Print the share of estimates within their intervals, and the errors released."""
    every = []
    for name in ARMS:
        robots = drawn(name)
        inside, released = [], 0
        for robot in range(count):
            model, points = robots.fitted(robot, 20)
            found = calibrated(robots, model, points)
            away = np.abs(found.mean - robots.truth(robot)) / np.sqrt(np.diag(found.covariance))
            inside.append((away[robots.stated] <= 1.96).mean())
            released += len(found.released)
        every += inside
        print(f"{name}: {100 * np.mean(inside):.1f} % within, {released} released", flush=True)
    print(f"all: {100 * np.mean(every):.1f} % of {len(every)} robots")


def releases(count: int) -> None:
    """Print how many errors are released of robots that follow their prior."""
    arm = lostmotion.read(EXAMPLES / "calibration" / "ur5.toml")
    every = model_of(arm, sample_poses(arm, 1024, "sobol", 1).q, added_terms(arm, Deviations()))
    chance, false, inside = np.random.default_rng(8), 0, []
    robot = np.array([not is_frame(owner) for owner in every.owners])
    for _ in range(count):
        model = every.rows(np.sort(chance.choice(1024, 20, replace=False)))
        draws = chance.normal(size=len(model.streams))
        points = model.frames(draws)[:, :3, 3] + chance.normal(0, 7e-5, (20, 3))
        found = fit(model, Points(points), Asked(np.ones(len(draws)), 7e-5))
        away = np.abs(found.mean - draws) / np.sqrt(np.diag(found.covariance))
        inside.append((away[robot] <= 1.96).mean())
        false += len(found.released)
    print(f"{false} false releases in {count} robots, {100 * np.mean(inside):.1f} % within")


def main() -> None:
    """Print what was asked for."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--robots", type=int, default=24)
    parser.add_argument("--only", choices=("errors", "coverage", "releases"))
    asked = parser.parse_args()
    for name, ask, count in (
        ("releases", releases, 200),
        ("errors", errors, asked.robots),
        ("coverage", coverage, 100),
    ):
        if asked.only in (None, name):
            ask(count if asked.robots >= 24 else asked.robots)


if __name__ == "__main__":
    main()
