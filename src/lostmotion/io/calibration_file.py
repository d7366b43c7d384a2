"""Estimates of the errors of one measured robot, from a TOML file.

covariance = [[0.01, 0.0], [0.0, 0.02]]  # of the estimates, in their order; in place of their
                                         # deviations
factor = [[0.1, 0.0], [0.0, 0.14]]       # or: the covariance of all estimates without a deviation
                                         # is factor times its transpose

[[estimates]]
draw = "joints.A.encoder.zero"           # what was estimated
mean = 0.7                               # in standard deviations of what the arm file states
deviation = 0.1                          # of the estimate, in the same unit; 0 where it is exact

[[estimates]]
draw = "joints.B.encoder.zero"           # of an error with one size: as a signed angle or length
mean = "-0.3 mrad"
deviation = "0.05 mrad"

[[estimates]]
draw = "joints.A.gearbox.transmission error 1"
phase = "sine"                           # a harmonic has two draws, "sine" and "cosine"
mean = -0.3
deviation = 0.14

[added]                                  # deviations, rad and m, assumed for errors that the arm's
turn = 0.0005                            # file does not state, as `lostmotion calibrate` adds them
orders = 32
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Final, Literal, cast

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import PydanticCustomError

from lostmotion.calibration.terms import Deviations, added_terms
from lostmotion.errors import InputError, Problem, shown
from lostmotion.io.draft import Draft
from lostmotion.io.limits import listed, nearest, refuse_all
from lostmotion.io.toml import read_toml
from lostmotion.io.toml_lines import names_lines
from lostmotion.io.validation_errors import problems
from lostmotion.mechanism.calibration import Calibration, known_streams, size_of
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from lostmotion.laws.distributions import Law
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.spatial import Floats

_MOST_ESTIMATES: Final = 500
_EXAMPLE: Final = 'draw = "joints.A.encoder.zero"'
_COVARIANCE: Final = "covariance = [[0.01]]"
# No robot is as many standard deviations from what its arm file states.
_FARTHEST: Final = 1000.0
_Number = Annotated[float, Field(strict=True)]
_Rows = Annotated[
    list[Annotated[list[_Number], Field(max_length=_MOST_ESTIMATES)]],
    Field(max_length=_MOST_ESTIMATES),
]
_QUANTITIES: Final = {"rad": Quantity("rad", "-0.3 mrad"), "m": Quantity("m", "-0.3 mm")}
_Size = Annotated[float, Field(strict=True, ge=0, le=10)]


class _Estimate(BaseModel):
    """One estimated draw."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    draw: str
    mean: _Number | str
    deviation: _Number | str | None = None
    phase: Literal["sine", "cosine"] | None = None


class _Added(BaseModel):
    """Prior deviations of the errors that are added to those of the arm's file, rad and m."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    zero: _Size = Deviations.zero
    turn: _Size = Deviations.turn
    shift: _Size = Deviations.shift
    base_turn: _Size = Deviations.base_turn
    base_shift: _Size = Deviations.base_shift
    tool_turn: _Size = Deviations.tool_turn
    tool_shift: _Size = Deviations.tool_shift
    harmonic: _Size = Deviations.harmonic
    orders: Annotated[int, Field(strict=True, ge=0, le=64)] = 0
    compliance: _Size = Deviations.compliance


class _File(BaseModel):
    """The whole file."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    estimates: Annotated[list[_Estimate], Field(min_length=1, max_length=_MOST_ESTIMATES)]
    covariance: _Rows | None = None
    factor: _Rows | None = None
    added: _Added | None = None
    data: dict[str, str | int] | None = None


