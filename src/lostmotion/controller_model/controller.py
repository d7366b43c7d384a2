"""The controller of an arm: what its error will be at a pose under a load, and the joint command
that removes the part that can be computed.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.controller_model.accurate_percentile import accurate95
from lostmotion.controller_model.compensation import (
    DAMPING,
    LARGEST_STEP,
    Options,
    corrected,
)
from lostmotion.controller_model.percentile import percentile95
from lostmotion.controller_model.prediction import factors_of, tool_error

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
    left        (pose, 6) expected motion of the tool that remains, under the loads that act where
                the arm then stands
    prediction  the prediction at the wanted pose
    status      (pose,) as in `Prediction`; SINGULAR where a step was reduced or the limits cut the
                command, so that more than usual is left, and where more would be left than without
                a correction: then the command is not corrected
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
            **{
                name: values
                for name, values in found._asdict().items()
                if name not in {"factors", "twists"}
            },
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

        What deflects along the joints is subtracted from the command, under the loads at the wanted
        pose: exact where nothing else deflects. What links, bearings and base move is removed
        through the damped inverse of the Jacobian, so that the arm stands a little beside.

        passes        two correct the loads and the curvature where the arm then stands, which
                      counts where links and bearings bend
        whole_pose    whether the rotation is corrected with the position
        damping       of the inverse, m^2, from 1e-8 to 1: more means smaller steps near singular
                      poses, and more error left
        largest_step  of a joint near singular poses, rad or m, for what links, bearings and base
                      move; larger steps are reduced together. At other poses a step is as large as
                      the bending that it corrects

        Other arguments and errors as `predict`; ValueError for an option out of its range.
        """
        options = Options(passes, whole_pose, damping, largest_step)
        first = self.predict(q, load, gravity, side)
        good = first.status == OK
        values, loads, falls, sides = (each[good] for each in self._inputs(q, load, gravity, side))
        at = tool_error(self.tables, values, loads, falls, sides, factors_of)
        found = corrected(self.tables, at, (values, loads, falls, sides), options)
        status, command, remains = (
            first.status.copy(),
            np.zeros((len(good), len(self.tables.joints))),
            np.zeros((len(good), 6)),
        )
        within = ~found.beyond[:, None]
        command[good], remains[good] = (
            np.where(within, found.command, 0.0),
            np.where(within, found.left, 0.0),
        )
        status[good] = np.select([found.beyond, found.reduced], [LOAD, SINGULAR], OK)
        return Compensation(command, remains, first, status)
