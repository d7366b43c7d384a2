"""Reducers by their makers' names, with the ratio appended where it is stated: RV-40E, RV-40E-121,
CSG-25-100.
"""

from __future__ import annotations

import functools
import itertools
import re
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, NoReturn, Self, TypeAlias, TypeVar

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lostmotion.catalogue import data_file
from lostmotion.errors import InputError, Problem, nearest, shown
from lostmotion.parts.error_source import (
    AngleAmount,
    AngularStiffness,
    FrictionTorque,
    Inertia,
    Line,
    Part,
    PlayDim,
    TorqueAmount,
)
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox
from lostmotion.parts.provenance import LONGEST_SOURCE, NO_VALUES
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

Rows: TypeAlias = "Mapping[str, Sequence[GearboxRow]]"
Values = Literal["limit", "typical"]
Value = TypeVar("Value")
Ratio = Annotated[float, Quantity("", "100", above=0)]

_NONE: Final[Rows] = {}
# Number of a user's rows that are searched for the nearest name.
_NEAR_OWN: Final = 100
# Text after the name in the note on a row that is used.
FROM_CATALOGUE: Final = " is taken from the catalogue"
_MOST_MAKERS: Final = 4

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
_RATIO: Final = re.compile(r"[0-9]{1,6}(?:\.[0-9]{1,6})?")
_BY_RATIO: Final = {
    "inertia_by_ratio": (
        "each with a moment of inertia at the input",
        'inertia_by_ratio = { "57" = "3.25e-5 kg m^2", "121" = "1.37e-5 kg m^2" }',
    ),
    "torques_by_ratio": (
        "each with rated, repeated and momentary peak torque",
        'torques_by_ratio = { "80" = ["63 N m", "137 N m", "255 N m"] }',
    ),
}
_TYPICAL: Final = 'typical = { hysteresis = "0.2 arcmin", source = "measured on 5 pieces, 2024" }'
# Confidence in a source, as the data file marks it: [R] verified against the source, [M 95] not
# verified, 95 % confidence.
_MARK: Final = re.compile(r"\s*\[(?P<mark>R|M (?P<confidence>\d\d))\]")
_CODE: Final = re.compile(r"(?P<model>.+?)(?:-(?P<ratio>[0-9]{1,6}(?:\.[0-9]{1,6})?))?")


class Typical(Part):
    """Typical values of delivered gearboxes where the maker prints only an upper limit; `source`
    states who measured or prints them.
    """

    backlash: PlayDim | None = None
    lost_motion: AngleAmount | None = None
    hysteresis: AngleAmount | None = None
    transmission_error: AngleAmount | None = None
    source: Annotated[Line, Field(min_length=1, max_length=200)]


class _Printed(Part):
    """The fields of a row besides the gearbox itself."""

    models: Annotated[
        list[Annotated[Line, Field(min_length=1, max_length=40)]],
        Field(min_length=1, max_length=20),
    ]
    maker: Annotated[Line, Field(min_length=1, max_length=80)]
    ratio: Ratio | None = None
    ratio_one_of: Annotated[tuple[Ratio, ...], Field(max_length=50)] = ()
    ratio_above: Ratio | None = None
    upper_limits: Annotated[tuple[Line, ...], Field(max_length=20)] = ()
    lost_motion: AngleAmount | None = None
    moment_rigidity: AngularStiffness | None = None
    acceleration_torque: TorqueAmount | None = None
    emergency_torque: TorqueAmount | None = None
    inertia_by_ratio: Annotated[dict[Line, Inertia], Field(max_length=50)] = Field(default={})
    torques_by_ratio: Annotated[
        dict[Line, tuple[TorqueAmount, TorqueAmount, TorqueAmount]], Field(max_length=50)
    ] = Field(default={})
    printed: Annotated[Line, Field(max_length=300)] = ""
    source: Annotated[Line, Field(min_length=1, max_length=200)]
    mass_source: Annotated[Line, Field(max_length=200)] = ""
    inertia_source: Annotated[Line, Field(max_length=200)] = ""
    torque_source: Annotated[Line, Field(max_length=200)] = ""

    @model_validator(mode="after")
    def _is_of_one_class(self) -> Self:
        stated = [name for name in ("ratio", "ratio_one_of", "ratio_above") if getattr(self, name)]
        if len(stated) > 1:
            context = {
                "why": _and(stated),
                "expected": "one of them, or none for every ratio",
                "example": "ratio_above = 50",
            }
            raise PydanticCustomError("gearbox", "{why}", context)
        for key, (value, example) in _BY_RATIO.items():
            strange = [ratio for ratio in getattr(self, key) if not _RATIO.fullmatch(ratio)]
            if strange:
                context = {
                    "why": f"{shown(strange[0])} in {key}",
                    "expected": f"ratios as keys, {value}",
                    "example": example,
                }
                raise PydanticCustomError("gearbox", "{why}", context)
        return self


