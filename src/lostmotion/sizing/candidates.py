"""Candidates for the parts of an arm: sections of links, gearboxes and bearing clearances, with
their masses and prices.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from lostmotion.mechanism.leg_copies import leg_copies
from lostmotion.parts.family import section_text
from lostmotion.sizing.lightest import with_section
from lostmotion.sizing.size_steps import EXACT, SizeSteps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.family import Family
    from lostmotion.parts.joint import Joint
    from lostmotion.parts.material import Material
    from lostmotion.parts.section import Plain

PartKind = Literal["link", "gearbox", "bearing"]

# Number of free sizes -> values of each in the first grid of a family.
_GRID: Final = {1: (12,), 2: (9, 4), 3: (7, 3, 3), 4: (6, 2, 2, 2)}
# Most sections of the first grid, evenly over the mass.
_MOST_SECTIONS: Final = 14


@dataclass(frozen=True, slots=True)
class LinkOptions:
    """Options for one link: a family or a list of sections, and its new material (None: its
    own).
    """

    choice: Family | tuple[Plain, ...]
    material: Material | None = None


@dataclass(frozen=True, slots=True)
class PartCandidate:
    """One candidate for a part, with its mass (kg) and price (in one currency).

    part        a section, a gearbox, or a bearing with its clearance; None: the present part
    file_value  value in an arm file; None for a section
    values      free sizes of a section from a family
    note        remark for the report
    """

    name: str
    part: Any
    mass: float = 0.0
    price: float = 0.0
    file_value: Any = None
    values: tuple[float, ...] = ()
    note: str = ""


@dataclass(frozen=True)
class Slot:
    """One part to select at a joint, and at the joints of `copies`. Masses and prices are of all of
    them.

    present        the present part; its price is NaN where unknown
    material       new material of a link; None: its own
    family         family of a link's sections; its sizes are as `steps` allows, and differ by about
                   the ratio `spacing`
    per_kg         price per kg of link
    mass_in_joint  kg of the mass of each joint that is the present gearbox, which a selected one
                   replaces
    has_masses     whether the masses of the candidates are known; if not, the joint keeps its mass
    """

    joint: str
    kind: PartKind
    candidates: tuple[PartCandidate, ...]
    present: PartCandidate
    material: Material | None = None
    family: Family | None = None
    steps: SizeSteps = EXACT
    spacing: float = 1.0
    per_kg: float = 0.0
    mass_in_joint: float = 0.0
    has_masses: bool = True
    copies: tuple[str, ...] = ()

    @property
    def joints(self) -> tuple[str, ...]:
        """Return the joints that get the part."""
        return (self.joint, *self.copies)

    @property
    def label(self) -> str:
        """Return joint and kind of part, and the number of its copies."""
        count = len(self.copies)
        further = f" and {count} {'copy' if count == 1 else 'copies'}" if count else ""
        return f"{self.joint} {self.kind}{further}"

    def install(self, joint: Joint, candidate: PartCandidate) -> Joint:
        """Return the joint with this part."""
        if self.kind == "link":
            return (
                joint
                if candidate.part is None
                else with_section(joint, candidate.part, self.material)
            )
        changed: dict[str, Any] = {} if candidate.part is None else {self.kind: candidate.part}
        if self.kind == "gearbox" and candidate.part is not None:
            # The joint's mass is stated, because the gearbox has a mass of its own.
            changed["mass"] = (
                max(joint.total_mass - self.mass_in_joint, 0.0) + candidate.mass / len(self.joints)
                if self.has_masses
                else joint.total_mass
            )
        return joint.model_copy(update=changed) if changed else joint


@dataclass(frozen=True, slots=True)
class Objective:
    """Objective to minimise: weights of mass (per kg) and of price, non-negative and not both
    zero.
    """

    per_kg: float = 1.0
    per_price: float = 0.0

    @property
    def has_price(self) -> bool:
        """Return whether prices count."""
        return self.per_price > 0

    @property
    def text(self) -> str:
        """Return the objective as a sum ("price + 20 * mass")."""
        factors = ((self.per_price, "price"), (self.per_kg, "mass"))
        return " + ".join(
            name if factor == 1 else f"{factor:g} * {name}" for factor, name in factors if factor
        )

    def cost(self, mass: float, price: float) -> float:
        """Return the cost; a quantity of weight zero may be NaN."""
        return (self.per_kg * mass if self.per_kg else 0.0) + (
            self.per_price * price if self.per_price else 0.0
        )


def link_slot(
    joint: Joint,
    choice: Family | tuple[Plain, ...],
    material: Material | None,
    step: float | None,
    per_kg: float = 0.0,
) -> Slot:
    """Return the slot of a link with the sections of a list, or with a grid over a family that
    `refined_candidates` refines.

    step (m) of the sizes, 0: continuous, None: usual sizes; per_kg: price per kg of link.
    """
    weight = joint.link.total_mass
    section = joint.link.section
    present = "as stated" if section is None else section_text(section)
    slot = Slot(
        joint.name,
        "link",
        (),
        PartCandidate(present, None, weight, per_kg * weight),
        material,
        steps=SizeSteps(step),
        per_kg=per_kg,
    )
    if isinstance(choice, tuple):
        return replace(slot, candidates=tuple(_weighed(joint, slot, each) for each in choice))
    spans = [choice.spans[k] for k in choice.free]
    counts = _GRID.get(len(spans), ())
    axes = [
        np.geomspace(span.low, span.high, count) for span, count in zip(spans, counts, strict=True)
    ]
    slot = replace(
        slot,
        family=choice,
        spacing=max(
            (
                (span.high / span.low) ** (1 / (n - 1))
                for span, n in zip(spans, counts, strict=True)
            ),
            default=1.0,
        ),
    )
    grid = [
        _of_family(joint, slot, tuple(float(x) for x in point))
        for point in itertools.product(*axes)
    ]
    return replace(
        slot, candidates=_pareto(joint, slot, [each for each in grid if each is not None])
    )


def for_copies(slots: Sequence[Slot], arm: Arm) -> tuple[Slot, ...]:
    """Return the slots with one for all copies of a leg that are offered the same parts."""
    out: list[Slot] = []
    copies_by_kind = {kind: leg_copies(arm, kind) for kind in {slot.kind for slot in slots}}
    for slot in slots:
        copies = copies_by_kind[slot.kind][slot.joint]
        for k, first in enumerate(out):
            if first.joint in copies and _offered(first) == _offered(slot):
                out[k] = replace(first, copies=(*first.copies, slot.joint))
                break
        else:
            out.append(slot)
    return tuple(_of_all(slot, len(slot.joints)) for slot in out)


def _offered(slot: Slot) -> str:
    return repr(replace(slot, joint="", copies=()))


def _of_all(slot: Slot, count: int) -> Slot:
    """Return the slot with masses and prices of this number of parts."""
    return replace(
        slot,
        candidates=tuple(_times(each, count) for each in slot.candidates),
        present=_times(slot.present, count),
    )


def _times(each: PartCandidate, count: int) -> PartCandidate:
    return replace(each, mass=count * each.mass, price=count * each.price)


def refined_candidates(
    joint: Joint, slot: Slot, selected: PartCandidate, ratio: float
) -> tuple[PartCandidate, ...]:
    """Return new sections of the slot's family around the selected one, each free size smaller or
    larger by this ratio, or equal.
    """
    if slot.family is None or not selected.values:
        return ()
    around = itertools.product(
        *((value / ratio, value, value * ratio) for value in selected.values)
    )
    known = {each.name for each in slot.candidates}
    sections = {
        each.name: each for point in around if (each := _of_family(joint, slot, point)) is not None
    }
    return tuple(each for name, each in sections.items() if name not in known)


def _of_family(joint: Joint, slot: Slot, free: tuple[float, ...]) -> PartCandidate | None:
    family = slot.family
    if family is None:
        return None
    values, chosen = [span.low for span in family.spans], []
    for k, value in zip(family.free, free, strict=True):
        values[k] = slot.steps.nearest(family, k, value)
        chosen.append(values[k])
    section = slot.steps.section(family, tuple(values))
    return (
        None if section is None else replace(_weighed(joint, slot, section), values=tuple(chosen))
    )


def _weighed(joint: Joint, slot: Slot, section: Plain) -> PartCandidate:
    mass = len(slot.joints) * with_section(joint, section, slot.material).link.total_mass
    return PartCandidate(section_text(section), section, mass, slot.per_kg * mass)


def _pareto(joint: Joint, slot: Slot, candidates: list[PartCandidate]) -> tuple[PartCandidate, ...]:
    """Return the Pareto-optimal sections in mass and tip compliance, at most `_MOST_SECTIONS`,
    evenly over their order.
    """
    optimal: list[PartCandidate] = []
    least = math.inf
    for each in sorted(
        {each.name: each for each in candidates}.values(), key=lambda each: each.mass
    ):
        matrix = with_section(joint, each.part, slot.material).elastic_link.tip_compliance
        compliance = float(np.linalg.norm(matrix[3:, 3:], 2))
        if compliance < least:
            optimal.append(each)
            least = compliance
    if len(optimal) > _MOST_SECTIONS:
        optimal = [
            optimal[int(k)] for k in np.linspace(0, len(optimal) - 1, _MOST_SECTIONS).round()
        ]
    return tuple(optimal)
