"""Unilateral contact of two wheels whose compliance is known: pressures and rotation under a torque, by an active set.

The equations are those of `stage`; lengths in mm, pressures in MPa.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.cycloid.finite_elements.contours import gaps_at
from lostmotion.laws.cycloid.finite_elements.mesh import MM
from lostmotion.laws.cycloid.finite_elements.wheel import gauss
from lostmotion.laws.cycloid.geometry import arms

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.finite_elements.contours import Contacts
    from lostmotion.laws.cycloid.finite_elements.wheel import ElasticWheel
    from lostmotion.spatial import Floats

_MOST_STEPS: Final = 100
_MOST_SLIPS: Final = 30
_SLIP: Final = 1e-7


class System:
    """The equations of the contacts, in mm and MPa."""

    def __init__(self, made: Contacts, at: dict[int, Floats], gap: Floats, wheels: tuple[ElasticWheel, ...]) -> None:
        """Weight gaps (N,), m, and arms of the contacts at the places `at` (m) with their hat functions."""
        self.pins, self.at, self.wheels = made.stage.pins, at, wheels
        self.radius = MM * made.stage.pin_radius
        self.compliance = np.sum([wheel.compliance for wheel in wheels], axis=0)
        self.sliding = np.sum([wheel.sliding for wheel in wheels], axis=0)
        self.contact = np.repeat(np.arange(len(at)), [len(places) for places in at.values()])
        sums = [_weighted(made, k, places, gap[k]) for k, places in at.items()]
        self.area, self.first, self.second, self.gap, turning = np.concatenate(sums, axis=1)
        inner = list(at)
        sense = float(np.sign(turning @ arms(made.stage, made.theta)[inner][self.contact]))
        self.arm = sense * turning
        # by the planet's rotation the flank slips on the pin, and the gap opens by its square
        foot = made.pin[inner] + (0.0 if made.stage.has_planet_pins else made.stage.pin_radius) * made.towards[inner] - made.planet
        along = MM * (np.conj(made.towards[inner]) * foot).real
        self.turning = -sense * along
        self.radial = self.area * ((1 if made.stage.has_planet_pins else -1) * along)[self.contact]

    def solve(self, load: float) -> tuple[Floats, float, float]:
        """Return pressures (MPa), rotation (rad) and its derivative by the load, under a torque per width (N)."""
        turn, slip = 0.0, np.zeros(len(self.at))
        for _ in range(_MOST_SLIPS):
            # Newton's method: gap + area slip^2/(2 Rr) + radial turn^2/2, linear in the change of slip and turn
            weight = (self.area * slip[self.contact] / self.radius)[:, None] * self.sliding[self.contact]
            arm = self.arm - self.area * (slip * self.turning)[self.contact] / self.radius - self.radial * turn
            gap = self.gap - self.area * (slip**2)[self.contact] / (2 * self.radius) - self.radial * turn**2 / 2
            pressures, found, slope = self._closed(self.compliance + weight + weight.T, arm, gap, load)
            slip = self.sliding @ pressures + self.turning * found
            if abs(found - turn) <= _SLIP * found:
                return pressures, found, slope
            turn = found
        raise DidNotConvergeError("the slip of the flanks does not settle: take a smaller torque or a stiffer material")

    def _closed(self, compliance: Floats, arm: Floats, gap: Floats, load: float) -> tuple[Floats, float, float]:
        """Return pressures, rotation and its derivative by the load, by the active set method from the middle of every contact."""
        closed = np.concatenate([np.abs(places - places.mean()) < np.ptp(places) / 4 for places in self.at.values()]) & (arm > 0)
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
            after = np.where(closed, pressures > 0, gap + compliance @ pressures - turn * arm < 0)
            if (after == closed).all():
                return pressures, turn, float(solved[-1, 1])
            # one node at least must carry the torque
            closed = after if (arm[after] > 0).any() else (gap / np.where(arm > 0, arm, 1e-300)) == (gap[arm > 0] / arm[arm > 0]).min()
        raise DidNotConvergeError("no equilibrium of the contacts was found")

    def outgrown(self, pressures: Floats) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.bool_]], bool]:
        """Return which contacts carry pressure at an edge under any of the pressures (torque, node), and whether an outermost contact carries any."""
        loaded = pressures.max(axis=0) > 0
        of_contact = [loaded[self.contact == n] for n in range(len(self.at))]
        at_edge = np.array([each[0] or each[-1] for each in of_contact])
        return at_edge, len(self.at) < self.pins and bool(of_contact[0].any() or of_contact[-1].any())

    def by_lobe(self, pressures: Floats) -> tuple[Floats, Floats, Floats]:
        """Return forces per width (torque, N), N/mm, pressures of the half-ellipses (torque, N), MPa, and their half-widths, mm."""
        sums = np.zeros((3, len(pressures), self.pins))
        for n, k in enumerate(self.at):
            mine = self.contact == n
            sums[:, :, k] = [pressures[:, mine] @ moment[mine] for moment in (self.area, self.first, self.second)]
        forces = sums[0]
        shares = np.where(forces > 0, forces, 1.0)
        half = 2 * np.sqrt(np.maximum(sums[2] / shares - (sums[1] / shares) ** 2, 0.0))
        return forces, np.where(half > 0, 2 * forces / (math.pi * np.where(half > 0, half, 1.0)), 0.0), half


def _weighted(made: Contacts, k: int, places: Floats, gap: float) -> Floats:
    """Return unity, place, its square, gap and moment of the normal, integrated with the hat function of each node of contact k: (5, node), mm."""
    x, weight = gauss()
    out = np.zeros((5, len(places)))
    for n, step in enumerate(np.diff(places)):
        s = places[n] + x * step
        outwards = made.towards[k] * np.exp(1j * s / made.stage.pin_radius)
        moment = (np.conj(made.pin[k] - made.planet) * outwards).imag
        values = np.stack([np.ones_like(s), MM * s, (MM * s) ** 2, MM * (gaps_at(made, k, s) + gap), MM * moment])
        for node, hat in ((n, 1 - x), (n + 1, x)):
            out[:, node] += MM * step * (values * hat * weight).sum(axis=1)
    return out
