"""A calibrated chain of frames as errors of an arm: the smallest screws at its seats that lead to
the same motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration.choices import Asked
from lostmotion.calibration.fit import fit
from lostmotion.calibration.instruments import FullPoses
from lostmotion.calibration.model import model_of
from lostmotion.calibration.robot import calibrations_of, estimated_errors
from lostmotion.calibration.terms import Deviations, added_terms
from lostmotion.spatial import inverse, mean_pose

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.calibration.robot import EstimatedError
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.calibration import Calibration
    from lostmotion.spatial import Floats

_POSES: Final = 200
# Deviation by which the chain is followed, m: far below what any robot repeats.
_EXACT: Final = 1e-8
# Prior deviations, so wide that a maker's tolerances do not count, yet the smallest errors are
# found where the chain leaves a choice.
_WIDE: Final = Deviations(
    zero=3e-3, turn=3e-3, shift=2e-3, base_turn=10e-3, base_shift=10e-3, tool_turn=10e-3
)
_HALF_TURN: Final = np.diag([-1.0, -1.0, 1.0, 1.0])


@dataclass(frozen=True)
class ChainErrors:
    """Errors of an arm that lead to the motion of a chain.

    calibration  as every question takes it, with the deviation of rounding
    errors       largest effect first
    left         largest distance between the chain and the calibrated arm, m
    before       the same of the nominal arm, mean
    """

    calibration: Calibration
    errors: tuple[EstimatedError, ...]
    left: float
    before: float
    sizes: Deviations


def errors_of_chain(
    arm: Arm, tool: Callable[[Floats], Floats], *, with_tool: bool, seed: int = 1
) -> ChainErrors:
    """Return the errors of an arm by a chain.

    tool       returns the frames of the tool (pose, 4, 4) for joint values (pose, joint)
    with_tool  whether these are of the arm's tool; else a fixed tool and a half turn of the base
               are found first
    """
    low, high = np.clip(arm.limits, -np.pi, np.pi).T
    q = low + np.random.default_rng(seed).random((_POSES, len(low))) * (high - low)
    model = model_of(arm, q, added_terms(arm, _WIDE))
    nominal, frames = model.matrix.state.frames[-1], tool(q)
    if not with_tool:
        frames = _with_tool(frames, nominal)
    found = fit(
        model,
        FullPoses(frames),
        Asked(np.ones(len(model.streams)), _EXACT, release=False, robust=False),
    )
    moved = model.frames(found.mean)
    return ChainErrors(
        calibrations_of(arm, model, found, _WIDE, source="a maker's calibration").own,
        estimated_errors(model, found, FullPoses(frames)),
        float(np.linalg.norm(moved[:, :3, 3] - frames[:, :3, 3], axis=1).max()),
        float(np.linalg.norm(nominal[:, :3, 3] - frames[:, :3, 3], axis=1).mean()),
        _WIDE,
    )


def _with_tool(frames: Floats, nominal: Floats) -> Floats:
    """Return frames of the last joint as those of the tool: times the fixed step that is nearest to
    the nominal one, in the base that fits better, as it is or by a half turn.
    """
    options = []
    for base in (np.eye(4), _HALF_TURN):
        steps = inverse(base @ frames) @ nominal
        moved = base @ frames @ mean_pose(steps)
        options.append((float(np.abs(moved - nominal).mean()), moved))
    return np.asarray(min(options, key=lambda option: option[0])[1])
