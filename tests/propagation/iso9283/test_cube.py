"""Test cube of ISO 9283: its geometry, and reach of the largest one."""

from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.mechanism.inverse import inverse_kinematics
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.iso9283.cube import CORNERS, cube_from_arguments, five_points
from lostmotion.propagation.iso9283.largest_cube import largest_cube

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "test cube",
        "a gantry's shortest range; random points of the cube reached",
        "two last steps of the search; 99 %",
        "propagation/iso9283/cube.py propagation/iso9283/largest_cube.py",
    ),
)

EXAMPLES = Path(__file__).parents[3] / "examples"


def gantry(ranges=("500 mm", "400 mm", "700 mm")):
    """Return three slides along x, y, z in front of the base."""
    joints = [
        {"name": name, "type": "prismatic", "axis": name.lower(), "limits": ("0 mm", width)}
        for name, width in zip("XYZ", ranges, strict=True)
    ]
    joints[0]["origin"] = {"xyz": ["600 mm", "-200 mm", "100 mm"]}
    return lostmotion.Arm.model_validate({"name": "gantry", "joints": joints})


def test_the_five_poses_stand_on_the_diagonals_of_one_plane():
    """P1 is the centre; the others are a tenth of a diagonal from C1, C2, C7, C8; all are in the
    plane C1-C2-C7-C8.
    """
    centre, side = np.array([0.5, 0.1, 0.3]), 0.4
    corners = centre + side / 2 * CORNERS
    points = five_points(centre, side)
    assert points[0] == pytest.approx(centre)
    for point, (near, far) in zip(points[1:], ((0, 6), (1, 7), (6, 0), (7, 1)), strict=True):
        diagonal = corners[far] - corners[near]
        assert np.linalg.norm(diagonal) == pytest.approx(side * np.sqrt(3))
        assert point == pytest.approx(corners[near] + 0.1 * diagonal)
    normal = np.cross(points[2] - points[1], points[3] - points[1])
    assert (points - points[0]) @ normal == pytest.approx(np.zeros(5), abs=1e-15)


def test_a_gantry_holds_a_cube_of_its_shortest_range():
    """For slides of 500, 400 and 700 mm the largest cube has 400 mm; the one found is no larger and
    hardly smaller.
    """
    arm = gantry()
    cube = largest_cube(arm)
    assert cube.side <= 0.4 + 1e-9
    assert cube.side >= 0.4 - 2 * cube.resolution
    assert cube.rotation is None
    assert (cube.corners.min(axis=0) >= [0.6 - 1e-9, -0.2 - 1e-9, 0.1 - 1e-9]).all()
    assert (cube.corners.max(axis=0) <= [1.1 + 1e-9, 0.2 + 1e-9, 0.8 + 1e-9]).all()


def rail(folder, travel):
    """Read three sliding axes, the first far longer than the others, whose workspace is a beam of
    350 mm by 350 mm.
    """
    ranges = {"x": (0, travel), "y": (0.3, 0.65), "z": (0.2, 0.55)}
    joints = [
        (
            f'[[joints]]\nname = "{axis}"\ntype = "prismatic"\naxis = "{axis}"\nlimits = ["{low} '
            f'm", "{high} m"]\n'
        )
        for axis, (low, high) in ranges.items()
    ]
    path = folder / "rail.toml"
    path.write_text('name = "rail"\n' + "".join(joints), encoding="utf-8")
    return lostmotion.read(path)


@pytest.mark.parametrize("travel", [1, 30])
def test_a_long_rail_has_the_cube_of_its_section(tmp_path, travel):
    """However long the first axis, a workspace of 350 mm by 350 mm holds a cube of that side,
    beside the rail too.
    """
    found = largest_cube(rail(tmp_path, travel))
    assert found.side == pytest.approx(0.35, rel=0.02)
    assert found.side <= 0.35


def test_the_floor_bounds_the_cube():
    """With the floor at 500 mm only 300 mm of height remain."""
    cube = largest_cube(gantry(), floor=0.5)
    assert cube.side == pytest.approx(0.3, abs=0.02)
    assert cube.corners[:, 2].min() >= 0.5 - 1e-9


def test_a_cube_is_reached_all_over():
    """Random points of the cube found for the five-joint arm are reached from its centre; its poses
    are those of the standard.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    cube = largest_cube(arm)
    assert cube.poses[:, :3, 3] == pytest.approx(five_points(cube.centre, cube.side), abs=1e-8)
    assert state_of(arm, cube.q).frames[-1] == pytest.approx(cube.poses)
    assert cube.corners[:, 2].min() >= -1e-9
    wanted = np.tile(np.eye(4), (300, 1, 1))
    wanted[:, :3, 3] = cube.centre + cube.side * np.random.default_rng(1).uniform(
        -0.5, 0.5, (300, 3)
    )
    assert (
        inverse_kinematics(arm, wanted, np.tile(cube.q[0], (300, 1)), with_orientation=False)[
            1
        ].mean()
        > 0.99
    )


@pytest.mark.slow
def test_six_joints_hold_the_tool_in_the_same_way_everywhere():
    """All five poses of the six-joint arm have one orientation, and a slightly smaller stated cube
    there is reachable too.
    """
    arm = lostmotion.read(EXAMPLES / "ur5e.urdf")
    cube = largest_cube(arm)
    assert cube.poses[:, :3, :3] == pytest.approx(np.tile(cube.rotation, (5, 1, 1)), abs=1e-8)
    assert cube.side > 0.5
    again = cube_from_arguments(arm, cube.centre, 0.9 * cube.side, cube.rotation)
    assert again.poses[:, :3, 3] == pytest.approx(
        five_points(cube.centre, 0.9 * cube.side), abs=1e-8
    )


def test_what_cannot_be_is_refused():
    """A cube out of reach, a planar arm, and an orientation for too few joints are refused in one
    message each.
    """
    arm = gantry()
    with pytest.raises(lostmotion.InputError, match="that the tool reaches entirely"):
        cube_from_arguments(arm, np.array([0.85, 0.0, 0.45]), 0.41)
    assert cube_from_arguments(arm, np.array([0.85, 0.0, 0.45]), 0.4).side == 0.4
    with pytest.raises(lostmotion.InputError, match="orientation"):
        largest_cube(arm, np.eye(3))
    two = arm.model_copy(update={"joints": arm.joints[:2]})
    with pytest.raises(lostmotion.InputError, match="at least three"):
        largest_cube(two)
