"""Which is the lightest section that bends little enough, of a family or of a list? One link, its loads given."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.parts.family import rounded

if TYPE_CHECKING:
    from lostmotion.analyses.sizing.link_deflection import LinkLoads, Worst
    from lostmotion.parts.family import Family
    from lostmotion.parts.joint import Joint
    from lostmotion.parts.link import ElasticLink
    from lostmotion.parts.material import Material
    from lostmotion.parts.section import Plain, Sized
    from lostmotion.spatial import Floats

# A misfit beyond one by no more than this is rounding.
SLACK: Final = 1e-9
# Poses that the search looks at to begin with, the worst by either limit; others join where the section found bends more there.
_ACTIVE: Final = 32
_ROUNDS: Final = 50
# Values of one free size tried before the root is closed in on; of several, so many of each.
_SCAN: Final = 13
_GRID: Final = {2: 8, 3: 5, 4: 4}
_STARTS: Final = 3
_IMPOSSIBLE: Final = 20.0
_LEAST: Final = 1e-300
# Shares of the leading size are chosen in steps of this.
_SHARE_STEP: Final = 1e-3
_AROUND: Final = 2


@dataclass(frozen=True, slots=True)
class Limits:
    """What a link may do: slope in rad, deflection as its length over this number; the paper's condition (4) asks 0.5' and 2500."""

    slope: float
    deflection: float

    def scaled(self, factor: float) -> Limits:
        """Give both limits so many times as wide."""
        return Limits(self.slope * factor, self.deflection / factor)


@dataclass(frozen=True, slots=True)
class Found:
    """The section found, and the larger of slope and deflection over their limits: at most one where it does, else it is the stiffest of its kind."""

    section: Plain
    misfit: float

    @property
    def holds(self) -> bool:
        """Tell whether the limits hold."""
        return self.misfit <= 1 + SLACK


def with_section(joint: Joint, section: Plain, material: Material | None = None) -> Joint:
    """Which joint is this one with another section of its link, all along?

    A mass that was stated for the link stays as far as it is more than its section weighed: what is bolted on. Of a link without a section that is
    all of it, since nobody says how much of it the new section takes the place of.
    """
    link = joint.link
    changed: dict[str, object] = {"section": section, "material": material or link.material, "mass": None}
    changed |= {"compliance": None, "measured": None, "rigid": False}
    out = link.model_copy(update=changed)
    if link.mass is not None:
        own = link.model_copy(update={"mass": None}).total_mass
        out = out.model_copy(update={"mass": out.total_mass + max(link.mass - own, 0.0)})
    return joint.model_copy(update={"link": out})


@dataclass(frozen=True)
class Task:
    """One link to be sized: its joint, everything that acts on it, what it may do, and its material where another is wanted."""

    joint: Joint
    loads: LinkLoads
    limits: Limits
    material: Material | None = None

    def link(self, section: Plain) -> ElasticLink:
        """Give the link with this section."""
        return with_section(self.joint, section, self.material).elastic_link

    def mass(self, section: Plain) -> float:
        """Give what the link weighs with this section, kg."""
        return self.link(section).link.total_mass

    def ratios(self, section: Plain) -> Floats:
        """How much of each limit does a section take (pose, 2): slope, deflection?"""
        return self.taken(self.link(section), self.loads)

    def taken(self, link: ElasticLink, loads: LinkLoads) -> Floats:
        """How much of each limit does a link take (pose, 2) under some loads?"""
        limits = np.array([self.limits.slope, link.link.reach / self.limits.deflection])
        return np.asarray(loads.bent(link) / limits)

    def worst(self, section: Plain) -> Worst:
        """What does the link do at worst with this section?"""
        return self.loads.worst(self.link(section))


def lightest(task: Task, choice: Family | tuple[Plain, ...], step: float = 0.0) -> Found:
    """Which section of a family, or of a list, is the lightest that holds the limits? Where none does: the one that misses them by least.

    Free lengths come in whole steps (m), rounded up; 0: as they come. Of one free size exact: bending is scanned along it, and the root closed in on
    (Brent). Of several, SLSQP from several starts in the logarithms of the sizes, where masses and bending of thin sections are sums of powers and so
    convex; held against brute force in tests. Only the worst poses are looked at on the way, but the section returned is checked at all of them and
    those where it fails join in, which leaves the result that of all poses.
    """
    if isinstance(choice, tuple):
        return _of_list(task, choice)
    seed = choice.section(tuple(math.sqrt(span.low * span.high) for span in choice.spans)) or choice.section(
        tuple(span.high for span in choice.spans)
    )
    if seed is None:
        raise ValueError("a family of no section")
    active = _worst_poses(task.ratios(seed))
    found = Found(seed, math.inf)
    for _ in range(_ROUNDS):
        found = _Search(task, choice, task.loads.at(active), step).found()
        ratios = task.ratios(found.section)
        whole = Found(found.section, float(ratios.max()))
        if whole.misfit <= max(found.misfit, 1.0) + SLACK:
            return whole
        active = np.union1d(active, _worst_poses(ratios))
    return Found(found.section, float(task.ratios(found.section).max()))


def _worst_poses(ratios: Floats) -> np.ndarray:
    return np.unique(np.argsort(-ratios, axis=0, kind="stable")[:_ACTIVE])


def _of_list(task: Task, stock: tuple[Plain, ...]) -> Found:
    """Try a list, the lightest first."""
    least: Found | None = None
    for section in sorted(stock, key=task.mass):
        found = Found(section, float(task.ratios(section).max()))
        if found.holds:
            return found
        least = found if least is None or found.misfit < least.misfit else least
    if least is None:
        raise ValueError("an empty list of sections")
    return least


class _Search:
    """The search in one family, at the active poses."""

    def __init__(self, task: Task, family: Family, loads: LinkLoads, step: float) -> None:
        self.task, self.family, self.loads, self.step = task, family, loads, step
        self.free = family.free
        self.fixed = tuple(span.low for span in family.spans)
        self.ends = [(family.spans[k].low, family.spans[k].high) for k in self.free]
        self.ask = functools.lru_cache(maxsize=20_000)(self._ask)

    def _values(self, free: tuple[float, ...]) -> tuple[float, ...]:
        values = list(self.fixed)
        for k, value in zip(self.free, free, strict=True):
            values[k] = value
        return tuple(values)

    def section(self, free: tuple[float, ...]) -> Sized | None:
        return self.family.section(self._values(free))

    def _ask(self, free: tuple[float, ...]) -> tuple[float, float, float]:
        """Give mass, and the shares taken of the slope's and the deflection's limit; infinite where there is no such section."""
        section = self.section(free)
        if section is None:
            return math.inf, math.inf, math.inf
        link = self.task.link(section)
        slope, deflection = self.task.taken(link, self.loads).max(axis=0)
        return link.link.total_mass, float(slope), float(deflection)

    def misfit(self, free: tuple[float, ...]) -> float:
        return max(self.ask(free)[1:])

    def found(self) -> Found:
        if not self.free:
            chosen: tuple[float, ...] = ()
        elif len(self.free) == 1:
            chosen = self._of_one()
        else:
            chosen = self._of_several()
        section = self.section(chosen)
        if section is None:
            raise ValueError("a family of no section")
        return Found(section, self.misfit(chosen))

    def _of_one(self) -> tuple[float, ...]:
        """Find the smallest value that holds. Bending may rise again beyond some size, where the link's own weight takes over."""
        from scipy.optimize import brentq, minimize_scalar

        low, high = self.ends[0]
        scan = [float(x) for x in np.geomspace(low, high, _SCAN)]
        scan[0], scan[-1] = low, high
        over = [math.log(misfit) if 0 < (misfit := self.misfit((x,))) < math.inf else _sign(misfit) * _IMPOSSIBLE for x in scan]
        first = next((k for k, value in enumerate(over) if value <= 0), None)
        if first is None:
            least = int(np.argmin(over))
            ends = scan[max(least - 1, 0)], scan[min(least + 1, len(scan) - 1)]
            best = minimize_scalar(
                lambda x: min(math.log(self.misfit((float(x),))), _IMPOSSIBLE), bounds=ends, method="bounded", options={"xatol": 1e-9}
            )
            size = float(best.x) if best.fun < over[least] else scan[least]
            if self.misfit((size,)) > 1:
                return self._stiffest(size)
            scan, first = [ends[0], size], 1
        if first == 0:
            return (low,)
        root = float(brentq(lambda x: _clipped(math.log(self.misfit((float(x),)))), scan[first - 1], scan[first], xtol=1e-12, rtol=1e-12))
        nudge = 1e-12
        while self.misfit((root,)) > 1:  # the root's other side, by rounding
            root = min(root * (1 + nudge), scan[first])
            nudge *= 2
        return self._in_steps((root,))

    def _stiffest(self, size: float) -> tuple[float, ...]:
        candidates = [tuple(each) for each in self._near((size,))]
        return min(candidates, key=self.misfit, default=(size,))

    def _of_several(self) -> tuple[float, ...]:
        from scipy.optimize import minimize

        grid = [
            tuple(float(x) for x in point)
            for point in itertools.product(*(np.geomspace(low, high, _GRID[len(self.ends)]) for low, high in self.ends))
        ]
        grid = [self._clip(point) for point in grid]
        holding = sorted((point for point in grid if self.misfit(point) <= 1), key=lambda point: self.ask(point)[0])
        bounds = [(math.log(low), math.log(high)) for low, high in self.ends]
        if not holding:
            start = min(grid, key=self.misfit)
            best = minimize(self._log_misfit, _logs(start), method="L-BFGS-B", bounds=bounds)
            least = min((self._point(best.x), start), key=self.misfit)
            if self.misfit(least) > 1:
                return min([*self._near(least), least], key=self.misfit)
            holding = [least]
        found = list(holding[:1])
        room: Any = [{"type": "ineq", "fun": self._log_room, "args": (which,)} for which in (1, 2)]
        for start in _apart(holding):
            best = minimize(
                self._log_mass,
                _logs(start),
                method="SLSQP",
                bounds=bounds,
                constraints=room,
                options={"maxiter": 60, "ftol": 1e-9},
            )
            found.append(self._mended(self._point(best.x), start))
        return self._in_steps(min(found, key=lambda point: self.ask(point)[0]))

    def _log_mass(self, x: Floats) -> float:
        return _clipped(math.log(max(self.ask(self._point(x))[0], _LEAST)))

    def _log_misfit(self, x: Floats) -> float:
        return _clipped(math.log(max(self.misfit(self._point(x)), _LEAST)))

    def _log_room(self, x: Floats, which: int) -> float:
        return -_clipped(math.log(max(self.ask(self._point(x))[which], _LEAST)))

    def _point(self, x: Floats) -> tuple[float, ...]:
        return self._clip(tuple(float(each) for each in np.exp(x)))

    def _clip(self, point: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(min(max(x, low), high) for x, (low, high) in zip(point, self.ends, strict=True))

    def _mended(self, point: tuple[float, ...], holds: tuple[float, ...]) -> tuple[float, ...]:
        """Go back from a point that misses the limits towards one that holds them, no further than needed."""
        if self.misfit(point) <= 1:
            return point
        near, far = _logs(holds), _logs(point)
        good, bad = 0.0, 1.0
        for _ in range(50):
            share = (good + bad) / 2
            good, bad = (share, bad) if self.misfit(self._point(near + share * (far - near))) <= 1 else (good, share)
        return self._point(near + good * (far - near))

    def _in_steps(self, point: tuple[float, ...]) -> tuple[float, ...]:
        """Round to whole steps: the lightest that holds among those around; the point itself where none around does."""
        if not self.step:
            return point
        holding = [each for each in self._near(point) if self.misfit(each) <= 1]
        return min(holding, key=lambda each: self.ask(each)[0], default=point)

    def _near(self, point: tuple[float, ...]) -> list[tuple[float, ...]]:
        if not self.step:
            return [point]
        axes = []
        for k, value, (low, high) in zip(self.free, point, self.ends, strict=True):
            step = _SHARE_STEP if self.family.spans[k].share else self.step
            around = (rounded(value, step) + n * step for n in range(-_AROUND, _AROUND + 1))
            axes.append(sorted({min(max(rounded(x, step), low), high) for x in around}))
        return list(itertools.product(*axes))


def _apart(points: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """Take the lightest few, and the one in the middle of all."""
    return list(dict.fromkeys([*points[: _STARTS - 1], points[len(points) // 2]]))


def _clipped(value: float) -> float:
    return min(max(value, -_IMPOSSIBLE), _IMPOSSIBLE)


def _logs(point: tuple[float, ...]) -> Floats:
    return np.array([math.log(x) for x in point])


def _sign(value: float) -> float:
    return 1.0 if value > 1 else -1.0
