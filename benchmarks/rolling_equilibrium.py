"""How many shafts on rolling bearings settle per second, against careful NumPy over all cases at
once and a loop over SciPy, in the same run?

Loads from any side on a deep-groove pair (9 balls each, 15 um clearance), a preloaded
angular-contact pair (13 balls each) and a crossed-roller bearing (48 rollers, 5 um preload): shift
in x, y, z and tilt about x, y, five unknowns.

    python benchmarks/rolling_equilibrium.py [--cases 2000] [--scipy 50]

Contestants, alternating, best of three:
    SciPy loop   scipy.optimize.root per case on the five balances with their slopes, all contacts
                 at once in NumPy, started along the load NumPy        Newton over all cases at
                 once, an eigenvalue decomposition for its step, a search along the step; cases that
                 are balanced drop out lostmotion   laws.rolling.equilibrium.shaft_equilibrium
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np
from scipy.optimize import root

from lostmotion.laws.rolling.equilibrium import shaft_equilibrium
from lostmotion.laws.rolling.rows import BallRow, CrossedRow, RowSeat

GROOVE = BallRow(count=9, ball=12.7e-3, pitch=65e-3)
ANGULAR = BallRow(count=13, ball=12.7e-3, pitch=65e-3, contact_angle=math.radians(25))
SHAFTS = {
    "deep-groove pair": ((RowSeat(GROOVE, -0.03), RowSeat(GROOVE, 0.03)), 15e-6),
    "angular-contact pair": (
        (
            RowSeat(ANGULAR, -0.03, preload_shift=5e-6),
            RowSeat(ANGULAR, 0.03, mirrored=True, preload_shift=5e-6),
        ),
        0.0,
    ),
    "crossed roller": ((RowSeat(CrossedRow(count=48, length=8e-3, pitch=120e-3)),), -5e-6),
}
REACH = 0.05  # m, at which a tilt counts as a shift
SCALE = np.array([1, 1, 1, 1 / REACH, 1 / REACH])


class Balance:
    """All contacts of a shaft for many cases at once; stands in metres throughout."""

    def __init__(self, seats: tuple[RowSeat, ...], play: float) -> None:
        self.contacts = np.concatenate([seat.contacts for seat in seats])
        self.across, self.along = self.contacts["across"] * SCALE, self.contacts["along"] * SCALE
        self.radial = self.contacts["radial"] - self.contacts["share"] * play
        self.size = 2 * max(abs(self.radial).max(), self.contacts["apart"].max())
        self.balls = bool(self.contacts["apart"].any())

    def held(self, displacement: np.ndarray) -> tuple[np.ndarray, ...]:
        """Load held (case, 5), force (case, contact), its tangent, the way it acts (case, contact,
        5) and how that turns.
        """
        c = self.contacts
        radial = self.radial + displacement @ self.across.T
        if self.balls:
            axial = c["axial"] + displacement @ self.along.T
            turns = c["shoulders"] | (axial > 0)
            axial = axial * turns
            length = np.hypot(radial, axial)
            cosine, sine = (radial / length)[..., None], (axial / length)[..., None]
            way = cosine * self.across + sine * self.along
            bow = (cosine * self.along - sine * self.across) * (turns / np.sqrt(length))[..., None]
            closed = length - c["apart"]
        else:
            closed, way, bow = radial, np.broadcast_to(self.across, (*radial.shape, 5)), None
        force = c["stiffness"] * np.maximum(closed, 0.0) ** c["exponent"]
        tangent = np.divide(
            c["exponent"] * force, closed, out=np.zeros_like(force), where=closed > 0
        )
        return (force[:, None] @ way)[:, 0], force, tangent, way, bow

    def slope(
        self, force: np.ndarray, tangent: np.ndarray, way: np.ndarray, bow: np.ndarray | None
    ) -> np.ndarray:
        out = np.swapaxes(way, 1, 2) @ (tangent[..., None] * way)
        return out if bow is None else out + np.swapaxes(bow, 1, 2) @ (force[..., None] * bow)

    def start(self, wanted: np.ndarray) -> np.ndarray:
        """A stand along the load where the contacts hold as much along it as is wanted."""
        size = np.linalg.norm(wanted, axis=1)
        along = wanted / size[:, None]
        high = np.full(len(wanted), 1e-6)
        while (
            short := (np.einsum("ck,ck->c", self.held(high[:, None] * along)[0], along) < size)
            & (high < REACH)
        ).any():
            high = np.where(short, 2 * high, high)
        return high[:, None] * along


def numpy_batch(balance: Balance, wanted: np.ndarray) -> np.ndarray:
    displacement = balance.start(wanted)
    left = np.arange(len(wanted))
    size = np.linalg.norm(wanted, axis=1)
    for _ in range(200):
        held, *parts = balance.held(displacement[left])
        lack = wanted[left] - held
        rounding = 5e-16 * (parts[0].sum(axis=1) + balance.size * parts[1].sum(axis=1))
        on = np.linalg.norm(lack, axis=1) > 1e-11 * size[left] + rounding
        if not on.any():
            return displacement
        left, lack = left[on], lack[on]
        values, vectors = np.linalg.eigh(
            balance.slope(*(None if part is None else part[on] for part in parts))
        )
        shares = np.einsum("ckl,ck->cl", vectors, lack) / np.maximum(values, 1e-12 * values[:, -1:])
        step = np.einsum("ckl,cl->ck", vectors, shares)
        step *= np.minimum(
            1.0, (np.linalg.norm(displacement[left], axis=1) + 2e-5) / np.linalg.norm(step, axis=1)
        )[:, None]
        start = np.einsum("ck,ck->c", lack, step)
        low, high, share = np.zeros(len(left)), np.ones(len(left)), np.ones(len(left))
        for _ in range(40):
            held = balance.held(displacement[left] + share[:, None] * step)[0]
            down = np.einsum("ck,ck->c", wanted[left] - held, step)
            beyond = down < -0.5 * start
            done = ~beyond & ((down <= 0.5 * start) | (share >= 1))
            if done.all():
                break
            low, high = np.where(beyond, low, share), np.where(beyond, share, high)
            share = np.where(done, share, (low + high) / 2)
        displacement[left] += share[:, None] * step
    return np.full_like(displacement, np.nan)


def scipy_loop(balance: Balance, wanted: np.ndarray) -> np.ndarray:
    def left_over(place: np.ndarray, load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        held, *parts = balance.held(place[None] * 1e-6)
        size = np.linalg.norm(load)
        return (held[0] - load) / size, balance.slope(*parts)[0] * 1e-6 / size

    start = balance.start(wanted) * 1e6
    found = [
        root(left_over, place, args=(load,), jac=True, tol=1e-10)
        for place, load in zip(start, wanted, strict=True)
    ]
    return np.array([each.x * 1e-6 if each.success else np.full(5, np.nan) for each in found])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--scipy", type=int, default=50)
    options = parser.parse_args()
    load = np.random.default_rng(1).normal(size=(options.cases, 5)) * [1000, 1000, 500, 30, 30]
    started = time.perf_counter()
    shaft_equilibrium(SHAFTS["crossed roller"][0], load[:1])
    print(
        f"first call, with loading or compiling the kernel: {time.perf_counter() - started:.1f} s"
    )
    print(f"{options.cases} loads ({options.scipy} for SciPy), best of three, us each")
    print(f"{'':22}{'SciPy loop':>12}{'NumPy':>8}{'lostmotion':>12}{'times NumPy':>13}")
    for name, (seats, play) in SHAFTS.items():
        balance = Balance(seats, play)
        contestants = {
            "SciPy loop": (
                options.scipy,
                lambda balance=balance: scipy_loop(balance, load[: options.scipy] * SCALE),
            ),
            "NumPy": (options.cases, lambda balance=balance: numpy_batch(balance, load * SCALE)),
            "lostmotion": (
                options.cases,
                lambda seats=seats, play=play: (
                    shaft_equilibrium(seats, load, play).displacement / SCALE
                ),
            ),
        }
        best, stands = dict.fromkeys(contestants, math.inf), {}
        for _ in range(3):
            for who, (count, contestant) in contestants.items():
                start = time.perf_counter()
                stands[who] = contestant()
                best[who] = min(best[who], (time.perf_counter() - start) / count * 1e6)
        ours = stands["lostmotion"]
        theirs = stands["SciPy loop"]
        apart = np.linalg.norm(stands["NumPy"] - ours, axis=1) / np.linalg.norm(ours, axis=1)
        off = np.linalg.norm(theirs - ours[: len(theirs)], axis=1) / np.linalg.norm(
            ours[: len(theirs)], axis=1
        )
        print(
            f"{name:22}{best['SciPy loop']:12.0f}{best['NumPy']:8.0f}{best['lostmotion']:12.1f}{best['NumPy'] / best['lostmotion']:13.0f}"  # noqa: E501
        )
        found = np.isfinite(off)
        print(
            f"{'':22}differ by {apart.max():.0e} (NumPy), {np.max(off[found], initial=0):.0e} "
            f"(SciPy, which found {found.sum()} of {len(off)})"
        )


if __name__ == "__main__":
    main()
