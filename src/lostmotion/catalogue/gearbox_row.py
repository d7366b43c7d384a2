"""One row of a catalogue of reducers: the printed values of one model, with their source."""

from __future__ import annotations

import functools
import re
from typing import TYPE_CHECKING, Any, Final, Literal, TypeVar

from pydantic import Field

from lostmotion.catalogue.printed_row import CheckedRow, Printed, Typical, listed
from lostmotion.parts.error_source import (
    AngleAmount,
    AngularStiffness,
    FrictionTorque,
    PlayDim,
    TorqueAmount,
)
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox
from lostmotion.parts.provenance import LONGEST_SOURCE, NO_VALUES

if TYPE_CHECKING:
    from collections.abc import Mapping

Values = Literal["limit", "typical"]
Value = TypeVar("Value")
# Text after the name in the note on a row that is used.
FROM_CATALOGUE: Final = " is taken from the catalogue"
# A stated field replaces the row's fields that express the same figure.
_ELASTIC: Final = {"stiffness", "zone_torques", "stiffness_scatter"}
REPLACES: Final = {
    "backlash": {"lost_motion", "lost_motion_torque"},
    "lost_motion": {"backlash"},
    "stiffness": {"zone_torques"},
    "rigid": _ELASTIC,
}
_SOUGHT: Final = (
    "lost_motion",
    "backlash",
    "hysteresis",
    "transmission_error",
    "stiffness_scatter",
)
# Confidence in a source, as the data file marks it: [R] verified against the source, [M 95] not
# verified, 95 % confidence.
_MARK: Final = re.compile(r"\s*\[(?P<mark>R|M (?P<confidence>\d\d))\]")


