"""Bodies that pictures of an arm are made of: they connect, lie where the kinematics place them,
and have the sizes of the sections.
"""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import lostmotion
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of, tool_points
from tests.mechanism.test_places import random_tree

if TYPE_CHECKING:
    from lostmotion.mechanism.shape import Body

ROOT = Path(__file__).parents[2]
ARMS = sorted(
    path
    for path in (
        *ROOT.glob("examples/*.toml"),
        *ROOT.glob("examples/*.urdf"),
        *ROOT.glob("examples/paper/*.toml"),
    )
    if path.name != "ur5e.toml"
)
ALUMINIUM = {"young": "70 GPa", "poisson": 0.33, "density": "2700 kg/m^3"}
FRONT = np.array([[1.0, 0, 0], [0, 0, 1]])


def of_links(*links: dict, **joint: object) -> Arm:
    """Return an arm of turning joints with these links."""
    made = [
        {"type": "revolute", "name": f"J{k}", "limits": (-1, 1), **joint, "link": link}
        for k, link in enumerate(links)
    ]
    return Arm.model_validate({"name": "arm", "joints": made})


def ends(body: Body, at: np.ndarray) -> np.ndarray:
    """Return both ends (2, 3) of a body's axis in the base's frame."""
    pose = at[body.place] @ body.pose
    return pose[:3, 3] + np.outer([-0.5, 0.5], pose[:3, 2]) * body.length


def distance(point: np.ndarray, *lines: np.ndarray) -> float:
    """Return the distance of a point from the nearest of these line segments (2, 3)."""
    start, end = np.stack(lines, axis=1)
    step = end - start
    share = np.clip(((point - start) * step).sum(axis=1) / (step**2).sum(axis=1), 0, 1)
    return float(np.linalg.norm(start + share[:, None] * step - point, axis=1).min())


def check_connected(arm: Arm, q: np.ndarray) -> None:
    """Check that bodies join every place to its parent at poses q, and that the column of the base
    reaches from its level to the first seats.
    """
    shape = arm.bodies
    for at in state_of(arm, q).frames.swapaxes(0, 1):
        lines = [ends(body, at) for body in shape]
        for number, place in enumerate(arm.tree.places[1:], start=1):
            here, parent = at[number, :3, 3], at[place.parent, :3, 3]
            if place.parent == 0:
                column = next(
                    ends(body, at)
                    for body in shape
                    if f"{body.name.removesuffix('.base')}.seat" == place.name
                    and body.kind == "base"
                )
                assert distance(here, column) < 1e-12
                assert min(abs(column[:, 2])) < 1e-12 or abs(here[2]) < 0.1
            elif np.linalg.norm(here - parent) > 1e-12:
                # Pieces of a link lie in a row, so every point of the step is on some body.
                middles = [parent + share * (here - parent) for share in np.linspace(0, 1, 7)]
                assert all(distance(point, *lines) < 1e-9 for point in middles), place.name


@pytest.mark.parametrize("path", ARMS, ids=lambda path: path.stem)
def test_the_bodies_of_every_example_connect_and_end_at_the_tool_point(path):
    """From the level of the base to the tool point there is no gap in the picture of an arm, at any
    pose.
    """
    arm = lostmotion.read(path)
    q = sample_poses(arm, 8).q[:3]
    check_connected(arm, q)
    shape = arm.bodies
    placed = np.stack([state_of(arm, q).frames[body.place] @ body.pose for body in shape])
    (tip,) = [k for k, body in enumerate(shape) if body.name == "tool point"]
    np.testing.assert_allclose(placed[tip, :, :3, 3], tool_points(arm, q), atol=1e-12)


def test_the_bodies_of_random_mechanisms_connect():
    """Branches, slides, fixed joints, offsets and tilted feet are drawn without gaps."""
    rng = np.random.default_rng(3)
    for _ in range(8):
        arm = random_tree(rng)
        check_connected(arm, sample_poses(arm, 8).q[:2])


