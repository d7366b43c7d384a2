"""Sizes of an arm's parts that a target allocates, and the error terms that scale with each of
them.

An item is one cause in one part: the backlash of joint A's gearbox, the stiffness of link B, an
encoder's zero. Its terms are proportional to its size, or to the inverse of a stiffness; a
tolerance stated as ± scales with it. A term without a parameter is an item of its own.

An item whose allowance exceeds the largest usual size does not limit the target. Usual sizes are
round values, each coarser than what manufacturers of robot parts state: 60' of backlash, 100
encoder counts per turn, 200 µm of bearing clearance, a length tolerance of 1 % (ISO 2768-1, class
v: ±4 mm from 400 mm on). Stiffness depends on the arm and parts by drawing have no single size;
their errors may be ten times as large.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from lostmotion.parts.term import Parameter
from lostmotion.printed import ARCMIN

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.error_model.columns import Column
    from lostmotion.mechanism.arm import Arm


_TURNING: Final = 60 * ARCMIN
_SLIDING: Final = 1e-3
# Largest usual factor on the errors of a stiffness, and of items without a size.
MOST_TIMES: Final = 10.0
# Largest usual length tolerance, as a share of the length.
MOST_OF_LENGTH: Final = 0.01
# (kind of part, cause) -> largest usual size by unit: of a revolute and of a prismatic joint, or
# one for both.
_USUAL: Final[dict[tuple[str, str], dict[str, float]]] = {
    ("gearbox", "play"): {"rad": _TURNING, "m": _SLIDING},
    ("gearbox", "hysteresis"): {"rad": _TURNING, "m": _SLIDING},
    ("gearbox", "transmission error"): {"rad": _TURNING, "m": _SLIDING},
    ("bearing", "clearance"): {"m": 200e-6},
    ("bearing", "axial play"): {"m": 500e-6},
    ("bearing", "radial runout"): {"m": 100e-6},
    ("bearing", "axial runout"): {"m": 100e-6},
    ("encoder", "resolution"): {"rad": 2 * math.pi / 100, "m": _SLIDING},
    ("encoder", "noise"): {"rad": _TURNING, "m": _SLIDING},
    ("encoder", "eccentricity"): {"rad": _TURNING, "m": _SLIDING},
    ("encoder", "zero"): {"rad": _TURNING, "m": _SLIDING},
    ("servo", "dead_band"): {"rad": _TURNING, "m": _SLIDING},
    ("mounting", "axis tilt"): {"rad": _TURNING},
    ("mounting", "axis offset"): {"m": 1e-3},
    ("base", "roll"): {"rad": math.radians(30)},
    ("base", "pitch"): {"rad": math.radians(30)},
    ("lumped", "angle"): {"rad": 3 * _TURNING, "m": 5e-3},
    ("lumped", "offset"): {"m": 5e-3},
}


def largest_usual_factor(
    kind: str, cause: str, value: float, unit: str, length: float = 0.0
) -> float:
    """Return the factor from an item's size (SI, `unit`) to its largest usual one; at least 1,
    because the stated size exists.

    kind, cause  the kind of part and the cause, as an item names them; `length` (m) of a link, for
                 its tolerance
    """
    if (kind, cause) == ("link", "length tolerance"):
        largest = MOST_OF_LENGTH * length
    else:
        largest = _USUAL.get((kind, cause), {}).get(unit, MOST_TIMES * value)
    return max(largest / value, 1.0)


@dataclass(frozen=True, slots=True)
class StatedSize:
    """A size as the file states it: value in SI, its unit, whether the error is inversely
    proportional (a stiffness), and its number of zones.
    """

    value: float
    unit: str
    divides: bool = False
    zones: int = 1

    def at(self, factor: float) -> float:
        """Return the size with which the error is `factor` times as large."""
        if not self.divides:
            return self.value * factor
        return self.value / factor if factor else float("inf")


@dataclass(frozen=True, slots=True)
class Item:
    """One cause in one part, or in all parts of a kind; `columns` are its terms, `size` is None
    where it is not stated by one value.

    most   factor on its errors at the largest usual size
    stiff  whether it is a stiffness, to which the errors are inversely proportional
    """

    owner: str
    kind: str
    cause: str
    columns: tuple[int, ...]
    size: StatedSize | None = None
    most: float = MOST_TIMES
    stiff: bool = False

    @property
    def name(self) -> str:
        """Return the part and the cause ("joints.A.gearbox play")."""
        return self.owner if self.owner.endswith(self.cause) else f"{self.owner} {self.cause}"


def items(arm: Arm, columns: Sequence[Column]) -> tuple[Item, ...]:
    """Return the items of these columns, in the order of the chain; every column belongs to exactly
    one item.
    """
    reaches = {f"joints.{joint.name}.link": joint.link.reach for joint in arm.joints}
    groups: dict[tuple[str, str], list[int]] = {}
    for k, column in enumerate(columns):
        groups.setdefault((column.owner, _parameter(column).key), []).append(k)
    return tuple(
        _item([columns[k] for k in members], tuple(members), reaches.get(owner, 0.0))
        for (owner, _), members in groups.items()
    )


def _parameter(column: Column) -> Parameter:
    term = column.of.term
    return term.parameter or Parameter(term.cause)


def _item(terms: Sequence[Column], members: tuple[int, ...], reach: float) -> Item:
    of, sized = terms[0].of, _parameter(terms[0])
    stiff = of.term.exponent < 0
    size = None if sized.value is None else StatedSize(sized.value, sized.unit, stiff, sized.zones)
    if size is None or stiff:
        return Item(of.owner, of.kind, sized.key, members, size, stiff=stiff)
    most = largest_usual_factor(of.kind, sized.key, size.value, size.unit, reach)
    return Item(of.owner, of.kind, sized.key, members, size, most)


def shared_items(single: Iterable[Item]) -> tuple[Item, ...]:
    """Return an item for each cause in several parts of a kind, with a size where all of them have
    the same.
    """
    groups: dict[tuple[str, str], list[Item]] = {}
    for item in single:
        groups.setdefault((item.kind, item.cause), []).append(item)
    out = []
    for (kind, cause), members in groups.items():
        if len(members) > 1:
            sizes = {member.size for member in members}
            columns = tuple(column for member in members for column in member.columns)
            most = min(member.most for member in members)
            out.append(
                Item(
                    f"every {kind},",
                    kind,
                    cause,
                    columns,
                    members[0].size if len(sizes) == 1 else None,
                    most,
                    members[0].stiff,
                )
            )
    return tuple(out)
