"""Classes of drive: what a joint's drive usually is, by the load that it is to give, before any
part is chosen.
"""

from __future__ import annotations

import functools
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from lostmotion.catalogue import data_file
from lostmotion.catalogue.presets import PARTS
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

# By type of joint: the quantity of a drive's load.
LOADS: Final = {
    "revolute": Quantity("N m", "150 N m", above=0, high=1e7),
    "prismatic": Quantity("N", "500 N", above=0, high=1e9),
}
_LARGEST: Final = {"revolute": "largest_torque", "prismatic": "largest_force"}
_LAW: Final = {"at", "power"}
# Numbers of a quantity as text, apart from shares.
_NUMBER: Final = re.compile(r"[0-9]+(?:\.[0-9]+)?(?:e[+-]?[0-9]+)?(?=\s+[A-Za-zµ°])")
_DIGITS: Final = 4


@dataclass(frozen=True, slots=True)
class DriveClass:
    """One class of drive.

    order     position in the order of size, from 0
    largest   largest load of a drive of the class by type of joint, N m or N; infinite for the last
              class
    beyond    factor by which arms of the class may be worse than its laws, where no next class
              shows it; else 1
    examples  what arms of the class are
    laws      by type of joint: the table of the data file
    """

    name: str
    order: int
    largest: Mapping[str, float]
    beyond: float
    examples: str
    laws: Mapping[str, Mapping[str, Any]]

    def values(self, kind: str, load: float) -> dict[str, Any]:
        """Return the keys of a joint's table in an arm file, quantities as text, for a drive of
        this load (N m or N) on a joint of this type.

        Laws are powers of the load, and hold for every load above zero.
        """
        laws = self.laws[kind]
        ratio = load / self.reference(kind)
        return {
            key: _at(value, ratio) for key, value in laws.items() if key in PARTS or key == "mass"
        }

    def source(self, kind: str, part: str) -> str:
        """Return where the values of a part come from, with their marks; `part` "joint" for the
        mass.
        """
        laws = self.laws[kind]
        return str(laws["source"] if part == "joint" else laws[part]["source"])

    def reference(self, kind: str) -> float:
        """Return the load (N m or N) at which the laws have their stated values."""
        return load_of(self.laws[kind]["reference"], kind)


@functools.cache
def drive_classes() -> dict[str, DriveClass]:
    """Return the classes of drive by name, in order of size."""
    return {
        entry["name"]: DriveClass(
            entry["name"],
            order,
            {kind: _load(entry[key]) for kind, key in _LARGEST.items()},
            float(entry.get("beyond", 1.0)),
            entry["examples"],
            {kind: entry[kind] for kind in _LARGEST},
        )
        for order, entry in enumerate(data_file("drive_classes.toml")["classes"])
    }


def load_of(text: str, kind: str) -> float:
    """Return the load (N m or N) of a drive on a joint of this type. Raises pydantic's error for
    any other text.
    """
    found = LOADS[kind](text)
    return found if isinstance(found, float) else found.nominal


def class_of(kind: str, load: float) -> DriveClass:
    """Return the class of an arm whose largest drive on a joint of this type gives this load, N m
    or N.
    """
    return next(each for each in drive_classes().values() if load <= each.largest[kind])


def neighbours(name: str) -> list[DriveClass]:
    """Return a class with the next smaller and the next larger one, in order of size."""
    every = list(drive_classes().values())
    at = drive_classes()[name].order
    return every[max(at - 1, 0) : at + 2]


def _load(text: str) -> float:
    number, _, _ = text.partition(" ")
    return float(number)


def _at(value: Any, ratio: float) -> Any:  # noqa: ANN401 - whatever the data file holds
    """Return a value, or the values of a table, for a load of `ratio` times the reference."""
    if not isinstance(value, dict):
        return value
    if value.keys() == _LAW:
        return scaled(value["at"], ratio ** value["power"])
    return {key: _at(each, ratio) for key, each in value.items() if key != "source"}


def scaled(text: str, factor: float) -> str:
    """Return a quantity as text times a factor, with its tolerance; a tolerance in per cent stays.
    At most four significant digits.
    """
    return _NUMBER.sub(lambda number: _plain(float(number[0]) * factor), text)


def _plain(number: float) -> str:
    """Return a number with at most four significant digits, without a power of ten."""
    return f"{float(f'{number:.{_DIGITS}g}'):.12f}".rstrip("0").rstrip(".")
