"""Every value of an arm as a file would state it: by part and key, as text with its unit, and
whether it is assumed.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from lostmotion.band import Band
from lostmotion.io.field_schema import inside
from lostmotion.parts.error_source import Friction, Part
from lostmotion.parts.provenance import DEFAULT, Preset
from lostmotion.unit_registry import ABSOLUTE, ZERO_CELSIUS, factor
from lostmotion.units import Quantity, Toleranced

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from lostmotion.io.field_schema import Options
    from lostmotion.mechanism.arm import Arm

# Keys that state where values come from, and names that stand elsewhere.
_NO_VALUES: Final = frozenset({"assumed", "source", "upper_limits", "notes"})
# Units in which people state what the example of a field states otherwise.
_UNITS: Final = {"1/K": "µm/m/K", "kg m^2": "kg cm^2"}
_SMALL_LENGTH: Final = 1e-4
_ONE_DEGREE: Final = math.pi / 180
# Longer lists are counted, not written.
_MOST_VALUES: Final = 6
_EQUAL: Final = 1e-9


@dataclass(frozen=True, slots=True)
class StatedValue:
    """A value of a part: as text with its unit, why it is not a stated fact (empty where it is
    one), and its exact form for comparisons.

    A default that is used without being stated has the reason "default".
    """

    text: str
    reason: str
    exact: str


def stated_values(arm: Arm, digits: int = 6) -> dict[tuple[str, str], StatedValue]:
    """Return the values of an arm by part ("gearbox of A", "payload") and key ("stiffness",
    "section height"), in the order of the arm.

    What no file states and what is zero or absent by default is omitted. Texts have at most so many
    significant digits.
    """
    out: dict[tuple[str, str], StatedValue] = {}
    for name in ("base", "tool", "payload", "environment"):
        out |= {(name, key): value for key, value in _values(getattr(arm, name), "", digits)}
    if "gravity" in arm.model_fields_set:
        out["arm", "gravity"] = _leaf(arm, "gravity", "", digits)
    for joint in arm.joints:
        for name in type(joint).model_fields:
            part = getattr(joint, name)
            owner, reason = f"{name} of {joint.name}", joint.assumptions.get(name, "")
            if isinstance(part, Part) and not isinstance(part, Preset):
                out |= {(owner, key): value for key, value in _values(part, reason, digits)}
            elif name != "name" and name not in _NO_VALUES:
                out |= (
                    {(f"joint {joint.name}", _key(name)): _leaf(joint, name, reason, digits)}
                    if _counts(joint, name)
                    else {}
                )
    return out


def _values(
    part: Part, reason: str, digits: int, prefix: str = ""
) -> Iterator[tuple[str, StatedValue]]:
    """Yield the values of a part and of the parts that it consists of, each with its key; `reason`
    is that of the part as a whole.
    """
    reasons = getattr(part, "assumptions", {})
    for name in type(part).model_fields:
        value, why = getattr(part, name), reasons.get(name, reason)
        if name in _NO_VALUES:
            continue
        if isinstance(value, Part) and not isinstance(value, Preset):
            yield from _values(value, why, digits, f"{prefix}{_key(name)} ")
        elif (
            isinstance(value, list | tuple)
            and value
            and all(isinstance(each, Part) for each in value)
        ):
            for number, each in enumerate(value, 1):
                yield from _values(each, why, digits, f"{prefix}{_key(name)} {number} ")
        elif _counts(part, name):
            yield f"{prefix}{_key(name)}", _leaf(part, name, why, digits)


def _counts(part: Part, name: str) -> bool:
    """Return whether a value is stated, or is a default that is neither zero nor absent."""
    value = getattr(part, name)
    nothing = (
        value is None
        or (isinstance(value, Toleranced) and not value.nominal and not value.tolerance)
        or not _truth(value)
    )
    return not nothing or (name in part.model_fields_set and value is not None)


def _truth(value: Any) -> bool:  # noqa: ANN401 - whatever a field holds
    if isinstance(value, list | tuple):
        return any(_truth(each) for each in value)
    return bool(value.any()) if hasattr(value, "any") else bool(value)


def _key(name: str) -> str:
    return name.replace("_", " ")


def _leaf(part: Part, name: str, reason: str, digits: int) -> StatedValue:
    value = getattr(part, name)
    if isinstance(value, Preset):
        return StatedValue(value.name, "", value.name)
    stated = name in part.model_fields_set
    return StatedValue(
        _text(value, inside([type(part)], name), digits), reason if stated else DEFAULT, repr(value)
    )


def _text(value: Any, options: Options, digits: int) -> str:  # noqa: ANN401 - whatever a field holds
    """Return a value as a file would state it; `options` are the alternatives of its field."""
    quantity = next((each for each in options if isinstance(each, Quantity)), None)
    found = value.load if isinstance(value, Friction) else value
    if isinstance(found, bool):
        return "yes" if found else "no"
    if isinstance(found, Toleranced):
        return _toleranced(found, quantity, digits)
    if isinstance(found, int | float):
        return _amount(found, quantity, digits)
    return _several(found, options, digits) if isinstance(found, list | tuple) else _other(found)


def _several(values: Sequence[Any], options: Options, digits: int) -> str:
    """Return a short list of plain values in full, any other by its length."""
    if len(values) > _MOST_VALUES or any(
        isinstance(each, list | tuple | dict | Part) for each in values
    ):
        return _entries(len(values))
    return ", ".join(
        _text(each, inside(options, number), digits) for number, each in enumerate(values)
    )


def _other(value: object) -> str:
    """Return text as it stands, and a table or matrix by its size."""
    shape = getattr(value, "shape", None)
    if shape is not None:
        return f"matrix of {' x '.join(map(str, shape))}"
    return _entries(len(value)) if isinstance(value, dict) else str(value)


def _entries(count: int) -> str:
    return f"{count} {'entry' if count == 1 else 'entries'}"


def _toleranced(value: Toleranced, quantity: Quantity | None, digits: int) -> str:
    text = _amount(value.nominal, quantity, digits)
    if not value.tolerance:
        return text
    difference = quantity if quantity is None or quantity.si != ABSOLUTE else Quantity("K", "5 K")
    law = (
        ""
        if value.law == "normal"
        else f" ({value.law})"
        if isinstance(value.law, str)
        else " (its own distribution)"
    )
    return f"{text} ± {_amount(value.tolerance, difference, digits)}{law}"


def _amount(value: float, quantity: Quantity | None, digits: int) -> str:
    unit = _unit(quantity, value)
    ends = (value.low, value.high) if isinstance(value, Band) else (value,)
    return (
        f"{' .. '.join(_number(_in(end, quantity, unit), digits) for end in ends)} {unit}".strip()
    )


def _in(value: float, quantity: Quantity | None, unit: str) -> float:
    if quantity is None or not unit:
        return value
    return value - ZERO_CELSIUS if unit == "°C" else value / factor(unit, quantity.si)


def _unit(quantity: Quantity | None, value: float) -> str:
    """Return the unit in which people state a quantity of this size: that of the field's example,
    but for lengths and angles, which suit the size.
    """
    if quantity is None:
        return ""
    example = (
        re.sub(r"^[-+0-9.eE]+\s*", "", quantity.example)
        .partition("±")[0]
        .partition("..")[0]
        .strip()
    )
    if quantity.si == "m":
        return "µm" if 0 < abs(value) < _SMALL_LENGTH or (not value and example == "µm") else "mm"
    if quantity.si == "rad":
        return "deg" if example == "deg" or abs(value) >= _ONE_DEGREE else "arcmin"
    return "°C" if quantity.si == ABSOLUTE else _UNITS.get(quantity.si, example)


def _number(value: float, most: int) -> str:
    """Return a number with as many significant digits as it needs, at most so many; never as a
    power of ten.
    """
    if not math.isfinite(value):
        return str(value)
    digits = next(
        (
            count
            for count in range(1, most)
            if abs(float(f"{value:.{count}g}") - value) <= _EQUAL * abs(value)
        ),
        most,
    )
    rounded = float(f"{value:.{digits}g}")
    places = max(digits - 1 - math.floor(math.log10(abs(rounded))), 0) if rounded else 0
    text = f"{rounded:.{places}f}"
    return text if "." not in text else text.rstrip("0").rstrip(".")
