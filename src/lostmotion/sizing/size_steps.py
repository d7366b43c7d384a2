"""The sizes that a free section may have: those of usual tubes, bars and profiles, whole steps of a
length, or any.

Usual sizes are those in which drawn tubes, bars and profiles are commonly sold in millimetres:
outside sizes as in the preferred dimensions of precision steel tubes, and walls as there (EN
10305-1); tubes of aluminium and bars have mostly the same. Larger ones go on in steps of 20 and 50
mm. What a dealer has is not checked: a list of `stock` is for that.
"""

from __future__ import annotations

import bisect
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from lostmotion.parts.family import rounded

if TYPE_CHECKING:
    from lostmotion.parts.family import Family
    from lostmotion.parts.section import Sized

# mm
# fmt: off
_OUTSIDE: Final = (
    4, 5, 6, 8, 10, 12, 14, 15, 16, 18, 20, 22, 25, 28, 30, 32, 35, 38, 40, 42, 45, 48, 50, 55, 60,
    65, 70, 75, 80, 85, 90, 95, 100, *range(110, 201, 10), *range(220, 501, 20),
    *range(550, 1001, 50),
)
_WALLS: Final = (
    0.5, 0.8, 1, 1.2, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20, 25,
    30, 40, 50,
)
# fmt: on
_NAMES_OF_WALLS: Final = frozenset({"wall", "web", "flange"})
_ROUNDING: Final = 1e-9
# Step of sizes that are shares of the leading size.
_SHARE: Final = 1e-3


@dataclass(frozen=True, slots=True)
class SizeSteps:
    """The step of free sizes, m; 0 for any size, None for usual sizes of tubes, bars and
    profiles.
    """

    step: float | None = None

    @property
    def exact(self) -> bool:
        """Return whether any size is allowed."""
        return self.step == 0

    def near(self, family: Family, k: int, value: float, count: int) -> list[float]:
        """Return the allowed values of the size number k within its range, `count` on each side of
        a value (m, or a share of the leading size).
        """
        span = family.spans[k]
        if span.share or self.step is not None:
            step = _SHARE if span.share else self.step or 0.0
            middle = rounded(value, step)
            some = (
                [rounded(middle + n * step, step) for n in range(-count, count + 1)]
                if step
                else [value]
            )
        else:
            ladder = _usual(family.names[k])
            at = bisect.bisect_left(ladder, value * (1 - _ROUNDING))
            some = [
                each
                for each in ladder[max(at - count, 0) : at + count + 1]
                if span.low <= each <= span.high
            ]
        return sorted({min(max(each, span.low), span.high) for each in some}) or [
            min(max(value, span.low), span.high)
        ]

    def nearest(self, family: Family, k: int, value: float) -> float:
        """Return the allowed value of the size number k nearest to a value."""
        return min(self.near(family, k, value, 1), key=lambda each: abs(each - value))

    def section(self, family: Family, values: tuple[float, ...]) -> Sized | None:
        """Return the section with these sizes, those that are shares of the leading size rounded as
        well; None where no such section can exist.
        """
        if self.step is None:
            values = tuple(
                min(_usual(name), key=lambda each: abs(each - share * values[0])) / values[0]
                if span.share
                else share
                for name, span, share in zip(family.names, family.spans, values, strict=True)
            )
        return family.section(values)


EXACT: Final = SizeSteps(0.0)


def _usual(name: str) -> list[float]:
    """Return the usual sizes (m) of an outside size or a wall, rising."""
    return [round(each * 1e-3, 9) for each in (_WALLS if name in _NAMES_OF_WALLS else _OUTSIDE)]
