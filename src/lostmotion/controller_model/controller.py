"""The controller of an arm: what its error will be at a pose under a load, and the joint command
that removes the part that can be computed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.controller_model.accurate_percentile import accurate95
from lostmotion.controller_model.percentile import percentile95
from lostmotion.controller_model.prediction import factors_of, frames, tool_error
from lostmotion.spatial import cross

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.controller_model.tables import Record, Tables
    from lostmotion.spatial import Floats

# Status of a pose. Outputs are zero unless the status is OK or SINGULAR.
OK, INPUT, RANGE, LOAD, SINGULAR = range(5)
# Flags of a pose: a play is open in some robots, so that the direction of approach counts; a drive
# is above its rated torque; times 2^k, a play of the drive or of the bearings of joint k is open.
OPEN_PLAY, OVERLOAD, JOINT_PLAY = 1, 2, 4
# Joints with a flag of their own: as many as an int of 32 bits has room for.
_MOST_FLAGGED: Final = 29
# Damping of the inverse of the position Jacobian, m^2, and its limits (Y. Nakamura, H. Hanafusa, J.
# Dyn. Sys. Meas. Control 108 (1986) 163).
DAMPING: Final = 1e-5
_LEAST_DAMPING: Final = 1e-8
_LARGEST_DAMPING: Final = 1.0
# Length that turns a rotation into a displacement where the whole pose is corrected, m.
ROTATION_LENGTH: Final = 0.1
# Largest step of a joint (rad or m) that corrects bending and bearings; the step of a drive's own
# deflection has no limit.
LARGEST_STEP: Final = 0.01
# A change of the command is sent whole where the share of it that makes the error smallest is at
# least the inverse, as at regular poses.
_NEAR_BEST: Final = 1.25
# A command beyond a joint limit by less (rad or m) is not cut.
_ROUNDING: Final = 1e-12


@dataclass(frozen=True)
class Prediction:
    """The state of the arm at each pose, in SI, in the base's axes.

    status       (pose,) OK, INPUT, RANGE or LOAD; where it is not OK, all other values are zero
    flags        (pose,) sum of OPEN_PLAY, OVERLOAD and JOINT_PLAY x 2^k of each joint k concerned,
                 of the first 29
    turn, point  (pose, 3, 3) rotation of the tool and (pose, 3) tool point, without errors
    torques      (pose, joint) that the drives must hold, positive along the joint's motion, N m or
                 N
    joints       (pose, joint) expected deflection along each joint: wind-up, play and hysteresis,
                 rad or m
    elsewhere    (pose, 6) expected motion of the tool by links, bearings and base
    screw        (pose, 6) expected motion of the tool: rotation and displacement
    covariance   (pose, 3, 3) of the displacement, m^2
    mean_square  (pose,) m^2
    length95     (pose,) 95th percentile of the error's length, m
    jacobian     (pose, 6, joint) motion of the tool per motion of a joint
    """

    status: NDArray[np.int64]
    flags: NDArray[np.int64]
    turn: Floats
    point: Floats
    torques: Floats
    joints: Floats
    elsewhere: Floats
    screw: Floats
    covariance: Floats
    mean_square: Floats
    length95: Floats
    jacobian: Floats


@dataclass(frozen=True)
class Compensation:
    """A joint command and what remains of the expected error.

    command     (pose, joint) rad or m, within the limits
    left        (pose, 6) expected motion of the tool that remains: rotation to first, displacement
                to second order, without the change of the load
    prediction  the prediction at the wanted pose
    status      (pose,) as in `Prediction`; SINGULAR where a step was reduced or the limits cut the
                command, so that more than usual is left, and where the second of two passes finds
                more error than without a correction: then the command is not corrected
    """

    command: Floats
    left: Floats
    prediction: Prediction
    status: NDArray[np.int64]


def play_flags(record: Record) -> int:
    """Return the flags where a play of a place is open; joints behind the 29th have none of their
    own.
    """
    return OPEN_PLAY + (JOINT_PLAY << record.joint if 0 <= record.joint < _MOST_FLAGGED else 0)


class Controller:
    """The error model of one arm as its controller evaluates it. Every array has poses along its
    first axis; one pose is accepted as well.
    """

    def __init__(self, tables: Tables, *, accurate_length: bool = False) -> None:
        """Take the tables, of which `tables.py` defines the layout; `accurate_length` computes the
        95th percentile within 0.2 % instead of 1.5 %.
        """
        self.tables = tables
        self._percentile = accurate95 if accurate_length else percentile95

    def predict(
        self,
        q: Floats,
        load: Floats | None = None,
        gravity: Floats | None = None,
        side: Floats | None = None,
    ) -> Prediction:
        """Return the state of the arm at each pose.

        q        (pose, joint) rad or m
        load     (10,) or (pose, 10): mass of the payload (kg), its centre of mass (m), process
                 force (N) and moment (N m), all in the tool's axes; by default the arm's own
                 payload
        gravity  (3,) or (pose, 3) acceleration of free fall in the base's axes, m/s^2; by default
                 the arm's own
        side     (joint,) or (pose, joint) sign of each joint's last motion, from -1 to 1; 0, the
                 default, where it is not known

        Raises ValueError for arrays of another shape.
        """
        values, loads, falls, sides = self._inputs(q, load, gravity, side)
        status = self._status(values, loads, falls, sides)
        good = status == OK
        found = self._evaluate(values[good], loads[good], falls[good], sides[good])
        out = {
            each.name: np.zeros(
                (len(values), *getattr(found, each.name).shape[1:]), getattr(found, each.name).dtype
            )
            for each in fields(found)
        }
        within = found.status == OK
        for name, whole in out.items():
            whole[np.flatnonzero(good)[within]] = getattr(found, name)[within]
        status[good] = found.status
        out["status"] = status
        return Prediction(**out)

    def _inputs(
        self, q: Floats, load: Floats | None, gravity: Floats | None, side: Floats | None
    ) -> tuple[Floats, Floats, Floats, Floats]:
        joints = len(self.tables.joints)
        values = np.atleast_2d(np.asarray(q, dtype=float))
        defaults = (
            (load, self.tables.load),
            (gravity, self.tables.gravity),
            (side, np.zeros(joints)),
        )
        others = [
            np.asarray(default if given is None else given, dtype=float)
            for given, default in defaults
        ]
        for name, array, size in zip(
            ("q", "load", "gravity", "side"),
            (values, *others),
            (joints, 10, 3, joints),
            strict=True,
        ):
            if array.shape not in {(size,), (len(values), size)}:
                raise ValueError(
                    f"{name} has shape {array.shape}; expected ({size},) or (pose, {size})"
                )
        loads, falls, sides = (
            np.broadcast_to(each, (len(values), each.shape[-1])) for each in others
        )
        return values, loads, falls, sides

    def _status(self, q: Floats, load: Floats, gravity: Floats, side: Floats) -> NDArray[np.int64]:
        valid = self.tables.valid
        low = np.array([0.0, *[-valid.reach] * 3, *[-valid.force] * 3, *[-valid.moment] * 3])
        high = np.array(
            [valid.payload, *[valid.reach] * 3, *[valid.force] * 3, *[valid.moment] * 3]
        )
        bad = ~np.isfinite(np.concatenate([q, load, gravity, side], axis=1)).all(axis=1) | ~(
            np.abs(side) <= 1
        ).all(axis=1)
        outside = ~((q >= self.tables.limits[:, 0]) & (q <= self.tables.limits[:, 1])).all(axis=1)
        heavy = ~(
            ((load >= low) & (load <= high)).all(axis=1)
            & (np.abs(gravity) <= valid.gravity).all(axis=1)
        )
        return np.select([bad, outside, heavy], [INPUT, RANGE, LOAD], OK)

    def _evaluate(self, q: Floats, load: Floats, gravity: Floats, side: Floats) -> Prediction:
        found = tool_error(self.tables, q, load, gravity, side, factors_of)
        places = [record for record in self.tables.records if record.carries_tool]
        opens = [
            np.where(each.open_play, play_flags(place), 0)
            for place, each in zip(places, found.factors, strict=True)
        ]
        beyond = np.any([each.beyond for each in found.factors], axis=0)
        overload = (np.abs(found.torques) > self.tables.rated).any(axis=1)
        mean_square = np.einsum("pii->p", found.covariance) + (found.screw[:, 3:] ** 2).sum(axis=1)
        return Prediction(
            status=np.where(beyond, LOAD, OK),
            flags=np.bitwise_or.reduce([*opens, np.where(overload, OVERLOAD, 0)]),
            mean_square=mean_square,
            length95=self._percentile(found.screw[:, 3:], found.covariance),
            **{name: values for name, values in found._asdict().items() if name != "factors"},
        )

    def compensate(  # noqa: PLR0913 - the inputs and the options of lm_compensate
        self,
        q: Floats,
        load: Floats | None = None,
        gravity: Floats | None = None,
        side: Floats | None = None,
        *,
        passes: Literal[1, 2] = 1,
        whole_pose: bool = False,
        damping: float = DAMPING,
        largest_step: float = LARGEST_STEP,
    ) -> Compensation:
        """Return the joint command whose tool is expected at the pose that q has without errors.

        What deflects along the joints is subtracted from the command, exactly. What links, bearings
        and base move is removed through the damped inverse of the Jacobian.

        passes        one leaves about 0.1 % of the expected error; a second one corrects the change
                      of the load and the curvature
        whole_pose    whether the rotation is corrected with the position
        damping       of the inverse, m^2, from 1e-8 to 1: more means smaller steps near singular
                      poses, and more error left
        largest_step  of a joint for what links, bearings and base move, rad or m; steps beyond it
                      are reduced together

        Other arguments and errors as `predict`; ValueError for an option out of its range.
        """
        if passes not in {1, 2}:
            raise ValueError(f"passes is {passes}; expected 1 or 2")
        if not _LEAST_DAMPING <= damping <= _LARGEST_DAMPING:
            raise ValueError(f"damping is {damping}; expected 1e-8 to 1 m^2 (for example 1e-5)")
        if not 0 <= largest_step < math.inf:
            raise ValueError(
                f"largest_step is {largest_step}; expected an angle or length, zero or more "
                "(for example 0.01)"
            )
        first = self.predict(q, load, gravity, side)
        good = first.status == OK
        wanted, *inputs = (each[good] for each in self._inputs(q, load, gravity, side))
        at = start = self._evaluate(wanted, *inputs)
        sent, (short, worse) = wanted, np.zeros((2, len(wanted)), dtype=bool)
        residual, drift, moved = start.elsewhere, start.joints, start.screw - start.elsewhere
        left = start.screw
        for number in range(passes):
            if number:
                before, at = at, self._evaluate(sent, *inputs)
                residual, drift = (
                    self._residual(start, at, sent + before.joints),
                    at.joints - before.joints,
                )
                moved = _displaced(at, drift)
                left = residual + moved
                # A torque that changes its sign with the command turns a play over, which the first
                # pass cannot see.
                worse = _product(left, left, whole_pose=whole_pose) > _product(
                    start.screw, start.screw, whole_pose=whole_pose
                )
            step, reduced = _step(
                at.jacobian, residual, damping, largest_step, whole_pose=whole_pose
            )
            sent, left, cut = self._sent(
                sent, step - drift, left, moved, drift, at, whole_pose=whole_pose
            )
            short |= reduced | cut | worse
            sent, left = (
                np.where(worse[:, None], wanted, sent),
                np.where(worse[:, None], start.screw, left),
            )
        status, command, remains = (
            first.status.copy(),
            np.zeros((len(good), len(self.tables.joints))),
            np.zeros((len(good), 6)),
        )
        within = (at.status == OK)[:, None]
        command[good], remains[good] = np.where(within, sent, 0.0), np.where(within, left, 0.0)
        status[good] = np.where(within[:, 0], np.where(short, SINGULAR, OK), at.status)
        return Compensation(command, remains, first, status)

    def _residual(self, start: Prediction, at: Prediction, reached: Floats) -> Floats:
        """Return how far the tool is expected from where it is wanted when the joints stand at
        `reached` after their deflection.
        """
        turns, points = frames(self.tables, reached)
        change = turns[-1] @ start.turn.transpose(0, 2, 1)
        turn = (
            np.stack(
                [
                    change[:, 2, 1] - change[:, 1, 2],
                    change[:, 0, 2] - change[:, 2, 0],
                    change[:, 1, 0] - change[:, 0, 1],
                ],
                axis=1,
            )
            / 2
        )
        return np.concatenate([turn, points[-1] - start.point], axis=1) + at.elsewhere

    def _sent(
        self,
        before: Floats,
        change: Floats,
        error: Floats,
        moved: Floats,
        drift: Floats,
        at: Prediction,
        *,
        whole_pose: bool,
    ) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Return the command after a change (pose, joint), within the joint limits, what it leaves
        (pose, 6), and whether the change was reduced.

        before, error  (pose, joint) command to be changed, and (pose, 6) the error of the tool
                       there
        moved, drift   (pose, 6) the part of that error by joints that stand beyond where they
                       should, and (pose, joint) by how much; the change begins with its negative

        A change that a limit cuts, or whose step was reduced, may add to the error, and with the
        command the load changes: the error by about its size times the largest angle. The change is
        sent whole where the share of it that makes the error smallest is at least 1 / _NEAR_BEST.
        """
        asked = before + change
        within = np.clip(asked, *self.tables.limits.T)
        cut = np.abs(within - asked) > _ROUNDING
        change = np.where(cut, within - before, change)
        effect = _displaced(at, drift + change) - moved
        removed, square, whole = (
            _product(a, b, whole_pose=whole_pose)
            for a, b in ((-effect, error), (effect, effect), (error, error))
        )
        of_load = np.abs(change).max(axis=1, initial=0.0) * whole
        share = np.clip(
            _NEAR_BEST * (removed - of_load) / np.where(square > 0, square, 1.0), 0.0, 1.0
        )
        share = np.where(square > 0, share, 1.0)[:, None]
        sent = np.clip(before + share * change, *self.tables.limits.T)
        return sent, error + share * effect, cut.any(axis=1) | (share[:, 0] < 1)


