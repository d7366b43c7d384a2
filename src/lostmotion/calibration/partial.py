"""Instruments that see one number of each pose: a distance, a touch on a plane or a sphere, a dial
gauge, an inclinometer. Each has unknowns of its own, with wide priors.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from lostmotion.calibration.instruments import (
    Instrument,
    Rows,
    rotation_vector,
    turned_by_twist,
)
from lostmotion.spatial import across

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Self

    from numpy.typing import NDArray

    from lostmotion.calibration.instruments import Readings
    from lostmotion.spatial import Floats

# Prior deviations of an instrument's unknowns, m and rad: of places, of their turn, of a zero.
PLACE: Final = 0.1
TURN: Final = 0.1
ZERO: Final = 0.01
# A rotation is as much less precise than a length as a level of this length makes it, m.
LEVEL: Final = 0.1


@dataclass(frozen=True, eq=False)
class _OneNumber(Instrument):
    """An instrument with one row for each pose.

    names   of the targets
    target  (pose,) number of the target of each pose
    value   (pose,) reading, m or rad
    """

    _turns: ClassVar[bool] = False
    names: tuple[str, ...]
    target: NDArray[np.int64]
    value: Floats

    @property
    def noise(self) -> Floats:
        """Return one."""
        return np.ones(1)

    def part(self, rows: NDArray[np.int64]) -> Self:
        """Return the measurement at the poses in these rows."""
        return replace(self, target=self.target[rows], value=self.value[rows])

    @property
    @abstractmethod
    def _each(self) -> tuple[tuple[str, float], ...]:
        """Return the unknowns of each target with their deviations."""

    @property
    def unknowns(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return the unknowns of all targets."""
        return tuple(f"{name} {each}" for name in self.names for each, _ in self._each)

    def size(self, unknown: int) -> tuple[float, str]:
        """Return the deviation of an unknown with its unit."""
        name, deviation = self._each[unknown % len(self._each)]
        return deviation, "rad" if self._turns or name.startswith("turn") else "m"

    def _rows(self, predicted: Floats, by_twist: Floats, by_each: Floats) -> Rows:
        """Return the rows, from the derivatives by the unknowns of each pose's own target (pose,
        unknown), per unit.
        """
        count, size = len(predicted), len(self._each)
        deviations = np.array([deviation for _, deviation in self._each])
        by_unknown = np.zeros((count, 1, len(self.names) * size))
        for k in range(size):
            at = self.target * size + k
            by_unknown[np.arange(count), 0, at] = by_each[:, k] * deviations[k]
        return Rows((self.value - predicted)[:, None], by_twist[:, None], by_unknown)

    def _own(self, unknowns: Floats) -> Floats:
        """Return the unknowns of each pose's target (pose, unknown), m and rad."""
        deviations = np.array([deviation for _, deviation in self._each])
        return np.asarray(unknowns.reshape(len(self.names), -1)[self.target] * deviations)


def _along(direction: Floats) -> Floats:
    """Return the derivative by a twist (pose, 6) of the position along a direction (pose, 3)."""
    return np.concatenate([np.zeros_like(direction), direction], axis=1)


@dataclass(frozen=True, eq=False)
class Distances(_OneNumber):
    """Distances from the tool point to fixed centres by a bar or a draw wire with an unknown zero;
    or, with `touch`, touches of spheres of a known radius.

    centre  (target, 3) first estimate of each centre, m
    """

    centre: Floats
    touch: bool = False

    @property
    def _each(self) -> tuple[tuple[str, float], ...]:
        places = tuple((axis, PLACE) for axis in "xyz")
        return places if self.touch else (*places, ("zero", ZERO))

    def rows(self, frames: Floats, unknowns: Floats) -> Rows:
        """Return the rows: the distance."""
        own = self._own(unknowns)
        beside = frames[:, :3, 3] - self.centre[self.target] - own[:, :3]
        distance = np.linalg.norm(beside, axis=1)
        way = beside / distance[:, None]
        zero = np.zeros(len(own)) if self.touch else own[:, 3]
        by_each = np.concatenate([-way, np.ones((len(own), own.shape[1] - 3))], axis=1)
        return self._rows(distance + zero, _along(way), by_each)


@dataclass(frozen=True, eq=False)
class Planes(_OneNumber):
    """Touches of planes, by a probe or a cube: the tool point lies in the plane.

    centre  (target, 3) a point near the touches, m
    normal  (target, 3) first estimate of the normal
    """

    centre: Floats
    normal: Floats

    @property
    def _each(self) -> tuple[tuple[str, float], ...]:
        return (("turn 1", TURN), ("turn 2", TURN), ("offset", PLACE))

    def rows(self, frames: Floats, unknowns: Floats) -> Rows:
        """Return the rows: the distance from the plane."""
        own = self._own(unknowns)
        first, second = (np.array([across(n)[k] for n in self.normal])[self.target] for k in (0, 1))
        whole = self.normal[self.target] + own[:, :1] * first + own[:, 1:2] * second
        length = np.linalg.norm(whole, axis=1)[:, None]
        normal = whole / length
        beside = frames[:, :3, 3] - self.centre[self.target]
        height = (normal * beside).sum(axis=1)
        turned = [
            ((beside - height[:, None] * normal) * way).sum(axis=1) / length[:, 0]
            for way in (first, second)
        ]
        by_each = np.stack([*turned, -np.ones(len(own))], axis=1)
        return self._rows(height - own[:, 2], _along(normal), by_each)


