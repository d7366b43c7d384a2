"""The places of an arm that its controller needs: fixed places without errors are combined with
their parents, and every joint moves along its z.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lostmotion.controller_model.tables import Record
from lostmotion.spatial import across, inverse

if TYPE_CHECKING:
    from collections.abc import Set as AbstractSet

    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats


class Places(NamedTuple):
    """Records without error terms, and for the arm's places the index of the record and the pose in
    it.

    number  index of the record of each place of the arm
    pose    (4, 4) pose of each place of the arm in the axes of its record, m
    """

    records: tuple[Record, ...]
    number: tuple[int, ...]
    pose: tuple[Floats, ...]


def places_of(tree: Tree, with_terms: AbstractSet[int]) -> Places:
    """Return the records of a tree; places with indices in `with_terms` have errors and keep a
    record of their own, as do joints, base and tool.
    """
    records: list[Record] = []
    number: list[int] = []
    pose: list[Floats] = []
    last = len(tree.places) - 1
    for k, place in enumerate(tree.places):
        if place.parent < 0:
            records.append(
                Record(place.name, -1, -1, slides=False, carries_tool=True, pose=np.eye(4))
            )
            number.append(0)
            pose.append(np.eye(4))
            continue
        parent, fixed = number[place.parent], pose[place.parent]
        if place.joint is None:
            fixed = fixed @ place.pose
            if k not in with_terms and k != last:
                number.append(parent)
                pose.append(fixed)
                continue
        turned = np.eye(4) if place.joint is None else along_z(place.twist[:, 0])
        records.append(
            Record(
                place.name,
                parent,
                -1 if place.joint is None else place.joint,
                slides=place.joint is not None and not place.twist[:3].any(),
                carries_tool=k in tree.tool_path,
                pose=fixed @ turned,
            )
        )
        number.append(len(records) - 1)
        pose.append(inverse(turned))
    return Places(_with_masses(tree, records, number, pose), tuple(number), tuple(pose))


def along_z(twist: Floats) -> Floats:
    """Return a rotation (4, 4) that turns z into the direction of a joint's unit motion (6,)."""
    axis = twist[:3] if twist[:3].any() else twist[3:]
    out = np.eye(4)
    if axis[2] < 1.0:
        first, second = across(axis)
        out[:3, :3] = np.column_stack([first, second, axis])
    return out


def _with_masses(
    tree: Tree, records: list[Record], number: list[int], pose: list[Floats]
) -> tuple[Record, ...]:
    mass, moment = np.zeros(len(records)), np.zeros((len(records), 3))
    for weight in tree.masses:
        # A mass is stated in the axes of one place and loads another one, which is fixed to it.
        here, at = np.eye(4), weight.at
        while at != weight.on:
            here = tree.places[at].pose @ here
            at = tree.places[at].parent
        here = pose[weight.on] @ here
        centre = here[:3, :3] @ weight.centre + here[:3, 3]
        mass[number[weight.on]] += weight.mass
        moment[number[weight.on]] += weight.mass * centre
    return tuple(
        Record(
            each.name,
            each.parent,
            each.joint,
            each.slides,
            each.carries_tool,
            each.pose,
            float(m),
            c,
        )
        for each, m, c in zip(records, mass, moment, strict=True)
    )
