"""The joint command whose tool stands, under the loads that act there, where it is wanted.

A wanted pose is where the arm shall stand, so the loads are those at that pose: what deflects along
a joint is subtracted from its command, exactly, whatever the size of the deflection. What links,
bearings and base move is removed by the other joints, so that the arm stands a little beside: its
frames and loads are then those of the deflected arm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

import numpy as np

from lostmotion.controller_model.standing import standing
from lostmotion.spatial import cross

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.controller_model.prediction import ToolError
    from lostmotion.controller_model.standing import Standing
    from lostmotion.controller_model.tables import Tables
    from lostmotion.spatial import Floats

# Damping of the inverse of the position Jacobian, m^2, and its limits (Y. Nakamura, H. Hanafusa, J.
# Dyn. Sys. Meas. Control 108 (1986) 163).
DAMPING: Final = 1e-5
_LEAST_DAMPING: Final = 1e-8
_LARGEST_DAMPING: Final = 1.0
# Length that turns a rotation into a displacement where the whole pose is corrected, m.
ROTATION_LENGTH: Final = 0.1
# Largest step of a joint (rad or m) near singular poses, for what links, bearings and base move.
LARGEST_STEP: Final = 0.01
# A pose whose position Jacobian has a smaller singular value (m) is near a singular one. Elsewhere
# a step is as large as the bending that it corrects, and has no limit.
REGULAR: Final = 0.1
# A change of the command is sent whole where the share of it that makes the error smallest is at
# least the inverse, as at regular poses.
_NEAR_BEST: Final = 1.25
# A command is sent that leaves at most this share of the squared error: both are computed to less.
_WORTH: Final = 0.98
# Steps of one and of two passes. Each uses the Jacobian of the wanted pose, so that a share of the
# error remains of the size of the angles by which the parts bend.
_STEPS: Final = {1: 1, 2: 4}
# Steps from the command to where it stands, by which it is checked: a play may turn over at the
# third.
_CHECKED: Final = 3
# A smaller square of a motion of the tool, m^2, is none.
_TINY: Final = 1e-300
# A motion of the tool by a smaller share of the reach is rounding.
_UNSEEN: Final = 1e-12
# A command beyond a joint limit by less (rad or m) is not cut.
_ROUNDING: Final = 1e-12


@dataclass(frozen=True)
class Options:
    """Options of a compensation, as `Controller.compensate`. Raises ValueError for one out of its
    range.
    """

    passes: Literal[1, 2]
    whole_pose: bool
    damping: float
    largest_step: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        if self.passes not in {1, 2}:
            raise ValueError(f"passes is {self.passes}; expected 1 or 2")
        if not _LEAST_DAMPING <= self.damping <= _LARGEST_DAMPING:
            raise ValueError(
                f"damping is {self.damping}; expected 1e-8 to 1 m^2 (for example 1e-5)"
            )
        if not 0 <= self.largest_step < math.inf:
            raise ValueError(
                f"largest_step is {self.largest_step}; expected an angle or length, zero or more "
                "(for example 0.01)"
            )

    @property
    def weight(self) -> Floats:
        """Return the weights (6,) of rotation and displacement in what is corrected."""
        return np.array([ROTATION_LENGTH * self.whole_pose] * 3 + [1.0] * 3)


class Corrected(NamedTuple):
    """The command (pose, joint), what it leaves of the tool's error (pose, 6), whether the
    correction was reduced (pose,), and whether a load is beyond a table (pose,).
    """

    command: Floats
    left: Floats
    reduced: NDArray[np.bool_]
    beyond: NDArray[np.bool_]


def corrected(
    tables: Tables,
    at: ToolError,
    given: tuple[Floats, Floats, Floats, Floats],
    options: Options,
) -> Corrected:
    """Return the command for each wanted pose.

    at     the prediction there
    given  wanted joint values (pose, joint), and load, gravity and last motions as
           `Controller.predict`
    """
    wanted, load, gravity, side = given
    sent, twists, left = wanted, at.twists, at.screw
    drift, moved = at.joints, at.screw - at.elsewhere
    short, beyond = np.zeros((2, len(wanted)), dtype=bool)
    for _ in range(_STEPS[options.passes]):
        step, capped = _step(at.jacobian, left - moved, options)
        asked = sent + step - drift
        within = np.clip(asked, *tables.limits.T)
        cut = np.abs(within - asked) > _ROUNDING
        change, reduced = np.where(cut, within - sent, step - drift), capped | cut.any(axis=1)
        # A change that a limit cuts, or whose step was reduced, may add to the error. It is sent
        # whole where the share of it that makes the error smallest is near one.
        effect = _displaced(at.jacobian, drift + change) - moved
        best = _product(-left, effect, options) / np.maximum(
            _product(effect, effect, options), _TINY
        )
        share = np.where(reduced, np.clip(_NEAR_BEST * best, 0.0, 1.0), 1.0)[:, None]
        sent = np.clip(sent + share * change, *tables.limits.T)
        stands = standing(tables, sent, load, gravity, side, twists)
        left, drift = _off(at, stands), _along_joints(tables, stands.twists - twists)
        moved, twists = _displaced(at.jacobian, drift), stands.twists
        short, beyond = short | reduced, beyond | stands.beyond
    # A joint limit, or a play that turns over, may leave more than there was.
    without = _off(at, standing(tables, wanted, load, gravity, side, at.twists))
    before, after = (_product(each, each, options) for each in (without, left))
    unseen = (_UNSEEN * tables.valid.reach) ** 2
    # On the way from the command to where it stands, a play may stay on the side that the loads at
    # the command close; and of a soft arm one step from the wanted pose may miss the equilibrium.
    begun = np.zeros_like(at.twists)
    for _ in range(_CHECKED):
        stands = standing(tables, sent, load, gravity, side, begun)
        begun = stands.twists
    off = _off(at, stands)
    after = np.maximum(after, _product(off, off, options))
    kept = (after <= _WORTH * before + unseen)[:, None]
    return Corrected(
        np.where(kept, sent, wanted),
        np.where(kept, left, without),
        short | (after > before + unseen),
        beyond,
    )


def _along_joints(tables: Tables, twists: Floats) -> Floats:
    """Return what twists (place, pose, 6) move the joints (pose, joint), rad or m."""
    out = np.zeros((twists.shape[1], len(tables.joints)))
    for record, twist in zip(tables.records, twists, strict=True):
        if record.joint >= 0:
            out[:, record.joint] = twist[:, 5 if record.slides else 2]
    return out


def _off(at: ToolError, stands: Standing) -> Floats:
    """Return how far the tool stands (pose, 6) from where it does without errors: rotation, of
    first order, and displacement.
    """
    change = stands.turn @ at.turn.transpose(0, 2, 1)
    turn = np.stack(
        [
            change[:, 2, 1] - change[:, 1, 2],
            change[:, 0, 2] - change[:, 2, 0],
            change[:, 1, 0] - change[:, 0, 1],
        ],
        axis=1,
    )
    return np.concatenate([turn / 2, stands.point - at.point], axis=1)


def _step(jacobian: Floats, error: Floats, options: Options) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the step of the joints that removes an error of the tool, and whether its size was
    reduced.

    Solved twice, the second time for what damping left, so that only its square remains (iterated
    Tikhonov regularisation).
    """
    own, gap = jacobian * options.weight[:, None], (error * options.weight)[..., None]
    normal = own @ own.transpose(0, 2, 1) + options.damping * np.eye(6)
    once = np.linalg.solve(normal, gap)
    both = once + options.damping * np.linalg.solve(normal, once)
    step = -np.einsum("pij,pi->pj", own, both[..., 0])
    largest = np.abs(step).max(axis=1, initial=0.0)
    most = np.maximum(options.largest_step, np.linalg.norm(gap[..., 0], axis=1) / REGULAR)
    capped = largest > most
    return step * np.where(capped, most / np.where(capped, largest, 1.0), 1.0)[:, None], capped


def _product(one: Floats, other: Floats, options: Options) -> Floats:
    """Return the product (pose,) of two motions of the tool (pose, 6) in what is corrected, m^2."""
    return np.asarray((one * other * options.weight**2).sum(axis=1))


def _displaced(jacobian: Floats, change: Floats) -> Floats:
    """Return the motion of the tool (pose, 6) due to a change of the joints (pose, joint).

    The displacement is of second order: each joint turns the motions of those behind it.
    """
    parts = jacobian * change[:, None]
    turned = np.cumsum(parts[:, :3], axis=2) - parts[:, :3] / 2
    out = parts.sum(axis=2)
    out[:, 3:] += cross(turned.transpose(0, 2, 1), parts[:, 3:].transpose(0, 2, 1)).sum(axis=1)
    return np.asarray(out)
