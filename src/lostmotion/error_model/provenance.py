"""State of each kind of error source of every joint: stated, assumed, or ideal where the arm file does not describe it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from lostmotion.errors import InputError, Problem
from lostmotion.parts.error_source import Part
from lostmotion.parts.provenance import ASSUMED, DEFAULT, Sourced, value_keys

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.base import Base
    from lostmotion.parts.joint import Joint
    from lostmotion.parts.link import Link

State = Literal["stated", "assumed", "ideal"]
NOT_DESCRIBED: Final = "no error source is described, so no accuracy can be predicted"

# The kinds of error source that a joint may have, in the order of the table.
KINDS: Final = (
    "backlash",
    "stiffness",
    "hysteresis",
    "transmission error",
    "bearing",
    "guideway",
    "encoder",
    "servo",
    "axis mounting",
    "link bending",
    "link length",
    "lumped",
)

# The keys of a gearbox that describe each kind of error. The first list decides whether the kind is described; the second also decides whether it
# is assumed.
_OF_GEARBOX: Final = {
    "backlash": (("backlash", "lost_motion"), ("lost_motion_torque",)),
    "stiffness": (("stiffness",), ("zone_torques", "stiffness_scatter")),
    "hysteresis": (("hysteresis", "hysteresis_scatter"), ()),
}
_OF_ENCODER: Final = ("resolution", "noise", "eccentricity", "zero", "scale_error")
_OF_GUIDEWAY: Final = ("straightness", "pitch", "yaw", "roll")
_OF_LUMPED: Final = ("angle", "offset")
_OF_MOUNT: Final = ("angular_stiffness", "linear_stiffness", "compliance", "tracks")
# Key of links and materials that counts only where a temperature is stated.
_EXPANSION: Final = "expansion"
# Keys of a bearing that state only its size, and so describe no error.
_SIZES_OF_BEARING: Final = frozenset({"span", "pitch_diameter", "closing_force"})


@dataclass(frozen=True, slots=True)
class LimitShare:
    """A value of a gearbox that is its maker's upper limit, with the shares of its error in two mean squares.

    key        field of the gearbox ("backlash")
    of_error   share of the mean-square error
    of_repeat  share of the mean square between visits
    """

    joint: str
    model: str
    key: str
    of_error: float
    of_repeat: float


@dataclass(frozen=True, slots=True)
class JointStates:
    """The state of each kind of error source of one joint; a kind that the joint cannot have is omitted, and a servo that is not described."""

    joint: str
    states: Mapping[str, State]

    @property
    def ideal(self) -> bool:
        """Return whether no error source at all is described for this joint."""
        return all(state == "ideal" for state in self.states.values())


@dataclass(frozen=True, slots=True)
class AssumedValue:
    """An assumed value: the part that has it ("joints.A.gearbox", or "gearboxes.RV"), its key, why it counts as assumed, and its source."""

    owner: str
    key: str
    reason: str
    source: str = ""


@dataclass(frozen=True, slots=True)
class GivenValue:
    """A value that went in: the part that has it ("joints.A.gearbox", or a shared "gearboxes.RV"), its key, and the class of parts whose field it is.

    value   as the part holds it, in SI; None where the part has no value of its own, and computes one
    reason  why it counts as assumed; empty for a stated one
    whole   whether its part as a whole is marked as assumed; then it counts there, once
    """

    owner: str
    key: str
    part: type[Part]
    value: object
    reason: str = ""
    source: str = ""
    whole: bool = False

    @property
    def state(self) -> str:
        """Return "stated", or why it counts as assumed."""
        return self.reason or (ASSUMED if self.whole else "stated")


@dataclass(frozen=True, slots=True)
class States:
    """The states of the error sources of an arm.

    joints   states of every joint that moves the tool, in order
    fixed    states of fixed joints between base and tool whose link or mounting is described
    base     states of the base's tilt and mount
    assumed  every assumed value; a value that several joints share is listed once, under the name of the shared part, else the first joint
    given    every value of the arm, stated or assumed, in the order of its parts; shared ones as in `assumed`
    moved_by_temperature  whether a link expands or bends at a stated temperature
    limits   maker's upper limits that count at the poses of a study (`upper_limits.with_limits`), the largest contributor first
    """

    joints: tuple[JointStates, ...]
    fixed: tuple[JointStates, ...]
    base: Mapping[str, State]
    assumed: tuple[AssumedValue, ...]
    moved_by_temperature: bool = False
    limits: tuple[LimitShare, ...] = ()
    given: tuple[GivenValue, ...] = ()

    @property
    def ideal_joints(self) -> tuple[str, ...]:
        """Return the names of the moving joints without any error source, which are modelled as perfect."""
        return tuple(each.joint for each in self.joints if each.ideal)

    @property
    def ideal_kinds(self) -> tuple[str, ...]:
        """Return the kinds of error that at least one moving joint does not describe. A lumped error stands for other kinds and is not listed."""
        return tuple(kind for kind in KINDS if kind != "lumped" and any(each.states.get(kind) == "ideal" for each in self.joints))

    @property
    def described(self) -> bool:
        """Return whether the arm has any error source: without one no accuracy can be predicted."""
        ideal = all(each.ideal for each in (*self.joints, *self.fixed)) and all(state == "ideal" for state in self.base.values())
        return self.moved_by_temperature or not ideal


def states(arm: Arm) -> States:
    """Return the state of every kind of error source of an arm, and its assumed values.

    A kind is "ideal" where no value describes it, "assumed" where any value that describes it is assumed (marked in the file, a catalogue's upper
    limit, a typical material), and "stated" otherwise. A zero in the file counts as stated. A default does not describe a kind; where it is used
    together with stated values, it is listed among the assumed values. Joints on a branch are excluded, since their errors do not move the tool.
    """
    on_tool_path = [joint for joint, places in zip(arm.joints, arm.tree.joints, strict=True) if places.moved in arm.tree.tool_path]
    found = [(joint, JointStates(joint.name, _of_joint(joint))) for joint in on_tool_path]
    given = tuple(_given_in(arm))
    return States(
        joints=tuple(each for joint, each in found if joint.type != "fixed"),
        fixed=tuple(each for joint, each in found if joint.type == "fixed" and not each.ideal),
        base=_of_base(arm.base),
        assumed=_assumed(given),
        given=given,
        moved_by_temperature=any(
            joint.link.bends_with_temperature or (joint.link.expands and arm.environment.temperature is not None) for joint in on_tool_path
        ),
    )


def given_in_part(part: object, owner: str) -> tuple[GivenValue, ...]:
    """Return every value of one part and of the parts that it consists of; `owner` is the name of the part, for example "gearbox"."""
    return tuple(value for value, _ in _walk(part, owner, ""))


def assumed_in_part(part: object, owner: str) -> tuple[AssumedValue, ...]:
    """Return every assumed value of one part and of the parts that it consists of; `owner` as in `given_in_part`."""
    return _assumed(given_in_part(part, owner))


def _assumed(given: Iterable[GivenValue]) -> tuple[AssumedValue, ...]:
    return tuple(AssumedValue(each.owner, each.key, each.reason, each.source) for each in given if each.reason)


def part_states(part: Sourced, kind: str) -> dict[str, State]:
    """Return the state of each kind of error of a gearbox or a bearing by itself; `kind` is "gearbox" or "bearing"."""
    return _of_gearbox(part, whole=False) if kind == "gearbox" else {kind: _of_bearing(part, whole=False)}


def refuse_undescribed(arm: Arm) -> None:
    """Raise InputError for an arm without any error source, whose accuracy cannot be predicted; the message states what to add, and where."""
    if not states(arm).described:
        joint = arm.moving[0]
        backlash = "20 µm" if joint.type == "prismatic" else "1 arcmin"
        expected = (
            "the gearbox, bearing, encoder or link of at least one joint; `lostmotion study FILE` prints lines to fill in for every joint, "
            "and shows workspace and holding torques"
        )
        raise InputError([Problem(arm.name, f"joints.{joint.name}", NOT_DESCRIBED, expected, f'gearbox = {{ backlash = "{backlash}" }}')])


def _of_joint(joint: Joint) -> dict[str, State]:
    found: dict[str, State] = {}
    if joint.type != "fixed":
        found |= _of_gearbox(joint.gearbox, whole="gearbox" in joint.assumed)
        found["bearing"] = _of_bearing(joint.bearing, whole="bearing" in joint.assumed)
        if joint.type == "prismatic":
            found["guideway"] = _state(joint.guideway, _OF_GUIDEWAY, whole="guideway" in joint.assumed)
        found["encoder"] = _state(joint.encoder, _OF_ENCODER, ("ratio",), whole="encoder" in joint.assumed)
        if joint.servo is not None:
            found["servo"] = _state(joint.servo, ("dead_band",), whole="servo" in joint.assumed)
        found["lumped"] = _state(joint.lumped, _OF_LUMPED, _all(joint.lumped), whole="lumped" in joint.assumed)
    found["axis mounting"] = _state(joint.mounting, _all(joint.mounting), whole="mounting" in joint.assumed)
    found |= _of_link(joint.link, whole="link" in joint.assumed)
    return {kind: found[kind] for kind in KINDS if kind in found}


def _of_gearbox(gearbox: Sourced | None, *, whole: bool) -> dict[str, State]:
    if gearbox is not None and gearbox.by_drawing:
        drawn: State = "assumed" if whole or _any_assumed(gearbox, elastic=False) else "stated"
        springs: State = "assumed" if whole or _any_assumed(gearbox) else "stated"
        has_friction = _state(gearbox, ("friction", "friction_torque")) != "ideal"
        return {"backlash": drawn, "stiffness": springs, "hysteresis": drawn if has_friction else "ideal", "transmission error": drawn}
    own: Mapping[str, tuple[str, ...]] = getattr(gearbox, "described_by", {})
    out = {kind: _state(gearbox, (*main, *own.get(kind, ())), besides, whole=whole) for kind, (main, besides) in _OF_GEARBOX.items()}
    errors = [name for name in _all(gearbox) if name == "transmission_error" or name.endswith("_error")]
    return {**out, "transmission error": _state(gearbox, errors, whole=whole)}


def _of_bearing(bearing: Sourced | None, *, whole: bool) -> State:
    if bearing is not None and bearing.by_drawing:
        return "assumed" if whole or _any_assumed(bearing) else "stated"
    names = _all(bearing)
    return _state(bearing, [name for name in names if name not in _SIZES_OF_BEARING], names, whole=whole)


def _of_link(link: Link, *, whole: bool) -> dict[str, State]:
    if not link.reach:
        return {}
    length: State = "ideal"
    named = {"length_tolerance", "tip_tolerance"}
    if link.length.tolerance or named & link.model_fields_set or link.process is not None:
        length = "assumed" if whole or {"length", *named} & set(link.assumptions) else "stated"
    bending = _state(link, ("section", "compliance", "measured", "rigid"), ("material",), whole=whole)
    return {"link bending": bending, "link length": length}


def _of_base(base: Base) -> dict[str, State]:
    tilt: State = "ideal"
    if base.roll.tolerance or base.pitch.tolerance:
        tilt = "assumed" if {"roll", "pitch"} & set(base.assumed) else "stated"
    return {"tilt": tilt, "mount": _state(base, _OF_MOUNT, ())}


def _state(part: Sourced | None, main: tuple[str, ...] | list[str], besides: tuple[str, ...] | list[str] = (), *, whole: bool = False) -> State:
    """Return the state of the kind of error that these keys of a part describe; `whole`: the joint marks the whole part as assumed."""
    if part is None:
        return "ideal"
    given = {name: getattr(part, name) for name in (*main, *besides) if name in part.model_fields_set and getattr(part, name, None) is not None}
    if not any(name in given for name in main):
        return "ideal"
    assumed = whole or any(name in _assumed_keys(part) or _any_assumed(value) for name, value in given.items())
    return "assumed" if assumed else "stated"


def _all(part: Sourced | None) -> list[str]:
    return [] if part is None else value_keys(type(part))


def _assumed_keys(part: Sourced) -> set[str]:
    """Return the keys of the values in the file that are assumed; defaults, which are not in the file, are excluded."""
    return {key for key, reason in part.assumptions.items() if not reason.startswith(DEFAULT)}


def _any_assumed(value: object, *, elastic: bool = True) -> bool:
    """Return whether any value in a part is assumed; without `elastic`, the values of materials, which enter only its stiffness, are excluded."""
    return any(each.reason and not each.reason.startswith(DEFAULT) and (elastic or not holder.elastic_only) for each, holder in _walk(value, "", ""))


def _given_in(arm: Arm) -> Iterator[GivenValue]:
    """Yield every value of an arm, once also where several joints share the part that it belongs to."""
    seen: set[tuple[str, str]] = set()
    names: dict[int, str] = {}
    places: list[tuple[str, object]] = [("base", arm.base), ("tool", arm.tool), ("payload", arm.payload), ("environment", arm.environment)]
    places += [(f"joints.{joint.name}", joint) for joint in arm.joints]
    for owner, part in places:
        for value, holder in _walk(part, owner, ""):
            if holder.shareable and id(holder) not in names:
                names[id(holder)] = repr(holder)
            key = (names.get(id(holder), value.owner), value.key)
            if key not in seen and (value.key != _EXPANSION or arm.has_temperatures):
                seen.add(key)
                yield value


def _walk(value: object, owner: str, source: str, *, whole: bool = False) -> Iterator[tuple[GivenValue, Part]]:
    """Yield the values of a part and of the parts that it consists of, each with the part that has it; `whole` as in `GivenValue`."""
    if isinstance(value, tuple | list):
        for index, each in enumerate(value, 1):
            yield from _walk(each, f"{owner}.{index}", source, whole=whole)
    if not isinstance(value, Part):
        return
    owner = value.shared_name or owner
    assumptions: dict[str, str] = {}
    preset = None
    if isinstance(value, Sourced):
        source = value.source or source
        assumptions = value.assumptions
        preset = getattr(value, "preset", None)
    model = type(value)
    inner = {name: getattr(value, name) for name in value_keys(model)}
    for key in [*(key for key in inner if key in value.model_fields_set and key not in assumptions), *assumptions]:
        reason, held = assumptions.get(key, ""), inner.get(key)
        if not reason and (held is None or _has_parts(held)):
            continue
        # The source that the file quotes for its own values is not the source of a default.
        origin = preset.source if preset is not None and key in preset.keys else "" if reason.startswith(DEFAULT) else source
        yield GivenValue(owner, key, model, None if _has_parts(held) else held, reason, origin, whole), value
    for name, held in inner.items():
        yield from _walk(held, f"{owner}.{name}", source, whole=whole or assumptions.get(name) == ASSUMED)


def _has_parts(value: object) -> bool:
    """Return whether a value is a part or consists of parts, whose own values are listed."""
    return isinstance(value, Part) or (isinstance(value, tuple | list) and any(isinstance(each, Part) for each in value))
