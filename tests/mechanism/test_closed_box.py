"""Poses of closed chains that are sampled in a box of the tool."""

from __future__ import annotations

import functools
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import kstest

import lostmotion
from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import InputError
from lostmotion.io.arm_templates import template_text
from lostmotion.io.native import arm_of
from lostmotion.mechanism.assembly import assembled, drives_at, pose_ranges
from lostmotion.mechanism.inverse import tool_and_jacobian

EXAMPLES = Path(__file__).parents[2] / "examples" / "closed-chains"
# Boxes of which the tool reaches every pose.
WHOLE = {
    "five-bar": {"x": ["60 mm", "140 mm"], "y": ["440 mm", "520 mm"]},
    "delta-printer": {
        "x": ["-30 mm", "30 mm"],
        "y": ["-30 mm", "30 mm"],
        "z": ["50 mm", "95 mm"],
    },
    "hexapod": {
        "x": ["-10 mm", "10 mm"],
        "y": ["-10 mm", "10 mm"],
        "z": ["475 mm", "490 mm"],
        "rz": ["-2 deg", "2 deg"],
    },
}
VALIDATES = (
    (
        "poses of a five-bar, a delta and a hexapod sampled in a box of the tool",
        "uniform distribution (Kolmogorov-Smirnov), forward kinematics",
        "p > 0.001; 1e-9 m and rad",
        "mechanism/closed_box.py",
    ),
)


def boxed(name: str, **box: object):
    """Return an example with this box of its tool."""
    tables = tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8"))
    return arm_of("test.toml", {**tables, "workspace": box} if box else tables)


@pytest.mark.parametrize("name", WHOLE)
def test_positions_of_the_tool_are_uniform_in_its_box(name):
    """Each stated component of the tool's pose is uniform within its limits; the orientation is
    that of home where no rotation is stated.
    """
    arm = boxed(name, **WHOLE[name])
    q = sample_poses(arm, 1024, "uniform").q
    tools, home = tool_and_jacobian(arm, q)[0], tool_and_jacobian(arm, arm.home[None])[0][0]
    turned = Rotation.from_matrix(tools[:, :3, :3] @ home[:3, :3].T).as_rotvec()
    reached = np.hstack([turned, tools[:, :3, 3]])
    for component, (low, high) in arm.workspace.stated.items():
        assert kstest(reached[:, component], "uniform", (low, high - low)).pvalue > 0.001
    if name == "hexapod":
        np.testing.assert_allclose(turned[:, :2], 0.0, atol=1e-8)


@pytest.mark.parametrize("name", WHOLE)
def test_the_tool_is_where_the_box_has_it(name):
    """Inverse and forward kinematics agree to 1e-9 in every component that is stated."""
    arm = boxed(name, **WHOLE[name])
    low, high = pose_ranges(arm).T
    values = np.random.default_rng(1).uniform(low, high, (200, len(low)))
    q, inside = drives_at(arm, values)
    assert inside.all()
    assert assembled(arm, q).all()
    wanted = arm.workspace.poses_at(values, tool_and_jacobian(arm, arm.home[None])[0][0])
    tools = tool_and_jacobian(arm, q)[0]
    np.testing.assert_allclose(tools[:, :3, 3], wanted[:, :3, 3], atol=1e-9)
    if name == "hexapod":
        np.testing.assert_allclose(tools, wanted, atol=2e-9)


@pytest.mark.parametrize(
    ("name", "box"),
    [
        ("five-bar", {"z": ["-10 mm", "10 mm"]}),
        ("delta-printer", {"rz": ["-1 deg", "1 deg"]}),
        ("hexapod", {"rz": ["-180 deg", "180 deg"]}),
    ],
)
def test_a_box_that_the_drives_do_not_control_is_refused(name, box):
    """A five-bar has no height, a delta no rotation, and half a turn has no one rotation vector."""
    with pytest.raises(InputError, match="workspace"):
        boxed(name, **box)


def test_a_box_of_a_serial_arm_is_refused():
    """The joint limits are the ranges of an arm without closures."""
    text = (EXAMPLES.parent / "planar-2r.toml").read_text(encoding="utf-8")
    tables = {**tomllib.loads(text), "workspace": {"x": ["0 mm", "100 mm"]}}
    with pytest.raises(InputError, match="without closures"):
        arm_of("test.toml", tables)


def test_poses_outside_the_limits_of_a_drive_are_counted_and_excluded():
    """A box larger than the reach: its poses within the limits remain, and the note states why the
    others do not.
    """
    arm = boxed("delta-printer", x=["-200 mm", "200 mm"], y=["-50 mm", "50 mm"])
    q = sample_poses(arm, 256).q
    low, high = arm.limits.T
    assert ((q >= low) & (q <= high)).all()
    assert assembled(arm, q).all()
    note = next(each for each in arm.remarks if "excluded, of 256" in each)
    assert "of the tool" in note
    assert "in its box" in note
    assert "a drive outside its limits" in note


