"""What an instrument sees of the tool: rows of a measurement, with their derivatives.

Every instrument is a function of the frame of the tool and of unknowns of its own. Derivatives are
by the twist of the tool about the tool point in the base's axes, and by the unknowns.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Final, NamedTuple

import numpy as np

from lostmotion.spatial import exp, right_jacobian, skew

if TYPE_CHECKING:
    from typing import Self

    from numpy.typing import NDArray

    from lostmotion.spatial import Floats

# A full pose is measured by targets about so far from the tool point, m: rotations are as much less
# precise than positions.
TARGET_RADIUS: Final = 0.1


@dataclass(frozen=True, eq=False)
class MeasuredVisits:
    """Visits of one robot to poses, in SI.

    q           (visit, joint) commanded values of the driven joints, rad or m
    point       (visit, 3) attained tool point in any fixed frame, m; None: a difference is measured
    difference  (visit, 3) attained less commanded tool point, m, or the reverse; None: a point is
    rotation    (visit, 3, 3) attained orientation of the tool; None: not measured
    approach    (visit, joint) sign of the last motion; zero where it is not stated
    readings    one number of each visit, in place of points and differences
    time        (visit,) by any clock, s; None: not recorded
    payload     (visit,) mass at the tool, kg; None: that of the arm's file
    signed      whether the differences are known to be attained less commanded
    sets        (visit,) name of the set-up of the instrument; None: one for all visits
    """

    q: Floats
    point: Floats | None = None
    difference: Floats | None = None
    rotation: Floats | None = None
    approach: Floats | float = 0.0
    readings: Readings | None = None
    time: Floats | None = None
    payload: Floats | None = None
    signed: bool = False
    sets: NDArray[np.str_] | None = None

    def __len__(self) -> int:
        """Return the number of visits."""
        return len(self.q)

    @property
    def by_set(self) -> dict[str, NDArray[np.int64]]:
        """Return the rows of each set-up by its name, that with the most rows first; all rows
        without a name where none is stated.
        """
        if self.sets is None:
            return {"": np.arange(len(self))}
        names = dict.fromkeys(map(str, self.sets))
        found = {name: np.flatnonzero(self.sets == name) for name in names}
        return dict(sorted(found.items(), key=lambda each: -len(each[1])))

    def rows(self, kept: NDArray[np.int64]) -> Self:
        """Return the visits in these rows."""

        def part(values: Floats | None) -> Floats | None:
            return None if values is None else values[kept]

        read, approach = self.readings, self.approach
        return replace(
            self,
            q=self.q[kept],
            point=part(self.point),
            difference=part(self.difference),
            rotation=part(self.rotation),
            approach=approach[kept] if isinstance(approach, np.ndarray) else approach,
            readings=None if read is None else read.rows(kept),
            time=part(self.time),
            payload=part(self.payload),
            sets=None if self.sets is None else self.sets[kept],
        )


class Camera(NamedTuple):
    """A camera without distortion: focal lengths and centre of the image, px; and the edge of the
    tags that it sees, m.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    size: float


class Readings(NamedTuple):
    """One reading at each pose; of a tag its four corners.

    kind    "distance", "plane", "sphere", "dial", "angle" or "tags"
    value   (pose,) m or rad; zero for touches of a plane, the radius for those of a sphere
    target  (pose,) name of what is measured: of a centre, a plane or a sphere; or the axis x, y or
            z of the base along or about which is measured; or of a tag
    camera  that sees the tags, whose corners (pose, 4, 2), px, are the value
    """

    kind: str
    value: Floats
    target: tuple[str, ...]
    camera: Camera | None = None

    def rows(self, kept: NDArray[np.int64]) -> Readings:
        """Return the readings in these rows."""
        return self._replace(value=self.value[kept], target=tuple(self.target[k] for k in kept))


class Rows(NamedTuple):
    """What an instrument reads at each pose, less what it would read.

    residual    (pose, row) measured less predicted
    by_twist    (pose, row, 6) derivative of the prediction by the tool's twist
    by_unknown  (pose, row, unknown) derivative by the instrument's unknowns, in their deviations
    """

    residual: Floats
    by_twist: Floats
    by_unknown: Floats


class Instrument(ABC):
    """A measurement at some poses.

    points    number of points that it sees at a pose
    unknowns  names of its unknowns
    noise     (row,) standard deviation of a row for a noise of one metre
    """

    points: ClassVar[int] = 1
    unknowns: tuple[str, ...]

    @property
    @abstractmethod
    def noise(self) -> Floats:
        """Return the standard deviations of the rows (row,), per unit of the stated noise."""

    @property
    def lengths(self) -> NDArray[np.bool_]:
        """Return which rows are lengths; all of them where none is."""
        found = self.noise == 1.0
        return np.asarray(found if found.any() else ~found)

    def error(self, residual: Floats) -> Floats:
        """Return the r.m.s. distance of its points (pose,), m, by residuals (pose, row)."""
        return np.asarray(np.linalg.norm(residual[:, self.lengths], axis=1) / self.points**0.5)

    def size(self, unknown: int) -> tuple[float, str]:  # noqa: ARG002 - one for all of most
        """Return the deviation of an unknown, and its unit as in `EstimatedError`."""
        return 1.0, "1"

    @abstractmethod
    def rows(self, frames: Floats, unknowns: Floats) -> Rows:
        """Return the rows for frames of the tool (pose, 4, 4) and the instrument's unknowns
        (unknown,), in their standard deviations.
        """

    @abstractmethod
    def part(self, rows: NDArray[np.int64]) -> Instrument:
        """Return the measurement at the poses in these rows."""


