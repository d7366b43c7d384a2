"""An arm with its unknown errors at the poses of a measurement: where its tool is for any values of
them, and how much each moves it.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.calibration import Calibration
from lostmotion.mechanism.standing import standing_if_soft
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.exact import compose

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.draws import Stream
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.spatial import Floats


@dataclass(frozen=True, eq=False)
class RobotModel:
    """The errors of an arm at some poses, split by what measurements of one robot can estimate.

    matrices    pose matrix of the arm with its added errors under each payload
    load        (pose,) number of the payload at each pose
    streams     draws that are estimated: of columns drawn per robot alone
    of          (column,) index of the draw of each column; -1 for design columns, -2 for the others
    columns     (pose, 6, stream) motion of the tool per unit draw, in the nominal arm, where a soft
                one stands
    scatter     (pose, 6, 6) covariance of the motions by all errors that are not estimated
    sides       (pose, 6, 6) the part of it by sides of approach that are not known
    reading     (pose,) variance of what is measured by what repeats show, m^2; zero without any
    """

    matrices: tuple[PoseMatrix, ...]
    load: NDArray[np.int64]
    streams: tuple[Stream, ...]
    of: NDArray[np.int64]
    columns: Floats
    scatter: Floats
    sides: Floats
    reading: Floats

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self.columns)

    @property
    def matrix(self) -> PoseMatrix:
        """Return the pose matrix under the first payload."""
        return self.matrices[0]

    def rows(self, rows: NDArray[np.int64]) -> RobotModel:
        """Return the model at the poses in these rows."""
        return replace(
            self,
            matrices=tuple(matrix.rows(rows) for matrix in self.matrices),
            load=self.load[rows],
            columns=self.columns[rows],
            scatter=self.scatter[rows],
            sides=self.sides[rows],
            reading=self.reading[rows],
        )

    def keeping(self, kept: NDArray[np.int64]) -> RobotModel:
        """Return the model with these draws alone; the others are zero."""
        number = np.full(len(self.streams), -2)
        number[kept] = np.arange(len(kept))
        return replace(
            self,
            streams=tuple(self.streams[k] for k in kept),
            of=np.where(self.of >= 0, number[self.of], self.of),
            columns=self.columns[:, :, kept],
        )

    def frames(self, draws: Floats) -> Floats:
        """Return the exact frames of the tool (pose, 4, 4), m, of the robot with these draws
        (stream,).
        """
        values = np.concatenate([draws, [0.0, 1.0]])[self.of]  # -1 is the last, -2 before it
        out = np.empty((len(self), 4, 4))
        for number, matrix in enumerate(self.matrices):
            rows = np.flatnonzero(self.load == number)
            factors = np.broadcast_to(values[:, None], (len(rows), len(values), 1))
            out[rows] = compose(matrix, rows, factors)[:, 0]
        return out

    def numbers(self, streams: Sequence[Stream]) -> NDArray[np.int64]:
        """Return the number of each of these draws in this model. The two draws of a harmonic have
        one name, so that a name alone is no key.
        """
        at = {stream: k for k, stream in enumerate(self.streams)}
        return np.array([at[stream] for stream in streams], dtype=np.int64)

    @functools.cached_property
    def owners(self) -> tuple[str, ...]:
        """Return the part of each draw, by the first column that has it."""
        first = {int(k): c for c, k in reversed(list(enumerate(self.of))) if k >= 0}
        return tuple(self.matrix.infos[first[k]].owner for k in range(len(self.streams)))


def model_of(
    arm: Arm,
    q: Floats,
    added: Sequence[PlacedTerm] = (),
    *,
    approach: float | Floats = 0.0,
    payload: Floats | None = None,
) -> RobotModel:
    """Return the model of an arm at poses q (pose, joint), rad and m, with these errors besides
    those of its file.

    approach  sign of the joints' last motion, as for `screws`
    payload   (pose,) mass at the tool, kg; None: that of the file

    A soft arm is taken where it stands under its loads, a stiff one at the command.
    Raises InputError where a soft arm cannot hold its load.
    """
    arm = arm.calibrated(Calibration((), np.zeros(0), np.zeros((0, 0)), tuple(added)))
    masses, load = np.unique([] if payload is None else payload, return_inverse=True)
    loaded = [with_payload(arm, float(mass)) for mass in masses] or [arm]
    matrices = tuple(
        screws(standing_if_soft(state_of(each, q)), approach=approach) for each in loaded
    )
    load = load if len(masses) else np.zeros(len(q), dtype=np.int64)
    streams: dict[Stream, int] = {}
    of = np.full(len(matrices[0].infos), -2)
    for k, info in enumerate(matrices[0].infos):
        if info.robot is not None and info.visit is None and info.closing is None:
            of[k] = streams.setdefault(info.robot, len(streams))
        elif info.level == "design":
            of[k] = -1
    columns, scatter = np.zeros((len(q), 6, len(streams))), np.zeros((2, len(q), 6, 6))
    for number, matrix in enumerate(matrices):
        rows = np.flatnonzero(load == number)
        for column in np.flatnonzero(of >= 0):
            columns[rows, :, of[column]] += matrix.tool[rows, :, column]
        sided = {info.visit for info in matrix.infos if info.of.term.sided}
        others = [
            (k, info.visit is not None and info.visit in sided)
            for k, info in enumerate(matrix.summed.infos)
            if info.level != "design" and not (info.visit is None and info.closing is None)
        ]
        for of_side in (False, True):
            kept = [k for k, side in others if side is of_side]
            rest = matrix.summed.tool[rows][:, :, kept]
            scatter[int(of_side), rows] = rest @ rest.transpose(0, 2, 1)
    every, sides = scatter.sum(axis=0), scatter[1]
    return RobotModel(matrices, load, tuple(streams), of, columns, every, sides, np.zeros(len(q)))


def with_payload(arm: Arm, mass: float) -> Arm:
    """Return the arm with this mass at its tool, kg."""
    if mass == arm.payload.mass:
        return arm
    return arm.with_payload(arm.payload.model_copy(update={"mass": mass}))
