"""Which keys of an arm file are to take which values: the table `[sweep]`, in the arm file itself
or in a TOML of its own.

    [sweep]
    "gearboxes.cycloidal.backlash" = ["0.25 arcmin", "0.5 arcmin ± 0.2 arcmin", "1 arcmin"]    # a
    list: any value that the key takes "joints.B.link.length" = { from = "300 mm", to = "500 mm",
    steps = 5 }                      # a range, ends included
    "payload.mass" = { from = "0.1 kg", to = "10 kg", steps = 3, spacing = "log" }

Every combination is a design. A key goes from table to table as in mistakes and budgets, joints by
their names; where a joint names a part that it shares, `joints.A.gearbox.backlash` changes A's
alone and `gearboxes.NAME.backlash` changes it for all.
"""

from __future__ import annotations

import math
import re
import sys
from typing import TYPE_CHECKING, Annotated, Any, Final

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from lostmotion.errors import Problem, shown
from lostmotion.io.arm_builder import SWEEP as TABLE
from lostmotion.io.limits import MOST_MISTAKES, nearest
from lostmotion.io.toml import key_step, key_steps, request_of, source_of

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

EXAMPLE: Final = '"gearboxes.cycloidal.backlash" = ["0.5 arcmin", "1 arcmin"]'
MOST_KEYS: Final = 8
MOST_VALUES: Final = 1000
MOST_DESIGNS: Final = 10_000
_LONGEST_KEY: Final = 200
_LONG_LABEL: Final = 12
# With a key of its own, since other keys take other quantities.
_RANGE: Final = (
    '"gearboxes.cycloidal.backlash" = { from = "0.5 arcmin", to = "1 arcmin", steps = 5 }'
)
_RANGE_KEYS: Final = ("from", "to", "steps", "spacing")
_SPACINGS: Final = ("even", "log")
_AMOUNT: Final = re.compile(
    r"^\s*(?P<number>[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(?P<unit>[^0-9.±+-][^0-9±+-]{0,30})?\s*$"
)


