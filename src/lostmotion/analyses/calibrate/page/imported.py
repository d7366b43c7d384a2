"""Sheet of a maker's calibration."""

from __future__ import annotations

from typing import Final

from lostmotion.analyses.calibrate.answer import ImportedErrors, size
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.sheet import Card, Cell, Sheet, length, table

_SHOWN: Final = 60


def imported_sheet(imported: ImportedErrors) -> Sheet:
    """Return the sheet of a maker's calibration."""
    robot = [each for each in imported.errors if not each.frame]
    turns = [abs(each.value) for each in robot if each.unit == "rad"]
    shifts = [abs(each.value) for each in robot if each.unit == "m"]
    most = Cell(max(turns, default=0.0), "mrad"), length(max(shifts, default=0.0))
    return Sheet(
        name=imported.robot.name,
        subject="maker's calibration",
        verdict=(
            f"The maker's calibration moves the tool by {length(imported.before)} on average: "
            "tilts "
            f"and zeros of at most {most[0]}, offsets of at most {most[1]}."
        ),
        cards=(
            Card("largest turn", str(most[0]), "of a seat"),
            Card("largest offset", str(most[1]), "of a seat"),
            Card("difference", str(length(imported.left)), "largest, to the maker's chain"),
        ),
        sections=(
            table(
                "estimates",
                "Errors by the maker's calibration, largest effect first",
                ("value", "effect at the tool"),
                [
                    (
                        short_name(each.name),
                        size(each, each.value),
                        length(each.effect),
                        "frame" if each.frame else "",
                    )
                    for each in imported.errors[:_SHOWN]
                ],
                "the smallest errors that lead to the maker's chain; r.m.s. motion of the tool",
            ),
        ),
        source=f"{imported.file.name}, {imported.digest}",
        facts={"arm": imported.robot.name},
    )
