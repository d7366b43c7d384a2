"""Fields that count: teeth, planets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Final

from lostmotion.units import Quantity

if TYPE_CHECKING:
    from pydantic import GetJsonSchemaHandler, ValidationInfo
    from pydantic_core import CoreSchema


@dataclass(frozen=True)
class Whole(Quantity):
    """Marks a field that counts something: a whole number from `low` to `high`."""

    @property
    def expected(self) -> str:
        """Return the description of the values that this field takes."""
        return f"a whole number from {self.low:g} to {self.high:g}"

    def __call__(self, value: Any, info: ValidationInfo | None = None) -> int:  # noqa: ANN401 - whatever a file holds
        """Convert an input value to a count; raises pydantic's error with `expected` and `example`
        in its context.
        """
        number = super().__call__(value, info)
        if not isinstance(number, float) or not number.is_integer():
            raise self.refusal("not a whole number")
        return int(number)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Describe the field for editors."""
        return {
            "type": ["string", "integer"],
            "description": self.expected,
            "examples": [int(self.example)],
        }


def teeth(example: str) -> Whole:
    """Mark a field that holds a number of teeth."""
    return Whole("", example, low=1, high=10_000)


MOST_PLANETS: Final = 64
Planets = Annotated[int, Whole("", "3", low=1, high=MOST_PLANETS)]
