"""What can be changed in the view: payload, remedies, gearboxes of the catalogue, and sections of
links.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from pydantic import TypeAdapter

from lostmotion.catalogue import materials
from lostmotion.catalogue.gearboxes import find_gearbox, gearboxes
from lostmotion.error_model.remedies import STAGES
from lostmotion.parts.error_source import Mass
from lostmotion.parts.gearbox.kinds import turning_gearbox
from lostmotion.parts.profile import Section

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import Joint

# The choice that leaves a part as the file describes it.
AS_IN_FILE: Final = "as in the file"
# Round tubes that every link can have, outside diameter and wall in mm, in the material of the
# link; aluminium where it has none.
_TUBES: Final = (
    (30, 2),
    (40, 3),
    (60, 3),
    (80, 4),
    (100, 4),
    (120, 5),
    (150, 6),
    (200, 8),
    (250, 8),
)
_MATERIAL: Final = "aluminium"


@dataclass(frozen=True)
class Choices:
    """Everything that can be changed, without the pose.

    payload      mass of the payload, kg
    compensated  whether the controller knows the load and every nominal deflection
    calibrated   whether the geometry of each robot is calibrated
    gearboxes    name of another gearbox of the catalogue, by joint
    sections     name of another section of the link, by joint
    """

    payload: float
    compensated: bool = False
    calibrated: bool = False
    gearboxes: Mapping[str, str] = field(default_factory=dict)
    sections: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raise ValueError for a payload that an arm file could not state."""
        TypeAdapter(Mass).validate_python(self.payload)

    @property
    def stage(self) -> str:
        """Return the stage of remedies, one of `remedies.STAGES`."""
        return STAGES[self.calibrated + 2 * self.compensated]


def gearbox_names(joint: Joint) -> list[str]:
    """Return the gearboxes of the catalogue that a joint can have, with its ratio where the maker
    offers it; none for a joint that does not turn.
    """
    if joint.type != "revolute":
        return []
    ratio = abs(joint.gearbox.ratio) if joint.gearbox is not None else None
    names = []
    for row in gearboxes():
        own = (
            ratio
            if ratio is not None and ratio > 1 and row.applies_to(ratio)
            else row.typical_ratio
        )
        if own is not None:
            names += [f"{model}-{own:g}" for model in row.models]
    return list(dict.fromkeys(names))


def section_names(arm: Arm, joint: Joint) -> list[str]:
    """Return the sections that the link of a joint can have: those of the other links of the arm,
    then round tubes; none for a link of no length.
    """
    others = [
        other.name
        for other in arm.joints
        if other.link.section is not None and _is_sized(other) and other is not joint
    ]
    return (
        [
            *(f"that of {name}" for name in others),
            *(f"tube {outer} x {wall} mm" for outer, wall in _TUBES),
        ]
        if joint.link.reach
        else []
    )


def changed(arm: Arm, choices: Choices) -> Arm:
    """Return the arm with these choices; what is not chosen is as in `arm`.

    The stated mass of a joint stays, with its gearbox included; that of a link without a stated
    mass follows its section.
    """
    joints = [
        _with_gearbox(_with_section(arm, joint, choices.sections), choices.gearboxes)
        for joint in arm.joints
    ]
    if any(new is not old for new, old in zip(joints, arm.joints, strict=True)):
        arm = arm.model_copy(update={"joints": tuple(joints)}).with_warnings(arm.warnings)
    if choices.payload == arm.payload.mass:
        return arm
    return arm.with_payload(arm.payload.model_copy(update={"mass": choices.payload}))


def _is_sized(joint: Joint) -> bool:
    """Return whether the section of a link also fits links of other lengths."""
    return not hasattr(joint.link.section, "length")


def _with_gearbox(joint: Joint, names: Mapping[str, str]) -> Joint:
    name = names.get(joint.name, AS_IN_FILE)
    if name == AS_IN_FILE:
        return joint
    row, ratio = find_gearbox(name)
    tree = row.with_stated({"model": name, "ratio": ratio})
    return joint.model_copy(update={"gearbox": turning_gearbox(tree)})


def _with_section(arm: Arm, joint: Joint, names: Mapping[str, str]) -> Joint:
    name = names.get(joint.name, AS_IN_FILE)
    if name == AS_IN_FILE:
        return joint
    other = next((other.link for other in arm.joints if name == f"that of {other.name}"), None)
    if other is not None:
        section, material = other.section, other.material
    else:
        size = next((size for size in _TUBES if name == f"tube {size[0]} x {size[1]} mm"), None)
        if size is None:
            raise ValueError(f"no section '{name}'")
        outer, wall = size
        tube = {"kind": "tube", "outer": f"{outer} mm", "wall": f"{wall} mm"}
        section, material = (
            TypeAdapter(Section).validate_python(tube, context={"text": True}),
            joint.link.material or materials()[_MATERIAL],
        )
    update = {
        "section": section,
        "material": material,
        "compliance": None,
        "measured": None,
        "rigid": False,
    }
    return joint.model_copy(update={"link": joint.link.model_copy(update=update)})
