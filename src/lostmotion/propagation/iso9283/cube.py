"""Test cube and five poses of ISO 9283:1998, 6.8, and whether an arm reaches all of the cube
(largest cube: `largest_cube.py`).

Edges parallel to the base's axes; five poses on the diagonals of the plane C1-C2-C7-C8: P1 in the
centre, P2 to P5 a tenth of a diagonal from its ends. Corners are numbered C1 to C4 around the lower
face, from least x and y by way of largest x, and C5 to C8 above them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import refuse_argument
from lostmotion.mechanism.inverse import inverse_kinematics
from lostmotion.mechanism.state import state_of, tool_points
from lostmotion.spatial import pose_of

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Most commanded poses at which robots are predicted.
MOST_POSES: Final = 50
# C1 to C8 in half sides from the centre.
CORNERS: Final = np.array(
    [
        [-1, -1, -1],
        [1, -1, -1],
        [1, 1, -1],
        [-1, 1, -1],
        [-1, -1, 1],
        [1, -1, 1],
        [1, 1, 1],
        [-1, 1, 1],
    ],
    dtype=float,
)
# Corners of P2 to P5, and their distance from the centre as a share of the half diagonal.
_BY_CORNER: Final = (0, 1, 6, 7)
INWARD: Final = 0.8
NAMES: Final = ("P1", "P2", "P3", "P4", "P5")
# Usual orientations of a tool: downward, forward.
_DOWN: Final = pose_of(rpy=(math.pi, 0.0, 0.0))[:3, :3]
_FORWARD: Final = pose_of(rpy=(0.0, math.pi / 2, 0.0))[:3, :3]
# Fewest joints for any orientation of the tool.
FULL: Final = 6
SPACE: Final = 3
# Number of sampled poses, and of the nearest ones from which a point is tried.
SAMPLES: Final = 16_384
STARTS: Final = 64
# Joint values at one point that differ by less (rad or m) are one configuration.
SAME_CONFIGURATION: Final = 0.2
# Newton steps from one point to a neighbouring one.
STEPS: Final = 10
# Steps from the centre outward, as shares of the distance.
_OUTWARD: Final = (0.4, 0.75, 1.0)
# Check points along an edge.
_CHECK_POINTS_ALONG: Final = 7


@dataclass(frozen=True)
class Cube:
    """A test cube and the arm in it.

    centre (3,), side   m, base frame
    rotation (3, 3)     orientation of the tool, the same all over the cube; None where the arm has
                        too few joints to choose it
    q (5, joint)        joint values at P1 to P5, rad or m
    poses (5, 4, 4)     commanded poses of the tool
    resolution          last change of the side in the search, m; NaN for a stated cube
    checked             number of points of the cube that the tool reached
    method              how the cube was found, in words; "given" for a stated cube
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
    def names(self) -> tuple[str, ...]:
        """Return P1 to P5."""
        return NAMES

    @property
    def corners(self) -> Floats:
        """Return C1 to C8 (8, 3), m."""
        return self.centre + self.side / 2 * CORNERS


@dataclass(frozen=True)
class CommandedPoses:
    """Poses of a measured file, as `Cube` holds those of the standard.

    names               in the order in which a cycle visits them
    q (pose, joint)     joint values, rad or m
    poses (pose, 4, 4)  the arm's tool there
    rotation            orientation of the tool (3, 3) where it is the same at all poses; None where
                        each has its own
    left                number of commanded poses of the file that are not among them
    """

    names: tuple[str, ...]
    q: Floats
    poses: Floats
    rotation: Floats | None
    left: int


def five_points(centre: Floats, side: float) -> Floats:
    """Return P1 to P5 (5, 3), m: the centre, and a tenth of the diagonal from C1, C2, C7 and C8."""
    return np.asarray(
        centre + side / 2 * INWARD * np.vstack([np.zeros(3), CORNERS[list(_BY_CORNER)]])
    )


def cube_from_arguments(
    arm: Arm, centre: Floats, side: float, rotation: Floats | None = None
) -> Cube:
    """Return the stated cube (centre (3,) and side in m) with its five poses, with constant
    orientation of the tool where the arm can hold one.

    `rotation` (3, 3) of the tool; None: the first feasible one of downward, forward, and that in
    the middle of the joint ranges. With fewer than six joints the orientation follows from the
    position. Raises InputError for an arm that cannot move its tool in space, and where a point is
    out of reach.
    """
    if not (math.isfinite(side) and side > 0):
        raise refuse_argument("cube", side, "a side above zero", cube="400 mm")
    cube = cube_in_reach(arm, centre, side, rotation)
    if cube is None:
        where = ", ".join(f"{x * 1e3:.0f}" for x in centre)
        raise refuse_argument(
            "cube",
            f"{side * 1e3:.0f} mm about ({where}) mm",
            f"a cube that the tool reaches entirely{orientation_clause(arm)} "
            f"({len(check_points())} points are checked): "
            "smaller, elsewhere, or none stated, to search for the largest",
        )
    return cube


def orientation_clause(arm: Arm) -> str:
    """Return ", with constant orientation of the tool" for an arm with six joints or more, else
    nothing.
    """
    return ", with constant orientation of the tool" if len(arm.tree.tool_joints) >= FULL else ""


