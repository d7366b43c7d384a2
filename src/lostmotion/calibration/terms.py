"""The complete set of constant errors of a serial chain, and periodic errors of its joints.

A file states the errors that its author expects. A robot may have others: a fit that lacks the tilt
of an axis attributes it to encoders that are right. So every seat is completed to six directions.
Sources: K. Okamura, F. Park, Robotica 14 (1996) 415 (local product of exponentials); L. Everett, M.
Driels, B. Mooring, ICRA 1987.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.laws.distributions import Normal
from lostmotion.mechanism.placed_terms import PlacedTerm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.forms import Constant, Curve, Harmonic, Spring
from lostmotion.parts.term import Draw, Term
from lostmotion.spatial import across

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Law of an added error: normal, without limits.
_LAW: Final = Normal(np.inf)
# A file states a direction where one of its errors is within 25 degrees of it.
_STATED: Final = 0.9
# Range of the size of stated errors over usual ones.
_SCALES: Final = (1 / 32, 8.0)
# Owners of the frames that are not the robot's fault.
BASE: Final = "base frame"
TOOL: Final = "tool frame"


@dataclass(frozen=True)
class Deviations:
    """Standard deviations of errors that the arm's file does not state, rad and m.

    zero                   of a turning joint's zero
    turn, shift            of a joint's axis in its seat
    base_turn, base_shift  of the base frame in the frame of the instrument
    tool_turn, tool_shift  of the tool frame; a turn of zero: a tool point without orientation
    harmonic               amplitude of a periodic error of a joint, rad, of which order n has the
                           share 1 / sqrt(1 + (n/16)^2)
    orders                 highest order of these, cycles per turn; 0: none
    compliance             of a turning joint whose file states no scatter of its stiffness,
                           rad/(N m); 0: none
    """

    zero: float = 1e-3
    turn: float = 0.5e-3
    shift: float = 0.3e-3
    base_turn: float = 10e-3
    base_shift: float = 10e-3
    tool_turn: float = 0.0
    tool_shift: float = 3e-3
    harmonic: float = 0.04e-3
    orders: int = 0
    compliance: float = 0.0


def is_frame(owner: str) -> bool:
    """Return whether the part is the base or tool frame, which a user may set."""
    return owner in {BASE, TOOL}


def is_harmonic(owner: str) -> bool:
    """Return whether the part is the periodic error that a calibration adds to a joint."""
    return owner.endswith(".harmonics")


def is_seat(owner: str) -> bool:
    """Return whether the part is a seat, of which a calibration adds what the file does not
    state.
    """
    return owner.endswith(".seat")


def is_compliance(owner: str) -> bool:
    """Return whether the part is the compliance that a calibration adds to a joint."""
    return owner.endswith(".compliance")


def is_added(owner: str) -> bool:
    """Return whether a calibration added the part, which the arm's file does not state."""
    return any(kind(owner) for kind in (is_frame, is_harmonic, is_seat, is_compliance))


def stated_scale(arm: Arm, sizes: Deviations) -> float:
    """Return how large the constant errors of the arm's file are, as a geometric mean over those
    of `sizes`; 1 where the file states none.
    """
    ratios = []
    for of in arm.calibrated(None).terms:
        form = of.term.form
        if of.term.level == "robot" and isinstance(form, Constant) and not form.reads:
            turn = np.linalg.norm(form.direction[:3])
            usual = sizes.turn if turn else sizes.shift
            ratios.append(abs(of.term.scale) * (turn or np.linalg.norm(form.direction[3:])) / usual)
    positive = [ratio for ratio in ratios if ratio > 0]
    if not positive:
        return 1.0
    return float(np.clip(np.exp(np.mean(np.log(positive))), *_SCALES))


def added_terms(arm: Arm, sizes: Deviations) -> tuple[PlacedTerm, ...]:
    """Return the errors that complete those of the arm's file: the base frame, the directions of
    each seat between base and tool that the file does not state, periodic errors, and the tool
    frame.

    A seat that is fixed to the base has none: they are those of the base frame.
    """
    tree, at = arm.tree, state_of(arm, arm.limits.mean(axis=1)).frames[:, 0]
    out = _frame(BASE, "base", 0, sizes.base_turn, sizes.base_shift)
    carrier = None  # the last moving place inboard
    for place in tree.tool_path:
        joint = tree.places[place].joint
        if joint is None:
            continue
        owner = f"joints.{arm.driven[joint].name}"
        seat = tree.places[place].parent
        if carrier is not None:
            stated = _stated(arm, at, carrier, seat, place)
            twist = tree.places[place].twist[:, 0]
            out += _seat(f"{owner}.seat", joint, seat, twist, stated, sizes)
        out += _harmonics(f"{owner}.harmonics", joint, place, tree.places[place].twist[:, 0], sizes)
        out += _compliance(arm, f"{owner}.compliance", joint, place, sizes.compliance)
        carrier = place
    return (*out, *_frame(TOOL, "link", len(tree.places) - 1, sizes.tool_turn, sizes.tool_shift))


