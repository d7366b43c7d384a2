"""Positioning of one axis approached from two sides, by ISO 230-2:2014: accuracy, repeatability and
reversal value along a line of measured poses.

The standard is for machine tools; the definitions hold for any motion along a line of the base
frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.iso230 import positioning, reversal

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.io.measured.visits import Visits
    from lostmotion.spatial import Floats

# Fewest target positions and approaches with which the figures are defined.
_FEWEST_POSITIONS: Final = 3
_FEWEST_APPROACHES: Final = 2
_SIDES: Final = 2
# Commanded coordinates (m) that differ by less are equal.
_SAME: Final = 1e-6


@dataclass(frozen=True)
class AxisPositioning:
    """Figures of one axis by ISO 230-2:2014, clause 3, m.

    axis, at             "x", "y" or "z", and the line's other two coordinates by axis, m
    sides                the two sides from which the positions were approached, as the file names
                         them
    positions            target positions along the axis (position,), m, ascending
    approaches           fewest approaches to a position from a side
    mean, deviation      mean deviation and standard deviation (side, position)
    """

    axis: str
    at: dict[str, float]
    sides: tuple[str, str]
    positions: Floats
    approaches: int
    mean: Floats
    deviation: Floats

    @property
    def reversal(self) -> Floats:
        """Return the reversal value B_i at each position (position,)."""
        return reversal(self.mean)

    @property
    def figures(self) -> dict[str, float]:
        """Return the figures by their symbols, as `laws.iso230.positioning`."""
        return {
            name: float(value) for name, value in positioning(self.mean, self.deviation).items()
        }


def axis_positionings(visits: Visits) -> tuple[AxisPositioning, ...]:
    """Return the figures of each line of poses along an axis of the base frame, every pose of which
    was approached from the same two sides.

    visits  visits to poses under one load, with sides and commands
    A line needs three positions and two approaches to each from either side; what has fewer is no
    line.
    """
    rows: dict[str, dict[str, list[int]]] = {}
    for k, (name, side) in enumerate(zip(visits.pose, visits.side, strict=True)):
        if side and np.isfinite(visits.command[k]).all():
            rows.setdefault(name, {}).setdefault(side, []).append(k)
    rows = {
        name: sides
        for name, sides in rows.items()
        if len(sides) == _SIDES and min(map(len, sides.values())) >= _FEWEST_APPROACHES
    }
    command = {name: visits.command[next(iter(sides.values()))[0]] for name, sides in rows.items()}
    out = []
    for axis, names in _lines(command):
        sides = [side for side in dict.fromkeys(visits.side) if side in rows[names[0]]]
        if any(set(rows[name]) != set(sides) for name in names):
            continue
        errors = [
            [visits.attained[rows[name][side], axis] - command[name][axis] for name in names]
            for side in sides
        ]
        out.append(
            AxisPositioning(
                axis="xyz"[axis],
                at={
                    letter: float(command[names[0]][k])
                    for k, letter in enumerate("xyz")
                    if k != axis
                },
                sides=(sides[0], sides[1]),
                positions=np.array([command[name][axis] for name in names]),
                approaches=min(len(each) for of_side in errors for each in of_side),
                mean=np.array([[each.mean() for each in of_side] for of_side in errors]),
                deviation=np.array([[each.std(ddof=1) for each in of_side] for of_side in errors]),
            )
        )
    return tuple(out)


def _lines(command: dict[str, Floats]) -> Iterator[tuple[int, list[str]]]:
    """Yield the axis of each line of poses along an axis, and the names of its poses in ascending
    order.
    """
    for axis in range(3):
        lines: dict[tuple[int, ...], list[str]] = {}
        for name, point in command.items():
            others = tuple(round(float(point[k]) / _SAME) for k in range(3) if k != axis)
            lines.setdefault(others, []).append(name)
        for names in lines.values():
            ordered = sorted(names, key=lambda name: float(command[name][axis]))
            apart = np.diff([command[name][axis] for name in ordered])
            if len(ordered) >= _FEWEST_POSITIONS and (apart > _SAME).all():
                yield axis, ordered
