"""Lowering of an arm to the tables of its controller: from terms and forms to constant matrices,
sizes and products of sizes.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.controller_model.factors import Factors
from lostmotion.controller_model.places import places_of
from lostmotion.controller_model.simplification import with_combined_springs, without_phases
from lostmotion.controller_model.tables import (
    ONE,
    UNKNOWN,
    Entry,
    Product,
    Shared,
    Tables,
    Validity,
)
from lostmotion.mechanism.calibration import REMAINING
from lostmotion.mechanism.closed_chain import refuse_closed
from lostmotion.parts.forms import Linear
from lostmotion.parts.play import InPlay
from lostmotion.parts.term import Draw

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.controller_model.factors import Factor, Size
    from lostmotion.controller_model.tables import Record
    from lostmotion.laws.distributions import Law
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.spatial import Floats

    # Directions (6,) by index of their size.
    Screw = dict[int, Floats]


class Error(NamedTuple):
    """The draws of an error: terms with equal draws add before they are squared. The joint's last
    motion is not among them.

    robot, visit  streams with their laws; None: no such factor
    play          name of the stream that decides whether a play is closed, for the deviation of one
                  robot from the mean; empty elsewhere
    """

    robot: tuple[str, Law] | None = None
    visit: tuple[str, Law] | None = None
    play: str = ""

    @property
    def name(self) -> str:
        """Return the names of its streams."""
        streams = (each[0] for each in (self.robot, self.visit) if each is not None)
        return " x ".join([*streams, *([self.play] if self.play else [])])


_DESIGN: Final = Error()
# A smaller share is rounding.
_ROUNDING: Final = 1e-14


@dataclass
class Screws:
    """The screws of one error at one place: without and with the last motion as a factor, and what
    is linear in wrench and gravity.
    """

    plain: Screw = field(default_factory=dict)
    sided: Screw = field(default_factory=dict)
    compliance: Floats = field(default_factory=lambda: np.zeros((6, 6)))
    own_weight: Floats = field(default_factory=lambda: np.zeros((6, 3)))

    @property
    def is_linear(self) -> bool:
        """Return whether a part of it is linear in the wrench or in gravity."""
        return bool(self.compliance.any() or self.own_weight.any())


def tables_of(arm: Arm, valid: Validity) -> Tables:
    """Return the tables of an arm.

    valid  limits of the load and of gravity

    Exact: the tables have the same mean and covariance as the terms.
    """
    refuse_closed(
        arm.tree,
        "table for a controller, as `compensate` and `export` need it",
        "a serial arm; of a closed chain `study` predicts the errors at given poses "
        "(`--poses poses.csv`)",
    )
    own = [each for each in _independent(arm) if each.place in arm.tree.tool_path]
    simplified = with_combined_springs(without_phases(own))
    places = places_of(arm.tree, {each.place for each in simplified})
    rise = 0.0 if arm.environment.rise is None else arm.environment.rise.nominal
    factors = [
        Factors(np.eye(6), None if each.joint < 0 else arm.limits[each.joint])
        for each in places.records
    ]
    errors: list[dict[Error, Screws]] = [{} for _ in places.records]
    for placed in simplified:
        number = places.number[placed.place]
        factors[number].turn = np.asarray(
            np.kron(np.eye(2), places.pose[placed.place][:3, :3]), dtype=float
        )
        _add(placed, errors[number], factors[number], rise)
    draws = _shared(errors)
    payload, rated = (
        arm.payload,
        [None if joint.gearbox is None else joint.gearbox.rated_torque for joint in arm.driven],
    )
    return Tables(
        arm.name,
        tuple(joint.name for joint in arm.driven),
        arm.limits,
        np.array([np.inf if each is None else each for each in rated]),
        tuple(_record(*each, draws) for each in zip(places.records, errors, factors, strict=True)),
        tuple(error.name for error in draws),
        np.array([payload.mass, *payload.centre_of_mass, *payload.force, *payload.moment]),
        arm.gravity_in_base,
        valid,
    )


def _independent(arm: Arm) -> list[PlacedTerm]:
    """Return the terms of an arm with independent draws: tables have no others, so that a term with
    one of several correlated draws becomes one for each independent draw of which it is a sum.
    """
    correlations = arm.correlations
    if correlations is None:
        return list(arm.terms)
    out: list[PlacedTerm] = []
    for placed in arm.terms:
        term, draw = placed.term, placed.term.robot
        row = None if draw is None else correlations.row.get(draw.name(placed.owner))
        if row is None:
            out.append(placed)
            continue
        out += [
            replace(
                placed,
                term=replace(
                    term,
                    scale=term.scale * factor,
                    robot=Draw(correlations.streams[k], REMAINING, "calibration"),
                ),
            )
            for k, factor in enumerate(correlations.factor[row].tolist())
            if abs(factor) > _ROUNDING
        ]
    return out


def _shared(errors: Sequence[Mapping[Error, Screws]]) -> list[Error]:
    """Return the errors that are added up at the tool: those of several places, and those with a
    compliance matrix.
    """
    count = Counter(error for here in errors for error in here)
    linear = {error for here in errors for error, screws in here.items() if screws.is_linear}
    return [
        error
        for error, places in count.items()
        if error != _DESIGN and (places > 1 or error in linear)
    ]


def _stream(owner: str, draw: Draw | None) -> tuple[str, Law] | None:
    return None if draw is None else (draw.name(owner), draw.law)


def _add(placed: PlacedTerm, errors: dict[Error, Screws], factors: Factors, rise: float) -> None:
    """Add a term to the errors at its place."""
    term, form = placed.term, placed.term.form
    error = Error(
        _stream(placed.owner, term.robot), None if term.sided else _stream(placed.owner, term.visit)
    )
    if isinstance(form, Linear):
        screws = errors.setdefault(error, Screws())
        _add_linear(screws, form, term.scale, factors.turn)
        if form.per_kelvin is not None and rise:
            _put(screws.plain, ONE, term.scale * rise * factors.turn @ form.per_kelvin)
        return
    sizes, decides = factors.of_form(form), form.decides if isinstance(form, InPlay) else None
    if decides is None:
        variants = [(error, sizes, 1.0)]
    else:
        mean, change, sign = factors.threshold(decides, above=form.above)
        variants = [(error, _times(sizes, mean), 1.0)]
        if decides.scatters:
            variants.append(
                (
                    error._replace(play=f"{placed.owner}.{decides.stream}"),
                    _times(sizes, change),
                    sign,
                )
            )
    for each, of_size, sign in variants:
        screws = errors.setdefault(each, Screws())
        for size, direction in of_size:
            _put(
                screws.sided if term.sided else screws.plain,
                factors.size(size),
                sign * term.scale * direction,
            )


def _add_linear(screws: Screws, form: Linear, scale: float, turn: Floats) -> None:
    screws.compliance = screws.compliance + scale * turn @ form.matrix @ turn.T
    if form.own_weight is not None:
        screws.own_weight = screws.own_weight + scale * turn @ form.own_weight @ turn[:3, :3].T


def _times(sizes: Sequence[tuple[Size, Floats]], factor: Factor) -> list[tuple[Size, Floats]]:
    return [((*size, factor), direction) for size, direction in sizes]


def _put(screw: Screw, size: int, direction: Floats) -> None:
    screw[size] = screw[size] + direction if size in screw else direction


def _record(
    record: Record, errors: Mapping[Error, Screws], factors: Factors, draws: Sequence[Error]
) -> Record:
    """Return the record of a place with its errors."""
    design = errors.get(_DESIGN, Screws())
    sums: dict[tuple[int, int, int], Floats] = {}
    shared = []
    for error, screws in errors.items():
        if error in draws:
            entries = _entries(screws, constant=True)
            shared.append(
                Shared(
                    draws.index(error),
                    screws.compliance,
                    screws.own_weight,
                    entries,
                    _share(screws, design),
                )
            )
        elif error != _DESIGN:
            _square(sums, screws.plain, screws.plain, 0)
            _square(sums, screws.plain, screws.sided, 1, 2.0)
        # A last motion that is drawn has the variance 1 - s^2, which is zero where it is known. Of
        # a drawn error the mean square remains.
        _square(
            sums, screws.sided, screws.sided, UNKNOWN if error == _DESIGN or error in draws else 0
        )
    constant = sums.pop((ONE, ONE, 0), np.zeros((6, 6)))
    return replace(
        record,
        mean=design.plain.get(ONE, np.zeros(6)),
        compliance=design.compliance,
        own_weight=design.own_weight,
        covariance=constant,
        curves=tuple(factors.curves),
        harmonics=tuple(factors.harmonics),
        seats=tuple(factors.seats),
        thresholds=tuple(factors.thresholds),
        tables=tuple(factors.tables),
        sizes=factors.numbered_sizes(),
        entries=_entries(design, constant=False),
        products=tuple(Product(*key, matrix) for key, matrix in sums.items() if matrix.any()),
        shared=tuple(shared),
    )


def _entries(screws: Screws, *, constant: bool) -> tuple[Entry, ...]:
    return tuple(
        Entry(size, side, direction)
        for side, screw in enumerate((screws.plain, screws.sided))
        for size, direction in screw.items()
        if direction.any() and (side or constant or size != ONE)
    )


def _square(
    sums: dict[tuple[int, int, int], Floats],
    one: Screw,
    other: Screw,
    side: int,
    factor: float = 1.0,
) -> None:
    """Add the covariance of two screws of one error, by pairs of sizes and by the factor of the
    last motion.
    """
    for a, first in one.items():
        for b, second in other.items():
            outer = np.outer(first, second)
            key = min(a, b), max(a, b), side
            sums[key] = sums.get(key, 0.0) + factor / 2 * (outer + outer.T)


def _share(screws: Screws, whole: Screws) -> float:
    """Return by which factor compliance and own weight are those of the whole; 0 where they are not
    proportional to them.
    """
    drawn, own = (
        np.concatenate([each.compliance.ravel(), each.own_weight.ravel()])
        for each in (screws, whole)
    )
    largest = int(np.argmax(np.abs(own)))
    share = float(drawn[largest] / own[largest]) if own[largest] else 0.0
    return share if (np.abs(drawn - share * own) <= _ROUNDING * np.abs(drawn)).all() else 0.0