def test_a_joint_is_a_cylinder_along_its_axis_that_it_does_not_leave():
    """A motion of one joint alone turns no point of its own axis, and the axis of its cylinder is
    this line.
    """
    rng = np.random.default_rng(4)
    for _ in range(5):
        arm = random_tree(rng)
        for joint, moved in zip(arm.moving, arm.tree.moved, strict=True):
            if joint.type == "prismatic":
                continue
            (body,) = [body for body in arm.bodies if body.name == joint.name]
            q = np.tile(sample_poses(arm, 1).q[:1], (2, 1))
            q[1, arm.moving.index(joint)] += 0.5
            line = ends(body, state_of(arm, q[:1]).frames[:, 0])
            in_link = [
                np.linalg.inv(at) @ np.append(line[1], 1) for at in state_of(arm, q).frames[moved]
            ]
            np.testing.assert_allclose(in_link[0], in_link[1], atol=1e-12)
            assert distance(state_of(arm, q).frames[moved, 0, :3, 3], line) < 1e-12


def test_a_slide_is_a_rail_over_its_travel():
    """At either limit the carriage of a sliding joint is at an end of its rail."""
    lift = {"type": "prismatic", "name": "lift", "limits": ["100 mm", "700 mm"], "axis": "x"}
    arm = Arm.model_validate({"name": "lift", "joints": [lift]})
    shape = {body.name: body for body in arm.bodies}
    for value, end in ((0.1, 0), (0.7, 1)):
        at = state_of(arm, np.array([[value]])).frames[:, 0]
        np.testing.assert_allclose(
            (at[shape["lift"].place] @ shape["lift"].pose)[:3, 3],
            ends(shape["lift.rail"], at)[end],
            atol=1e-12,
        )


@pytest.mark.parametrize(
    ("section", "form", "size"),
    [
        ({"kind": "tube", "outer": "80 mm", "wall": "4 mm"}, "round", (0.08, 0.08)),
        ({"kind": "rod", "diameter": "30 mm"}, "round", (0.03, 0.03)),
        ({"kind": "box", "width": "50 mm", "height": "70 mm", "wall": "3 mm"}, "box", (0.05, 0.07)),
        (
            {"kind": "I", "width": "50 mm", "height": "80 mm", "web": "4 mm", "flange": "6 mm"},
            "box",
            (0.05, 0.08),
        ),
        (
            {"kind": "outline", "points": [["0 mm", "0 mm"], ["40 mm", "0 mm"], ["0 mm", "60 mm"]]},
            "box",
            (0.04, 0.06),
        ),
    ],
)
def test_a_link_has_the_outer_size_of_its_section(section, form, size):
    """Width lies along the joint's axis and height across it, so a link seen along the axis is as
    high as its section.
    """
    arm = of_links({"length": "400 mm", "section": section, "material": ALUMINIUM}, axis="-y")
    (body,) = [body for body in arm.bodies if body.kind == "link"]
    assert (body.form, body.stated) == (form, True)
    np.testing.assert_allclose(body.near, size)
    seen = body.silhouette(state_of(arm, np.zeros((1, 1))).frames[body.place, 0], FRONT)
    np.testing.assert_allclose(np.ptp(seen, axis=0), (0.4, size[1]))


def test_a_custom_section_is_drawn_as_a_circle_of_equal_area():
    """Its figures state no size; the area is kept."""
    figures = {
        "kind": "custom",
        "area": "540 mm^2",
        "i_y": "2.2e5 mm^4",
        "i_z": "2.2e5 mm^4",
        "torsion": "4.4e5 mm^4",
    }
    (body,) = [
        body
        for body in of_links({"length": "1 m", "section": figures, "material": ALUMINIUM}).bodies
        if body.kind == "link"
    ]
    assert math.pi / 4 * body.near[0] ** 2 == pytest.approx(540e-6)


def test_layers_have_the_size_of_all_of_them():
    """A sandwich is as high as the distance between its outer faces."""
    face = {
        "section": {"kind": "rectangle", "width": "60 mm", "height": "2 mm"},
        "material": ALUMINIUM,
    }
    section = {
        "kind": "composite",
        "layers": [{**face, "offset": "19 mm"}, {**face, "offset": "-19 mm"}],
    }
    (body,) = [
        body
        for body in of_links({"length": "1 m", "section": section}).bodies
        if body.kind == "link"
    ]
    np.testing.assert_allclose(body.near, (0.06, 0.04))