def _frame(owner: str, kind: str, place: int, turn: float, shift: float) -> list[PlacedTerm]:
    named = [(f"turn {axis}", turn) for axis in "xyz"] + [(f"shift {a}", shift) for a in "xyz"]
    return [
        PlacedTerm(
            owner, kind, None, place, _constant(name, owner.removeprefix(f"{kind} "), row, size)
        )
        for row, (name, size) in zip(np.eye(6), named, strict=True)
        if size
    ]


def _seat(
    owner: str, joint: int, seat: int, twist: Floats, stated: Sequence[Floats], sizes: Deviations
) -> list[PlacedTerm]:
    axis = twist[:3] if twist[:3].any() else twist[3:]
    first, second = across(axis)
    none = np.zeros(3)
    directions = {
        "tilt 1": (first, none),
        "tilt 2": (second, none),
        "turn": (axis, none),
        "offset 1": (none, first),
        "offset 2": (none, second),
        "shift": (none, axis),
    }
    return [
        PlacedTerm(
            owner,
            "mounting",
            joint,
            seat,
            _constant(
                name,
                f"axis {name.split()[0]}",
                np.concatenate(way),
                _size(name, way, turning=bool(twist[:3].any()), sizes=sizes),
            ),
        )
        for name, way in directions.items()
        if not any(_along(each, *way) for each in stated)
    ]


def _size(name: str, way: tuple[Floats, Floats], *, turning: bool, sizes: Deviations) -> float:
    if turning and name == "turn":
        return sizes.zero
    return sizes.turn if way[0].any() else sizes.shift


def _along(screw: Floats, turn: Floats, shift: Floats) -> bool:
    """Return whether a screw states this direction; one that turns states its turn alone."""
    if turn.any():
        return bool(abs(screw[:3] @ turn) > _STATED * np.linalg.norm(screw[:3]))
    if screw[:3].any():
        return False
    return bool(abs(screw[3:] @ shift) > _STATED * np.linalg.norm(screw[3:]))


def _stated(arm: Arm, at: Floats, carrier: int, seat: int, moved: int) -> list[Floats]:
    """Return the directions (6,) in the axes of a seat, turn and shift, that the file states: of
    constant errors on the body that carries the seat, and of those along the joint's own motion.
    """
    places, out = arm.tree.places, []
    between, twist = [seat], places[moved].twist[:, 0]
    while between[-1] != carrier:
        between.append(places[between[-1]].parent)
    for of in arm.calibrated(None).terms:
        if of.term.level != "robot" or of.term.form.reads or not isinstance(of.term.form, Constant):
            continue
        screw = of.term.form.direction
        own = of.place == moved and _same(screw, twist)
        carried = of.place in between and not (
            of.place == carrier and _same(screw, places[carrier].twist[:, 0])
        )
        if own or carried:
            axes = at[seat, :3, :3].T @ at[of.place, :3, :3]
            out.append(np.concatenate([axes @ screw[:3], axes @ screw[3:]]))
    return out


def _same(screw: Floats, twist: Floats) -> bool:
    return bool(np.linalg.matrix_rank(np.stack([screw, twist])) == 1)


def _harmonics(
    owner: str, joint: int, place: int, twist: Floats, sizes: Deviations
) -> list[PlacedTerm]:
    phases: tuple[Literal["sine", "cosine"], ...] = ("sine", "cosine")
    if not twist[:3].any():
        return []
    return [
        PlacedTerm(
            owner,
            "encoder",
            joint,
            place,
            Term(
                f"{phase} {order}",
                "periodic error",
                Harmonic(twist, order, phase),
                sizes.harmonic / np.sqrt(1 + (order / 16) ** 2),
                robot=Draw(f"{phase} {order}", _LAW),
                effect=f"order {order}",
            ),
        )
        for order in range(1, sizes.orders + 1)
        for phase in phases
    ]


def _compliance(arm: Arm, owner: str, joint: int, place: int, size: float) -> list[PlacedTerm]:
    """Return the compliance of a turning joint, unless the file states how its stiffness
    scatters.
    """
    twist = arm.tree.places[place].twist[:, 0]
    drawn = any(
        of.place == place and of.term.level == "robot" and isinstance(of.term.form, Spring)
        for of in arm.calibrated(None).terms
    )
    if drawn or not size or not twist[:3].any():
        return []
    curve = Curve(np.array([0.0, 1.0]), np.array([0.0, 1.0]), 1.0)
    draw = Draw("per torque", _LAW)
    term = Term("per torque", "wind-up", Spring(twist, curve), size, robot=draw)
    return [PlacedTerm(owner, "gearbox", joint, place, term)]


def joint_torques(arm: Arm, q: Floats) -> Floats:
    """Return the torques about the turning joints between base and tool (pose, joint), N m."""
    state, tree = state_of(arm, q), arm.tree
    turning = [
        place
        for place in tree.tool_path
        if tree.places[place].joint is not None and tree.places[place].twist[:3, 0].any()
    ]
    found = [state.wrenches[place] @ tree.places[place].twist[:, 0] for place in turning]
    return np.stack(found, axis=1) if found else np.zeros((len(q), 0))


def _constant(name: str, cause: str, direction: Floats, size: float) -> Term:
    return Term(name, cause, Constant(direction), size, robot=Draw(name, _LAW))
