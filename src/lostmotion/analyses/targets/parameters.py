"""Which sizes of an arm's parts can a designer choose, and which terms of the error follow each of them?

An item is one cause in one part: the play of joint A's gearbox, the stiffness of link B, an encoder's zero. Its terms are proportional to its size,
or to one over it where it is a stiffness; scatter that is stated as ± goes along in proportion. Terms that no rule names make an item of their own.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from lostmotion.analyses.targets.usual_sizes import MOST_TIMES, largest_usual_factor
from lostmotion.parts.bearing.rolling_contact import DrawnBearing
from lostmotion.parts.joint import FixedJoint, PrismaticJoint
from lostmotion.parts.link import Link
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from lostmotion.error_model.pose_matrix import TermInfo
    from lostmotion.mechanism.arm import Arm

# "kind of part: name of the term" -> the cause, by the file's own word where it has one. First match counts.
_CAUSES: Final = tuple(
    (re.compile(pattern), cause)
    for pattern, cause in (
        (r"gearbox: backlash", "play"),
        (r"gearbox: (wind-up|stiffness scatter|material scatter)", "stiffness"),
        (r"gearbox: hysteresis", "hysteresis"),
        (r"gearbox: (transmission error|.* per turn)", "transmission error"),
        (r"bearing: axial play", "axial play"),
        (r"bearing: .*(clearance|amount)", "clearance"),
        (r"bearing: .*radial give", "radial stiffness"),
        (r"bearing: axial give", "axial stiffness"),
        (r"bearing: (in|out)board give", "stiffness"),
        (r"bearing: tilt", "moment stiffness"),
        (r"link: (mean )?length", "length tolerance"),
        (r"link: (bending|sag|stiffness)", "stiffness"),
        (r"mount: (give|scatter)", "stiffness"),
        (r"tilt: mean roll", "roll"),
        (r"tilt: mean pitch", "pitch"),
        (r"encoder: mean noise", "noise"),
        (r"encoder: eccentricity", "eccentricity"),
        (r"lumped: (mean )?angle", "angle"),
        (r"lumped: offset", "offset"),
    )
)
# What tells the terms of one cause apart: the two parts of a wave, directions by number.
_PARTNER: Final = re.compile(r" (sine|cosine|\d+)$")
_ALONG: Final = "along"
_AGAINST: Final = "against"
# (kind of part, cause) -> the field that states its size, and its SI unit: along the joint's own motion (rad or m) or against it (stiffness).
_STATED: Final = {
    ("gearbox", "play"): ("play", _ALONG),
    ("gearbox", "stiffness"): ("stiffness", _AGAINST),
    ("gearbox", "hysteresis"): ("hysteresis", _ALONG),
    ("gearbox", "transmission error"): ("transmission_error", _ALONG),
    ("bearing", "clearance"): ("clearance", "m"),
    ("bearing", "axial play"): ("axial_play", "m"),
    ("bearing", "radial stiffness"): ("radial_stiffness", "N/m"),
    ("bearing", "axial stiffness"): ("axial_stiffness", "N/m"),
    ("bearing", "moment stiffness"): ("tilt_stiffness", "N m/rad"),
    ("bearing", "radial runout"): ("radial_runout", "m"),
    ("bearing", "axial runout"): ("axial_runout", "m"),
    ("encoder", "resolution"): ("resolution", _ALONG),
    ("encoder", "noise"): ("noise", _ALONG),
    ("encoder", "eccentricity"): ("eccentricity", _ALONG),
    ("encoder", "zero"): ("zero", _ALONG),
    ("mounting", "axis tilt"): ("tilt", "rad"),
    ("mounting", "axis offset"): ("offset", "m"),
    ("tilt", "roll"): ("roll", "rad"),
    ("tilt", "pitch"): ("pitch", "rad"),
    ("lumped", "angle"): ("angle", _ALONG),
    ("lumped", "offset"): ("offset", "m"),
}
# Of these the tolerance is the size that errs, of all others the nominal value.
_TOLERANCES: Final = ("roll", "pitch")


@dataclass(frozen=True, slots=True)
class Size:
    """A size as the file states it: value in SI, its unit, and whether the error goes with one over it (a stiffness); `zones` of a stiffness."""

    value: float
    unit: str
    divides: bool = False
    zones: int = 1

    def at(self, factor: float) -> float:
        """Give the size at which the error is `factor` times as large."""
        if not self.divides:
            return self.value * factor
        return self.value / factor if factor else float("inf")


@dataclass(frozen=True, slots=True)
class Item:
    """One cause in one part, or in all parts of a kind; `columns` are its terms, `size` None where no one value states it.

    most   the factor on its errors at the largest usual size (`usual`)
    """

    owner: str
    cause: str
    columns: tuple[int, ...]
    size: Size | None = None
    most: float = MOST_TIMES

    @property
    def name(self) -> str:
        """Give the part and the cause ("joints.A.gearbox play")."""
        return self.owner if self.owner.endswith(self.cause) else f"{self.owner} {self.cause}"

    @property
    def kind(self) -> str:
        """Give the kind of part ("gearbox")."""
        return _kind(self.owner)


def items(arm: Arm, infos: Sequence[TermInfo]) -> tuple[Item, ...]:
    """Which sizes make these terms? In walking order; every term belongs to exactly one item."""
    parts: dict[str, tuple[object, bool]] = dict(_parts(arm))
    unknown = (None, False)
    found: dict[tuple[str, str], list[int]] = {}
    for k, info in enumerate(infos):
        source, _ = parts.get(info.owner, unknown)
        found.setdefault((info.owner, _cause(info, source)), []).append(k)
    return tuple(_item(owner, cause, tuple(columns), *parts.get(owner, unknown)) for (owner, cause), columns in found.items())


def _item(owner: str, cause: str, columns: tuple[int, ...], source: object, sliding: bool) -> Item:  # noqa: FBT001 - handed on from `_parts`
    size = _size(owner, cause, source, sliding)
    if size is None or size.divides:
        return Item(owner, cause, columns, size)
    length = source.reach if isinstance(source, Link) else 0.0
    return Item(owner, cause, columns, size, largest_usual_factor(_kind(owner), cause, size.value, size.unit, length))


def alike(each: Iterable[Item]) -> tuple[Item, ...]:
    """Which items stand for the same cause in several parts of a kind? One item for all of them; its size where all have the same."""
    groups: dict[tuple[str, str], list[Item]] = {}
    for item in each:
        groups.setdefault((item.kind, item.cause), []).append(item)
    out = []
    for (kind, cause), members in groups.items():
        if len(members) > 1:
            sizes = {member.size for member in members}
            columns = tuple(column for member in members for column in member.columns)
            most = min(member.most for member in members)
            out.append(Item(f"every {kind},", cause, columns, members[0].size if len(sizes) == 1 else None, most))
    return tuple(out)


def _parts(arm: Arm) -> Iterator[tuple[str, tuple[object, bool]]]:
    """Give every part by its owner's name, and whether it belongs to a sliding joint."""
    yield "base tilt", (arm.base, False)
    yield "base mount", (arm.base, False)
    for joint in arm.joints:
        sliding = isinstance(joint, PrismaticJoint)
        yield f"joints.{joint.name}.mounting", (joint.mounting, sliding)
        yield f"joints.{joint.name}.link", (joint.link, sliding)
        if not isinstance(joint, FixedJoint):
            for name, source in joint.sources.items():
                yield f"joints.{joint.name}.{name}", (source, sliding)