@names_lines
def read_calibration(path: Path, arm: Arm) -> Calibration:
    """Return the calibration that a file states for an arm. Raises InputError with every mistake in
    the file.
    """
    file, tree = str(path), read_toml(path)
    try:
        stated = _File.model_validate(tree)
    except ValidationError as error:
        refuse_all(problems(error, _File, file, Draft(file, {}, {}).key))
    added = () if stated.added is None else added_terms(arm, Deviations(**stated.added.__dict__))
    usual = _of_usual_size(arm, stated.added)
    numbers_of = {each.draw for each in stated.estimates if not isinstance(each.mean, str)}
    known: dict[str, list[Law]] = {}
    for name, law in known_streams((*arm.calibrated(None).terms, *added)):
        known.setdefault(name, []).append(law)
    mistakes: list[Problem] = []
    streams = [_stream(file, k, each, known, mistakes) for k, each in enumerate(stated.estimates)]
    terms = (*arm.calibrated(None).terms, *added)
    numbers = [
        _in_deviations(file, k, each, terms, mistakes) for k, each in enumerate(stated.estimates)
    ]
    stated = stated.model_copy(update={"estimates": numbers})
    mistakes += [
        problem
        for k, each in enumerate(stated.estimates)
        for problem in _mistakes_in(file, k, each, stated)
    ]
    mistakes += [
        Problem(
            file,
            f"estimates[{k}].draw",
            f"{shown(name)} a second time",
            "every draw once",
            _EXAMPLE,
        )
        for k, (name, law) in enumerate(streams)
        if law is not None and (name, law) in streams[:k]
    ]
    rows = stated.covariance
    if rows is not None and {len(rows), *map(len, rows)} != {len(streams)}:
        found = (
            f"{len(rows)} rows of {listed(sorted({str(len(row)) for row in rows})) or 'no'} numbers"
        )
        mistakes.append(
            Problem(
                file,
                "covariance",
                found,
                f"{len(streams)} rows of {len(streams)} numbers, as there are estimates",
                _COVARIANCE,
            )
        )
    if stated.factor is not None:
        mistakes += _mistakes_in_factor(file, stated)
    if rows is not None and not all(abs(each) <= _FARTHEST**2 for row in rows for each in row):
        mistakes.append(
            Problem(
                file, "covariance", shown(rows), f"numbers of at most {_FARTHEST**2:g}", _COVARIANCE
            )
        )
    if mistakes:
        refuse_all(mistakes)
    mean = np.array([each.mean for each in stated.estimates])
    names = {name for name, _ in streams}
    try:
        return Calibration(
            tuple((name, law) for name, law in streams if law is not None),
            mean,
            _covariance(stated),
            tuple(of for of in added if of.name in names),
            _source(stated.data),
            frozenset(usual & numbers_of),
        )
    except InputError as error:
        raise InputError(
            [
                replace(each, file=file, found=shown(rows), example=_COVARIANCE, passing=())
                for each in error.problems
            ]
        ) from None


def _of_usual_size(arm: Arm, added: _Added | None) -> set[str]:
    """Return the names of the added errors whose standard deviations the file does not state."""
    if added is None:
        return set()
    sizes = added.__dict__
    doubled = {
        name: 2 * size
        for name, size in sizes.items()
        if name not in added.model_fields_set and name != "orders"
    }
    pairs = zip(
        *(added_terms(arm, Deviations(**{**sizes, **other})) for other in ({}, doubled)),
        strict=True,
    )
    return {of.name for of, wider in pairs if of.term.scale != wider.term.scale}


def _source(data: dict[str, str | int] | None) -> str:
    """Return what the estimates are from; empty where a person states them."""
    if data is None:
        return ""
    poses = data.get("poses")
    return f"{poses} measured poses" if poses else "a maker's calibration"


def _in_deviations(
    file: str, k: int, stated: _Estimate, terms: Sequence[PlacedTerm], mistakes: list[Problem]
) -> _Estimate:
    """Return an estimate whose angles or lengths are in standard deviations of its draw; what is
    none is noted as a mistake.
    """
    draw = [
        t for t in terms if t.term.robot is not None and t.term.robot.name(t.owner) == stated.draw
    ]
    size, unit = size_of(draw) if draw else (1.0, "1")
    found: dict[str, float] = {}
    for key in ("mean", "deviation"):
        value = getattr(stated, key)
        if not isinstance(value, str):
            continue
        found[key] = 0.0
        where = f"estimates[{k}].{key}"
        if unit == "1" or not size:
            expected = "a number of standard deviations: this draw has no single size"
            mistakes += (
                [Problem(file, where, shown(value), expected, f"{key} = 0.1")] if draw else []
            )
            continue
        try:
            number = cast("float", _QUANTITIES[unit](value))
        except PydanticCustomError as error:
            why = f"{shown(value)}: {(error.context or {})['why']}"
            example = f'{key} = "0.3 {"mrad" if unit == "rad" else "mm"}"'
            mistakes.append(Problem(file, where, why, _QUANTITIES[unit].expected, example))
            continue
        found[key] = number / (size if key == "mean" else abs(size))
    return stated.model_copy(update=found)