class Axis(BaseModel):
    """One key and the values it takes, as they would stand in the arm file."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    key: Annotated[str, Field(min_length=1, max_length=_LONGEST_KEY)]
    values: Annotated[tuple[Any, ...], Field(min_length=1, max_length=MOST_VALUES)]

    @property
    def steps(self) -> list[str]:
        """Return the names that the key leads through."""
        return key_steps(self.key)

    @property
    def labels(self) -> tuple[str, ...]:
        """Return each value as text for people; quantities of a range with four digits, where that
        distinguishes them.
        """
        plain = tuple(value if isinstance(value, str) else shown(value) for value in self.values)
        if self.quantities is None:
            return plain
        numbers, unit = self.quantities
        short = tuple(f"{number:.4g} {unit}".strip() for number in numbers)
        return (
            short
            if len(set(short)) == len(set(numbers)) and max(map(len, plain)) > _LONG_LABEL
            else plain
        )

    @property
    def quantities(self) -> tuple[tuple[float, ...], str] | None:
        """Return the values as numbers, and the unit they are all stated in; None where they are no
        plain quantities in one unit.
        """
        found = [_amount(value) for value in self.values]
        quantities = [each for each in found if each is not None]
        units = {unit for _, unit in quantities}
        return (
            (tuple(number for number, _ in quantities), units.pop())
            if len(quantities) == len(found) and len(units) == 1
            else None
        )


def read_axes(
    arm: Path | Mapping[str, Any] | None, by: Path | Mapping[str, Any] | None = None
) -> tuple[tuple[Axis, ...], list[Problem], str]:
    """Return the keys that are swept, with their values. Of the table in `by`, or else in `arm`,
    files or dictionaries; none where it has no such table.

    Returns the axes that can be read, every mistake in the table, each under its key, and what
    messages call the file; whether the arm accepts the values is checked by
    `sweep_designs.read_sweep`. Raises InputError for a file that is no TOML.
    """
    if by is None and arm is None:
        return (), [], ""
    file, tree = source_of("arm", arm) if by is None else request_of(by, TABLE)  # type: ignore[arg-type] # one of both
    mistakes = []
    if by is not None:
        mistakes = [
            Problem(
                file,
                shown(key)[1:-1],
                f"an unknown key with {shown(value)}",
                f"one table [{TABLE}]",
                EXAMPLE,
                nearest(key, [TABLE]),
            )
            for key, value in list(tree.items())[:MOST_MISTAKES]
            if key != TABLE
        ]
    if TABLE not in tree:
        if by is not None:
            mistakes.append(
                Problem(
                    file,
                    TABLE,
                    "nothing",
                    "a table of keys and their values",
                    f"[{TABLE}] with {EXAMPLE}",
                )
            )
        return (), mistakes, file
    return _axes(file, tree[TABLE], mistakes), mistakes, file


def designs(axes: tuple[Axis, ...]) -> int:
    """Return the number of designs: all combinations of the values."""
    return math.prod(len(axis.values) for axis in axes)


def changes(axes: tuple[Axis, ...], design: int) -> dict[str, Any]:
    """Return the value of each key in this design. The last key changes fastest."""
    shape = tuple(len(axis.values) for axis in axes)
    at = np.unravel_index(design, shape) if axes else ()
    return {axis.key: axis.values[int(index)] for axis, index in zip(axes, at, strict=True)}


def _axes(file: str, stated: Any, mistakes: list[Problem]) -> tuple[Axis, ...]:  # noqa: ANN401 - whatever a file holds
    if not isinstance(stated, dict):
        mistakes.append(
            Problem(
                file,
                TABLE,
                shown(stated),
                "a table of keys and their values",
                f"[{TABLE}] with {EXAMPLE}",
            )
        )
        return ()
    flat = _flat(stated)
    if not 1 <= len(flat) <= MOST_KEYS:
        mistakes.append(
            Problem(file, TABLE, f"{len(flat)} keys", f"from 1 to {MOST_KEYS}", EXAMPLE)
        )
        return ()
    keys = [key for key, _ in flat]
    mistakes += [
        Problem(file, f"{TABLE}.{key_text(key)}", "stated twice", "each key once", EXAMPLE)
        for key in sorted(set(keys))
        if keys.count(key) > 1
    ]
    axes = [_axis(file, key, value, mistakes) for key, value in flat]
    found = tuple(axis for axis in axes if axis is not None)
    if designs(found) > MOST_DESIGNS:
        grid = " x ".join(str(len(axis.values)) for axis in found)
        mistakes.append(
            Problem(
                file,
                TABLE,
                f"{grid} = {designs(found)} designs",
                f"at most {MOST_DESIGNS}",
                "fewer values, or several sweeps",
            )
        )
    return found


def _flat(stated: dict[str, Any], above: str = "") -> list[tuple[str, Any]]:
    """Return keys and values; a key may be written as one text, as TOML's dotted key, or as
    tables.
    """
    out = []
    for key, value in stated.items():
        if isinstance(value, dict) and value and not set(_RANGE_KEYS) & value.keys():
            out += _flat(value, f"{above}{key_step(key) if above else key}.")
        else:
            out.append((f"{above}{key}", value))
    return out


def key_text(key: str) -> str:
    """Return a key as text, as in the table."""
    return '"' + shown(key, _LONGEST_KEY)[1:-1] + '"'


def _axis(file: str, key: str, value: Any, mistakes: list[Problem]) -> Axis | None:  # noqa: ANN401 - whatever a file holds
    where = f"{TABLE}.{key_text(key)}"
    if len(key) > _LONGEST_KEY or not all(key_steps(key)):
        mistakes.append(
            Problem(file, where, "no path of keys", "names with dots between them", EXAMPLE)
        )
        return None
    values = value
    if isinstance(value, dict):
        values = _range(file, where, value, mistakes)
    elif not isinstance(value, list) or not 1 <= len(value) <= MOST_VALUES:
        found = f"{len(value)} values" if isinstance(value, list) else shown(value)
        mistakes.append(
            Problem(file, where, found, f"a list of 1 to {MOST_VALUES} values, or a range", _RANGE)
        )
        return None
    odd = [each for each in values if not _is_plain(each)]
    mistakes += [
        Problem(file, where, shown(each), "text, numbers, lists or tables", EXAMPLE) for each in odd
    ]
    return Axis(key=key, values=tuple(values)) if values and not odd else None


def _is_plain(value: Any) -> bool:  # noqa: ANN401 - whatever a file holds
    """Return whether JSON can hold a value as it is; not dates, not what is not finite."""
    if isinstance(value, list | dict):
        return all(
            _is_plain(each) for each in (value.values() if isinstance(value, dict) else value)
        )
    return isinstance(value, str | bool | int) or (
        isinstance(value, float) and math.isfinite(value)
    )


def _range(file: str, where: str, stated: dict[str, Any], mistakes: list[Problem]) -> list[Any]:
    """Lay out a range's values: text with a unit where its ends have one, else numbers."""
    before = len(mistakes)
    for key in stated:
        if key not in _RANGE_KEYS:
            near = nearest(key, _RANGE_KEYS)
            mistakes.append(
                Problem(
                    file,
                    f"{where}.{shown(key)[1:-1]}",
                    "an unknown key",
                    "one of " + ", ".join(_RANGE_KEYS),
                    _RANGE,
                    near,
                )
            )
    steps, spacing = stated.get("steps"), stated.get("spacing", _SPACINGS[0])
    if isinstance(steps, bool) or not isinstance(steps, int) or not 2 <= steps <= MOST_VALUES:  # noqa: PLR2004 - two ends
        found = shown(steps) if "steps" in stated else "nothing"
        mistakes.append(
            Problem(
                file,
                f"{where}.steps",
                found,
                f"a whole number from 2 to {MOST_VALUES}, both ends counted",
                "steps = 5",
            )
        )
    if spacing not in _SPACINGS:
        mistakes.append(
            Problem(
                file,
                f"{where}.spacing",
                shown(spacing),
                "one of " + ", ".join(_SPACINGS),
                'spacing = "log"',
            )
        )
    ends = _ends(file, where, stated, mistakes)
    if ends is None or len(mistakes) > before or not isinstance(steps, int):
        return []
    low, high, unit = ends
    numbers = np.geomspace(low, high, steps) if spacing == "log" else np.linspace(low, high, steps)
    if unit:
        return [f"{number:.12g} {unit}" for number in numbers]
    return [
        int(number)
        if isinstance(stated["from"], int) and float(number).is_integer()
        else float(f"{number:.12g}")
        for number in numbers
    ]