def _kind(owner: str) -> str:
    """Give the kind of part: the word behind the joint's name, or behind the base."""
    return owner.rpartition(".")[2].removeprefix("base ").removeprefix("every ").partition(" ")[0].rstrip(",")


def _cause(info: TermInfo, source: object) -> str:
    kind, name = _kind(info.owner), info.name.removeprefix(f"{info.owner}.")
    if isinstance(source, DrawnBearing) and name.startswith("axial play"):
        return "clearance"  # which in such a bearing is the same thing
    known = next((cause for pattern, cause in _CAUSES if pattern.match(f"{kind}: {name}")), None)
    return known or _PARTNER.sub("", name)


def _size(owner: str, cause: str, source: object, sliding: bool) -> Size | None:  # noqa: FBT001 - handed on from `_parts`
    kind = _kind(owner)
    if (kind, cause) == ("link", "length tolerance"):
        length = getattr(source, "length", None)
        tolerance = (length.tolerance if isinstance(length, Toleranced) else 0.0) or getattr(source, "length_tolerance", None)
        return Size(tolerance, "m") if tolerance else None
    if (kind, cause) not in _STATED or (isinstance(source, DrawnBearing) and cause == "clearance"):
        return None  # by its drawing a bearing does not follow its clearance in proportion
    field, unit = _STATED[kind, cause]
    stated = getattr(source, field, None)
    zones = len(stated) if isinstance(stated, list) else 1
    if isinstance(stated, list) and cause == "stiffness":
        stated = stated[0]
    if isinstance(stated, Toleranced):
        stated = stated.tolerance if field in _TOLERANCES else stated.nominal
    if not isinstance(stated, int | float) or not stated:
        return None
    units = {_ALONG: "m" if sliding else "rad", _AGAINST: "N/m" if sliding else "N m/rad"}
    return Size(float(stated), units.get(unit, unit), "stiffness" in cause, zones)
