"""The parts of a mechanism and their error terms, each with the place whose frame it acts in."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.parts.joint import has_axis
from lostmotion.parts.term import Motion

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.mechanism.places import Tree
    from lostmotion.parts.base import Base
    from lostmotion.parts.environment import Environment
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.parts.joint import Joint
    from lostmotion.parts.term import Holding, Term


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


def placed_parts(
    base: Base,
    joints: Sequence[Joint],
    tree: Tree,
    environment: Environment,
    holding: Callable[[int], Holding],
) -> tuple[PlacedPart, ...]:
    """Return the parts of a mechanism that have errors, in the order of their places.

    holding  returns the largest static load of a joint, by its index
    """
    rise, varies = environment.rise, environment.temperature_varies
    no_motion = Motion(np.zeros(6), rise=rise, varies=varies)
    out = [
        PlacedPart(f"base {name}", "base", None, 0, source, no_motion)
        for name, source in base.sources.items()
    ]
    for k, (joint, (seat, moved, tip)) in enumerate(zip(joints, tree.joints, strict=True)):
        owner, column = f"joints.{joint.name}", tree.places[moved].joint
        if joint.mounting is not None:
            axis = Motion(joint.twist if joint.twist.any() else np.eye(6)[2])
            out.append(
                PlacedPart(f"{owner}.mounting", "mounting", column, seat, joint.mounting, axis)
            )
        motion = Motion(
            joint.twist,
            functools.partial(holding, k),
            rise,
            varies,
            joint.limits if has_axis(joint) else None,
        )
        out += [
            PlacedPart(f"{owner}.{name}", name.partition(" ")[0], column, moved, source, motion)
            for name, source in joint.sources.items()
        ]
        link = joint.elastic_link
        out.append(PlacedPart(f"{owner}.link", "link", column, tip, link, no_motion))
    return tuple(out)
