"""Differences between the descriptions of arms: value by value, and what is stated, assumed or
ideal.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from lostmotion.error_model.provenance import KINDS
from lostmotion.io.stated_values import stated_values

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.provenance import States
    from lostmotion.io.stated_values import StatedValue
    from lostmotion.mechanism.arm import Arm

# Digits of stated values, of assumed ones, and digits that distinguish values whose shorter texts
# are equal.
_DIGITS: Final = 6
_ASSUMED_DIGITS: Final = 4
_ALL_DIGITS: Final = 12
ABSENT: Final = "-"
WHOLE_JOINT: Final = "joint"


@dataclass(frozen=True, slots=True)
class Difference:
    """A value that is not the same in all arms.

    parts   the parts whose values differ in this way ("gearbox of A", "gearbox of B")
    key     of the value ("stiffness"); "joint" where whole joints are in some arms only
    texts   the value in each arm, with its reason where it is not a stated fact; "-" where the arm
            has none
    """

    parts: tuple[str, ...]
    key: str
    texts: tuple[str, ...]

    @property
    def name(self) -> str:
        """Return parts and key: "gearbox of A, B: stiffness"."""
        first, *others = self.parts
        if self.key == WHOLE_JOINT:
            return (
                f"joint{'s' if others else ''} "
                f"{', '.join(part.removeprefix('joint ') for part in self.parts)}"
            )
        return (
            ", ".join(
                [first, *(other.rpartition(" of ")[2].removeprefix("joint ") for other in others)]
            )
            + f": {self.key}"
        )


@dataclass(frozen=True, slots=True)
class StateChange:
    """A kind of error of a joint, or of the base, that is not equally well known in all arms: its
    state in each, "-" where there is none.
    """

    place: str
    kind: str
    states: tuple[str, ...]

    @property
    def described_in_some_only(self) -> bool:
        """Return whether some arm takes as perfect what another one describes."""
        return "ideal" in self.states and any(
            state not in {"ideal", ABSENT} for state in self.states
        )


def value_differences(arms: Sequence[Arm]) -> tuple[Difference, ...]:
    """Return the values that differ between the arms, in the order of the first arm that has them.
    Equal ones of several joints are one entry.
    """
    joints = [{joint.name: joint for joint in arm.joints} for arm in arms]
    names = list(dict.fromkeys(name for each in joints for name in each))
    missing = [name for name in names if not all(name in each for each in joints)]
    found = [
        Difference(
            (f"joint {name}",),
            WHOLE_JOINT,
            tuple(each[name].type if name in each else ABSENT for each in joints),
        )
        for name in missing
    ]
    of_missing = {
        owner
        for name in missing
        for owner in _owners(name, [each[name] for each in joints if name in each])
    }
    rough, short, full = (
        [stated_values(arm, digits) for arm in arms]
        for digits in (_ASSUMED_DIGITS, _DIGITS, _ALL_DIGITS)
    )
    for place in dict.fromkeys(place for each in short for place in each):
        cells = [each.get(place) for each in short]
        if place[0] in of_missing or len({_identity(cell) for cell in cells}) == 1:
            continue
        texts = _texts(
            [
                coarse.get(place) if cell is not None and cell.reason else cell
                for coarse, cell in zip(rough, cells, strict=True)
            ]
        )
        if len(set(texts)) == 1:
            texts = _texts([each.get(place) for each in full])
        found.append(Difference((place[0],), place[1], texts))
    return tuple(_together(found))


def state_changes(known: Sequence[States]) -> tuple[StateChange, ...]:
    """Return the kinds of error that are not in the same state in all arms, of joints that all arms
    have and of the base.
    """
    tables = [{each.joint: each.states for each in (*of.joints, *of.fixed)} for of in known]
    places = [
        (name, kind) for name in tables[0] if all(name in each for each in tables) for kind in KINDS
    ]
    found = [
        StateChange(name, kind, tuple(each.get(name, {}).get(kind, ABSENT) for each in tables))
        for name, kind in places
    ]
    found += [
        StateChange("base", kind, tuple(of.base.get(kind, ABSENT) for of in known))
        for kind in known[0].base
    ]
    return tuple(each for each in found if len(set(each.states)) > 1)


def _owners(name: str, joints: Sequence[object]) -> set[str]:
    """Return the names of the parts of a joint."""
    fields = (each for joint in joints for each in type(joint).model_fields)  # type: ignore[attr-defined]
    return {f"joint {name}", *(f"{field} of {name}" for field in fields)}


def _identity(value: StatedValue | None) -> tuple[str, str] | None:
    return None if value is None else (value.exact, value.reason)


def _texts(values: Sequence[StatedValue | None]) -> tuple[str, ...]:
    return tuple(
        ABSENT if each is None else each.text + (f" ({each.reason})" if each.reason else "")
        for each in values
    )


def _together(differences: Sequence[Difference]) -> list[Difference]:
    """Return the differences, those of one key with the same values at several joints as one."""
    groups: dict[tuple[str, str, tuple[str, ...]], list[str]] = {}
    for each in differences:
        kind, _, joint = each.parts[0].partition(" of ")
        kind = (
            kind
            if joint
            else each.parts[0].partition(" ")[0]
            if each.parts[0].startswith("joint ")
            else each.parts[0]
        )
        groups.setdefault((kind, each.key, each.texts), []).append(each.parts[0])
    return [Difference(tuple(parts), key, texts) for (_, key, texts), parts in groups.items()]
