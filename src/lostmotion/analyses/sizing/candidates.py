"""What may an arm be made of? For each link its sections, for each joint its gearboxes and its bearings' clearances; what they weigh and cost."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from lostmotion.analyses.sizing.lightest import with_section
from lostmotion.parts.family import rounded, said
from lostmotion.parts.section import Sized

if TYPE_CHECKING:
    from lostmotion.parts.family import Family
    from lostmotion.parts.joint import Joint
    from lostmotion.parts.material import Material
    from lostmotion.parts.section import Plain

What = Literal["link", "gearbox", "bearing"]

# Sections of a family that a search begins with: so many values of each free size, by how many are free.
_GRID: Final = {1: (12,), 2: (9, 4), 3: (7, 3, 3), 4: (6, 2, 2, 2)}
# Of those that are not both heavier and weaker than another, so many at most, evenly over the mass.
_MOST_SECTIONS: Final = 14
_SHARE_STEP: Final = 1e-3


@dataclass(frozen=True, slots=True)
class Candidate:
    """One way to make one part: what it is called, what it is, what it weighs (kg) and costs (any one currency).

    part    a section, a gearbox, or a bearing with its clearance; None: as the arm states it
    stated  how an arm file says it; values of the free sizes for a section out of a family; note what the reader should know of it
    """

    name: str
    part: Any
    mass: float = 0.0
    price: float = 0.0
    stated: Any = None
    values: tuple[float, ...] = ()
    note: str = ""


@dataclass(frozen=True)
class Slot:
    """One part of the arm that is to be chosen.

    joint       by name; what is chosen there
    candidates  the ways to make it
    present     what there is now; its price NaN where nobody said it
    material    of a link, where another one is wanted
    family      that a link's sections come from, with the step (m) of its sizes and the spacing (ratio of neighbours) that they have
    in_joint    kg of the joint's own mass that the present gearbox accounts for: a chosen one takes its place
    weighs      whether the masses of the candidates are known; if not, the joint weighs what it does now
    """

    joint: str
    what: What
    candidates: tuple[Candidate, ...]
    present: Candidate
    material: Material | None = None
    family: Family | None = None
    step: float = 0.0
    spacing: float = 1.0
    per_kg: float = 0.0
    in_joint: float = 0.0
    weighs: bool = True

    @property
    def label(self) -> str:
        """Name the part."""
        return f"{self.joint} {self.what}"

    def put(self, joint: Joint, candidate: Candidate) -> Joint:
        """Give the joint with this part in it."""
        if self.what == "link":
            return joint if candidate.part is None else with_section(joint, candidate.part, self.material)
        changed: dict[str, Any] = {} if candidate.part is None else {self.what: candidate.part}
        if self.what == "gearbox" and candidate.part is not None:
            # Stated, so that it holds whatever mass the gearbox put here carries itself.
            changed["mass"] = max(joint.total_mass - self.in_joint, 0.0) + candidate.mass if self.weighs else joint.total_mass
        return joint.model_copy(update=changed) if changed else joint


@dataclass(frozen=True, slots=True)
class Worth:
    """What is to be small: so much per kg and so much per unit of price. Both at least zero, and not both zero."""

    mass: float = 1.0
    price: float = 0.0

    def of(self, mass: float, price: float) -> float:
        """Give the cost; what counts for nothing need not be known."""
        return (self.mass * mass if self.mass else 0.0) + (self.price * price if self.price else 0.0)


def link_slot(joint: Joint, choice: Family | tuple[Plain, ...], material: Material | None, step: float, per_kg: float = 0.0) -> Slot:
    """Among which sections is a link to be chosen? Those of a list as they are; of a family a grid, from which `finer` goes on.

    step (m) of the sizes, 0: as they come; per_kg what a kilogram of link costs.
    """
    weight = joint.link.total_mass
    section = joint.link.section
    name = said(section) if isinstance(section, Sized.__origin__) else "as stated" if section is None else str(section.kind)  # type: ignore[attr-defined]
    slot = Slot(joint.name, "link", (), Candidate(name, None, weight, per_kg * weight), material, step=step, per_kg=per_kg)
    if isinstance(choice, tuple):
        return replace(slot, candidates=tuple(_weighed(joint, slot, each) for each in choice))
    spans = [choice.spans[k] for k in choice.free]
    counts = _GRID.get(len(spans), ())
    axes = [np.geomspace(span.low, span.high, count) for span, count in zip(spans, counts, strict=True)]
    slot = replace(
        slot, family=choice, spacing=max(((span.high / span.low) ** (1 / (n - 1)) for span, n in zip(spans, counts, strict=True)), default=1.0)
    )
    made = [_of_family(joint, slot, tuple(float(x) for x in point)) for point in itertools.product(*axes)]
    return replace(slot, candidates=_worth_trying(joint, slot, [each for each in made if each is not None]))


def finer(joint: Joint, slot: Slot, chosen: Candidate, ratio: float) -> tuple[Candidate, ...]:
    """Which sections of the slot's family lie around the one chosen, each free size by this ratio smaller, as it is, or larger? New ones only."""
    if slot.family is None or not chosen.values:
        return ()
    around = itertools.product(*((value / ratio, value, value * ratio) for value in chosen.values))
    known = {each.name for each in slot.candidates}
    found = {each.name: each for point in around if (each := _of_family(joint, slot, point)) is not None}
    return tuple(each for name, each in found.items() if name not in known)


def _of_family(joint: Joint, slot: Slot, free: tuple[float, ...]) -> Candidate | None:
    family = slot.family
    if family is None:
        return None
    values, kept = [span.low for span in family.spans], []
    for k, value in zip(family.free, free, strict=True):
        span = family.spans[k]
        step = _SHARE_STEP if span.share else slot.step
        values[k] = min(max(rounded(value, step), span.low), span.high)
        kept.append(values[k])
    section = family.section(tuple(values))
    return None if section is None else replace(_weighed(joint, slot, section), values=tuple(kept))


def _weighed(joint: Joint, slot: Slot, section: Plain) -> Candidate:
    mass = with_section(joint, section, slot.material).link.total_mass
    name = said(section) if isinstance(section, Sized.__origin__) else str(section.kind)  # type: ignore[attr-defined]
    return Candidate(name, section, mass, slot.per_kg * mass)


def _worth_trying(joint: Joint, slot: Slot, made: list[Candidate]) -> tuple[Candidate, ...]:
    """Leave out what is heavier than another and gives more; of the rest take some, evenly."""

    def gives(candidate: Candidate) -> float:
        bends = with_section(joint, candidate.part, slot.material).elastic_link.tip_compliance
        return float(np.linalg.norm(bends[3:, 3:], 2))

    kept: list[Candidate] = []
    least = math.inf
    for each in sorted({each.name: each for each in made}.values(), key=lambda each: each.mass):
        give = gives(each)
        if give < least:
            kept.append(each)
            least = give
    if len(kept) > _MOST_SECTIONS:
        kept = [kept[int(k)] for k in np.linspace(0, len(kept) - 1, _MOST_SECTIONS).round()]
    return tuple(kept)
