"""Cost, error and constraints of one selection of parts. Every selection is the real arm at the
real poses, with its own masses and loads.

Results are cached, so that a selection is evaluated once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import LostmotionError
from lostmotion.mechanism.even_poses import corners
from lostmotion.mechanism.holding_torques import worst_torques_over_tilts
from lostmotion.mechanism.state import state_of
from lostmotion.sizing.error_cache import ErrorCache, error_at, mean_square
from lostmotion.sizing.lightest import LinkTask
from lostmotion.sizing.link_deflection import LinkLoads

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import Joint
    from lostmotion.sizing.candidates import Objective, PartCandidate, Slot
    from lostmotion.sizing.error_cache import TargetOf
    from lostmotion.sizing.lightest import Limits
    from lostmotion.spatial import Floats

LEVEL: Final = 0.95
# The number of the candidate in each slot.
Choice = tuple[int, ...]
# Relative differences that are rounding.
EQUAL: Final = 1e-9
_MOST_CORNERS: Final = 256


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Cost, mass (kg) and price of the selected parts, r.m.s. error (m), and the violation of the
    constraints.

    `violation` is the sum of the logarithms of load over rating and of deflection over limit, 0
    where none is exceeded.
    """

    cost: float
    mass: float
    price: float
    rms: float
    violation: float


@dataclass(frozen=True, slots=True)
class Constraints:
    """Constraints besides the target: limits on each selected link (None: none), and the largest
    tilt of the base (rad; None: as stated).
    """

    limits: Limits | None = None
    tilt: float | None = None


