"""An arm with chosen parts, put together slot by slot, to compare the search's own arms with."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.sizing.candidates import PartCandidate, Slot


def with_parts(arm: Arm, slots: tuple[Slot, ...], chosen: tuple[PartCandidate, ...]) -> Arm:
    """Return the arm with one chosen candidate in each slot."""
    joints = {joint.name: joint for joint in arm.joints}
    for slot, candidate in zip(slots, chosen, strict=True):
        joints[slot.joint] = slot.install(joints[slot.joint], candidate)
    return arm.model_copy(update={"joints": tuple(joints.values())})
