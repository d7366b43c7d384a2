"""The tables of a task in TOML, and where the places of its features are."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from lostmotion.errors import Worded
from lostmotion.parts.error_source import Angle, Force, Line
from lostmotion.parts.frame import Direction, Frame, Vector, unit
from lostmotion.parts.gearbox.counts import Whole
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Stand in examples for a feature of the task, and for a joint of the arm that its heat lengthens.
FEATURE: Final = '"FEATURE"'
JOINT: Final = '"JOINT"'
_MOST_FEATURES: Final = 200
_SEGMENTS: Final = 20
_LIMIT: Final = Quantity("m", "0.4 mm", above=0, high=100)
_Size = Annotated[float, Quantity("m", "100 mm", above=0)]
_Limit = Annotated[float, _LIMIT]
_Angles = tuple[Angle, Angle, Angle]
_Row = Annotated[int, Whole("", "3", low=1, high=50)]
_Grid = Annotated[int, Whole("", "3", low=2, high=30)]
_Approach = Literal["up", "down", "random"]


class TaskTable(BaseModel):
    """A table of the file."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class FeatureTable(TaskTable):
    """What the features have in common.

    retract   distance from which the tool arrives along its axis at the first place, and at every
              hole
    approach  side from which all joints arrive at its first place; by default as they move
    """

    name: Annotated[Line, Field(min_length=1, max_length=60)]
    tool_rpy: _Angles | None = None
    retract: Annotated[float, Quantity("m", "20 mm", low=0)] = 0.0
    approach: _Approach | None = None

    @abstractmethod
    def layout(self, step: float | None) -> tuple[Floats, Floats | None]:
        """Return the points (place, 3), m, and the axis (3,) in the frame of the task."""


class PointTable(FeatureTable):
    """A place."""

    kind: Literal["point"]
    at: Vector

    def layout(self, step: float | None) -> tuple[Floats, Floats | None]:
        """Return the points (place, 3), m, and the axis (3,) in the frame of the task."""
        del step
        return np.array([self.at]), None


class LineTable(FeatureTable):
    """Places along a straight line, `step` apart."""

    kind: Literal["line"]
    start: Vector
    end: Vector

    def layout(self, step: float | None) -> tuple[Floats, Floats | None]:
        """Return the points (place, 3), m, and the axis (3,) in the frame of the task."""
        start, end = np.array(self.start), np.array(self.end)
        far = float(np.linalg.norm(end - start))
        if not far:
            raise ValueError("a line whose start is its end; two ends apart")
        share = np.linspace(0, 1, _count(far, step) + 1)[:, None]
        return start + share * (end - start), (end - start) / far


class CircleTable(FeatureTable):
    """Places along a circle, or an arc of it, from its x."""

    kind: Literal["circle"]
    centre: Vector
    diameter: _Size
    normal: Direction = "z"
    sweep: Angle = 2 * math.pi

    def layout(self, step: float | None) -> tuple[Floats, Floats | None]:
        """Return the points (place, 3), m, and the axis (3,) in the frame of the task."""
        if not self.sweep:
            raise ValueError("a sweep of zero; an arc, or a whole circle")
        count = _count(abs(self.sweep) * self.diameter / 2, step)
        return self._ring(np.linspace(0, self.sweep, count + 1)), unit(self.normal)

    def _ring(self, turn: Floats) -> Floats:
        across = _across(unit(self.normal))
        ring = np.column_stack([np.cos(turn), np.sin(turn)]) @ across
        return np.array(self.centre) + self.diameter / 2 * ring


class HolesTable(FeatureTable):
    """Places on a bolt circle, or on a grid about its centre."""

    kind: Literal["holes"]
    centre: Vector
    normal: Direction = "z"
    diameter: _Size | None = None
    count: Annotated[int, Whole("", "6", low=2, high=200)] | None = None
    pitch: tuple[_Size, _Size] | None = None
    grid: tuple[_Row, _Row] | None = None

    def layout(self, step: float | None) -> tuple[Floats, Floats | None]:
        """Return the points (place, 3), m, and the axis (3,) in the frame of the task."""
        del step
        normal = unit(self.normal)
        across = _across(normal)
        if self.diameter is not None and self.count is not None:
            turn = 2 * np.pi * np.arange(self.count) / self.count
            off = self.diameter / 2 * np.column_stack([np.cos(turn), np.sin(turn)])
        elif self.pitch is not None and self.grid is not None:
            steps = (np.arange(n) - (n - 1) / 2 for n in self.grid)
            off = np.stack(np.meshgrid(*steps, indexing="ij"), -1).reshape(-1, 2) * self.pitch
        else:
            raise ValueError(
                "neither diameter with count nor pitch with grid; a bolt circle or a grid"
            )
        return np.array(self.centre) + off @ across, normal


