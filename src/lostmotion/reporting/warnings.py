"""What a sheet about an arm warns of: drives that hold more than they are rated for, and what seems
wrong in its description.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.error_model.few_poses import MANY, known_ends
from lostmotion.error_model.overload import overloads
from lostmotion.reporting.sheet import Cell, length, several

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.overload import Overload
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm


def overload_warnings(overloaded: Iterable[Overload]) -> tuple[str, ...]:
    """Return one sentence per overloaded drive, for the first screen."""
    return tuple(
        f"joint {each.joint} is overloaded: it holds up to {Cell(each.held, each.unit)} "
        f"standing still (worst of {several(each.poses, 'pose')}), "
        f"rated {Cell(each.rated, each.unit, stated=True)}; every figure assumes that the "
        "drive holds"
        for each in overloaded
    )


def few_poses_warnings(
    poses: int, figures: Mapping[str, tuple[Estimate, Estimate]]
) -> tuple[str, ...]:
    """Return the sentence that these poses are too few for some figures; nothing where they are
    enough for all.

    figures: by the name of a figure, the root mean square (m) of the errors in it over the poses
    and over many
    """
    short = {
        name: pair for name, pair in figures.items() if known_ends(pair[0], *pair) is not pair[0]
    }
    if not short:
        return ()
    sizes = (
        " in place of ".join(
            str(length(each.value, each.low, each.high)) for each in reversed(pair)
        )
        + f" ({name})"
        for name, pair in short.items()
    )
    sentence = (
        f"{several(poses, 'pose')} are too few: over {MANY} poses the root mean square is "
        f"{', '.join(sizes)}. Ends of intervals that are therefore "
        f"not known are marked with a question mark; visit at least {MANY} poses"
    )
    return (sentence,)


def arm_warnings(arm: Arm, poses: Poses | None = None) -> tuple[str, ...]:
    """Return what every sheet about an arm warns of: doubtful data of its description, and
    overloaded drives, `poses` as for `overloads`.
    """
    return (*arm.warnings, *overload_warnings(overloads(arm, poses)))