def _ends(
    file: str, where: str, stated: dict[str, Any], mistakes: list[Problem]
) -> tuple[float, float, str] | None:
    """Return the ends of a range and their unit; None where they are wrong, which is noted."""
    ends = []
    for key in ("from", "to"):
        amount = _amount(stated.get(key))
        if amount is None:
            found = shown(stated[key]) if key in stated else "nothing"
            mistakes.append(
                Problem(
                    file,
                    f"{where}.{key}",
                    found,
                    "a number with its unit, without a tolerance",
                    _RANGE,
                )
            )
        else:
            ends.append(amount)
    if len(ends) < 2:  # noqa: PLR2004 - from and to
        return None
    (low, unit), (high, other) = ends
    if unit != other:
        mistakes.append(
            Problem(
                file,
                where,
                f"from in '{unit}', to in '{other}'",
                "the same unit at both ends",
                _RANGE,
            )
        )
        return None
    if stated.get("spacing") == "log" and not (low > 0 and high > 0):
        mistakes.append(
            Problem(
                file,
                where,
                f"from {low:g} to {high:g}",
                "ends above zero where steps are even in the logarithm",
                _RANGE,
            )
        )
        return None
    return low, high, unit


def _amount(value: Any) -> tuple[float, str] | None:  # noqa: ANN401 - whatever a file holds
    """Take a plain amount apart: its number, and its unit as written."""
    if isinstance(value, bool):
        return None
    if isinstance(value, int | float):
        # a whole number may be beyond every float
        return (float(value), "") if abs(value) <= sys.float_info.max else None
    match = _AMOUNT.match(value) if isinstance(value, str) else None
    number = float(match["number"]) if match else math.nan
    return (number, (match["unit"] or "").strip()) if match and math.isfinite(number) else None