class PlaneTable(FeatureTable):
    """A grid of places in a plane."""

    kind: Literal["plane"]
    centre: Vector
    size: tuple[_Size, _Size]
    normal: Direction = "z"
    points: tuple[_Grid, _Grid] = (3, 3)

    def layout(self, step: float | None) -> tuple[Floats, Floats | None]:
        """Return the points (place, 3), m, and the axis (3,) in the frame of the task."""
        del step
        steps = (np.linspace(-0.5, 0.5, n) for n in self.points)
        off = np.stack(np.meshgrid(*steps, indexing="ij"), -1).reshape(-1, 2) * self.size
        normal = unit(self.normal)
        return np.array(self.centre) + off @ _across(normal), normal


class ToleranceTable(TaskTable):
    """One tolerance: exactly one of the kinds, with its size."""

    in_example: ClassVar = ("cylinder",)

    name: Line | None = None
    of: Annotated[Line | list[Line] | None, Worded("features of the task", FEATURE)] = None
    cylinder: _Limit | None = None
    sphere: _Limit | None = None
    box: tuple[_Limit, _Limit, _Limit] | None = None
    orientation: Annotated[float, Quantity("rad", "0.5 deg", above=0, high=math.pi)] | None = None
    distance: _Limit | None = None
    straightness: _Limit | None = None
    roundness: _Limit | None = None
    flatness: _Limit | None = None
    length: Annotated[float, Quantity("m", "30 mm", low=0)] = 0.0
    axis: Literal["tool", "path", "x", "y", "z"] | None = None
    relative_to: Annotated[
        Line | list[Line], Worded('"base", "fitted", or features of the task', '"fitted"')
    ] = "base"


class SearchTable(TaskTable):
    """By how much the placement may be moved from where it is stated, either way."""

    x: Annotated[float, Quantity("m", "100 mm", low=0)] = 0.0
    y: Annotated[float, Quantity("m", "100 mm", low=0)] = 0.0
    z: Annotated[float, Quantity("m", "100 mm", low=0)] = 0.0
    yaw: Annotated[float, Quantity("rad", "30 deg", low=0, high=math.pi)] = 0.0


class ForceTable(TaskTable):
    """Force on the tool: along the axes of the task, along the path, or both."""

    vector: tuple[Force, Force, Force] = (0.0, 0.0, 0.0)
    along: Force = 0.0
    scatter: Annotated[float, Quantity("", "10 %", low=0, high=1)] = 0.0


class HeatTable(TaskTable):
    """Temperature rise of a joint's link in the long run at the duty of the task, and the time
    within which it reaches 63 % of it.
    """

    joint: Annotated[Line, Worded("the name of a joint", JOINT)]
    rise: Annotated[float, Quantity("K", "12 K", above=0, high=200)]
    time_constant: Annotated[float, Quantity("s", "40 min", above=0, high=1e9)]


class WarmUpTable(TaskTable):
    """Own heat of joints over the task: how long a run takes, how long runs follow each other (one
    run unless stated), and whether the arm is cold or warm when they begin.
    """

    duration: Annotated[float, Quantity("s", "20 min", above=0, high=1e9)]
    over: Annotated[float, Quantity("s", "8 h", above=0, high=1e9)] | None = None
    start: Literal["cold", "warm"] = "cold"
    joints: Annotated[list[HeatTable], Field(min_length=1, max_length=_MOST_FEATURES)]


class TaskFile(TaskTable):
    """The whole file."""

    name: Annotated[Line, Field(max_length=100)] = ""
    required: Annotated[float, Quantity("", "95 %", above=0, high=1)] = 0.95
    repeated: bool = False
    step: _Size | None = None
    tool_rpy: _Angles | None = None
    poses: Line | None = None
    program: Line | None = None
    placement: Frame | None = None
    search: SearchTable | None = None
    force: ForceTable | None = None
    warm_up: WarmUpTable | None = None
    features: Annotated[
        list[
            Annotated[
                PointTable | LineTable | CircleTable | HolesTable | PlaneTable,
                Field(discriminator="kind"),
            ]
        ],
        Field(max_length=_MOST_FEATURES),
    ] = []
    tolerances: Annotated[list[ToleranceTable], Field(min_length=1, max_length=_MOST_FEATURES)]


def _count(length: float, step: float | None) -> int:
    """Return the number of segments of a line or arc."""
    if step is None:
        return _SEGMENTS
    return max(math.ceil(min(length / step, 1e6) - 1e-9), 1)


def _across(normal: Floats) -> Floats:
    """Return two unit vectors (2, 3) across a normal: for z, x and y."""
    helper = np.eye(3)[0] if abs(normal[0]) < 0.9 else np.eye(3)[1]  # noqa: PLR2004 - not along it
    first = helper - (helper @ normal) * normal
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])