class CheckedRow(_Printed):
    """A row with its gearbox validated key by key, as required of rows from a user's file."""

    part: CatalogueGearbox[AngleAmount, PlayDim, AngularStiffness, TorqueAmount, FrictionTorque]
    typical: Typical | None = None

    @model_validator(mode="after")
    def _typical_values_are_of_limits(self) -> Self:
        for name in (self.typical.model_fields_set if self.typical is not None else set()) - {
            "source"
        }:
            limit, typical = getattr(self.part, name), getattr(self.typical, name)
            if name not in self.upper_limits:
                context = {
                    "why": f"{name} in typical",
                    "expected": "errors named in upper_limits",
                    "example": f'upper_limits = ["{name}"]',
                }
                raise PydanticCustomError("gearbox", "{why}", context)
            if isinstance(limit, list) or _size(typical) > _size(limit):
                context = {
                    "why": f"a typical {name} above the maker's limit",
                    "expected": "at most the limit",
                    "example": _TYPICAL,
                }
                raise PydanticCustomError("gearbox", "{why}", context)
        return self

    @model_validator(mode="after")
    def _limits_are_its_own(self) -> Self:
        strange = [name for name in self.upper_limits if name not in self.part.model_fields_set]
        if strange:
            stated = sorted(self.part.model_fields_set - NO_VALUES)
            near = nearest(strange[0], stated) or next(iter(stated), "hysteresis")
            context = {
                "why": f"{shown(strange[0])} in upper_limits",
                "expected": "keys that part states",
                "example": f'upper_limits = ["{near}"]',
            }
            raise PydanticCustomError("gearbox", "{why}", context)
        return self


