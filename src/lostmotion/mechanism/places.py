"""Places of a mechanism: frames with parents, and the masses attached to them."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.parts.frame import unit
from lostmotion.parts.joint import has_axis

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.mechanism.closures import Closure
    from lostmotion.mechanism.tool import Tool
    from lostmotion.parts.joint import Joint
    from lostmotion.spatial import Floats


# Suffixes of the three places of a joint: before its motion, after it, and the far end of its link.
_ENDS: Final = (".seat", "", ".tip")


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A frame of the mechanism.

    parent  index of the place that it is fixed to, or moves relative to; -1 for the base
    pose    (4, 4) pose relative to the parent, m, of a frame that is fixed to it
    joint   index of the driven joint between the parent and this frame, which is its column in q;
            None for a frame without a drive
    twist   (6, n) unit motions by the n freedoms between them, in the frame's own axes: none for a
            fixed frame, one for a driven joint, any number for a passive one
    """

    name: str
    parent: int
    pose: Floats = field(default_factory=functools.partial(np.eye, 4))
    joint: int | None = None
    twist: Floats = field(default_factory=functools.partial(np.zeros, (6, 0)))


@dataclass(frozen=True, slots=True, eq=False)
class PlacedMass:
    """A mass (kg) with its centre (3,), m, in the frame of the place with index `at`; it loads the
    place `on` and all places inboard of it.
    """

    at: int
    on: int
    mass: float
    centre: Floats


class JointPlaces(NamedTuple):
    """Indices of the three places of a joint: its seat before the motion, the frame after it, and
    the far end of its link.
    """

    seat: int
    moved: int
    tip: int


class PassivePlace(NamedTuple):
    """A place that a passive joint moves: its index, the joint's name, its motion (4, 4) at home,
    roughly, the limits of its value (rad or m), and the largest angle of a cone with its axis (3,).
    """

    place: int
    joint: str
    start: Floats
    limits: tuple[float, float] | None = None
    cone: tuple[float, Floats] | None = None


class Weld(NamedTuple):
    """Two frames that are one: indices of two places, and a fixed frame (4, 4) in each."""

    places: tuple[int, int]
    frames: tuple[Floats, Floats]


@dataclass(frozen=True, eq=False)
class Tree:
    """The places of an arm and the masses on them.

    places   the base is place 0, a parent has a lower index than its children, and the tool is the
             last place
    masses   of joints, links and tool, without the payload
    joints   places of each joint, moving or fixed, in the order of the arm's joints
    passive  places that passive joints move, in rising order
    welds    closures: frames that are one
    home     values of the driven joints at which the closed chain is first assembled, rad or m
    """

    places: tuple[Place, ...]
    masses: tuple[PlacedMass, ...]
    joints: tuple[JointPlaces, ...]
    passive: tuple[PassivePlace, ...] = ()
    welds: tuple[Weld, ...] = ()
    home: tuple[float, ...] = ()

    @functools.cached_property
    def tool_path(self) -> tuple[int, ...]:
        """Return the indices of the places from the base to the tool, both included."""
        out = [len(self.places) - 1]
        while out[-1]:
            out.append(self.places[out[-1]].parent)
        return tuple(reversed(out))

    @functools.cached_property
    def moves_tool(self) -> frozenset[int]:
        """Return the indices of the places whose errors can move the tool: those that carry it, and
        those within closed loops.
        """
        ends = (len(self.places) - 1, *(place for weld in self.welds for place in weld.places))
        return frozenset().union(*(self.inboard(place) for place in ends))

    @functools.cached_property
    def moved(self) -> tuple[int, ...]:
        """Return the index of the place that each driven joint moves, in the order of q."""
        return tuple(number for number, place in enumerate(self.places) if place.joint is not None)

    @functools.cached_property
    def tool_joints(self) -> tuple[int, ...]:
        """Return the indices of the joints that move the tool, which are their columns in q."""
        return tuple(
            joint
            for number in sorted(self.moves_tool)
            if (joint := self.places[number].joint) is not None
        )

    @property
    def loads_are_outboard(self) -> bool:
        """Return whether what loads a place is outboard of it: no closure shares the loads."""
        return not self.welds

    def loading(self, place: int) -> frozenset[int]:
        """Return the indices of the places whose masses load this one."""
        return (
            self.outboard(place) if self.loads_are_outboard else frozenset(range(len(self.places)))
        )

    def inboard(self, place: int) -> frozenset[int]:
        """Return the indices of a place and of all places that carry it."""
        out = {place}
        while place:
            place = self.places[place].parent
            out.add(place)
        return frozenset(out)

    def outboard(self, place: int) -> frozenset[int]:
        """Return the indices of a place and of all places that it carries."""
        out = {place}
        for k in range(place + 1, len(self.places)):
            if self.places[k].parent in out:
                out.add(k)
        return frozenset(out)


