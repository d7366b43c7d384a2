"""Quantities of arguments: text with its unit, "0.5 mm", or a number in SI."""

from __future__ import annotations

import re
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from lostmotion.errors import InputError, Problem, shown
from lostmotion.units import Quantity, Toleranced

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

Amount: TypeAlias = str | float
# What errors are to stay within, and the share of positions, or of robots, that are to.
TARGET: Final = Quantity("m", "0.5 mm", above=0, high=100)
SHARE: Final = Quantity("", "95 %", low=0.5, high=0.999)
# Along or about x, y and z.
_AXES: Final = 3
_LONGEST: Final = 400
_BETWEEN: Final = re.compile(r"\s*,\s*|\s+x\s+|\s*×\s*")
_UNIT: Final = re.compile(r"[A-Za-zµμ°%′″'\"]")


@dataclass(frozen=True)
class Three:
    """Three quantities along or about x, y and z: the kind of each, and an example of all three as
    text.
    """

    each: Quantity
    example: str

    @property
    def expected(self) -> str:
        """Return the description of the values that are accepted."""
        which = {"m": "lengths, along", "rad": "angles, about"}[self.each.si]
        return f"three {which} x, y and z, each {self.each.expected}"


def amount(name: str, value: object, wanted: Quantity) -> float:
    """Return a quantity in SI. `value` is text with its unit, or a number in SI; `name` is the
    argument, for the message.

    Raises InputError for text without a unit, another dimension, a number that is not finite, and a
    quantity out of range.
    """
    from pydantic_core import PydanticCustomError

    given: Any = (
        float(value) if isinstance(value, Real) and not isinstance(value, bool | int) else value
    )
    try:
        found = wanted(given)
    except PydanticCustomError as error:
        why = (error.context or {})["why"]
        raise InputError(
            [
                Problem(
                    "",
                    name,
                    f"{shown(value)} ({why})",
                    wanted.expected,
                    passing=((name, wanted.example),),
                )
            ]
        ) from None
    return found.nominal if isinstance(found, Toleranced) else found


def three(name: str, value: object, wanted: Three) -> tuple[float, float, float]:
    """Return three quantities along, or about, x, y and z, in SI, from a sequence, or one text with
    commas or ' x ' between them.

    One text may state the unit once, at the end: "0, 0, 400 mm". Raises InputError with every
    mistake, as `amount`.
    """
    parts: list[Any]
    if isinstance(value, str):
        parts = _BETWEEN.split(value.strip()) if len(value) <= _LONGEST else []
        unit = parts[-1].lstrip("+-.0123456789eE ") if parts else ""
        parts = [part if _UNIT.search(part) else f"{part} {unit}" for part in parts]
    else:
        parts = list(value) if hasattr(value, "__iter__") and hasattr(value, "__len__") else []
    if len(parts) != _AXES:
        raise InputError(
            [Problem("", name, shown(value), wanted.expected, passing=((name, wanted.example),))]
        )
    x, y, z = each_of(name, parts, [wanted.each] * _AXES)
    return x, y, z


def each_of(name: str, values: Sequence[object], wanted: Sequence[Quantity]) -> list[float]:
    """Return as many quantities in SI as `wanted` has entries. Raises InputError with every
    mistake, all under one name.
    """
    return list(
        read_quantities(
            dict(enumerate(values)), dict(enumerate(wanted)), lambda _: name, needed=True
        ).values()
    )


def read_quantities(
    asked: Mapping[Any, object],
    wanted: Mapping[Any, Quantity | Three],
    named: Any = str,  # noqa: ANN401 - from key to name
    *,
    needed: bool = False,
) -> dict[Any, Any]:
    """Return in SI the quantities that `wanted` lists; a value of None is skipped, or refused where
    all are `needed`.

    Raises InputError with every mistake at once.
    """
    out: dict[Any, Any] = {}
    problems: dict[Problem, None] = {}
    for key, value in asked.items():
        field = wanted.get(key)
        if field is None or (value is None and not needed):
            continue
        try:
            out[key] = (
                three(named(key), value, field)
                if isinstance(field, Three)
                else amount(named(key), value, field)
            )
        except InputError as mistake:
            problems |= dict.fromkeys(mistake.problems)
    if problems:
        raise InputError(list(problems))
    return out