class GearboxRow(_Printed):
    """One row of the catalogue: a maker's figures for one size, with their source.

    models           names of the row
    ratio            the row applies to this ratio only; ratio_one_of: to each of these;
                     ratio_above: to all above; without any: to every ratio part             the
                     fields of a revolute joint's gearbox, as text with units
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
            [f"{_and(limits)} {'is' if len(limits) == 1 else 'are'} the maker's upper limit"]
            if limits
            else []
        )
        if typical and values == "typical":
            words.append(f"{_and(typical)} typical ({source_in_words(self.typical['source'])})")
        elif typical:
            words.append(f'for {_and(typical)} values = "typical" is known')
        words += [f"{_and(silent)} not specified, taken as none"] if silent else []
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


@functools.cache
def gearboxes() -> tuple[GearboxRow, ...]:
    """Return the known reducers in the order of the data file: by maker, series, size and ratio."""
    return tuple(
        GearboxRow.model_validate(row, context={"text": True})
        for row in data_file("gearboxes.toml")["reducers"]
    )


@functools.cache
def _packaged_by_model() -> dict[str, list[GearboxRow]]:
    return by_model(gearboxes())


def by_model(rows: Iterable[GearboxRow]) -> dict[str, list[GearboxRow]]:
    """Return the rows by name."""
    out: dict[str, list[GearboxRow]] = {}
    for row in rows:
        for model in row.models:
            out.setdefault(model, []).append(row)
    return out


def gearbox_models() -> tuple[str, ...]:
    """Return the names of the known reducers, without ratios."""
    return tuple(_packaged_by_model())


def find_gearbox(
    name: str, ratio: float | None = None, own: Rows = _NONE
) -> tuple[GearboxRow, float | None]:
    """Return the row of this name and the stated ratio: in the name ("CSG-25-100"), as an argument,
    or None.

    `own` are a user's rows by model, with priority over those of the package. Raises InputError
    with one problem for an unknown name (with the nearest known one), a name that needs a ratio and
    has none, two different ratios, and a ratio to which no row applies.
    """
    rows, model, behind = find_rows(name, own)
    if behind is not None and ratio is not None and behind != ratio:
        _refuse(
            f"{shown(name)} with the ratio {ratio:g}",
            "one ratio, in the name or beside it",
            f"{model}-{ratio:g}",
        )
    ratio = behind if ratio is None else ratio
    fitting = [row for row in rows if ratio is not None and row.applies_to(ratio)]
    choices = _or([row.ratios for row in rows])
    if ratio is None:
        if len(rows) > 1:
            _refuse(
                f"{shown(name)} without its ratio",
                f"its ratio appended, because the stiffness depends on it: {choices}",
                f"{model}-{_typical(rows)}",
            )
        fitting = list(rows)
    if not fitting:
        _refuse(
            f"{shown(model)} with the ratio {ratio:g}",
            f"a ratio with known figures of the maker: {choices}",
            f"{model}-{_typical(rows)}",
        )
    return fitting[0], ratio


def find_rows(name: str, own: Rows = _NONE) -> tuple[Sequence[GearboxRow], str, float | None]:
    """Return the rows of this name, the model, and the ratio appended to the name or None. Raises
    InputError for an unknown name.
    """
    model, behind = name, None
    rows = own.get(model) or _packaged_by_model().get(model)
    if not rows:
        match = _CODE.fullmatch(name)
        if match is not None and match["ratio"]:
            model, behind = match["model"], float(match["ratio"])
            rows = own.get(model) or _packaged_by_model().get(model)
    if not rows:
        names = [*itertools.islice(own, _NEAR_OWN), *gearbox_models()]
        near = nearest(name, [*names, *(f"{each}-{behind:g}" for each in names if behind)])
        first = {
            row.maker: row.models[0]
            for row in reversed(
                [*(rows[0] for rows in itertools.islice(own.values(), _NEAR_OWN)), *gearboxes()]
            )
        }
        makers = ", ".join(
            f"{each} … by {maker}" for maker, each in list(reversed(first.items()))[:_MOST_MAKERS]
        )
        _refuse(
            shown(name),
            f"a reducer of the catalogue ({makers}), with or without its ratio",
            near or "RV-40E-121",
            near,
        )
    return rows, model, behind


def _size(amount: Any) -> float:  # noqa: ANN401 - an amount with or without its tolerance
    return float(getattr(amount, "nominal", amount) or 0.0)


def _at_ratio(by_ratio: Mapping[str, Value], stated: Any) -> Value | None:  # noqa: ANN401 - whatever a file holds
    """Return the value at the ratio that a file states, as a number or as text; None where the
    table has none at that ratio.
    """
    try:
        ratio = float(stated)
    except (TypeError, ValueError, OverflowError):
        return None
    return next((value for each, value in by_ratio.items() if float(each) == ratio), None)


def _typical(rows: Sequence[GearboxRow]) -> str:
    return "100" if any(row.applies_to(100) for row in rows) else f"{rows[0].typical_ratio:g}"


def _refuse(found: str, expected: str, example: str, near: str = "") -> NoReturn:
    raise InputError([Problem("the catalogue", "gearboxes", found, expected, example, near)])


def _and(names: list[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _or(names: list[str]) -> str:
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