class Misplaced(NamedTuple):
    """An `after` that names no place: the path of its key, its value, and the names that are
    possible there.
    """

    path: tuple[str | int, ...]
    after: str
    known: tuple[str, ...]


def misplaced(joints: Sequence[Joint], tool: Tool) -> list[Misplaced]:
    """Return each `after` of joints and tool that does not name exactly one earlier place."""
    out, known = [], ["base"]
    for k, joint in enumerate(joints):
        if joint.after is not None and known.count(joint.after) != 1:
            out.append(Misplaced(("joints", k, "after"), joint.after, tuple(known)))
        known += [f"{joint.name}{end}" for end in _ENDS]
    if tool.after is not None and known.count(tool.after) != 1:
        out.append(Misplaced(("tool", "after"), tool.after, tuple(known)))
    return out


def tool_moves(joints: Sequence[Joint], tool: Tool) -> bool:
    """Return whether a moving joint is between the base and the tool. Every `after` must name an
    earlier place.
    """
    number = {f"{joint.name}{end}": k for k, joint in enumerate(joints) for end in _ENDS}
    after = tool.after or f"{joints[-1].name}.tip"
    while after != "base":
        k = number[after]
        if joints[k].type != "fixed" and after != f"{joints[k].name}.seat":
            return True  # a passive joint too: loops move it
        after = joints[k].after or (f"{joints[k - 1].name}.tip" if k else "base")
    return False


def tree_of(
    foot: Floats, joints: Sequence[Joint], tool: Tool, closures: Sequence[Closure] = ()
) -> Tree:
    """Return the places of these joints and of the tool, the masses on them, and the closures.

    foot (4, 4): pose of the foot of the arm in the base's frame, m. A joint without `after` is
    attached to the tip of the previous joint, the first one to the base; a tool without `after` to
    the tip of the last joint. Raises KeyError where `after` names no earlier place.
    """
    places, masses, units, passive, home = [Place("base", -1)], [], [], [], []
    number = {"base": 0}

    def add(place: Place) -> int:
        number.setdefault(place.name, len(places))
        places.append(place)
        return len(places) - 1

    end = column = 0
    for joint in joints:
        on = end if joint.after is None else number[joint.after]
        seat = add(
            Place(f"{joint.name}.seat", on, joint.origin.pose if on else foot @ joint.origin.pose)
        )
        if joint.type == "fixed":
            moved = add(Place(joint.name, seat))
        elif joint.passive:
            moved = seat
            names = [f"{joint.name}.cross"] * (len(joint.freedoms) - 1) + [joint.name]
            for name, freedom, start, limits in zip(
                names, joint.freedoms, joint.at_start, _ranges(joint), strict=True
            ):
                moved = add(Place(name, moved, twist=freedom))
                passive.append(PassivePlace(moved, joint.name, start, limits, _cone(joint)))
        else:
            moved = add(Place(joint.name, seat, joint=column, twist=joint.twist[:, None]))
            home.append(float(np.mean(joint.limits)) if joint.start is None else joint.start)
            column += 1
        end = add(Place(f"{joint.name}.tip", moved, joint.link.tip_pose))
        units.append(JointPlaces(seat, moved, end))
        # The housing is fixed to the seat: it loads the place that the joint is attached to, not
        # the joint's own bearing.
        masses.append(PlacedMass(seat, on, joint.total_mass, np.array(joint.centre_of_mass)))
        masses.append(
            PlacedMass(
                moved, moved, joint.link.total_mass, np.asarray(joint.link.mass_centre, dtype=float)
            )
        )
    on = end if tool.after is None else number[tool.after]
    last = add(Place("tool", on, tool.frame.pose if on else foot @ tool.frame.pose))
    masses.append(PlacedMass(last, last, tool.mass, tool.mass_centre))
    return Tree(
        tuple(places),
        tuple(each for each in masses if each.mass),
        tuple(units),
        tuple(passive),
        tuple(
            Weld(
                (number[each.joins[0]], number[each.joins[1]]),
                (each.frames[0].pose, each.frames[1].pose),
            )
            for each in closures
        ),
        tuple(home),
    )


def _ranges(joint: Joint) -> tuple[tuple[float, float] | None, ...]:
    """Return the limits of each step of a passive joint."""
    if joint.type == "universal":
        return joint.limits
    return (joint.limits if has_axis(joint) else None,)


def _cone(joint: Joint) -> tuple[float, Floats] | None:
    """Return the largest angle of a ball joint, and its axis."""
    if joint.type != "spherical" or joint.cone is None:
        return None
    return joint.cone, unit(joint.axis)
