"""The parts of a mechanism and their error terms, each with the place whose frame it acts in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.parts.term import Motion, Term


def short_name(name: str) -> str:
    """Return the name of a part or term as tables and plots show it, without the "joints." of the arm file: "A.gearbox" for "joints.A.gearbox"."""
    return name.removeprefix("joints.")


@dataclass(frozen=True, slots=True)
class PlacedPart:
    """A part that errs, and where it sits.

    owner   its name ("joints.A.gearbox"); `kind` the kind of part ("gearbox", "bearing", "encoder", "lumped", "mounting", "link", "base")
    joint   column of the joint values that it feels; None where nothing moves
    place   index of the place whose frame its terms are in
    """

    owner: str
    kind: str
    joint: int | None
    place: int
    source: ErrorSource
    motion: Motion

    def terms(self) -> tuple[PlacedTerm, ...]:
        """Return its terms."""
        return tuple(PlacedTerm(self.owner, self.kind, self.joint, self.place, term) for term in self.source.terms(self.motion))


@dataclass(frozen=True, slots=True)
class PlacedTerm:
    """A term with what `PlacedPart` says of its part."""

    owner: str
    kind: str
    joint: int | None
    place: int
    term: Term

    @property
    def name(self) -> str:
        """Return the full name ("joints.A.gearbox.backlash")."""
        return f"{self.owner}.{self.term.name}"
