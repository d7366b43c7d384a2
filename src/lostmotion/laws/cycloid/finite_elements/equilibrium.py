"""Unilateral contact of two wheels whose compliance is known: pressures and rotation under a
torque, by an active set.

The equations are those of `stage`; lengths in mm, pressures in MPa.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.cycloid.finite_elements.mesh import MM
from lostmotion.laws.cycloid.finite_elements.wheel import gauss

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.finite_elements.contours import Contacts
    from lostmotion.laws.cycloid.finite_elements.envelope import EnvelopeContacts
    from lostmotion.laws.cycloid.finite_elements.wheel import ElasticWheel
    from lostmotion.spatial import Floats

_MOST_STEPS: Final = 100
_MOST_SLIPS: Final = 30
_SLIP: Final = 1e-7


@dataclass(frozen=True, slots=True)
class Solved:
    """A stage under one torque.

    pressures  (node,) MPa
    gaps       (node,) weighted with the hat function of each node, mm^2
    turn       rotation, rad
    slope      its derivative by the load, rad/N
    """

    pressures: Floats
    gaps: Floats
    turn: float
    slope: float


class System:
    """The equations of the contacts, in mm and MPa."""

    def __init__(
        self,
        made: Contacts | EnvelopeContacts,
        at: dict[int, Floats],
        gap: Floats,
        wheels: tuple[ElasticWheel, ...],
    ) -> None:
        """Weight gaps (contact,), m, and arms of the contacts at the places `at` (m) with their hat
        functions.
        """
        self.count, self.at, self.wheels, self.hertzian = len(made.theta), at, wheels, made.hertzian
        self.compliance = np.sum([wheel.compliance for wheel in wheels], axis=0)
        self.sliding = np.sum([wheel.sliding for wheel in wheels], axis=0)
        self.contact = np.repeat(np.arange(len(at)), [len(places) for places in at.values()])
        sums = [_weighted(made, k, places, gap[k]) for k, places in at.items()]
        self.area, self.first, self.second, self.gap, turning, self.bend = np.concatenate(
            sums, axis=1
        )
        inner = list(at)
        sense = float(np.sign(turning @ made.arm[inner][self.contact]))
        self.arm = sense * turning
        # by the planet's rotation the flank slips on the pin, and the gap opens by its square
        along = MM * made.lever[inner]
        self.turning = -sense * along
        self.radial = self.area * ((1 if made.stage.has_planet_pins else -1) * along)[self.contact]

    def solve(self, load: float) -> Solved:
        """Return the stage under a torque per width (N)."""
        turn, slip = 0.0, np.zeros(len(self.at))
        for _ in range(_MOST_SLIPS):
            # Newton's method: gap + area slip^2/(2 R) + radial turn^2/2, linear in the change of
            # slip and turn
            weight = (self.bend * slip[self.contact])[:, None] * self.sliding[self.contact]
            arm = self.arm - self.bend * (slip * self.turning)[self.contact] - self.radial * turn
            gap = self.gap - self.bend * (slip**2)[self.contact] / 2 - self.radial * turn**2 / 2
            found = self._closed(self.compliance + weight + weight.T, arm, gap, load)
            slip = self.sliding @ found.pressures + self.turning * found.turn
            if abs(found.turn - turn) <= _SLIP * found.turn:
                return found
            turn = found.turn
        raise DidNotConvergeError(
            "the slip of the flanks does not settle: take a smaller torque or a stiffer material"
        )

    def _closed(self, compliance: Floats, arm: Floats, gap: Floats, load: float) -> Solved:
        """Return the stage by the active set method from the middle of every contact."""
        closed = np.concatenate(
            [np.abs(places - places.mean()) < np.ptp(places) / 4 for places in self.at.values()]
        ) & (arm > 0)
        for _ in range(_MOST_STEPS):
            mine = np.flatnonzero(closed)
            matrix = np.zeros((len(mine) + 1, len(mine) + 1))
            matrix[:-1, :-1] = compliance[np.ix_(mine, mine)]
            matrix[:-1, -1], matrix[-1, :-1] = -arm[mine], arm[mine]
            right = np.zeros((len(mine) + 1, 2))
            right[:-1, 0], right[-1] = -gap[mine], (load, 1.0)
            solved = np.linalg.solve(matrix, right)
            pressures = np.zeros(len(gap))
            pressures[mine] = solved[:-1, 0]
            turn = float(solved[-1, 0])
            gaps = gap + compliance @ pressures - turn * arm
            after = np.where(closed, pressures > 0, gaps < 0)
            if (after == closed).all():
                return Solved(pressures, gaps, turn, float(solved[-1, 1]))
            # one node at least must carry the torque
            closed = (
                after
                if (arm[after] > 0).any()
                else (gap / np.where(arm > 0, arm, 1e-300)) == (gap[arm > 0] / arm[arm > 0]).min()
            )
        raise DidNotConvergeError("no equilibrium of the contacts was found")

    def outgrown(self, solved: list[Solved]) -> tuple[Floats, bool]:
        """Return how far each contact should reach, over half of its length, and whether an
        outermost contact carries pressure.

        Zero stands for far enough, one for pressure at an edge under any of the torques. If no
        contact has any, the places count where gaps close beyond an edge: before, the wheels turn
        too far, and more gaps seem to close.
        """
        loaded = np.max([each.pressures for each in solved], axis=0) > 0
        of_contact = [loaded[self.contact == n] for n in range(len(self.at))]
        reach = np.array([float(each[0] or each[-1]) for each in of_contact])
        if not reach.any():
            reach = np.max([self._closing(each.gaps) for each in solved], axis=0)
        return reach, len(self.at) < self.count and bool(
            of_contact[0].any() or of_contact[-1].any()
        )

    def _closing(self, gaps: Floats) -> Floats:
        """Return where gaps close beyond an end of their contacts, over half of these, and zero for
        others. A gap continues as the parabola at the last three nodes.

        By the rotation the flanks move along each other, and touch beside the place that they touch
        without load.
        """
        half = MM * np.array([np.ptp(places) / 2 for places in self.at.values()])
        start = np.searchsorted(self.contact, np.arange(len(self.at) + 1))[:, None]
        out = np.zeros(len(self.at))
        for nodes, end in ((start[:-1] + np.arange(3), 0), (start[1:] - [3, 2, 1], -1)):
            weights = np.stack([self.area[nodes], self.first[nodes], self.second[nodes]], axis=-1)
            level, slope, bend = np.linalg.solve(weights, gaps[nodes][..., None])[..., 0].T
            at_end = MM * np.array([places[end] for places in self.at.values()])
            inwards = (slope + 2 * bend * at_end) * (-1 if end else 1)
            closes = (inwards > 0) & (slope**2 > 4 * level * bend)
            lowest = np.abs(slope / np.where(bend > 0, 2 * bend, np.inf)) / half
            out = np.where(closes, np.maximum(lowest, 1.0), out)
        return out

    def by_lobe(self, pressures: Floats) -> tuple[Floats, Floats, Floats]:
        """Return forces per width (torque, contact), N/mm, largest pressures (torque, contact),
        MPa, and half-widths, mm.

        Pressure and half-width are those of the half-ellipse with the same force and second moment;
        of contacts that are none the largest mean over neighbouring nodes, and half of the loaded
        length.
        """
        sums = np.zeros((3, len(pressures), self.count))
        peak, half = np.zeros((2, len(pressures), self.count))
        for n, k in enumerate(self.at):
            mine = self.contact == n
            sums[:, :, k] = [
                pressures[:, mine] @ moment[mine] for moment in (self.area, self.first, self.second)
            ]
            if not self.hertzian:
                p = np.pad(pressures[:, mine], ((0, 0), (1, 1)))
                peak[:, k] = ((p[:, :-2] + 2 * p[:, 1:-1] + p[:, 2:]) / 4).max(axis=1)
                half[:, k] = (pressures[:, mine] > 0) @ self.area[mine] / 2
        forces = sums[0]
        if self.hertzian:
            shares = np.where(forces > 0, forces, 1.0)
            half = 2 * np.sqrt(np.maximum(sums[2] / shares - (sums[1] / shares) ** 2, 0.0))
            peak = np.where(half > 0, 2 * forces / (math.pi * np.where(half > 0, half, 1.0)), 0.0)
        return forces, peak, half


def _weighted(made: Contacts | EnvelopeContacts, k: int, places: Floats, gap: float) -> Floats:
    """Return unity, place, its square, gap, moment of the normal and curvature, integrated with the
    hat function of each node: (6, node), mm.
    """
    x, weight = gauss()
    step = np.diff(places)[:, None]
    s = places[:-1, None] + x * step
    opening, moment, bend = (each.reshape(s.shape) for each in made.surface(k, s.ravel()))
    values = np.stack(
        [np.ones_like(s), MM * s, (MM * s) ** 2, MM * (opening + gap), MM * moment, bend / MM]
    )
    out = np.zeros((6, len(places)))
    for nodes, hat in ((slice(None, -1), 1 - x), (slice(1, None), x)):
        out[:, nodes] += MM * step[:, 0] * (values * hat * weight).sum(axis=2)
    return out
