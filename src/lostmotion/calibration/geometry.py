"""The geometry of a calibrated robot: its fixed steps and joint axes, exactly composed, and as a
table of modified Denavit-Hartenberg values where its axes allow one.

Source: J. Craig, Introduction to Robotics, ch. 3.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.mechanism.state import state_of
from lostmotion.parts.forms import Constant
from lostmotion.spatial import across, exp, inverse

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Sine of the angle below which two axes count as parallel: their common normal is not defined.
_PARALLEL: Final = 1e-9
# A table whose tool differs by more, m, is none.
_EXACT: Final = 1e-9
_POSES: Final = 64


class ExactChain(NamedTuple):
    """A serial chain: tool = steps[0] exp(axes[0] q[0]) steps[1] ... steps[-1].

    joints  names of the driven joints
    steps   (joint + 1, 4, 4) fixed steps, m
    axes    (joint, 6) unit twists of the joints in their own frames
    """

    joints: tuple[str, ...]
    steps: Floats
    axes: Floats

    def tool(self, q: Floats) -> Floats:
        """Return the frames of the tool (pose, 4, 4), m, at q (pose, joint), rad and m."""
        out = np.broadcast_to(self.steps[0], (len(q), 4, 4))
        for k, axis in enumerate(self.axes):
            out = out @ exp(q[:, k, None] * axis) @ self.steps[k + 1]
        return np.asarray(out)


class MdhTable(NamedTuple):
    """Modified Denavit-Hartenberg values of a chain: frame i in frame i-1 is Rx(alpha) Tx(a)
    Rz(theta) Tz(d), to whose theta (of a sliding joint: d) the joint value is added.

    rows  (joint, 4) a (m), alpha (rad), d (m), theta (rad)
    base, tool  (4, 4) first frame in the base, and tool in the last frame
    """

    rows: Floats
    base: Floats
    tool: Floats


def is_serial(arm: Arm) -> bool:
    """Return whether every joint of an arm has a drive and moves the tool, and no closure joins
    two places.
    """
    undriven = (place for place in arm.tree.places if place.joint is None)
    beside = set(arm.tree.moved) - set(arm.tree.tool_path)
    return not (arm.closures or beside or any(place.twist.shape[1] for place in undriven))


def exact_chain(arm: Arm) -> ExactChain:
    """Return the chain of an arm with the constant errors that every visit repeats: those of a
    calibrated arm are its estimates. Errors that depend on joint values or loads are not in it.

    Valid for arms that `is_serial` accepts.
    """
    tree = arm.tree
    twists = np.zeros((len(tree.places), 6))
    for placed in arm.terms:
        term = placed.term
        if term.level == "design" and isinstance(term.form, Constant) and not term.form.reads:
            twists[placed.place] += term.scale * term.form.direction
    home = state_of(arm, np.zeros((1, len(arm.driven)))).frames[:, 0]
    steps, axes, step, before = [], [], np.eye(4), np.eye(4)
    for place in tree.tool_path:
        moving = tree.places[place].joint
        step = step @ inverse(before) @ home[place]
        if moving is not None:
            steps.append(step)
            axes.append(tree.places[place].twist[:, 0])
            step = np.eye(4)
        step, before = step @ exp(twists[place]), home[place]
    return ExactChain(
        tuple(joint.name for joint in arm.driven), np.array([*steps, step]), np.array(axes)
    )


def mdh_of(chain: ExactChain) -> MdhTable | None:
    """Return the table of a chain; None where its axes allow none that leads the tool to the same
    place within a nanometre, as where two axes are so nearly parallel that their common normal is
    kilometres away.
    """
    frame, lines = np.eye(4), []
    for step, axis in zip(chain.steps, chain.axes, strict=False):
        frame = frame @ step
        way = axis[:3] if axis[:3].any() else axis[3:]
        lines.append((frame[:3, 3], frame[:3, :3] @ way / np.linalg.norm(way)))
    frames = [_on_axis(*pair) for pair in itertools.pairwise(lines)]
    frames.append(_frame(*lines[-1], across(lines[-1][1])[0]))
    last = inverse(frames[-1]) @ frame @ chain.steps[-1]
    rows = [np.zeros(4)]
    rows += [_row(inverse(a) @ b) for a, b in itertools.pairwise(frames)]
    table = MdhTable(np.array(rows), frames[0], last)
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (_POSES, len(chain.axes)))
    sliding = np.array([not axis[:3].any() for axis in chain.axes])
    left = np.abs(chain.tool(q) - mdh_tool(table, q, sliding)).max()
    return table if left < _EXACT else None


def mdh_tool(table: MdhTable, q: Floats, sliding: NDArray[np.bool_]) -> Floats:
    """Return the frames of the tool (pose, 4, 4), m, by a table; `sliding`: (joint,) of joints."""
    out = np.broadcast_to(table.base, (len(q), 4, 4))
    for (a, alpha, d, theta), value, slides in zip(table.rows, q.T, sliding, strict=True):
        turn, shift = theta + (0 if slides else value), d + (value if slides else 0)
        link = exp(np.array([[alpha, 0, 0, a, 0, 0]]))
        zeros = np.zeros_like(value)
        moved = np.stack([zeros, zeros, turn + zeros, zeros, zeros, shift + zeros], axis=1)
        out = out @ link @ exp(moved)
    return np.asarray(out @ table.tool)


def _on_axis(one: tuple[Floats, Floats], other: tuple[Floats, Floats]) -> Floats:
    """Return the frame on the first of two lines (point, direction) whose x is along their common
    normal.
    """
    (p, z), (p2, z2) = one, other
    between, normal = p2 - p, np.cross(z, z2)
    size = float(np.linalg.norm(normal))
    if size < _PARALLEL:
        beside = between - (between @ z) * z
        length = float(np.linalg.norm(beside))
        return _frame(p, z, beside / length if length > _PARALLEL else across(z)[0])
    normal = normal / size * (1.0 if between @ normal >= 0 else -1.0)
    foot = p + z * (np.cross(between, z2) @ np.cross(z, z2)) / size**2
    return _frame(foot, z, normal)


def _frame(point: Floats, z: Floats, x: Floats) -> Floats:
    out = np.eye(4)
    out[:3, 0], out[:3, 1], out[:3, 2], out[:3, 3] = x, np.cross(z, x), z, point
    return out


def _row(step: Floats) -> Floats:
    """Return a, alpha, d and theta of the step (4, 4) from one frame of a table to the next."""
    alpha = np.arctan2(-step[1, 2], step[2, 2])
    theta = np.arctan2(-step[0, 1], step[0, 0])
    d = -np.sin(alpha) * step[1, 3] + np.cos(alpha) * step[2, 3]
    return np.array([step[0, 3], alpha, d, theta])
