"""The errors by which a calibration completes those of an arm's file."""

from __future__ import annotations

import numpy as np
import pytest

import lostmotion
from lostmotion.calibration.model import model_of
from lostmotion.calibration.terms import Deviations, added_terms
from lostmotion.mechanism.arm import Arm
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.parts.link import Frame, Link
from tests.calibration.ur5_grid import grid_model

ROWS = {
    "full pose": (slice(0, 6), 30, 30),
    "point": (slice(3, 6), 25, 27),
}


def six_axes(beside: float) -> Arm:
    """Build an arm of the UR5's table whose tool is `beside` its last axis, m."""
    rows = ((0, 0.08916, 90), (-0.425, 0, 0), (-0.39225, 0, 0), (0, 0.10915, 90))
    links = [
        Link(tip=Frame(xyz=(a, 0, d), rpy=(np.radians(alpha), 0, 0)))
        for a, d, alpha in (*rows, (0, 0.09456, -90), (0, 0.0823, 0))
    ]
    joints = [RevoluteJoint(name=f"J{k}", limits=(-3, 3), link=x) for k, x in enumerate(links, 1)]
    return Arm(name="six axes", joints=joints, tool={"frame": {"xyz": (beside, 0, 0.03)}})


@pytest.mark.parametrize("measured", ROWS)
@pytest.mark.parametrize("beside", [0.0, 0.08])
def test_ranks_are_those_of_a_complete_set(measured, beside):
    """Of a chain with R turning joints, 4 R + 6 combinations of constant errors move the tool
    (Everett, Driels and Mooring); points resolve three less, and with the tool on the last axis also
    not its zero and one offset.
    """
    arm = six_axes(beside)
    q = np.random.default_rng(1).uniform(-3, 3, (300, 6))
    model = model_of(arm, q, added_terms(arm, Deviations(tool_turn=10e-3)))
    rows, on, off = ROWS[measured]
    columns = model.columns[:, rows].reshape(-1, len(model.streams))
    values = np.linalg.svd(columns, compute_uv=False)
    assert (values > 1e-7 * values[0]).sum() == (off if beside else on)


def test_what_the_file_states_is_not_added():
    """A length along x and a zero of an encoder are stated; tilts and other offsets are not."""
    model, _ = grid_model()
    names = [stream.name for stream in model.streams]
    assert "joints.J2.link.tip offset x" in names
    assert "joints.J3.seat.tilt 1" in names
    assert "joints.J3.seat.turn" not in names
    assert sum(name.startswith("joints.J3.seat.offset") for name in names) == 1
    assert not any(name.startswith("joints.J1.seat") for name in names)


def test_the_nominal_arm_is_the_one_without_draws():
    """With all draws zero the frames are those of the nominal geometry, and a small draw moves the
    tool by its column.
    """
    model, _ = grid_model()
    some = model.rows(np.arange(0, 1000, 200))
    none = np.zeros(len(model.streams))
    nominal = some.matrix.state.frames[-1]
    np.testing.assert_allclose(some.frames(none), nominal, atol=1e-12)
    for k in range(0, len(none), 7):
        draws = none.copy()
        draws[k] = 1e-4
        ahead, behind = some.frames(draws), some.frames(-draws)
        moved = (ahead - behind)[:, :3, 3] / 2e-4
        np.testing.assert_allclose(moved, some.columns[:, 3:, k], atol=1e-9)


def test_the_two_draws_of_a_harmonic_keep_their_columns():
    """Sine and cosine of a stated transmission error have one name; each is found in a model with
    another order of draws, with its own effect on the tool.
    """
    arm = lostmotion.read("examples/scara.toml")
    model = model_of(arm, arm.limits.mean(axis=1)[None] + [[0.1], [0.2]])
    names = [stream.name for stream in model.streams]
    assert len(set(names)) < len(names)
    other = model.keeping(np.arange(len(names))[::-1])
    np.testing.assert_array_equal(other.columns[:, :, other.numbers(model.streams)], model.columns)
