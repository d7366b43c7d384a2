"""A value of which only the limits are known."""

from __future__ import annotations

import math
from typing import Literal, Self, TypeAlias

from lostmotion.unit_registry import UnitError

# Distribution of a value that is unknown between two limits: every value, or every factor, is
# equally probable.
BandLaw: TypeAlias = Literal["uniform", "log-uniform"]


class Band(float):
    """A value that is unknown between two limits, as "1.3 .. 3.0 GPa" states it. As a number it is
    the middle of the range.

    low, high  the limits, in SI
    law        "uniform", with the arithmetic mean as the middle, or "log-uniform", with the
               geometric mean

    Ignorance, not scatter: the value is the same for all gearboxes or robots of a study, whereas ±
    differs from one to the next. A field that takes ranges (`Quantity.band`) sets the law.
    """

    __slots__ = ("high", "law", "low")
    low: float
    high: float
    law: BandLaw

    def __new__(cls, low: float, high: float, law: BandLaw = "uniform") -> Self:
        """Build the range. Raises UnitError for limits that do not rise, are not finite, or, of a
        log-uniform one, not above zero.
        """
        low, high = float(low), float(high)
        if not (math.isfinite(low) and math.isfinite(high)):
            raise UnitError("not a finite number")
        if not low < high:
            raise UnitError("a range a .. b whose ends do not rise")
        if law == "log-uniform" and low <= 0:
            raise UnitError("out of range")
        out = super().__new__(
            cls, math.sqrt(low) * math.sqrt(high) if law == "log-uniform" else low / 2 + high / 2
        )
        out.low, out.high, out.law = low, high, law
        return out

    def at(self, share: float) -> float:
        """Return the value below which this share (0 to 1) of the distribution lies."""
        if self.law == "log-uniform":
            return self.low * math.exp(share * math.log(self.high / self.low))
        return self.low + share * (self.high - self.low)

    def __repr__(self) -> str:
        """Return the range; two bands with one middle differ here, though they are equal as
        numbers.
        """
        return f"Band({self.low!r}, {self.high!r}, {self.law!r})"

    def __reduce__(self) -> tuple[type[Self], tuple[float, float, BandLaw]]:
        """Return how to rebuild a copy."""
        return type(self), (self.low, self.high, self.law)


def limits_of(value: float) -> tuple[float, float]:
    """Return the limits of a range, or a known value twice."""
    return (value.low, value.high) if isinstance(value, Band) else (value, value)
