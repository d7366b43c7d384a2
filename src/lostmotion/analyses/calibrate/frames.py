"""The frames of the instrument that a calibration removes, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.calibration.sets import FEWEST_IN_SET, set_in_words
from lostmotion.reporting.sheet import Cell, length

if TYPE_CHECKING:
    from lostmotion.calibration.instruments import MeasuredVisits
    from lostmotion.calibration.robot import Robot


def frames_of_instrument(robot: Robot, visits: MeasuredVisits) -> list[str]:
    """Return which frames of the instrument were removed, and of several sets the one in whose base
    frame the results are.

    visits  the first one to each pose that was used
    """
    several_sets = len(robot.alignments) > 1
    out = []
    if several_sets:
        first = set_in_words(next(iter(robot.alignments)))
        out.append(
            f"{len(robot.alignments)} sets, each with a frame of its own: corrected commands are "
            f"in the base frame of {first}"
        )
    for name, frame in robot.alignments.items():
        if frame is not None:
            whose = f" of {set_in_words(name)}" if several_sets else ""
            out.append(
                f"the measurements{whose} are in the frame of the instrument, "
                f"{length(frame.shift)} and {Cell(frame.turn, '°')} from the base: "
                "brought into the base frame"
            )
    for name, rows in visits.by_set.items():
        if several_sets and len(rows) <= FEWEST_IN_SET:
            out.append(
                f"{set_in_words(name)} has {len(rows)} poses, which its frame needs: their errors "
                "where they are held out are mostly those of that frame"
            )
    return out