@dataclass(frozen=True, eq=False)
class _FromNominal(_OneNumber):
    """Deviations from the nominal tool along or about axes of the base, with unknown zeros.

    nominal  (pose, ...) nominal tool points, m, or orientations
    axis     (target, 3)
    zero     (target,) first estimate of each zero, m or rad
    """

    nominal: Floats
    axis: Floats
    zero: Floats

    def part(self, rows: NDArray[np.int64]) -> Self:
        """Return the measurement at the poses in these rows."""
        return replace(super().part(rows), nominal=self.nominal[rows])


class Dials(_FromNominal):
    """Deviations of the tool point along axes of the base, by dial gauges with unknown zeros; from
    nominal tool points (pose, 3), m.
    """

    @property
    def _each(self) -> tuple[tuple[str, float], ...]:
        return (("zero", ZERO),)

    def rows(self, frames: Floats, unknowns: Floats) -> Rows:
        """Return the rows: the deviation along the axis."""
        own, way = self._own(unknowns), self.axis[self.target]
        moved = ((frames[:, :3, 3] - self.nominal) * way).sum(axis=1)
        return self._rows(
            moved + self.zero[self.target] + own[:, 0], _along(way), np.ones((len(own), 1))
        )


class Inclinometers(_FromNominal):
    """Rotations of the tool about axes of the base from its nominal orientation (pose, 3, 3), with
    unknown zeros.
    """

    _turns: ClassVar[bool] = True

    @property
    def noise(self) -> Floats:
        """Return what a level of `LEVEL` resolves."""
        return np.array([1 / LEVEL])

    @property
    def _each(self) -> tuple[tuple[str, float], ...]:
        return (("zero", TURN),)

    def rows(self, frames: Floats, unknowns: Floats) -> Rows:
        """Return the rows: the part of the rotation vector along the axis."""
        own, way = self._own(unknowns), self.axis[self.target]
        turned = rotation_vector(frames[:, :3, :3] @ self.nominal.transpose(0, 2, 1))
        by_turn = (way[:, None] @ turned_by_twist(turned))[:, 0]
        by_twist = np.concatenate([by_turn, np.zeros_like(way)], axis=1)
        angle = (turned * way).sum(axis=1) + self.zero[self.target] + own[:, 0]
        return self._rows(angle, by_twist, np.ones((len(own), 1)))


def instrument_of(readings: Readings, frames: Floats) -> Instrument:
    """Return the instrument of these readings; its unknowns start from the nominal frames of the
    tool (pose, 4, 4).
    """
    names = tuple(dict.fromkeys(readings.target))
    target = np.array([names.index(name) for name in readings.target])
    value = np.asarray(readings.value, dtype=float)
    points = frames[:, :3, 3]
    if readings.kind == "plane":
        centre = _each(points, target, lambda own: own.mean(axis=0))
        normal = _each(points, target, _normal)
        return Planes(names, target, np.zeros(len(target)), centre, normal)
    if readings.kind in {"dial", "angle"}:
        axis = np.array([np.eye(3)["xyz".index(name)] for name in names])
        # most of a constant reading is a zero, and no error of the arm
        zero = _each(value, target, np.median)
        if readings.kind == "dial":
            return Dials(names, target, value, points, axis, zero)
        return Inclinometers(names, target, value, frames[:, :3, :3], axis, zero)
    touch = readings.kind == "sphere"
    centre = np.array([_centre(points[target == k], value[target == k]) for k in range(len(names))])
    return Distances(names, target, value, centre, touch)


def _each(
    values: Floats, target: NDArray[np.int64], of: Callable[[Floats], Floats | np.floating]
) -> Floats:
    return np.array([of(values[target == k]) for k in range(int(target.max()) + 1)])


def _normal(points: Floats) -> Floats:
    return np.asarray(np.linalg.svd(points - points.mean(axis=0))[2][2])


def _centre(points: Floats, distance: Floats) -> Floats:
    """Return the centre (3,) of least squares from points at these distances (pose,).

    |p|^2 - d^2 = 2 p.c - |c|^2 is linear in c and |c|^2.
    """
    columns = np.column_stack([2 * points, -np.ones(len(points))])
    square = (points**2).sum(axis=1) - distance**2
    return np.asarray(np.linalg.lstsq(columns, square, rcond=None)[0][:3])
