"""The warning about drives that hold more than they are rated for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.figures import Figure, several

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lostmotion.studies.statics.overload import Overload


def overload_warnings(found: Iterable[Overload]) -> tuple[str, ...]:
    """Return one sentence per overloaded drive, for the first screen."""
    return tuple(
        f"joint {each.joint} is overloaded: it holds up to {Figure(each.held, each.unit)} standing still (worst of {several(each.poses, 'pose')}), "
        f"rated {Figure(each.rated, each.unit, stated=True)}; every figure assumes that the drive holds"
        for each in found
    )
