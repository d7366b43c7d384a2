"""A bearing that is declared rigid and free of clearance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from lostmotion.parts.bearing.bearing import BearingFigures

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion, Term


class RigidBearing(BearingFigures):
    """A bearing or guide that is declared ideal: rigid, without clearance and runout. In a file
    `rigid = true` suffices.

    rigid  true
    """

    kind: Literal["rigid"] = "rigid"
    rigid: Literal[True]

    def terms(self, motion: Motion) -> list[Term]:  # noqa: ARG002 - an ideal bearing has no error on any joint
        """Return no terms."""
        return []


def of_rigid_kind(stated: Any) -> Any:  # noqa: ANN401 - whatever a file holds
    """Return a stated bearing with the kind of a rigid one where it states `rigid` and no kind."""
    return {"kind": "rigid", **stated} if isinstance(stated, dict) and "rigid" in stated else stated
