"""Tolerances of a frame on the body that carries it: of a joint's axis in the link before it, and
of the far end of a link.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final

import numpy as np
from pydantic import ValidatorFunctionWrapHandler, WrapValidator
from pydantic_core import PydanticCustomError

from lostmotion.laws.distributions import Normal, of_tolerance
from lostmotion.parts.error_source import Angle, AngleAmount, ErrorSource, LengthAmount, Part
from lostmotion.parts.forms import Constant
from lostmotion.parts.provenance import OfClass
from lostmotion.parts.standard_terms import limit_terms, parameter
from lostmotion.spatial import across, pose_of
from lostmotion.units import Quantity, Toleranced, states_zero_tolerance

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion, Term
    from lostmotion.spatial import Floats


def _deviation(value: object, quantity: ValidatorFunctionWrapHandler) -> Toleranced:
    """Return how far a direction may deviate from zero: "20 µm" and "0 µm ± 20 µm (uniform)"."""
    found: Toleranced = quantity(value)
    if found.nominal < 0 or (found.tolerance and found.nominal):
        context = {
            "why": "a deviation below zero, or not around zero",
            "expected": "a limit, or 0 ± a limit",
            "example": '"0 µm ± 20 µm (uniform)"',
        }
        raise PydanticCustomError("limits", "{why}", context)
    return found if found.tolerance else replace(found, nominal=0.0, tolerance=found.nominal)


AngleDeviation = Annotated[
    Toleranced,
    Quantity("rad", "0.5 arcmin", toleranced=True, any_law=True),
    WrapValidator(_deviation),
]
LengthDeviation = Annotated[
    Toleranced, Quantity("m", "20 µm", toleranced=True, any_law=True), WrapValidator(_deviation)
]
Tilts = tuple[AngleDeviation, AngleDeviation, AngleDeviation]
Offsets = tuple[LengthDeviation, LengthDeviation, LengthDeviation]
_NONE: Final = (Toleranced(0.0), Toleranced(0.0), Toleranced(0.0))


class Mounting(OfClass, ErrorSource):
    """Tolerances of the joint's axis in the previous link, independent of each other.

    tilt    ± about the two directions across the axis, one value for both; or three values, about
            x, y and z of the seat
    offset  ± along the two directions across the axis, one value for both; or three values, along
            x, y and z of the seat
    axes    roll, pitch and yaw of the directions x, y and z in the seat, where they are not its own
    """

    shareable: ClassVar[bool] = False
    tilt: AngleAmount | Tilts = 0.0
    offset: LengthAmount | Offsets = 0.0
    axes: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)

    def terms(self, motion: Motion) -> list[Term]:
        """Return the errors of the axis in the seat's frame, which does not turn with the joint."""
        axes, law = pose_of(rpy=self.axes)[:3, :3], Normal()
        if isinstance(self.tilt, tuple):
            out = tilt_terms("axis tilt", self.tilt, axes)
        else:
            sized = parameter("axis tilt", self.tilt, "rad")
            turns = (
                [
                    Constant(np.concatenate([direction, np.zeros(3)]))
                    for direction in across(motion.axis)
                ]
                if self.tilt
                else []
            )
            out = [
                term
                for k, turn in enumerate(turns, 1)
                for term in limit_terms(
                    f"axis tilt {k}", turn, self.tilt, law, sized, cause="axis tilt"
                )
            ]
        if isinstance(self.offset, tuple):
            return out + offset_terms("axis offset", self.offset, axes)
        sized = parameter("axis offset", self.offset, "m")
        shifts = (
            [
                Constant(np.concatenate([np.zeros(3), direction]))
                for direction in across(motion.axis)
            ]
            if self.offset
            else []
        )
        for k, shift in enumerate(shifts, 1):
            out += limit_terms(
                f"axis offset {k}", shift, self.offset, law, sized, cause="axis offset"
            )
        return out


class TipTolerance(Part):
    """Tolerances of the far end of a link, independent of each other: ± about and along x, y and z
    of the tip.
    """

    tilt: Tilts = _NONE
    offset: Offsets = _NONE

    def terms(self) -> list[Term]:
        """Return the errors of the tip in its own frame."""
        return [
            *tilt_terms("tip tilt", self.tilt, np.eye(3)),
            *offset_terms("tip offset", self.offset, np.eye(3)),
        ]


def tilt_terms(name: str, stated: Tilts, axes: Floats) -> list[Term]:
    """Return the terms of independent tilts about the three columns of `axes` (3, 3)."""
    return _terms(name, stated, np.vstack([axes, np.zeros((3, 3))]))


def offset_terms(name: str, stated: Offsets, axes: Floats) -> list[Term]:
    """Return the terms of independent offsets along the three columns of `axes` (3, 3)."""
    return _terms(name, stated, np.vstack([np.zeros((3, 3)), axes]))


def _terms(name: str, stated: tuple[Toleranced, ...], twists: Floats) -> list[Term]:
    out: list[Term] = []
    for letter, value, twist in zip("xyz", stated, twists.T, strict=True):
        if value.tolerance:
            out += limit_terms(
                f"{name} {letter}",
                Constant(twist),
                value.tolerance,
                of_tolerance(value.law),
                parameter(name, None, ""),
                cause=name,
            )
    return out


def with_zero_tolerance(stated: Any) -> Any:  # noqa: ANN401 - whatever a file holds
    """Return the keys of a link with "400 mm ± 0 mm" as a stated length_tolerance of zero, which
    the length alone does not remember.
    """
    if not isinstance(stated, dict) or not states_zero_tolerance(stated.get("length"), "m"):
        return stated
    return {"length_tolerance": "0 mm", **stated}