def _covariance(stated: _File) -> Floats:
    """Return the covariance of the estimates by whichever of its three forms is stated."""
    if stated.covariance is not None:
        return np.array(stated.covariance)
    out = np.diag(np.square([each.deviation or 0.0 for each in stated.estimates]))
    if stated.factor is not None:
        factor, joint = np.array(stated.factor), np.flatnonzero(_joint(stated))
        whole = factor @ factor.T
        out[np.ix_(joint, joint)] = (whole + whole.T) / 2
    return out


def _joint(stated: _File) -> list[bool]:
    """Return which of the estimates have no deviation of their own."""
    return [each.deviation is None for each in stated.estimates]


def _mistakes_in_factor(file: str, stated: _File) -> list[Problem]:
    """Return what is wrong with the shape or the numbers of the factor of the covariance."""
    rows, out, example = stated.factor or [], [], "factor = [[0.1]]"
    if stated.covariance is not None:
        expected = "covariance or factor, not both"
        out.append(Problem(file, "factor", "beside covariance", expected, example))
    count = sum(_joint(stated))
    if len(rows) != count or len(set(map(len, rows))) != 1 or not rows[0]:
        found = f"{len(rows)} rows of {listed(sorted({str(len(row)) for row in rows}))} numbers"
        expected = f"{count} equally long rows, one per estimate without a deviation"
        out.append(Problem(file, "factor", found, expected, example))
    if not all(abs(each) <= _FARTHEST for row in rows for each in row):
        expected = f"numbers of at most {_FARTHEST:g}"
        out.append(Problem(file, "factor", shown(rows), expected, example))
    return out


def _stream(
    file: str, k: int, stated: _Estimate, known: dict[str, list[Law]], mistakes: list[Problem]
) -> tuple[str, Law | None]:
    """Return the name of a draw with its law; without one where it has none, which is noted as a
    mistake.
    """
    key, laws = f"estimates[{k}]", known.get(stated.draw, [])
    by_phase = {type(law).__name__.lower(): law for law in laws} if len(laws) > 1 else {}
    if not laws:
        expected = (
            f"a draw by which robots of this arm differ, such as {listed(list(known))}"
            if known
            else "no estimate: all robots of this arm are equal"
        )
        mistakes.append(
            Problem(
                file,
                f"{key}.draw",
                shown(stated.draw),
                expected,
                nearest=nearest(stated.draw, known),
            )
        )
    elif by_phase and stated.phase is None:
        mistakes.append(
            Problem(
                file,
                f"{key}.phase",
                "nothing",
                "sine or cosine: a harmonic has two draws",
                'phase = "sine"',
            )
        )
    elif not by_phase and stated.phase is not None:
        mistakes.append(
            Problem(
                file,
                f"{key}.phase",
                shown(stated.phase),
                "no phase: this draw is no harmonic",
                _EXAMPLE,
            )
        )
    else:
        return stated.draw, by_phase[stated.phase] if stated.phase is not None else laws[0]
    return stated.draw, None


def _mistakes_in(file: str, k: int, stated: _Estimate, whole: _File) -> list[Problem]:
    """Return what is wrong with the numbers of an estimate: one out of its range, and a deviation
    beside a covariance or neither of both.
    """
    key, ranges = (
        f"estimates[{k}]",
        {"mean": (stated.mean, -_FARTHEST), "deviation": (stated.deviation, 0.0)},
    )
    out = [
        Problem(
            file,
            f"{key}.{name}",
            shown(value),
            f"from {low:g} to {_FARTHEST:g} standard deviations",
            f"{name} = 0.1",
        )
        for name, (value, low) in ranges.items()
        if isinstance(value, float | int) and not low <= value <= _FARTHEST
    ]
    together = whole.covariance is not None or whole.factor is not None
    if not together and stated.deviation is None:
        expected = "the standard deviation of the estimate, or covariance above all estimates"
        out.append(Problem(file, f"{key}.deviation", "nothing", expected, "deviation = 0.1"))
    if whole.covariance is not None and stated.deviation is not None:
        expected = "no deviation beside covariance, whose diagonal has its square"
        out.append(
            Problem(file, f"{key}.deviation", shown(stated.deviation), expected, _COVARIANCE)
        )
    return out