class Evaluator:
    """Evaluations of selections of one arm at some poses; `evaluations` has every selection that
    was evaluated.
    """

    def __init__(
        self,
        arm: Arm,
        slots: tuple[Slot, ...],
        objective: Objective,
        q: Floats,
        constraints: Constraints,
        on_evaluation: Callable[[], None] = lambda: None,
        of: TargetOf = "error",
    ) -> None:
        """Begin without evaluations; `slots` may be extended by candidates later. `on_evaluation`
        is called at every new evaluation.
        """
        self.arm, self.slots, self.objective, self.constraints, self.on_evaluation = (
            arm,
            slots,
            objective,
            constraints,
            on_evaluation,
        )
        self.cache = ErrorCache(arm, q, of)
        self.load_q = np.vstack([q, corners(arm, _MOST_CORNERS)])
        self.evaluations: dict[Choice, Evaluation] = {}
        self._errors: dict[Choice, float] = {}
        # of the selection evaluated last, whose error is often the next that is asked for
        self._sums: tuple[Choice, Floats] | None = None
        self._joints: dict[tuple[str, tuple[tuple[int, int], ...]], Joint] = {}
        self._torques: dict[tuple[tuple[float, ...], ...], Floats] = {}
        self._deflections: dict[tuple[object, ...], float] = {}

    def parts(self, choice: Choice) -> tuple[PartCandidate, ...]:
        """Return the selected candidates."""
        return tuple(slot.candidates[k] for slot, k in zip(self.slots, choice, strict=True))

    def arm_with(self, choice: Choice) -> Arm:
        """Return the arm with these parts. A joint with the same parts is the same object, so that
        its errors are cached.
        """
        joints = []
        for joint in self.arm.joints:
            own = tuple(
                (k, choice[k]) for k, slot in enumerate(self.slots) if joint.name in slot.joints
            )
            known = (joint.name, own)
            if own and known not in self._joints:
                changed = joint
                for k, index in own:
                    changed = self.slots[k].install(changed, self.slots[k].candidates[index])
                self._joints[known] = changed
            joints.append(self._joints[known] if own else joint)
        return self.arm.model_copy(update={"joints": tuple(joints)})

    def evaluate(self, choice: Choice) -> Evaluation:
        """Return the evaluation of a selection; error and violation are infinite where a part has
        no solution under its load.
        """
        known = self.evaluations.get(choice)
        if known is None:
            parts = self.parts(choice)
            mass, price = sum(each.mass for each in parts), sum(each.price for each in parts)
            try:
                arm = self.arm_with(choice)
                self._sums = choice, self.cache.of(arm)
                rms = math.sqrt(mean_square(self._sums[1]))
                violation = self._violation(arm, choice)
            except LostmotionError:
                rms = violation = math.inf
            known = self.evaluations[choice] = Evaluation(
                sum(map(self.cost_of_part, parts)), mass, price, rms, violation
            )
            self.on_evaluation()
        return known

    def error(self, choice: Choice) -> float:
        """Return the 95 % error (m) of a selection, for a target on a repeatability that of its
        scatter between visits.
        """
        if choice not in self._errors:
            error = math.inf
            if math.isfinite(self.evaluate(choice).rms):
                last = self._sums
                sums = (
                    last[1]
                    if last is not None and last[0] == choice
                    else self.cache.of(self.arm_with(choice))
                )
                error = error_at(sums, LEVEL)
            self._errors[choice] = error
        return self._errors[choice]

    def meets(self, choice: Choice, target: float) -> bool:
        """Return whether a selection meets the target (m) and all constraints."""
        return self.evaluate(choice).violation <= 0 and self.error(choice) <= target

    def cost(self, choice: Choice) -> float:
        """Return the cost of a selection, without its evaluation."""
        return sum(map(self.cost_of_part, self.parts(choice)))

    def cost_of_part(self, candidate: PartCandidate) -> float:
        """Return the cost of one part."""
        return self.objective.cost(candidate.mass, candidate.price)

    def torques(self, arm: Arm) -> Floats:
        """Return the largest holding torque of each moving joint (joint,), N m or N, over the poses
        and the corners of the joint ranges.
        """
        key = _masses(arm)
        if key not in self._torques:
            state, tilt = state_of(arm, self.load_q), self.constraints.tilt
            held = (
                np.abs(state.torques)
                if tilt is None
                else worst_torques_over_tilts(state, within=tilt)
            )
            self._torques[key] = held.max(axis=0)
        return self._torques[key]

    def _violation(self, arm: Arm, choice: Choice) -> float:
        return self._torque_violation(arm) + (
            0.0
            if self.constraints.limits is None
            else self._limit_violation(arm, choice, self.constraints.limits)
        )

    def _torque_violation(self, arm: Arm) -> float:
        selected = {name for slot in self.slots if slot.kind == "gearbox" for name in slot.joints}
        out = 0.0
        for joint, torque in zip(
            arm.driven, self.torques(arm) if selected else (), strict=bool(selected)
        ):
            rated = joint.gearbox.rated_torque if joint.gearbox is not None else None
            if joint.name in selected and rated is not None and torque > rated * (1 + EQUAL):
                out += math.log(torque / rated) if rated > 0 else math.inf
        return out

    def _limit_violation(self, arm: Arm, choice: Choice, limits: Limits) -> float:
        out = 0.0
        masses = _masses(arm)
        links = [
            (name, choice[k])
            for k, slot in enumerate(self.slots)
            if slot.kind == "link"
            for name in slot.joints
        ]
        for name, chosen in links:
            at = next(n for n, joint in enumerate(arm.joints) if joint.name == name)
            loading = arm.tree.loading(arm.tree.joints[at].tip)
            carried = tuple(
                mass
                for mass, places in zip(masses, arm.tree.joints, strict=True)
                if places.seat in loading
            )
            key = (name, chosen, carried)
            if key not in self._deflections:
                joint = arm.joints[at]
                task = LinkTask(
                    joint, LinkLoads.of(arm, at, self.load_q, self.constraints.tilt), limits
                )
                self._deflections[key] = (
                    0.0
                    if joint.link.is_rigid
                    else float(task.utilisation(joint.elastic_link, task.loads).max())
                )
            out += math.log(self._deflections[key]) if self._deflections[key] > 1 + EQUAL else 0.0
        return out


def _masses(arm: Arm) -> tuple[tuple[float, ...], ...]:
    """Return the masses of each joint that a selection may change: of the joint, of its link, and
    the link's centre of mass.
    """
    return tuple(
        (joint.total_mass, joint.link.total_mass, *(float(x) for x in joint.link.mass_centre))
        for joint in arm.joints
    )
