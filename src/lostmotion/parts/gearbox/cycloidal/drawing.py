"""Drawing of a cycloidal gearbox: what it states of its stages, and what it leaves open, with every
spring stated, computed or bounded.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, Any, Final, Self

from pydantic import Field, model_validator

from lostmotion.errors import shown
from lostmotion.parts.error_source import OF_RATED, RATED_SHARE, Friction
from lostmotion.parts.gearbox.cycloidal.names import FIRST_STAGE, FRAME
from lostmotion.parts.gearbox.cycloidal.seats import Named  # noqa: TC001 - read by pydantic
from lostmotion.parts.gearbox.cycloidal.stages import CycloidalStages
from lostmotion.parts.gearbox.cycloidal.states import MemberState, Unknown, member_states, unknowns
from lostmotion.parts.gearbox.gearbox import refuse
from lostmotion.parts.provenance import with_friction
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

# Of a compliance, over its middle.
Factor = Annotated[float, Quantity("", "1.5", above=0, high=1000, band="log-uniform")]
# What some members include beyond their names.
_INCLUDED: Final = {
    "eccentric shaft": "eccentric shaft with its bearings and seats",
    "frame": "frame (housing and output shaft)",
}


class CycloidalDrawing(CycloidalStages):
    """What the drawing of a cycloidal gearbox states, and what it leaves open; `CycloidalGearbox`
    lists its fields.
    """

    unstated: Annotated[dict[Named, Factor], Field(max_length=100)] = Field(default={})

    @model_validator(mode="after")
    def _leaves_open(self) -> Self:
        names = [each.name for each in self.unknowns]
        strange = [name for name in self.unstated if name not in names]
        if strange:
            expected = f"what this drawing leaves open: {', '.join(names) or 'nothing'}"
            raise refuse(
                f"{shown(strange[0])} in unstated",
                expected,
                f'unstated = {{ "{names[0] if names else FRAME}" = 1.5 }}',
            )
        object.__setattr__(self, "unstated", self.left_open)
        return self

    @property
    def left_open(self) -> dict[str, float]:
        """Return a factor for whatever the drawing leaves open: a range, unless it is stated."""
        return {each.name: self.unstated.get(each.name, each.factor) for each in self.unknowns}

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with other values, which may leave other things open."""
        out = super().model_copy(update=update, deep=deep)
        if update and "unstated" not in update:
            object.__setattr__(out, "unstated", out.left_open)
        return out

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the default
        friction.
        """
        return with_friction(super().assumptions, "friction_torque", self.friction_at_rest)

    @functools.cached_property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Return what the drawing does not state, each with its effect on the members."""
        return unknowns(self)

    @functools.cached_property
    def middle(self) -> Self:
        """Return the drawing with the middle of everything that it does not state."""
        return self.model_copy(update={"unstated": {}})

    @functools.cached_property
    def states(self) -> dict[str, MemberState]:
        """Return what is known of each member, by name."""
        return member_states(self)

    @property
    def bounded(self) -> tuple[str, ...]:
        """Return the members that the drawing does not describe, of which the compliance is
        bounded.
        """
        return tuple(name for name, state in self.states.items() if state.kind == "bounded")

    @property
    def not_specified(self) -> str:
        """Return the bounded members as text, each with what it includes and its stage."""
        return ", ".join(
            _INCLUDED.get(member := name.removeprefix(FIRST_STAGE), member)
            + " of the first stage" * name.startswith(FIRST_STAGE)
            for name in self.bounded
        )

    @property
    def friction_at_rest(self) -> Friction:
        """Return the load (N m) below which the direction of the last motion decides the side of
        the play, stated or else assumed.
        """
        return (
            self.friction_torque
            if self.friction_torque is not None
            else Friction.of_load(RATED_SHARE * self.rated_torque, OF_RATED)
        )

    @property
    def friction_in_loop(self) -> float:
        """Return the friction torque without load (N m) that counts in the hysteresis: the stated
        one.
        """
        return self.friction_torque.load.nominal if self.friction_torque is not None else 0.0
