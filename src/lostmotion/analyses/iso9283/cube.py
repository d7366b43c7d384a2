"""Where does ISO 9283 put its test cube and its five poses, and does the arm reach all of it? The largest cube: `largest_cube.py`.

Geometry by ISO 9283:1998, 6.8: edges parallel to the base's axes, as large as possible, five poses on the diagonals of the plane C1-C2-C7-C8: P1 in
its middle, P2 to P5 a tenth of a diagonal from its ends. The corners are numbered here as C1 to C4 round the lower face, from its corner of least x
and y over that of largest x, and C5 to C8 above them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import refuse_argument
from lostmotion.mechanism.inverse import inverse_kinematics
from lostmotion.mechanism.serial import frames, tool_points
from lostmotion.spatial import pose_of

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Of half a side, from the middle; C1 to C8.
CORNERS: Final = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float)
# Of the corner that each pose stands by: P1 in the middle, P2 to P5 by C1, C2, C7, C8.
_BY_CORNER: Final = (0, 1, 6, 7)
INWARD: Final = 0.8
NAMES: Final = ("P1", "P2", "P3", "P4", "P5")
# The tool as it is mostly held: pointing down; forward; and as the arm has it in the middle of its joints' ranges.
_DOWN: Final = pose_of(rpy=(math.pi, 0.0, 0.0))[:3, :3]
_FORWARD: Final = pose_of(rpy=(0.0, math.pi / 2, 0.0))[:3, :3]
_FULL: Final = 6
SPACE: Final = 3
# Poses of the arm that are sampled, and from how many of the nearest a place is looked for.
SAMPLES: Final = 16_384
STARTS: Final = 64
# Two answers at one place within this, rad or m, are one configuration.
SAME_CONFIGURATION: Final = 0.2
# Newton's steps from one point to the next, where the first is near: they are enough wherever it can be reached.
STEPS: Final = 10
# From the middle outward, in so many steps.
_OUTWARD: Final = (0.4, 0.75, 1.0)
# Points along an edge at which the cube that was found is looked at again.
_CHECK_POINTS_ALONG: Final = 7


@dataclass(frozen=True)
class Cube:
    """A test cube and the arm in it.

    centre (3,), side   m, base frame
    rotation (3, 3)     the tool's, at every point of the cube; None where the arm has too few joints to hold one
    q (5, joint)        joint values at P1 to P5, rad or m
    poses (5, 4, 4)     the commanded poses of the tool
    resolution          m: by how much the side was changed last; NaN where the cube was given
    checked             points of the cube that the tool was brought to
    found_by            how it was come by, in words
    """

    centre: Floats
    side: float
    rotation: Floats | None
    q: Floats
    poses: Floats
    resolution: float
    checked: int
    method: str

    @property
    def corners(self) -> Floats:
        """Give C1 to C8 (8, 3), m."""
        return self.centre + self.side / 2 * CORNERS


def five_points(centre: Floats, side: float) -> Floats:
    """Where do P1 to P5 stand (5, 3), m? In the middle, and a tenth of the diagonal from C1, C2, C7 and C8."""
    return np.asarray(centre + side / 2 * INWARD * np.vstack([np.zeros(3), CORNERS[list(_BY_CORNER)]]))


def cube_from_arguments(arm: Arm, centre: Floats, side: float, rotation: Floats | None = None) -> Cube:
    """Can the tool be brought to every point of this cube (centre (3,) and side in m), held alike where it can be? The cube with its five poses.

    `rotation` (3, 3) of the tool; left out: the first that holds of pointing down, forward, and as in the middle of the joints' ranges. With
    fewer than six joints the orientation comes as it comes. Raises InputError for an arm that cannot move its tool in space, and where a point
    is out of reach.
    """
    if not (math.isfinite(side) and side > 0):
        raise refuse_argument("cube", side, "a side above zero", cube="400 mm")
    cube = cube_in_reach(arm, centre, side, rotation)
    if cube is None:
        where = ", ".join(f"{x * 1e3:.0f}" for x in centre)
        raise refuse_argument(
            "cube",
            f"{side * 1e3:.0f} mm about ({where}) mm",
            f"a cube all of which the tool reaches{orientation_clause(arm)} ({len(check_points())} points of it are checked); "
            "smaller, elsewhere, or found where neither is stated",
        )
    return cube


def orientation_clause(arm: Arm) -> str:
    """Say how the tool is held all over a cube, where the arm has the joints to hold it."""
    return ", held alike" if len(arm.tree.drives) >= _FULL else ""


def cube_in_reach(arm: Arm, centre: Floats, side: float, rotation: Floats | None = None) -> Cube | None:
    """Give what `cube_from_arguments` gives; None where a point is out of reach. Raises InputError for an arm that cannot move its tool in space."""
    refuse_planar(arm)
    centre = np.asarray(centre, dtype=float)
    cloud = sample_poses(arm, SAMPLES).q
    near = np.argsort(np.linalg.norm(tool_points(arm, cloud) - centre, axis=1))[:STARTS]
    for held in candidate_rotations(arm, rotation):
        q, reached = inverse_kinematics(arm, poses_at(np.tile(centre, (len(near), 1)), held), cloud[near], turned=held is not None)
        kept: list[Floats] = []
        for first in q[reached]:
            if any(np.abs(first - other).max() < SAME_CONFIGURATION for other in kept):
                continue
            kept.append(first)
            cube = checked(arm, Candidate(side, centre, first, held), math.nan, "given")
            if cube is not None:
                return cube
    return None


def out_of_reach(arm: Arm, points: Floats, rotation: Floats | None = None) -> np.ndarray:
    """Which of these points (point, 3), m, is the tool brought to from none of many sampled poses? True (point,) for each such."""
    cloud = sample_poses(arm, SAMPLES).q
    tools = tool_points(arm, cloud)
    held = candidate_rotations(arm, rotation)[0]
    near = [np.argsort(np.linalg.norm(tools - point, axis=1))[:STARTS] for point in points]
    return np.array(
        [
            not inverse_kinematics(arm, poses_at(np.tile(point, (len(starts), 1)), held), cloud[starts], turned=held is not None)[1].any()
            for point, starts in zip(points, near, strict=True)
        ]
    )


@dataclass(frozen=True)
class Candidate:
    """A cube, the joint values with which the tool stands in its middle, and how the tool is held."""

    side: float
    centre: Floats
    start: Floats
    held: Floats | None


def checked(arm: Arm, cube: Candidate, resolution: float, text: str) -> Cube | None:
    """Give a cube with its five poses where the tool can be brought to all points of a grid in it; else None."""
    offsets = cube.side / 2 * check_points()
    q, ok = spread(arm, cube.centre, offsets[None], cube, np.ones(1, bool))
    if not ok[0]:
        return None
    five = q[0, : len(NAMES)]
    return Cube(cube.centre, cube.side, cube.held, five, frames(arm, five)[-1], resolution, len(offsets), text)


def refuse_planar(arm: Arm) -> None:
    """Raise InputError for an arm that cannot move its tool in space."""
    if len(arm.tree.drives) < SPACE:
        raise refuse_argument("arm", f"{len(arm.tree.drives)} joints that move the tool", "at least three: a test cube is a body in space")


def candidate_rotations(arm: Arm, rotation: Floats | None) -> list[Floats | None]:
    """How may the tool be held in a cube? As asked (3, 3); else in three ways, or, None, as it comes with fewer than six joints.

    Raises InputError where an orientation is asked of an arm that cannot hold one.
    """
    if rotation is not None:
        if len(arm.tree.drives) < _FULL:
            found = f"an orientation for {len(arm.tree.drives)} joints"
            raise refuse_argument("tool_rpy", found, "none: with fewer than six joints the orientation comes as it comes")
        return [np.asarray(rotation, dtype=float)]
    if len(arm.tree.drives) < _FULL:
        return [None]
    return [_DOWN, _FORWARD, frames(arm, arm.limits.mean(axis=1)[None])[-1, 0, :3, :3]]


def poses_at(points: Floats, held: Floats | None) -> Floats:
    """Give poses (point, 4, 4) at points (point, 3), m, with the tool held so (3, 3); None: unturned."""
    out = np.tile(np.eye(4), (len(points), 1, 1))
    out[:, :3, 3] = points
    if held is not None:
        out[:, :3, :3] = held
    return out


def check_points() -> Floats:
    """Give the points of a cube that are looked at (point, 3), of half a side from its middle: P1 to P5, C1 to C8, and a grid."""
    line = np.linspace(-1.0, 1.0, _CHECK_POINTS_ALONG)
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.vstack([five_points(np.zeros(3), 2.0), CORNERS, grid])


def spread(arm: Arm, origin: Floats, offsets: Floats, begun: Candidate, may: np.ndarray) -> tuple[Floats, np.ndarray]:
    """Bring the tool from where it stands outward to sets of points about it (set, point, 3), for the sets that `may` be reached.

    Gives q (set, point, joint), and which sets were reached whole.
    """
    q = np.tile(begun.start, (*offsets.shape[:2], 1))
    may = may.copy()
    for share in _OUTWARD:
        if not may.any():
            break
        wanted = poses_at((origin + share * offsets[may]).reshape(-1, 3), begun.held)
        solved, reached = inverse_kinematics(arm, wanted, q[may].reshape(-1, q.shape[-1]), turned=begun.held is not None, steps=STEPS)
        q[may] = solved.reshape(-1, *q.shape[1:])
        may[may] = reached.reshape(-1, q.shape[1]).all(axis=1)
    return q, may
