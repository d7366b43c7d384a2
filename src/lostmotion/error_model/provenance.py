"""State of each kind of error source of every joint: stated, assumed, or ideal where the arm file
does not describe it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

from lostmotion.error_model.assumed_drives import presets_of_arm
from lostmotion.error_model.given_values import (
    any_assumed,
    assumed_among,
    assumed_count,
    bounded_members,
    given_in,
)
from lostmotion.error_model.required_kinds import ELASTIC, required_kinds
from lostmotion.errors import InputError, Problem
from lostmotion.parts.joint import has_axis, has_drive
from lostmotion.parts.provenance import DEFAULT, Sourced, value_keys

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.error_model.given_values import AssumedValue, GivenValue
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.calibration import StatedEstimate
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

# The keys of a gearbox that describe each kind of error. The first list decides whether the kind is
# described; the second also decides whether it is assumed.
_OF_GEARBOX: Final = {
    "backlash": (("backlash", "lost_motion"), ("lost_motion_torque",)),
    "stiffness": (("stiffness", "rigid"), ("zone_torques", "stiffness_scatter")),
    "hysteresis": (("hysteresis", "hysteresis_scatter"), ()),
}
_OF_ENCODER: Final = ("resolution", "noise", "eccentricity", "zero", "scale_error")
_OF_GUIDEWAY: Final = ("straightness", "pitch", "yaw", "roll")
_OF_LUMPED: Final = ("angle", "offset")
_OF_MOUNT: Final = ("angular_stiffness", "linear_stiffness", "compliance", "tracks")
# Keys of a bearing that state only its size, and so describe no error.
_SIZES_OF_BEARING: Final = frozenset({"span", "pitch_diameter", "closing_force"})


@dataclass(frozen=True, slots=True)
class LimitShare:
    """A value of a gearbox that is its maker's upper limit, with the shares of its error in two
    mean squares.

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
    """The state of each kind of error source of one joint; a kind that the joint cannot have is
    omitted, and a servo that is not described.

    required  kinds that a real joint and link of this sort must have (`required_kinds`)
    """

    joint: str
    states: Mapping[str, State]
    required: tuple[str, ...] = ()

    @property
    def missing(self) -> tuple[str, ...]:
        """Return the kinds that a real joint must have and that nothing describes, in the order of
        the table.
        """
        return tuple(
            kind for kind in KINDS if kind in self.required and self.states.get(kind) == "ideal"
        )

    @property
    def ideal(self) -> bool:
        """Return whether no error source at all is described for this joint."""
        return all(state == "ideal" for state in self.states.values())


@dataclass(frozen=True, slots=True)
class States:
    """The states of the error sources of an arm.

    joints   states of every joint that moves the tool, in order
    fixed    states of fixed joints between base and tool that have a link, or whose mounting is
             described
    base     states of the base's tilt and mount
    assumed  every assumed value; a value that several joints share is listed once, under the name
             of the shared part, else the first joint
    given    every value of the arm, stated or assumed, in the order of its parts; shared ones as in
             `assumed`
    bounded  members of drawn gearboxes that their drawings do not describe, so that only bounds of
             them are known
    moved_by_temperature  whether a link expands or bends at a stated temperature
    estimates  of the errors of one robot
    presets  that all drives are, by name; empty where any value of one is stated
    limits   maker's upper limits that count at the poses of a study (`upper_limits.with_limits`),
             the largest contributor first
    """

    joints: tuple[JointStates, ...]
    fixed: tuple[JointStates, ...]
    base: Mapping[str, State]
    assumed: tuple[AssumedValue, ...]
    moved_by_temperature: bool = False
    limits: tuple[LimitShare, ...] = ()
    given: tuple[GivenValue, ...] = ()
    bounded: tuple[str, ...] = ()
    estimates: tuple[StatedEstimate, ...] = ()
    presets: tuple[str, ...] = ()

    @property
    def assumed_count(self) -> int:
        """Return on how many assumed sources the arm rests (`assumed_count`)."""
        return assumed_count(self.assumed, self.bounded)

    @property
    def ideal_joints(self) -> tuple[str, ...]:
        """Return the names of the moving joints without any error source, which are modelled as
        perfect.
        """
        return tuple(each.joint for each in self.joints if each.ideal)

    @property
    def ideal_kinds(self) -> tuple[str, ...]:
        """Return the kinds of error that at least one moving joint does not describe. A lumped
        error stands for other kinds and is not listed.
        """
        return tuple(
            kind
            for kind in KINDS
            if kind != "lumped" and any(each.states.get(kind) == "ideal" for each in self.joints)
        )

    @property
    def missing(self) -> dict[str, tuple[str, ...]]:
        """Return by joint the kinds of error that a real one must have, and that nothing describes:
        with any, every figure is a lower bound.
        """
        return {each.joint: each.missing for each in (*self.joints, *self.fixed) if each.missing}

    @property
    def lower_bound(self) -> bool:
        """Return whether the figures of the arm lack errors that a real one must have."""
        return bool(self.missing)

    @property
    def described(self) -> bool:
        """Return whether the arm has any error source: without one no accuracy can be predicted."""
        ideal = all(each.ideal for each in (*self.joints, *self.fixed)) and all(
            state == "ideal" for state in self.base.values()
        )
        return self.moved_by_temperature or not ideal