def _step(
    jacobian: Floats, error: Floats, damping: float, largest_step: float, *, whole_pose: bool
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the step of the joints that removes an error of the tool, and whether its size was
    reduced.
    """
    rows, weight = _rows(whole_pose=whole_pose)
    own = jacobian[:, rows] * weight[:, None]
    normal = own @ own.transpose(0, 2, 1) + damping * np.eye(len(weight))
    step = -np.einsum(
        "pij,pi->pj", own, np.linalg.solve(normal, (error[:, rows] * weight)[..., None])[..., 0]
    )
    largest = np.abs(step).max(axis=1, initial=0.0)
    short = largest > largest_step
    return step * np.where(short, largest_step / np.where(short, largest, 1.0), 1.0)[:, None], short


def _rows(*, whole_pose: bool) -> tuple[slice, Floats]:
    """Return the rows of a twist that are corrected, and their weights."""
    rows = slice(0, 6) if whole_pose else slice(3, 6)
    return rows, np.array([ROTATION_LENGTH] * 3 + [1.0] * 3)[rows]


def _product(one: Floats, other: Floats, *, whole_pose: bool) -> Floats:
    """Return the product (pose,) of two motions of the tool (pose, 6) in the rows that are
    corrected, m^2.
    """
    rows, weight = _rows(whole_pose=whole_pose)
    return np.asarray(((one * other)[:, rows] * weight**2).sum(axis=1))


def _displaced(at: Prediction, change: Floats) -> Floats:
    """Return the motion of the tool (pose, 6) due to a change of the joints (pose, joint).

    The displacement is of second order: each joint turns the motions of those behind it.
    """
    parts = at.jacobian * change[:, None]
    turned = np.cumsum(parts[:, :3], axis=2) - parts[:, :3] / 2
    out = parts.sum(axis=2)
    out[:, 3:] += cross(turned.transpose(0, 2, 1), parts[:, 3:].transpose(0, 2, 1)).sum(axis=1)
    return np.asarray(out)
