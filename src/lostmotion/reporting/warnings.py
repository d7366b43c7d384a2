"""What a sheet about an arm warns of: drives that hold more than they are rated for, and what seems wrong in its description."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.error_model.overload import overloads
from lostmotion.reporting.sheet import Figure, several

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lostmotion.error_model.overload import Overload
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm


def overload_warnings(found: Iterable[Overload]) -> tuple[str, ...]:
    """Return one sentence per overloaded drive, for the first screen."""
    return tuple(
        f"joint {each.joint} is overloaded: it holds up to {Figure(each.held, each.unit)} standing still (worst of {several(each.poses, 'pose')}), "
        f"rated {Figure(each.rated, each.unit, stated=True)}; every figure assumes that the drive holds"
        for each in found
    )


def arm_warnings(arm: Arm, poses: Poses | None = None) -> tuple[str, ...]:
    """Return what every sheet about an arm warns of: doubtful data of its description, and overloaded drives, `poses` as for `overloads`."""
    return (*arm.warnings, *overload_warnings(overloads(arm, poses)))