def states(arm: Arm) -> States:
    """Return the state of every kind of error source of an arm, and its assumed values.

    A kind is "ideal" where no value describes it, "assumed" where any value that describes it is
    assumed (marked in the file, a catalogue's upper limit, a typical material), and "stated"
    otherwise. A zero in the file, and `rigid = true`, count as stated: they declare the kind ideal.
    A default does not describe a kind; used together with stated values, it is listed among the
    assumed ones. Joints on a branch are excluded, since their errors do not move the tool.
    """
    on_tool_path = [
        joint
        for joint, places in zip(arm.joints, arm.tree.joints, strict=True)
        if places.moved in arm.tree.moves_tool
    ]
    found = [(joint, _states_of(joint)) for joint in on_tool_path]
    given = tuple(given_in(arm))
    moving = {joint.name for joint in arm.moving}
    known = arm.calibration
    return States(
        joints=tuple(each for joint, each in found if joint.name in moving),
        fixed=tuple(
            each
            for joint, each in found
            if joint.name not in moving and (each.required or not each.ideal)
        ),
        base=_of_base(arm.base),
        estimates=() if known is None else known.stated(arm.calibrated(None).terms),
        assumed=assumed_among(given),
        given=given,
        presets=presets_of_arm(arm),
        bounded=tuple(
            dict.fromkeys(
                member
                for joint in on_tool_path
                for member in bounded_members(getattr(joint, "gearbox", None))
            )
        ),
        moved_by_temperature=any(
            joint.link.bends_with_temperature
            or (joint.link.expands and arm.environment.temperature is not None)
            for joint in on_tool_path
        ),
    )


def of_compliance(known: States) -> States:
    """Return states that require only kinds of error that make an arm compliant."""

    def elastic(each: JointStates) -> JointStates:
        return replace(each, required=tuple(kind for kind in each.required if kind in ELASTIC))

    return replace(
        known, joints=tuple(map(elastic, known.joints)), fixed=tuple(map(elastic, known.fixed))
    )


def part_states(part: Sourced, kind: str) -> dict[str, State]:
    """Return the state of each kind of error of a gearbox or a bearing by itself; `kind` is
    "gearbox" or "bearing".
    """
    return (
        _of_gearbox(part, whole=False)
        if kind == "gearbox"
        else {kind: _of_bearing(part, whole=False)}
    )


def refuse_undescribed(arm: Arm) -> None:
    """Raise InputError for an arm without any error source, whose accuracy cannot be predicted; the
    message states what to add, and where.
    """
    if not states(arm).described:
        joint = arm.driven[0]
        backlash = "20 µm" if joint.type == "prismatic" else "1 arcmin"
        expected = (
            "the gearbox, bearing, encoder or link of at least one joint; `lostmotion study "
            "FILE` prints lines to fill in for every joint, "
            "and shows workspace and holding torques"
        )
        raise InputError(
            [
                Problem(
                    arm.name,
                    f"joints.{joint.name}",
                    NOT_DESCRIBED,
                    expected,
                    f'gearbox = {{ backlash = "{backlash}" }}',
                )
            ]
        )


def _states_of(joint: Joint) -> JointStates:
    found = _of_joint(joint)
    return JointStates(
        joint.name, found, required_kinds(joint, lumped=found.get("lumped", "ideal") != "ideal")
    )