def test_steps_and_tapers_lie_in_a_row_along_the_link():
    """The volume of their convex bodies is that of the cylinders and frusta of a textbook."""
    tube = {"kind": "rod", "diameter": "60 mm"}, {"kind": "rod", "diameter": "30 mm"}
    steps = {
        "kind": "stepped",
        "steps": [
            {"length": "100 mm", "section": tube[0]},
            {"length": "300 mm", "section": tube[1]},
        ],
    }
    taper = {
        "kind": "tapered",
        "stations": [{"at": "0 mm", "section": tube[0]}, {"at": "400 mm", "section": tube[1]}],
    }
    for section, expected in (
        (steps, math.pi * (0.1 * 0.03**2 + 0.3 * 0.015**2)),
        (taper, math.pi * 0.4 / 3 * (0.03**2 + 0.03 * 0.015 + 0.015**2)),
    ):
        arm = of_links({"length": "400 mm", "section": section, "material": ALUMINIUM}, axis="y")
        links = [body for body in arm.bodies if body.kind == "link"]
        at = state_of(arm, np.zeros((1, 1))).frames[:, 0]
        lines = [ends(body, at) for body in links]
        assert all(np.allclose(one[1], other[0]) for one, other in itertools.pairwise(lines))
        np.testing.assert_allclose(
            (lines[0][0], lines[-1][1]), ([0, 0, 0], [0.4, 0, 0]), atol=1e-12
        )
        # area of a polygon of 48 sides over that of its circle
        inscribed = 48 / (2 * math.pi) * math.sin(2 * math.pi / 48)
        assert sum(ConvexHull(body.corners()).volume for body in links) == pytest.approx(
            expected * inscribed
        )


def test_links_without_sections_are_thinner_towards_the_tool():
    """Sizes that the file does not state fit the arm: an arm ten times as large has bodies ten
    times as large, and none counts as stated.
    """
    small, large = (
        of_links({"length": length}, {"length": length}, {"length": length}).bodies
        for length in ("0.1 m", "1 m")
    )
    thick = [body.near[0] for body in small if body.kind == "link"]
    assert thick == sorted(thick, reverse=True)
    assert thick[0] < 0.1
    for one, other in zip(small, large, strict=True):
        np.testing.assert_allclose(np.multiply(10, one.near), other.near)
        assert not one.stated


def test_the_silhouette_of_a_ball_is_a_circle_in_any_view():
    """A sphere has the same outline from every side, and its area is that of its great circle."""
    (ball,) = [body for body in of_links({"length": "1 m"}).bodies if body.form == "sphere"]
    for view in (FRONT, np.eye(3)[:2], np.array([[0.6, 0.8, 0], [0, 0, 1.0]])):
        outline = ball.silhouette(np.eye(4), view)
        x, y = outline.T
        assert (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2 == pytest.approx(
            math.pi / 4 * ball.length**2, rel=0.01
        )


def test_the_payload_is_drawn_at_its_centre_of_mass():
    """A held mass turns the last joint by its weight times the distance of the drawn point from the
    axis.
    """
    arm = lostmotion.read(ROOT / "examples" / "z-arm.toml")
    q = sample_poses(arm, 1).q[:1]
    (payload,) = [body for body in arm.bodies if body.kind == "payload"]
    point = (state_of(arm, q).frames[payload.place, 0] @ payload.pose)[:3, 3]
    empty = arm.with_payload(arm.payload.model_copy(update={"mass": 0.0}))
    added = state_of(arm, q).torques - state_of(empty, q).torques
    for joint, moved, torque in zip(arm.moving, arm.tree.moved, added[0], strict=True):
        frame = state_of(arm, q).frames[moved, 0]
        moment = np.cross(point - frame[:3, 3], arm.payload.mass * arm.gravity_in_base)
        assert torque == pytest.approx(-moment @ frame[:3, :3] @ joint.twist[:3], abs=1e-9)
