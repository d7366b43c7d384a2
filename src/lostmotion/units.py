"""Text with units in, SI numbers out: "0.5 arcmin" -> 1.454e-4, "400 mm ± 50 µm" -> 0.4 within
5e-5.

Angle is a dimension here, so "50 N m" is refused where a stiffness in N m/rad belongs. Unit text
lives at
the edges only; everything inside the package is a float in SI (m, rad, kg, N, s).
"""

from __future__ import annotations

import math
import re
import sys
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, cast

from lostmotion.band import Band, BandLaw, limits_of
from lostmotion.distribution_table import TABLE_SCHEMA, ToleranceLaw, table_rows
from lostmotion.unit_registry import (
    ABSOLUTE,
    ZERO_CELSIUS,
    UnitError,
    factor,
    unit_in_words,
    zero_point,
)

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
    from pydantic_core import CoreSchema

# Taken whole or not at all (?>): else "51/m" could be read as 5 with the unit 1/m.
# The point of a number is not the first of the two in a range "1..3".
_NUMBER: Final = r"(?>[+-]?(?:[0-9]+(?:\.(?!\.)[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
# Words with a one-digit power at most, so that no text from a file can make the unit parser compute
# a giant.
_WORD: Final = r"(?:[A-Za-zµμ°]{1,12}|[%'″′\"])(?:(?:\^|\*\*)-?[0-9])?"
_UNIT: Final = rf"(?:1\s*/\s*)?{_WORD}(?:[ */·]{{1,3}}{_WORD}){{0,5}}|"
_TEXT: Final = re.compile(
    rf"^\s*(?P<value>{_NUMBER})\s*(?P<unit>{_UNIT})"
    rf"(?:\s*\.\.\s*(?P<end>{_NUMBER})\s*(?P<end_unit>{_UNIT}))?"
    rf"(?:\s*(?:±|\+/-|\+-)\s*(?P<tolerance>{_NUMBER})\s*(?P<tolerance_unit>{_UNIT}))?"
    r"\s*(?:\((?P<law>normal without limits|normal|uniform)\))?\s*$",
)
_LONGEST_TEXT: Final = 120
# In SI; no part of an arm is larger or smaller, heavier or stiffer, and powers of it still fit a
# float.
LARGEST: Final = 1e15
_SMALLEST: Final = 1e-20


_LIMITED: Final = ("normal", "uniform")


def read_quantity(text: str, si: str) -> Toleranced:
    """Return the SI value and the tolerance that a text states.

    `si` is the SI unit wanted ("rad", "N m/rad", "" for a plain number). A temperature above
    absolute zero (`unit_registry.ABSOLUTE`) is read on its scale, "35 °C", and its tolerance is a
    difference, "± 5 K". A tolerance without a unit takes the value's own
    ("400 ± 0.05 mm" is refused, "400 mm ± 0.05" is not); one in per cent is a share of the value
    ("20 N m/arcmin ± 10 %"). The ends of a range, "1.3 .. 3.0 GPa", have a unit each, or share one.

    Raises UnitError for text that is no quantity, another dimension, an unknown unit, or a value
    that is not finite.
    """
    match = _TEXT.match(text) if len(text) <= _LONGEST_TEXT else None
    if match is None:
        raise UnitError("not a number with a unit")
    unit = match["unit"].strip()
    end_unit = (match["end_unit"] or "").strip()
    if match["end"] is not None:
        unit, end_unit = unit or end_unit, end_unit or unit
    value = float(match["value"]) * factor(unit, si) + zero_point(unit, si)
    if match["end"] is not None:
        value = Band(value, float(match["end"]) * factor(end_unit, si) + zero_point(end_unit, si))
    tolerance = 0.0
    if match["tolerance"] is not None:
        tolerance_unit = match["tolerance_unit"].strip() or unit
        amount = float(match["tolerance"])
        of_value = tolerance_unit == "%" and unit != "%" and si != ABSOLUTE
        tolerance = amount / 100 * abs(value) if of_value else amount * factor(tolerance_unit, si)
    if not (math.isfinite(value) and math.isfinite(tolerance)):
        raise UnitError("not a finite number")
    if tolerance < 0:
        raise UnitError("a tolerance after ± cannot be negative")
    return Toleranced(value, tolerance, cast("ToleranceLaw", match["law"] or "normal"))


