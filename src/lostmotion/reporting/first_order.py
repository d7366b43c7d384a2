"""Where the first-order sum of errors fails, a sheet says so in its headline and prints no interval
of an accuracy.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.droop import droop
from lostmotion.mechanism.standing import cannot_hold
from lostmotion.propagation.exact import FAILS, share_neglected
from lostmotion.reporting.sheet import Card, length, several

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.droop import Droop
    from lostmotion.propagation.exact import ExactCheck
    from lostmotion.reporting.sheet import Section, Sheet
    from lostmotion.runs.summary import Outcome

# What exact composition may differ by, as a share of the error, for first order to be enough.
ENOUGH: Final = 0.01
# Droop (rad) from which a sheet mentions it.
_MENTIONED: Final = math.radians(1)
# Sections whose figures do not come from the sum of errors.
_SOUND: Final = frozenset({"workspace", "torques", "bending", "exact_check", "check", "cube"})
_SOUND_CARDS: Final = frozenset({"reach from the base", "test cube"})


def judged(check: ExactCheck, error: float) -> str:
    """Return a remark on the validity of first order for errors of this size (m)."""
    share = share_neglected(check, error)
    if share <= ENOUGH:
        return "first order is enough" if check.samples else "nothing was compared"
    return (
        "more than 1 %: the first-order figures are that uncertain"
        if share <= FAILS
        else "first order fails: the figures of errors are wrong"
    )


def failure(check: ExactCheck, error: float) -> str:
    """Return the headline's remark that first order fails for errors of this size (m); empty where
    it is valid.
    """
    share = share_neglected(check, error)
    if share <= FAILS:
        return ""
    angle = math.degrees(check.turn)
    turned = (
        f"errors of {float(f'{angle:.2g}'):g}° are not small"
        if angle >= 1
        else "errors are not small beside the arm"
    )
    found = (
        f"adding them up is wrong by {float(f'{100 * share:.2g}'):g} % of the 95 % error"
        if math.isfinite(share)
        else "they reach beyond 16 m, or some robots cannot hold their load"
    )
    return (
        f"First-order figures fail here: {turned}, and {found}. No accuracy can be stated for this "
        "arm; its largest errors are in the error budget."
    )


def with_falls(verdict: str, arm: Arm, name: str = "The arm") -> str:
    """Return the headline, after the sentence on a soft arm of this name that falls at some
    poses.
    """
    first = _falls(arm, droop(arm).falls_at, name) if arm.soft_freedoms else ""
    return f"{first} {verdict}".strip()


def _falls(arm: Arm, places: NDArray[np.int64], name: str = "The arm") -> str:
    count = np.count_nonzero(places >= 0)
    if not count:
        return ""
    return (
        f"{name} falls at {count} of {len(places)} poses spread evenly between its limits, where "
        f"the springs at {cannot_hold(arm, places)} cannot hold the load most often: no figure "
        "counts these poses."
    )


def _droops(droop: Droop) -> str:
    """Return the remark on a soft arm that it droops."""
    return (
        f"droops by up to {length(droop.length)} ({math.degrees(droop.turn):.2g}°) under its own "
        "weight, payload and process force; its errors are those where it stands"
        if droop.turn >= _MENTIONED
        else ""
    )


def checked(sheet: Sheet, check: ExactCheck, error: float, arm: Arm) -> Sheet:
    """Return a sheet as it is where first order holds for errors of this size (m); else with that
    in its headline, and no interval of an error. The headline begins with the poses at which a soft
    arm falls, the notes with its droop.

    The intervals would claim a certainty that is not there; the figures themselves stay.
    """
    message = failure(check, error)
    if arm.soft_freedoms:
        found = droop(arm)
        first, droops = _falls(arm, found.falls_at), _droops(found)
        verdict, note = " ".join(filter(None, (first, sheet.verdict))), [droops] if droops else []
        sheet = replace(sheet, verdict=verdict, notes=(*note, *sheet.notes))
    if not message:
        return sheet
    kept = [card for card in sheet.cards if card.title in _SOUND_CARDS]
    fails_by = Card(
        "first order fails by",
        str(length(check.largest)),
        "largest difference from exact composition",
    )
    shares = tuple(  # which part errs most remains known, what a remedy leaves does not
        replace(block, effect="", bars=tuple(replace(bar, effect=None) for bar in block.bars))
        for block in sheet.bars
        if block.key == "budget"
    )
    return replace(
        sheet,
        verdict=message,
        cards=(fails_by, *kept),
        sections=_without_intervals(sheet.sections),
        facts={**sheet.facts, "first_order_fails": True},
        bars=shares,
    )


def _without_intervals(sections: Sequence[Section]) -> tuple[Section, ...]:
    return tuple(
        section
        if section.key in _SOUND
        else replace(
            section,
            rows=tuple(
                replace(
                    row,
                    cells=tuple(
                        replace(figure, low=math.nan, high=math.nan) for figure in row.cells
                    ),
                )
                for row in section.rows
            ),
        )
        for section in sections
    )


def unsure(outcome: Outcome) -> Outcome:
    """Take the intervals off the figures of a design of a sweep."""
    return replace(
        outcome,
        figures={key: _alone(found) for key, found in outcome.figures.items()},
        lower=None if outcome.lower is None else _alone(outcome.lower),
    )


def _alone(estimate: Estimate) -> Estimate:
    return replace(estimate, low=math.nan, high=math.nan)


def failed(failing: Sequence[Outcome], designs: int, named: Callable[[int], str]) -> list[str]:
    """Return the headline's remark on designs where first order fails, with the worst one's
    name.
    """
    if not failing:
        return []
    worst = max(failing, key=lambda each: share_neglected(each.check, each.p95.value))
    message = failure(worst.check, worst.p95.value)
    return [
        message
        if designs == 1
        else (
            f"In {several(len(failing), 'design')} of {designs}, first of all "
            f"{named(worst.design)}: {message}"
        )
    ]
