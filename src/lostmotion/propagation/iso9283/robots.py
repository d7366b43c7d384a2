"""Predicted ISO 9283 characteristics of robots simulated from one design.

Each robot is drawn once, follows the standard's cycles, and is evaluated by the standard's
definitions. Motion is quasi-static: no overshoot, settling or speed. The direction of each joint's
last motion decides the side of its backlash.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.expected_repeatability import expected_repeatability, visit_covariance
from lostmotion.error_model.pose_matrix import pose_matrix, screws
from lostmotion.error_model.trust import refuse_untrusted
from lostmotion.laws import iso9283 as iso
from lostmotion.laws.frame_fit import residual_after_fit
from lostmotion.laws.iso9283 import PATH_FIGURES
from lostmotion.mechanism.standing import standing
from lostmotion.mechanism.state import state_of
from lostmotion.propagation import exact
from lostmotion.propagation.iso9283.axes import axis_tests
from lostmotion.propagation.iso9283.cube import MOST_POSES, NAMES
from lostmotion.propagation.iso9283.experiment import Experiment
from lostmotion.propagation.iso9283.joint_motion import (
    cycle_approach,
    path_approach,
    path_poses,
    side_approach,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.exact import ExactCheck
    from lostmotion.propagation.iso9283.axes import AxisTest
    from lostmotion.propagation.iso9283.cube import CommandedPoses, Cube
    from lostmotion.spatial import Floats

CYCLES: Final = 30
PATH_CYCLES: Final = 10
LOADS: Final = (1.0, 0.1)
ROBOTS: Final = 1000
MOST_CYCLES: Final = 1000
MOST_PATH_POINTS: Final = 200
PATH_POINTS: Final = 20
# Poses at which the standard evaluates vAP; ends of the distance and of the default path.
FROM_THREE_SIDES: Final = (0, 1, 3)
DISTANCE: Final = (1, 3)
SHOWN_ROBOTS: Final = 3
_CHECKED: Final = 8
# First pose number of each experiment: visits are drawn independently, robots are the same.
_NUMBERS: Final = {"cycle": 0, "sides": 1_000, "path": 2_000, "commanded": 4_000, "axes": 5_000}


@dataclass(frozen=True)
class LoadSheet:
    """Characteristics under one load, robot by robot, m and rad.

    load                  share of the payload
    barycentre, turn      (pose, robot, 3) mean error and rotation of a robot's visits: AP_x, AP_y,
                          AP_z and AP_a, AP_b, AP_c
    repeatability         (pose, robot) RP_l
    scatter               (pose, robot, 6) 3 s about and along the axes: RP_a, RP_b, RP_c first
    fitted                (pose, robot) AP_p after the best fit of each robot's base frame over the
                          five poses
    expected, deviation   (pose,) expected value and standard deviation of RP_l for normal scatter
                          of the same covariance, without sampling
    limit                 (pose,) its limit for many visits
    random_approach       (pose, robot) RP_l if every joint arrives from either side at random
    shown                 (robot, pose, visit, 3) errors of the first robots, for a plot
    multi_directional     (3, robot) vAP_p at P1, P2 and P4
    distance              (2, robot) AD_p and RD between P2 and P4
    path                  (8, robot) `PATH_FIGURES` along the line
    path_profile          (8, point, 2) the same at each point: mean and 95th percentile over robots
    path_reversal         (robot,) largest distance between the line followed in either direction
    """

    load: float
    barycentre: Floats
    turn: Floats
    repeatability: Floats
    scatter: Floats
    fitted: Floats
    expected: Floats
    deviation: Floats
    limit: Floats
    random_approach: Floats
    shown: Floats
    multi_directional: Floats
    distance: Floats
    path: Floats
    path_profile: Floats
    path_reversal: Floats

    @property
    def accuracy(self) -> Floats:
        """Return AP_p (pose, robot), m."""
        return np.asarray(np.linalg.norm(self.barycentre, axis=-1))


@dataclass(frozen=True)
class PredictedRobots:
    """Characteristics of the simulated robots of one design.

    approach (5, joint)       sign of each joint's motion on arrival in the cycle
    still                     names of joints that do not move in the cycle
    loads                     characteristics under each load, in the order given
    path_ends                 the poses that the path joins
    path_points, path_cycles  number of points of the path, and of its cycles
    axes                      positioning along and about the base's axes, under the first load
    check                     difference of the first-order sum to the exact composition, on a
                              sample at the five poses
    """

    arm: Arm
    cube: Cube
    cycles: int
    robots: int
    seed: int
    approach: Floats
    still: tuple[str, ...]
    loads: tuple[LoadSheet, ...]
    path_ends: tuple[int, int]
    path_points: int
    path_cycles: int
    axes: tuple[AxisTest, ...]
    check: ExactCheck


def predict_robots(  # noqa: PLR0913 - an ISO sheet is these numbers
    arm: Arm,
    cube: Cube,
    *,
    cycles: int = CYCLES,
    robots: int = ROBOTS,
    seed: int = 1,
    path: tuple[int, int] = DISTANCE,
    path_points: int = PATH_POINTS,
    path_cycles: int = PATH_CYCLES,
    loads: Sequence[float] = LOADS,
    instrument: float = 0.0,
    progress: Callable[[str, int, int], None] | None = None,
) -> PredictedRobots:
    """Return the ISO 9283 characteristics of simulated robots of this design, in this cube.

    cycles      visits to each pose (the standard's 30), in the order P5, P4, P3, P2, P1
    robots      number of simulated robots
    path        the poses that the line for AT and RT joins, 0 for P1; followed `path_cycles` times
                (the standard's 10), evaluated at `path_points`, at most `MOST_PATH_POINTS`
    loads       shares of the payload
    instrument  standard deviation of the readings of positions that is added, m
    Raises InputError for a path that the arm cannot follow.
    """
    approach, still = cycle_approach(cube.q)
    visiting = Experiment(seed, robots, cycles, instrument)
    sheets = load_sheets(
        arm, cube, visiting, dict(enumerate(loads)), (*path, path_points), path_cycles, progress
    )
    return PredictedRobots(
        arm,
        cube,
        cycles,
        robots,
        seed,
        approach,
        tuple(joint.name for joint, stands in zip(arm.driven, still, strict=True) if stands),
        sheets,
        path,
        path_points,
        path_cycles,
        axis_tests(
            with_payload_share(arm, loads[0]), cube, approach[0], visiting, _NUMBERS["axes"]
        ),
        exact.check(
            pose_matrix(arm, cube.q, approach=approach),
            0,
            np.arange(len(NAMES)),
            seed,
            min(robots, _CHECKED),
            min(cycles, _CHECKED),
        ),
    )


def load_sheets(
    arm: Arm,
    cube: Cube,
    visiting: Experiment,
    loads: Mapping[int, float],
    line: tuple[int, int, int] | None,
    path_cycles: int,
    progress: Callable[[str, int, int], None] | None = None,
) -> tuple[LoadSheet, ...]:
    """Return the characteristics of simulated robots in a cube under each load.

    loads   shares of the payload by their number, which decides the draws of their visits
    line    first and last pose of the path and its number of points; None: its figures are NaN
    Other arguments as for `predict_robots`. Raises InputError for a path that the arm cannot
    follow.
    """
    report = progress or (lambda _stage, _done, _total: None)
    steps = 3 * len(loads)
    approach = cycle_approach(cube.q)[0]
    # The payload changes no joint values.
    q = None if line is None else path_poses(arm, cube, line[:2], line[2])
    sheets = []
    for done, (number, load) in enumerate(loads.items()):
        loaded = with_payload_share(arm, load)
        report("visiting the five poses", 3 * done, steps)
        first = _NUMBERS["cycle"] + len(NAMES) * number
        at_poses = _at_poses(loaded, cube, approach, visiting, first)
        report("arriving from three sides", 3 * done + 1, steps)
        first = _NUMBERS["sides"] + 3 * len(FROM_THREE_SIDES) * number
        sides = _from_sides(loaded, cube, approach, visiting, first)
        along = _no_path(visiting.robots)
        if line is not None and q is not None:
            report("following the path", 3 * done + 2, steps)
            first = _NUMBERS["path"] + MOST_PATH_POINTS * number
            followed = replace(visiting, visits=path_cycles)
            along = _along_path(loaded, cube, approach, line[:2], q, followed, first)
        sheets.append(LoadSheet(load=load, multi_directional=sides, **along, **at_poses))
    return tuple(sheets)


def predict_at(
    arm: Arm,
    at: CommandedPoses,
    *,
    cycles: int,
    robots: int,
    seed: int,
    loads: Sequence[float],
    instrument: float = 0.0,
) -> tuple[LoadSheet, ...]:
    """Return the characteristics of simulated robots at commanded poses, at most `MOST_POSES`,
    visited in their order cycle by cycle, under each load.

    Arguments as for `predict_robots`. What needs a cube (vAP over three sides, paths) is NaN; AD_p
    and RD need poses of the names P2 and P4.
    """
    approach = cycle_approach(at.q[::-1])[0][::-1]
    visiting = Experiment(seed, robots, cycles, instrument)
    return tuple(
        LoadSheet(
            load=load,
            multi_directional=np.full((len(FROM_THREE_SIDES), robots), np.nan),
            **_no_path(robots),
            **_at_poses(
                with_payload_share(arm, load),
                at,
                approach,
                visiting,
                _NUMBERS["commanded"] + MOST_POSES * number,
            ),
        )
        for number, load in enumerate(loads)
    )


def with_payload_share(arm: Arm, share: float) -> Arm:
    """Return the arm with a share of its payload: mass, process force and moment. Drives and their
    friction do not change.
    """
    payload = arm.payload
    lighter = payload.model_copy(
        update={
            "mass": payload.mass * share,
            "force": tuple(share * x for x in payload.force),
            "moment": tuple(share * x for x in payload.moment),
        }
    )
    return arm if share == 1 else arm.with_payload(lighter)


def _at_poses(
    arm: Arm, at: Cube | CommandedPoses, approach: Floats, visiting: Experiment, first: int
) -> dict[str, Floats]:
    """Return the fields of a `LoadSheet` that belong to the poses, numbered from `first`."""
    refuse_untrusted(arm, at.q, 0.0)
    state = standing(state_of(arm, at.q))
    matrix = screws(state, approach=approach)
    errors = visiting.at_all(matrix, first)
    shift, turn = errors[..., 3:], errors[..., :3]
    barycentre = iso.axis_accuracy(shift)
    command = at.poses[:, :3, 3]
    covariance = visit_covariance(matrix) + visiting.instrument**2 * np.eye(3)
    expected, deviation = expected_repeatability(covariance, visiting.visits)
    return {
        "barycentre": barycentre,
        "turn": iso.axis_accuracy(turn),
        "repeatability": iso.pose_repeatability(shift),
        "scatter": iso.axis_repeatability(errors),
        "fitted": np.linalg.norm(residual_after_fit(barycentre, command), axis=-1),
        "expected": expected,
        "deviation": deviation,
        "limit": expected_repeatability(covariance)[0],
        "random_approach": iso.pose_repeatability(visiting.at_all(screws(state), first)[..., 3:]),
        "shown": shift[:, :SHOWN_ROBOTS].swapaxes(0, 1).copy(),
        "distance": _distance(at, command, shift),
    }


def _distance(at: Cube | CommandedPoses, command: Floats, shift: Floats) -> Floats:
    """Return AD_p and RD (2, robot) between P2 and P4; NaN where these are not among the poses."""
    if not {NAMES[k] for k in DISTANCE} <= set(at.names):
        return np.full((2, shift.shape[1]), np.nan)
    a, b = (at.names.index(NAMES[k]) for k in DISTANCE)
    ends = command[a] + shift[a], command[b] + shift[b]
    far = float(np.linalg.norm(command[b] - command[a]))
    return np.stack([iso.distance_accuracy(*ends, far), iso.distance_repeatability(*ends)])


def _from_sides(arm: Arm, cube: Cube, approach: Floats, visiting: Experiment, first: int) -> Floats:
    """Return vAP (pose, robot), with each pose approached along the base's x, y and z."""
    out = np.empty((len(FROM_THREE_SIDES), visiting.robots))
    for row, pose in enumerate(FROM_THREE_SIDES):
        state = state_of(arm, np.tile(cube.q[pose], (3, 1)))
        matrix = screws(standing(state), approach=side_approach(arm, cube, pose, approach[pose]))
        shift = visiting.at_all(matrix, first + 3 * row)[..., 3:]
        out[row] = iso.multi_directional_accuracy(np.moveaxis(shift, 0, 1))
    return out


def _no_path(robots: int) -> dict[str, Floats]:
    """Return the fields of a `LoadSheet` that belong to the path, where none is followed."""
    unknown = np.full((len(PATH_FIGURES), robots), np.nan)
    return {
        "path": unknown,
        "path_profile": unknown[:, :0, None],
        "path_reversal": unknown[0],
    }


def _along_path(
    arm: Arm,
    cube: Cube,
    approach: Floats,
    ends: tuple[int, int],
    q: Floats,
    visiting: Experiment,
    first: int,
) -> dict[str, Floats]:
    """Return the fields of a `LoadSheet` that belong to the path between two poses, at joint values
    q (point, joint).
    """
    a, b = ends
    refuse_untrusted(arm, q, 0.0)
    state = standing(state_of(arm, q))
    matrix = screws(state, approach=path_approach(q, approach[a]))
    back = screws(state, approach=path_approach(q[::-1], approach[b])[::-1])
    along = cube.poses[b, :3, 3] - cube.poses[a, :3, 3]
    found = np.empty((len(PATH_FIGURES), len(q), visiting.robots))
    apart = np.zeros((len(q), visiting.robots))
    once = replace(visiting, visits=1)
    for k in range(len(q)):
        found[:, k] = iso.path_figures(visiting.errors(matrix, k, first + k), along)
        # The same draws both ways: what differs is the side of the joints alone.
        ways = [once.errors(each, k, first + k)[:, 0, 3:] for each in (matrix, back)]
        apart[k] = np.linalg.norm(ways[1] - ways[0], axis=-1)
    profile = np.stack([found.mean(axis=-1), np.quantile(found, 0.95, axis=-1)], axis=-1)
    return {
        "path": found.max(axis=1),
        "path_profile": profile,
        "path_reversal": apart.max(axis=0),
    }
