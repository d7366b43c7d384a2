"""Places of a mechanism: frames with parents, and the masses attached to them."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

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
            fixed frame, one for a driven joint
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


@dataclass(frozen=True, eq=False)
class Tree:
    """The places of an arm and the masses on them.

    places   the base is place 0, a parent has a lower index than its children, and the tool is the
             last place
    masses   of joints, links and tool, without the payload
    joints   places of each joint, moving or fixed, in the order of the arm's joints
    """

    places: tuple[Place, ...]
    masses: tuple[PlacedMass, ...]
    joints: tuple[JointPlaces, ...]

    @functools.cached_property
    def tool_path(self) -> tuple[int, ...]:
        """Return the indices of the places from the base to the tool, both included."""
        out = [len(self.places) - 1]
        while out[-1]:
            out.append(self.places[out[-1]].parent)
        return tuple(reversed(out))

    @functools.cached_property
    def moved(self) -> tuple[int, ...]:
        """Return the index of the place that each driven joint moves, in the order of q."""
        return tuple(number for number, place in enumerate(self.places) if place.joint is not None)

    @functools.cached_property
    def tool_joints(self) -> tuple[int, ...]:
        """Return the indices of the joints that move the tool, which are their columns in q."""
        return tuple(
            joint for number in self.tool_path if (joint := self.places[number].joint) is not None
        )

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
            return True
        after = joints[k].after or (f"{joints[k - 1].name}.tip" if k else "base")
    return False


def tree_of(foot: Floats, joints: Sequence[Joint], tool: Tool) -> Tree:
    """Return the places of these joints and of the tool, and the masses on them.

    foot (4, 4): pose of the foot of the arm in the base's frame, m. A joint without `after` is
    attached to the tip of the previous joint, the first one to the base; a tool without `after` to
    the tip of the last joint. Raises KeyError where `after` names no earlier place.
    """
    places, masses, units = [Place("base", -1)], [], []
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
        else:
            moved = add(Place(joint.name, seat, joint=column, twist=joint.twist[:, None]))
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
    return Tree(tuple(places), tuple(each for each in masses if each.mass), tuple(units))
