"""Families of sections of one kind: each size is fixed, free within a range, or a share of the
leading size.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self

from pydantic import Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from lostmotion.parts.error_source import Part
from lostmotion.parts.provenance import value_keys
from lostmotion.parts.section import Box, ISection, Rectangle, Rod, Sized, Tube
from lostmotion.unit_registry import UnitError
from lostmotion.units import Quantity, Toleranced, read_quantity

if TYPE_CHECKING:
    from pydantic import ValidationInfo

    from lostmotion.parts.profile import Section

_TO: Final = re.compile(r"\s*(?:\.\.\.?|…)\s*")
_LONGEST: Final = 80


@dataclass(frozen=True, slots=True)
class Span:
    """Range of a size, from low to high, equal for a fixed size; in m, or with `share` as a share
    of the family's leading size.
    """

    low: float
    high: float
    share: bool = False

    @property
    def free(self) -> bool:
        """Return whether the size is free."""
        return self.high > self.low


@dataclass(frozen=True)
class SizeRange(Quantity):
    """Marks a size of a family: a length, a percentage of the leading size, or a range of
    either.
    """

    @property
    def expected(self) -> str:
        """Return the description of the values that this field takes."""
        return (
            'a length above zero ("3 mm"), a range ("30 mm .. 200 mm"), or a share of the leading '
            'size ("5 %", "4 % .. 10 %")'
        )

    def __call__(self, value: Any, info: ValidationInfo | None = None) -> Span:  # type: ignore[override]  # noqa: ANN401, ARG002 - a range is no number
        """Convert an input value to a Span; raises pydantic's error with `expected` and `example`
        in its context.
        """
        if isinstance(value, Span):
            return value
        try:
            return self._span(value)
        except UnitError as error:
            raise self.refusal(str(error)) from None

    def _span(self, value: object) -> Span:
        if not isinstance(value, str) or len(value) > _LONGEST:
            raise UnitError("not a size")
        ends = _TO.split(value)
        if len(ends) > 2:  # noqa: PLR2004 - from and to
            raise UnitError("more than two ends")
        shares = [end.rstrip().endswith("%") for end in ends]
        if any(shares) and not all(shares):
            raise UnitError("a range from a length to a share")
        read = [
            read_quantity(end, "" if share else "m")
            for end, share in zip(ends, shares, strict=True)
        ]
        if any(end.tolerance for end in read):
            raise UnitError("a tolerance is not used here")
        for end in read:
            self._check(Toleranced(end.nominal))
        low, high = read[0].nominal, read[-1].nominal
        if low > high or (len(ends) > 1 and low == high):
            raise UnitError("a range that does not rise")
        if any(shares) and high > _LARGEST_SHARE:
            raise UnitError(f"a share above {_LARGEST_SHARE:.0%}")
        return Span(low, high, any(shares))


_LARGEST_SHARE: Final = 10.0
Size = Annotated[Span, SizeRange("m", "30 mm .. 200 mm", above=0, high=10.0)]
Wall = Annotated[Span, SizeRange("m", "3 mm", above=0, high=10.0)]


class _PartFamily(Part):
    """Base class of families: the sizes in order, the leading one first."""

    @model_validator(mode="after")
    def _leading_size_is_a_length(self) -> Self:
        if self.spans[0].share:
            name = next(iter(self.names))
            raise _refuse(
                f"{name} as a share: it is the leading size",
                f"{name} as a length or a range of lengths",
                f'{name} = "30 mm .. 200 mm"',
            )
        if (
            self.section(tuple(span.high for span in self.spans)) is None
            and self.section(tuple(span.low for span in self.spans)) is None
        ):
            raise _refuse(
                "sizes of which no section can exist",
                "walls that fit into the section",
                'outer = "30 mm .. 200 mm", wall = "3 mm"',
            )
        return self

    @property
    def names(self) -> list[str]:
        """Return the names of the sizes, the leading one first."""
        return value_keys(type(self))

    @property
    def spans(self) -> list[Span]:
        """Return the range of each size."""
        return [getattr(self, name) for name in self.names]

    @property
    def free(self) -> list[int]:
        """Return the positions of the sizes that are free."""
        return [k for k, span in enumerate(self.spans) if span.free]

    def section(self, values: tuple[float, ...]) -> Sized | None:
        """Return the section with these sizes; None where no such section can exist."""
        leading = values[0]
        sizes = {
            name: value * leading if span.share else value
            for name, value, span in zip(self.names, values, self.spans, strict=True)
        }
        kind: Any = _SECTIONS[self.kind]  # type: ignore[attr-defined]
        try:
            made: Sized = kind(**sizes)
        except ValidationError:
            return None
        return made


class TubeFamily(_PartFamily):
    """Round tubes; the outside diameter leads."""

    kind: Literal["tube"] = "tube"
    outer: Size
    wall: Wall


class RodFamily(_PartFamily):
    """Solid round bars."""

    kind: Literal["rod"] = "rod"
    diameter: Size


class RectangleFamily(_PartFamily):
    """Solid bars; the height, across the joint's axis, leads."""

    kind: Literal["rectangle"] = "rectangle"
    height: Size
    width: Size


