"""What would ISO 9283 say of robots built to this design? Each is drawn once, sent through the standard's cycles, and judged by its definitions.

The standard's drives are quasi-static here: no overshoot, no settling, no speed. Every joint arrives from where the motion before came from, and
that decides the side of its play.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.iso9283 import characteristics as iso
from lostmotion.analyses.iso9283.cube import NAMES
from lostmotion.analyses.iso9283.expected_repeatability import expected_repeatability
from lostmotion.analyses.iso9283.frame_fit import residual_after_fit
from lostmotion.analyses.iso9283.paths import PATH_FIGURES, path_figures
from lostmotion.error_model.draws import key
from lostmotion.error_model.pose_matrix import screws
from lostmotion.errors import refuse_argument
from lostmotion.mechanism.inverse import inverse_kinematics
from lostmotion.propagation import exact

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.analyses.iso9283.cube import Cube
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.exact import ExactCheck
    from lostmotion.spatial import Floats

CYCLES: Final = 30
PATH_CYCLES: Final = 10
LOADS: Final = (1.0, 0.1)
ROBOTS: Final = 1000
MOST_ROBOTS: Final = 20_000
MOST_CYCLES: Final = 1000
MOST_PATH_POINTS: Final = 200
MOST_LOADS: Final = 8
# Share of the payload; more is a slip of the unit.
MOST_LOAD: Final = 2.0
PATH_POINTS: Final = 20
# The standard looks at vAP at these, at distances and the path between the last two.
FROM_THREE_SIDES: Final = (0, 1, 3)
DISTANCE: Final = (1, 3)
# Of the cube's side: from how far a pose is approached along an axis.
_APPROACH: Final = 0.1
# A joint that turns or slides by less than this (rad, m) between two poses stands still.
_STILL: Final = 1e-7
_AT_ONCE: Final = 500
SHOWN_ROBOTS: Final = 3
_CHECKED: Final = 8
# Numbers of the poses of each experiment, so that each has visits of its own while robots are the same.
_NUMBERS: Final = {"cycle": 0, "sides": 1_000, "path": 2_000}


@dataclass(frozen=True)
class LoadSheet:
    """What was found under one load, robot by robot, m and rad.

    load                  share of the payload
    barycentre, turn      (pose, robot, 3) the average error of a robot's visits, and its rotation: AP_x, AP_y, AP_z and AP_a, AP_b, AP_c
    repeatability         (pose, robot) RP_l
    scatter               (pose, robot, 6) 3 s about and along the axes: RP_a, RP_b, RP_c first
    fitted                (pose, robot) AP_p left once each robot's base frame fits best over the five poses
    expected, deviation   (pose,) mean and standard deviation of RP_l if visits scattered normally with the terms' covariance: no samples
    limit                 (pose,) and what it would tend to with more and more visits
    from_any_side         (pose, robot) RP_l if every joint arrived from either side at random, so that nothing held the side of its play
    shown                 (robot, pose, visit, 3) errors of the first robots, for a plot
    multi_directional     (3, robot) vAP_p at P1, P2 and P4
    distance              (2, robot) AD_p and RD between P2 and P4
    path                  (8, robot) `PATH_FIGURES` along the line
    path_profile          (8, point, 2) the same at each point: mean over robots, 95 % of robots below
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

    @property
    def accuracy(self) -> Floats:
        """Give AP_p (pose, robot), m."""
        return np.asarray(np.linalg.norm(self.barycentre, axis=-1))