def _of_joint(joint: Joint) -> dict[str, State]:
    found: dict[str, State] = {}
    if joint.type == "spherical":
        found["bearing"] = _state(joint.bearing, ("clearance",), whole="bearing" in joint.assumed)
    elif has_axis(joint):
        if not joint.passive:
            found |= _of_gearbox(joint.gearbox, whole="gearbox" in joint.assumed)
        found["bearing"] = _of_bearing(joint.bearing, whole="bearing" in joint.assumed)
        if joint.type == "prismatic":
            found["guideway"] = _state(
                joint.guideway, _OF_GUIDEWAY, whole="guideway" in joint.assumed
            )
    if has_drive(joint):
        found["encoder"] = _state(
            joint.encoder, _OF_ENCODER, ("ratio",), whole="encoder" in joint.assumed
        )
        if joint.servo is not None:
            found["servo"] = _state(joint.servo, ("dead_band",), whole="servo" in joint.assumed)
        found["lumped"] = _state(
            joint.lumped, _OF_LUMPED, _all(joint.lumped), whole="lumped" in joint.assumed
        )
    found["axis mounting"] = _state(
        joint.mounting, _all(joint.mounting), whole="mounting" in joint.assumed
    )
    found |= _of_link(joint.link, whole="link" in joint.assumed)
    return {kind: found[kind] for kind in KINDS if kind in found}


def _of_gearbox(gearbox: Sourced | None, *, whole: bool) -> dict[str, State]:
    if gearbox is not None and gearbox.by_drawing:
        drawn: State = "assumed" if whole or any_assumed(gearbox, elastic=False) else "stated"
        springs: State = "assumed" if whole or any_assumed(gearbox) else "stated"
        has_friction = _state(gearbox, ("friction", "friction_torque")) != "ideal"
        return {
            "backlash": drawn,
            "stiffness": springs,
            "hysteresis": drawn if has_friction else "ideal",
            "transmission error": drawn,
        }
    own: Mapping[str, tuple[str, ...]] = getattr(gearbox, "described_by", {})
    out = {
        kind: _state(gearbox, (*main, *own.get(kind, ())), besides, whole=whole)
        for kind, (main, besides) in _OF_GEARBOX.items()
    }
    errors = [
        name for name in _all(gearbox) if name == "transmission_error" or name.endswith("_error")
    ]
    return {**out, "transmission error": _state(gearbox, errors, whole=whole)}


def _of_bearing(bearing: Sourced | None, *, whole: bool) -> State:
    if bearing is not None and bearing.by_drawing:
        return "assumed" if whole or any_assumed(bearing) else "stated"
    names = _all(bearing)
    return _state(
        bearing, [name for name in names if name not in _SIZES_OF_BEARING], names, whole=whole
    )


def _of_link(link: Link, *, whole: bool) -> dict[str, State]:
    if not link.reach:
        return {}
    length: State = "ideal"
    named = {"length_tolerance", "tip_tolerance"}
    if link.length.tolerance or named & link.model_fields_set or link.process is not None:
        length = "assumed" if whole or {"length", *named} & set(link.assumptions) else "stated"
    bending = _state(
        link, ("section", "compliance", "measured", "rigid"), ("material",), whole=whole
    )
    return {"link bending": bending, "link length": length}


def _of_base(base: Base) -> dict[str, State]:
    tilt: State = "ideal"
    if base.roll.tolerance or base.pitch.tolerance:
        tilt = "assumed" if {"roll", "pitch"} & set(base.assumed) else "stated"
    return {"tilt": tilt, "mount": _state(base, _OF_MOUNT, ())}


def _state(
    part: Sourced | None,
    main: tuple[str, ...] | list[str],
    besides: tuple[str, ...] | list[str] = (),
    *,
    whole: bool = False,
) -> State:
    """Return the state of the kind of error that these keys of a part describe; `whole`: the joint
    marks the whole part as assumed.
    """
    if part is None:
        return "ideal"
    values = {
        name: getattr(part, name) for name in (*main, *besides) if name in part.model_fields_set
    }
    given = {
        name: value for name, value in values.items() if value is not None and value is not False
    }
    if not any(name in given for name in main):
        return "ideal"
    assumed = whole or any(
        name in _assumed_keys(part) or any_assumed(value) for name, value in given.items()
    )
    return "assumed" if assumed else "stated"


def _all(part: Sourced | None) -> list[str]:
    return [] if part is None else value_keys(type(part))


def _assumed_keys(part: Sourced) -> set[str]:
    """Return the keys of the values in the file that are assumed; defaults, which are not in the
    file, are excluded.
    """
    return {key for key, reason in part.assumptions.items() if not reason.startswith(DEFAULT)}
