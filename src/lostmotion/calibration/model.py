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

    matrix      pose matrix of the arm with its added errors
    streams     draws that are estimated: of columns drawn per robot alone
    of          (column,) index of the draw of each column; -1 for design columns, -2 for the others
    columns     (pose, 6, stream) motion of the tool per unit draw, in the nominal arm, where a soft
                one stands
    scatter     (pose, 6, 6) covariance of the motions by all errors that are not estimated
    """

    matrix: PoseMatrix
    streams: tuple[Stream, ...]
    of: NDArray[np.int64]
    columns: Floats
    scatter: Floats

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self.columns)

    def rows(self, rows: NDArray[np.int64]) -> RobotModel:
        """Return the model at the poses in these rows."""
        return replace(
            self,
            matrix=self.matrix.rows(rows),
            columns=self.columns[rows],
            scatter=self.scatter[rows],
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
        rows = np.arange(len(self))
        factors = np.broadcast_to(values[:, None], (len(rows), len(values), 1))
        return compose(self.matrix, rows, factors)[:, 0]

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
) -> RobotModel:
    """Return the model of an arm at poses q (pose, joint), rad and m, with these errors besides
    those of its file.

    approach  sign of the joints' last motion, as for `screws`

    A soft arm is taken where it stands under its loads, a stiff one at the command.
    Raises InputError where a soft arm cannot hold its load.
    """
    empty = Calibration((), np.zeros(0), np.zeros((0, 0)), tuple(added))
    state = standing_if_soft(state_of(arm.calibrated(empty), q))
    matrix = screws(state, approach=approach)
    estimated = [
        info.robot is not None and info.visit is None and info.closing is None
        for info in matrix.infos
    ]
    streams: dict[Stream, int] = {}
    of = np.full(len(matrix.infos), -2)
    for k, (info, own) in enumerate(zip(matrix.infos, estimated, strict=True)):
        if own and info.robot is not None:
            of[k] = streams.setdefault(info.robot, len(streams))
        elif info.level == "design":
            of[k] = -1
    columns = np.zeros((len(matrix.tool), 6, len(streams)))
    for column in np.flatnonzero(of >= 0):
        columns[:, :, of[column]] += matrix.tool[:, :, column]
    others = [
        k
        for k, info in enumerate(matrix.summed.infos)
        if info.level != "design" and not (info.visit is None and info.closing is None)
    ]
    rest = matrix.summed.tool[:, :, others]
    return RobotModel(matrix, tuple(streams), of, columns, rest @ rest.transpose(0, 2, 1))