@dataclass(frozen=True)
class PredictedRobots:
    """What was found for robots built to one design.

    approach (5, joint)  sign with which each joint arrives in the cycle
    still                names of joints that do not move in the cycle
    loads                a sheet for each load, the full one first
    path_ends            which poses the path joins
    path_points, path_cycles  how many points of it were looked at, and how often it was run
    check                how far the sum of small errors stands off their exact composition, on a sample at the five poses
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
    """What would the sheet of ISO 9283 say of robots built to this design, in this cube?

    cycles   visits to each pose (the standard's 30), in the order P5, P4, P3, P2, P1
    robots   how many are built
    path     the poses that the line for AT and RT joins, 0 for P1; it is run `path_cycles` times (the standard's 10), looked at in `path_points`
    loads    shares of the payload
    instrument  standard deviation, m, of the readings of positions that are added: what the sheet would look like through it
    Raises InputError for numbers out of range, and for a path that the arm cannot follow.
    """
    for name, value, least, most in (
        ("robots", robots, 2, MOST_ROBOTS),
        ("cycles", cycles, 2, MOST_CYCLES),
        ("path_points", path_points, 2, MOST_PATH_POINTS),
        ("path_cycles", path_cycles, 2, MOST_CYCLES),
        ("loads", len(loads), 1, MOST_LOADS),
    ):
        if not least <= value <= most:
            raise refuse_argument(name, value, f"from {least} to {most}", **{name: 30})
    if not all(0 <= load <= MOST_LOAD for load in loads):
        raise refuse_argument("loads", tuple(loads), f"shares of the payload, from 0 to {MOST_LOAD:g}", loads=LOADS)
    told = progress or (lambda _what, _done, _of: None)
    steps = 3 * len(loads)
    arrives, still = cycle_approach(cube.q)
    sheets = []
    for number, load in enumerate(loads):
        loaded = with_payload_share(arm, load)
        told("visiting the five poses", 3 * number, steps)
        at_poses = _at_poses(loaded, cube, arrives, seed, _NUMBERS["cycle"] + len(NAMES) * number, robots, cycles, instrument)
        told("arriving from three sides", 3 * number + 1, steps)
        first = _NUMBERS["sides"] + 3 * len(FROM_THREE_SIDES) * number
        sides = _from_sides(loaded, cube, arrives, seed, first, robots, cycles, instrument)
        told("following the path", 3 * number + 2, steps)
        first = _NUMBERS["path"] + MOST_PATH_POINTS * number
        profile, along = _along_path(loaded, cube, arrives, path, path_points, seed, first, robots, path_cycles, instrument)
        sheets.append(LoadSheet(load=load, multi_directional=sides, path=along, path_profile=profile, **at_poses))
    return PredictedRobots(
        arm,
        cube,
        cycles,
        robots,
        seed,
        arrives,
        tuple(joint.name for joint, stands in zip(arm.moving, still, strict=True) if stands),
        tuple(sheets),
        path,
        path_points,
        path_cycles,
        exact.check(screws(arm, cube.q, approach=arrives), 0, np.arange(len(NAMES)), seed, min(robots, _CHECKED), min(cycles, _CHECKED)),
    )


def cycle_approach(q: Floats) -> tuple[Floats, np.ndarray]:
    """With which sign does every joint arrive at P1 to P5 (5, joint), in the cycle P5, P4, P3, P2, P1, and which joints never move (joint,)?

    A joint that stands still between two poses keeps the sign of its motion before; one that never moves rests where it is, said as +1. Joints turn
    straight from pose to pose.
    """
    before = np.roll(q, -1, axis=0)
    signs = np.where(np.abs(q - before) < _STILL, 0.0, np.sign(q - before))
    still = np.asarray(~signs.any(axis=0))
    for _ in range(len(q)):
        signs = np.where(signs == 0, np.roll(signs, -1, axis=0), signs)
    return np.where(still, 1.0, signs), still


def with_payload_share(arm: Arm, share: float) -> Arm:
    """How is the arm with a share of its payload, of its mass and of the process force and moment? Its drives, and their friction, stay the same."""
    payload = arm.payload
    lighter = payload.model_copy(
        update={
            "mass": payload.mass * share,
            "force": tuple(share * x for x in payload.force),
            "moment": tuple(share * x for x in payload.moment),
        }
    )
    return arm if share == 1 else arm.carrying(lighter)


def _errors(matrix: PoseMatrix, row: int, number: int, seed: int, robots: int, visits: int, instrument: float) -> Floats:
    """Give the tool's error (robot, visit, 6) at one pose, rad and m: what the study's kernel would draw for pose `number`, and the readings' own."""
    out = np.empty((robots, visits, 6))
    for first in range(0, robots, _AT_ONCE):
        last = min(first + _AT_ONCE, robots)
        robot, visit = (axis.ravel() for axis in np.meshgrid(np.arange(first, last), np.arange(visits), indexing="ij"))
        draws = exact.draws_of(matrix, seed, number, robot, visit)
        out[first:last] = (matrix.tool[row] @ draws).T.reshape(last - first, visits, 6)
    if instrument:
        readings = np.random.Generator(np.random.Philox(key=key(seed, f"iso9283.readings.{number}")))
        out[..., 3:] += instrument * readings.standard_normal((robots, visits, 3))
    return out


def visit_covariance(matrix: PoseMatrix) -> Floats:
    """How do the visits of one robot scatter (pose, 3, 3), m^2, on the average over robots? Exact sum over terms."""
    errors = matrix.merged
    shift = errors.tool[:, 3:][:, :, errors.columns("visit", "robot x visit")]
    return np.asarray(shift @ np.swapaxes(shift, 1, 2))


def _at_poses(  # noqa: PLR0913, PLR0917 - one experiment's numbers
    arm: Arm, cube: Cube, arrives: Floats, seed: int, first: int, robots: int, cycles: int, instrument: float
) -> dict[str, Floats]:
    """Give what a `LoadSheet` holds of the five poses and of the distance between two of them."""
    matrix, loose = screws(arm, cube.q, approach=arrives), screws(arm, cube.q)
    errors = np.stack([_errors(matrix, k, first + k, seed, robots, cycles, instrument) for k in range(len(NAMES))])
    shift, turn = errors[..., 3:], errors[..., :3]
    barycentre = iso.axis_accuracy(shift)
    command = cube.poses[:, :3, 3]
    covariance = visit_covariance(matrix) + instrument**2 * np.eye(3)
    expected, deviation = expected_repeatability(covariance, cycles)
    a, b = DISTANCE
    ends = command[a] + shift[a], command[b] + shift[b]
    far = float(np.linalg.norm(command[b] - command[a]))
    either = np.stack([_errors(loose, k, first + k, seed, robots, cycles, instrument)[..., 3:] for k in range(len(NAMES))])
    return {
        "barycentre": barycentre,
        "turn": iso.axis_accuracy(turn),
        "repeatability": iso.pose_repeatability(shift),
        "scatter": iso.axis_repeatability(errors),
        "fitted": np.linalg.norm(residual_after_fit(barycentre, command), axis=-1),
        "expected": expected,
        "deviation": deviation,
        "limit": expected_repeatability(covariance)[0],
        "random_approach": iso.pose_repeatability(either),
        "shown": shift[:, : min(robots, SHOWN_ROBOTS)].swapaxes(0, 1).copy(),
        "distance": np.stack([iso.distance_accuracy(*ends, far), iso.distance_repeatability(*ends)]),
    }


def _from_sides(  # noqa: PLR0913, PLR0917 - one experiment's numbers
    arm: Arm, cube: Cube, arrives: Floats, seed: int, first: int, robots: int, cycles: int, instrument: float
) -> Floats:
    """Give vAP (pose, robot): each pose approached along the base's x, y and z."""
    out = np.empty((len(FROM_THREE_SIDES), robots))
    for row, pose in enumerate(FROM_THREE_SIDES):
        q = np.tile(cube.q[pose], (3, 1))
        matrix = screws(arm, q, approach=side_approach(arm, cube, pose, arrives[pose]))
        number = first + 3 * row
        shift = np.stack([_errors(matrix, k, number + k, seed, robots, cycles, instrument)[..., 3:] for k in range(3)], axis=1)
        out[row] = iso.multi_directional_accuracy(shift)
    return out


def side_approach(arm: Arm, cube: Cube, pose: int, otherwise: Floats) -> Floats:
    """With which sign does each joint arrive (3, joint) at one of the five poses, coming along the base's x, y and z?

    From a tenth of the cube's side away, on the side of the cube's middle, so that all of it is within reach; at the middle itself coming along the
    axes' own directions. Joints that stand still then keep the sign of the cycle, `otherwise` (joint,).
    """
    here = cube.poses[pose]
    inward = np.sign(cube.centre - here[:3, 3])
    before = np.tile(here, (3, 1, 1))
    before[:, :3, 3] += np.diag(np.where(np.abs(cube.centre - here[:3, 3]) < _STILL, -1.0, inward)) * (_APPROACH * cube.side)
    q, reached = inverse_kinematics(arm, before, np.tile(cube.q[pose], (3, 1)), turned=cube.rotation is not None)
    if not reached.all():
        raise refuse_argument("cube", f"no way to {NAMES[pose]} along the base's axes", "a smaller cube, within reach")
    moved = cube.q[pose] - q
    return np.asarray(np.where(np.abs(moved) < _STILL, otherwise, np.sign(moved)))


def path_poses(arm: Arm, cube: Cube, ends: tuple[int, int], points: int) -> Floats:
    """Through which joint values (point, joint) does the straight line between two of the five poses lead?

    Raises InputError where the line is none, or leaves the arm's reach.
    """
    a, b = ends
    if a == b or not {a, b} <= set(range(len(NAMES))):
        raise refuse_argument("path", ends, "two different ones of " + ", ".join(NAMES), path="P2 P4")
    share = np.linspace(0.0, 1.0, points)[:, None]
    wanted = np.tile(cube.poses[a], (points, 1, 1))
    wanted[:, :3, 3] = (1 - share) * cube.poses[a, :3, 3] + share * cube.poses[b, :3, 3]
    q = np.empty((points, cube.q.shape[1]))
    here = cube.q[a]
    for k in range(points):
        found, reached = inverse_kinematics(arm, wanted[k : k + 1], here[None], turned=cube.rotation is not None)
        if not reached[0]:
            raise refuse_argument("path", f"{NAMES[a]} {NAMES[b]}", "a line that the arm can follow without a change of configuration", path="P3 P5")
        q[k] = here = found[0]
    return q


def path_approach(q: Floats, otherwise: Floats) -> Floats:
    """With which sign does each joint arrive at the points q (point, joint) of a path? Those that stand still keep that of the cycle, `otherwise`."""
    steps = np.diff(q, axis=0)
    signs = np.where(np.abs(steps) < _STILL, 0.0, np.sign(steps))
    signs = np.vstack([signs[:1], signs])  # the run-up comes along the line too
    return np.asarray(np.where(signs == 0, otherwise, signs))


def _along_path(  # noqa: PLR0913, PLR0917 - one experiment's numbers
    arm: Arm,
    cube: Cube,
    arrives: Floats,
    ends: tuple[int, int],
    points: int,
    seed: int,
    first: int,
    robots: int,
    cycles: int,
    instrument: float,
) -> tuple[Floats, Floats]:
    """Give `PATH_FIGURES` at each point (8, point, 2), mean over robots and 95 % of them below, and of the whole path (8, robot)."""
    q = path_poses(arm, cube, ends, points)
    matrix = screws(arm, q, approach=path_approach(q, arrives[ends[0]]))
    along = cube.poses[ends[1], :3, 3] - cube.poses[ends[0], :3, 3]
    found = np.empty((len(PATH_FIGURES), points, robots))
    for k in range(points):
        found[:, k] = path_figures(_errors(matrix, k, first + k, seed, robots, cycles, instrument), along)
    profile = np.stack([found.mean(axis=-1), np.quantile(found, 0.95, axis=-1)], axis=-1)
    return profile, found.max(axis=1)
