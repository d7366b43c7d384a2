"""Friction of a drawn gearbox: efficiency in both directions, backdriving torque, and whether it is
self-locking.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.parts.gearbox.cycloidal.examined import FRICTION_LOADS
from lostmotion.printed import stated_text
from lostmotion.reporting.sheet import Cell, Row, Section

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.parts.gearbox.cycloidal.examined import Drawn

AS_DRAWN: Final = "the stage as drawn, without tolerances"
# Above this share friction invalidates the loads, which are computed without it.
_LARGE: Final = 0.2


def friction_sections(drawn: Drawn) -> tuple[Section, ...]:
    """Return the tables of efficiency over torque and of backdriving; none without stated
    friction.
    """
    friction = drawn.friction
    if not friction.any:
        return ()
    loads = drawn.read.asked.torque * np.array(FRICTION_LOADS)
    lost, efficiency, back = (
        friction.driving(loads) - loads,
        friction.efficiency(loads),
        friction.efficiency_driven_back(loads),
    )
    rows = [
        Row(
            f"at {stated_text(load)} N m",
            (
                _figure(torque, "N m", "the input cannot turn it"),
                *(Cell(each, "%", samples=AS_DRAWN) for each in (forth, reverse)),
            ),
        )
        for load, torque, forth, reverse in zip(
            *(each.tolist() for each in (loads, lost, efficiency, back)), strict=True
        )
    ]
    columns = ("friction at the output", "efficiency", "efficiency, driven back")
    note = (
        "friction at the output: what the input exerts beyond the load, times the ratio; "
        "Coulomb friction of flanks, eccentric and output pins "
        "of the stage at the output, without seals, grease and a first stage, normal forces "
        "as without friction: rough above a fifth of the torque"
    )
    return Section("friction", "Friction", columns, tuple(rows), note), _backdriving(drawn)


def _backdriving(drawn: Drawn) -> Section:
    friction = drawn.friction
    stated = "friction_torque over what output pins leave; the input itself turns freely"
    unknown = "no friction without load is stated: state friction_torque"
    torque = _figure(
        friction.backdriving_torque if friction.constant or friction.self_locking else math.nan,
        "N m",
        "none",
        "not stated",
    )
    rows = (
        Row(
            "backdriving torque",
            (torque,),
            "self-locking" if friction.self_locking else stated if friction.constant else unknown,
        ),
        Row(
            "self-locking",
            (_word(friction.self_locking),),
            "yes where friction of eccentric or output pins takes all of a load, however large",
        ),
        Row(
            "the input turns the output",
            (_word(friction.drives),),
            "no where friction of the flanks takes all of its torque",
        ),
    )
    note = (
        "without vibration, which may release a locked drive; as far as Coulomb friction of the "
        "stage goes, as above"
    )
    return Section("backdriving", "Backdriving", ("value",), rows, note)


def _figure(value: float, unit: str, infinite: str, missing: str = "") -> Cell:
    """Return a figure, or words in its place where it is infinite or missing."""
    words = "" if math.isfinite(value) else missing if math.isnan(value) else infinite
    return Cell(value, unit, samples=AS_DRAWN, words=words)


def _word(answer: bool) -> Cell:  # noqa: FBT001 - the answer itself
    return Cell(float(answer), "1", samples=AS_DRAWN, words="yes" if answer else "no")


def friction_facts(drawn: Drawn) -> dict[str, Any]:
    """Return what result.json holds of friction besides its figures; empty without stated
    friction.
    """
    friction = drawn.friction
    return (
        {"self_locking": friction.self_locking, "input_turns_output": friction.drives}
        if friction.any
        else {}
    )


def notes_on_friction(drawn: Drawn, torque: float) -> Iterator[str]:
    """Yield the warnings on friction that is large, or takes all of the torque."""
    friction = drawn.friction
    if not friction.any:
        return
    if not friction.drives:
        yield (
            "friction of the flanks takes all of the torque: the input cannot turn the output, "
            "and a wound-up drive does not unload"
        )
    elif friction.driving(np.array(torque)) - torque > _LARGE * torque:
        yield (
            "friction is more than a fifth of the torque: loads are computed without it, so that "
            "efficiency and hysteresis are rough estimates"
        )