@pytest.mark.parametrize("name", WHOLE)
def test_every_pose_within_the_limits_of_the_drives_is_found_from_its_tool(name):
    """Poses that the drives reach are not lost by starting the inverse kinematics at home."""
    plain = boxed(name)
    q = sample_poses(plain, 256).q
    tools = tool_and_jacobian(plain, q)[0]
    home = tool_and_jacobian(plain, plain.home[None])[0][0]
    if name == "hexapod":
        keys = ("x", "y", "z", "rx", "ry", "rz")
        turned = Rotation.from_matrix(tools[:, :3, :3] @ home[:3, :3].T).as_rotvec()
        values = np.hstack([tools[:, :3, 3], turned])
    else:
        keys = ("x", "y", "z")[: q.shape[1]]
        values = tools[:, : len(keys), 3]
    units = ["m"] * 3 + ["rad"] * 3
    box = {
        key: [f"{values[:, k].min() - 1e-6} {units[k]}", f"{values[:, k].max() + 1e-6} {units[k]}"]
        for k, key in enumerate(keys)
    }
    found, inside = drives_at(boxed(name, **box), values)
    assert inside.mean() > 0.99
    np.testing.assert_allclose(found[inside], q[inside], atol=1e-6)


BEYOND = {"x": ["-20 mm", "20 mm"], "z": ["400 mm", "420 mm"]}


@pytest.mark.parametrize(
    "ask",
    [
        functools.partial(lostmotion.study, poses=64),
        lostmotion.check,
        functools.partial(lostmotion.statics, poses=64),
    ],
    ids=["study", "check", "statics"],
)
def test_a_box_that_the_tool_does_not_reach_is_refused_with_the_reason(ask, tmp_path):
    """The carriages of a delta would leave their towers: every question says so at once, and where
    the tool is at home.
    """
    limits = "".join(f"{key} = {json.dumps(value)}\n" for key, value in BEYOND.items())
    text = (EXAMPLES / "delta-printer.toml").read_text(encoding="utf-8")
    (tmp_path / "far.toml").write_text(f"{text}\n[workspace]\n{limits}", encoding="utf-8")
    with pytest.raises(InputError, match="100 % a drive outside its limits") as refused:
        ask(tmp_path / "far.toml")
    (problem,) = refused.value.problems
    assert problem.key == "workspace"
    assert "(0, 0, 75.501) mm at home" in problem.expected


@pytest.mark.slow
def test_a_box_that_the_tool_hardly_reaches_is_given_up_early():
    """A corner of a box is found among few poses, or the search ends: 64 times as many poses are
    not tried where one in a thousand is reached.
    """
    arm = boxed("delta-printer", x=["-20 mm", "20 mm"], z=["94 mm", "10 m"])
    with pytest.raises(InputError, match="of 1024 poses"):
        sample_poses(arm, 1024)


@pytest.mark.slow
def test_a_sweep_in_a_box_has_the_errors_of_its_study(tmp_path):
    """The streamed poses of a sweep are in the box of the tool as those of a study are."""
    path = tmp_path / "boxed.toml"
    text = (EXAMPLES / "five-bar.toml").read_text(encoding="utf-8")
    limits = "".join(f"{key} = {json.dumps(value)}\n" for key, value in WHOLE["five-bar"].items())
    path.write_text(f"{text}\n[workspace]\n{limits}", encoding="utf-8")
    given = {"poses": 16, "robots": 16, "visits": 2}
    by = {"joints.left.link.length": ["250 mm ± 30 µm", "245 mm ± 30 µm"]}
    swept = lostmotion.sweep(path, by=by, out=tmp_path / "run", **given)
    study = lostmotion.study(path, **given)
    for key in ("mean", "rms", "p95"):
        one = swept.outcomes[0].figures[key].value
        assert one == pytest.approx(study.figures[key].value, rel=1e-3 if key == "p95" else 1e-9)
    outside = lostmotion.study(EXAMPLES / "five-bar.toml", **given)
    assert abs(outside.figures["mean"].value / study.figures["mean"].value - 1) > 0.01


def test_notes_state_how_often_a_chain_is_over_constrained():
    """A five-bar in space three times; a hexapod never."""
    of_five_bar, of_hexapod = (
        " ".join(arm_of("test.toml", tomllib.loads(template_text(name))).remarks)
        for name in ("five-bar", "hexapod")
    )
    assert "over-constrained 3 times" in of_five_bar
    assert "exactly constrained" in of_hexapod