def states_tolerance(value: object) -> bool:
    """Return whether a value that `Quantity` accepts states a tolerance, zero included: text with
    ±, or a Toleranced.
    """
    match = _TEXT.match(value) if isinstance(value, str) else None
    return isinstance(value, Toleranced) or (match is not None and match["tolerance"] is not None)


def states_zero_tolerance(value: object, si: str) -> bool:
    """Return whether a text, or the `value` of a table with a distribution, states a tolerance of
    zero: "400 mm ± 0 mm".
    """
    text = value.get("value") if isinstance(value, dict) else value
    if not isinstance(text, str) or not states_tolerance(text):
        return False
    try:
        return read_quantity(text, si).tolerance == 0
    except UnitError:
        return False  # the field reports what is wrong with it


@dataclass(frozen=True, slots=True)
class Toleranced:
    """A nominal value and how far a made part may stand off it: "400 mm ± 50 µm" is Toleranced(0.4,
    5e-5).

    The nominal value may be a `Band`: "12 .. 12.2 mm ± 0.05 mm".

    The tolerance is the limit at which a part is scrapped. `law` is the distribution of parts:
    "normal" is a normal distribution whose three sigma reach the limit, cut there; "uniform";
    "normal without limits" has the limit as its three sigma and exceeds it in 0.27 % of parts; a
    table has rows (value as a share of the tolerance, probability that a part lies below it).
    """

    nominal: float
    tolerance: float = 0.0
    law: ToleranceLaw = "normal"