class BoxFamily(_PartFamily):
    """Rectangular tubes; the height, across the joint's axis, leads."""

    kind: Literal["box"] = "box"
    height: Size
    width: Size
    wall: Wall


class IFamily(_PartFamily):
    """I-sections; the height leads."""

    kind: Literal["I"] = "I"
    height: Size
    width: Size
    web: Wall
    flange: Wall


Family = Annotated[
    TubeFamily | RodFamily | RectangleFamily | BoxFamily | IFamily, Field(discriminator="kind")
]
_SECTIONS: Final[dict[str, type[Part]]] = {
    "tube": Tube,
    "rod": Rod,
    "rectangle": Rectangle,
    "box": Box,
    "I": ISection,
}
_KINDS: Final[dict[str, type[_PartFamily]]] = {
    "tube": TubeFamily,
    "rod": RodFamily,
    "rectangle": RectangleFamily,
    "box": BoxFamily,
    "I": IFamily,
}
# Range of the leading size of the family around a stated section, as multiples of that size.
_SMALLEST: Final = 0.1
_LARGEST: Final = 5.0
# Sizes that keep their ratio to the leading one in the family around a stated section; the others,
# walls, stay constant.
_FOLLOW: Final = ("width",)
# Least side of a section in wall thicknesses: slightly above two.
_ROOM: Final = 2.02


def family_around(
    section: Section | None, smallest: float = _SMALLEST, largest: float = _LARGEST
) -> Family | None:
    """Return the family of a section: `smallest` to `largest` times its leading size, width in
    proportion, walls constant.

    None without a section, and for a section of fixed sizes.
    """
    kind = None if section is None else _KINDS.get(section.kind)
    if kind is None:
        return None
    leading, *others = value_keys(kind)
    size = float(getattr(section, leading))
    follow = {name: float(getattr(section, name)) / size for name in others if name in _FOLLOW}
    stay = {name: float(getattr(section, name)) for name in others if name not in _FOLLOW}
    least = max(
        smallest * size, _ROOM * max(stay.values(), default=0.0) / min([1.0, *follow.values()])
    )
    spans = {leading: Span(least, largest * max(size, least))}
    spans |= {name: Span(share, share, share=True) for name, share in follow.items()}
    spans |= {name: Span(value, value) for name, value in stay.items()}
    return kind(**spans)  # type: ignore[return-value]


def _refuse(why: str, expected: str, example: str) -> PydanticCustomError:
    return PydanticCustomError(
        "section", "{why}", {"why": why, "expected": expected, "example": example}
    )


def section_text(section: object) -> str:
    """Return a section as text: its sizes in mm where it has some ("tube 80 x 3 mm"), else its
    kind; "no section" for None.
    """
    if section is None:
        return "no section"
    if not isinstance(section, Tube | Rod | Rectangle | Box | ISection):
        return str(section.kind)  # type: ignore[attr-defined]
    sizes = " x ".join(f"{getattr(section, name) * 1e3:.6g}" for name in value_keys(type(section)))
    return f"{section.kind} {sizes} mm"


def rounded(value: float, step: float) -> float:
    """Return the nearest whole multiple of `step`, without binary rounding noise."""
    return round(round(value / step) * step, 12) if step and math.isfinite(value) else value