@dataclass(frozen=True, eq=False)
class OnInstrument(Instrument):
    """What another instrument measures, in other rows or at another arm.

    inner  the other instrument
    """

    inner: Instrument

    @property
    def unknowns(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return those of the other instrument."""
        return self.inner.unknowns

    @property
    def noise(self) -> Floats:
        """Return that of the other instrument."""
        return self.inner.noise

    def error(self, residual: Floats) -> Floats:
        """Return that of the other instrument."""
        return self.inner.error(residual)

    def size(self, unknown: int) -> tuple[float, str]:
        """Return that of the other instrument."""
        return self.inner.size(unknown)


@dataclass(frozen=True, eq=False)
class Points(Instrument):
    """Positions of the tool point: measured (pose, 3), m, in the base's axes."""

    measured: Floats
    unknowns: tuple[str, ...] = ()

    @property
    def noise(self) -> Floats:
        """Return one for each coordinate."""
        return np.ones(3)

    def rows(self, frames: Floats, unknowns: Floats) -> Rows:  # noqa: ARG002 - it has none
        """Return the rows: x, y and z."""
        count = len(frames)
        by_twist = np.broadcast_to(np.eye(6)[3:], (count, 3, 6))
        return Rows(self.measured - frames[:, :3, 3], by_twist, np.zeros((count, 3, 0)))

    def part(self, rows: NDArray[np.int64]) -> Points:
        """Return the measurement at the poses in these rows."""
        return Points(self.measured[rows])


@dataclass(frozen=True, eq=False)
class FullPoses(Instrument):
    """Frames of the tool: measured (pose, 4, 4), m, in the base's axes."""

    measured: Floats
    unknowns: tuple[str, ...] = ()

    @property
    def noise(self) -> Floats:
        """Return one for each coordinate, and for rotations what a target at `TARGET_RADIUS`
        resolves.
        """
        return np.repeat([1 / TARGET_RADIUS, 1.0], 3)

    def rows(self, frames: Floats, unknowns: Floats) -> Rows:  # noqa: ARG002 - it has none
        """Return the rows: the rotation vector from predicted to measured, then x, y and z."""
        turned = self.measured[:, :3, :3] @ frames[:, :3, :3].transpose(0, 2, 1)
        residual = np.concatenate(
            [rotation_vector(turned), self.measured[:, :3, 3] - frames[:, :3, 3]], axis=1
        )
        by_twist = np.tile(np.eye(6), (len(frames), 1, 1))
        by_twist[:, :3, :3] = turned_by_twist(-residual[:, :3])
        return Rows(residual, by_twist, np.zeros((len(frames), 6, 0)))

    def part(self, rows: NDArray[np.int64]) -> FullPoses:
        """Return the measurement at the poses in these rows."""
        return FullPoses(self.measured[rows])


class MovedBase(NamedTuple):
    """Frames of the tool on a base that is moved.

    frames  (pose, 4, 4) of the tool
    turn    (pose, 3, 3) rotation of the base
    motion  (pose, 6, 6) derivative of the tool's twist by the twist of the base
    """

    frames: Floats
    turn: Floats
    motion: Floats

    def by_twist(self, by_twist: Floats) -> Floats:
        """Return derivatives (pose, row, 6) by a twist of the tool before its base was moved, from
        those by a twist of the moved tool.
        """
        parts = [by_twist[:, :, :3] @ self.turn, by_twist[:, :, 3:] @ self.turn]
        return np.concatenate(parts, axis=2)


def moved_base(twist: Floats, frames: Floats) -> MovedBase:
    """Return frames of the tool (pose, 4, 4) on a base that is moved by these twists (pose, 6)."""
    moved = exp(twist)
    there = moved @ frames
    motion = right_jacobian(-twist)
    motion[:, 3:] -= skew(there[:, :3, 3]) @ motion[:, :3]
    return MovedBase(there, moved[:, :3, :3], motion)


def turned_by_twist(vector: Floats) -> Floats:
    """Return the derivative (pose, 3, 3) of rotation vectors (pose, 3) by a further rotation in
    the same fixed axes.
    """
    still = np.zeros_like(vector)
    turn = right_jacobian(np.concatenate([-vector, still], axis=1))[:, :3, :3]
    return np.asarray(np.linalg.inv(turn), dtype=float)


def rotation_vector(turned: Floats) -> Floats:
    """Return the rotation vectors (pose, 3), rad, of rotations (pose, 3, 3) by less than a half
    turn.
    """
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(turned).as_rotvec())
