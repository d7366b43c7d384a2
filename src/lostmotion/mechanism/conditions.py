"""What acts on the parts of an arm in a state: joint value, wrench and gravity at their places."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from lostmotion.mechanism.closed_position import joint_value
from lostmotion.mechanism.elastostatics import elastic_terms
from lostmotion.parts.term import Condition
from lostmotion.spatial import into, inverse

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.closed_statics import Spring
    from lostmotion.mechanism.placed_terms import PlacedPart, PlacedTerm
    from lostmotion.spatial import Floats


class Stands(Protocol):
    """An arm at poses; attributes as those of a state."""

    @property
    def arm(self) -> Arm:
        """Return the arm."""
        ...

    @property
    def q(self) -> Floats:
        """Return the values (pose, joint) of the driven joints, rad or m."""
        ...

    @property
    def frames(self) -> Floats:
        """Return the frames (place, pose, 4, 4) of the places, m."""
        ...

    @property
    def gravity(self) -> Floats:
        """Return the acceleration of free fall (3,), m/s^2."""
        ...

    @property
    def wrenches(self) -> Floats:
        """Return the wrenches (place, pose, 6) on the places, N m and N."""
        ...

    @property
    def process_wrenches(self) -> Floats:
        """Return the part of the wrenches by the process force and moment."""
        ...

    def __len__(self) -> int:
        """Return the number of poses."""
        ...


class Conditions:
    """What acts on the parts of an arm in a state; the conditions of this object remember what
    forms computed from them.
    """

    def __init__(self, state: Stands, wrenches: Floats | None = None) -> None:
        """Start with no condition, under the wrenches of the state or others."""
        self._state, self._on_trial = state, wrenches is not None
        self._wrenches = state.wrenches if wrenches is None else wrenches
        self._known: dict[tuple[int, int | None], Condition] = {}

    def __call__(self, part: PlacedPart | PlacedTerm) -> Condition:
        """Return the condition of a part, or of the part of a term, with poses as the last axis.
        Parts at one place with one joint share it.
        """
        key = part.place, part.joint
        if key not in self._known:
            state, rise = self._state, self._state.arm.environment.rise
            self._known[key] = Condition(
                self._angle(part),
                np.ascontiguousarray(self._wrenches[part.place].T),
                np.ascontiguousarray(into(state.frames[part.place], state.gravity).T),
                0.0 if rise is None else rise.nominal,
                self._process(part.place),
            )
        return self._known[key]

    def _process(self, place: int) -> Floats | None:
        payload = self._state.arm.payload
        if self._on_trial or not (any(payload.force) or any(payload.moment)):
            return None
        return np.ascontiguousarray(self._state.process_wrenches[place].T)

    def _angle(self, part: PlacedPart | PlacedTerm) -> Floats:
        """Return the value (pose,) of the joint of a part: zero for a part without one."""
        state, place = self._state, self._state.arm.tree.places[part.place]
        if part.joint is not None:
            return np.ascontiguousarray(state.q[:, part.joint])
        if place.twist.shape[1] != 1:
            return np.zeros(len(state))
        moved = inverse(state.frames[place.parent]) @ state.frames[part.place]
        return joint_value(place.twist[:, 0], moved)


def springs_under(state: Stands, wrenches: Floats) -> list[Spring]:
    """Return place, twist (pose, 6) and compliance (pose, 6, 6) of each spring of an arm under
    wrenches (place, pose, 6) on its places.
    """
    conditions = Conditions(state, wrenches)
    return [
        (
            placed.place,
            placed.term.scale * placed.term.form.screw(conditions(placed)).T,
            placed.term.scale * placed.term.form.compliance(conditions(placed)),
        )
        for placed in elastic_terms(state.arm)
    ]
