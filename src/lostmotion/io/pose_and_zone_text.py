"""A pose or a zone in a line of text: "A=30deg B=-10deg" or a pose's number, "x 0.2..0.5 m, y
-100..100 mm".
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import InputError, Problem, shown
from lostmotion.io.limits import listed, nearest
from lostmotion.parts.joint import PrismaticJoint
from lostmotion.unit_registry import UnitError
from lostmotion.units import read_quantity

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_LONGEST: Final = 2000
_NUMBER: Final = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
_VALUE: Final = rf"\s*=\s*(?P<value>{_NUMBER}\s*[^\s,=]*)\s*(?:,|(?=\s)|$)"
_ANY: Final = re.compile(r"\s*(?P<name>[^=,]{1,100}?)" + _VALUE)
_ENDS: Final = re.compile(
    rf"\s*(?P<axis>[a-zA-Z])\s+(?P<low>{_NUMBER})\s*(?P<own>[^\s.\d]+)?\s*\.\.\s*(?P<high>{_NUMBER})\s*(?P<unit>\S+)\s*"
)
_ZONE: Final = "x 0.2..0.5 m, y -100..100 mm"
_ROUNDING: Final = 1e-9


def read_pose(text: str, arm: Arm, argument: str = "at") -> int | Floats:
    """Return the joint values (joint,) in rad and m of a pose given by its number or by the value
    of every moving joint.

    Raises InputError with every mistake: joints that are unknown, missing or named twice, values
    without a unit of their kind or outside the limits.
    """
    # \s has more characters than int() takes
    if re.fullmatch(r"[ \t\r\n]*[0-9]{1,9}[ \t\r\n]*", text):
        return int(text)
    joints = {joint.name: joint for joint in arm.driven}
    example = " ".join(
        f"{name}={'10mm' if isinstance(joint, PrismaticJoint) else '30deg'}"
        for name, joint in joints.items()
    )
    # A joint of the arm is met by its whole name, whatever letters that has.
    known = re.compile(
        r"\s*(?P<name>"
        + "|".join(re.escape(name) for name in sorted(joints, key=len, reverse=True))
        + ")"
        + _VALUE
    )
    mistakes: list[Problem] = []
    found: dict[str, float] = {}
    at = 0
    while at < len(text) <= _LONGEST and text[at:].strip():
        match = known.match(text, at) or _ANY.match(text, at)
        if match is None:
            mistakes.append(
                Problem(
                    "",
                    argument,
                    shown(text[at:].strip()),
                    "joint=value with its unit, for every joint, or a pose's number",
                    passing=((argument, example),),
                )
            )
            break
        at = match.end()
        name = match["name"]
        if name not in joints or name in found:
            what = f"joint '{name}' twice" if name in found else shown(name)
            meant = "" if name in found else nearest(name, joints)
            mistakes.append(
                Problem(
                    "",
                    argument,
                    what,
                    f"each joint once, of {listed(joints)}",
                    nearest=meant,
                    passing=((argument, example),),
                )
            )
            continue
        si = "m" if isinstance(joints[name], PrismaticJoint) else "rad"
        try:
            found[name] = read_quantity(match["value"], si).nominal
        except UnitError as error:
            found[name] = joints[name].limits[0]
            mistakes.append(
                Problem(
                    "",
                    argument,
                    f"{name}={shown(match['value'])[1:-1]} ({error})",
                    "a value with its unit",
                    passing=((argument, example),),
                )
            )
            continue
        low, high = joints[name].limits
        slack = _ROUNDING * (high - low)
        if not low - slack <= found[name] <= high + slack:
            unit, factor = ("mm", 1e3) if si == "m" else ("deg", 180 / np.pi)
            ends = f"{low * factor:.6g} {unit} to {high * factor:.6g} {unit}"
            mistakes.append(
                Problem(
                    "",
                    argument,
                    f"{name}={match['value']}",
                    f"a value within its limits, {ends}",
                    f"{name}={low * factor:.6g}{unit}",
                )
            )
    if len(text) > _LONGEST:
        mistakes.append(
            Problem(
                "",
                argument,
                f"{len(text)} characters",
                f"at most {_LONGEST}",
                passing=((argument, example),),
            )
        )
    missing = [name for name in joints if name not in found]
    if missing and not mistakes:
        mistakes.append(
            Problem(
                "",
                argument,
                f"no value for {listed(missing)}",
                "the value of every moving joint",
                passing=((argument, example),),
            )
        )
    if mistakes:
        raise InputError(mistakes)
    return np.array([found[name] for name in joints])


def read_zone(text: str, argument: str = "zone") -> dict[str, tuple[float, float]]:
    """Return the limits (m) of a zone along each of the base's axes that it names.

    `argument` is what the text was given for. Raises InputError with every mistake: an axis that is
    none of
    x, y, z or comes twice, ends in the wrong order, no unit of length.
    """
    expected = "limits along x, y and z in the base's axes, lower one first, with their unit"
    out: dict[str, tuple[float, float]] = {}
    mistakes: list[Problem] = []

    def refuse(part: str, why: str) -> None:
        mistakes.append(
            Problem(
                "",
                argument,
                f"{shown(part.strip())} ({why})",
                expected,
                passing=((argument, _ZONE),),
            )
        )

    for part in text[:_LONGEST].split(","):
        match = _ENDS.fullmatch(part)
        axis = match["axis"].lower() if match else ""
        if match is None:
            refuse(part, _amiss(part))
            continue
        if axis not in {"x", "y", "z"} or axis in out:
            refuse(part, f"{axis} comes twice" if axis in out else f"no axis '{axis}'")
            continue
        try:
            units = match["own"] or match["unit"], match["unit"]
            low, high = (
                read_quantity(f"{match[end]} {unit}", "m").nominal
                for end, unit in zip(("low", "high"), units, strict=True)
            )
        except UnitError as error:
            refuse(part, str(error))
            continue
        if low > high:
            refuse(part, "the higher end stands first")
        out[axis] = (low, high)
    if mistakes:
        raise InputError(mistakes)
    return out


def _amiss(part: str) -> str:
    """Return the problem of a part of a zone's text."""
    axis, _, ends = part.strip().partition(" ")
    if ".." not in part:
        return "no '..' between two ends"
    if not axis.isalpha():
        return "no axis, and a space, before the ends"
    return (
        "no unit after the ends"
        if ends.strip()[-1:].isdigit()
        else "the ends are no numbers with their unit"
    )
