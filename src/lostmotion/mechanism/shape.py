"""Shape of an arm for pictures: simple bodies, each fixed to a place, sized by the sections of the
links.

Every picture of an arm (report, live view, `check`, notebook) draws `arm.bodies`. They are computed
once per arm. At a pose, a body is at `frames(arm, q)[body.place] @ body.pose`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.parts.joint import has_axis
from lostmotion.parts.outer_size import OuterPiece, outer_sizes
from lostmotion.spatial import across

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.mechanism.places import JointPlaces, Tree
    from lostmotion.mechanism.tool import Payload
    from lostmotion.parts.joint import Joint
    from lostmotion.parts.outer_size import Size
    from lostmotion.spatial import Floats

Kind = Literal["base", "link", "offset", "joint", "rail", "tool", "payload"]
Form = Literal["round", "box", "sphere"]

# Diameter of a link without a section: these shares of the arm's length, the second in proportion
# to the length that is still outboard.
_THIN: Final = 0.035
_THICKER: Final = 0.035
# Multiples of the thickest link that a joint touches: diameter and length of the joint, diameter of
# an offset and of the column under the first joint, width of a rail; diameter and thickness of the
# plate that replaces a column of no height.
_JOINT, _JOINT_LENGTH, _OFFSET, _COLUMN, _RAIL = 1.12, 1.3, 0.8, 1.3, 0.6
_PLATE: Final = (1.7, 0.25)
# Diameters of the tool point and of the payload's centre of mass, as shares of the arm's length.
_TOOL, _PAYLOAD = 0.016, 0.03
# Cosine of the angle between axis and link above which the body of a joint lies around the
# beginning of its link, and the share of the body's length that is before the seat.
_COAXIAL, _BEFORE = 0.95, 0.1
_SIDES: Final = 48
# Shorter distances (m) are rounding, and no bar is drawn.
_NOTHING: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A convex body that is fixed to a place of the arm. In its own axes it is centred at zero, and
    z is along its length.

    name    "A.link", "A.offset" and "A.rail" for joint A, "A" for the body of the joint itself,
            "A.base", "tool", "payload"
    kind    an offset connects a joint to the previous link where the file states a distance between
            them; a rail shows the travel of a slide
    form    round (cylinder or frustum of a cone), box, or sphere
    place   index of the place that it is fixed to, in the order of `arm.places`
    pose    (4, 4) in the frame of the place, m
    near    width along x and height along y (m) at the end where z is negative
    far     width and height (m) at the other end
    length  along z, m
    stated  whether the size comes from a stated section; otherwise it is chosen to fit the arm
    """

    name: str
    kind: Kind
    form: Form
    place: int
    pose: Floats
    near: Size
    far: Size
    length: float
    stated: bool = False

    def corners(self, sides: int = _SIDES) -> Floats:
        """Return points (corner, 3) in the frame of the place, m, whose convex hull is the body;
        circles are inscribed polygons of `sides` sides.
        """
        box = self.form == "box"
        angle = (
            2 * np.pi * (np.arange(4) + 0.5) / 4 if box else 2 * np.pi * np.arange(sides) / sides
        )
        ring = np.column_stack([np.cos(angle), np.sin(angle)]) / (np.sqrt(2.0) if box else 2.0)
        if self.form == "sphere":
            rising = np.linspace(-np.pi / 2, np.pi / 2, sides // 2 + 1)
            layers = [
                (np.multiply(self.near, cos), height)
                for cos, height in zip(np.cos(rising), np.sin(rising), strict=True)
            ]
        else:
            layers = [(np.array(self.near), -1.0), (np.array(self.far), 1.0)]
        points = np.concatenate(
            [
                np.column_stack([ring * size, np.full(len(ring), height * self.length / 2)])
                for size, height in layers
            ]
        )
        return np.asarray(points @ self.pose[:3, :3].T + self.pose[:3, 3])

    def corners_at(self, at: Floats) -> Floats:
        """Return `corners` (corner, 3) in the base's frame, m, with the body's place at the frame
        `at` (4, 4).
        """
        return np.asarray(self.corners() @ at[:3, :3].T + at[:3, 3])

    def silhouette(self, at: Floats, view: Floats) -> Floats:
        """Return the outline (corner, 2) of the body in parallel projection, counter-clockwise, m.

        at    (4, 4) frame of the body's place
        view  (2, 3) directions in the base's frame that point to the right and upwards in the
              picture, unit and perpendicular
        """
        from scipy.spatial import ConvexHull

        flat = self.corners_at(at) @ view.T
        return np.asarray(flat[ConvexHull(flat).vertices])


def bodies_of(tree: Tree, joints: Sequence[Joint], payload: Payload) -> tuple[Body, ...]:
    """Return the bodies of an arm: base, links, offsets, joints, rails, tool point, and the
    payload's centre of mass where it has a mass.

    A link has the outer sizes of its section. Steps and tapers are bodies in a row. A link without
    a section is a round bar whose diameter is a share of the arm's length. Joints are sized by the
    links that they touch. A sliding joint is a rail as long as its travel, and a carriage on it.
    """
    made = _Shape(tree, joints)
    out = [
        body
        for joint, at in zip(joints, tree.joints, strict=True)
        for body in made.of_joint(joint, at)
    ]
    return (*out, *made.of_closures(tree), *made.of_tool(payload))


class _Shape:
    """The sizes that the bodies of one arm share."""

    def __init__(self, tree: Tree, joints: Sequence[Joint]) -> None:
        self.places = places = tree.places
        steps = [
            float(np.linalg.norm(place.pose[:3, 3])) if place.parent > 0 else 0.0
            for place in places
        ]
        travel = [float(np.ptp(joint.limits)) for joint in joints if joint.type == "prismatic"]
        self.length = sum(steps) + sum(travel) or 1.0
        self._outboard = [
            sum(steps[k] for k in tree.outboard(place)) / self.length
            for place in range(len(places))
        ]
        # of the link that ends at a place, by the index of this place
        self._thickness: dict[int, float] = {}

    def of_joint(self, joint: Joint, at: JointPlaces) -> list[Body]:
        """Return the bodies of a joint: what connects its seat to the parent, the joint itself, and
        its link.
        """
        parent = self.places[at.seat].parent
        chosen = self.length * (_THIN + _THICKER * self._outboard[at.moved])
        pieces = _link_pieces(joint, chosen) if joint.link.reach else []
        before = self._thickness.get(parent, 0.0)
        size = max(min(pieces[0].near) if pieces else 0.0, before) or chosen
        self._thickness[at.tip] = min(pieces[-1].far) if pieces else before
        own = _of_motion(joint, at, size)
        return [*self._of_seat(joint, at.seat, size), *own, *_of_link(joint, at, pieces)]

    def _of_seat(self, joint: Joint, seat: int, size: float) -> list[Body]:
        """Return what connects a seat to its parent: an offset bar, or from the base a column on
        its level z = 0, or a plate there.
        """
        place = self.places[seat]
        to_seat = place.pose[:3, 3]
        if place.parent:
            return (
                [
                    _bar(
                        f"{joint.name}.offset",
                        "offset",
                        place.parent,
                        np.zeros(3),
                        to_seat,
                        _OFFSET * size,
                    )
                ]
                if np.linalg.norm(to_seat) > _NOTHING
                else []
            )
        foot = np.array([*to_seat[:2], 0.0])
        wide, thick = _PLATE
        if abs(to_seat[2]) > thick * size:
            return [_bar(f"{joint.name}.base", "base", 0, foot, to_seat, _COLUMN * size)]
        return [
            _bar(
                f"{joint.name}.base",
                "base",
                0,
                to_seat - [0.0, 0.0, thick * size],
                to_seat,
                wide * size,
            )
        ]

    def of_closures(self, tree: Tree) -> list[Body]:
        """Return bars from the places that closures join to the frames that meet there."""
        return [
            _bar(
                f"{self.places[place].name}.closure",
                "offset",
                place,
                np.zeros(3),
                frame[:3, 3],
                _OFFSET * self.length * _THIN,
            )
            for weld in tree.welds
            for place, frame in zip(weld.places, weld.frames, strict=True)
            if np.linalg.norm(frame[:3, 3]) > _NOTHING
        ]

    def of_tool(self, payload: Payload) -> list[Body]:
        """Return the tool's bar, the tool point and the payload's centre of mass."""
        last = len(self.places) - 1
        place = self.places[last]
        size = self._thickness.get(place.parent) or self.length * _THIN
        out = []
        if place.parent and np.linalg.norm(place.pose[:3, 3]) > _NOTHING:
            out.append(
                _bar("tool", "tool", place.parent, np.zeros(3), place.pose[:3, 3], _OFFSET * size)
            )
        out.append(_ball("tool point", "tool", last, np.zeros(3), _TOOL * self.length))
        if payload.mass:
            out.append(
                _ball(
                    "payload",
                    "payload",
                    last,
                    np.array(payload.centre_of_mass),
                    _PAYLOAD * self.length,
                )
            )
        return out


def _of_motion(joint: Joint, at: JointPlaces, size: float) -> list[Body]:
    """Return the body of a joint: a cylinder along the axis of a turning joint, rail and carriage
    of a sliding one, a ball of a ball or universal joint, none where nothing is.
    """
    if joint.type in {"spherical", "universal"}:
        return [_ball(joint.name, "joint", at.seat, np.zeros(3), _JOINT * size)]
    if not has_axis(joint):
        return []
    length = _JOINT_LENGTH * size
    if joint.type == "revolute":
        axis = joint.twist[:3]
        direction = joint.link.tip_pose[:3, 3] / (joint.link.reach or 1.0)
        along = float(axis @ direction)
        middle = np.zeros(3)
        if abs(along) > _COAXIAL:
            length = min(length, joint.link.reach / 2)
            middle = np.sign(along) * axis * (0.5 - _BEFORE) * length
        return [
            _bar(
                joint.name,
                "joint",
                at.seat,
                middle - axis * length / 2,
                middle + axis * length / 2,
                _JOINT * size,
            )
        ]
    axis, (low, high) = joint.twist[3:], joint.limits
    turned, wide = _along(axis), (_RAIL * size, _RAIL * size)
    carriage = (_JOINT * size, _JOINT * size)
    rail = Body(
        f"{joint.name}.rail",
        "rail",
        "box",
        at.seat,
        _posed(turned, axis * (low + high) / 2),
        wide,
        wide,
        high - low,
    )
    return [
        rail,
        Body(
            joint.name,
            "joint",
            "box",
            at.moved,
            _posed(turned, np.zeros(3)),
            carriage,
            carriage,
            length,
        ),
    ]


def _link_pieces(joint: Joint, chosen: float) -> list[OuterPiece]:
    """Return the pieces of a link; without a section one round piece of the chosen diameter."""
    reach, section = joint.link.reach, joint.link.section
    return (
        [OuterPiece(0.0, reach, "round", (chosen, chosen), (chosen, chosen))]
        if section is None
        else outer_sizes(section, reach)
    )


def _of_link(joint: Joint, at: JointPlaces, pieces: Sequence[OuterPiece]) -> list[Body]:
    """Return the bodies of a link, one for each piece."""
    if not pieces:
        return []
    along, width, height = joint.link.beam_axes(joint.elastic_link.joint_axis).T
    turned = np.column_stack([width, height, along])
    stated = joint.link.section is not None
    return [
        Body(
            f"{joint.name}.link",
            "link",
            piece.form,
            at.moved,
            _posed(turned, along * piece.middle),
            piece.near,
            piece.far,
            piece.length,
            stated,
        )
        for piece in pieces
    ]


def _bar(name: str, kind: Kind, place: int, start: Floats, end: Floats, diameter: float) -> Body:
    """Return a round bar from one point to another, in the frame of the place."""
    length = float(np.linalg.norm(end - start))
    pose = _posed(_along((end - start) / length), (start + end) / 2)
    return Body(
        name, kind, "round", place, pose, (diameter, diameter), (diameter, diameter), length
    )


def _ball(name: str, kind: Kind, place: int, centre: Floats, diameter: float) -> Body:
    return Body(
        name,
        kind,
        "sphere",
        place,
        _posed(np.eye(3), centre),
        (diameter, diameter),
        (diameter, diameter),
        diameter,
    )


def _along(axis: Floats) -> Floats:
    """Return a rotation (3, 3) whose third column is this unit axis."""
    return np.column_stack([*across(axis), axis])


def _posed(rotation: Floats, centre: Floats) -> Floats:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation, centre
    return out
