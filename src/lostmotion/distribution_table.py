"""Distributions stated by name or as a table of cumulative probability."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from lostmotion.unit_registry import (
    UnitError,
)

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic_core import CoreSchema

# (value, probability that a draw lies below it), both rising; values are shares of the stated
# amount.
TableRows: TypeAlias = tuple[tuple[float, float], ...]
ToleranceLaw: TypeAlias = Literal["normal", "uniform", "normal without limits"] | TableRows
# Of a table of a distribution; and the values in it are shares of the stated amount, so that larger
# ones are a slip of the unit.
_MOST_ROWS: Final = 1000
_LARGEST_SHARE: Final = 1e6
# Of the whole width, and of one: what rounding could take away.
_LEAST_STEP: Final = 1e-9


def table_rows(value: object) -> TableRows:
    """Return a distribution's table as rows (value, cumulative probability), checked.

    Both columns rise from row to row, the probability from 0 to 1: the distribution is uniform
    between neighbouring values.
    Raises UnitError that says what is wrong.
    """
    if not isinstance(value, list | tuple) or not 2 <= len(value) <= _MOST_ROWS:  # noqa: PLR2004 - a lower and an upper end
        raise UnitError("not a table of 2 to 1000 rows")
    rows = []
    for row in value:
        numbers = row if isinstance(row, list | tuple) else ()
        if len(numbers) != 2 or any(  # noqa: PLR2004
            isinstance(x, bool) or not isinstance(x, int | float) or not abs(x) <= _LARGEST_SHARE
            for x in numbers
        ):
            raise UnitError("a row that is not [value, probability], two finite numbers")
        rows.append((float(numbers[0]), float(numbers[1])))
    least = _LEAST_STEP * (rows[-1][0] - rows[0][0])
    if any(
        not later[0] - sooner[0] > max(least, 0.0) or not later[1] - sooner[1] > _LEAST_STEP
        for sooner, later in itertools.pairwise(rows)
    ):
        raise UnitError("a table whose values or probabilities do not rise from row to row")
    if rows[0][1] != 0 or rows[-1][1] != 1:
        raise UnitError(
            f"a table whose probabilities go from {rows[0][1]:g} to {rows[-1][1]:g}, not from "
            "0 to 1"
        )
    if rows[-1][0] - rows[0][0] < 1e-6 * max(-rows[0][0], rows[-1][0]):
        raise UnitError("a table whose values hardly differ")
    return tuple(rows)


@dataclass(frozen=True)
class Distribution:
    """Marks a field of a part that names a distribution: one of `words`, or a table
    (`table_rows`).
    """

    words: tuple[str, ...]

    @property
    def expected(self) -> str:
        """Return the description of the values that this field takes."""
        return (
            "one of "
            + ", ".join(f'"{word}"' for word in self.words)
            + ", or rows [value in units of the amount, probability of a smaller one]"
        )

    @property
    def example(self) -> str:
        """Return an example that passes."""
        return self.words[0]

    def __call__(self, value: Any) -> str | TableRows:  # noqa: ANN401 - whatever a file holds
        """Return the word or the checked table; raises pydantic's error with `expected` and
        `example` in its context.
        """
        from pydantic_core import PydanticCustomError

        if isinstance(value, str) and value in self.words:
            return value
        try:
            return table_rows(value)
        except UnitError as error:
            why = "not a known distribution" if isinstance(value, str) else str(error)
            context = {"why": why, "expected": self.expected, "example": f'"{self.example}"'}
            raise PydanticCustomError(
                "distribution", "{why}; expected {expected}", context
            ) from None

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Let pydantic validate this field by calling the marker."""
        from pydantic_core import core_schema

        return core_schema.no_info_plain_validator_function(self)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Describe the field for editors."""
        return {"anyOf": [{"enum": list(self.words)}, TABLE_SCHEMA], "description": self.expected}


TABLE_SCHEMA: Final = {"type": "array", "items": {"type": "array", "items": {"type": "number"}}}