class GearboxRow(Printed):
    """One row of the catalogue: a maker's figures for one size, with their source.

    models           names of the row
    ratio            the row applies to this ratio only; ratio_one_of: to each of these;
                     ratio_above: to all above; without any: to every ratio
    part             the fields of a revolute joint's gearbox, as text with units
    upper_limits     fields for which the maker prints a limit and no value
    typical          typical values of delivered gearboxes for such fields, with their source; used
                     where a file states values = "typical" inertia_by_ratio moment of inertia at
                     the input where it depends on the ratio
    torques_by_ratio rated, repeated peak and momentary peak torque where they depend on the ratio;
    those of the row itself are the smallest of them lost_motion      as printed, where `part`
    states it by other fields
    moment_rigidity  of the main bearing against tilting; kept as data, as acceleration_torque and
                     emergency_torque
    printed          the maker's figures where `part` states them by other fields
    source           with its confidence: [R] verified against the source, [M 95] not verified, 95 %
                     confidence
    mass_source      of the mass in `part`, inertia_source of moments of inertia, torque_source of
                     torques, where they have another source
    """

    part: dict[str, Any]
    typical: dict[str, Any] = Field(default={})

    @functools.cached_property
    def figures(self) -> CheckedRow:
        """Return the row with its gearbox in SI."""
        fields = {
            name: getattr(self, name)
            for name in type(self).model_fields
            if name not in {"part", "typical"}
        }
        typical = (
            Typical.model_validate(self.typical, context={"text": True}) if self.typical else None
        )
        gearbox = CatalogueGearbox[
            AngleAmount, PlayDim, AngularStiffness, TorqueAmount, FrictionTorque
        ].model_validate(self.with_stated({}), context={"text": True})
        return CheckedRow(**fields, part=gearbox, typical=typical)

    @property
    def unstated(self) -> list[str]:
        """Return the names of the errors that the row does not state; they count as zero."""
        stated = set(self.part) | (
            {"backlash"}
            if "lost_motion" in self.part
            else {"lost_motion"}
            if "backlash" in self.part
            else set()
        )
        return [name for name in _SOUGHT if name not in stated]

    @property
    def ratios(self) -> str:
        """Return the ratios of the row in words."""
        if self.ratio is not None or self.ratio_one_of:
            return ", ".join(f"{ratio:g}" for ratio in self.ratio_one_of or (self.ratio,))
        return "any ratio" if self.ratio_above is None else f"above {self.ratio_above:g}"

    @property
    def typical_ratio(self) -> float | None:
        """Return a ratio to which the row applies; None where it applies to every ratio."""
        if self.ratio_above is not None:
            return max(100.0, 2 * self.ratio_above)
        return next(iter(self.ratio_one_of), self.ratio)

    def applies_to(self, ratio: float) -> bool:
        """Return whether the row applies to a ratio."""
        if self.ratio_one_of and ratio not in self.ratio_one_of:
            return False
        return (self.ratio is None or ratio == self.ratio) and (
            self.ratio_above is None or ratio > self.ratio_above
        )

    @property
    def typical_fields(self) -> list[str]:
        """Return the fields with a typical value."""
        return [name for name in self.typical if name != "source"]

    def torques_at(self, ratio: object) -> tuple[float, float, float] | None:
        """Return rated, repeated peak and momentary peak torque (N m) at a ratio; None where the
        row does not state them by ratio.
        """
        return _at_ratio(self.torques_by_ratio, ratio)

    def with_stated(self, stated: dict[str, Any], values: Values = "limit") -> dict[str, Any]:
        """Return the fields of a gearbox with this row and with the fields stated by the user,
        which have priority.

        The row's upper limits and source are added. `values` selects the errors for which the maker
        prints only upper limits: the "limit" itself, or the "typical" value where the row has one,
        which is then marked as assumed. Values that were not verified are marked as assumed too.
        """
        replaced = {other for name in stated for other in REPLACES.get(name, ())}
        typical = (
            {name: self.typical[name] for name in self.typical_fields if name not in stated}
            if values == "typical"
            else {}
        )
        kept = {
            name: typical.get(name, value)
            for name, value in self.part.items()
            if name not in replaced
        }
        inertia = _at_ratio(self.inertia_by_ratio, stated.get("ratio"))
        if inertia is not None:
            kept["inertia"] = f"{inertia!r} kg m^2"
        torques = self.torques_at(stated.get("ratio"))
        if torques is not None and "rated_torque" not in stated:
            kept["rated_torque"] = f"{torques[0]!r} N m"
        limits = [
            name
            for name in self.upper_limits
            if name in kept and name not in stated and name not in typical
        ]
        own = stated.get("source")
        others = {
            "typical": self.typical["source"] if typical else "",
            "rated_torque": self.torque_source,
            "mass": self.mass_source,
        }
        others["inertia"] = self.inertia_source
        used = {"typical", *kept} - {*stated}
        besides = [
            f"{name.replace('_', ' ')}: {text}"
            for name, text in others.items()
            if text and name in used
        ]
        pieces = [source_in_words(piece) for piece in (self.source, *besides)]
        if isinstance(own, str) and own:
            pieces = [own, f"the rest: {pieces[0]}", *pieces[1:]]
        source = pieces[0]  # a stated source that is itself too long is refused by the model
        for piece in pieces[1:]:
            if len(joined := f"{source}; {piece}") <= LONGEST_SOURCE:
                source = joined
        # the stated source is joined with the row's own, unless it is not text: the model refuses
        # that
        origin: dict[str, Any] = (
            {"upper_limits": limits} if limits and "upper_limits" not in stated else {}
        )
        assumed = stated.get("assumed", [])
        doubted = [
            name
            for name in kept
            if name not in stated
            and name not in limits
            and name not in NO_VALUES
            and self._doubted(name, typical)
        ]
        if doubted and isinstance(assumed, list):
            origin["assumed"] = [*assumed, *doubted]
        return {
            "kind": "catalogue",
            **kept,
            **stated,
            **origin,
            **({"source": source} if own is None or isinstance(own, str) else {}),
        }

    def _doubted(self, name: str, typical: Mapping[str, Any]) -> bool:
        """Return whether a field's value is only assumed: a typical one, or one that was not
        verified.
        """
        own = {
            "mass": self.mass_source,
            "inertia": self.inertia_source,
            "rated_torque": self.torque_source,
        }.get(name)
        return name in typical or mark_of(own or self.source).startswith("M")

    def note(self, name: str, stated: dict[str, Any], values: Values = "limit") -> str:
        """Return a line on the fields of this row that the user did not state: limits, typical
        values, missing errors, source.
        """
        fields = self.with_stated(stated, values)
        limits = [field for field in fields.get("upper_limits", ()) if field not in stated]
        typical = [
            field for field in self.typical_fields if field in fields and field not in stated
        ]
        silent = [field for field in self.unstated if field not in stated]
        words = (
            [f"{listed(limits)} {'is' if len(limits) == 1 else 'are'} the maker's upper limit"]
            if limits
            else []
        )
        if typical and values == "typical":
            words.append(f"{listed(typical)} typical ({source_in_words(self.typical['source'])})")
        elif typical:
            words.append(f'for {listed(typical)} values = "typical" is known')
        words += [f"{listed(silent)} not specified, taken as none"] if silent else []
        return (
            name
            + FROM_CATALOGUE
            + "".join(f"; {each}" for each in words)
            + f". Source: {source_in_words(self.source)}"
        )


def source_in_words(source: str) -> str:
    """Return a source with its marks in words: verified against the source, or not verified, with
    the confidence.
    """
    return _MARK.sub(
        lambda mark: (
            f" (not verified, {mark['confidence']} % confidence)"
            if mark["confidence"]
            else " (verified)"
        ),
        source,
    )


def mark_of(source: str) -> str:
    """Return the mark of confidence of a source, "R" or such as "M 95"; empty without a mark."""
    match = _MARK.search(source)
    return match["mark"] if match else ""


def _at_ratio(by_ratio: Mapping[str, Value], stated: Any) -> Value | None:  # noqa: ANN401 - whatever a file holds
    """Return the value at the ratio that a file states, as a number or as text; None where the
    table has none at that ratio.
    """
    try:
        ratio = float(stated)
    except (TypeError, ValueError, OverflowError):
        return None
    return next((value for each, value in by_ratio.items() if float(each) == ratio), None)
