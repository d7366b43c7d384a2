"""Which part costs how much, and what would halving it buy? Exact sums over terms, no sampling."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats
    from lostmotion.studies.screws import Screws


@dataclass(frozen=True)
class Tally:
    """Sums over poses of mean-square tool errors, m^2; one entry per part in `owners`.

    total     of everything: |bias|^2 plus the variances, which add because terms are independent
    variance  of each part's drawn terms; own_bias of its design terms alone; shared_bias their product with the whole bias
    levels    the mean square that is |bias|^2 (design), drawn per robot, and drawn per visit
    """

    owners: tuple[str, ...]
    poses: int
    total: float
    variance: Floats
    own_bias: Floats
    shared_bias: Floats
    levels: Floats

    @classmethod
    def of(cls, matrix: Screws) -> Self:
        """Sum up one block of poses."""
        shift = matrix.along_poses[3:]
        bias = matrix.bias[:, 3:].T
        owners = matrix.owners
        variance, own, shared = np.zeros(len(owners)), np.zeros(len(owners)), np.zeros(len(owners))
        squares = matrix.square_sums
        for k, owner in enumerate(owners):
            part = np.zeros_like(bias)
            for c, info in enumerate(matrix.infos):
                if info.owner == owner and info.level == "design":
                    part += shift[:, c]
                elif info.owner == owner:
                    variance[k] += squares[c]
            own[k] = np.vdot(part, part)
            shared[k] = np.vdot(part, bias)
        whole = float(np.sum(bias * bias))
        robot = float(squares[matrix.columns("robot")].sum())
        visit = float(squares[matrix.columns("visit", "robot x visit")].sum())
        return cls(owners, len(matrix.tool), whole + robot + visit, variance, own, shared, np.array([whole, robot, visit]))

    def __add__(self, other: Tally) -> Tally:
        """Put two blocks together."""
        if self.owners != other.owners:
            raise ValueError("blocks of different arms do not add")
        return Tally(
            self.owners,
            self.poses + other.poses,
            self.total + other.total,
            self.variance + other.variance,
            self.own_bias + other.own_bias,
            self.shared_bias + other.shared_bias,
            self.levels + other.levels,
        )


@dataclass(frozen=True, slots=True)
class Cost:
    """What one part costs: its r.m.s. error alone (m), its share of the mean square, and the whole's r.m.s. error if it were halved (m).

    Shares add to one. A negative share means that the part happens to cancel others: without it the arm would be worse.
    """

    part: str
    alone: float
    share: float
    rms_if_halved: float


def costs(tally: Tally) -> list[Cost]:
    """What does each part cost over the poses tallied, the dearest first?"""
    mean_square = tally.total / tally.poses
    out = []
    for k, owner in enumerate(tally.owners):
        variance, own, shared = (float(x[k]) / tally.poses for x in (tally.variance, tally.own_bias, tally.shared_bias))
        halved = mean_square - shared + own / 4 - 0.75 * variance
        share = (variance + shared) / mean_square if mean_square else 0.0
        out.append(Cost(owner, float(np.sqrt(variance + own)), share, float(np.sqrt(max(halved, 0.0)))))
    return sorted(out, key=lambda cost: -cost.share)
