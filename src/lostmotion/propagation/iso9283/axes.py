"""Positioning of simulated robots along and about each axis of the base, as makers of positioners
state it: by ISO 230-2:2014, over the travel of one axis at a time, the others at rest.

Lines lead through P1 of the test cube: along x, y and z, and where the arm has six joints or more
about them, a, b and c, with the tool point at rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.trust import refuse_untrusted
from lostmotion.laws.iso230 import APPROACHES, POSITIONS, positioning
from lostmotion.mechanism.inverse import inverse_kinematics
from lostmotion.mechanism.standing import standing
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.iso9283.cube import STEPS
from lostmotion.propagation.iso9283.joint_motion import path_approach
from lostmotion.spatial import exp

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.iso9283.cube import Cube
    from lostmotion.propagation.iso9283.experiment import Experiment
    from lostmotion.spatial import Floats

REPEATABILITY: Final = "unidirectional repeatability"
# Names of the components of a twist.
_NAMES: Final = ("a", "b", "c", "x", "y", "z")
_TURNS: Final = 3
# Share of the travel that is kept free at either end: there is no way to an end from beyond it.
_FREE: Final = 0.1
# Steps along the travel: rad, and as a share of the cube's side; halved so often at an end.
_STEP: Final = (np.radians(5.0), 0.1)
_HALVINGS: Final = 6
_MOST_STEPS: Final = 1000
# A turning joint that moves farther within a step has changed the configuration, rad.
_SAME: Final = 0.5


@dataclass(frozen=True)
class AxisTest:
    """Positioning of simulated robots along or about one axis, m or rad.

    axis       x, y or z along the base's axes; a, b or c about them
    travel     (2,) how far the tool moves from P1 to either side
    positions  (position,) target positions from P1
    q          (position, joint) joint values there
    figures    by their symbols (`laws.iso230.positioning`), each (robot,); the first side is that
               of positive motion
    """

    axis: str
    travel: Floats
    positions: Floats
    q: Floats
    figures: dict[str, Floats]

    @property
    def turns(self) -> bool:
        """Return whether the tool turns about the axis."""
        return self.axis in _NAMES[:_TURNS]

    @property
    def stated(self) -> dict[str, Floats]:
        """Return the figures that makers state, by name, each (robot,): those of the worst
        position.
        """
        return {
            REPEATABILITY: np.maximum(self.figures["R1"], self.figures["R2"]),
            "reversal": self.figures["B"],
            "accuracy": self.figures["A"],
        }


def axis_tests(
    arm: Arm, cube: Cube, otherwise: Floats, visiting: Experiment, first: int
) -> tuple[AxisTest, ...]:
    """Return the positioning along and about each axis in which the tool moves from P1 of the cube.

    otherwise  (joint,) side of joints that do not move
    first      number of the first pose, of twice the positions of six axes
    """
    few = replace(visiting, visits=APPROACHES)
    out = []
    for axis, travel, positions, q in _lines(arm, cube):
        refuse_untrusted(arm, q, 0.0)
        state = standing(state_of(arm, q))
        ways = (path_approach(q, otherwise), path_approach(q[::-1], otherwise)[::-1])
        number = first + 2 * POSITIONS * axis
        errors = np.stack(
            [
                few.at_all(screws(state, approach=approach), number + POSITIONS * side)[..., axis]
                for side, approach in enumerate(ways)
            ]
        )
        figures = positioning(errors.mean(axis=-1), errors.std(axis=-1, ddof=1))
        out.append(AxisTest(_NAMES[axis], travel, positions, q, figures))
    return tuple(out)


def _lines(arm: Arm, cube: Cube) -> list[tuple[int, Floats, Floats, Floats]]:
    """Return the component of the tool's twist of each axis in which the tool moves, its travel
    (2,), the target positions (position,), m or rad, and the joint values there (position, joint).
    """
    axes = np.arange(0 if cube.rotation is not None else _TURNS, len(_NAMES))
    rows = np.repeat(axes, 2)
    ways = np.tile([-1.0, 1.0], len(axes))
    turns = rows < _TURNS
    step = np.where(turns, _STEP[0], _STEP[1] * cube.side)
    most, finest = np.where(turns, np.pi, np.inf), step * 2.0**-_HALVINGS
    at, q = np.zeros(len(rows)), np.tile(cube.q[0], (len(rows), 1))
    passed = [(at.copy(), q.copy())]
    for _ in range(_MOST_STEPS):
        moving = np.flatnonzero((step >= finest) & (at + step <= most))
        if not len(moving):
            break
        ahead = at[moving] + step[moving]
        found, ok = _moved(arm, cube, rows[moving], ways[moving] * ahead, q[moving])
        at[moving[ok]], q[moving[ok]] = ahead[ok], found[ok]
        step[moving[~ok]] /= 2
        passed.append((at.copy(), q.copy()))
    out = []
    for k, axis in enumerate(axes.tolist()):
        travel = ways[2 * k : 2 * k + 2] * at[2 * k : 2 * k + 2]
        free = _FREE * np.ptp(travel)
        positions = np.linspace(travel[0] + free, travel[1] - free, POSITIONS)
        along = np.array(
            [ways[row] * each[row] for each, _ in passed for row in (2 * k, 2 * k + 1)]
        )
        values = np.array([each[row] for _, each in passed for row in (2 * k, 2 * k + 1)])
        near = np.abs(along - positions[:, None]).argmin(axis=1)
        reached, ok = _moved(arm, cube, np.full(POSITIONS, axis), positions, values[near])
        if at[2 * k : 2 * k + 2].all() and ok.all():
            out.append((axis, travel, positions, reached))
    return out


def _moved(
    arm: Arm, cube: Cube, rows: NDArray[np.int64], moved_by: Floats, start: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return joint values (pose, joint) with the tool moved from P1 by `moved_by` (pose,), m or
    rad, along or about axes by the component of its twist (pose,), and whether they are reached
    without a change of configuration.
    """
    twists = np.zeros((len(rows), len(_NAMES)))
    twists[np.arange(len(rows)), rows] = moved_by
    motion = exp(twists)
    wanted = np.tile(cube.poses[0], (len(rows), 1, 1))
    wanted[:, :3, :3] = motion[:, :3, :3] @ wanted[:, :3, :3]
    wanted[:, :3, 3] += motion[:, :3, 3]
    # a step that is reached takes at most six iterations, for every example
    q, reached = inverse_kinematics(
        arm, wanted, start, with_orientation=cube.rotation is not None, steps=STEPS
    )
    turning = np.array([joint.type == "revolute" for joint in arm.driven])
    return q, reached & ~((np.abs(q - start) > _SAME) & turning).any(axis=1)
