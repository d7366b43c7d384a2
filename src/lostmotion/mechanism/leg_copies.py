"""Joints of legs that repeat, whether a file states the legs once or one by one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm


def leg_copies(arm: Arm, part: Literal["link", "gearbox", "bearing"]) -> dict[str, tuple[str, ...]]:
    """Return, for the name of each joint, the names of the joints that are copies of it, with its
    own, in the order of the arm.

    Copies have the same type, the same link and the same `part`, and are attached to one place, or
    to the same place of copies. In a serial arm every joint is its own copy alone.
    """
    ends = {
        place: (k, end) for k, own in enumerate(arm.tree.joints) for end, place in enumerate(own)
    }
    first: dict[object, str] = {}
    copied: list[str] = []
    for joint, places in zip(arm.joints, arm.tree.joints, strict=True):
        on = arm.tree.places[places.seat].parent
        leg = (copied[ends[on][0]], ends[on][1]) if on in ends else on
        stated = (joint.type, *(_stated(getattr(joint, name, None)) for name in ("link", part)))
        copied.append(first.setdefault((leg, stated), joint.name))
    names = [joint.name for joint in arm.joints]
    return {
        name: tuple(other for other, of in zip(names, copied, strict=True) if of == mine)
        for name, mine in zip(names, copied, strict=True)
    }


def _stated(part: object) -> str:
    return repr(part.model_dump() if hasattr(part, "model_dump") else part)