def cube_in_reach(
    arm: Arm, centre: Floats, side: float, rotation: Floats | None = None
) -> Cube | None:
    """Return the cube as `cube_from_arguments` does; None where a point is out of reach."""
    refuse_planar(arm)
    centre = np.asarray(centre, dtype=float)
    cloud = sample_poses(arm, SAMPLES).q
    near = np.argsort(np.linalg.norm(tool_points(arm, cloud) - centre, axis=1))[:STARTS]
    for orientation in candidate_rotations(arm, rotation):
        q, reached = inverse_kinematics(
            arm,
            poses_at(np.tile(centre, (len(near), 1)), orientation),
            cloud[near],
            with_orientation=orientation is not None,
        )
        kept: list[Floats] = []
        for first in q[reached]:
            if any(np.abs(first - other).max() < SAME_CONFIGURATION for other in kept):
                continue
            kept.append(first)
            cube = verified_cube(
                arm, Candidate(side, centre, first, orientation), math.nan, "given"
            )
            if cube is not None:
                return cube
    return None


def out_of_reach(arm: Arm, points: Floats, rotation: Floats | None = None) -> np.ndarray:
    """Return which points (point, 3), m, the tool reached from none of the nearest sampled poses,
    as a mask (point,).
    """
    cloud = sample_poses(arm, SAMPLES).q
    tools = tool_points(arm, cloud)
    orientation = candidate_rotations(arm, rotation)[0]
    near = [np.argsort(np.linalg.norm(tools - point, axis=1))[:STARTS] for point in points]
    return np.array(
        [
            not inverse_kinematics(
                arm,
                poses_at(np.tile(point, (len(starts), 1)), orientation),
                cloud[starts],
                with_orientation=orientation is not None,
            )[1].any()
            for point, starts in zip(points, near, strict=True)
        ]
    )


@dataclass(frozen=True)
class Candidate:
    """A cube, the joint values at its centre, and the orientation of the tool."""

    side: float
    centre: Floats
    start: Floats
    orientation: Floats | None


def verified_cube(arm: Arm, cube: Candidate, resolution: float, text: str) -> Cube | None:
    """Return a cube with its five poses where the tool reaches all check points in it; else
    None.
    """
    offsets = cube.side / 2 * check_points()
    q, ok = solve_outward(arm, cube.centre, offsets[None], cube, np.ones(1, bool))
    if not ok[0]:
        return None
    five = q[0, : len(NAMES)]
    return Cube(
        cube.centre,
        cube.side,
        cube.orientation,
        five,
        state_of(arm, five).frames[-1],
        resolution,
        len(offsets),
        text,
    )


def refuse_planar(arm: Arm) -> None:
    """Raise InputError for an arm that cannot move its tool in space."""
    if len(arm.tree.tool_joints) < SPACE:
        raise refuse_argument(
            "arm",
            f"{len(arm.tree.tool_joints)} joints that move the tool",
            "at least three, for a test cube is a body in space; `lostmotion study` predicts "
            "error and repeatability of an arm in a plane",
        )


def candidate_rotations(arm: Arm, rotation: Floats | None) -> list[Floats | None]:
    """Return the orientations of the tool to try: the one requested, else three; None with fewer
    than six joints.

    Raises InputError where an orientation is requested from an arm with fewer than six joints.
    """
    if rotation is not None:
        if len(arm.tree.tool_joints) < FULL:
            found = f"an orientation for {len(arm.tree.tool_joints)} joints"
            raise refuse_argument(
                "tool_rpy",
                found,
                "none: with fewer than six joints the orientation follows from the position",
            )
        return [np.asarray(rotation, dtype=float)]
    if len(arm.tree.tool_joints) < FULL:
        return [None]
    return [_DOWN, _FORWARD, state_of(arm, arm.limits.mean(axis=1)).frames[-1, 0, :3, :3]]


def poses_at(points: Floats, orientation: Floats | None) -> Floats:
    """Return poses (point, 4, 4) at points (point, 3), m, with this orientation (3, 3) of the tool;
    None: identity.
    """
    out = np.tile(np.eye(4), (len(points), 1, 1))
    out[:, :3, 3] = points
    if orientation is not None:
        out[:, :3, :3] = orientation
    return out


def check_points() -> Floats:
    """Return the points of a cube at which reach is checked (point, 3), in half sides from its
    centre: P1 to P5, C1 to C8, and a grid.
    """
    line = np.linspace(-1.0, 1.0, _CHECK_POINTS_ALONG)
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.vstack([five_points(np.zeros(3), 2.0), CORNERS, grid])


def solve_outward(
    arm: Arm, origin: Floats, offsets: Floats, initial: Candidate, feasible: np.ndarray
) -> tuple[Floats, np.ndarray]:
    """Bring the tool from the start outward to sets of points about it (set, point, 3), for the
    sets selected by the mask `feasible`.

    Returns q (set, point, joint), and which sets were reached completely.
    """
    q = np.tile(initial.start, (*offsets.shape[:2], 1))
    feasible = feasible.copy()
    for share in _OUTWARD:
        if not feasible.any():
            break
        wanted = poses_at((origin + share * offsets[feasible]).reshape(-1, 3), initial.orientation)
        solved, reached = inverse_kinematics(
            arm,
            wanted,
            q[feasible].reshape(-1, q.shape[-1]),
            with_orientation=initial.orientation is not None,
            steps=STEPS,
        )
        q[feasible] = solved.reshape(-1, *q.shape[1:])
        feasible[feasible] = reached.reshape(-1, q.shape[1]).all(axis=1)
    return q, feasible
