"""The parts of a mechanism and their error terms, each with the place whose frame it acts in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.parts.term import Motion, Term


def short_name(name: str) -> str:
    """Return the name of a part or term as tables and plots show it, without the "joints." of the
    arm file: "A.gearbox" for "joints.A.gearbox".
    """
    return name.removeprefix("joints.")


@dataclass(frozen=True, slots=True)
class PlacedPart:
    """A part with errors, and its place.

    owner   full name of the part ("joints.A.gearbox")
    kind    "gearbox", "bearing", "guideway", "encoder", "servo", "lumped", "mounting", "link" or
            "base"
    joint   index of the moving joint on whose value its errors depend, a column of q; None for a
            part without one
    place   index of the place in whose frame its terms are stated
    source  the part, which returns its terms
    motion  motion of the joint that the part belongs to; zero for a part that does not move
    """

    owner: str
    kind: str
    joint: int | None
    place: int
    source: ErrorSource
    motion: Motion

    def terms(self) -> tuple[PlacedTerm, ...]:
        """Return the error terms of this part."""
        return tuple(
            PlacedTerm(self.owner, self.kind, self.joint, self.place, term)
            for term in self.source.terms(self.motion)
        )


@dataclass(frozen=True, slots=True)
class PlacedTerm:
    """A term, with owner, kind, joint and place of its part as in `PlacedPart`."""

    owner: str
    kind: str
    joint: int | None
    place: int
    term: Term

    @property
    def name(self) -> str:
        """Return the full name of the term ("joints.A.gearbox.backlash")."""
        return f"{self.owner}.{self.term.name}"

    @property
    def whole_part(self) -> str:
        """Return the name of the whole part, of which the owner may be a member: "joints.A.gearbox"
        for "joints.A.gearbox output pins".
        """
        joint, kind, _ = self.owner.rpartition(f".{self.kind}")
        return joint + kind or self.owner