@dataclass(frozen=True)
class Quantity:
    """Marks a field of a part: which SI unit it holds, which values pass, and an example that does.

    From a file (validation context {"text": True}) a dimensioned quantity must carry its unit in
    the text. From Python
    a bare number is taken as SI. With `toleranced` the field holds a Toleranced, without it a
    float. With `any_law` its tolerance may have no limits, or a table: `{ value = "400 mm ± 50 µm",
    law = [[-1, 0], [0.2, 0.5], [1, 1]] }`; elsewhere limits must hold, because sizes, plays and
    fits are checked at them. With `band` the value may be unknown within a range (`Band`), with
    this distribution.
    """

    si: str
    example: str
    low: float = -math.inf
    above: float = -math.inf
    high: float = math.inf
    toleranced: bool = False
    any_law: bool = False
    band: BandLaw | None = None

    @property
    def expected(self) -> str:
        """Return the description of the values that this field takes."""
        words = unit_in_words(self.si) + (" or per cent" if self._is_share else "")
        if self.above == 0:
            words += ", above zero"
        elif self.low == 0:
            words += ", zero or more"
        elif math.isfinite(self.low):
            words += f", at least {self._limit_text(self.low)}"
        elif math.isfinite(self.above):
            words += f", above {self._limit_text(self.above)}"
        if math.isfinite(self.high):
            words += f", at most {self._limit_text(self.high)}"
        return (
            words
            + (", with or without ± tolerance" if self.toleranced else "")
            + (", or a range a .. b" if self.band else "")
        )

    @property
    def _is_share(self) -> bool:
        return not self.si and self.example.endswith("%")

    def _limit_text(self, end: float) -> str:
        """Return the end of the range as text: angles in degrees, shares also in per cent."""
        if self._is_share:
            return f"{end:g} ({100 * end:.6g} %)"
        if self.si == ABSOLUTE:
            return f"{end - ZERO_CELSIUS:g} °C"
        return f"{math.degrees(end):g} deg" if self.si == "rad" else f"{end:g} {self.si}".rstrip()

    def __call__(self, value: Any, info: ValidationInfo | None = None) -> float | Toleranced:  # noqa: ANN401 - whatever a file holds
        """Convert an input value to SI; raises pydantic's error with `expected` and `example` in
        its context.
        """
        try:
            found = self._in_band(
                self._of_law(
                    self._read(
                        value, from_file=bool(info and info.context and info.context.get("text"))
                    )
                )
            )
            self._check(found)
        except UnitError as error:
            raise self.refusal(str(error)) from None
        if self.toleranced:
            return found
        if found.tolerance:
            raise self.refusal("a tolerance is not used here")
        return found.nominal

    def refusal(self, why: str) -> Exception:
        """Build the error that carries what this field expects."""
        from pydantic_core import PydanticCustomError

        context = {"why": why, "expected": self.expected, "example": f'"{self.example}"'}
        return PydanticCustomError("quantity", "{why}; expected {expected}", context)

    def _read(self, value: object, *, from_file: bool) -> Toleranced:
        if self.any_law and isinstance(value, dict):
            if set(value) != {"value", "law"} or not isinstance(value["value"], str):
                raise UnitError("a table without exactly the keys value, a text, and law")
            return replace(read_quantity(value["value"], self.si), law=value["law"])
        if isinstance(value, str):
            return read_quantity(value, self.si)
        if isinstance(value, Toleranced):
            return value
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise UnitError("not a quantity")
        if not abs(value) <= sys.float_info.max:  # nor a whole number beyond every float
            raise UnitError("not a finite number")
        if from_file and self.si:
            raise UnitError("a number without a unit")
        return Toleranced(value if isinstance(value, Band) else float(value))

    def _in_band(self, toleranced: Toleranced) -> Toleranced:
        """Return the quantity with its range, where one is stated, distributed as in this field."""
        if not isinstance(toleranced.nominal, Band):
            return toleranced
        if self.band is None:
            raise UnitError("a range a .. b is not used here: state one value")
        return replace(
            toleranced, nominal=Band(toleranced.nominal.low, toleranced.nominal.high, self.band)
        )

    def _check(self, toleranced: Toleranced) -> None:
        value, largest = limits_of(toleranced.nominal)
        if not (
            math.isfinite(value) and math.isfinite(largest) and math.isfinite(toleranced.tolerance)
        ):
            raise UnitError("not a finite number")
        if toleranced.tolerance < 0:
            raise UnitError("a tolerance after ± cannot be negative")
        if value < self.low or value <= self.above or largest > self.high:
            raise UnitError("out of range")
        if max(abs(value), abs(largest), toleranced.tolerance) > LARGEST:
            raise UnitError("too large to be real")
        if self.above == 0 and value < _SMALLEST:
            raise UnitError("too small to be real")
        floor = max(self.low, self.above)
        if math.isfinite(floor) and value - toleranced.tolerance < floor:
            raise UnitError("the tolerance reaches out of range")

    def _of_law(self, toleranced: Toleranced) -> Toleranced:
        """Return the quantity with its distribution checked; only limits that hold are taken where
        the field needs them.
        """
        if isinstance(toleranced.law, str) and toleranced.law in _LIMITED:
            return toleranced
        if not self.any_law:
            raise UnitError(
                "a distribution other than normal or uniform, and here limits must hold"
            )
        if not toleranced.tolerance:
            raise UnitError("a distribution without a ± tolerance")
        if isinstance(toleranced.law, str):
            if toleranced.law != "normal without limits":
                raise UnitError(f"'{toleranced.law}' is not a known distribution")
            return toleranced
        return replace(toleranced, law=table_rows(toleranced.law))

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Let pydantic validate this field by calling the marker."""
        from pydantic_core import core_schema

        return core_schema.with_info_plain_validator_function(self)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Describe the field for editors: text with a unit, or a plain number where there is no
        unit.
        """
        described: dict[str, Any] = {
            "type": "string",
            "description": self.expected,
            "examples": [self.example],
        }
        if not self.si:
            described["type"] = ["string", "number"]
        if not self.any_law:
            return described
        law = {"anyOf": [{"enum": [*_LIMITED, "normal without limits"]}, TABLE_SCHEMA]}
        with_law = {
            "type": "object",
            "properties": {"value": described, "law": law},
            "required": ["value", "law"],
            "additionalProperties": False,
        }
        return {"anyOf": [described, with_law], "description": self.expected}
