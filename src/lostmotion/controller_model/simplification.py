"""Fewer error terms with the same mean and covariance at every pose: what a controller evaluates
need not be listed cause by cause.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.distributions import Cosine, Sine
from lostmotion.parts.forms import Constant, Curve, Harmonic, Spring

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.spatial import Floats


def without_phases(terms: Sequence[PlacedTerm]) -> list[PlacedTerm]:
    """Return the terms with one term in place of the sine and the cosine of a harmonic whose phase
    is drawn.

    The squares of sine and cosine add to one, so the covariance does not depend on the joint value.
    Mean and covariance are equal; draws are not.
    """
    pairs: dict[str, list[PlacedTerm]] = {}
    for each in terms:
        draw = each.term.robot
        if isinstance(each.term.form, Harmonic) and draw is not None and each.term.visit is None:
            pairs.setdefault(draw.name(each.owner), []).append(each)
    amplitudes: dict[int, PlacedTerm | None] = {}
    for pair in pairs.values():
        laws = {type(each.term.robot.law) for each in pair if each.term.robot is not None}
        if len(pair) == len(laws) and laws == {Cosine, Sine} and _are_one(*pair):
            amplitudes |= {id(pair[0]): _amplitude(pair[0]), id(pair[1]): None}
    found = (amplitudes.get(id(each), each) for each in terms)
    return [each for each in found if each is not None]


def _are_one(sine: PlacedTerm, cosine: PlacedTerm) -> bool:
    one, other = sine.term.form, cosine.term.form
    if (
        not isinstance(one, Harmonic)
        or not isinstance(other, Harmonic)
        or sine.place != cosine.place
    ):
        return False
    equal = (one.order, one.turns, one.envelope) == (other.order, other.turns, other.envelope)
    return bool(
        equal
        and one.phase != other.phase
        and sine.term.scale == cosine.term.scale
        and (one.direction == other.direction).all()
    )


def _amplitude(placed: PlacedTerm) -> PlacedTerm:
    form = placed.term.form
    assert isinstance(form, Harmonic)  # noqa: S101 - for the type checker
    own = (
        Constant(form.direction)
        if form.envelope is None
        else Spring(form.direction, form.envelope, odd=False)
    )
    return replace(placed, term=replace(placed.term, form=own))


def with_combined_springs(terms: Iterable[PlacedTerm]) -> list[PlacedTerm]:
    """Return the terms with one spring in place of several that have the same draws, place and
    direction, such as the members of one gearbox.
    """
    out: list[PlacedTerm] = []
    springs: dict[object, list[PlacedTerm]] = {}
    for each in terms:
        form = each.term.form
        if not isinstance(form, Spring):
            out.append(each)
            continue
        line = _line(form).tobytes()
        drawn = [
            draw
            for draw in (each.term.robot, None if each.term.sided else each.term.visit)
            if draw is not None
        ]
        owners = tuple(draw.shared or each.owner for draw in drawn)
        springs.setdefault(
            (each.place, owners, each.term.robot, each.term.visit, line, *_law(form)), []
        ).append(each)
    return [*out, *(_combined(group) if len(group) > 1 else group[0] for group in springs.values())]


def _law(spring: Spring) -> tuple[bool, Curve | None, bool]:
    return spring.odd, spring.travel, spring.fed_forward


def _line(spring: Spring) -> Floats:
    """Return the direction of a spring, without a sign where it is an axis."""
    return np.abs(spring.direction) if np.count_nonzero(spring.direction) == 1 else spring.direction


def _combined(group: Sequence[PlacedTerm]) -> PlacedTerm:
    forms = [each.term.form for each in group if isinstance(each.term.form, Spring)]
    load = np.unique(np.concatenate([form.curve.load for form in forms]))
    value, beyond, direction = np.zeros(len(load)), 0.0, _line(forms[0])
    for each, form in zip(group, forms, strict=True):
        # An odd curve along the opposite direction deflects the same way; an even one the opposite
        # way.
        factor = (
            each.term.scale
            if form.odd
            else each.term.scale * float(np.sign(form.direction @ direction))
        )
        value = value + factor * form.curve(load)
        beyond += factor * form.curve.beyond
    return replace(
        group[0],
        term=replace(
            group[0].term,
            form=replace(forms[0], direction=direction, curve=Curve(load, value, beyond)),
            scale=1.0,
        ),
    )
